#include "editor/ui/layer_panel.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "editor/ui/character_section.h"
#include "editor/ui/driver_section.h"
#include "editor/ui/image_row.h"
#include "editor/ui/map_section.h"
#include "editor/ui/widgets.h"

namespace furrow::editor::ui {
namespace {

using pipeline::LayerRecipe;

constexpr float kListShare = 0.34f;  // of the panel's height, that the list of layers takes at most

std::string unusedName(const pipeline::Recipe& recipe, const std::string& base) {
  for (int i = 1;; ++i) {
    const std::string name = i == 1 ? base : base + " " + std::to_string(i);
    if (std::none_of(recipe.layers.begin(), recipe.layers.end(),
                     [&](const LayerRecipe& layer) { return layer.name == name; }))
      return name;
  }
}

// A drag over several rows is one edit.
void moveLayer(Session& session, size_t from, size_t to) {
  Content content = session.document.content();
  LayerRecipe layer = std::move(content.recipe.layers[from]);
  content.recipe.layers.erase(content.recipe.layers.begin() + static_cast<std::ptrdiff_t>(from));
  content.recipe.layers.insert(content.recipe.layers.begin() + static_cast<std::ptrdiff_t>(to),
                               std::move(layer));
  session.document.apply(std::move(content), "Move layer");
}

void drawRows(State& state) {
  const pipeline::Recipe& recipe = state.session.document.recipe();
  const uint32_t selected = state.documentLayer();
  const float padding = 0.4f * em();
  const float most =
      std::max(kListShare * ImGui::GetWindowHeight() / ImGui::GetTextLineHeightWithSpacing(), 3.0f);
  const float rows =
      std::floor(std::clamp(static_cast<float>(recipe.layers.size()), 3.0f, std::min(most, 9.0f)));
  size_t dragged = recipe.layers.size();
  ImGui::PushStyleColor(ImGuiCol_ChildBg, IM_COL32(22, 23, 25, 255));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0.0f, padding});
  ImGui::BeginChild("layers", {0.0f, rows * ImGui::GetTextLineHeightWithSpacing() + 2.0f * padding}, false,
                    ImGuiWindowFlags_AlwaysUseWindowPadding | ImGuiWindowFlags_NavFlattened);
  ImGui::PopStyleVar();
  ImGui::PopStyleColor();
  for (size_t l = 0; l < recipe.layers.size(); ++l) {
    const LayerRecipe& layer = recipe.layers[l];
    const std::string id = "layer.select." + layer.name;
    if (ImGui::Selectable(("  " + layer.name + "##" + id).c_str(), l == selected)) state.layer = layer.name;
    mark(id.c_str());
    tooltip(
        "Select this layer: the panel below edits it, and the views of one layer show it. Drag it up or down "
        "to reorder; the order is that of the asset's weights");
    if (ImGui::IsItemActive() && !ImGui::IsItemHovered()) dragged = l;
  }
  // The row under the pointer takes the dragged layer.
  if (dragged < recipe.layers.size()) {
    const float y = ImGui::GetMousePos().y, row = ImGui::GetTextLineHeightWithSpacing();
    const float top = ImGui::GetWindowPos().y + padding - ImGui::GetScrollY();
    const auto target = static_cast<size_t>(
        std::clamp((y - top) / row, 0.0f, static_cast<float>(recipe.layers.size()) - 0.5f));
    if (target != dragged) moveLayer(state.session, dragged, target);
  }
  ImGui::EndChild();
}

// Puts the next button on the line of the last one if it fits there.
void beside(const char* label) {
  ImGui::SameLine();
  const float width = ImGui::CalcTextSize(label).x + 2.0f * ImGui::GetStyle().FramePadding.x;
  if (ImGui::GetContentRegionAvail().x < width) ImGui::NewLine();
}

void drawListButtons(State& state) {
  Session& session = state.session;
  const uint32_t selected = state.documentLayer();
  const size_t count = session.document.recipe().layers.size();
  const bool some = selected != pipeline::kNoIndex;
  // What an edit leaves selected is a layer of its content.
  const auto apply = [&](Content content, size_t select, const char* name) {
    state.layer = content.recipe.layers[select].name;
    session.document.apply(std::move(content), name);
    session.document.endGesture();
  };
  if (button("layer.add", "Add",
             "Add a layer over everything, with directions from the animation (1 to 16 layers)",
             count < kMaxLayers)) {
    Content content = session.document.content();
    LayerRecipe layer;
    layer.name = unusedName(content.recipe, "wrinkles");
    content.recipe.layers.push_back(std::move(layer));
    return apply(std::move(content), count, "Add layer");
  }
  beside("Copy");
  if (button("layer.copy", "Copy", "Add a layer like the selected one", some && count < kMaxLayers)) {
    Content content = session.document.content();
    LayerRecipe layer = content.recipe.layers[selected];
    layer.name = unusedName(content.recipe, layer.name);
    content.recipe.layers.insert(content.recipe.layers.begin() + selected + 1, std::move(layer));
    return apply(std::move(content), selected + 1, "Copy layer");
  }
  beside("Remove");
  if (button("layer.remove", "Remove", "Remove the selected layer; a recipe keeps at least one",
             some && count > 1)) {
    Content content = session.document.content();
    content.recipe.layers.erase(content.recipe.layers.begin() + selected);
    return apply(std::move(content), std::min<size_t>(selected, count - 2), "Remove layer");
  }
  beside("\xe2\x96\xb2");
  if (button("layer.up", "\xe2\x96\xb2", "Move the layer up; the order is that of the asset's weights",
             some && selected > 0))
    return moveLayer(session, selected, selected - 1);
  beside("\xe2\x96\xbc");
  if (button("layer.down", "\xe2\x96\xbc", "Move the layer down; the order is that of the asset's weights",
             some && selected + 1 < count))
    moveLayer(session, selected, selected + 1);
}

// Whether the selected layer has the image that strokes are painted into.
bool painted(const State& state, Painted kind) {
  const Document& document = state.session.document;
  const uint32_t layer = state.documentLayer();
  const auto [file, channel] = namedImage(document.recipe().layers[layer], kind);
  return channel == 0 && file == paintedFile(document.content(), document.file(), layer, kind);
}

bool channelRow(const std::string& id, uint32_t& channel) {
  constexpr const char* kChannels[] = {"r", "g", "b", "a"};
  int index = static_cast<int>(channel);
  if (!choice((id + "_channel").c_str(), "  Channel", index, kChannels,
              "The channel that is read: r, g, b or a"))
    return false;
  channel = static_cast<uint32_t>(index);
  return true;
}

void drawFit(State& state, const LayerRecipe& layer, const Response& fitted) {
  float target = static_cast<float>(*layer.fit);
  if (slider("layer.fit_weight", "Weight at 95%", target, 0.01f, 0.99f, "%.2f",
             "The weight that 95% of the layer's area stay at or below under the clips, 0.01 to 0.99"))
    state.edit("Weight of fit", [&](LayerRecipe& edited) { edited.fit = double{target}; });
  char text[64];
  std::snprintf(text, sizeof text, "lambda %.3g, beta %.3g", static_cast<double>(fitted.lambda),
                static_cast<double>(fitted.beta));
  row("Fitted");
  ImGui::TextDisabled("%s", text);
}

void drawCurve(State& state, const LayerRecipe& layer) {
  Response response = layer.response;
  const auto follow = [&response] {
    response.stretch_beta = response.beta;
    response.stretch_lambda = std::max(response.lambda, 1.0f);
  };
  const bool stretch_follows =
      response.stretch_beta == response.beta && response.stretch_lambda == std::max(response.lambda, 1.0f);
  bool changed =
      slider("layer.lambda", "Onset (lambda)", response.lambda, 0.1f, 10.0f, "%.3f",
             "The compression factor (length at rest / length, squared) at which wrinkles begin: below 1 at "
             "rest, 1 at the slightest squeeze, above 1 later. 0.1 to 10, no unit; Ctrl+click to type",
             ImGuiSliderFlags_Logarithmic);
  changed |=
      slider("layer.beta", "Steepness (beta)", response.beta, 0.25f, 32.0f, "%.2f",
             "How steeply wrinkles grow with the squeeze: 1 soft, 4 usual, 16 a switch. 0.25 to 32, no unit; "
             "Ctrl+click to type",
             ImGuiSliderFlags_Logarithmic);
  if (changed && stretch_follows) follow();
  bool own = !stretch_follows;
  if (checkbox("layer.own_stretch", "Separate stretch", own,
               "Give the stretch map an onset and a steepness of its own")) {
    follow();
    if (own) response.stretch_beta *= 1.5f;
    changed = true;
  }
  if (own) {
    changed |= slider("layer.stretch_lambda", "  Onset", response.stretch_lambda, 0.1f, 10.0f, "%.3f",
                      "The same for the stretch map, which sees 1 / compression factor. 0.1 to 10, no unit",
                      ImGuiSliderFlags_Logarithmic);
    changed |= slider("layer.stretch_beta", "  Steepness", response.stretch_beta, 0.25f, 32.0f, "%.2f",
                      "How steeply the stretch map comes. 0.25 to 32, no unit", ImGuiSliderFlags_Logarithmic);
  }
  if (changed)
    state.edit("Response of " + layer.name, [&](LayerRecipe& edited) { edited.response = response; });
}

void drawResponse(State& state, const LayerRecipe& layer, const preview::PosedFrame* frame) {
  if (!section("section.response", "Response", "How a squeeze becomes a weight")) return;
  Response fitted = layer.response;
  std::vector<float> stretches;
  if (Shown* shown = state.session.shown().get()) {
    const uint32_t index = state.assetLayer(*shown);
    if (index != pipeline::kNoIndex) {
      fitted = shown->view().layers[index].response;
      if (frame) {
        shown->surface.pose(frame->input);
        stretches = shown->surface.stretches(index, frame->input.scale);
      }
    }
  }
  const Response& response = layer.fit ? fitted : layer.response;
  const bool linear = layer.response.curve == Curve::kOat && !layer.fit;
  drawResponsePlot(response, linear, stretches);

  bool fit = layer.fit.has_value();
  if (checkbox(
          "layer.fit", "Fit to clips", fit,
          "Work lambda and beta out from the animation, so that 95% of the layer stay at or below a weight"))
    state.edit(fit ? "Fit response" : "Keep response", [&](LayerRecipe& edited) {
      if (fit)
        edited.fit = 0.9;
      else {
        edited.fit.reset();
        edited.response = response;
      }
      edited.response.curve = Curve::kLarsson;
    });
  if (layer.fit) {
    drawFit(state, layer, fitted);
  } else if (linear) {
    ImGui::TextDisabled("Linear in the area (no lambda, no beta)");
    if (button("layer.give_curve", "Give it lambda and beta",
               "Use the curved response in place of the linear one"))
      state.edit("Curved response", [](LayerRecipe& edited) { edited.response = Response{}; });
  } else {
    drawCurve(state, layer);
  }
}

// What a text field and a choice of channel make of a vertex attribute; true when changed.
bool attributeRows(const std::string& id, std::string& name, uint32_t& channel) {
  const bool named = field((id + "_attribute").c_str(), "  Attribute", name,
                           "Name of the vertex attribute, such as COLOR_0") &&
                     !name.empty();
  return channelRow(id, channel) || named;
}

void drawDirection(State& state, const LayerRecipe& layer) {
  if (!section("section.direction", "Direction", "Which way a squeeze raises wrinkles: across the creases"))
    return;
  const auto set = [&](const pipeline::Direction& to) {
    state.edit("Direction of " + layer.name, [&](LayerRecipe& edited) { edited.direction = to; });
  };
  const Chosen chosen = [&state](const std::filesystem::path& file) {
    state.edit("Flow map", [&](LayerRecipe& edited) { edited.direction = pipeline::DirectionTexture{file}; });
  };
  enum Kind { kAnimation, kAxis, kAttribute, kCombed, kImage, kMap, kGuides, kLines };
  constexpr const char* kNames[] = {"Animation",  "Axis",        "Attribute",    "Combed",
                                    "Flow image", "Wrinkle map", "Guide curves", "Lines in the file"};
  const auto* axis = std::get_if<pipeline::DirectionAxis>(&layer.direction);
  const auto* attribute = std::get_if<pipeline::DirectionAttribute>(&layer.direction);
  const auto* texture = std::get_if<pipeline::DirectionTexture>(&layer.direction);
  const auto* guides = std::get_if<pipeline::DirectionGuides>(&layer.direction);
  int index = axis                                                              ? kAxis
              : attribute                                                       ? kAttribute
              : texture && painted(state, Painted::kDirection)                  ? kCombed
              : texture                                                         ? kImage
              : std::holds_alternative<pipeline::DirectionMap>(layer.direction) ? kMap
              : guides ? guides->lines.empty() ? kGuides : kLines
                       : kAnimation;
  if (choice(
          "layer.direction", "From", index, kNames,
          "Where the direction comes from: the squeeze of all clips and morph targets, one axis, a vertex "
          "attribute, the comb tool, a flow image of yours, the layer's own wrinkle map, curves drawn with "
          "the guide tool along the creases, or lines in the glTF file")) {
    if (index == kAnimation) set(pipeline::DirectionAnimation{});
    if (index == kAxis) set(pipeline::DirectionAxis{{0, 1, 0}});
    if (index == kAttribute) set(pipeline::DirectionAttribute{"_DIRECTION"});
    if (index == kCombed) state.take(Tool::kComb);  // there is none until something is drawn
    if (index == kImage) chooseImage(state, chosen);
    if (index == kMap) set(pipeline::DirectionMap{});
    if (index == kGuides) state.take(Tool::kGuide);
    if (index == kLines) set(pipeline::DirectionGuides{{}, "guides"});
  }
  if (axis) {
    std::array<double, 3> v = axis->axis;
    if (direction("layer.axis", "Axis x y z", v,
                  "Direction across the creases in the scene root's space; any length but 0"))
      state.edit("Axis of " + layer.name,
                 [&](LayerRecipe& edited) { edited.direction = pipeline::DirectionAxis{v}; });
  } else if (attribute) {
    std::string name = attribute->name;
    if (field("layer.direction_attribute", "Attribute", name,
              "Name of a vertex attribute of 3 components that holds the direction") &&
        !name.empty())
      set(pipeline::DirectionAttribute{name});
  } else if (texture) {
    imageRow(state, "layer.direction_image", "Image", texture->texture, "",
             "The flow map: red and green hold the direction across the creases. Comb it with the comb tool, "
             "or choose another",
             chosen);
  } else if (guides && guides->lines.empty()) {
    row("Curves");
    ImGui::TextDisabled("%zu drawn", guides->curves.size());
  } else if (guides) {
    std::string name = guides->lines;
    if (field("layer.direction_lines", "Lines", name,
              "Name of a mesh or node of the glTF file that holds lines along the creases") &&
        !name.empty())
      set(pipeline::DirectionGuides{{}, name});
  }
  constexpr const char* kMeasures[] = {"Directional", "Area", "Principal", "None (scripted)"};
  int measure = static_cast<int>(layer.measure);
  if (choice("layer.measure", "Measure", measure, kMeasures,
             "How squeeze is measured: along the direction, by area, by the smallest stretch in any "
             "direction, or not at all (only drivers and the game move the layer)"))
    state.edit("Measure of " + layer.name,
               [&](LayerRecipe& edited) { edited.measure = static_cast<Measure>(measure); });
}

// The meshes and materials that the layer lies on: rows only where there is something to choose.
void drawSurface(State& state, const LayerRecipe& layer) {
  std::vector<std::string> meshes = layer.meshes, materials = layer.materials;
  if (state.session.shown())
    for (const Part& part : state.session.shown()->view().parts) {
      addName(meshes, part.mesh);
      addName(materials, part.material);
    }
  std::vector<std::string> chosen = layer.meshes;
  if (meshes.size() > 1 && choices("layer.meshes", "Meshes", chosen, meshes,
                                   "The meshes that the layer lies on; all, where none is chosen"))
    state.edit("Meshes of " + layer.name, [&](LayerRecipe& edited) { edited.meshes = chosen; });
  chosen = layer.materials;
  if (materials.size() > 1 && choices("layer.materials", "Materials", chosen, materials,
                                      "The materials that the layer lies on; all, where none is chosen"))
    state.edit("Materials of " + layer.name, [&](LayerRecipe& edited) { edited.materials = chosen; });
}

void drawMask(State& state, const LayerRecipe& layer) {
  const auto set = [&](const pipeline::Mask& to) {
    state.edit("Mask of " + layer.name, [&](LayerRecipe& edited) { edited.mask = to; });
  };
  const Chosen chosen = [&state](const std::filesystem::path& file) {
    state.edit("Mask", [&](LayerRecipe& edited) { edited.mask = pipeline::MaskTexture{file, 0}; });
  };
  const auto* texture = std::get_if<pipeline::MaskTexture>(&layer.mask);
  const auto* attribute = std::get_if<pipeline::MaskAttribute>(&layer.mask);
  enum Kind { kAutomatic, kWhole, kPainted, kImage, kAttribute };
  constexpr const char* kNames[] = {"Automatic", "Whole surface", "Painted", "Image", "Attribute"};
  int index = attribute                                                ? kAttribute
              : texture && painted(state, Painted::kMask)              ? kPainted
              : texture                                                ? kImage
              : std::holds_alternative<pipeline::MaskNone>(layer.mask) ? kWhole
                                                                       : kAutomatic;
  if (choice("layer.mask", "Mask", index, kNames,
             "How far the layer reaches: faded to where the clips squeeze it, everywhere, painted with the "
             "mask tool, an image of yours, or a vertex attribute")) {
    if (index == kAutomatic) set(pipeline::MaskAuto{});
    if (index == kWhole) set(pipeline::MaskNone{});
    if (index == kPainted) state.take(Tool::kMask);
    if (index == kImage) chooseImage(state, chosen);
    if (index == kAttribute) set(pipeline::MaskAttribute{"COLOR_0", 0});
  }
  if (texture && index != kPainted) {
    pipeline::MaskTexture next = *texture;
    imageRow(state, "layer.mask_image", "  Image", texture->texture, "",
             "The mask: white is where the layer reaches; click to choose another", chosen);
    if (channelRow("layer.mask", next.channel)) set(next);
  } else if (attribute) {
    pipeline::MaskAttribute next = *attribute;
    if (attributeRows("layer.mask", next.name, next.channel)) set(next);
  }
}

void drawBias(State& state, const LayerRecipe& layer) {
  const auto set = [&](const std::optional<pipeline::Bias>& to) {
    state.edit("Rest bias of " + layer.name, [&](LayerRecipe& edited) { edited.bias = to; });
  };
  const Chosen chosen = [&state](const std::filesystem::path& file) {
    state.edit("Rest bias", [&](LayerRecipe& edited) { edited.bias = pipeline::Bias{{}, 0, 0.5, file}; });
  };
  enum Kind { kNone, kPainted, kImage, kAttribute };
  constexpr const char* kNames[] = {"None", "Painted", "Image", "Attribute"};
  int index = !layer.bias                      ? kNone
              : layer.bias->texture.empty()    ? kAttribute
              : painted(state, Painted::kBias) ? kPainted
                                               : kImage;
  if (choice(
          "layer.bias", "Rest bias", index, kNames,
          "What is wrinkled at rest: nothing, what is painted with the bias tool, an image of yours (black "
          "never, mid grey as it is squeezed, white always), or a vertex attribute")) {
    if (index == kNone) set(std::nullopt);
    if (index == kPainted) state.take(Tool::kBias);
    if (index == kImage) chooseImage(state, chosen);
    if (index == kAttribute) set(pipeline::Bias{"COLOR_0", 0, 0.5, {}});
  }
  if (!layer.bias || index == kPainted) return;
  pipeline::Bias next = *layer.bias;
  bool changed = false;
  if (next.texture.empty()) {
    changed = attributeRows("layer.bias", next.attribute, next.channel);
  } else {
    imageRow(state, "layer.bias_image", "  Image", next.texture, "",
             "The bias: black never wrinkles, white always; click to choose another", chosen);
    changed = channelRow("layer.bias", next.channel);
  }
  float neutral = static_cast<float>(next.neutral);
  if (slider("layer.bias_neutral", "  Neutral", neutral, 0.0f, 1.0f, "%.3f",
             "The value that leaves the weight alone, 0 black to 1 white; painted images have 0.5")) {
    next.neutral = double{neutral};
    changed = true;
  }
  if (changed) set(next);
}

void drawAsset(State& state, const preview::PosedFrame* frame) {
  const AssetView& asset = state.session.shown()->view();
  ImGui::TextWrapped("A cooked asset: open its source, \"%s\", to edit it.",
                     std::string(asset.source).c_str());
  ImGui::Spacing();
  for (const Layer& layer : asset.layers) {
    const std::string name(layer.name), id = "layer.select." + name;
    if (ImGui::Selectable(("  " + name + "##" + id).c_str(), name == state.layer)) state.layer = name;
    mark(id.c_str());
    tooltip("Select this layer for the views of one layer");
  }
  const uint32_t index = state.assetLayer(*state.session.shown());
  if (index == pipeline::kNoIndex || !frame) return;
  if (!section("section.response", "Response", "How a squeeze becomes a weight")) return;
  state.session.shown()->surface.pose(frame->input);
  drawResponsePlot(asset.layers[index].response, false,
                   state.session.shown()->surface.stretches(index, frame->input.scale));
}

}  // namespace

void drawLayerPanel(State& state, const preview::PosedFrame* frame) {
  Session& session = state.session;
  if (session.source().empty()) {
    ImGui::TextDisabled("Nothing is open");
    return;
  }
  if (!session.editable()) {
    if (session.shown()) drawAsset(state, frame);
    return;
  }
  ImGui::TextDisabled("Layers");
  drawRows(state);
  drawListButtons(state);
  const uint32_t selected = state.documentLayer();
  if (selected == pipeline::kNoIndex) return;
  const LayerRecipe layer = session.document.recipe().layers[selected];
  ImGui::Separator();
  ImGui::BeginChild("layer", {0, 0}, false, ImGuiWindowFlags_NavFlattened);
  std::string name = layer.name;
  if (field("layer.name", "Name", name,
            "Name of the layer, unlike that of any other, without commas or quotes")) {
    const pipeline::Recipe& recipe = session.document.recipe();
    const bool bad = name.empty() || name.find_first_of(",\"") != std::string::npos ||
                     std::any_of(recipe.layers.begin(), recipe.layers.end(),
                                 [&](const LayerRecipe& other) { return other.name == name; });
    if (bad) {
      session.tell(Message::Kind::kError,
                   "\"" + name + "\": a layer needs a name of its own without commas or quotes");
    } else {
      state.edit("Rename layer", [&](LayerRecipe& edited) { edited.name = name; });
      state.layer = name;
    }
  }
  const float unit = session.shown() ? diagonalOf(session.shown()->view()) : 1.0f;
  drawResponse(state, layer, frame);
  if (section("section.reach", "Mask and bias", "Where the layer reaches, and what is wrinkled at rest")) {
    drawSurface(state, layer);
    drawMask(state, layer);
    drawBias(state, layer);
  }
  drawDirection(state, layer);
  drawMapSection(state, layer, false, unit);
  drawMapSection(state, layer, true, unit);
  drawDrivers(state, layer);
  drawCharacterSection(state, frame, unit);
  ImGui::EndChild();
}

}  // namespace furrow::editor::ui
