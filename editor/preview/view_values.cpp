#include "editor/preview/view_values.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <unordered_map>

namespace furrow::preview {

namespace {

glm::mat3 linear(const Affine& a) {
  return {a.m[0], a.m[4], a.m[8], a.m[1], a.m[5], a.m[9], a.m[2], a.m[6], a.m[10]};
}

glm::vec3 at(const Affine& a, Float3 p) {
  return linear(a) * glm::vec3(p.x, p.y, p.z) + glm::vec3(a.m[3], a.m[7], a.m[11]);
}

glm::vec3 unit(glm::vec3 v) {
  const float length = glm::length(v);
  return length > 0.0f ? v / length : glm::vec3(0.0f);
}

// A well-mixed hash (the finaliser of MurmurHash3).
uint32_t mixed(uint32_t x) {
  x = (x ^ (x >> 16)) * 0x85ebca6bu;
  x = (x ^ (x >> 13)) * 0xc2b2ae35u;
  return x ^ (x >> 16);
}

}  // namespace

std::vector<glm::vec4> pointColors(const AssetView& asset) {
  std::vector<glm::vec4> values(asset.vertexCount());
  for (size_t v = 0; v < values.size(); ++v) {
    const uint32_t hash = mixed(asset.vertex_point[v] + 1u);
    const float hue = static_cast<float>(hash & 0xffffu) / 65536.0f * 6.0f;
    const float light = 0.35f + 0.6f * static_cast<float>(hash >> 16) / 65535.0f;
    const auto ramp = [&](float shift) {
      const float k = std::fmod(hue + shift, 6.0f);
      return light * (1.0f - 0.85f * std::fmin(std::fmax(std::fmin(k, 4.0f - k), 0.0f), 1.0f));
    };
    values[v] = {ramp(5.0f), ramp(3.0f), ramp(1.0f), 1.0f};
  }
  return values;
}

std::vector<glm::vec4> biasValues(const AssetView& asset, uint32_t layer) {
  std::vector<glm::vec4> values(asset.vertexCount(), glm::vec4(0.0f));
  const auto bias = asset.layers[layer].bias;
  for (size_t v = 0; v < bias.size(); ++v) values[v].x = static_cast<float>(bias[v]) / 32767.0f;
  return values;
}

std::vector<glm::vec4> directionValues(const AssetView& asset, uint32_t layer,
                                       std::span<const glm::vec4> painted) {
  std::vector<glm::vec4> values(asset.vertexCount(), glm::vec4(0.0f));
  const auto directions = asset.layers[layer].directions;
  if (directions.empty()) return values;
  for (const Part& part : asset.parts) {
    const glm::mat3 a = linear(part.rest);
    const glm::mat3 cofactors(glm::cross(a[1], a[2]), glm::cross(a[2], a[0]), glm::cross(a[0], a[1]));
    for (uint32_t v = part.vertex_begin; v < part.vertex_end; ++v) {
      const int8_t* d = &directions[size_t{4} * asset.vertex_point[v]];
      const Float3 n = asset.normals[v];
      const Float4 t = asset.tangents[v];
      const glm::vec3 normal = unit(cofactors * glm::vec3(n.x, n.y, n.z));
      const glm::vec3 bent = a * glm::vec3(t.x, t.y, t.z);
      const glm::vec3 tangent = unit(bent - glm::dot(bent, normal) * normal);
      glm::vec3 direction = glm::vec3(d[0], d[1], d[2]) / 127.0f;
      float confidence = static_cast<float>(d[3]) / 127.0f;
      if (!painted.empty() && painted[v].w > 0.0f) {
        confidence = glm::length(glm::vec3(painted[v]));
        direction = unit(glm::vec3(painted[v]));
      }
      values[v] = {confidence, glm::dot(direction, tangent),
                   t.w * glm::dot(direction, glm::cross(normal, tangent)), 0.0f};
    }
  }
  return values;
}

std::vector<glm::vec4> morphValues(const AssetView& asset, std::span<const float> morph_weights) {
  std::vector<glm::vec3> moved(asset.vertexCount(), glm::vec3(0.0f));
  float farthest = 0.0f;
  for (size_t m = 0; m < asset.morphs.size(); ++m) {
    const Morph& morph = asset.morphs[m];
    for (size_t i = 0; i < morph.vertices.size(); ++i) {
      const int32_t* d = &morph.position_deltas[3 * i];
      const glm::vec3 delta = morph.position_step * glm::vec3(d[0], d[1], d[2]);
      farthest = std::max(farthest, glm::length(delta));
      moved[morph.vertices[i]] += morph_weights[m] * delta;
    }
  }
  std::vector<glm::vec4> values(asset.vertexCount(), glm::vec4(0.0f));
  for (size_t v = 0; v < values.size() && farthest > 0.0f; ++v)
    values[v].x = glm::length(moved[v]) / farthest;
  return values;
}

std::vector<uint32_t> strokeVertices(const AssetView& asset, uint32_t layer, float spacing) {
  std::vector<uint32_t> chosen;
  const auto directions = asset.layers[layer].directions;
  if (directions.empty() || !(spacing > 0.0f)) return chosen;

  std::vector<glm::vec3> rest(asset.vertexCount());
  for (const Part& part : asset.parts)
    for (uint32_t v = part.vertex_begin; v < part.vertex_end; ++v)
      rest[v] = at(part.rest, asset.positions[v]);

  // Darts in point order, thrown into a grid whose cells are as wide as the darts keep apart. Cells far from
  // each other may share a key: then a comparison is made in vain.
  std::unordered_map<uint64_t, std::vector<uint32_t>> grid;
  const auto key = [](glm::ivec3 cell) {
    return (static_cast<uint64_t>(static_cast<uint32_t>(cell.x) & 0x1fffffu) << 42) |
           (static_cast<uint64_t>(static_cast<uint32_t>(cell.y) & 0x1fffffu) << 21) |
           (static_cast<uint32_t>(cell.z) & 0x1fffffu);
  };
  constexpr float kFarthestCell = 1e9f;
  for (size_t p = 0; p < asset.point_vertex.size(); ++p) {
    const uint32_t v = asset.point_vertex[p];
    const int8_t* d = &directions[4 * p];
    if (d[0] == 0 && d[1] == 0 && d[2] == 0) continue;
    const glm::ivec3 cell(glm::clamp(glm::floor(rest[v] / spacing), -kFarthestCell, kFarthestCell));
    bool free = true;
    for (int i = 0; i < 27 && free; ++i) {
      const auto near = grid.find(key(cell + glm::ivec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1)));
      if (near == grid.end()) continue;
      for (uint32_t other : near->second) free = free && glm::distance(rest[other], rest[v]) >= spacing;
    }
    if (!free) continue;
    grid[key(cell)].push_back(v);
    chosen.push_back(v);
  }
  return chosen;
}

}  // namespace furrow::preview
