// How many bytes the clustered frame moves on a GPU, from the plan's own buffers: what every work-group reads
// and writes in sectors of 32 bytes, beside what the frame needs, which is each number once.

#include <gtest/gtest.h>

#include <cstdio>
#include <set>

#include "furrow/frame_plan.h"
#include "runtime/shaders/layout.h"
#include "sheets.h"

namespace furrow::tests {
namespace {

constexpr uint64_t kSector = 32;

std::span<const uint32_t> words(const FramePlan& plan, Buffer id) {
  const std::span<const std::byte> bytes = plan.buffer(id).initial;
  return {reinterpret_cast<const uint32_t*>(bytes.data()), bytes.size() / sizeof(uint32_t)};
}

struct Moved {
  uint64_t sectors = 0;
  void range(uint64_t begin_byte, uint64_t bytes) {
    if (bytes > 0) sectors += (begin_byte + bytes - 1) / kSector - begin_byte / kSector + 1;
  }
};

void expectFewBytes(const AssetView& asset, const char* name) {
  const FramePlan plan(asset, {.normals = false});
  ASSERT_EQ(plan.options().form, Form::kClustered);
  const auto table = words(plan, Buffer::kClusterTable), data = words(plan, Buffer::kClusterData);
  const uint32_t layers = asset.layerCount(), record = gpu::kClusterWords + layers;
  const uint64_t weight_bytes = asset.weightStride() * sizeof(int16_t);
  Moved moved;
  uint64_t coefficient_bytes = 0;
  for (const Layer& layer : asset.layers) coefficient_bytes += 4 * coefficientCount(layer.measure);
  for (uint32_t i = 0; i < plan.items()[0].groups[0]; ++i) {
    const uint32_t* c = &table[size_t{i} * record];
    const uint32_t slots = c[gpu::kClusterSlots], vertices = c[gpu::kClusterVertices],
                   triangles = c[gpu::kClusterTriangles], points = c[gpu::kClusterPoints];
    moved.range(uint64_t{i} * record * 4, record * 4);
    moved.range(4ull * c[gpu::kClusterSlotVertex], 4ull * slots);
    moved.range(4ull * c[gpu::kClusterExtraPoint], 2ull * (vertices - points));
    moved.range(4ull * c[gpu::kClusterCorners], 6ull * triangles);
    const uint32_t chunks = (points + 7) / 8, chunk = c[gpu::kClusterChunks];
    moved.range(4ull * chunk, 4ull * (chunks + 1));
    moved.range(4ull * data[chunk], 4ull * (data[chunk + chunks] - data[chunk]));
    for (uint32_t l = 0; l < layers; ++l)
      if (c[gpu::kClusterCovered] >> l & 1u)
        moved.range(4ull * c[gpu::kClusterWords + l],
                    4ull * triangles * coefficientCount(asset.layers[l].measure) + 2ull * points);
    // Gathers: each sector once a work-group.
    std::set<uint64_t> positions, influences, posed, weights;
    for (uint32_t s = 0; s < slots; ++s) {
      const uint64_t v = data[c[gpu::kClusterSlotVertex] + s], each = 4ull * asset.influences;
      for (uint64_t at = 12 * v / kSector; at <= (12 * v + 11) / kSector; ++at) positions.insert(at);
      for (uint64_t at = each * v / kSector; at <= (each * (v + 1) - 1) / kSector; ++at)
        influences.insert(at);
      if (s >= vertices) continue;
      for (uint64_t at = 12 * v / kSector; at <= (12 * v + 11) / kSector; ++at) posed.insert(at);
      weights.insert(weight_bytes * v / kSector);
    }
    moved.sectors += positions.size() + influences.size() + posed.size() + weights.size();
  }
  const uint64_t needed = asset.vertexCount() * (12ull + 4ull * asset.influences + 12ull + weight_bytes) +
                          asset.triangleCount() * (6ull + coefficient_bytes) +
                          4ull * asset.ring_triangles.size();
  const double triangles = asset.triangleCount();
  std::printf(
      "%s: %u triangles, %u vertices, %u influences: moves %.1f bytes a triangle, needs %.1f, ratio %.2f\n",
      name, asset.triangleCount(), asset.vertexCount(), asset.influences,
      static_cast<double>(moved.sectors * kSector) / triangles, static_cast<double>(needed) / triangles,
      static_cast<double>(moved.sectors * kSector) / static_cast<double>(needed));
  EXPECT_LE(static_cast<double>(moved.sectors * kSector), 1.5 * static_cast<double>(needed));
}

TEST(GpuBytes, AtMostHalfMoreThanTheFrameNeeds) {
  for (uint32_t n : {71u, 221u}) {
    const Asset asset =
        cookAsset(sceneOf(sheet(n), [](glm::dvec3 p) { return glm::dvec3(0.7 * p.x, p.y, 0.2 * p.x * p.y); }),
                  recipeOf({axisLayer({1, 0, 0})}));
    expectFewBytes(asset.view(), "sheet");
  }
}

}  // namespace
}  // namespace furrow::tests
