#pragma once

// Region weights from morph weights, so that a rig and the geometry work together [Oat].

#include <span>

#include "furrow/asset.h"

namespace furrow {

// What a driver adds to its layer's region weight while its morph target weighs `weight`.
float drive(const Driver& driver, float weight);

// region_weights[l] = clamp(scripted[l] + what the drivers of layer l add, -1, 1): what FrameInput and
// RespondJob take. `morph_weights` has an entry a morph target, `region_weights` one a layer, `scripted` one
// a layer or none; it may be `region_weights` itself. Neither allocates nor throws.
void driveRegions(const AssetView& asset, std::span<const float> morph_weights,
                  std::span<const float> scripted, std::span<float> region_weights);

}  // namespace furrow
