#include "pipeline/bake/tangents.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "pipeline/bake/index_table.h"
#include "runtime/src/near_cells.h"

namespace furrow::pipeline {
namespace {

struct Frame {
  glm::dvec3 tangent{0.0};
  double angle = 0.0;
};

// Zero if it is too short to have a direction.
glm::dvec3 unit(const glm::dvec3& v) {
  const double length = glm::length(v);
  return length > std::numeric_limits<float>::min() ? v / length : glm::dvec3(0.0);
}

glm::dvec3 inPlane(const glm::dvec3& v, const glm::dvec3& normal) {
  return unit(v - normal * glm::dot(normal, v));
}

glm::dvec3 anyTangent(const glm::dvec3& normal) {
  const glm::dvec3 axis = std::abs(normal.x) < 0.7 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 tangent = inPlane(axis, normal);
  return tangent == glm::dvec3(0.0) ? axis : tangent;
}

// For each vertex the first one that agrees with it in position, normal and UV.
std::vector<uint32_t> mergeEqual(std::span<const glm::vec3> positions, std::span<const glm::vec3> normals,
                                 std::span<const glm::vec2> uvs) {
  const auto bits = [](float x) { return uint64_t{std::bit_cast<uint32_t>(x + 0.0f)}; };  // 0 is -0
  const auto hashOf = [&](size_t v) {
    const glm::vec3 p = positions[v], n = normals[v];
    return hashOfThree(hashOfThree(bits(p.x), bits(p.y), bits(p.z)), bits(n.x) | bits(n.y) << 32,
                       hashOfThree(bits(n.z), bits(uvs[v].x), bits(uvs[v].y)));
  };
  IndexTable table(positions.size());
  std::vector<uint32_t> first(positions.size());
  std::array<uint64_t, IndexTable::kBlock> hashes{};
  for (size_t begin = 0; begin < first.size(); begin += hashes.size()) {
    const size_t count = std::min(hashes.size(), first.size() - begin);
    for (size_t i = 0; i < count; ++i) table.prefetch(hashes[i] = hashOf(begin + i));
    for (size_t i = 0; i < count; ++i) {
      const size_t v = begin + i;
      uint32_t* entry = table.find(hashes[i], [&](uint32_t other) {
        return positions[other] == positions[v] && normals[other] == normals[v] && uvs[other] == uvs[v];
      });
      if (*entry == IndexTable::kFree) *entry = table.entryOf(hashes[i], v);
      first[v] = table.indexOf(*entry);
    }
  }
  return first;
}

}  // namespace

std::vector<glm::vec4> tangents(std::span<const glm::vec3> positions, std::span<const glm::vec3> normals,
                                std::span<const glm::vec2> uvs, std::span<const glm::uvec3> triangles) {
  std::vector<std::array<Frame, 2>> frames(positions.size());  // unmirrored, mirrored
  std::vector<uint32_t> first(positions.size());
  if (!uvs.empty()) {
    first = mergeEqual(positions, normals, uvs);
    for (const glm::uvec3& triangle : triangles) {
      const std::array<glm::dvec3, 3> p = {positions[triangle[0]], positions[triangle[1]],
                                           positions[triangle[2]]};
      const glm::dvec2 uv0 = uvs[triangle[0]];
      const glm::dvec2 e1 = glm::dvec2(uvs[triangle[1]]) - uv0, e2 = glm::dvec2(uvs[triangle[2]]) - uv0;
      const double area = e1.x * e2.y - e1.y * e2.x;
      if (!(std::abs(area) > std::numeric_limits<float>::min())) {
        continue;
      }
      const glm::dvec3 along_u = unit(((p[1] - p[0]) * e2.y - (p[2] - p[0]) * e1.y) / area);
      const size_t mirrored = area > 0.0 ? 1 : 0;  // v runs down
      for (int c = 0; c < 3; ++c) {
        const glm::dvec3 normal = normals[triangle[c]];
        const glm::dvec3 to_next = inPlane(p[(c + 1) % 3] - p[c], normal);
        const glm::dvec3 to_last = inPlane(p[(c + 2) % 3] - p[c], normal);
        const double angle = std::acos(std::clamp(glm::dot(to_next, to_last), -1.0, 1.0));
        const glm::dvec3 tangent = inPlane(along_u, normal);
        if (tangent == glm::dvec3(0.0) || to_next == glm::dvec3(0.0) || to_last == glm::dvec3(0.0)) {
          continue;
        }
        Frame& frame = frames[first[triangle[c]]][mirrored];
        frame.tangent += angle * tangent;
        frame.angle += angle;
      }
    }
  }

  std::vector<glm::vec4> result(positions.size());
  for (size_t v = 0; v < positions.size(); ++v) {
    const auto& sides = frames[first[v]];
    const bool mirrored = sides[1].angle > sides[0].angle;
    const glm::dvec3 normal = normals[v];
    glm::dvec3 tangent = inPlane(sides[mirrored ? 1 : 0].tangent, normal);
    const bool known = tangent != glm::dvec3(0.0);
    if (!known) {
      tangent = anyTangent(normal);
    }
    result[v] = glm::vec4(glm::vec3(tangent), known && mirrored ? -1.0f : 1.0f);
  }
  return result;
}

}  // namespace furrow::pipeline
