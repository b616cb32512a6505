#pragma once

// The picture of the character: drawn by the preview renderer, on one or two sides of a divider.

#include <imgui.h>

#include <glm/vec3.hpp>
#include <memory>
#include <string>

#include "editor/ui/state.h"

namespace furrow::editor::ui {

// Draws one side, and only when something that it shows has changed.
class Pane {
 public:
  // The texture (bottom row first) of `look` at this size, or 0 and why in `drawn`. `paint`: what is being
  // painted, or null.
  uint32_t draw(const State& state, const std::shared_ptr<Shown>& shown, const preview::PosedFrame& frame,
                const Look& look, uint32_t width, uint32_t height, const class PaintTool* paint,
                Drawn& drawn);
  // A picture of another size, read back. Throws pipeline::Error.
  pipeline::Image picture(const State& state, const std::shared_ptr<Shown>& shown,
                          const preview::PosedFrame& frame, const Look& look, uint32_t width,
                          uint32_t height);
  void release();  // what it holds of the context

 private:
  preview::RenderOptions options(const State& state, const Shown& shown, const preview::PosedFrame& frame,
                                 const Look& look, uint32_t width, uint32_t height) const;
  void hold(const std::shared_ptr<Shown>& shown);

  std::shared_ptr<Shown> shown_;
  std::unique_ptr<preview::Renderer> renderer_;
  uint32_t texture_ = 0;
  size_t key_ = 0;
};

// A ray through a place of the picture, and back.
struct Projection {
  Projection(const preview::Camera& camera, const preview::PosedFrame& frame, ImVec2 low, ImVec2 size);

  glm::vec3 eye;  // relative to the frame's origin, as posed positions are
  glm::vec3 rayAt(ImVec2 screen) const;
  bool toScreen(glm::vec3 posed, ImVec2& screen) const;  // false behind the eye

 private:
  preview::CameraFrame camera_;
  float aspect_, tangent_;
  ImVec2 low_, size_;
};

// What the picture's height is at the distance of what the camera looks at, root-space units.
float viewHeight(const preview::Camera& camera);
// Moves the camera and what it looks at, in heights of the picture.
void panCamera(preview::Camera& camera, float right, float up);
// Nearer to a character of that size by steps of the wheel; what is at a place of the picture, in its heights
// from the middle, stays.
void zoomCamera(preview::Camera& camera, float size, float steps, float right = 0.0f, float up = 0.0f);

class Viewport {
 public:
  // Fills the current window. `frame` is that of the shown asset, null if there is none.
  void draw(State& state, const preview::PosedFrame* frame);
  // The view at another size, no side of which shows the UV layout. Throws pipeline::Error.
  pipeline::Image picture(State& state, const preview::PosedFrame& frame, uint32_t width, uint32_t height);

  void frameAll(State& state, const preview::PosedFrame& frame);
  void frameLayer(State& state, const preview::PosedFrame& frame);  // where the selected layer reaches
  float aspect() const { return aspect_; }
  void release();
  void contextLost();

 private:
  void moveCamera(State& state, ImVec2 low, ImVec2 size, bool hovered);
  void drawLabels(const State& state, ImVec2 low, ImVec2 high) const;
  void drawCooking(const State& state, ImVec2 low, ImVec2 high) const;
  void drawHint(const State& state, ImVec2 low, ImVec2 high) const;
  void drawDivider(State& state, ImVec2 low, ImVec2 high);
  void drawLegend(const State& state, const Look& look, ImVec2 at) const;
  void fit(State& state, const preview::PosedFrame& frame, std::span<const Float3> positions);

  struct Pen penOf(const State& state, ImVec2 low, ImVec2 size, bool hovered);

  Pane panes_[2];
  std::weak_ptr<Shown> sized_;  // what has that size
  float size_ = 0.0f;
  bool pen_down_ = false;  // that the keyboard moves, in the last frame
  float aspect_ = 1.0f;
  std::unique_ptr<class PaintTool> paint_;

 public:
  Viewport();
  ~Viewport();
};

}  // namespace furrow::editor::ui
