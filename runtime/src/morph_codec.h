#pragma once

// Displacements of morph targets as the file holds them: integers, of which only the difference to a
// prediction from the mesh is stored. The pipeline encodes with the same predictor.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "furrow/status.h"

namespace furrow {

namespace format {
struct Stream;
}

using Int3 = std::array<int32_t, 3>;

inline constexpr uint32_t kPositionDeltaBits = 24, kNormalDeltaBits = 8;

// Foretells a vertex of any field on the surface from vertices with lower numbers: the mean of two
// parallelograms a + b - c over neighbouring triangles; of vertices that are one point, the first one's
// value.
class MorphPredictor {
 public:
  // `indices`: 3 a triangle, < surface_vertex.size(); `surface_vertex`: a vertex, the first one of its point.
  MorphPredictor(std::span<const uint32_t> indices, std::span<const uint32_t> surface_vertex);

  // Twice the prediction for component c. `field` has an element a vertex.
  template <typename T>
  T twice(const std::vector<std::array<T, 3>>& field, uint32_t vertex, size_t c) const {
    const Parents& p = parents_[vertex];
    if (p[0] == kNone) return T(0);
    return (field[p[0]][c] + field[p[1]][c] - field[p[2]][c]) +
           (field[p[3]][c] + field[p[4]][c] - field[p[5]][c]);
  }
  int32_t predict(const std::vector<Int3>& field, uint32_t vertex, size_t c) const {
    return twice(field, vertex, c) >> 1;
  }

  // A lower neighbour of the vertex; the vertex itself where it has none.
  uint32_t neighbour(uint32_t vertex) const {
    return parents_[vertex][0] == kNone ? vertex : parents_[vertex][0];
  }

 private:
  using Parents = std::array<uint32_t, 6>;
  static constexpr uint32_t kNone = 0xffffffffu;

  std::vector<Parents> parents_;
};

// The value's lowest `bits`, as a signed number: sums of predictions and differences are meant modulo 2^bits.
inline int32_t wrapped(int32_t value, uint32_t bits) {
  return static_cast<int32_t>(static_cast<uint32_t>(value) << (32 - bits)) >> (32 - bits);
}

// The vertices that a target moves, from runs of two words: how many to skip, how many to take (not 0).
Status decodeRuns(const format::Stream* runs, size_t vertex_count, std::vector<uint32_t>& vertices);

// Three integers of `bits` bits for each of `vertices` (ascending). A stream's elements are 1 to 3 groups of
// 4 bytes, by rising significance: x, y, z, 0 of the differences, whose digits to base 256 lie in [-128,
// 127], summed up over the elements modulo 256, so that the codec's own differences give them back. `field`
// is scratch, zero for every vertex before and after.
Status decodeDeltas(const format::Stream* stream, uint32_t bits, const MorphPredictor& predictor,
                    std::span<const uint32_t> vertices, std::vector<Int3>& field, std::vector<Int3>& out);

}  // namespace furrow
