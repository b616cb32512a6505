#pragma once

// The preview's shader programs, which know nothing of an asset.

#include <map>
#include <tuple>

#include "editor/preview/gl_objects.h"
#include "editor/preview/renderer.h"

namespace furrow::preview {

// Texture units of the surface's samplers.
inline constexpr int kNormalMaps = 0, kShadingMaps = 1, kMaskMaps = 2, kShadowMap = 3, kBaseColorMap = 4,
                     kBaseNormalMap = 5, kPaintedMask = 6;

// Attribute slots of surface_vertex.glsl; the other programs take kPosition to kTangent as it does.
inline constexpr uint32_t kPosition = 0, kNormal = 1, kTangent = 2, kUv = 3, kWeights = 4, kMasks = 8,
                          kValue = 12;

class Programs {
 public:
  Programs();

  const GlObject background, stroke;

  // What draws the shadow of a part whose colour map has holes or not; made when it is first asked for.
  // Changes the current program.
  uint32_t shadow(bool holes);

  // What draws a part that has wrinkle maps or not, maps of its own or not, and a painted mask or not; made
  // when it is first asked for. Changes the current program.
  uint32_t surface(const RenderOptions& options, bool maps, bool base_color, bool base_normal, bool painted);

 private:
  GlObject shadow_[2];
  std::map<std::tuple<View, Shading, Lighting, bool, bool, bool, bool>, GlObject> surface_;
};

}  // namespace furrow::preview
