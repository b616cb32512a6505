#include "editor/ui/viewport.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <string_view>
#include <utility>

#include "editor/ui/paint_tool.h"
#include "editor/ui/uv_view.h"
#include "editor/ui/widgets.h"
#include "furrow/gl/tier.h"
#include "pipeline/error.h"

namespace furrow::editor::ui {
namespace {

constexpr float kOrbitSpeed = 0.35f;  // degrees a pixel
constexpr float kLightSpeed = 0.5f;
constexpr float kZoomStep = 1.12f;
constexpr float kNearest = 1e-3f, kFarthest = 100.0f;  // camera distance, of the character's size
constexpr float kOtherUnits = 5.0f;                    // a mesh of another size is framed anew
constexpr uint32_t kLargestPicture = 4096;

// Everything that a picture depends on, as one number.
class Key {
 public:
  template <typename T>
  void add(std::span<const T> values) {
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  }
  template <typename T>
  void add(const T& value) {
    add(std::span<const T>(&value, 1));
  }
  size_t value() const { return std::hash<std::string_view>()(bytes_); }

 private:
  std::string bytes_;
};

const std::shared_ptr<Shown>& shownOn(const State& state, int side) {
  const bool compared = side == 1 && state.looks[1].compared && state.session.comparison();
  return compared ? state.session.comparison() : state.session.shown();
}

}  // namespace

// ---- Pane ----

void Pane::hold(const std::shared_ptr<Shown>& shown) {
  if (shown_ == shown && renderer_) return;
  const std::shared_ptr<Shown> before = std::exchange(shown_, shown);  // the renderer looks at it once more
  key_ = 0;
  if (renderer_)
    renderer_->show(shown->view());
  else
    renderer_ = std::make_unique<preview::Renderer>(shown->view());
}

void Pane::release() {
  renderer_.reset();
  shown_.reset();
  texture_ = 0;
}

preview::RenderOptions Pane::options(const State& state, const Shown& shown, const preview::PosedFrame& frame,
                                     const Look& look, uint32_t width, uint32_t height) const {
  preview::RenderOptions options;
  options.width = width;
  options.height = height;
  options.view = static_cast<preview::View>(look.view);
  options.shading = static_cast<preview::Shading>(look.shading);
  const uint32_t layer = state.assetLayer(shown);
  options.layer = layer == pipeline::kNoIndex ? 0 : layer;
  options.camera = state.camera;
  options.camera.target.x -= static_cast<float>(frame.origin[0]);
  options.camera.target.y -= static_cast<float>(frame.origin[1]);
  options.camera.target.z -= static_cast<float>(frame.origin[2]);
  options.light_yaw = state.light_yaw;
  return options;
}

uint32_t Pane::draw(const State& state, const std::shared_ptr<Shown>& shown, const preview::PosedFrame& frame,
                    const Look& look, uint32_t width, uint32_t height, const PaintTool* paint, Drawn& drawn) {
  try {
    gl::TierChoice choice;
    std::string_view wanted;
    if (const Status status = gl::wantedTier(look.tier, wanted); !status.ok())
      throw pipeline::Error(pipeline::Exit::kBadUsage, "FURROW_BACKEND", status.message, "unset it");
    if (const Status status = gl::chooseTier(wanted, {}, choice); !status.ok())
      throw pipeline::Error(pipeline::Exit::kEnvironment, std::string(wanted), status.message, "choose auto");
    hold(shown);
    preview::RenderOptions o = options(state, *shown, frame, look, width, height);
    o.tier = choice.tier;
    const bool live = paint && paint->fits(shown->view(), state.layer);
    if (live) {
      o.mask = paint->mask();
      o.mask_parts = paint->maskParts();
      o.bias = paint->bias();
      o.directions = paint->directions();
    }
    if (!o.bias.empty() && (o.view == preview::View::kBeauty || o.view == preview::View::kWeight)) {
      o.tier = preview::Tier::kCpu;
      choice = {o.tier, "a painted bias shows on the cpu tier until it is cooked"};
    }
    FrameInput input = frame.input;
    const std::vector<Response> responses = state.session.responses(*shown);
    input.responses = responses;

    Key key;
    for (uint32_t part : {o.width, o.height, static_cast<uint32_t>(o.tier), static_cast<uint32_t>(o.shading),
                          static_cast<uint32_t>(o.view), o.layer})
      key.add(part);
    const preview::Camera& c = o.camera;
    for (float part : {c.target.x, c.target.y, c.target.z, c.distance, c.yaw, c.pitch, c.field_of_view,
                       o.light_yaw, input.scale})
      key.add(part);
    key.add(c.z_up);
    key.add(live ? paint->stroke() : uint64_t{0});
    key.add(input.palette);
    key.add(input.morph_weights);
    key.add(input.region_weights);
    for (const Response& r : responses) {
      key.add(static_cast<uint32_t>(r.curve));
      for (float part : {r.lambda, r.beta, r.stretch_lambda, r.stretch_beta}) key.add(part);
    }
    if (texture_ != 0 && key.value() == key_) return texture_;
    o.times = &drawn.times;
    texture_ = renderer_->draw(input, o);
    key_ = key.value();
    drawn.tier = gl::tierName(renderer_->tier());
    drawn.lost = renderer_->tier() != choice.tier;
    drawn.reason = drawn.lost ? "the tiers before it were lost" : choice.reason;
    drawn.failed = false;
    return texture_;
  } catch (const preview::ContextLost&) {
    texture_ = 0;
    key_ = 0;
    throw;  // nothing else can be drawn either
  } catch (const pipeline::Error& error) {
    drawn.failed = true;
    drawn.tier = look.tier;
    drawn.reason = error.what();
    texture_ = 0;
    key_ = 0;
    return 0;
  }
}

pipeline::Image Pane::picture(const State& state, const std::shared_ptr<Shown>& shown,
                              const preview::PosedFrame& frame, const Look& look, uint32_t width,
                              uint32_t height) {
  hold(shown);
  preview::RenderOptions o = options(state, *shown, frame, look, width, height);
  std::string_view wanted;
  gl::TierChoice choice;
  Status status = gl::wantedTier(look.tier, wanted);
  if (status.ok()) status = gl::chooseTier(wanted, {}, choice);
  if (!status.ok())
    throw pipeline::Error(pipeline::Exit::kEnvironment, look.tier, status.message, "choose auto");
  o.tier = choice.tier;
  FrameInput input = frame.input;
  const std::vector<Response> responses = state.session.responses(*shown);
  input.responses = responses;
  key_ = 0;  // the texture has another size from here on
  texture_ = 0;
  return renderer_->render(input, o);
}

// ---- Projection ----

Projection::Projection(const preview::Camera& camera, const preview::PosedFrame& frame, ImVec2 low,
                       ImVec2 size)
    : aspect_(size.x / size.y), low_(low), size_(size) {
  preview::Camera local = camera;
  local.target.x -= static_cast<float>(frame.origin[0]);
  local.target.y -= static_cast<float>(frame.origin[1]);
  local.target.z -= static_cast<float>(frame.origin[2]);
  camera_ = preview::cameraFrame(local, aspect_);
  tangent_ = std::tan(glm::radians(camera.field_of_view) * 0.5f);
  eye = camera_.eye;
}

glm::vec3 Projection::rayAt(ImVec2 screen) const {
  const float x = 2.0f * (screen.x - low_.x) / size_.x - 1.0f,
              y = 1.0f - 2.0f * (screen.y - low_.y) / size_.y;
  return glm::normalize(tangent_ * (x * aspect_ * camera_.right + y * camera_.up) - camera_.back);
}

bool Projection::toScreen(glm::vec3 posed, ImVec2& screen) const {
  const glm::vec4 clip = camera_.view_projection * glm::vec4(posed, 1.0f);
  if (clip.w <= 0.0f) return false;
  screen = {low_.x + size_.x * (0.5f + 0.5f * clip.x / clip.w),
            low_.y + size_.y * (0.5f - 0.5f * clip.y / clip.w)};
  return true;
}

// ---- Viewport ----

float viewHeight(const preview::Camera& camera) {
  return 2.0f * camera.distance * std::tan(glm::radians(camera.field_of_view) * 0.5f);
}

void panCamera(preview::Camera& camera, float right, float up) {
  const float height = viewHeight(camera);
  const preview::CameraFrame axes = preview::cameraFrame(camera, 1.0f);
  const glm::vec3 move = height * (right * axes.right + up * axes.up);
  camera.target = {camera.target.x + move.x, camera.target.y + move.y, camera.target.z + move.z};
}

void zoomCamera(preview::Camera& camera, float size, float steps, float right, float up) {
  if (!(size > 0.0f)) return;
  const float before = camera.distance;
  camera.distance = std::clamp(before / std::pow(kZoomStep, steps), kNearest * size, kFarthest * size);
  const float moved = before / camera.distance - 1.0f;
  panCamera(camera, moved * right, moved * up);
}

Viewport::Viewport() : paint_(std::make_unique<PaintTool>()) {}
Viewport::~Viewport() = default;

void Viewport::release() {
  for (Pane& pane : panes_) pane.release();
  paint_->forget();
}

// The first pane's renderer knows, and goes on with the next tier.
void Viewport::contextLost() {
  panes_[1].release();
}

void Viewport::fit(State& state, const preview::PosedFrame& frame, std::span<const Float3> positions) {
  const preview::Camera before = state.camera;
  state.camera = preview::fitCamera(positions, aspect_, before.yaw, before.pitch, before.z_up);
  state.camera.target.x += static_cast<float>(frame.origin[0]);
  state.camera.target.y += static_cast<float>(frame.origin[1]);
  state.camera.target.z += static_cast<float>(frame.origin[2]);
  state.framed = true;
}

void Viewport::frameAll(State& state, const preview::PosedFrame& frame) {
  PosedSurface& surface = state.session.shown()->surface;
  surface.pose(frame.input);
  fit(state, frame, surface.positions());
}

void Viewport::frameLayer(State& state, const preview::PosedFrame& frame) {
  const Shown& shown = *state.session.shown();
  const uint32_t layer = state.assetLayer(shown);
  if (layer == pipeline::kNoIndex || shown.view().layers[layer].mask.empty()) return frameAll(state, frame);
  state.session.shown()->surface.pose(frame.input);
  std::vector<Float3> reached;
  const std::span<const uint8_t> mask = shown.view().layers[layer].mask;
  for (size_t v = 0; v < mask.size(); ++v)
    if (mask[v] > 51) reached.push_back(shown.surface.positions()[v]);
  if (reached.empty()) return frameAll(state, frame);
  fit(state, frame, reached);
}

void Viewport::moveCamera(State& state, ImVec2 low, ImVec2 size, bool hovered) {
  const ImGuiIO& io = ImGui::GetIO();
  preview::Camera& camera = state.camera;
  const bool looking = state.tool == Tool::kLook || io.KeyAlt;
  const auto drags = [&](ImGuiMouseButton button) {
    return ImGui::IsItemActive() && ImGui::IsMouseDragging(button, 0.0f);
  };
  const bool pan = drags(ImGuiMouseButton_Middle) || (looking && io.KeyShift && drags(ImGuiMouseButton_Left));
  if (pan) {
    panCamera(camera, -io.MouseDelta.x / size.y, io.MouseDelta.y / size.y);
  } else if (drags(ImGuiMouseButton_Right)) {
    state.light_yaw = std::remainder(state.light_yaw + kLightSpeed * io.MouseDelta.x, 360.0f);
  } else if (looking && drags(ImGuiMouseButton_Left)) {
    camera.yaw = std::remainder(camera.yaw - kOrbitSpeed * io.MouseDelta.x, 360.0f);
    camera.pitch = std::clamp(camera.pitch + kOrbitSpeed * io.MouseDelta.y, -89.0f, 89.0f);
  }
  if (hovered && io.MouseWheel != 0.0f) {
    if (io.KeyCtrl && state.tool != Tool::kLook)
      state.brush.size = std::clamp(state.brush.size * std::pow(kZoomStep, io.MouseWheel), 0.002f, 0.5f);
    else
      zoomCamera(camera, diagonalOf(state.session.shown()->view()), io.MouseWheel,
                 (io.MousePos.x - low.x - 0.5f * size.x) / size.y,
                 (low.y + 0.5f * size.y - io.MousePos.y) / size.y);
  }
}

void Viewport::draw(State& state, const preview::PosedFrame* frame) {
  const ImVec2 low = ImGui::GetCursorScreenPos(), size = ImGui::GetContentRegionAvail();
  if (size.x < 8.0f || size.y < 8.0f) return;
  const ImVec2 high = {low.x + size.x, low.y + size.y};
  const float aspect_before = std::exchange(aspect_, size.x / size.y);
  ImDrawList* list = ImGui::GetWindowDrawList();
  list->AddRectFilled(low, high, IM_COL32(26, 27, 29, 255));
  const std::shared_ptr<Shown>& shown = state.session.shown();
  if (!shown || !frame) return drawCooking(state, low, high);
  if (sized_.lock() != shown) {
    const float before = std::exchange(size_, diagonalOf(shown->view()));
    if (size_ > kOtherUnits * before || kOtherUnits * size_ < before) state.framed = false;
    sized_ = shown;
  }
  if (!state.framed) {
    const preview::Facing facing = preview::facing(shown->view().positions, shown->view().indices);
    state.camera.yaw = facing.yaw;
    state.camera.pitch = facing.pitch;
    frameAll(state, *frame);
    state.framed = aspect_ == aspect_before;  // the panels around it take a frame to find their sizes
  }

  const ImVec2 pixels = ImGui::GetIO().DisplayFramebufferScale;
  const auto width = static_cast<uint32_t>(std::clamp(size.x * pixels.x, 1.0f, float{kLargestPicture})),
             height = static_cast<uint32_t>(std::clamp(size.y * pixels.y, 1.0f, float{kLargestPicture}));
  const float middle = state.split ? std::floor(low.x + size.x * state.divider) : high.x;
  const int sides = state.split ? 2 : 1;
  const auto lowOf = [&](int side) { return ImVec2(side == 0 ? low.x : middle, low.y); };
  const auto highOf = [&](int side) { return ImVec2(side == 0 ? middle : high.x, high.y); };
  for (int side = 0; side < sides; ++side) {
    const Look& look = state.looks[side];
    const std::shared_ptr<Shown>& of = shownOn(state, side);
    const bool compared = of != shown;
    const ImVec2 from = lowOf(side), to = highOf(side);
    if (look.view == kUvView) {
      list->PushClipRect(from, to, true);
      drawUvLayout(state, *of, low, size);
      list->PopClipRect();
      continue;
    }
    const preview::PosedFrame other =
        compared ? state.session.player.frame(*of->loaded) : preview::PosedFrame();
    const uint32_t texture = panes_[side].draw(state, of, compared ? other : *frame, look, width, height,
                                               compared ? nullptr : paint_.get(), state.drawn[side]);
    if (texture != 0) {
      const float u0 = (from.x - low.x) / size.x, u1 = (to.x - low.x) / size.x;
      list->AddImage(reinterpret_cast<ImTextureID>(static_cast<uintptr_t>(texture)), from, to, {u0, 1.0f},
                     {u1, 0.0f});
    } else {
      list->AddText(ImGui::GetFont(), em(), {from.x + em(), low.y + 3.0f * em()}, Colors::kRed,
                    state.drawn[side].reason.c_str(), nullptr, to.x - from.x - 2.0f * em());
    }
  }
  if (!state.split) panes_[1].release();

  if (state.split) drawDivider(state, low, high);
  ImGui::SetCursorScreenPos(low);
  ImGui::InvisibleButton("##viewport", size,
                         ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight |
                             ImGuiButtonFlags_MouseButtonMiddle);
  ImGui::SetItemAllowOverlap();
  mark("viewport");
  const Projection projection(state.camera, *frame, low, size);
  list->PushClipRect(low, high, true);
  Pen pen = penOf(state, low, size, ImGui::IsItemHovered());
  const bool on_surface = state.looks[pen.at.x < middle ? 0 : 1].view != kUvView;
  pen.over = pen.over && on_surface;
  const bool taken = paint_->use(state, *frame, projection, pen);
  list->PopClipRect();
  for (int side = 0; side < sides; ++side) {
    const int view = state.looks[side].view;
    if (view == kUvView ||
        (state.tool != Tool::kGuide && view != static_cast<int>(preview::View::kDirection)))
      continue;
    list->PushClipRect(lowOf(side), highOf(side), true);
    paint_->drawGuides(state, *frame, projection);
    list->PopClipRect();
  }
  if (on_surface && (!taken || ImGui::GetIO().KeyAlt || ImGui::IsMouseDown(ImGuiMouseButton_Middle) ||
                     ImGui::IsMouseDown(ImGuiMouseButton_Right) || ImGui::GetIO().MouseWheel != 0.0f))
    moveCamera(state, low, size, ImGui::IsItemHovered());
  drawLabels(state, low, high);
  if (state.split || on_surface) drawHint(state, low, high);
}

Pen Viewport::penOf(const State& state, ImVec2 low, ImVec2 size, bool hovered) {
  if (!state.cursor)
    return {ImGui::GetIO().MousePos, hovered, ImGui::IsMouseClicked(ImGuiMouseButton_Left),
            ImGui::IsMouseDown(ImGuiMouseButton_Left)};
  const ImVec2 at = {low.x + size.x * state.cursor->x, low.y + size.y * state.cursor->y};
  const bool before = std::exchange(pen_down_, state.cursor_down);
  // Seen off the surface, too.
  const float arm = 0.5f * em();
  ImDrawList* list = ImGui::GetWindowDrawList();
  list->AddLine({at.x - arm, at.y}, {at.x + arm, at.y}, Colors::kAccent, 1.5f);
  list->AddLine({at.x, at.y - arm}, {at.x, at.y + arm}, Colors::kAccent, 1.5f);
  return {at, true, state.cursor_down && !before, state.cursor_down};
}

// Before there is anything to look at.
void Viewport::drawCooking(const State& state, ImVec2 low, ImVec2 high) const {
  if (!state.session.cooking()) return;
  ImDrawList* list = ImGui::GetWindowDrawList();
  const ImVec2 middle = {0.5f * (low.x + high.x), 0.5f * (low.y + high.y)};
  const auto line = [&](float y, ImU32 color, const std::string& text) {
    const float width = ImGui::CalcTextSize(text.c_str()).x;
    list->AddText({std::floor(middle.x - 0.5f * width), std::floor(middle.y + y * em())}, color,
                  text.c_str());
  };
  line(-2.4f, Colors::kText, "Cooking " + state.session.source().filename().string());
  line(0.6f, Colors::kDim, state.session.stage());
  // How long a cook takes is not known: the bar says that something happens.
  const float half = 9.0f * em(), y = middle.y - 0.4f * em(), thick = 0.25f * em();
  list->AddRectFilled({middle.x - half, y}, {middle.x + half, y + thick}, IM_COL32(255, 255, 255, 26), thick);
  const float t = state.scripted ? 0.25f : static_cast<float>(std::fmod(ImGui::GetTime() / 1.4, 1.0));
  const float from = middle.x - half + 2.0f * half * std::max(0.0f, 1.3f * t - 0.3f),
              to = middle.x - half + 2.0f * half * std::min(1.0f, 1.3f * t);
  list->AddRectFilled({from, y}, {to, y + thick}, Colors::kAccent, thick);
}

// What the mouse does with the tool in hand.
void Viewport::drawHint(const State& state, ImVec2 low, ImVec2 high) const {
  constexpr const char* kBrush = "Alt + drag: orbit     [ ]: brush size     X: mirror     Q: done";
  std::string text;
  if (state.cursor)
    text =
        "Arrows: move the brush     Space: down, up     E: erase     [ ]: brush size     C: by mouse again";
  else
    switch (state.tool) {
      case Tool::kLook:
        text =
            "Drag: orbit     Shift + drag: pan     Wheel: zoom     Right drag: turn lights     F1: all keys";
        break;
      case Tool::kBias:
        text = std::string("Drag: paint wrinkles at rest     Ctrl + drag: erase     ") + kBrush;
        break;
      case Tool::kMask:
        text = std::string("Drag: paint where the layer reaches     Ctrl + drag: erase     ") + kBrush;
        break;
      case Tool::kComb:
        text = std::string("Drag: stroke along the creases     Ctrl + drag: erase     ") + kBrush;
        break;
      case Tool::kGuide:
        text = "Drag: draw along a crease     Ctrl + click: remove a curve     Alt + drag: orbit     Q: done";
        break;
    }
  const float size = 0.87f * em(), pad = 0.7f * em();
  const auto widthOf = [&] { return ImGui::GetFont()->CalcTextSizeA(size, 1e9f, 0.0f, text.c_str()).x; };
  while (widthOf() + 2.0f * pad > high.x - low.x) {  // the last ones matter least
    const size_t end = text.rfind("     ");
    if (end == std::string::npos) return;
    text.erase(end);
  }
  const float width = widthOf();
  ImDrawList* list = ImGui::GetWindowDrawList();
  const ImVec2 at = {std::floor(low.x + pad), std::floor(high.y - pad - size)};
  list->AddRectFilled({at.x - 0.4f * em(), at.y - 0.2f * em()},
                      {at.x + width + 0.4f * em(), at.y + size + 0.25f * em()}, IM_COL32(14, 15, 17, 130),
                      0.3f * em());
  list->AddText(ImGui::GetFont(), size, at, Colors::kDim, text.c_str());
}

void Viewport::drawDivider(State& state, ImVec2 low, ImVec2 high) {
  const float x = std::floor(low.x + (high.x - low.x) * state.divider), grip = 0.45f * em();
  ImGui::SetCursorScreenPos({x - grip, low.y});
  ImGui::InvisibleButton("##divider", {2.0f * grip, high.y - low.y});
  mark("divider", {x - grip, low.y}, {x + grip, high.y});
  tooltip("Drag to show more of one side, 2 to 98% of the width  (Ctrl+Left, Ctrl+Right)");
  const bool held = ImGui::IsItemActive(), near = held || ImGui::IsItemHovered();
  if (held)
    state.divider = std::clamp((ImGui::GetIO().MousePos.x - low.x) / (high.x - low.x), kLeastDivider,
                               1.0f - kLeastDivider);
  if (near) ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
  ImDrawList* list = ImGui::GetWindowDrawList();
  const float line = std::floor(low.x + (high.x - low.x) * state.divider);
  list->AddLine({line, low.y}, {line, high.y}, IM_COL32(0, 0, 0, 160), 4.0f);
  list->AddLine({line, low.y}, {line, high.y}, near ? Colors::kAccent : IM_COL32(235, 235, 235, 255), 1.6f);
  const float y = 0.5f * (low.y + high.y);
  list->AddRectFilled({line - 0.25f * em(), y - em()}, {line + 0.25f * em(), y + em()},
                      near ? Colors::kAccent : IM_COL32(235, 235, 235, 255), 0.25f * em());
}

void Viewport::drawLabels(const State& state, ImVec2 low, ImVec2 high) const {
  ImDrawList* list = ImGui::GetWindowDrawList();
  const float pad = 0.7f * em(), middle = low.x + (high.x - low.x) * state.divider;
  for (int side = 0; side < (state.split ? 2 : 1); ++side) {
    const Look& look = state.looks[side];
    std::string text = kViewNames[look.view];
    if (look.view == 0)
      text += std::string("  \xc2\xb7  ") + kShadingNames[look.shading];
    else if (look.view != 3 && look.view != 7 && !state.layer.empty())
      text += "  \xc2\xb7  " + state.layer;
    if (side == 1 && look.compared && !state.session.compared().empty())
      text += "  \xc2\xb7  " + state.session.compared().filename().string();
    const float room =
        (state.split ? (side == 0 ? middle - low.x : high.x - middle) : high.x - low.x) - 2.0f * pad;
    text = fitted(text, std::max(room, 2.0f * em()));
    const ImVec2 extent = ImGui::CalcTextSize(text.c_str());
    const float x = state.split && side == 0 ? middle - extent.x - 2.0f * pad - pad * 0.5f
                    : state.split            ? middle + pad * 0.5f + pad * 0.5f
                                             : low.x + pad;
    const ImVec2 at = {std::floor(std::max(x, low.x + 4.0f)), std::floor(low.y + pad)};
    list->AddRectFilled({at.x - 0.4f * em(), at.y - 0.25f * em()},
                        {at.x + extent.x + 0.4f * em(), at.y + extent.y + 0.25f * em()},
                        IM_COL32(14, 15, 17, 170), 0.3f * em());
    list->AddText(at, Colors::kText, text.c_str());
    drawLegend(state, look,
               {side == 1 || !state.split ? std::max(high.x - 11.0f * em(), low.x + pad) : low.x + pad,
                high.y - 4.4f * em()});
  }
}

void Viewport::drawLegend(const State&, const Look& look, ImVec2 at) const {
  const auto view = static_cast<preview::View>(look.view);
  std::vector<ImU32> colors;
  const char *left = "", *right = "";
  if (view == preview::View::kWeight || view == preview::View::kBias) {
    colors = {IM_COL32(28, 62, 170, 255), IM_COL32(89, 172, 237, 255), IM_COL32(172, 172, 172, 255),
              IM_COL32(249, 172, 69, 255), IM_COL32(206, 38, 33, 255)};
    left = view == preview::View::kWeight ? "-1 stretch" : "-1 smooth";
    right = view == preview::View::kWeight ? "squeeze 1" : "creased 1";
  } else if (view == preview::View::kMorph) {
    colors = {IM_COL32(172, 172, 172, 255), IM_COL32(249, 172, 69, 255), IM_COL32(206, 38, 33, 255)};
    left = "0 still";
    right = "farthest 1";
  } else if (view == preview::View::kConfidence) {
    colors = {IM_COL32(28, 24, 64, 255), IM_COL32(97, 39, 130, 255), IM_COL32(195, 69, 89, 255),
              IM_COL32(247, 156, 39, 255), IM_COL32(252, 241, 176, 255)};
    left = "0 guess";
    right = "sure 1";
  } else if (view == preview::View::kMask) {
    colors = {IM_COL32(48, 48, 48, 255), IM_COL32(238, 238, 238, 255)};
    left = "0 outside";
    right = "inside 1";
  } else {
    return;
  }
  ImDrawList* list = ImGui::GetWindowDrawList();
  const float width = 10.2f * em(), height = 0.45f * em(), small = 0.82f * em();
  list->AddRectFilled({at.x - 0.4f * em(), at.y - 0.3f * em()},
                      {at.x + width + 0.4f * em(), at.y + height + 1.25f * em()}, IM_COL32(14, 15, 17, 170),
                      0.3f * em());
  for (size_t i = 0; i + 1 < colors.size(); ++i) {
    const float x0 = at.x + width * static_cast<float>(i) / static_cast<float>(colors.size() - 1),
                x1 = at.x + width * static_cast<float>(i + 1) / static_cast<float>(colors.size() - 1);
    list->AddRectFilledMultiColor({x0, at.y}, {x1, at.y + height}, colors[i], colors[i + 1], colors[i + 1],
                                  colors[i]);
  }
  const float y = at.y + height + 0.15f * em();
  list->AddText(ImGui::GetFont(), small, {at.x, y}, Colors::kText, left);
  const float extent = ImGui::GetFont()->CalcTextSizeA(small, 1e9f, 0.0f, right).x;
  list->AddText(ImGui::GetFont(), small, {at.x + width - extent, y}, Colors::kText, right);
}

pipeline::Image Viewport::picture(State& state, const preview::PosedFrame& frame, uint32_t width,
                                  uint32_t height) {
  const auto side = [&](int number) {
    const std::shared_ptr<Shown>& of = shownOn(state, number);
    const bool compared = of != state.session.shown();
    const preview::PosedFrame other =
        compared ? state.session.player.frame(*of->loaded) : preview::PosedFrame();
    return panes_[number].picture(state, of, compared ? other : frame, state.looks[number], width, height);
  };
  pipeline::Image picture = side(0);
  if (!state.split) return picture;
  const pipeline::Image right = side(1);
  const auto divider = static_cast<uint32_t>(static_cast<float>(width) * state.divider);
  for (uint32_t y = 0; y < height; ++y)
    std::copy_n(right.at(divider, y), size_t{4} * (width - divider), picture.at(divider, y));
  return picture;
}

}  // namespace furrow::editor::ui
