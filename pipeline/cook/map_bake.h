#pragma once

// The maps of an asset: texture sets by material, with the wrinkle maps, shading maps and masks of every
// layer.

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "pipeline/cook/layer_bake.h"
#include "pipeline/maps/encode.h"

namespace furrow::pipeline {

// The patterns of synthesised layers, by all that they are made from but the surface, which must outlive
// them.
struct Pattern;
using Patterns = std::map<std::string, std::shared_ptr<const Pattern>>;

struct BakedTextureSet {
  std::string name;
  std::vector<uint32_t> parts;  // of the surface
  EncodedTexture normals, shading, masks;
  std::vector<uint32_t> compress_slice, stretch_slice;  // a layer, kAbsent: none
  std::vector<glm::vec4> windows;                       // a slice, as TextureSet::windows
};

// Fills in what the recipe of a baked layer leaves open about its maps: presets, spacings, depths. All stay
// open in a layer that reaches nowhere.
void resolveMaps(const LayerInput& input, const BakedLayer& layer, LayerRecipe& recipe);

// Sets for the materials that have UVs and that a layer shows on; materials whose charts share one atlas
// without overlapping together. The layers' maps are resolved. `dependencies` gains the images read,
// `warnings` what does not look as it should; patterns in `known` are not made again, and it is left with
// those that were drawn. Throws Error (kBadData) for an image that cannot be used.
std::vector<BakedTextureSet> bakeMaps(const LayerInput& input, const Recipe& recipe,
                                      const std::vector<BakedLayer>& layers, uint32_t threads,
                                      std::vector<std::filesystem::path>& dependencies,
                                      std::vector<std::string>& warnings, Patterns& known);

}  // namespace furrow::pipeline
