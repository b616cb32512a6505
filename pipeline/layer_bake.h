#pragma once

// What one layer of a recipe comes to on a surface.

#include <set>
#include <vector>

#include "pipeline/bake/squeeze.h"
#include "pipeline/bake/surface.h"
#include "pipeline/recipe.h"
#include "pipeline/scene/source_scene.h"

namespace furrow::pipeline {

struct BakedLayer {
  LayerField field;                 // direction, confidence and mask, a point
  std::vector<bool> covered;        // a triangle
  std::vector<float> coefficients;  // the layer's measure
  std::vector<float> bias;          // a point; empty: none
  double unsure = 0.0;              // share of the area under its mask where confidence is low
};

struct LayerInput {
  const SourceScene& scene;
  const Surface& surface;
  const std::vector<uint32_t>& source_vertex;
  const Squeeze& squeeze;
  std::string recipe_file;  // for messages
};

// Throws Error (kBadData): a mesh, material, attribute or lines that the scene lacks, a mask that is empty,
// guide curves off the surface, an image that cannot be used. `dependencies` gains the images read.
BakedLayer bakeLayer(const LayerInput& input, const LayerRecipe& recipe,
                     std::vector<std::filesystem::path>& dependencies);

}  // namespace furrow::pipeline
