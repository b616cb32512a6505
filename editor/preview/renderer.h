#pragma once

// The preview renderer: one asset at a time, one pose, one picture. Needs a current OpenGL 3.3 core context
// (headless_context.h or a window), 4.3 for the gpu tier; the destructor needs it too.

#include <glm/vec4.hpp>
#include <memory>
#include <span>
#include <string>

#include "editor/preview/camera.h"
#include "editor/preview/stage_times.h"
#include "furrow/frame_plan.h"
#include "furrow/gl/context.h"
#include "furrow/gl/tier.h"
#include "pipeline/error.h"
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
  // In place of the asset's for `layer`, as it is being painted, or nothing. A mask is the first channel of
  // an image in the UVs of some parts; the layer shows on no others. It cannot be seen without OpenGL.
  std::shared_ptr<const pipeline::ByteImage> mask;
  std::span<const uint32_t> mask_parts;
  // A value a vertex, in [-1, 1]. The view of the bias shows it on every tier, the other views on the cpu
  // tier.
  std::span<const float> bias;
  // A direction a vertex, in root space at rest, as long as it is sure; w: whether it is painted. The views
  // of direction and confidence show it.
  std::span<const glm::vec4> directions;
  // If not null, every stage of draw() is waited for, and how long it took is left here.
  StageTimes* times = nullptr;
};

// The OpenGL context was lost under a picture. Thrown in place of the picture; the next one is drawn in
// whatever context is current by then, on the next tier.
class ContextLost : public pipeline::Error {
 public:
  ContextLost(Tier on, const char* how);
  Tier tier() const { return tier_; }              // that it was lost on
  const std::string& how() const { return how_; }  // "the OpenGL context was lost (reset)"

 private:
  Tier tier_;
  std::string how_;
};

// Where the maps of a texture set cannot be had (a mesh without UVs), creases are drawn by alpha shading of
// the vertices.
class Renderer {
 public:
  // `asset` must outlive the renderer. Whether the context was lost is asked of `lost`; null: of
  // gl::resetStatus(). One in which the renderer's objects are no more is lost in any case.
  explicit Renderer(const AssetView& asset, gl::ResetStatus lost = nullptr);
  ~Renderer();

  // From here on draws `asset`. Shader programs are kept, and textures that both assets have; the one before
  // must still be there. Throws ContextLost; `asset` is then drawn in the next context.
  void show(const AssetView& asset);

  // Poses, weighs and draws; the picture has 4 channels, sRGB-encoded, row 0 on top. Throws pipeline::Error:
  // kBadUsage for an option or an input that does not fit the asset, kEnvironment where the tier or the
  // memory for the picture cannot be had; ContextLost.
  pipeline::Image render(const FrameInput& input, const RenderOptions& options);

  // The same without reading back: an OpenGL texture of sRGB-encoded bytes, bottom row first, good until the
  // next call. Leaves the default framebuffer bound, and the viewport and other drawing state changed.
  uint32_t draw(const FrameInput& input, const RenderOptions& options);

  // Of the last picture: RenderOptions::tier, or the one that losses of the context left.
  Tier tier() const { return tier_; }

 private:
  struct State;
  void check();  // throws ContextLost
  [[noreturn]] void lose(const char* how);

  const AssetView* asset_;
  gl::ResetStatus asked_;
  Tier tier_ = Tier::kGpu, first_ = Tier::kGpu;  // `first_`: the tiers before it were lost
  std::unique_ptr<State> state_;                 // null: to be made anew
};

}  // namespace furrow::preview
