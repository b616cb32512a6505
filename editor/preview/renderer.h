#pragma once

// The preview renderer: one asset, one pose, one picture. Needs a current OpenGL core context (headless_context.h or a window).

#include <memory>
#include <string>

#include "furrow/frame_plan.h"
#include "pipeline/maps/image.h"

namespace furrow::preview {

enum class Tier { kGpu, kCpu };
enum class Shading { kInterpolated, kBlend, kAlpha, kNone };  // Larsson's three methods, and no wrinkles
enum class View { kBeauty, kWeight, kDirection, kPoint, kMask, kBias, kConfidence };

// Orbit around `target`; angles in degrees, yaw 0 looks along -Z at the front of the subject.
struct Camera {
  Float3 target{0, 0, 0};
  float distance = 1.0f;
  float yaw = 0.0f, pitch = 0.0f;
  float field_of_view = 30.0f;  // vertical, degrees
};

struct RenderOptions {
  uint32_t width = 1024, height = 1024;
  Tier tier = Tier::kGpu;
  Shading shading = Shading::kInterpolated;
  View view = View::kBeauty;
  uint32_t layer = 0;  // for the views of one layer: weight, direction, mask, bias, confidence
  Camera camera;
};

// Fits the posed asset into the picture.
Camera fitCamera(const AssetView& asset, std::span<const Float3> posed_positions, float aspect, float yaw, float pitch);

class Renderer {
 public:
  explicit Renderer(const AssetView& asset);  // `asset` must outlive the renderer
  ~Renderer();

  // Poses, weighs and draws; the picture has 4 channels, sRGB-encoded, row 0 on top.
  pipeline::Image render(const FrameInput& input, const RenderOptions& options);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace furrow::preview
