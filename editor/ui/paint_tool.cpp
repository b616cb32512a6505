#include "editor/ui/paint_tool.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "editor/ui/widgets.h"
#include "pipeline/error.h"

namespace furrow::editor::ui {
namespace {

constexpr int kRing = 48;             // points of the brush's circle
constexpr float kGuideStep = 0.012f;  // of the diagonal, between points of a guide
constexpr float kGrab = 8.0f;         // pixels from a guide that still mean it
constexpr float kSeen = 0.1f;         // of a weight or a mask, the least that shows
constexpr float kMostPlaces = 12.0f;  // that a stroke visits in a frame

Painted paintedBy(Tool tool) {
  return tool == Tool::kMask ? Painted::kMask : tool == Tool::kComb ? Painted::kDirection : Painted::kBias;
}

const char* nameOf(Painted kind) {
  return kind == Painted::kMask ? "mask" : kind == Painted::kDirection ? "direction" : "bias";
}

// Whether what is known of one asset's vertices holds for the other's, and one frame poses both.
bool sameShape(const AssetView& a, const AssetView& b) {
  return a.vertexCount() == b.vertexCount() && a.parts.size() == b.parts.size() &&
         a.morphs.size() == b.morphs.size() && a.palette.size() == b.palette.size();
}

// Whether the mask ends nowhere on the surface that the layer lies on.
bool isWhole(const pipeline::Mask& mask, const AssetView& asset, uint32_t layer) {
  if (std::holds_alternative<pipeline::MaskNone>(mask)) return true;
  if (!std::holds_alternative<pipeline::MaskAuto>(mask) || layer == pipeline::kNoIndex) return false;
  return std::ranges::all_of(asset.layers[layer].mask, [](uint8_t m) { return m == 0 || m == 255; });
}

// Whether bias was painted, and nowhere that the layer reaches.
bool isOutside(const Layer& layer, std::span<const float> painted) {
  bool some = false;
  for (size_t v = 0; v < painted.size(); ++v) {
    const float before = layer.bias.empty() ? 0.0f : static_cast<float>(layer.bias[v]) / 32767.0f;
    if (std::abs(painted[v] - before) < kSeen) continue;
    if (layer.mask.empty() || static_cast<float>(layer.mask[v]) > 255.0f * kSeen) return false;
    some = true;
  }
  return some;
}

// From behind `from` to `to`, two em apart: a fast hand leaves out nothing of a curved surface.
std::vector<ImVec2> placesBetween(ImVec2 from, ImVec2 to) {
  const float steps = std::hypot(to.x - from.x, to.y - from.y) / (2.0f * em());
  const int count = static_cast<int>(std::clamp(std::ceil(steps), 1.0f, kMostPlaces));
  std::vector<ImVec2> places;
  for (int i = 1; i <= count; ++i) {
    const float t = static_cast<float>(i) / static_cast<float>(count);
    places.push_back({from.x + t * (to.x - from.x), from.y + t * (to.y - from.y)});
  }
  return places;
}

}  // namespace

void PaintTool::forget() {
  shown_.reset();
  canvas_.reset();
  canvas_key_.clear();
  stroke_.reset();
  unshow();
  guide_hits_.clear();
  guide_curves_.clear();
  curve_.reset();
}

// Takes what is shown now. A stroke or curve goes on over the surface that it began on, and what was painted
// since a cook began stays in sight when it ends, unless the surface is another.
void PaintTool::follow(Session& session) {
  const bool drawing = stroke_ || curve_;
  if (!drawing && image_) {
    const pipeline::Images& images = session.document.content().images;
    const auto found = images.find(file_);
    if (found == images.end() || found->second != image_) unshow();  // it was undone
  }
  if (shown_ == session.shown()) return;
  const std::shared_ptr<Shown> next = session.shown();
  if (!shown_ || !next || !sameShape(shown_->view(), next->view())) {
    forget();
  } else if (drawing) {
    return;
  } else if (session.current()) {
    unshow();
  }
  shown_ = next;
  canvas_key_.clear();
  guide_curves_.clear();
  guide_hits_.clear();
}

bool PaintTool::fits(const AssetView& asset, const std::string& layer) const {
  return shown_ && layer == layer_ && (mask_ || !bias_.empty() || !directions_.empty()) &&
         sameShape(asset, shown_->view());
}

void PaintTool::showPainted(const State& state) {
  ++stroke_number_;
  if (kind_ == Painted::kMask) mask_ = std::make_shared<const pipeline::ByteImage>(stroke_->image());
  if (kind_ == Painted::kDirection)
    directions_ = stroke_->vertexDirections(shown_->view(), state.assetLayer(*shown_), combed_);
  if (kind_ == Painted::kBias) bias_ = vertexBias(stroke_->image(), *canvas_, shown_->view());
}

void PaintTool::unshow() {
  image_.reset();
  mask_.reset();
  bias_.clear();
  directions_.clear();
}

bool PaintTool::begin(State& state, Painted kind) {
  Session& session = state.session;
  const uint32_t index = state.documentLayer();
  if (!session.editable() || index == pipeline::kNoIndex) return false;
  const pipeline::LayerRecipe& layer = session.document.recipe().layers[index];
  const AssetView& asset = shown_->view();
  const auto size = static_cast<uint32_t>(state.settings.painted_size);
  const auto [named, channel] = namedImage(layer, kind);

  std::shared_ptr<const pipeline::ByteImage> before;
  if (const auto known = session.document.content().images.find(named);
      known != session.document.content().images.end())
    before = known->second;
  std::string key = layer.name + "\n" + std::to_string(before ? before->width : size);
  for (const auto* names : {&layer.meshes, &layer.materials})
    for (const std::string& name : *names) key += "\n" + name;
  if (!canvas_ || canvas_key_ != key) {
    canvas_ = std::make_shared<Canvas>(asset, layer, before ? before->width : size);
    canvas_key_ = key;
  }
  if (canvas_->empty()) {
    session.tell(Message::Kind::kError, session.source().string() + ": the meshes of layer \"" + layer.name +
                                            "\" have no UVs to paint in: unwrap them, or paint a vertex "
                                            "attribute in your modelling program");
    state.problems_shown = true;
    return false;
  }
  if (!before && !named.empty()) {
    try {
      const pipeline::ByteImage image = pipeline::readByteImage(named);
      if (kind != Painted::kDirection && channel < image.channels)
        before = std::make_shared<pipeline::ByteImage>(planeOf(image, channel, canvas_->size()));
      else if (kind == Painted::kDirection && image.channels >= 2)
        before = std::make_shared<pipeline::ByteImage>(
            pipeline::toBytes(pipeline::resize(pipeline::toFloats(image), canvas_->size(), canvas_->size())));
    } catch (const pipeline::Error& error) {
      session.tell(Message::Kind::kError, error.what());
    }
  }
  // Where all that the layer lies on is white, a mask begins black: strokes could add nothing to it.
  if (!before && kind == Painted::kMask && isWhole(layer.mask, asset, state.assetLayer(*shown_)))
    before = std::make_shared<pipeline::ByteImage>(
        canvas_->current(kind, asset, static_cast<uint32_t>(asset.layerCount())));
  if (!before)
    before = std::make_shared<pipeline::ByteImage>(canvas_->current(kind, asset, state.assetLayer(*shown_)));
  if (kind != kind_ || layer_ != layer.name) unshow();
  kind_ = kind;
  layer_ = layer.name;
  combed_ = directions_;
  stroke_ = std::make_unique<Stroke>(canvas_, before, kind, state.brush, viewHeight(state.camera));
  return true;
}

void PaintTool::finish(State& state) {
  const std::unique_ptr<Stroke> stroke = std::move(stroke_);
  if (!stroke->touched()) {
    unshow();
    return;
  }
  // The layer that it began on, whichever is selected by now; it may be gone.
  Session& session = state.session;
  Content content = session.document.content();
  std::vector<pipeline::LayerRecipe>& layers = content.recipe.layers;
  const auto found = std::find_if(layers.begin(), layers.end(),
                                  [&](const pipeline::LayerRecipe& layer) { return layer.name == layer_; });
  if (found == layers.end()) return unshow();
  const std::filesystem::path file =
      paintedFile(content, session.document.file(), static_cast<size_t>(found - layers.begin()), kind_);
  pipeline::LayerRecipe& layer = *found;
  file_ = file;
  image_ = content.images[file] = std::make_shared<pipeline::ByteImage>(stroke->image());
  if (kind_ == Painted::kMask)
    layer.mask = pipeline::MaskTexture{file, 0};
  else if (kind_ == Painted::kDirection)
    layer.direction = pipeline::DirectionTexture{file};
  else
    layer.bias = pipeline::Bias{{}, 0, 0.5, file};
  const uint32_t index = state.layer == layer_ ? state.assetLayer(*shown_) : pipeline::kNoIndex;
  if (kind_ == Painted::kBias && index != pipeline::kNoIndex &&
      isOutside(shown_->view().layers[index], bias_))
    session.tell(Message::Kind::kWarning, session.source().string() + ": layer \"" + layer_ +
                                              "\" does not reach what was painted: paint its mask there, "
                                              "too, or let it have the whole surface");
  session.document.endGesture();
  session.document.apply(std::move(content), std::string("Paint ") + nameOf(kind_) + " of " + layer.name);
  session.document.endGesture();
}

bool PaintTool::use(State& state, const preview::PosedFrame& frame, const Projection& projection,
                    const Pen& pen) {
  follow(state.session);
  if (!stroke_ && state.layer != layer_) unshow();
  if (state.tool == Tool::kLook) {
    if (stroke_) finish(state);
    return false;
  }
  const ImGuiIO& io = ImGui::GetIO();
  if (io.KeyAlt && !stroke_ && !curve_) return false;  // the camera's
  // A stroke that comes from beside the surface begins where it meets it.
  pressed_ = pen.down && (pressed_ || (pen.over && pen.begins));
  const ImVec2 before = std::exchange(pen_at_, pen.at);
  const std::vector<ImVec2> places = placesBetween(pen.begins ? pen.at : before, pen.at);
  if (state.tool == Tool::kGuide) {
    guide(state, frame, projection, pen, places);
    return true;
  }
  PosedSurface& surface = shown_->surface;
  std::optional<SurfaceHit> hit;  // at the pen, in the end
  if (pen.over || pressed_ || stroke_) surface.pose(frame.input);
  if (pressed_ || stroke_) {
    for (const ImVec2 at : places) {
      hit = surface.hit(projection.eye, projection.rayAt(at));
      if (!hit) continue;
      if (pressed_ && !stroke_) {
        const bool erase = state.brush.erase;
        state.brush.erase = erase != io.KeyCtrl;
        pressed_ = begin(state, paintedBy(state.tool));
        state.brush.erase = erase;
      }
      if (stroke_)
        stroke_->moveTo(surface.restAt(hit->triangle, hit->barycentric), surface.restNormal(hit->triangle));
    }
    if (stroke_) showPainted(state);
  } else if (pen.over) {
    hit = surface.hit(projection.eye, projection.rayAt(pen.at));
  }
  if (stroke_ && !pen.down) finish(state);
  if (hit) drawBrush(state, projection, *hit);
  return true;
}

void PaintTool::drawBrush(const State& state, const Projection& projection, const SurfaceHit& hit) const {
  ImDrawList* list = ImGui::GetWindowDrawList();
  const PosedSurface& surface = shown_->surface;
  const glm::vec3 middle = surface.at(hit.triangle, hit.barycentric);
  glm::vec3 normal = glm::cross(surface.at(hit.triangle, {0, 1, 0}) - surface.at(hit.triangle, {1, 0, 0}),
                                surface.at(hit.triangle, {0, 0, 1}) - surface.at(hit.triangle, {1, 0, 0}));
  if (!(glm::length(normal) > 0.0f)) return;
  normal = glm::normalize(normal);
  const glm::vec3 aside = std::abs(normal.y) < 0.9f ? glm::vec3(0, 1, 0) : glm::vec3(1, 0, 0);
  const glm::vec3 x = glm::normalize(glm::cross(aside, normal)), y = glm::cross(normal, x);
  const float radius = state.brush.size * viewHeight(state.camera);
  for (const float part : {1.0f, 1.0f - state.brush.falloff}) {
    if (part < 0.02f) continue;
    std::array<ImVec2, kRing> ring;
    bool seen = true;
    for (int i = 0; i < kRing; ++i) {
      const float angle = 6.2831853f * static_cast<float>(i) / kRing;
      seen &= projection.toScreen(middle + radius * part * (std::cos(angle) * x + std::sin(angle) * y),
                                  ring[static_cast<size_t>(i)]);
    }
    if (!seen) continue;
    list->AddPolyline(ring.data(), kRing, IM_COL32(0, 0, 0, 140), ImDrawFlags_Closed, 3.0f);
    list->AddPolyline(ring.data(), kRing,
                      part == 1.0f ? IM_COL32(255, 255, 255, 220) : IM_COL32(255, 255, 255, 110),
                      ImDrawFlags_Closed, 1.3f);
  }
}

void PaintTool::guide(State& state, const preview::PosedFrame& frame, const Projection& projection,
                      const Pen& pen, std::span<const ImVec2> places) {
  Session& session = state.session;
  const uint32_t index = state.documentLayer();
  if (!session.editable() || index == pipeline::kNoIndex) return;
  const ImGuiIO& io = ImGui::GetIO();
  shown_->surface.pose(frame.input);
  if (pen.over && pen.begins && (io.KeyCtrl || state.brush.erase)) {
    pressed_ = false;
    // The curve under the pointer goes.
    for (size_t c = 0; c < guide_hits_.size(); ++c)
      for (const SurfaceHit& point : guide_hits_[c]) {
        ImVec2 at;
        if (!projection.toScreen(shown_->surface.at(point.triangle, point.barycentric), at)) continue;
        if (std::hypot(at.x - pen.at.x, at.y - pen.at.y) > kGrab * em() / 15.0f) continue;
        state.edit("Remove guide", [&](pipeline::LayerRecipe& layer) {
          auto* guides = std::get_if<pipeline::DirectionGuides>(&layer.direction);
          if (!guides || guides->curves != guide_curves_) return;  // another layer is selected by now
          guides->curves.erase(guides->curves.begin() + static_cast<std::ptrdiff_t>(c));
          if (guides->curves.empty()) layer.direction = pipeline::DirectionAnimation{};
        });
        session.document.endGesture();
        return;
      }
  }
  if (!pressed_ && !curve_) return;
  const float step = kGuideStep * diagonalOf(shown_->view());
  for (const ImVec2 at : places) {
    const std::optional<SurfaceHit> hit = shown_->surface.hit(projection.eye, projection.rayAt(at));
    if (!hit) continue;
    if (!curve_) {
      layer_ = state.layer;
      curve_.emplace();
      curve_hits_.clear();
    }
    const glm::vec3 rest = shown_->surface.restAt(hit->triangle, hit->barycentric);
    const auto last = [&] { return glm::vec3(curve_->back()[0], curve_->back()[1], curve_->back()[2]); };
    if (curve_->empty() || glm::distance(last(), rest) >= step) {
      curve_->push_back({double{rest.x}, double{rest.y}, double{rest.z}});
      curve_hits_.push_back(*hit);
    }
  }
  if (!curve_ || pen.down) return;
  if (curve_->size() >= 2 && state.layer == layer_)
    state.edit("Draw guide", [&](pipeline::LayerRecipe& layer) {
      auto* old = std::get_if<pipeline::DirectionGuides>(&layer.direction);
      pipeline::DirectionGuides guides = old && old->lines.empty() ? *old : pipeline::DirectionGuides{};
      guides.curves.push_back(*curve_);
      layer.direction = guides;
    });
  session.document.endGesture();
  curve_.reset();
}

void PaintTool::drawGuides(const State& state, const preview::PosedFrame& frame,
                           const Projection& projection) {
  const uint32_t index = state.documentLayer();
  if (!shown_ || !state.session.editable() || index == pipeline::kNoIndex) return;
  const auto* guides =
      std::get_if<pipeline::DirectionGuides>(&state.session.document.recipe().layers[index].direction);
  ImDrawList* list = ImGui::GetWindowDrawList();
  const auto draw = [&](const std::vector<SurfaceHit>& hits, ImU32 color) {
    std::vector<ImVec2> line;
    for (const SurfaceHit& hit : hits) {
      ImVec2 at;
      if (projection.toScreen(shown_->surface.at(hit.triangle, hit.barycentric), at)) line.push_back(at);
    }
    if (line.size() < 2) return;
    list->AddPolyline(line.data(), static_cast<int>(line.size()), IM_COL32(0, 0, 0, 150), 0, 4.5f);
    list->AddPolyline(line.data(), static_cast<int>(line.size()), color, 0, 2.2f);
  };
  if (guides || curve_) shown_->surface.pose(frame.input);
  if (guides) {
    if (guides->curves != guide_curves_) {
      guide_hits_.clear();
      for (const auto& curve : guides->curves) {
        std::vector<SurfaceHit>& hits = guide_hits_.emplace_back();
        for (const std::array<double, 3>& p : curve)
          hits.push_back(shown_->surface.nearestAtRest(glm::vec3(p[0], p[1], p[2])));
      }
      guide_curves_ = guides->curves;
    }
    for (const std::vector<SurfaceHit>& hits : guide_hits_) draw(hits, IM_COL32(120, 220, 190, 255));
  } else {
    guide_hits_.clear();
    guide_curves_.clear();
  }
  if (curve_) draw(curve_hits_, Colors::kAccent);
}

}  // namespace furrow::editor::ui
