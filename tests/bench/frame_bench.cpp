// Frames of the cpu tier on one thread, staged and clustered, beside a bare gather and a copy. The first
// argument is the side of a grid of quads: 222 has 98,568 triangles, 300 has 180,000 and 707 has 999,698.

#include <benchmark/benchmark.h>

#include <Eigen/SparseCore>
#include <cstring>
#include <map>

#include "../unit/sheets.h"
#include "furrow/cluster_frame.h"

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

// The same grid on a chain of 98 joints, four to a vertex.
const Asset& skinnedAsset(int64_t side) {
  static std::map<int64_t, Asset> assets;
  const auto it = assets.find(side);
  if (it != assets.end()) return it->second;
  constexpr uint32_t kJoints = 98;
  pipeline::SourceScene scene =
      tests::sceneOf(tests::sheet(static_cast<uint32_t>(side)), [](glm::dvec3 p) { return p; });
  pipeline::Primitive& primitive = scene.primitives[0];
  primitive.morphs.clear();
  scene.rig.morphs.clear();
  scene.rig.palette.assign(kJoints, {});
  scene.parts[0].skinned = true;
  scene.parts[0].palette_count = kJoints;
  primitive.influences = 4;
  for (const glm::vec3& p : primitive.positions) {
    const auto first = static_cast<uint16_t>(p.x * static_cast<float>(kJoints - 4));
    for (uint16_t k = 0; k < 4; ++k) primitive.joints.push_back(first + k);
    for (float w : {0.4f, 0.3f, 0.2f, 0.1f}) primitive.weights.push_back(w);
  }
  return assets
      .emplace(side, tests::cookAsset(std::move(scene), tests::recipeOf({tests::axisLayer({1, 0, 0})})))
      .first->second;
}

void countTriangles(benchmark::State& state, const AssetView& asset) {
  state.counters["triangles/s"] = benchmark::Counter(static_cast<double>(asset.triangleCount()),
                                                     benchmark::Counter::kIsIterationInvariantRate);
}

// How the cpu tier's frame is computed.
enum Form : int64_t { kStaged, kPortableClusters, kSse4Clusters, kAvx2Clusters, kAvx512Clusters };

// A frame's input and memory, the same for every form. With `posed`, the host has posed it; else a palette
// does, positions only.
void runFrames(benchmark::State& state, const AssetView& asset, std::span<const Float3> posed) {
  std::vector<Affine> palette(asset.palette.size());
  for (size_t i = 0; i < palette.size(); ++i) palette[i].m[3] = 0.01f * static_cast<float>(i);
  const std::vector<float> morph_weights(asset.morphs.size(), 0.0f);
  std::vector<Float3> positions(posed.empty() ? asset.vertexCount() : 0);
  std::vector<float> triangle_q(asset.triangleCount()), q(asset.pointCount());
  std::vector<int16_t> weights(size_t{asset.vertexCount()} * asset.weightStride());
  Clusters clusters;
  if (!clusters.build(asset).ok()) return state.SkipWithError("no clusters");
  std::vector<std::byte> scratch(clusters.scratchBytes());
  ClusterFrameJob job;
  job.clusters = &clusters;
  job.posed = posed.empty() ? nullptr : reinterpret_cast<const std::byte*>(posed.data());
  job.palette = palette;
  job.morph_weights = morph_weights;
  job.positions = positions;
  job.weights = weights;
  if (state.range(1) != kStaged) {
    job.simd = static_cast<Simd>(state.range(1) - 1);
    if (!job.validate().ok()) return state.SkipWithError("not available");
  }
  const std::span<const Float3> measured = posed.empty() ? positions : posed;
  for (auto _ : state) {
    if (state.range(1) == kStaged) {
      if (posed.empty())
        DeformJob{&asset, palette, morph_weights, positions, {}, {}}.run(0, asset.vertexCount());
      CompressJob{&asset, 0, measured, 1.0f, triangle_q}.run(0, asset.triangleCount());
      SmoothJob{&asset, triangle_q, q}.run(0, asset.pointCount());
      RespondJob{&asset, 0, asset.layers[0].response, 0.0f, q, weights}.run(0, asset.vertexCount());
    } else {
      job.run(0, clusters.count(), scratch);
    }
    benchmark::DoNotOptimize(weights.data());
  }
  countTriangles(state, asset);
}

// Four joints a vertex, one layer.
void wholeFrame(benchmark::State& state) {
  runFrames(state, skinnedAsset(state.range(0)).view(), {});
}

// Compress, smooth and respond, one layer.
void fromPosed(benchmark::State& state) {
  const AssetView& asset = gridAsset(state.range(0)).view();
  const tests::Frame posed = tests::evaluate(asset, {1.0f});
  runFrames(state, asset, posed.positions);
}

// What no frame can do without: the ring gather alone, as Eigen's product of a sparse matrix and a vector.
void eigenRings(benchmark::State& state) {
  const AssetView& asset = gridAsset(state.range(0)).view();
  Eigen::SparseMatrix<float, Eigen::RowMajor> rings(asset.pointCount(), asset.triangleCount());
  std::vector<Eigen::Triplet<float>> entries;
  for (uint32_t p = 0; p < asset.pointCount(); ++p)
    for (uint32_t i = asset.ring_offsets[p]; i < asset.ring_offsets[p + 1]; ++i)
      entries.emplace_back(p, asset.ring_triangles[i], static_cast<float>(asset.ring_weights[i]) / 65535.0f);
  rings.setFromTriplets(entries.begin(), entries.end());
  Eigen::VectorXf triangle_q = Eigen::VectorXf::Ones(asset.triangleCount()), q(asset.pointCount());
  for (auto _ : state) {
    q.noalias() = rings * triangle_q;
    benchmark::DoNotOptimize(q.data());
  }
  countTriangles(state, asset);
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

BENCHMARK(eigenRings)->Arg(64)->Arg(222)->Arg(707)->Unit(benchmark::kMicrosecond);
BENCHMARK(fromPosed)
    ->ArgsProduct({{64, 222, 300, 707}, {0, 1, 2, 3, 4}})
    ->ArgNames({"side", "form"})
    ->Unit(benchmark::kMicrosecond);
BENCHMARK(wholeFrame)
    ->ArgsProduct({{222, 707}, {0, 1, 2, 3, 4}})
    ->ArgNames({"side", "form"})
    ->Unit(benchmark::kMicrosecond);
BENCHMARK(copyOfItsBytes)->Arg(300)->Arg(707)->Unit(benchmark::kMicrosecond);

}  // namespace
