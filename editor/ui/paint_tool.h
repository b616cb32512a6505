#pragma once

// The tools that work on the surface under the pointer: painting of bias, masks and directions, and guide
// curves.

#include <optional>
#include <span>

#include "editor/ui/viewport.h"

namespace furrow::editor::ui {

// The pointer, or what the keyboard moves in its place.
struct Pen {
  ImVec2 at;            // on the screen
  bool over = false;    // the picture
  bool begins = false;  // was put down in this frame
  bool down = false;
};

class PaintTool {
 public:
  // Takes the pen over the picture; true while it does, so that the camera stays. Draws the brush.
  bool use(State& state, const preview::PosedFrame& frame, const Projection& projection, const Pen& pen);
  // The guide curves of the selected layer.
  void drawGuides(const State& state, const preview::PosedFrame& frame, const Projection& projection);

  // What a stroke in progress, or one that is not cooked yet, makes of a layer, as RenderOptions have it; for
  // the layer and an asset that it fits.
  bool fits(const AssetView& asset, const std::string& layer) const;
  const std::shared_ptr<const pipeline::ByteImage>& mask() const { return mask_; }
  std::span<const uint32_t> maskParts() const {
    return canvas_ ? canvas_->parts() : std::span<const uint32_t>();
  }
  std::span<const float> bias() const { return bias_; }
  std::span<const glm::vec4> directions() const { return directions_; }
  uint64_t stroke() const { return stroke_number_; }
  void forget();  // of the asset that is gone

 private:
  void follow(Session& session);
  bool begin(State& state, Painted kind);
  void finish(State& state);
  void guide(State& state, const preview::PosedFrame& frame, const Projection& projection, const Pen& pen,
             std::span<const ImVec2> places);
  void showPainted(const State& state);
  void unshow();
  void drawBrush(const State& state, const Projection& projection, const SurfaceHit& hit) const;

  std::shared_ptr<Shown> shown_;
  std::shared_ptr<const Canvas> canvas_;
  std::string canvas_key_;
  std::unique_ptr<Stroke> stroke_;
  bool pressed_ = false;  // on the picture, and still down
  ImVec2 pen_at_{};       // in the last frame
  Painted kind_ = Painted::kBias;
  std::string layer_;  // that the stroke, or the last one, is of
  std::shared_ptr<const pipeline::ByteImage> mask_;
  std::vector<float> bias_;
  std::vector<glm::vec4> directions_, combed_;  // combed_: before the stroke
  uint64_t stroke_number_ = 0;
  // The image that the last stroke left in the document.
  std::filesystem::path file_;
  std::shared_ptr<const pipeline::ByteImage> image_;
  std::optional<std::vector<std::array<double, 3>>> curve_;  // being drawn, rest
  std::vector<SurfaceHit> curve_hits_;

  // Where the guides of the document lie on the shown surface.
  std::vector<std::vector<SurfaceHit>> guide_hits_;
  std::vector<std::vector<std::array<double, 3>>> guide_curves_;
};

}  // namespace furrow::editor::ui
