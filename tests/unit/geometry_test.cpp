// Draco's way of storing a part against the plain one: the same vertices, told by their place in the source,
// and the same triangles.

#include "pipeline/pack/geometry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/unit/sheets.h"

namespace furrow::pipeline {
namespace {

constexpr size_t kMethod = 8;  // in Draco's header, after name, version and kind
constexpr uint8_t kEdgebreaker = 1;

struct Packed {
  PackedPart part;
  PartGeometry geometry;
};

Packed pack(const Primitive& primitive, GeometryCodec codec) {
  const std::vector<glm::vec3> normals(primitive.positions.size(), {0, 0, 1});
  const std::vector<glm::vec4> tangents(primitive.positions.size(), {1, 0, 0, 1});
  Packed packed;
  packed.part = packGeometry(
      [&] {
        return quantizePart(primitive, normals, tangents, 1,
                            positionStep(primitive.positions, primitive.indices));
      },
      primitive.indices, codec, packed.geometry);
  return packed;
}

using Triangle = std::array<uint32_t, 3>;

// By source vertices, each from its lowest.
std::vector<Triangle> triangles(const PartGeometry& geometry) {
  std::vector<Triangle> out;
  for (size_t i = 0; i < geometry.indices.size(); i += 3) {
    Triangle t;
    for (size_t c = 0; c < 3; ++c) t[c] = geometry.source[geometry.indices[i + c]];
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    out.push_back(t);
  }
  std::sort(out.begin(), out.end());
  return out;
}

void expectTheSame(const Primitive& primitive) {
  const Packed draco = pack(primitive, GeometryCodec::kDraco), raw = pack(primitive, GeometryCodec::kRaw);
  ASSERT_GT(draco.part.draco.size(), kMethod);
  EXPECT_EQ(draco.part.draco[kMethod], kEdgebreaker);
  ASSERT_EQ(draco.geometry.positions.size(), primitive.positions.size());
  for (size_t v = 0; v < primitive.positions.size(); ++v) {
    const uint32_t source = draco.geometry.source[v];
    ASSERT_EQ(raw.geometry.source[source], source);
    ASSERT_EQ(draco.geometry.positions[v].x, raw.geometry.positions[source].x);
    ASSERT_EQ(draco.geometry.positions[v].y, raw.geometry.positions[source].y);
    ASSERT_EQ(draco.geometry.positions[v].z, raw.geometry.positions[source].z);
    ASSERT_EQ(draco.geometry.uvs[v].x, raw.geometry.uvs[source].x);
  }
  std::vector<Triangle> expected = triangles(raw.geometry);
  std::erase_if(expected, [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
  EXPECT_EQ(triangles(draco.geometry), expected);
}

TEST(Geometry, ASheet) {
  expectTheSame(tests::sheet(9));
}

TEST(Geometry, TheStepIsAPowerOfTwoThatFollowsTheShortEdges) {
  for (const float edge : {0.009f, 0.01f, 0.013f, 0.016f}) {
    // A large triangle, and small ones, which are more than one edge in twenty.
    Primitive mesh;
    mesh.positions = {{0, 0, 0}, {100, 0, 0}, {0, 100, 0}};
    for (uint32_t i = 0; i < 8; ++i) {
      const glm::vec3 at(0.0f, 0.0f, static_cast<float>(i));
      mesh.positions.insert(mesh.positions.end(),
                            {at, at + glm::vec3(edge, 0, 0), at + glm::vec3(0, edge, 0)});
    }
    for (uint32_t v = 0; v < mesh.positions.size(); ++v) mesh.indices.push_back(v);
    const float step = positionStep(mesh.positions, mesh.indices);
    EXPECT_LE(step, edge / 64.0f);
    EXPECT_GT(step, edge / 129.0f);
    int exponent = 0;
    EXPECT_EQ(std::frexp(step, &exponent), 0.5f);
  }
  const Primitive sheet = tests::sheet(9);  // whose edges are long: 16 bits across
  EXPECT_LE(positionStep(sheet.positions, sheet.indices), 1.0f / 65535.0f);
}

// A fin stands on every third edge of the sheet, so that these have three triangles.
Primitive fins() {
  Primitive mesh = tests::sheet(9);
  const size_t triangles = mesh.indices.size() / 3;
  for (size_t t = 0; t < triangles; t += 3) {
    const uint32_t a = mesh.indices[3 * t], b = mesh.indices[3 * t + 1];
    const glm::vec3 tip = 0.5f * (mesh.positions[a] + mesh.positions[b]) + glm::vec3(0, 0, 0.1f);
    mesh.indices.insert(mesh.indices.end(), {a, b, static_cast<uint32_t>(mesh.positions.size())});
    mesh.positions.push_back(tip);
    mesh.uvs.push_back({0.5f, 0.5f});
  }
  return mesh;
}

TEST(Geometry, EdgesOfThreeTriangles) {
  expectTheSame(fins());
}

TEST(Geometry, VerticesWithoutATriangle) {
  Primitive mesh = fins();
  for (int i = 0; i < 7; ++i) {  // some at the end, one in the middle, one with a triangle that is none
    mesh.positions.push_back({0.1f * static_cast<float>(i), -0.3f, 0.0f});
    mesh.uvs.push_back({0.1f * static_cast<float>(i), 0.9f});
  }
  const auto last = static_cast<uint32_t>(mesh.positions.size()) - 1;
  for (uint32_t& index : mesh.indices) index = index == 20 ? 21 : index;
  mesh.indices.insert(mesh.indices.end(), {last, last, 3});
  expectTheSame(mesh);
}

TEST(Geometry, PointsAlone) {
  Primitive mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const Packed draco = pack(mesh, GeometryCodec::kDraco);
  EXPECT_EQ(draco.geometry.positions.size(), 3u);
  EXPECT_TRUE(draco.geometry.indices.empty());
}

}  // namespace
}  // namespace furrow::pipeline
