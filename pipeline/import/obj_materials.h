#pragma once

// The material files (.mtl) of OBJ models, as far as previews show them.

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/scene/source_scene.h"

namespace furrow::pipeline {

// The file of that name in one of the folders, written on any system: where the name leads, or right in them.
// What is nowhere is in the first.
std::filesystem::path findFile(std::string_view name, const std::vector<std::filesystem::path>& folders);

struct ObjMaterials {
  std::map<std::string, Material> materials;  // by name, which they do not hold; their images are in `images`
  std::vector<SourceImage> images;            // files that may be missing
  std::vector<std::filesystem::path> files;   // the material files that were read
  std::vector<std::string> warnings;          // of those that cannot be
};

// Adds those of a material file's text. Images are looked for in its folder and in the model's.
void addMaterials(std::string_view text, const std::filesystem::path& file,
                  const std::filesystem::path& model, ObjMaterials& out);

// `libraries`: what stands behind every "mtllib" of the model, one name or several. What is not where names
// lead is looked for beside the model. Throws Error (kEnvironment).
ObjMaterials readObjMaterials(const std::filesystem::path& model, const std::vector<std::string>& libraries);

}  // namespace furrow::pipeline
