#include <benchmark/benchmark.h>

#include <random>

#include "furrow/place_hash.h"
#include "pipeline/bake/perfect_hash.h"

namespace {

// Pairwise different: x alone numbers them.
std::vector<glm::vec3> places(size_t count) {
  std::mt19937 random(1);
  std::vector<glm::vec3> result;
  for (size_t i = 0; i < count; ++i)
    result.emplace_back(static_cast<float>(i), static_cast<float>(random() >> 8),
                        static_cast<float>(random() >> 8));
  return result;
}

void buildPlaceHash(benchmark::State& state) {
  auto input = places(static_cast<size_t>(state.range(0)));
  size_t bytes = 0;
  for (auto _ : state) bytes = furrow::pipeline::buildPlaceHash(input).section.size();
  state.SetItemsProcessed(state.iterations() * state.range(0));
  state.counters["bits_a_place"] =
      8.0 * static_cast<double>(bytes) / static_cast<double>(state.range(0)) - 16.0;  // without the checks
}
BENCHMARK(buildPlaceHash)->Arg(10000)->Arg(1000000)->Unit(benchmark::kMillisecond);

void openPlaceHash(benchmark::State& state) {
  auto section = furrow::pipeline::buildPlaceHash(places(static_cast<size_t>(state.range(0)))).section;
  furrow::PlaceHash hash;
  for (auto _ : state) benchmark::DoNotOptimize(hash.open(section).ok());
}
BENCHMARK(openPlaceHash)->Arg(1000000)->Unit(benchmark::kMicrosecond);

void findPlaces(benchmark::State& state) {
  auto input = places(static_cast<size_t>(state.range(0)));
  auto section = furrow::pipeline::buildPlaceHash(input).section;
  furrow::PlaceHash hash;
  if (!hash.open(section).ok()) return state.SkipWithError("the section does not open");
  for (auto _ : state) {
    uint32_t sum = 0;
    for (const auto& p : input) sum += hash.find({p.x, p.y, p.z}).value_or(0);
    benchmark::DoNotOptimize(sum);
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(findPlaces)->Arg(10000)->Arg(1000000)->Unit(benchmark::kMillisecond);

}  // namespace
