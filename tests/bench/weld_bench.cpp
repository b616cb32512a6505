// Places of one and four million vertices on one thread, beside meshoptimizer's remap of the same positions:
// the ratios are what docs/performance.md reports.

#include <benchmark/benchmark.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "pipeline/bake/places.h"

namespace {

// A wavy sheet of 2 x 2 m whose every sixth vertex or so stands twice, as seams and hard edges split it;
// `jitter`: the second one is off by rounding.
std::vector<glm::vec3> vertices(size_t count, bool shuffled, bool jitter) {
  const auto side = static_cast<size_t>(std::ceil(std::sqrt(static_cast<double>(count) * 6.0 / 7.0)));
  std::mt19937 random(1);
  std::vector<glm::vec3> result;
  for (size_t i = 0; result.size() < count; ++i) {
    const float x = 2.0f * static_cast<float>(i % side) / static_cast<float>(side) - 1.0f;
    const float y = 2.0f * static_cast<float>(i / side) / static_cast<float>(side) - 1.0f;
    glm::vec3 p(x, y, 0.1f * std::sin(20.0f * x) * std::cos(17.0f * y));
    result.push_back(p);
    if (random() % 6 != 0) continue;
    if (jitter) p.x = std::nextafter(p.x, 2.0f);
    result.push_back(p);
  }
  result.resize(count);
  if (shuffled) std::shuffle(result.begin(), result.end(), random);
  return result;
}

const std::vector<glm::vec3>& input(const benchmark::State& state, bool jitter = false) {
  static std::map<std::tuple<int64_t, int64_t, bool>, std::vector<glm::vec3>> made;
  auto& found = made[{state.range(0), state.range(1), jitter}];
  if (found.empty()) found = vertices(static_cast<size_t>(state.range(0)), state.range(1) != 0, jitter);
  return found;
}

void meshoptimizerRemap(benchmark::State& state) {
  const auto& positions = input(state);
  std::vector<unsigned int> remap(positions.size());
  for (auto _ : state) {
    state.counters["places"] = static_cast<double>(meshopt_generateVertexRemap(
        remap.data(), nullptr, positions.size(), positions.data(), positions.size(), sizeof(glm::vec3)));
    benchmark::ClobberMemory();
  }
}

void weldExact(benchmark::State& state) {
  const auto& positions = input(state);
  for (auto _ : state) {
    const auto places = furrow::pipeline::findPlaces(positions, 0.0f);
    state.counters["places"] = places->count;
  }
}

void weldWithTolerance(benchmark::State& state) {
  const auto& positions = input(state, true);
  const float tolerance = furrow::pipeline::roundingTolerance(positions, 1.0);
  for (auto _ : state) {
    const auto places = furrow::pipeline::findPlaces(positions, tolerance);
    state.counters["places"] = places->count;
  }
}

void sizes(benchmark::internal::Benchmark* benchmark) {
  benchmark->ArgNames({"vertices", "shuffled"})->Unit(benchmark::kMillisecond);
  for (int64_t count : {1000000, 4000000})
    for (int64_t shuffled : {0, 1}) benchmark->Args({count, shuffled});
}
BENCHMARK(meshoptimizerRemap)->Apply(sizes);
BENCHMARK(weldExact)->Apply(sizes);
BENCHMARK(weldWithTolerance)->Apply(sizes);

}  // namespace
