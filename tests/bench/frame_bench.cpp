// The staged frame of the cpu tier on one thread: compress, smooth and respond from posed positions, one
// layer.

#include <benchmark/benchmark.h>

#include <cstring>
#include <map>

#include "../unit/sheets.h"

namespace {

using namespace furrow;

const Asset& gridAsset(int64_t side) {
  static std::map<int64_t, Asset> assets;
  auto it = assets.find(side);
  if (it == assets.end())
    it = assets
             .emplace(side, tests::cookAsset(tests::sceneOf(tests::sheet(static_cast<uint32_t>(side)),
                                                            [](glm::dvec3 p) {
                                                              return glm::dvec3(0.8 * p.x, p.y,
                                                                                0.1 * p.x * p.y);
                                                            }),
                                             tests::recipeOf({tests::axisLayer({1, 0, 0})})))
             .first;
  return it->second;
}

void staged(benchmark::State& state) {
  const AssetView& asset = gridAsset(state.range(0)).view();
  const tests::Frame posed = tests::evaluate(asset, {1.0f});
  std::vector<float> triangle_q(asset.triangleCount()), q(asset.pointCount());
  std::vector<int16_t> weights(size_t{asset.vertexCount()} * asset.weightStride());
  for (auto _ : state) {
    CompressJob{&asset, 0, posed.positions, 1.0f, triangle_q}.run(0, asset.triangleCount());
    SmoothJob{&asset, triangle_q, q}.run(0, asset.pointCount());
    RespondJob{&asset, 0, asset.layers[0].response, 0.0f, q, weights}.run(0, asset.vertexCount());
    benchmark::DoNotOptimize(weights.data());
  }
  state.counters["triangles/s"] = benchmark::Counter(static_cast<double>(asset.triangleCount()),
                                                     benchmark::Counter::kIsIterationInvariantRate);
}

// The bytes that the staged frame must read and write, copied once: the ratio to it is what
// docs/performance.md reports.
void copyOfItsBytes(benchmark::State& state) {
  const AssetView& asset = gridAsset(state.range(0)).view();
  const size_t bytes = asset.positions.size_bytes() + asset.surface_indices.size_bytes() +
                       asset.layers[0].coefficients.size_bytes() + asset.ring_offsets.size_bytes() +
                       asset.ring_triangles.size_bytes() + asset.ring_weights.size_bytes() +
                       asset.vertex_point.size_bytes() + asset.triangleCount() * 2 * sizeof(float) +
                       asset.pointCount() * 2 * sizeof(float) + asset.vertexCount() * 4;
  std::vector<char> from(bytes / 2, 1), to(bytes / 2);
  for (auto _ : state) {
    std::memcpy(to.data(), from.data(), from.size());
    benchmark::DoNotOptimize(to.data());
    benchmark::ClobberMemory();
  }
  state.counters["bytes"] = static_cast<double>(bytes);
}

BENCHMARK(staged)->Arg(300)->Arg(707)->Unit(benchmark::kMicrosecond);
BENCHMARK(copyOfItsBytes)->Arg(300)->Arg(707)->Unit(benchmark::kMicrosecond);

}  // namespace
