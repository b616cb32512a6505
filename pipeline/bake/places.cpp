#include "pipeline/bake/places.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>

#include "pipeline/bake/index_table.h"
#include "runtime/src/near_cells.h"

namespace furrow::pipeline {
namespace {

constexpr uint32_t kNone = IndexTable::kFree;
constexpr size_t kBlock = IndexTable::kBlock;
constexpr double kCellTolerances = 32;  // edge of a cell: most balls then lie in one
constexpr uint64_t kMostTests = 1000;   // a vertex

uint64_t hashOf(const glm::vec3& p) {  // adding zero turns -0 into 0
  return hashOfThree(std::bit_cast<uint32_t>(p.x + 0.0f), std::bit_cast<uint32_t>(p.y + 0.0f),
                     std::bit_cast<uint32_t>(p.z + 0.0f));
}

constexpr auto kAny = [](uint32_t) { return true; };

Places findExact(std::span<const glm::vec3> vertices) {
  IndexTable table(vertices.size());
  Places places;
  places.vertex_position.resize(vertices.size());
  places.positions.reserve(vertices.size());
  std::array<uint64_t, kBlock> hashes;
  for (size_t begin = 0; begin < vertices.size(); begin += kBlock) {
    const size_t count = std::min(kBlock, vertices.size() - begin);
    for (size_t i = 0; i < count; ++i) table.prefetch(hashes[i] = hashOf(vertices[begin + i]));
    for (size_t i = 0; i < count; ++i)
      if (const uint32_t entry = *table.find(hashes[i], kAny); entry != kNone)
        __builtin_prefetch(&places.positions[table.indexOf(entry)]);
    for (size_t i = 0; i < count; ++i) {
      const glm::vec3& p = vertices[begin + i];
      uint32_t* entry = table.find(hashes[i], [&](uint32_t index) { return places.positions[index] == p; });
      if (*entry == kNone) {
        *entry = table.entryOf(hashes[i], places.positions.size());
        places.positions.push_back(p);
      }
      places.vertex_position[begin + i] = table.indexOf(*entry);
    }
  }
  places.count = static_cast<uint32_t>(places.positions.size());
  places.position_place.resize(places.count);
  std::iota(places.position_place.begin(), places.position_place.end(), 0);
  return places;
}

// Positions by the cell they lie in, as lists that a table leads to. Cells whose hashes agree in slot and tag
// share a list, which is rare and costs tests alone. A position that is new looks for earlier ones in every
// cell within reach.
class NearSearch {
 public:
  NearSearch(std::span<const glm::vec3> vertices, float tolerance)
      : vertices_(vertices),
        tolerance_(tolerance),
        cells_(tolerance_, kCellTolerances * tolerance_),
        table_(vertices.size()) {}

  std::optional<Places> run() {
    places_.vertex_position.resize(vertices_.size());
    places_.positions.reserve(vertices_.size());
    nodes_.reserve(vertices_.size());
    std::array<NearCells::Hashes, kBlock> near;
    for (size_t begin = 0; begin < vertices_.size(); begin += kBlock) {
      const size_t count = std::min(kBlock, vertices_.size() - begin);
      for (size_t i = 0; i < count; ++i) {
        const glm::vec3& p = vertices_[begin + i];
        near[i] = cells_.around(p.x, p.y, p.z);
        for (uint32_t c = 0; c < near[i].count; ++c) table_.prefetch(near[i].cells[c]);
      }
      for (size_t i = 0; i < count; ++i)
        if (const uint32_t entry = *table_.find(near[i].cells[0], kAny); entry != kNone) {
          __builtin_prefetch(&places_.positions[table_.indexOf(entry)]);
          __builtin_prefetch(&nodes_[table_.indexOf(entry)]);
        }
      for (size_t i = 0; i < count; ++i)
        places_.vertex_position[begin + i] = positionOf(vertices_[begin + i], near[i]);
      if (tests_ > kMostTests * (begin + 1000)) return std::nullopt;
    }
    number();
    return std::move(places_);
  }

 private:
  uint32_t positionOf(const glm::vec3& p, const NearCells::Hashes& near) {
    uint32_t* own = table_.find(near.cells[0], kAny);
    const uint32_t first = *own == kNone ? kNone : table_.indexOf(*own);
    for (uint32_t i = first; i != kNone; i = nodes_[i].next, ++tests_)
      if (places_.positions[i] == p) return i;
    const auto index = static_cast<uint32_t>(places_.positions.size());
    nodes_.push_back({first, index});
    uniteNear(first, p, index);
    for (uint32_t c = 1; c < near.count; ++c)
      if (const uint32_t entry = *table_.find(near.cells[c], kAny); entry != kNone)
        uniteNear(table_.indexOf(entry), p, index);
    places_.positions.push_back(p);
    *own = table_.entryOf(near.cells[0], index);
    return index;
  }

  void uniteNear(uint32_t first, const glm::vec3& p, uint32_t index) {
    for (uint32_t i = first; i != kNone; i = nodes_[i].next, ++tests_)
      if (within(places_.positions[i], p)) unite(i, index);
  }

  bool within(const glm::vec3& a, const glm::vec3& b) const {
    const double x = double{a.x} - b.x, y = double{a.y} - b.y, z = double{a.z} - b.z;
    return x * x + y * y + z * z <= tolerance_ * tolerance_;
  }

  uint32_t root(uint32_t i) {
    while (nodes_[i].parent != i) i = nodes_[i].parent = nodes_[nodes_[i].parent].parent;
    return i;
  }

  void unite(uint32_t a, uint32_t b) {
    a = root(a);
    b = root(b);
    nodes_[std::max(a, b)].parent = std::min(a, b);
  }

  void number() {
    places_.position_place.reserve(nodes_.size());
    for (uint32_t i = 0; i < nodes_.size(); ++i) {  // a parent comes before and has its number already
      const uint32_t parent = nodes_[i].parent;
      places_.position_place.push_back(parent == i ? places_.count++ : places_.position_place[parent]);
    }
  }

  struct Node {
    uint32_t next;    // position in the same cell
    uint32_t parent;  // an earlier position of the same place, or itself
  };

  std::span<const glm::vec3> vertices_;
  double tolerance_;
  NearCells cells_;
  IndexTable table_;         // to the last position of a cell
  std::vector<Node> nodes_;  // a position
  Places places_;
  uint64_t tests_ = 0;
};

}  // namespace

std::optional<Places> findPlaces(std::span<const glm::vec3> positions, float tolerance) {
  if (tolerance > 0.0f) return NearSearch(positions, tolerance).run();
  return findExact(positions);
}

float roundingTolerance(std::span<const glm::vec3> positions, double short_edge) {
  float largest = 0.0f;
  for (const glm::vec3& p : positions)
    largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  return static_cast<float>(std::min(8.0 * 0x1p-23 * largest, short_edge / 16.0));
}

}  // namespace furrow::pipeline
