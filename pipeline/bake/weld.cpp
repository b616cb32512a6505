#include "pipeline/bake/weld.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <map>
#include <string>

#include "pipeline/bake/perfect_hash.h"
#include "pipeline/bake/places.h"
#include "pipeline/pack/geometry.h"
#include "pipeline/scene/rest.h"

namespace furrow::pipeline {
namespace {

constexpr float kSameWeight = 1.0f / 255.0f;  // exporters round weights to 8 bits and more

// What moves a vertex, comparable between parts.
struct Motion {
  std::vector<std::pair<uint32_t, float>> nodes;       // by node, weights summed
  std::vector<std::pair<uint32_t, glm::vec3>> morphs;  // by morph id, in root space
};

class Motions {
 public:
  explicit Motions(const SourceScene& scene) : scene_(scene) {
    std::map<std::string, uint32_t> names;
    for (uint32_t m = 0; m < scene.rig.morphs.size(); ++m) {
      const MorphTarget& target = scene.rig.morphs[m];
      morph_id_.push_back(target.name.empty() ? m : names.try_emplace(target.name, m).first->second);
    }
    for (const glm::dmat4& bind : bindMatrices(scene)) to_root_.emplace_back(bind);
    rows_.resize(scene.primitives.size());
  }

  Motion of(uint32_t part_index, uint32_t vertex) {
    const Part& part = scene_.parts[part_index];
    const Primitive& primitive = scene_.primitives[part.primitive];
    Motion motion;
    if (!part.skinned) {
      motion.nodes.push_back({part.node, 1.0f});
    } else {
      std::map<uint32_t, float> by_node;
      for (uint32_t k = 0; k < primitive.influences; ++k) {
        const size_t i = size_t{vertex} * primitive.influences + k;
        if (primitive.weights[i] > 0.0f)
          by_node[scene_.rig.palette[part.palette_begin + primitive.joints[i]].node] += primitive.weights[i];
      }
      motion.nodes.assign(by_node.begin(), by_node.end());
    }
    const auto& rows = morphRows(part.primitive);
    for (uint32_t i = rows.offsets[vertex]; i < rows.offsets[vertex + 1]; ++i)
      motion.morphs.push_back({morph_id_[part.first_morph + rows.entries[i].first],
                               to_root_[part_index] * rows.entries[i].second});
    std::stable_sort(motion.morphs.begin(), motion.morphs.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    return motion;
  }

 private:
  struct Rows {
    std::vector<uint32_t> offsets;
    std::vector<std::pair<uint32_t, glm::vec3>> entries;  // morph of the primitive, displacement
  };

  const Rows& morphRows(uint32_t index) {
    Rows& rows = rows_[index];
    if (!rows.offsets.empty()) return rows;
    const Primitive& primitive = scene_.primitives[index];
    rows.offsets.assign(primitive.positions.size() + 1, 0);
    for (const MorphDelta& delta : primitive.morphs)
      for (uint32_t v : delta.vertices) ++rows.offsets[v + 1];
    for (size_t v = 0; v < primitive.positions.size(); ++v) rows.offsets[v + 1] += rows.offsets[v];
    rows.entries.resize(rows.offsets.back());
    std::vector<uint32_t> next(rows.offsets.begin(), rows.offsets.end() - 1);
    for (uint32_t m = 0; m < primitive.morphs.size(); ++m)
      for (size_t i = 0; i < primitive.morphs[m].vertices.size(); ++i)
        rows.entries[next[primitive.morphs[m].vertices[i]]++] = {m, primitive.morphs[m].positions[i]};
    return rows;
  }

  const SourceScene& scene_;
  std::vector<uint32_t> morph_id_;
  std::vector<glm::mat3> to_root_;  // a part
  std::vector<Rows> rows_;
};

// Both lists ascend by id; an id that one lacks counts as zero there.
template <typename Value, typename Size>
bool alike(const std::vector<std::pair<uint32_t, Value>>& a, const std::vector<std::pair<uint32_t, Value>>& b,
           float tolerance, Size size) {
  size_t i = 0, j = 0;
  while (i < a.size() || j < b.size()) {
    const bool only_a = j == b.size() || (i < a.size() && a[i].first < b[j].first);
    const bool only_b = i == a.size() || (j < b.size() && b[j].first < a[i].first);
    const float difference = only_a   ? size(a[i].second)
                             : only_b ? size(b[j].second)
                                      : size(a[i].second - b[j].second);
    if (!(difference <= tolerance)) return false;
    i += !only_b;
    j += !only_a;
  }
  return true;
}

// Length that one edge in twenty is shorter than, in the part that has the shortest.
double shortestEdges(const SourceScene& scene, std::span<const glm::vec3> positions) {
  double shortest = INFINITY;
  for (const Part& part : scene.parts) {
    const Primitive& primitive = scene.primitives[part.primitive];
    const double length = shortEdge(positions.first(primitive.positions.size()), primitive.indices);
    if (length > 0.0) shortest = std::min(shortest, length);
    positions = positions.subspan(primitive.positions.size());
  }
  return shortest;
}

}  // namespace

std::vector<glm::vec3> sourcePositions(const SourceScene& scene) {
  std::vector<glm::vec3> out;
  const std::vector<glm::dmat4> bind = bindMatrices(scene);
  for (size_t i = 0; i < scene.parts.size(); ++i) {
    Affine rest;
    std::ranges::copy(affineRows(bind[i]), rest.m);
    for (const glm::vec3& p : scene.primitives[scene.parts[i].primitive].positions) {
      const Float3 placed = transformed(rest, {p.x, p.y, p.z});
      out.emplace_back(placed.x, placed.y, placed.z);
    }
  }
  requireInRange(scene, out);
  return out;
}

std::optional<Weld> weld(const SourceScene& scene, std::optional<double> tolerance,
                         std::span<const glm::dvec3> rest_offsets) {
  const std::vector<glm::vec3> positions = sourcePositions(scene);
  const float rounding = roundingTolerance(positions, shortestEdges(scene, positions));
  Weld result;
  result.tolerance = tolerance ? static_cast<float>(*tolerance) : rounding;
  std::optional<Places> places = findPlaces(positions, result.tolerance);
  if (!places && !tolerance) {  // far more vertices than edges tell of, in a heap
    result.tolerance = 0.0f;
    places = findPlaces(positions, 0.0f);
  }
  if (!places) return std::nullopt;
  result.places = places->count;
  result.vertex_place.reserve(positions.size());
  for (uint32_t position : places->vertex_position)
    result.vertex_place.push_back(places->position_place[position]);
  const float same_motion = std::max(result.tolerance, rounding);

  // Motions matter only where a place has several vertices: there, points are a list.
  struct Shared {
    uint32_t point, next;
    Motion motion;
  };
  std::vector<uint32_t> vertices_at(result.places, 0);
  for (uint32_t place : result.vertex_place) ++vertices_at[place];
  Motions motions(scene);
  std::vector<uint32_t> first_shared(result.places, kNoIndex);
  std::vector<Shared> shared;
  result.vertex_point.reserve(positions.size());
  uint32_t vertex = 0;
  for (uint32_t part = 0; part < scene.parts.size(); ++part) {
    const size_t count = scene.primitives[scene.parts[part].primitive].positions.size();
    for (uint32_t v = 0; v < count; ++v, ++vertex) {
      const uint32_t place = result.vertex_place[vertex];
      if (vertices_at[place] == 1) {
        result.vertex_point.push_back(result.points++);
        continue;
      }
      Motion motion = motions.of(part, v);
      if (!rest_offsets.empty()) motion.morphs.push_back({kNoIndex, glm::vec3(rest_offsets[vertex])});
      uint32_t* slot = &first_shared[place];
      while (*slot != kNoIndex) {
        const Motion& other = shared[*slot].motion;
        if (alike(motion.nodes, other.nodes, kSameWeight, [](float w) { return std::abs(w); }) &&
            alike(motion.morphs, other.morphs, same_motion, [](glm::vec3 d) { return glm::length(d); }))
          break;
        slot = &shared[*slot].next;
      }
      if (*slot == kNoIndex) {
        *slot = static_cast<uint32_t>(shared.size());
        shared.push_back({result.points, kNoIndex, std::move(motion)});
        result.vertex_point.push_back(result.points++);
      } else {
        result.vertex_point.push_back(shared[*slot].point);
      }
    }
  }
  BuiltPlaceHash hash = buildPlaceHash(places->positions);
  result.hash = std::move(hash.section);
  result.slot_place.resize(places->positions.size());
  for (size_t i = 0; i < hash.slots.size(); ++i) result.slot_place[hash.slots[i]] = places->position_place[i];
  return result;
}

}  // namespace furrow::pipeline
