#include <charconv>
#include <nlohmann/json.hpp>

#include "pipeline/recipe/recipe.h"
#include "pipeline/recipe/recipe_schema.h"

namespace furrow::pipeline {
namespace {

using json = nlohmann::ordered_json;

// The shortest decimal that reads back as the same float.
json number(float value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  double decimal = 0.0;
  std::from_chars(text, end, decimal);
  return decimal;
}

class Writer {
 public:
  explicit Writer(const std::filesystem::path& folder) : folder_(folder) {}

  json recipe(const Recipe& recipe) const {
    json out = {{"rest", rest(recipe.rest)}};
    if (recipe.weld_tolerance)
      out["weld"] = {{"tolerance", number(static_cast<float>(*recipe.weld_tolerance))}};
    if (recipe.map_size != 0) out["mapSize"] = recipe.map_size;
    if (recipe.preview_size != Recipe().preview_size) out["previewSize"] = recipe.preview_size;
    if (!recipe.hidden.empty()) out["hidden"] = recipe.hidden;
    out["layers"] = json::array();
    for (const LayerRecipe& l : recipe.layers) out["layers"].push_back(layer(l));
    return out;
  }

 private:
  json rest(const Rest& rest) const {
    if (const auto* clip = std::get_if<RestClip>(&rest)) return {{"clip", clip->clip}, {"time", clip->time}};
    if (const auto* morphs = std::get_if<RestMorphs>(&rest)) return {{"morphs", morphs->weights}};
    if (const auto* other = std::get_if<RestFile>(&rest)) return {{"file", path(other->file)}};
    return "bind";
  }

  json direction(const Direction& direction) const {
    if (const auto* axis = std::get_if<DirectionAxis>(&direction)) return {{"axis", axis->axis}};
    if (const auto* attribute = std::get_if<DirectionAttribute>(&direction))
      return {{"attribute", attribute->name}};
    if (const auto* texture = std::get_if<DirectionTexture>(&direction))
      return {{"texture", path(texture->texture)}};
    if (const auto* guides = std::get_if<DirectionGuides>(&direction)) {
      if (!guides->lines.empty()) return {{"guides", {{"lines", guides->lines}}}};
      return {{"guides", guides->curves}};
    }
    return std::holds_alternative<DirectionMap>(direction) ? "map" : "animation";
  }

  static json response(const LayerRecipe& layer) {
    if (layer.fit) return {{"fit", *layer.fit}};
    const Response& r = layer.response;
    json out = {{"lambda", number(r.lambda)}, {"beta", number(r.beta)}};
    if (r.stretch_lambda != std::max(r.lambda, 1.0f) || r.stretch_beta != r.beta)
      out["stretch"] = {{"lambda", number(r.stretch_lambda)}, {"beta", number(r.stretch_beta)}};
    return out;
  }

  static std::string channel(uint32_t channel) { return std::string(1, "rgba"[channel]); }

  json path(const std::filesystem::path& file) const {
    const std::u8string text = file.lexically_proximate(folder_).generic_u8string();
    return std::string(text.begin(), text.end());
  }

  json mask(const Mask& mask) const {
    if (const auto* texture = std::get_if<MaskTexture>(&mask))
      return {{"texture", path(texture->texture)}, {"channel", channel(texture->channel)}};
    if (const auto* attribute = std::get_if<MaskAttribute>(&mask))
      return {{"attribute", attribute->name}, {"channel", channel(attribute->channel)}};
    return std::holds_alternative<MaskNone>(mask) ? "none" : "auto";
  }

  json bias(const Bias& bias) const {
    json out;
    if (bias.texture.empty())
      out["attribute"] = bias.attribute;
    else
      out["texture"] = path(bias.texture);
    out["channel"] = channel(bias.channel);
    out["neutral"] = bias.neutral;
    return out;
  }

  json map(const Map& map, const MapFinish& finish) const {
    json out;
    if (const auto* normal = std::get_if<MapNormal>(&map)) {
      out["normal"] = path(normal->texture);
      if (normal->green == Green::kDirectX) out["green"] = "directx";
    } else if (const auto* height = std::get_if<MapHeight>(&map)) {
      out["height"] = path(height->texture);
      if (height->depth > 0.0) out["depth"] = height->depth;
    } else if (const auto* synthesized = std::get_if<MapSynthesized>(&map)) {
      json& s = out["synthesize"] = json::object();
      if (synthesized->preset) s["preset"] = kPresetNames[static_cast<size_t>(*synthesized->preset)];
      if (synthesized->spacing > 0.0) s["spacing"] = synthesized->spacing;
      if (synthesized->depth > 0.0) s["depth"] = synthesized->depth;
      s["seed"] = synthesized->seed;
    } else {
      return "none";
    }
    if (finish.limit < 1.0) out["limit"] = finish.limit;
    if (finish.light) out["light"] = *finish.light;
    if (finish.shading) out["shading"] = path(*finish.shading);
    return out;
  }

  json layer(const LayerRecipe& layer) const {
    json out = {{"name", layer.name}};
    if (!layer.meshes.empty()) out["meshes"] = layer.meshes;
    if (!layer.materials.empty()) out["materials"] = layer.materials;
    out["direction"] = direction(layer.direction);
    out["measure"] = kMeasureNames[static_cast<size_t>(layer.measure)];
    if (layer.response.curve == Curve::kLarsson) out["response"] = response(layer);
    out["mask"] = mask(layer.mask);
    if (layer.bias) out["bias"] = bias(*layer.bias);
    out["compress"] = map(layer.compress, layer.compress_finish);
    out["stretch"] = map(layer.stretch, layer.stretch_finish);
    if (!layer.driver_table.empty()) out["drivers"] = layer.driver_table;
    for (const DriverRecipe& driver : layer.drivers) {
      json& written = out["drivers"].emplace_back(json{{"morph", driver.morph}, {"gain", driver.gain}});
      if (!driver.curve.empty()) written["curve"] = driver.curve;
    }
    return out;
  }

  const std::filesystem::path& folder_;
};

// A value on one line where it fits, else one entry a line.
std::string laidOut(const json& value, size_t indent) {
  constexpr size_t kColumns = 100;
  if (!value.is_structured() || value.empty()) return value.dump();
  std::vector<std::string> entries;
  size_t length = 0;
  for (const auto& [key, entry] : value.items()) {
    entries.push_back((value.is_object() ? json(key).dump() + ": " : "") + laidOut(entry, indent + 2));
    length += entries.back().size() + 2;
    if (entries.back().find('\n') != std::string::npos) length = kColumns;
  }
  const bool one_line = indent > 0 && indent + length < kColumns;
  const std::string space = one_line ? " " : '\n' + std::string(indent + 2, ' ');
  std::string text(1, value.is_object() ? '{' : '[');
  if (!one_line || value.is_object()) text += space;
  for (size_t i = 0; i < entries.size(); ++i) text += (i ? ',' + space : "") + entries[i];
  if (!one_line)
    text += '\n' + std::string(indent, ' ');
  else if (value.is_object())
    text += ' ';
  return text + (value.is_object() ? '}' : ']');
}

}  // namespace

bool isRecipeText(const std::string& text) {
  constexpr auto kReplace = json::error_handler_t::replace;
  return !text.empty() && json::parse(json(text).dump(-1, ' ', false, kReplace)) == text;
}

std::string recipeText(const Recipe& recipe, const std::filesystem::path& file) {
  const std::filesystem::path folder = std::filesystem::absolute(file).lexically_normal().parent_path();
  return laidOut(Writer(folder).recipe(recipe), 0) + '\n';
}

}  // namespace furrow::pipeline
