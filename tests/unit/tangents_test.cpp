#include "pipeline/bake/tangents.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

namespace furrow::pipeline {
namespace {

struct Mesh {
  std::vector<glm::vec3> positions, normals;
  std::vector<glm::vec2> uvs;
  std::vector<glm::uvec3> triangles;

  std::vector<glm::vec4> run() const { return tangents(positions, normals, uvs, triangles); }
};

// In the plane z = 0, seen from +z; u runs along +x, v down (-y), as an image lies on it.
Mesh quad() {
  return {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
          {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}},
          {{0, 1}, {1, 1}, {1, 0}, {0, 0}},
          {{0, 1, 2}, {0, 2, 3}}};
}

void expectNear(const glm::vec4& a, const glm::vec4& b) {
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(a[i], b[i], 1e-6f) << i;
  }
}

TEST(Tangents, BitangentRunsTowardsTheTopOfTheImage) {
  for (const glm::vec4& t : quad().run()) {
    expectNear(t, {1, 0, 0, 1});  // cross(z, x) = +y, where v falls
  }
}

TEST(Tangents, MirroredChartsHaveTheOtherSign) {
  Mesh mesh = quad();
  for (glm::vec2& uv : mesh.uvs) {
    uv.x = -uv.x;
  }
  for (const glm::vec4& t : mesh.run()) {
    expectNear(t, {-1, 0, 0, -1});
  }
}

// Two charts meet along an edge whose vertices agree in all but their UVs.
TEST(Tangents, DoNotMixOverASeam) {
  Mesh mesh = quad(), right = quad();
  for (size_t v = 0; v < 4; ++v) {
    mesh.positions.push_back(right.positions[v] + glm::vec3(1, 0, 0));
    mesh.normals.push_back(right.normals[v]);
    mesh.uvs.push_back({2.0f + right.uvs[v].y, right.uvs[v].x});  // a quarter turn
  }
  for (const glm::uvec3& t : right.triangles) mesh.triangles.push_back(t + 4u);
  const std::vector<glm::vec4> found = mesh.run();
  for (size_t v = 0; v < 4; ++v) {
    expectNear(found[v], {1, 0, 0, 1});
    EXPECT_NEAR(found[v + 4].y, -1.0f, 1e-6f) << v;
  }
}

TEST(Tangents, FollowShearedUvs) {
  Mesh mesh = quad();
  for (glm::vec2& uv : mesh.uvs) {
    uv = {uv.x + 2.0f * uv.y, uv.y};  // lines of constant v still run along x
  }
  for (const glm::vec4& t : mesh.run()) {
    expectNear(t, {1, 0, 0, 1});
  }
}

TEST(Tangents, AreUnitAndOrthogonalToSmoothNormals) {
  Mesh mesh = quad();
  mesh.normals = {glm::normalize(glm::vec3(-1, 0.2, 1)), glm::normalize(glm::vec3(1, 0, 1)),
                  glm::normalize(glm::vec3(1, 2, 1)), glm::normalize(glm::vec3(0, 1, 1))};
  const auto result = mesh.run();
  for (size_t v = 0; v < 4; ++v) {
    EXPECT_NEAR(glm::length(glm::vec3(result[v])), 1.0f, 1e-6f);
    EXPECT_NEAR(glm::dot(glm::vec3(result[v]), mesh.normals[v]), 0.0f, 1e-6f);
    EXPECT_GT(result[v].x, 0.0f);
  }
}

// Two triangles meet at vertex 0 with u along x and along y, at angles of 60 and 30 degrees.
TEST(Tangents, AreWeightedByAngle) {
  const float s = std::sqrt(3.0f) / 2.0f;
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0.5f, s, 0}, {0, 0, 0}, {0.5f, s, 0}, {0, 1, 0}};
  mesh.normals.assign(6, {0, 0, 1});
  mesh.uvs = {{0, 0}, {1, 0}, {0.5f, -s}, {0, 0}, {s, 0.5f}, {1, 0}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  const glm::vec2 expected = glm::normalize(glm::vec2(60.0f, 30.0f));
  const auto result = mesh.run();
  for (const size_t v : {0u, 3u}) {  // equal vertices count as one, and both get its frame
    EXPECT_NEAR(result[v].x, expected.x, 1e-6f);
    EXPECT_NEAR(result[v].y, expected.y, 1e-6f);
  }
  expectNear(result[1], {1, 0, 0, 1});
}

TEST(Tangents, AnUnindexedMeshEqualsTheIndexedOne) {
  Mesh mesh = quad();
  mesh.normals = {glm::normalize(glm::vec3(-1, 0.2, 1)), glm::normalize(glm::vec3(1, 0, 1)),
                  glm::normalize(glm::vec3(1, 2, 1)), glm::normalize(glm::vec3(0, 1, 1))};
  mesh.uvs[2] = {0.7f, 0.2f};
  Mesh soup;
  for (const glm::uvec3& t : mesh.triangles) {
    for (int c = 0; c < 3; ++c) {
      soup.positions.push_back(mesh.positions[t[c]]);
      soup.normals.push_back(mesh.normals[t[c]]);
      soup.uvs.push_back(mesh.uvs[t[c]]);
    }
  }
  soup.triangles = {{0, 1, 2}, {3, 4, 5}};
  const auto a = mesh.run(), b = soup.run();
  for (uint32_t t = 0; t < 2; ++t) {
    for (int c = 0; c < 3; ++c) {
      expectNear(a[mesh.triangles[t][c]], b[soup.triangles[t][c]]);
    }
  }
}

TEST(Tangents, WithoutUsableUvsAreOrthogonalAllTheSame) {
  Mesh none = quad(), point = quad(), line = quad();
  none.uvs.clear();
  point.uvs.assign(4, {0.25f, 0.25f});
  for (glm::vec2& uv : line.uvs) {
    uv.y = 2.0f * uv.x;
  }
  for (Mesh* mesh : {&none, &point, &line}) {
    mesh->normals[1] = {1, 0, 0};
    const auto result = mesh->run();
    ASSERT_EQ(result.size(), 4u);
    for (size_t v = 0; v < 4; ++v) {
      EXPECT_NEAR(glm::length(glm::vec3(result[v])), 1.0f, 1e-6f);
      EXPECT_NEAR(glm::dot(glm::vec3(result[v]), mesh->normals[v]), 0.0f, 1e-6f);
      EXPECT_EQ(result[v].w, 1.0f);
    }
  }
  EXPECT_TRUE(Mesh{}.run().empty());
}

TEST(Tangents, DegenerateTrianglesHaveNoSay) {
  Mesh mesh = quad();
  mesh.triangles.push_back({0, 0, 2});
  mesh.triangles.push_back({1, 1, 1});
  for (const glm::vec4& t : mesh.run()) {
    expectNear(t, {1, 0, 0, 1});
  }
}

}  // namespace
}  // namespace furrow::pipeline
