#include "pipeline/recipe/recipe.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "pipeline/error.h"
#include "pipeline/recipe/recipe_schema.h"

namespace furrow::pipeline {

namespace {

using json = nlohmann::json;

// What follows reads recipes that fit recipeShape().

std::vector<std::string> strings(const json& object, const char* key) {
  return object.value(key, std::vector<std::string>{});
}

uint32_t channelOf(const json& object) {
  return static_cast<uint32_t>(std::string("rgba").find(object.value("channel", "r")));
}

template <typename Enum>
Enum named(const std::array<const char*, 4>& names, const std::string& word) {
  return static_cast<Enum>(std::ranges::find(names, word) - names.begin());
}

class Reader {
 public:
  explicit Reader(const std::filesystem::path& file) : file_(file) {}

  Recipe recipe(const json& j) const {
    Recipe recipe;
    recipe.file = std::filesystem::absolute(file_).lexically_normal();
    if (j.contains("rest")) recipe.rest = rest(j["rest"]);
    if (j.contains("weld") && j["weld"].contains("tolerance"))
      recipe.weld_tolerance = j["weld"]["tolerance"].get<double>();
    recipe.map_size = j.value("mapSize", 0u);
    recipe.preview_size = j.value("previewSize", recipe.preview_size);
    recipe.hidden = strings(j, "hidden");
    for (const json& l : j["layers"]) {
      recipe.layers.push_back(layer(l, "layers[" + std::to_string(recipe.layers.size()) + ']'));
      for (size_t i = 0; i + 1 < recipe.layers.size(); ++i)
        if (recipe.layers[i].name == recipe.layers.back().name)
          throw Error(Exit::kBadData, file_.string(),
                      "layers[" + std::to_string(recipe.layers.size() - 1) + "].name: \"" +
                          recipe.layers[i].name + "\" is also the name of layers[" + std::to_string(i) + ']',
                      "give each layer a name of its own");
    }
    return recipe;
  }

 private:
  std::filesystem::path path(const json& text) const { return pathIn(file_, text.get<std::string>()); }

  Rest rest(const json& j) const {
    if (j.is_string()) return RestBind{};
    if (j.contains("file")) return RestFile{path(j["file"])};
    if (j.contains("morphs")) return RestMorphs{j["morphs"].get<std::map<std::string, double>>()};
    const json& clip = j["clip"];
    return RestClip{clip.is_string() ? clip.get<std::string>() : clip.dump(), j.value("time", 0.0)};
  }

  Direction direction(const json& j, const std::string& at) const {
    if (j == "map") return DirectionMap{};
    if (j.is_string() || j.contains("animation")) return DirectionAnimation{};
    if (j.contains("texture")) return DirectionTexture{path(j["texture"])};
    if (j.contains("guides")) {
      const json& guides = j["guides"];
      if (guides.is_object()) return DirectionGuides{{}, guides["lines"].get<std::string>()};
      return DirectionGuides{guides.get<std::vector<std::vector<std::array<double, 3>>>>(), {}};
    }
    if (j.contains("attribute")) return DirectionAttribute{j["attribute"].get<std::string>()};
    return DirectionAxis{towards(j["axis"], at + ".axis", "give the direction across the creases")};
  }

  std::array<double, 3> towards(const json& j, const std::string& at, const char* remedy) const {
    const auto vector = j.get<std::array<double, 3>>();
    if (std::hypot(vector[0], vector[1], vector[2]) < 1e-12)
      throw Error(Exit::kBadData, file_.string(), at + ": is the zero vector, which points nowhere", remedy);
    return vector;
  }

  static Response response(const json& layer, Measure measure) {
    Response response;
    if (!layer.contains("response")) {
      if (measure == Measure::kArea) response.curve = Curve::kOat;
      return response;
    }
    const json& j = layer["response"];
    const json stretch = j.value("stretch", json::object());
    response.lambda = j.value("lambda", response.lambda);
    response.beta = j.value("beta", response.beta);
    response.stretch_lambda = stretch.value("lambda", std::max(response.lambda, 1.0f));
    response.stretch_beta = stretch.value("beta", response.beta);
    return response;
  }

  std::optional<double> fit(const json& layer, const std::string& at) const {
    if (!layer.contains("response") || !layer["response"].contains("fit")) return std::nullopt;
    if (layer["response"].size() > 1)
      throw Error(Exit::kBadData, file_.string(), at + ": \"fit\" does not go with other keys",
                  "leave out \"fit\", or lambda, beta and stretch, which it works out");
    return layer["response"]["fit"].get<double>();
  }

  Mask mask(const json& j) const {
    if (j == "none") return MaskNone{};
    if (j.is_string()) return MaskAuto{};
    if (j.contains("texture")) return MaskTexture{path(j["texture"]), channelOf(j)};
    return MaskAttribute{j["attribute"].get<std::string>(), channelOf(j)};
  }

  Map map(const json& j) const {
    if (j.is_string()) return MapNone{};
    if (j.contains("normal"))
      return MapNormal{path(j["normal"]),
                       j.value("green", "opengl") == "directx" ? Green::kDirectX : Green::kOpenGl};
    if (j.contains("height")) return MapHeight{path(j["height"]), j.value("depth", 0.0)};
    const json& s = j["synthesize"];
    MapSynthesized map;
    if (s.contains("preset")) map.preset = named<Preset>(kPresetNames, s["preset"]);
    map.spacing = s.value("spacing", 0.0);
    map.depth = s.value("depth", 0.0);
    map.seed = s.value("seed", map.seed);
    return map;
  }

  MapFinish finish(const json& map, const std::string& at) const {
    MapFinish finish;
    if (!map.is_object()) return finish;
    if (map.contains("shading") && map.contains("light"))
      throw Error(Exit::kBadData, file_.string(), at + ": has both \"shading\" and \"light\"",
                  "give one of them");
    if (map.contains("shading")) finish.shading = path(map["shading"]);
    if (map.contains("light"))
      finish.light = towards(map["light"], at + ".light", "give the direction towards the light");
    finish.limit = map.value("limit", 1.0);
    return finish;
  }

  DriverRecipe driver(const json& j, const std::string& at) const {
    DriverRecipe driver{j["morph"].get<std::string>(), j.value("gain", 1.0)};
    driver.curve = j.value("curve", driver.curve);
    for (size_t i = 1; i < driver.curve.size(); ++i)
      if (!(static_cast<float>(driver.curve[i - 1][0]) < static_cast<float>(driver.curve[i][0])))
        throw Error(Exit::kBadData, file_.string(), at + ".curve: its points are not in ascending order",
                    "sort them by their first number");
    return driver;
  }

  LayerRecipe layer(const json& j, const std::string& at) const {
    LayerRecipe layer;
    layer.name = j["name"].get<std::string>();
    layer.meshes = strings(j, "meshes");
    layer.materials = strings(j, "materials");
    if (j.contains("direction")) layer.direction = direction(j["direction"], at + ".direction");
    layer.measure = named<Measure>(kMeasureNames, j.value("measure", "directional"));
    layer.response = response(j, layer.measure);
    layer.fit = fit(j, at + ".response");
    if (j.contains("mask")) layer.mask = mask(j["mask"]);
    if (j.contains("bias")) {
      const json& bias = j["bias"];
      layer.bias = Bias{bias.value("attribute", std::string()), channelOf(bias), bias.value("neutral", 0.5)};
      if (bias.contains("texture")) layer.bias->texture = path(bias["texture"]);
    }
    if (j.contains("compress")) {
      layer.compress = map(j["compress"]);
      layer.compress_finish = finish(j["compress"], at + ".compress");
    }
    if (j.contains("stretch")) {
      layer.stretch = map(j["stretch"]);
      layer.stretch_finish = finish(j["stretch"], at + ".stretch");
    }
    const json drivers = j.value("drivers", json::array());
    if (drivers.is_string()) layer.driver_table = drivers.get<std::string>();
    for (size_t i = 0; drivers.is_array() && i < drivers.size(); ++i)
      layer.drivers.push_back(driver(drivers[i], at + ".drivers[" + std::to_string(i) + ']'));
    return layer;
  }

  const std::filesystem::path& file_;
};

Recipe recipeOf(JsonFile read, const std::filesystem::path& file) {
  Recipe recipe = Reader(file).recipe(read.value);
  recipe.files = std::move(read.files);
  return recipe;
}

}  // namespace

Recipe defaultRecipe() {
  Recipe recipe;
  recipe.layers.emplace_back().name = "wrinkles";
  return recipe;
}

Recipe readRecipe(const std::filesystem::path& file) {
  return recipeOf(readJson(file, recipeShape(), "recipe"), file);
}

Recipe parseRecipe(const std::string& text, const std::filesystem::path& file) {
  return recipeOf(parseJson(text, file, recipeShape(), "recipe"), file);
}

}  // namespace furrow::pipeline
