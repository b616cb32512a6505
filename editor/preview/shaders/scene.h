// The uniform blocks of the preview's shaders, read by C++ and pasted in front of every shader.

#ifdef __cplusplus
#pragma once
#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>
namespace furrow::preview::gpu {
using glm::mat4;
using glm::uvec4;
using glm::vec4;
using uint = uint32_t;
#define FURROW_BLOCK(name) struct name
#define FURROW_INSTANCE(name)
#define FURROW_CONSTANT inline constexpr uint
#else
#define FURROW_BLOCK(name) layout(std140) uniform name
#define FURROW_INSTANCE(name) name
#define FURROW_CONSTANT const uint
#endif

FURROW_CONSTANT kMaxPreviewLayers = 16u;

// The values of renderer.h's Shading and View.
FURROW_CONSTANT kShadingInterpolated = 0u;
FURROW_CONSTANT kShadingBlend = 1u;
FURROW_CONSTANT kShadingAlpha = 2u;
FURROW_CONSTANT kShadingNone = 3u;
FURROW_CONSTANT kViewBeauty = 0u;
FURROW_CONSTANT kViewWeight = 1u;
FURROW_CONSTANT kViewDirection = 2u;
FURROW_CONSTANT kViewPoint = 3u;
FURROW_CONSTANT kViewMask = 4u;
FURROW_CONSTANT kViewBias = 5u;
FURROW_CONSTANT kViewConfidence = 6u;
FURROW_CONSTANT kViewMorph = 7u;

// A picture.
FURROW_BLOCK(Scene) {
  mat4 view_projection;
  mat4 shadow;     // world to shadow map: xy texture coordinates, z depth
  vec4 eye;        // world; w: world units a shadow texel
  vec4 lights[3];  // key, fill, rim: direction to the light; w: radiance
  vec4 up;         // of the camera; w: exposure
  vec4 size;       // picture in pixels; z: stroke length in world units, w: stroke width in pixels
  uint layer;
  uint layers;  // that show
  uint pad0, pad2;
  uvec4 shown_layers[kMaxPreviewLayers / 4u];
}
FURROW_INSTANCE(scene);

// A part.
FURROW_BLOCK(Material) {
  vec4 base_color;
  vec4 color_uv, normal_uv;  // columns from uv to the model's own maps
  vec4 color_at_normal_at;   // where they begin
  uint with_masks;           // 0: Layer::mask of the vertex
  float roughness;
  float opaque_from;
  uint pad1;
  uvec4 slices[kMaxPreviewLayers];       // as furrow_shade.glsl takes them
  vec4 windows[2u * kMaxPreviewLayers];  // a slice of the maps
}
FURROW_INSTANCE(material);

#ifdef __cplusplus
#undef FURROW_BLOCK
#undef FURROW_INSTANCE
#undef FURROW_CONSTANT
static_assert(sizeof(Scene) == 240 + 4 * kMaxPreviewLayers &&
              sizeof(Material) == 80 + 48 * kMaxPreviewLayers);
}  // namespace furrow::preview::gpu
#endif
