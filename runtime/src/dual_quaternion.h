#pragma once

#include <span>

#include "furrow/skinning.h"

namespace furrow {

// The matrix that moves a vertex, blended from its joints' motions. Quaternions are turned towards the one of
// the vertex's first joint, since q and -q are one rotation.
Affine blendMotions(const AssetView& asset, std::span<const JointMotion> motions, uint32_t vertex);

}  // namespace furrow
