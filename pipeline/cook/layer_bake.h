#pragma once

// What one layer of a recipe comes to on a surface.

#include <cstddef>
#include <set>
#include <vector>

#include "pipeline/bake/squeeze.h"
#include "pipeline/bake/surface.h"
#include "pipeline/maps/masks.h"
#include "pipeline/recipe/recipe.h"
#include "pipeline/scene/source_scene.h"

namespace furrow::pipeline {

struct BakedLayer {
  LayerField field;                   // direction, confidence and mask, a point
  std::vector<bool> covered;          // a triangle
  std::vector<uint32_t> parts;        // of the surface, that it covers
  std::optional<glm::vec3> axis;      // unit: the direction is this one, projected
  std::vector<std::byte> directions;  // as the asset holds them; empty for a layer without measure
  std::vector<float> coefficients;    // as the loader works them out
  std::vector<float> bias;            // a point; empty: none
  double unsure = 0.0;                // share of the area under its mask where confidence is low
};

struct LayerInput {
  const SourceScene& scene;
  const Surface& surface;
  const std::vector<uint32_t>& source_vertex;
  const Squeeze& squeeze;
  const MaskImages& masks;  // and biases, of all layers that name one
  const Images& images;     // that stand in for files of directions
  std::string recipe_file;  // for messages
};

// Throws Error (kBadData): a mesh, material, attribute or lines that the scene lacks, a mask that is none
// (checkMask()) or is empty or constant on the layer's meshes, guide curves off the surface, an image of
// directions that cannot be used. `dependencies` gains the images of directions.
BakedLayer bakeLayer(const LayerInput& input, const LayerRecipe& recipe,
                     std::vector<std::filesystem::path>& dependencies);

// All that the baked layer depends on but the scene, its surface and its squeeze; empty where it reads a file
// of directions.
std::string layerKey(const LayerInput& input, const LayerRecipe& recipe);

// Per point, the largest squeeze of its triangles; 0 where none was measured.
std::vector<float> pointPeaks(const Surface& surface, const Squeeze& squeeze);

}  // namespace furrow::pipeline
