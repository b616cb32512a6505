#pragma once

// A .furrow asset with the rig that moves it, as the tools need both.

#include <cstddef>
#include <filesystem>
#include <span>

#include "furrow/asset.h"
#include "pipeline/pack/section_bytes.h"
#include "pipeline/scene/rig.h"

namespace furrow::preview {

struct LoadedAsset {
  std::filesystem::path file;  // it, or the source that it was cooked from in memory
  size_t bytes = 0;
  pipeline::SectionBytes sections;  // of `bytes`
  Asset asset;
  pipeline::Rig rig;
};

// By extension or content; false for a file that cannot be read.
bool looksLikeAsset(const std::filesystem::path& file);

// Both throw pipeline::Error: kBadData for a file that is missing or no sound asset, kEnvironment for one
// that cannot be read. `file` names the asset in messages.
LoadedAsset loadAsset(const std::filesystem::path& file);
LoadedAsset loadAsset(const std::filesystem::path& file, std::span<const std::byte> bytes);
LoadedAsset withRig(const std::filesystem::path& file, std::span<const std::byte> bytes,
                    Asset asset);  // loaded from `bytes`

}  // namespace furrow::preview
