#pragma once

// The tools that work on the surface under the pointer: painting of bias, masks and directions, and guide
// curves.

#include <optional>

#include "editor/ui/viewport.h"

namespace furrow::editor::ui {

class PaintTool {
 public:
  // Takes the pointer over the picture; true while it does, so that the camera stays. Draws the brush.
  bool use(State& state, const preview::PosedFrame& frame, const Projection& projection, bool hovered);
  // The guide curves of the selected layer.
  void drawGuides(const State& state, const preview::PosedFrame& frame, const Projection& projection);

  // What a stroke in progress shows, or what the painted image says; a value a vertex.
  std::span<const float> values() const { return values_; }
  uint64_t stroke() const { return stroke_number_; }
  void forget();  // of the asset that is gone

 private:
  bool begin(State& state, Painted kind);
  void finish(State& state);
  void guide(State& state, const preview::PosedFrame& frame, const Projection& projection, bool hovered);
  void drawBrush(const State& state, const Projection& projection, const SurfaceHit& hit) const;

  std::shared_ptr<Shown> shown_;
  std::shared_ptr<const Canvas> canvas_;
  std::string canvas_key_;
  std::unique_ptr<Stroke> stroke_;
  Painted kind_ = Painted::kBias;
  std::vector<float> values_;
  uint64_t stroke_number_ = 0;
  std::optional<std::vector<std::array<double, 3>>> curve_;  // being drawn, rest
  std::vector<SurfaceHit> curve_hits_;

  // Where the guides of the document lie on the shown surface.
  std::vector<std::vector<SurfaceHit>> guide_hits_;
  std::vector<std::vector<std::array<double, 3>>> guide_curves_;
};

}  // namespace furrow::editor::ui
