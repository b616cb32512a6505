#pragma once

// Many cooks in one file. Manifests are JSON; docs/manifest.schema.json is their published schema,
// docs/build_step.md explains them.

#include <filesystem>
#include <vector>

#include "pipeline/cook/cook_cache.h"

namespace furrow::pipeline {

struct ManifestAsset {
  CookRequest request;
  std::filesystem::path output;
};

// In the manifest's order; paths come out behind the folder of `file` as it is given. Throws Error (kBadData)
// as readRecipe() does, and where an asset has neither source nor sequence, or its output is that of another
// or an input of any. Whether the inputs exist is not looked at.
std::vector<ManifestAsset> readManifest(const std::filesystem::path& file);

// The same of a text that is in memory, as if it stood in `file`.
std::vector<ManifestAsset> parseManifest(const std::string& text, const std::filesystem::path& file);

}  // namespace furrow::pipeline
