#include "pipeline/bake/weld.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <unordered_map>

#include "pipeline/bake/perfect_hash.h"

namespace furrow::pipeline {
namespace {

constexpr float kSameWeight = 1e-3f;  // exporters round weights to 8 or 16 bits
constexpr float kSameMotion = 1e-6f;  // of the bounding box's diagonal: float noise of a displacement

struct Key {
  uint32_t x, y, z;
  bool operator==(const Key&) const = default;
};
struct KeyHash {
  size_t operator()(const Key& k) const {
    uint64_t h = (uint64_t{k.x} << 32 | k.y) * 0x9e3779b97f4a7c15u;
    h = (h ^ (h >> 29) ^ k.z) * 0xbf58476d1ce4e5b9u;
    return h ^ (h >> 32);
  }
};
Key keyOf(glm::vec3 p) {  // adding zero turns -0 into 0
  return {std::bit_cast<uint32_t>(p.x + 0.0f), std::bit_cast<uint32_t>(p.y + 0.0f),
          std::bit_cast<uint32_t>(p.z + 0.0f)};
}

// What moves a vertex, comparable between parts.
struct Motion {
  std::vector<std::pair<uint32_t, float>> nodes;       // by node, weights summed
  std::vector<std::pair<uint32_t, glm::vec3>> morphs;  // by morph id
};

class Motions {
 public:
  explicit Motions(const SourceScene& scene) : scene_(scene) {
    std::map<std::string, uint32_t> names;
    for (uint32_t m = 0; m < scene.rig.morphs.size(); ++m) {
      const MorphTarget& target = scene.rig.morphs[m];
      morph_id_.push_back(target.name.empty() ? m : names.try_emplace(target.name, m).first->second);
    }
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
      motion.morphs.push_back({morph_id_[part.first_morph + rows.entries[i].first], rows.entries[i].second});
    std::sort(motion.morphs.begin(), motion.morphs.end(),
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

}  // namespace

Weld weld(const SourceScene& scene, const std::vector<glm::vec3>& positions) {
  Weld result;
  std::unordered_map<Key, uint32_t, KeyHash> place_of;
  place_of.reserve(positions.size());
  std::vector<glm::vec3> places;
  glm::vec3 lowest(INFINITY), highest(-INFINITY);
  for (const glm::vec3& p : positions) {
    const auto [it, fresh] = place_of.try_emplace(keyOf(p), static_cast<uint32_t>(places.size()));
    if (fresh) places.push_back(p);
    result.vertex_place.push_back(it->second);
    lowest = glm::min(lowest, p);
    highest = glm::max(highest, p);
  }
  const float same_motion = kSameMotion * glm::length(highest - lowest);

  // Points of each place, as a list through `next_in_place`. Motions matter only where a place has several
  // vertices.
  std::vector<uint32_t> vertices_at(places.size(), 0);
  for (uint32_t place : result.vertex_place) ++vertices_at[place];
  Motions motions(scene);
  std::vector<uint32_t> first_point(places.size(), kNoIndex);
  std::vector<uint32_t> next_in_place;
  std::vector<Motion> motion_of_point;
  result.vertex_point.reserve(positions.size());
  uint32_t vertex = 0;
  for (uint32_t part = 0; part < scene.parts.size(); ++part) {
    const size_t count = scene.primitives[scene.parts[part].primitive].positions.size();
    for (uint32_t v = 0; v < count; ++v, ++vertex) {
      const uint32_t place = result.vertex_place[vertex];
      Motion motion = vertices_at[place] > 1 ? motions.of(part, v) : Motion();
      uint32_t* slot = &first_point[place];
      while (*slot != kNoIndex) {
        const Motion& other = motion_of_point[*slot];
        if (alike(motion.nodes, other.nodes, kSameWeight, [](float w) { return std::abs(w); }) &&
            alike(motion.morphs, other.morphs, same_motion, [](glm::vec3 d) { return glm::length(d); }))
          break;
        slot = &next_in_place[*slot];
      }
      if (*slot == kNoIndex) {
        const auto point = static_cast<uint32_t>(motion_of_point.size());
        *slot = point;
        motion_of_point.push_back(std::move(motion));
        next_in_place.push_back(kNoIndex);
        result.vertex_point.push_back(point);
      } else {
        result.vertex_point.push_back(*slot);
      }
    }
  }
  result.points = static_cast<uint32_t>(motion_of_point.size());
  result.places = static_cast<uint32_t>(places.size());
  BuiltPlaceHash hash = buildPlaceHash(places);
  for (uint32_t& place : result.vertex_place) place = hash.slots[place];
  result.hash = std::move(hash.section);
  return result;
}

}  // namespace furrow::pipeline
