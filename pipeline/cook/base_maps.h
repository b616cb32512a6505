#pragma once

// The model's own maps, as an asset keeps them for previews.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "pipeline/maps/encode.h"
#include "pipeline/scene/source_scene.h"

namespace furrow::pipeline {

struct BakedBaseMaps {
  std::string material;  // the first that they are of
  MaterialMaps source;
  EncodedTexture color, normal;  // without slices where there is none
};

struct SceneBaseMaps {
  std::vector<BakedBaseMaps> maps;                  // with one texture at least
  std::vector<uint32_t> of_material;                // index into maps, or kNoIndex
  std::vector<std::string> warnings;                // of images that cannot be read and are left out
  std::vector<std::filesystem::path> dependencies;  // files of images that were read
};

// What images came to, by their bytes and how they are used; kept by whoever cooks a scene again and again.
using EncodedImages = std::map<std::string, EncodedTexture>;

// Of the materials that a part with UVs shows. No side is longer than `longest` texels; 0: no maps. Images
// that are in `known` are not decoded; the others are added.
SceneBaseMaps bakeBaseMaps(const SourceScene& scene, uint32_t longest, uint32_t threads,
                           EncodedImages& known);

}  // namespace furrow::pipeline
