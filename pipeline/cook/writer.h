#pragma once

// The bytes of a .furrow file, the same for any number of threads.

#include <cstddef>
#include <string>
#include <vector>

#include "pipeline/bake/weld.h"
#include "pipeline/cook/base_maps.h"
#include "pipeline/cook/layer_bake.h"
#include "pipeline/cook/map_bake.h"
#include "pipeline/pack/geometry.h"

namespace furrow::pipeline {

struct PackInput {
  const SourceScene& scene;
  const Surface& surface;
  const Weld& weld;
  const Recipe& recipe;
  const std::vector<BakedLayer>& layers;
  const std::vector<BakedTextureSet>& texture_sets;
  const std::vector<BakedBaseMaps>& base_maps;
  const std::vector<PackedPart>& parts;        // by surface part
  const std::vector<uint32_t>& source_vertex;  // of the surface's vertices
  const std::vector<glm::u8vec4>& colors;      // of the surface's vertices, or empty
  const std::vector<std::pair<uint32_t, uint32_t>>&
      place_points;  // a slot of the hash: first point, how many
  uint32_t influences = 1;
  double position_error = 0.0;
  float place_error = 0.0f;
};

std::vector<std::byte> writeAsset(const PackInput& input, uint32_t threads);

}  // namespace furrow::pipeline
