#pragma once

// What stands where a command says ASSET: a .furrow file, or a source that is cooked in memory first.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "editor/preview/loaded_asset.h"
#include "pipeline/cook/cook.h"
#include "pipeline/import/sequence.h"

namespace furrow::cli {

struct OpenedAsset : preview::LoadedAsset {
  bool cooked_here = false;
  std::vector<std::string> warnings;  // of the cook, if there was one
};

struct AssetOptions {
  std::string file, recipe;

  void add(CLI::App& command, const char* name = "ASSET");

  // Throws Error (kBadUsage) for a recipe of what is cooked already.
  OpenedAsset open() const;
};

// Cooks a source (the base alone if the sequence has no pattern) with a recipe (empty path: the default one);
// prints stages on a terminal unless quiet.
pipeline::Cooked cookFile(const pipeline::Sequence& source, const std::filesystem::path& recipe,
                          pipeline::CookOptions options, bool quiet);

// One a line, as they are printed.
std::string warningLines(const std::filesystem::path& source, const std::vector<std::string>& warnings);

// On stderr. The last thing a command does: a fault stands alone.
void printWarnings(const std::filesystem::path& source, const std::vector<std::string>& warnings);

}  // namespace furrow::cli
