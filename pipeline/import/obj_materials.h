#pragma once

// The material files (.mtl) of OBJ models, as far as previews show them.

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "pipeline/scene/source_scene.h"

namespace furrow::pipeline {

struct ObjMaterials {
  std::map<std::string, Material> materials;  // by name, which they do not hold; their images are in `images`
  std::vector<SourceImage> images;            // files that may be missing
  std::vector<std::filesystem::path> files;   // the material files that were read
  std::vector<std::string> warnings;          // of those that cannot be
};

// `libraries`: what stands behind every "mtllib" of the model, one name or several. Names may have been
// written on any system; what is not where they lead is looked for beside the model. Throws Error
// (kEnvironment).
ObjMaterials readObjMaterials(const std::filesystem::path& model, const std::vector<std::string>& libraries);

}  // namespace furrow::pipeline
