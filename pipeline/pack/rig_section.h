#pragma once

// The rig as a section of the asset, for the tools that play clips (CBOR).

#include <cstddef>
#include <vector>

#include "furrow/asset.h"
#include "pipeline/scene/rig.h"

namespace furrow::pipeline {

std::vector<std::byte> writeRig(const Rig& rig);

// Throws std::runtime_error where the section is not sound.
Rig readRig(const AssetView& asset);

}  // namespace furrow::pipeline
