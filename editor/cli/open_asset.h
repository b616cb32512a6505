#pragma once

// What stands where a command says ASSET: a .furrow file, or a source that is cooked in memory first.

#include <filesystem>
#include <vector>

#include "furrow/asset.h"
#include "pipeline/cook.h"
#include "pipeline/import/sequence.h"
#include "pipeline/scene/rig.h"

namespace furrow::cli {

struct OpenedAsset {
  std::filesystem::path file;
  size_t bytes = 0;
  bool cooked_here = false;
  Asset asset;
  pipeline::Rig rig;
};

OpenedAsset openAsset(const std::filesystem::path& file);

// Cooks a source (the base alone if the sequence has no pattern) with a recipe (empty path: the default one);
// prints stages on a terminal and warnings on stderr, unless quiet.
pipeline::Cooked cookFile(const pipeline::Sequence& source, const std::filesystem::path& recipe,
                          pipeline::CookOptions options, bool quiet);

}  // namespace furrow::cli
