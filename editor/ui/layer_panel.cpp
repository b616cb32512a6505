#include "editor/ui/layer_panel.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "editor/ui/widgets.h"
#include "pipeline/recipe/arkit.h"

namespace furrow::editor::ui {
namespace {

using pipeline::LayerRecipe;

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

void drawList(State& state) {
  Session& session = state.session;
  const pipeline::Recipe& recipe = session.document.recipe();
  const uint32_t selected = state.documentLayer();
  const auto rows = static_cast<float>(std::clamp<size_t>(recipe.layers.size(), 3, 9));
  const float padding = 0.4f * em();
  ImGui::TextDisabled("Layers");
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
        "to "
        "reorder; the order is that of the asset's weights");
    if (ImGui::IsItemActive() && !ImGui::IsItemHovered()) dragged = l;
  }
  // The row under the pointer takes the dragged layer.
  if (dragged < recipe.layers.size()) {
    const float y = ImGui::GetMousePos().y, row = ImGui::GetTextLineHeightWithSpacing();
    const float top = ImGui::GetWindowPos().y + padding - ImGui::GetScrollY();
    const auto target = static_cast<size_t>(
        std::clamp((y - top) / row, 0.0f, static_cast<float>(recipe.layers.size()) - 0.5f));
    if (target != dragged) moveLayer(session, dragged, target);
  }
  ImGui::EndChild();

  const bool some = selected != pipeline::kNoIndex;
  if (button("layer.add", "Add",
             "Add a layer over everything, with directions from the animation (1 to 16 layers)",
             recipe.layers.size() < kMaxLayers)) {
    Content content = session.document.content();
    LayerRecipe layer;
    layer.name = unusedName(recipe, "wrinkles");
    state.layer = layer.name;
    content.recipe.layers.push_back(layer);
    session.document.apply(std::move(content), "Add layer");
    session.document.endGesture();
    return;
  }
  ImGui::SameLine();
  if (button("layer.copy", "Copy", "Add a layer like the selected one",
             some && recipe.layers.size() < kMaxLayers)) {
    Content content = session.document.content();
    LayerRecipe layer = content.recipe.layers[selected];
    layer.name = unusedName(recipe, layer.name);
    state.layer = layer.name;
    content.recipe.layers.insert(content.recipe.layers.begin() + selected + 1, layer);
    session.document.apply(std::move(content), "Copy layer");
    session.document.endGesture();
    return;
  }
  ImGui::SameLine();
  if (button("layer.remove", "Remove", "Remove the selected layer; a recipe keeps at least one",
             some && recipe.layers.size() > 1)) {
    Content content = session.document.content();
    content.recipe.layers.erase(content.recipe.layers.begin() + selected);
    state.layer = content.recipe.layers[std::min<size_t>(selected, content.recipe.layers.size() - 1)].name;
    session.document.apply(std::move(content), "Remove layer");
    session.document.endGesture();
    return;
  }
  ImGui::SameLine();
  if (button("layer.up", "\xe2\x96\xb2", "Move the layer up; the order is that of the asset's weights",
             some && selected > 0))
    return moveLayer(session, selected, selected - 1);
  ImGui::SameLine();
  if (button("layer.down", "\xe2\x96\xbc", "Move the layer down; the order is that of the asset's weights",
             some && selected + 1 < recipe.layers.size()))
    moveLayer(session, selected, selected + 1);
}

using Chosen = std::function<void(const std::filesystem::path&)>;

// A row with an image's name, or `none`, on a button that chooses another.
void imageRow(State& state, const std::string& id, const char* label, const std::filesystem::path& now,
              const char* none, const char* tip, Chosen chosen, float spare = 0.0f) {
  row(label);
  const float width = ImGui::CalcItemWidth() - spare;
  const std::string text =
      now.empty() ? none
                  : fitted(now.filename().string(), width - 2.0f * ImGui::GetStyle().FramePadding.x, true);
  if (button(id.c_str(), text.c_str(), tip, true, width)) {
    state.texture_chosen = std::move(chosen);
    state.dialog = Dialog::kTexture;
  }
}

// The same with a button that takes the image away.
void clearableImage(State& state, const std::string& id, const char* label, const std::filesystem::path& now,
                    const char* none, const char* tip, Chosen chosen,
                    const std::function<void(LayerRecipe&)>& clear) {
  const float gap = 4.0f, width = now.empty() ? 0.0f : 3.8f * em();
  imageRow(state, id, label, now, none, tip, std::move(chosen), now.empty() ? 0.0f : width + gap);
  if (now.empty()) return;
  ImGui::SameLine(0.0f, gap);
  if (button((id + ".clear").c_str(), "Clear", "Take it away", true, width))
    state.edit(std::string("Clear ") + label, clear);
}

constexpr const char* kChannels[] = {"r", "g", "b", "a"};

void drawResponse(State& state, const LayerRecipe& layer, const preview::PosedFrame* frame) {
  if (!section("section.response", "Response", "How a squeeze becomes a weight")) return;
  Session& session = state.session;
  const Response* shown_response = &layer.response;
  Response fitted;
  std::vector<float> stretches;
  if (session.shown()) {
    const uint32_t index = state.assetLayer(*session.shown());
    if (index != pipeline::kNoIndex) {
      fitted = session.shown()->view().layers[index].response;
      if (layer.fit) shown_response = &fitted;
      if (frame) {
        session.shown()->surface.pose(frame->input);
        stretches = session.shown()->surface.stretches(index, frame->input.scale);
      }
    }
  }
  drawResponsePlot(*shown_response, layer.response.curve == Curve::kOat && !layer.fit, stretches);

  bool fit = layer.fit.has_value();
  if (checkbox(
          "layer.fit", "Fit to clips", fit,
          "Work lambda and beta out from the animation, so that 95% of the layer stay at or below a weight"))
    state.edit(fit ? "Fit response" : "Keep response", [&](LayerRecipe& edited) {
      if (fit)
        edited.fit = 0.9;
      else {
        edited.fit.reset();
        edited.response = *shown_response;
      }
      edited.response.curve = Curve::kLarsson;
    });
  if (layer.fit) {
    float target = static_cast<float>(*layer.fit);
    if (slider("layer.fit_weight", "Weight at 95%", target, 0.01f, 0.99f, "%.2f",
               "The weight that 95% of the layer's area stay at or below under the clips, 0.01 to 0.99"))
      state.edit("Weight of fit", [&](LayerRecipe& edited) { edited.fit = double{target}; });
    char text[64];
    std::snprintf(text, sizeof text, "lambda %.3g, beta %.3g", static_cast<double>(fitted.lambda),
                  static_cast<double>(fitted.beta));
    row("Fitted");
    ImGui::TextDisabled("%s", text);
    return;
  }
  if (layer.response.curve == Curve::kOat) {
    ImGui::TextDisabled("Linear in the area (no lambda, no beta)");
    if (button("layer.give_curve", "Give it lambda and beta",
               "Use the curved response in place of the linear one"))
      state.edit("Curved response", [](LayerRecipe& edited) { edited.response = Response{}; });
    return;
  }
  Response response = layer.response;
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
  if (changed && stretch_follows) {
    response.stretch_beta = response.beta;
    response.stretch_lambda = std::max(response.lambda, 1.0f);
  }
  bool own = !stretch_follows;
  if (checkbox("layer.own_stretch", "Separate stretch", own,
               "Give the stretch map an onset and a steepness of its own")) {
    response.stretch_beta = own ? response.beta * 1.5f : response.beta;
    response.stretch_lambda = std::max(response.lambda, 1.0f);
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

void drawDirection(State& state, const LayerRecipe& layer) {
  if (!section("section.direction", "Direction", "Which way a squeeze raises wrinkles: across the creases"))
    return;
  constexpr const char* kNames[] = {"Animation",   "Axis",        "Attribute", "Painted / flow image",
                                    "Wrinkle map", "Guide curves"};
  const size_t now = std::holds_alternative<pipeline::DirectionAnimation>(layer.direction)   ? 0
                     : std::holds_alternative<pipeline::DirectionAxis>(layer.direction)      ? 1
                     : std::holds_alternative<pipeline::DirectionAttribute>(layer.direction) ? 2
                     : std::holds_alternative<pipeline::DirectionTexture>(layer.direction)   ? 3
                     : std::holds_alternative<pipeline::DirectionMap>(layer.direction)       ? 4
                                                                                             : 5;
  int index = static_cast<int>(now);
  if (choice(
          "layer.direction", "From", index, kNames,
          "Where the direction comes from: the squeeze of all clips and morph targets, one axis, a vertex "
          "attribute, an image combed with the comb tool, the layer's own wrinkle map, or curves drawn with "
          "the guide tool along the creases")) {
    if (index == 3 || index == 5) {
      state.tool = index == 3 ? Tool::kComb : Tool::kGuide;  // there is none until something is drawn
    } else {
      state.edit("Direction of " + layer.name, [&](LayerRecipe& edited) {
        if (index == 0) edited.direction = pipeline::DirectionAnimation{};
        if (index == 1) edited.direction = pipeline::DirectionAxis{{0, 1, 0}};
        if (index == 2) edited.direction = pipeline::DirectionAttribute{"_DIRECTION"};
        if (index == 4) edited.direction = pipeline::DirectionMap{};
      });
    }
  }
  if (const auto* axis = std::get_if<pipeline::DirectionAxis>(&layer.direction)) {
    std::array<double, 3> v = axis->axis;
    row("Axis x y z");
    const bool used =
        ImGui::InputScalarN("##layer.axis", ImGuiDataType_Double, v.data(), 3, nullptr, nullptr, "%.2f");
    mark("layer.axis");
    tooltip("Direction across the creases in the scene root's space; any length but 0");
    if (used && std::hypot(v[0], v[1], v[2]) > 1e-6)
      state.edit("Axis of " + layer.name,
                 [&](LayerRecipe& edited) { edited.direction = pipeline::DirectionAxis{v}; });
  } else if (const auto* attribute = std::get_if<pipeline::DirectionAttribute>(&layer.direction)) {
    std::string name = attribute->name;
    if (field("layer.direction_attribute", "Attribute", name,
              "Name of a vertex attribute of 3 components that holds the direction") &&
        !name.empty())
      state.edit("Direction of " + layer.name,
                 [&](LayerRecipe& edited) { edited.direction = pipeline::DirectionAttribute{name}; });
  } else if (const auto* texture = std::get_if<pipeline::DirectionTexture>(&layer.direction)) {
    imageRow(
        state, "layer.direction_image", "Image", texture->texture, "",
        "The flow map: red and green hold the direction across the creases. Comb it with the comb tool, or "
        "choose another",
        [&state](const std::filesystem::path& file) {
          state.edit("Flow map",
                     [&](LayerRecipe& edited) { edited.direction = pipeline::DirectionTexture{file}; });
        });
  } else if (const auto* guides = std::get_if<pipeline::DirectionGuides>(&layer.direction)) {
    row("Curves");
    if (guides->lines.empty())
      ImGui::TextDisabled("%zu drawn", guides->curves.size());
    else
      ImGui::TextDisabled("lines \"%s\"", guides->lines.c_str());
  }
  constexpr const char* kMeasures[] = {"Directional", "Area", "Principal", "None (scripted)"};
  int measure = static_cast<int>(layer.measure);
  if (choice("layer.measure", "Measure", measure, kMeasures,
             "How squeeze is measured: along the direction, by area, by the smallest stretch in any "
             "direction, or "
             "not at all (only drivers and the game move the layer)"))
    state.edit("Measure of " + layer.name,
               [&](LayerRecipe& edited) { edited.measure = static_cast<Measure>(measure); });
}

void drawReach(State& state, const LayerRecipe& layer) {
  if (!section("section.reach", "Mask and bias", "Where the layer reaches, and what is wrinkled at rest"))
    return;
  constexpr const char* kMasks[] = {"Automatic", "Whole surface", "Painted / image", "Attribute"};
  int index = static_cast<int>(layer.mask.index());
  if (choice(
          "layer.mask", "Mask", index, kMasks,
          "How far the layer reaches: faded to where the clips squeeze it, everywhere, painted with the mask "
          "tool, or a vertex attribute")) {
    if (index == 2)
      state.tool = Tool::kMask;
    else
      state.edit("Mask of " + layer.name, [&](LayerRecipe& edited) {
        if (index == 0) edited.mask = pipeline::MaskAuto{};
        if (index == 1) edited.mask = pipeline::MaskNone{};
        if (index == 3) edited.mask = pipeline::MaskAttribute{"COLOR_0", 0};
      });
  }
  if (const auto* texture = std::get_if<pipeline::MaskTexture>(&layer.mask)) {
    int channel = static_cast<int>(texture->channel);
    imageRow(state, "layer.mask_image", "  Image", texture->texture, "",
             "The mask: white is where the layer reaches. Paint it with the mask tool, or choose another",
             [&state](const std::filesystem::path& file) {
               state.edit("Mask", [&](LayerRecipe& edited) { edited.mask = pipeline::MaskTexture{file, 0}; });
             });
    if (choice("layer.mask_channel", "  Channel", channel, kChannels, "Channel of the image: r, g, b or a"))
      state.edit("Mask of " + layer.name, [&](LayerRecipe& edited) {
        std::get<pipeline::MaskTexture>(edited.mask).channel = static_cast<uint32_t>(channel);
      });
  } else if (const auto* attribute = std::get_if<pipeline::MaskAttribute>(&layer.mask)) {
    std::string name = attribute->name;
    int channel = static_cast<int>(attribute->channel);
    if (field("layer.mask_attribute", "  Attribute", name, "Name of the vertex attribute, such as COLOR_0") &&
        !name.empty())
      state.edit("Mask of " + layer.name, [&](LayerRecipe& edited) {
        edited.mask = pipeline::MaskAttribute{name, static_cast<uint32_t>(channel)};
      });
    if (choice("layer.mask_channel", "  Channel", channel, kChannels,
               "Channel of the attribute: r, g, b or a"))
      state.edit("Mask of " + layer.name, [&](LayerRecipe& edited) {
        edited.mask = pipeline::MaskAttribute{name, static_cast<uint32_t>(channel)};
      });
  }
  // A vertex attribute is named in the recipe.
  const std::filesystem::path bias = !layer.bias ? std::filesystem::path()
                                     : layer.bias->texture.empty()
                                         ? std::filesystem::path(layer.bias->attribute)
                                         : layer.bias->texture;
  clearableImage(
      state, "layer.bias", "Rest bias", bias, "None: choose ...",
      "What is wrinkled at rest: black never, mid grey as it is squeezed, white always. Paint it with the "
      "bias "
      "tool, or choose an image",
      [&state](const std::filesystem::path& file) {
        state.edit("Rest bias", [&](LayerRecipe& edited) { edited.bias = pipeline::Bias{{}, 0, 0.5, file}; });
      },
      [](LayerRecipe& edited) { edited.bias.reset(); });
}

std::string mapPrefix(bool stretch) {
  return stretch ? "stretch" : "compress";
}

void setMap(State& state, const LayerRecipe& layer, bool stretch, const std::string& what,
            const pipeline::Map& value) {
  state.edit(what + " of " + layer.name,
             [&](LayerRecipe& edited) { (stretch ? edited.stretch : edited.compress) = value; });
}

// `unit`: the diagonal of the character, to which the ranges of lengths belong.
void drawSynthesis(State& state, const LayerRecipe& layer, bool stretch, float unit,
                   const pipeline::MapSynthesized& made) {
  const std::string prefix = mapPrefix(stretch);
  pipeline::MapSynthesized next = made;
  const auto set = [&](const std::string& what) { setMap(state, layer, stretch, what, next); };
  constexpr const char* kPresets[] = {"Automatic", "Skin", "Skin, fine", "Cloth", "Cloth, puckers"};
  int preset = next.preset ? 1 + static_cast<int>(*next.preset) : 0;
  if (choice((prefix + ".preset").c_str(), "Preset", preset, kPresets,
             "Narrow valleys, fine lines, round folds or short bulges; automatic: skin if morph targets "
             "squeeze the layer, cloth if only joints do")) {
    next.preset.reset();
    if (preset > 0) next.preset = static_cast<pipeline::Preset>(preset - 1);
    set("Preset");
  }
  // What the cook worked out is where the slider begins.
  const pipeline::MapSynthesized* resolved = nullptr;
  for (const LayerRecipe& other : state.session.resolved().layers)
    if (other.name == layer.name)
      resolved = std::get_if<pipeline::MapSynthesized>(stretch ? &other.stretch : &other.compress);
  const auto length = [&](const char* id, const char* label, double& value, double worked_out, float low,
                          float high, const char* tip) {
    float shown = static_cast<float>(value > 0.0 ? value : worked_out);
    if (slider((prefix + id).c_str(), label, shown, low * unit, high * unit,
               value > 0.0 ? "%.4g" : "%.4g (auto)", tip, ImGuiSliderFlags_Logarithmic)) {
      value = double{shown};
      set(label);
    }
    if (ImGui::IsItemClicked(ImGuiMouseButton_Right) && value > 0.0) {
      value = 0.0;
      set(label);
    }
  };
  length(".spacing", "Spacing", next.spacing, resolved ? resolved->spacing : 0.0, 0.002f, 0.2f,
         "From ridge to ridge, in the file's unit of length, 0.2% to 20% of the character's size. Right "
         "click: automatic");
  length(".depth", "Depth", next.depth, resolved ? resolved->depth : 0.0, 0.0001f, 0.05f,
         "From valley to ridge, in the file's unit of length, 0.01% to 5% of the character's size. Right "
         "click: automatic");
  int seed = static_cast<int>(next.seed);
  if (integer((prefix + ".seed").c_str(), "Seed", seed, 0, 999999,
              "Another number gives another pattern, 0 to 999999")) {
    next.seed = static_cast<uint32_t>(seed);
    set("Seed");
  }
}

// `unit`: as drawSynthesis() takes it.
void drawMap(State& state, const LayerRecipe& layer, bool stretch, float unit) {
  const std::string prefix = mapPrefix(stretch);
  const pipeline::Map& map = stretch ? layer.stretch : layer.compress;
  if (!section(("section." + prefix).c_str(), stretch ? "Stretch map" : "Compress map",
               stretch ? "The wrinkles where the surface is stretched"
                       : "The wrinkles where the surface is squeezed",
               !stretch))
    return;
  const auto set = [&](const std::string& what, const pipeline::Map& value) {
    setMap(state, layer, stretch, what, value);
  };
  // An image for a map of the kind of `value`.
  const auto chosen = [&](const pipeline::Map& value) -> Chosen {
    return [&state, stretch, value](const std::filesystem::path& file) {
      state.edit("Map", [&](LayerRecipe& edited) {
        pipeline::Map& of = stretch ? edited.stretch : edited.compress;
        if (of.index() != value.index()) of = value;
        if (auto* normal = std::get_if<pipeline::MapNormal>(&of)) normal->texture = file;
        if (auto* height = std::get_if<pipeline::MapHeight>(&of)) height->texture = file;
      });
    };
  };
  constexpr const char* kKinds[] = {"None", "Normal map", "Height map", "Synthesised"};
  int kind = static_cast<int>(map.index());
  if (choice((prefix + ".kind").c_str(), "From", kind, kKinds,
             "A map made from the direction field, a normal or height map of yours, or none")) {
    if (kind == 0) set("Map", pipeline::MapNone{});
    if (kind == 3) set("Map", pipeline::MapSynthesized{});
    if (kind == 1 || kind == 2) {
      state.texture_chosen =
          chosen(kind == 1 ? pipeline::Map(pipeline::MapNormal{}) : pipeline::Map(pipeline::MapHeight{}));
      state.dialog = Dialog::kTexture;
    }
  }
  if (const auto* normal = std::get_if<pipeline::MapNormal>(&map)) {
    imageRow(state, prefix + ".image", "Image", normal->texture, "",
             "A tangent-space normal map of the wrinkles alone; click to choose another", chosen(map));
    constexpr const char* kGreens[] = {"Up (OpenGL)", "Down (DirectX)"};
    int green = static_cast<int>(normal->green);
    if (choice((prefix + ".green").c_str(), "Green points", green, kGreens,
               "Which way the green channel points: up as in Blender and glTF, down as in Unreal. Wrong, and "
               "ridges look like valleys")) {
      pipeline::MapNormal next = *normal;
      next.green = static_cast<pipeline::Green>(green);
      set("Green", next);
    }
  }
  if (const auto* height = std::get_if<pipeline::MapHeight>(&map)) {
    imageRow(state, prefix + ".image", "Image", height->texture, "",
             "Heights of the wrinkles, white is up; click to choose another", chosen(map));
    float depth = static_cast<float>(height->depth);
    if (slider((prefix + ".height_depth").c_str(), "Depth", depth, 0.0f, 0.05f * unit,
               depth > 0.0f ? "%.4g" : "auto",
               "From black to white, in the file's unit of length, up to 5% of the character's size; 0: "
               "automatic")) {
      pipeline::MapHeight next = *height;
      next.depth = double{depth};
      set("Depth", next);
    }
  }
  if (!std::holds_alternative<pipeline::MapNone>(map))
    clearableImage(
        state, prefix + ".shading", "Alpha shading",
        (stretch ? layer.stretch_finish : layer.compress_finish).shading.value_or(std::filesystem::path()),
        "From the relief",
        "How dark creases are by the alpha-shading method: worked out from the relief, or an image of yours; "
        "click to choose one",
        [&state, stretch](const std::filesystem::path& file) {
          state.edit("Alpha-shading map", [&](LayerRecipe& edited) {
            (stretch ? edited.stretch_finish : edited.compress_finish).shading = file;
          });
        },
        [stretch](LayerRecipe& edited) {
          (stretch ? edited.stretch_finish : edited.compress_finish).shading.reset();
        });
  if (const auto* made = std::get_if<pipeline::MapSynthesized>(&map))
    drawSynthesis(state, layer, stretch, unit, *made);
}

void drawDrivers(State& state, const LayerRecipe& layer) {
  if (!section("section.drivers", "Drivers",
               "Morph targets that raise the layer whether or not it is squeezed", false))
    return;
  std::vector<std::string> tables = pipeline::driverTables();
  tables.insert(tables.begin(), "(own list)");
  std::string table = layer.driver_table.empty() ? tables.front() : layer.driver_table;
  if (choice("drivers.table", "Ready table", table, tables,
             "A table of ARKit's face shapes for a region of the face, or a list of your own"))
    state.edit("Drivers of " + layer.name, [&](LayerRecipe& edited) {
      edited.driver_table = table == tables.front() ? std::string() : table;
      edited.drivers.clear();
    });
  if (!layer.driver_table.empty()) return;
  for (size_t d = 0; d < layer.drivers.size(); ++d) {
    const std::string id = "drivers." + layer.drivers[d].morph;
    float gain = static_cast<float>(layer.drivers[d].gain);
    ImGui::PushID(static_cast<int>(d));
    if (slider(id.c_str(), layer.drivers[d].morph.c_str(), gain, -2.0f, 2.0f, "%.2f",
               "Weight that the morph target at 1 adds to the layer, -2 to 2. Right click: remove"))
      state.edit("Gain of " + layer.drivers[d].morph,
                 [&](LayerRecipe& edited) { edited.drivers[d].gain = double{gain}; });
    const bool removed = ImGui::IsItemClicked(ImGuiMouseButton_Right);
    ImGui::PopID();
    if (removed) {
      state.edit("Remove driver", [&](LayerRecipe& edited) {
        edited.drivers.erase(edited.drivers.begin() + static_cast<std::ptrdiff_t>(d));
      });
      return;
    }
  }
  std::vector<std::string> names;
  if (state.session.shown())
    for (const Morph& morph : state.session.shown()->view().morphs)
      if (std::find(names.begin(), names.end(), morph.name) == names.end()) names.emplace_back(morph.name);
  if (names.empty()) {
    ImGui::TextDisabled("the character has no morph targets");
    return;
  }
  std::string chosen;
  if (choice("drivers.add", "Add", chosen, names, "A morph target whose weight is added to the layer's"))
    state.edit("Add driver", [&](LayerRecipe& edited) { edited.drivers.push_back({chosen}); });
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
  drawList(state);
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
  drawReach(state, layer);
  drawDirection(state, layer);
  drawMap(state, layer, false, unit);
  drawMap(state, layer, true, unit);
  drawDrivers(state, layer);
  ImGui::EndChild();
}

}  // namespace furrow::editor::ui
