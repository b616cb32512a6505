#include "pipeline/maps/texel_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "pipeline/scene/rig.h"

namespace furrow::pipeline {
namespace {

// One part whose UVs are the given ones; positions are (u, v, 0).
Surface surfaceOf(std::vector<glm::vec2> uvs, std::vector<glm::uvec3> triangles) {
  Surface surface;
  SurfacePart part;
  part.vertex_end = static_cast<uint32_t>(uvs.size());
  part.triangle_end = static_cast<uint32_t>(triangles.size());
  part.has_uvs = true;
  surface.parts = {part};
  for (const glm::vec2& uv : uvs) {
    surface.positions.emplace_back(uv, 0.0f);
  }
  surface.uvs = std::move(uvs);
  surface.triangles = std::move(triangles);
  return surface;
}

glm::vec2 uvAt(const Surface& surface, const TexelMap& map, size_t texel) {
  const glm::uvec3 t = surface.triangles[map.triangle[texel]];
  const glm::vec2 b = map.barycentric[texel];
  return surface.uvs[t.x] * (1.0f - b.x - b.y) + surface.uvs[t.y] * b.x + surface.uvs[t.z] * b.y;
}

glm::vec2 centreOf(uint32_t x, uint32_t y, uint32_t size) {
  return (glm::vec2(static_cast<float>(x), static_cast<float>(y)) + 0.5f) / static_cast<float>(size);
}

const std::vector<uint32_t> kFirst = {0};

TEST(TexelMap, FullSquareIsCoveredByItsCentres) {
  const Surface surface = surfaceOf({{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {{0, 1, 2}, {0, 2, 3}});
  const TexelMap map = mapTexels(surface, chartsOf(surface, kFirst), {16, 16}, 0);
  for (uint32_t y = 0; y < 16; ++y) {
    for (uint32_t x = 0; x < 16; ++x) {
      ASSERT_NE(map.triangle[y * 16 + x], kNoIndex);
      EXPECT_LT(glm::distance(uvAt(surface, map, y * 16 + x), centreOf(x, y, 16)), 1e-6f);
    }
  }
}

// Against brute force: a texel is covered if its centre is within the margin, and has the nearest point then.
TEST(TexelMap, DilatesToTheNearestPointOfTheChart) {
  const Surface surface =
      surfaceOf({{0.31f, 0.29f}, {0.72f, 0.35f}, {0.55f, 0.70f}, {0.28f, 0.52f}}, {{0, 1, 2}, {0, 2, 3}});
  const uint32_t size = 32;
  for (const uint32_t margin : {0u, 1u, 4u}) {
    const TexelMap map = mapTexels(surface, chartsOf(surface, kFirst), {size, size}, margin);
    for (uint32_t y = 0; y < size; ++y) {
      for (uint32_t x = 0; x < size; ++x) {
        const glm::vec2 centre = centreOf(x, y, size);
        float nearest = 1e9f;
        for (const glm::uvec3& t : surface.triangles) {
          for (int i = 0; i <= 200; ++i) {
            for (int j = 0; i + j <= 200; ++j) {
              const float b1 = static_cast<float>(i) / 200.0f, b2 = static_cast<float>(j) / 200.0f;
              const glm::vec2 p =
                  surface.uvs[t.x] * (1 - b1 - b2) + surface.uvs[t.y] * b1 + surface.uvs[t.z] * b2;
              nearest = std::min(nearest, glm::distance(p, centre) * static_cast<float>(size));
            }
          }
        }
        const bool covered = map.triangle[y * size + x] != kNoIndex;
        const float reach = std::max(static_cast<float>(margin), 0.7072f);
        if (nearest < reach - 0.1f) {
          ASSERT_TRUE(covered) << x << ' ' << y;
          EXPECT_LE(glm::distance(uvAt(surface, map, y * size + x), centre) * static_cast<float>(size),
                    nearest + 1e-3f);
        } else if (nearest > reach + 0.1f) {
          ASSERT_FALSE(covered) << x << ' ' << y;
        }
      }
    }
  }
}

TEST(TexelMap, ChartsSmallerThanATexelAreCovered) {
  const Surface surface = surfaceOf({{0.51f, 0.51f}, {0.52f, 0.51f}, {0.51f, 0.52f}}, {{0, 1, 2}});
  const TexelMap map = mapTexels(surface, chartsOf(surface, kFirst), {8, 8}, 0);
  EXPECT_EQ(map.triangle[4 * 8 + 4], 0u);
  const Surface line = surfaceOf({{0.1f, 0.1f}, {0.9f, 0.1f}, {0.5f, 0.1f}}, {{0, 1, 2}});
  EXPECT_EQ(mapTexels(line, chartsOf(line, kFirst), {8, 8}, 0).triangle[4], 0u);
}

// As when every face of a mesh shows the whole image; a thousand times as long as one would take for ever.
TEST(TexelMap, UvsSharedByThousandsOfTrianglesShowTheFirst) {
  const std::vector<glm::vec2> square = {{0, 0}, {1, 0}, {1, 1}, {0, 1}}, half = {{0, 0}, {1, 0}, {0, 1}};
  std::vector<glm::vec2> uvs;
  std::vector<glm::uvec3> triangles;
  for (uint32_t face = 0; face < 2000; ++face)
    for (const auto& shape : {square, half}) {
      const auto first = static_cast<uint32_t>(uvs.size());
      uvs.insert(uvs.end(), shape.begin(), shape.end());
      triangles.emplace_back(first, first + 1, first + 2);
      if (shape.size() == 4) triangles.emplace_back(first, first + 2, first + 3);
    }
  const Surface surface = surfaceOf(uvs, triangles);
  const TexelMap map = mapTexels(surface, chartsOf(surface, kFirst), {1024, 1024}, 8);
  for (const uint32_t triangle : map.triangle) ASSERT_LT(triangle, 2u);
  const Surface halves = surfaceOf({{0, 0}, {1, 0}, {0, 1}, {0, 0}, {1, 0}, {0, 1}}, {{0, 1, 2}, {3, 4, 5}});
  for (const uint32_t triangle : mapTexels(halves, chartsOf(halves, kFirst), {64, 64}, 2).triangle)
    ASSERT_TRUE(triangle == 0 || triangle == kNoIndex);
}

TEST(TexelMap, UvsRepeat) {
  const Surface home = surfaceOf({{0.25f, 0.25f}, {0.75f, 0.25f}, {0.25f, 0.75f}}, {{0, 1, 2}});
  Surface away = home;
  for (glm::vec2& uv : away.uvs) {
    uv += glm::vec2(-3.0f, 5.0f);
  }
  EXPECT_EQ(mapTexels(home, chartsOf(home, kFirst), {64, 64}, 2).triangle,
            mapTexels(away, chartsOf(away, kFirst), {64, 64}, 2).triangle);

  // Across the border of the tile, and a triangle of a million tiles, which must not take a million times as
  // long.
  const Surface across = surfaceOf({{0.9f, 0.4f}, {1.1f, 0.4f}, {1.1f, 0.6f}}, {{0, 1, 2}});
  const TexelMap map = mapTexels(across, chartsOf(across, kFirst), {32, 32}, 0);
  EXPECT_EQ(map.triangle[14 * 32 + 1], 0u);
  // Margins reach across it too, to every side.
  const Surface corner = surfaceOf({{0.0f, 0.0f}, {0.1f, 0.0f}, {0.0f, 0.1f}}, {{0, 1, 2}});
  const TexelMap around = mapTexels(corner, chartsOf(corner, kFirst), {32, 32}, 2);
  for (const size_t texel : {31 * 32 + 31, 0 * 32 + 31, 31 * 32 + 0, 0 * 32 + 0})
    EXPECT_EQ(around.triangle[texel], 0u) << texel;
  const Surface huge = surfaceOf({{0, 0}, {1e6f, 0}, {0, 1e6f}}, {{0, 1, 2}});
  EXPECT_EQ(mapTexels(huge, chartsOf(huge, kFirst), {32, 32}, 8).triangle[100], 0u);
}

TEST(TexelMap, BadUvsAreLeftOut) {
  const Surface surface = surfaceOf({{NAN, 0}, {1, 0}, {0, INFINITY}}, {{0, 1, 2}});
  for (const uint32_t t : mapTexels(surface, chartsOf(surface, kFirst), {8, 8}, 2).triangle) {
    EXPECT_EQ(t, kNoIndex);
  }
}

// Measured in such a window, the triangle lies further out than integers count.
TEST(TexelMap, AWindowMayBeTiny) {
  const Surface surface = surfaceOf({{0, 0}, {0.1f, 0}, {0, 0.1f}}, {{0, 1, 2}});
  for (const uint32_t t :
       mapTexels(surface, chartsOf(surface, kFirst), {8, 8, {0.5, 0.5}, {1e-20, 1e-20}}, 2).triangle) {
    EXPECT_EQ(t, kNoIndex);
  }
}

// A window of 20 x 12 texels across both borders of the unit square shows what a map of the whole shows
// there.
TEST(TexelMap, AWindowIsAPartOfTheWhole) {
  const Surface surface =
      surfaceOf({{0.8f, -0.3f}, {1.15f, 0.1f}, {0.95f, 0.15f}, {0.4f, 0.5f}, {0.6f, 0.5f}, {0.5f, 0.9f}},
                {{0, 1, 2}, {3, 4, 5}});
  const TexelMap whole = mapTexels(surface, chartsOf(surface, kFirst), {64, 64}, 3);
  const TexelMap window = mapTexels(surface, chartsOf(surface, kFirst),
                                    {20, 12, {54.0 / 64.0, 58.0 / 64.0}, {20.0 / 64.0, 12.0 / 64.0}}, 3);
  size_t covered = 0;
  for (uint32_t y = 0; y < 12; ++y) {
    for (uint32_t x = 0; x < 20; ++x) {
      const size_t here = y * 20 + x, there = (y + 58) % 64 * 64 + (x + 54) % 64;
      ASSERT_EQ(window.triangle[here], whole.triangle[there]) << x << ' ' << y;
      if (window.triangle[here] != kNoIndex) {
        ++covered;
        EXPECT_LT(glm::distance(window.barycentric[here], whole.barycentric[there]), 1e-5f);
      }
    }
  }
  EXPECT_GT(covered, 50u);
  EXPECT_LT(covered, 20u * 12u);
}

// The two halves of a face that share one half of the texture: their common edge is the chart's border.
TEST(TexelMap, ChartsFoldedOntoEachOtherEndAtTheFold) {
  const Surface surface =
      surfaceOf({{0.5f, 0.25f}, {0.5f, 0.75f}, {0.25f, 0.5f}, {0.25f, 0.5f}}, {{0, 1, 2}, {1, 0, 3}});
  const TexelMap map = mapTexels(surface, chartsOf(surface, kFirst), {32, 32}, 3);
  EXPECT_EQ(map.triangle[16 * 32 + 14], 0u);  // the lowest index has the overlap
  EXPECT_NE(map.triangle[16 * 32 + 18], kNoIndex);
  EXPECT_EQ(map.triangle[16 * 32 + 20], kNoIndex);
}

}  // namespace
}  // namespace furrow::pipeline
