#pragma once

// The options that choose a pose, shared by eval and render.

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "editor/cli/open_asset.h"
#include "editor/preview/posed_frame.h"

namespace furrow::cli {

struct PoseOptions {
  std::string clip, take;
  std::optional<double> time;
  std::vector<std::string> morphs, regions;
  std::optional<double> scale;  // none: that of the clip
  std::string backend = "auto";

  void add(CLI::App& command);

  // What can be refused before a file is opened. Throws Error (kBadUsage) for a morph or region that is not
  // NAME=NUMBER and for a FURROW_BACKEND that is no tier.
  void validate() const;
};

// Throws Error (kBadUsage) for a clip, morph target or layer that the asset lacks, naming those it has.
preview::PosedFrame poseFrame(const OpenedAsset& opened, const PoseOptions& options);

}  // namespace furrow::cli
