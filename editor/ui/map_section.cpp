#include "editor/ui/map_section.h"

#include "editor/ui/image_row.h"
#include "editor/ui/widgets.h"

namespace furrow::editor::ui {
namespace {

using pipeline::LayerRecipe;

std::string mapPrefix(bool stretch) {
  return stretch ? "stretch" : "compress";
}

void setMap(State& state, const LayerRecipe& layer, bool stretch, const std::string& what,
            const pipeline::Map& value) {
  state.edit(what + " of " + layer.name,
             [&](LayerRecipe& edited) { (stretch ? edited.stretch : edited.compress) = value; });
}

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

// What is done to a map wherever it comes from.
void drawFinish(State& state, const LayerRecipe& layer, bool stretch) {
  const std::string prefix = mapPrefix(stretch);
  const auto of = [stretch](auto& edited) -> auto& {
    return stretch ? edited.stretch_finish : edited.compress_finish;
  };
  const pipeline::MapFinish& finish = of(layer);
  clearableImage(
      state, prefix + ".shading", "Alpha shading", finish.shading.value_or(std::filesystem::path()),
      "From the relief",
      "How dark creases are by the alpha-shading method: worked out from the relief, or an image of yours; "
      "click to choose one",
      [&state, of](const std::filesystem::path& file) {
        state.edit("Alpha-shading map", [&](LayerRecipe& edited) { of(edited).shading = file; });
      },
      [of](LayerRecipe& edited) { of(edited).shading.reset(); });
  if (!finish.shading) {
    bool lit = finish.light.has_value();
    if (checkbox((prefix + ".lit").c_str(), "  Lit from", lit,
                 "Alpha shading shows the wrinkles lit from a direction, in place of dark creases"))
      state.edit("Light", [&](LayerRecipe& edited) {
        of(edited).light = lit ? std::optional(std::array<double, 3>{0, 1, 1}) : std::nullopt;
      });
    if (lit && finish.light) {
      std::array<double, 3> light = *finish.light;
      if (direction((prefix + ".light").c_str(), "  Light x y z", light,
                    "Towards the light, in the scene root's space; any length but 0"))
        state.edit("Light", [&](LayerRecipe& edited) { of(edited).light = light; });
    }
  }
  float limit = static_cast<float>(finish.limit);
  if (slider(
          (prefix + ".limit").c_str(), "Steepest", limit, 0.05f, 1.0f, limit < 1.0f ? "%.2f" : "no limit",
          "Largest x^2 + y^2 of the map's normals, 0.05 to 1; 1: no limit. Engines that normalise in z alone "
          "look right up to 0.6"))
    state.edit("Steepest normal", [&](LayerRecipe& edited) { of(edited).limit = double{limit}; });
}

}  // namespace

void drawMapSection(State& state, const LayerRecipe& layer, bool stretch, float unit) {
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
      chooseImage(state, chosen(kind == 1 ? pipeline::Map(pipeline::MapNormal{})
                                          : pipeline::Map(pipeline::MapHeight{})));
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
  if (const auto* made = std::get_if<pipeline::MapSynthesized>(&map))
    drawSynthesis(state, layer, stretch, unit, *made);
  if (!std::holds_alternative<pipeline::MapNone>(map)) drawFinish(state, layer, stretch);
}

}  // namespace furrow::editor::ui
