#pragma once

// Morph targets as the file holds them: sparse, quantised, predicted from the mesh.

#include <cstdint>
#include <vector>

#include "morph_codec.h"
#include "pipeline/bake/surface.h"
#include "pipeline/scene/source_scene.h"

namespace furrow::pipeline {

struct PackedMorph {
  uint32_t vertices = 0;       // that move
  std::vector<uint32_t> runs;  // two words a run: vertices to skip, vertices that move
  float position_step = 0.0f, normal_step = 0.0f;
  uint32_t position_stride = 4;             // bytes a vertex
  std::vector<uint8_t> positions, normals;  // as furrow::decodeDeltas reads them; normals may be empty
  double error = 0.0;                       // largest |stored - source| at weight 1, in root space at rest
};

// The step of a target is at most 1/64 of the short edges where it moves something, at rest and posed alike
// (the 5th percentile; an edge that it squeezes to less than 1/8 counts as 1/8, where alpha ends) and 2^-15
// of the largest side of the parts that it moves, as far as 24 bits allow; and finer where that costs little:
// a displacement that the mesh foretells, as a stretch or a rotation of the whole, is kept to 24 bits.
// Normals have 8 bits of the largest change.
class MorphPacker {
 public:
  // `scene` holds the positions that `surface` was made from; `source_vertex` maps surface vertices to source
  // order.
  MorphPacker(const SourceScene& scene, const Surface& surface, const std::vector<uint32_t>& source_vertex);

  PackedMorph pack(uint32_t morph);

 private:
  using Float3Field = std::vector<std::array<float, 3>>;

  void gather(uint32_t morph);
  double positionStep() const;
  void measureError(PackedMorph& packed, const std::vector<Int3>& values) const;
  uint32_t encode(const std::vector<Int3>& values, uint32_t bits, std::vector<uint8_t>& out);

  const SourceScene& scene_;
  const Surface& surface_;
  std::vector<uint32_t> asset_vertex_;  // of a source vertex
  std::vector<glm::vec3> rest_;         // in part space
  MorphPredictor predictor_;
  // Of the target at hand: what moves, ascending, and by how much; zero elsewhere.
  std::vector<uint32_t> moved_;
  float across_ = 0.0f;  // largest side, at rest, of the parts that it moves
  Float3Field displacement_, bend_;
  std::vector<Int3> field_;
};

}  // namespace furrow::pipeline
