#pragma once

// What the views of the preview show, a value a vertex.

#include <glm/vec4.hpp>
#include <span>
#include <vector>

#include "furrow/asset.h"

namespace furrow::preview {

// kPoint: a colour (linear) by point. Interpolated, points that are wrongly apart or wrongly welded stand
// out.
std::vector<glm::vec4> pointColors(const AssetView& asset);

// kBias: x the bias in [-1, 1].
std::vector<glm::vec4> biasValues(const AssetView& asset, uint32_t layer);

// kDirection and kConfidence: x confidence in [0, 1]; y, z the wrinkle direction along the vertex's tangent
// and bitangent.
std::vector<glm::vec4> directionValues(const AssetView& asset, uint32_t layer,
                                       std::span<const glm::vec4> painted = {});

// kMorph: x how far the morph targets move the vertex, in [0, 1] of the farthest that one of them moves any
// vertex at weight 1.
std::vector<glm::vec4> morphValues(const AssetView& asset, std::span<const float> morph_weights);

// Vertices at least `spacing` apart at rest (root space) among those whose point has a direction, chosen
// evenly.
std::vector<uint32_t> strokeVertices(const AssetView& asset, uint32_t layer, float spacing);

}  // namespace furrow::preview
