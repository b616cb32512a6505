#pragma once

// FROZEN: what the clustered frame is measured against. A straightforward staged frame in fp32: skin,
// measure, gather and respond, three loops with whole arrays between them. It must not be made faster or
// slower; it has its own copy of all it needs.

#include <cstdint>
#include <vector>

#include "furrow/asset.h"

namespace furrow::bench {

// Of an asset with four influences and one directional layer without bias.
class StagedReference {
 public:
  explicit StagedReference(const AssetView& asset);

  // Items: vertices, triangles, points; each loop needs the whole of the one before.
  void skin(const std::vector<Affine>& palette, uint32_t begin, uint32_t end);
  void measure(uint32_t begin, uint32_t end);
  void gather(uint32_t begin, uint32_t end);

  uint32_t vertices() const { return static_cast<uint32_t>(rest_.size()); }
  uint32_t triangles() const { return static_cast<uint32_t>(triangle_q_.size()); }
  uint32_t points() const { return static_cast<uint32_t>(ring_offsets_.size() - 1); }
  const std::vector<int16_t>& weights() const { return weights_; }  // a point

  // Bytes that a frame reads and writes.
  uint64_t bytes() const;

 private:
  std::vector<Float3> rest_, posed_;
  std::vector<uint16_t> joints_, joint_weights_;  // 4 a vertex
  std::vector<uint32_t> corners_;                 // 3 a triangle
  std::vector<float> coefficients_;               // 2 a triangle
  std::vector<float> triangle_q_;
  std::vector<uint32_t> ring_offsets_, ring_triangles_;
  std::vector<float> ring_weights_;  // sum to 1
  std::vector<int16_t> weights_;
  float beta_;
};

}  // namespace furrow::bench
