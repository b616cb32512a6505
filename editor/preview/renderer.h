#pragma once

// The preview renderer: one asset, one pose, one picture. Needs a current OpenGL 3.3 core context
// (headless_context.h or a window), 4.3 for the gpu tier; the destructor needs it too.

#include <memory>
#include <span>

#include "editor/preview/camera.h"
#include "editor/preview/stage_times.h"
#include "furrow/frame_plan.h"
#include "furrow/gl/tier.h"
#include "pipeline/maps/image.h"

namespace furrow::preview {

using gl::Tier;
enum class Shading : uint8_t {
  kInterpolated,
  kBlend,
  kAlpha,
  kNone
};                                               // Larsson's three methods, and no wrinkles
enum class Lighting : uint8_t { kGgx, kBlinn };  // skin and cloth by GGX; Blinn with Larsson's fading
enum class View : uint8_t { kBeauty, kWeight, kDirection, kPoint, kMask, kBias, kConfidence, kMorph };

struct RenderOptions {
  uint32_t width = 1024, height = 1024;  // 1 to 4096
  Tier tier = Tier::kGpu;
  Shading shading = Shading::kInterpolated;
  Lighting lighting = Lighting::kGgx;
  View view = View::kBeauty;
  uint32_t layer = 0;  // for the views of one layer: weight, direction, mask, bias, confidence
  Camera camera;
  float light_yaw = 0.0f;  // degrees that the lights are turned by round the picture's upright, to its right
  // A value a vertex that the views mask, in [0, 1], and bias, in [-1, 1], show in place of the asset's; or
  // empty.
  std::span<const float> values;
  // If not null, every stage of draw() is waited for, and how long it took is left here.
  StageTimes* times = nullptr;
};

// Where the maps of a texture set cannot be had (a mesh without UVs), creases are drawn by alpha shading of
// the vertices.
class Renderer {
 public:
  explicit Renderer(const AssetView& asset);  // `asset` must outlive the renderer
  ~Renderer();

  // Poses, weighs and draws; the picture has 4 channels, sRGB-encoded, row 0 on top. Throws pipeline::Error:
  // kBadUsage for an option or an input that does not fit the asset, kEnvironment where the tier or the
  // memory for the picture cannot be had.
  pipeline::Image render(const FrameInput& input, const RenderOptions& options);

  // The same without reading back: an OpenGL texture of sRGB-encoded bytes, bottom row first, good until the
  // next call. Leaves the default framebuffer bound, and the viewport and other drawing state changed.
  uint32_t draw(const FrameInput& input, const RenderOptions& options);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace furrow::preview
