#pragma once

// The options that choose a pose, shared by eval and render.

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "editor/cli/open_asset.h"
#include "editor/preview/headless_context.h"
#include "editor/preview/posed_frame.h"
#include "furrow/gl/tier.h"

namespace furrow::cli {

struct PoseOptions {
  std::string clip, take;
  std::optional<double> time;
  std::vector<std::string> morphs, regions;
  double scale = 1.0;
  std::string backend = "auto";

  void add(CLI::App& command);

  // What can be refused before a file is opened. Throws Error (kBadUsage) for a morph or region that is not
  // NAME=NUMBER and for a FURROW_BACKEND that is no tier.
  void validate() const;
};

// Throws Error (kBadUsage) for a clip, morph target or layer that the asset lacks, naming those it has.
preview::PosedFrame poseFrame(const OpenedAsset& opened, const PoseOptions& options);

// The tier of --backend or FURROW_BACKEND; kUnavailable for a forced one that is missing, for which the
// second form throws Error (kEnvironment). `context` is made where the tier may need one. Throws Error
// (kBadUsage) for a FURROW_BACKEND that is no tier.
Status chooseTier(const std::string& backend, std::unique_ptr<preview::HeadlessContext>& context,
                  gl::TierChoice& choice);
gl::TierChoice chooseTier(const std::string& backend, std::unique_ptr<preview::HeadlessContext>& context);

// Says on stderr where auto came to less than the gpu tier.
void printTier(const std::string& backend, const gl::TierChoice& choice);

}  // namespace furrow::cli
