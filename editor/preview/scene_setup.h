#pragma once

// What a picture shows, whoever draws it: camera and lights as the shaders take them, and values by vertex.

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "editor/preview/renderer.h"
#include "editor/preview/shaders/scene.h"

namespace furrow::preview {

inline constexpr uint32_t kShadowSize = 2048;  // texels of the key light's shadow map
inline constexpr float kStrokeLength = 0.9f;   // of their spacing

// Throws pipeline::Error (kBadUsage) for an option or an input that does not fit the asset.
void checkPicture(const AssetView& asset, const FrameInput& input, const RenderOptions& options);

// Of the light, so that a bright subject is not burnt out. Looks at every vertex.
float exposureOf(const AssetView& asset);

// Without the layers that show.
gpu::Scene sceneOf(const RenderOptions& options, float exposure);

// The colour a part is drawn in, linear, times those of its vertices. White says that nobody gave it one: it
// becomes clay.
glm::vec4 shownColor(const AssetView& asset, const Part& part);

// A vertex's own colour, linear, as the shader takes it: near enough to sRGB.
glm::vec3 vertexColor(const AssetView& asset, uint32_t v);

// The values of the view, see view_values.h; empty for one that has none.
std::vector<glm::vec4> shownValues(const AssetView& asset, const FrameInput& input,
                                   const RenderOptions& options);

}  // namespace furrow::preview
