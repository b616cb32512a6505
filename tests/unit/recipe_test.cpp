#include "pipeline/recipe/recipe.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>

#include "pipeline/error.h"
#include "pipeline/recipe/recipe_schema.h"
#include "tests/unit/gltf_builder.h"

namespace furrow::pipeline {
namespace {

using testing::ElementsAre;

// Every key there is, each with a value that is not its default.
constexpr const char* kEverything = R"({
  // comments are allowed /* in both ways */
  "$schema": "recipe.schema.json",
  "rest": { "clip": "talk", "time": 0.5 },
  "weld": { "tolerance": 0.001 },
  "mapSize": 512,
  "previewSize": 256,
  "hidden": ["Occlusion", "lashes"],
  "layers": [
    { "name": "forehead",
      "meshes": ["Head", "Brows"], "materials": ["skin"],
      "direction": { "axis": [0, 3, 4] },
      "measure": "principal",
      "response": { "lambda": 0.5, "beta": 6, "stretch": { "lambda": 2, "beta": 3 } },
      "mask": { "texture": "map.png", "channel": "g" },
      "bias": { "attribute": "COLOR_0", "channel": "b", "neutral": 0.25 },
      "compress": { "normal": "map.png", "green": "directx", "limit": 0.6, "shading": "dark.png" },
      "stretch": { "synthesize": { "preset": "cloth", "spacing": 0.004, "depth": 0.0005, "seed": 7 }, "shading": "map.png" },
      "drivers": [ { "morph": "browInnerUp", "gain": -0.5 }, { "morph": "squint", "curve": [[0.25, 0], [1, 0.5]] } ] },
    { "name": "cheeks",
      "direction": { "attribute": "_FLOW" },
      "mask": { "attribute": "COLOR_1", "channel": "a" },
      "compress": { "height": "map.png", "depth": 0.25, "light": [0, 6, 8] },
      "stretch": "none" },
    { "name": "neck", "direction": { "animation": {} }, "mask": "none", "response": { "fit": 0.75 } },
    { "name": "chin", "direction": { "texture": "map.png" }, "bias": { "texture": "dark.png", "neutral": 0.75 } },
    { "name": "ear", "direction": "map", "compress": { "normal": "map.png" } },
    { "name": "brow", "direction": { "guides": [[[0, 1, 2], [3, 4, 5], [6, 7, 8]], [[1, 1, 1], [2, 2, 2]]] } },
    { "name": "lip", "direction": { "guides": { "lines": "Creases" } } }
  ]
})";

class RecipeTest : public testing::Test {
 protected:
  RecipeTest() {
    for (const char* image : {"map.png", "dark.png"}) std::ofstream(folder_ / image) << "only has to exist";
  }

  std::filesystem::path file() const { return folder_ / "recipe.json"; }

  Recipe read(const std::string& text) const {
    std::ofstream(file(), std::ios::binary) << text;
    return readRecipe(file());
  }

  // What the tools print, without the recipe's own path.
  std::string errorOf(const std::string& text) const {
    try {
      read(text);
    } catch (const Error& error) {
      EXPECT_EQ(error.exit(), Exit::kBadData);
      std::string what = error.what(), prefix = file().string() + ": ";
      EXPECT_EQ(what.substr(0, prefix.size()), prefix);
      EXPECT_EQ(what.find('\n'), std::string::npos);
      return what.substr(prefix.size());
    }
    return "no error";
  }

  std::string layerError(const std::string& keys) const {
    return errorOf(R"({"layers": [{"name": "a", )" + keys + "}]}");
  }
  LayerRecipe layer(const std::string& keys) const {
    return read(R"({"layers": [{"name": "a")" + (keys.empty() ? "" : ", " + keys) + "}]}").layers.at(0);
  }

  const test::ScratchFolder scratch_;
  const std::filesystem::path folder_ = scratch_.path();
};

TEST_F(RecipeTest, ReadsEveryKey) {
  Recipe recipe = read(kEverything);
  EXPECT_EQ(recipe.file, file());
  const RestClip& rest = std::get<RestClip>(recipe.rest);
  EXPECT_EQ(rest.clip, "talk");
  EXPECT_EQ(rest.time, 0.5);
  EXPECT_EQ(recipe.weld_tolerance, 0.001);
  EXPECT_EQ(recipe.map_size, 512u);
  EXPECT_EQ(recipe.preview_size, 256u);
  EXPECT_THAT(recipe.hidden, ElementsAre("Occlusion", "lashes"));
  ASSERT_EQ(recipe.layers.size(), 7u);

  const LayerRecipe& a = recipe.layers[0];
  EXPECT_EQ(a.name, "forehead");
  EXPECT_THAT(a.meshes, ElementsAre("Head", "Brows"));
  EXPECT_THAT(a.materials, ElementsAre("skin"));
  EXPECT_THAT(std::get<DirectionAxis>(a.direction).axis, ElementsAre(0.0, 3.0, 4.0));
  EXPECT_EQ(a.measure, Measure::kPrincipal);
  EXPECT_EQ(a.response.curve, Curve::kLarsson);
  EXPECT_EQ(a.response.lambda, 0.5f);
  EXPECT_EQ(a.response.beta, 6.0f);
  EXPECT_EQ(a.response.stretch_lambda, 2.0f);
  EXPECT_EQ(a.response.stretch_beta, 3.0f);
  EXPECT_EQ(std::get<MaskTexture>(a.mask).texture, folder_ / "map.png");
  EXPECT_EQ(std::get<MaskTexture>(a.mask).channel, 1u);
  ASSERT_TRUE(a.bias.has_value());
  EXPECT_EQ(a.bias->attribute, "COLOR_0");
  EXPECT_EQ(a.bias->channel, 2u);
  EXPECT_EQ(a.bias->neutral, 0.25);
  EXPECT_EQ(std::get<MapNormal>(a.compress).texture, folder_ / "map.png");
  EXPECT_EQ(std::get<MapNormal>(a.compress).green, Green::kDirectX);
  EXPECT_EQ(a.compress_finish.shading, folder_ / "dark.png");
  EXPECT_EQ(a.compress_finish.limit, 0.6);
  EXPECT_FALSE(a.compress_finish.light);
  const MapSynthesized& map = std::get<MapSynthesized>(a.stretch);
  EXPECT_EQ(map.preset, Preset::kCloth);
  EXPECT_EQ(map.spacing, 0.004);
  EXPECT_EQ(map.depth, 0.0005);
  EXPECT_EQ(map.seed, 7u);
  EXPECT_EQ(a.stretch_finish.shading, folder_ / "map.png");
  ASSERT_EQ(a.drivers.size(), 2u);
  EXPECT_EQ(a.drivers[0].morph, "browInnerUp");
  EXPECT_EQ(a.drivers[0].gain, -0.5);
  EXPECT_EQ(a.drivers[1].gain, 1.0);
  EXPECT_TRUE(a.drivers[0].curve.empty());
  EXPECT_THAT(a.drivers[1].curve, ElementsAre(ElementsAre(0.25, 0.0), ElementsAre(1.0, 0.5)));

  const LayerRecipe& b = recipe.layers[1];
  EXPECT_EQ(std::get<DirectionAttribute>(b.direction).name, "_FLOW");
  EXPECT_EQ(std::get<MaskAttribute>(b.mask).name, "COLOR_1");
  EXPECT_EQ(std::get<MaskAttribute>(b.mask).channel, 3u);
  EXPECT_EQ(std::get<MapHeight>(b.compress).texture, folder_ / "map.png");
  EXPECT_EQ(std::get<MapHeight>(b.compress).depth, 0.25);
  ASSERT_TRUE(b.compress_finish.light);
  EXPECT_THAT(*b.compress_finish.light, ElementsAre(0.0, 6.0, 8.0));
  EXPECT_EQ(b.compress_finish.limit, 1.0);
  EXPECT_TRUE(std::holds_alternative<MapNone>(b.stretch));
  EXPECT_TRUE(std::holds_alternative<DirectionAnimation>(recipe.layers[2].direction));
  EXPECT_TRUE(std::holds_alternative<MaskNone>(recipe.layers[2].mask));
  EXPECT_EQ(recipe.layers[2].fit, 0.75);
  EXPECT_EQ(std::get<DirectionTexture>(recipe.layers[3].direction).texture, folder_ / "map.png");
  EXPECT_TRUE(std::holds_alternative<DirectionMap>(recipe.layers[4].direction));
  const DirectionGuides& curves = std::get<DirectionGuides>(recipe.layers[5].direction);
  ASSERT_EQ(curves.curves.size(), 2u);
  EXPECT_THAT(curves.curves[0],
              ElementsAre(ElementsAre(0, 1, 2), ElementsAre(3, 4, 5), ElementsAre(6, 7, 8)));
  EXPECT_EQ(curves.lines, "");
  EXPECT_EQ(std::get<DirectionGuides>(recipe.layers[6].direction).lines, "Creases");
}

// A key that the table has and the reader forgot would not be in kEverything either.
void collectKeys(const JsonShape& shape, std::set<std::string>& names) {
  for (const JsonKey& key : shape.keys) {
    names.insert(key.name);
    collectKeys(key.shape, names);
  }
  for (const JsonShape& inner : shape.inner) collectKeys(inner, names);
}

std::set<std::string> keysOf(const std::string& recipe) {
  std::set<std::string> used;
  auto walk = [&](auto& self, const nlohmann::json& value) -> void {
    for (const auto& [name, item] : value.items()) {
      if (value.is_object()) used.insert(name);
      if (item.is_structured()) self(self, item);
    }
  };
  walk(walk, nlohmann::json::parse(recipe, nullptr, true, true));
  return used;
}

TEST_F(RecipeTest, TheTestAboveHasEveryKeyOfTheTable) {
  std::set<std::string> names, used = keysOf(kEverything);
  collectKeys(recipeShape(), names);
  used.insert({"morphs", "file"});  // ReadsTheOtherFormsOfRest
  EXPECT_EQ(used, names);
}

TEST_F(RecipeTest, WritesEveryKey) {
  const std::string written = recipeText(read(kEverything), file());
  EXPECT_EQ(recipeText(read(written), file()), written);
  std::set<std::string> keys = keysOf(kEverything);
  keys.erase("$schema");
  keys.erase("animation");  // as a word
  EXPECT_EQ(keysOf(written), keys);
  EXPECT_NE(written.find(R"("bias": { "attribute": "COLOR_0", "channel": "b", "neutral": 0.25 })"),
            std::string::npos)
      << written;
  std::filesystem::create_directory(folder_ / "sub");
  EXPECT_NE(recipeText(read(kEverything), folder_ / "sub" / "recipe.json").find("\"../map.png\""),
            std::string::npos);
}

TEST_F(RecipeTest, DriversMayBeATable) {
  const LayerRecipe read_layer = layer(R"("drivers": "arkit:crowsFeetLeft")");
  EXPECT_EQ(read_layer.driver_table, "arkit:crowsFeetLeft");
  EXPECT_TRUE(read_layer.drivers.empty());
  EXPECT_THAT(layerError(R"("drivers": "arkit:ear")"), testing::HasSubstr("give \"arkit:forehead\", "));
  EXPECT_EQ(
      layerError(R"("drivers": [{"morph": "m", "curve": [[0, 0], [0, 1]]}])"),
      "layers[0].drivers[0].curve: its points are not in ascending order: sort them by their first number");
  EXPECT_EQ(layerError(R"("drivers": [{"morph": "m", "curve": [[0, 0, 1]]}])"),
            "layers[0].drivers[0].curve[0]: is a list of 3: give a point [in, out], two numbers from "
            "-100 to 100");
}

TEST_F(RecipeTest, AFitStandsAlone) {
  EXPECT_EQ(layerError(R"("response": {"fit": 0.9, "beta": 4})"),
            "layers[0].response: \"fit\" does not go with other keys: leave out \"fit\", or lambda, beta and "
            "stretch, which it works out");
  EXPECT_EQ(layerError(R"("response": {"fit": 1})"),
            "layers[0].response.fit: is 1: give a number from 0.01 to 0.99");
  EXPECT_FALSE(layer("").fit);
}

// What is committed as docs/`name`; FURROW_UPDATE=1 in the environment writes what `current` makes of it.
template <typename Current>
void expectCurrent(const char* name, const Current& current) {
  const std::filesystem::path file = std::filesystem::path(FURROW_SOURCE_DIR) / "docs" / name;
  std::ifstream stream(file, std::ios::binary);
  const std::string committed{std::istreambuf_iterator<char>(stream), {}}, wanted = current(committed);
  if (std::getenv("FURROW_UPDATE") != nullptr)
    std::ofstream(file, std::ios::binary) << wanted;
  else
    EXPECT_EQ(committed, wanted) << "run this test with FURROW_UPDATE=1 and commit " << file;
}

TEST_F(RecipeTest, TheCommittedSchemasAreThoseOfTheParser) {
  expectCurrent("recipe.schema.json",
                [](const std::string&) { return schemaText(recipeShape(), "furrow recipe"); });
  expectCurrent("manifest.schema.json",
                [](const std::string&) { return schemaText(manifestShape(), "furrow manifest"); });
}

TEST_F(RecipeTest, TheTablesOfTheDocumentationAreThoseOfTheParser) {
  expectCurrent("recipe.md", [](const std::string& committed) {
    const size_t begin = committed.find("-->\n", committed.find("<!-- tables")) + 4,
                 end = committed.find("<!-- end of the tables");
    EXPECT_LE(begin, end);
    return committed.substr(0, begin) + '\n' + recipeTablesText() + '\n' + committed.substr(end);
  });
}

TEST_F(RecipeTest, OnlyTheNameIsRequiredOfALayer) {
  LayerRecipe read_layer = layer(""), standard = defaultRecipe().layers.at(0);
  EXPECT_EQ(standard.name, "wrinkles");
  for (const LayerRecipe& l : {read_layer, standard}) {
    EXPECT_TRUE(l.meshes.empty() && l.materials.empty() && l.drivers.empty());
    EXPECT_TRUE(std::holds_alternative<DirectionAnimation>(l.direction));
    EXPECT_EQ(l.measure, Measure::kDirectional);
    EXPECT_EQ(l.response.curve, Curve::kLarsson);
    EXPECT_EQ(l.response.lambda, 1.0f);
    EXPECT_EQ(l.response.beta, 4.0f);
    EXPECT_EQ(l.response.stretch_lambda, 1.0f);
    EXPECT_EQ(l.response.stretch_beta, 4.0f);
    EXPECT_TRUE(std::holds_alternative<MaskAuto>(l.mask));
    EXPECT_FALSE(l.bias);
    ASSERT_TRUE(std::holds_alternative<MapSynthesized>(l.compress));
    EXPECT_FALSE(std::get<MapSynthesized>(l.compress).preset);
    EXPECT_TRUE(std::holds_alternative<MapNone>(l.stretch));
  }
}

TEST_F(RecipeTest, ReadsTheOtherFormsOfRest) {
  EXPECT_TRUE(std::holds_alternative<RestBind>(read(R"({"rest": "bind", "layers": [{"name": "a"}]})").rest));
  EXPECT_EQ(std::get<RestClip>(read(R"({"rest": {"clip": 2}, "layers": [{"name": "a"}]})").rest).clip, "2");
  Recipe recipe = read(R"({"rest": {"morphs": {"jawOpen": 0.1, "smile": -1}}, "layers": [{"name": "a"}]})");
  EXPECT_THAT(std::get<RestMorphs>(recipe.rest).weights,
              ElementsAre(testing::Pair("jawOpen", 0.1), testing::Pair("smile", -1.0)));
  recipe = read(R"({"rest": {"file": "map.png"}, "layers": [{"name": "a"}]})");
  EXPECT_EQ(std::get<RestFile>(recipe.rest).file, folder_ / "map.png");
  EXPECT_EQ(std::get<RestFile>(read(recipeText(recipe, file())).rest).file, folder_ / "map.png");
}

TEST_F(RecipeTest, TheStretchResponseFollowsTheCompressResponse) {
  Response late = layer(R"("response": {"lambda": 1.5, "beta": 8})").response;
  EXPECT_EQ(late.stretch_lambda, 1.5f);
  EXPECT_EQ(late.stretch_beta, 8.0f);
  Response early = layer(R"("response": {"lambda": 0.5, "stretch": {"beta": 2}})").response;
  EXPECT_EQ(early.stretch_lambda, 1.0f);
  EXPECT_EQ(early.stretch_beta, 2.0f);
}

TEST_F(RecipeTest, AreaIsOatsUnlessAResponseIsGiven) {
  EXPECT_EQ(layer(R"("measure": "area")").response.curve, Curve::kOat);
  EXPECT_EQ(layer(R"("measure": "area", "response": {"beta": 2})").response.curve, Curve::kLarsson);
}

TEST_F(RecipeTest, SyntaxErrorsSayWhere) {
  EXPECT_THAT(errorOf("{\n  \"layers\": [\n    { \"name\" \"a\" }\n  ]\n}"),
              testing::StartsWith("line 3, column 16: syntax error while parsing object separator"));
  EXPECT_THAT(errorOf(""), testing::StartsWith("line 1, column 1: "));
  EXPECT_THAT(errorOf("{\"layers\": [\n{\"name\": \"a\", \"response\": {\"beta\": 1e999}}]}"),
              testing::AllOf(testing::StartsWith("line 2, column 40: "), testing::HasSubstr("1e999")));
  EXPECT_EQ(errorOf("{\"layers\": [{\"name\": \"a\"},\n ]}"),
            "line 2, column 2: nothing follows the comma before ]: take the comma out");
  EXPECT_EQ(errorOf("{\"layers\": [{\"name\": \"a\", }]}"),
            "line 1, column 27: nothing follows the comma before }: take the comma out");
  EXPECT_THAT(layerError(R"("compress": {"height": "maps\map.png"})"),
              testing::EndsWith(": write paths with /"));
  EXPECT_EQ(errorOf(std::string("\xFF\xFE{\0}\0", 6)), "line 1, column 1: it is UTF-16: save it as UTF-8");
  EXPECT_EQ(errorOf("{\"layers\": [{\"name\": \"\xE4\"}]}"),
            "line 1, column 24: it is not UTF-8: save it as UTF-8");
  EXPECT_THAT(errorOf(" \r\n"), testing::HasSubstr(": nothing stands in it: "));
  for (const char* bare : {"{layers: []}", "{'layers': []}"})
    EXPECT_THAT(errorOf(bare), testing::EndsWith(": put keys and texts in double quotes")) << bare;
  EXPECT_EQ(
      layerError(R"("mask": {"texture": "..\\map.png"})"),
      "layers[0].mask.texture: no such file " + (folder_ / "..\\map.png").string() + ": write paths with /");
  EXPECT_THAT(errorOf("{} {}"), testing::StartsWith("line 1, column 4: "));
  EXPECT_THAT(errorOf("{\"layers\": NaN}"), testing::StartsWith("line 1, column 12: "));
  EXPECT_THAT(errorOf("\"\xff\""), testing::StartsWith("line 1, column 2: "));
  EXPECT_THAT(errorOf("{\"a\nb\": 1}"), testing::StartsWith("line "));
  EXPECT_EQ(errorOf(std::string(100000, '[')), "is nested too deeply: a recipe nests a few levels");
  EXPECT_EQ(errorOf(R"({"layers": [{"name": "a", "name": "b"}]})"),
            "the key \"name\" stands twice in one object: keep one");
}

TEST_F(RecipeTest, UnknownKeysNameTheNearest) {
  EXPECT_EQ(errorOf(R"({"layer": []})"), "layer: no such key: did you mean \"layers\"?");
  EXPECT_EQ(layerError(R"("respones": {})"), "layers[0].respones: no such key: did you mean \"response\"?");
  EXPECT_EQ(layerError(R"("response": {"betta": 1})"),
            "layers[0].response.betta: no such key: did you mean \"beta\"?");
  EXPECT_EQ(layerError(R"("response": {"stretch": {"Lambda": 1}})"),
            "layers[0].response.stretch.Lambda: no such key: did you mean \"lambda\"?");
  EXPECT_EQ(layerError(R"("mask": {"textur": "map.png"})"),
            "layers[0].mask.textur: no such key: did you mean \"texture\"?");
  EXPECT_EQ(layerError(R"("direction": {"animation": {"clip": 1}})"),
            "layers[0].direction.animation.clip: no such key: it belongs to rest");
  EXPECT_EQ(layerError(R"("mapSize": 512)"), "layers[0].mapSize: no such key: it belongs to the top level");
  EXPECT_EQ(layerError(R"("Mapsize": 512)"),
            "layers[0].Mapsize: no such key: did you mean \"mapSize\", which belongs to the top level?");
  EXPECT_EQ(layerError(R"("beta": 3)"),
            "layers[0].beta: no such key: it belongs to layers[].response or layers[].response.stretch");
  EXPECT_EQ(
      errorOf(R"({"spacing": 1, "layers": [{"name": "a"}]})"),
      "spacing: no such key: it belongs to layers[].compress.synthesize or layers[].stretch.synthesize");
}

TEST_F(RecipeTest, WrongTypesAreNamed) {
  EXPECT_EQ(errorOf("[]"), "the recipe is a list of 0: give an object with \"layers\"");
  EXPECT_EQ(errorOf("{}"), "layers: is missing: give a list of 1 to 16 values, each an object with \"name\"");
  EXPECT_EQ(errorOf(R"({"layers": [{}]})"),
            "layers[0].name: is missing: give a name without commas, quotes or line breaks");
  EXPECT_EQ(layerError(R"("response": {"beta": "steep"})"),
            "layers[0].response.beta: is \"steep\": give a number from 0.001 to 1000");
  EXPECT_EQ(layerError(R"("meshes": "Head")"),
            "layers[0].meshes: is \"Head\": give a list of one or more values, each the name of a mesh");
  EXPECT_EQ(layerError(R"("meshes": ["Head", 1])"), "layers[0].meshes[1]: is 1: give the name of a mesh");
  EXPECT_EQ(layerError(R"("measure": "direction")"),
            "layers[0].measure: is \"direction\": give \"directional\", \"area\", \"principal\" or \"none\"");
  EXPECT_EQ(layerError(R"("mask": "atuo")"),
            "layers[0].mask: is \"atuo\": give \"auto\" or \"none\", or an object with \"texture\" or "
            "\"attribute\"");
  EXPECT_EQ(
      layerError(R"("mask": null)"),
      "layers[0].mask: is null: give \"auto\" or \"none\", or an object with \"texture\" or \"attribute\"");
  EXPECT_EQ(layerError(R"("bias": {"attribute": "COLOR_0", "channel": "x"})"),
            "layers[0].bias.channel: is \"x\": give \"r\", \"g\", \"b\" or \"a\"");
  EXPECT_EQ(layerError(R"("bias": {})"),
            "layers[0].bias: says nothing: give an object with \"texture\" or \"attribute\"");
  EXPECT_EQ(layerError(R"("drivers": [{"gain": 1}])"),
            "layers[0].drivers[0].morph: is missing: give the name of a morph target");
}

TEST_F(RecipeTest, WrongRangesAreNamed) {
  EXPECT_EQ(layerError(R"("response": {"lambda": 0})"),
            "layers[0].response.lambda: is 0: give a number from 0.001 to 1000");
  EXPECT_EQ(layerError(R"("response": {"stretch": {"beta": -1}})"),
            "layers[0].response.stretch.beta: is -1: give a number from 0.001 to 1000");
  EXPECT_EQ(layerError(R"("compress": {"synthesize": {"spacing": 0}})"),
            "layers[0].compress.synthesize.spacing: is 0: give a number above 0");
  EXPECT_EQ(layerError(R"("compress": {"height": "map.png", "depth": -0.5})"),
            "layers[0].compress.depth: is -0.5: give a number above 0");
  EXPECT_EQ(layerError(R"("compress": {"synthesize": {"seed": 1.5}})"),
            "layers[0].compress.synthesize.seed: is 1.5: give a whole number from 0 to 4294967295");
  EXPECT_EQ(layerError(R"("compress": {"synthesize": {"seed": 4294967296}})"),
            "layers[0].compress.synthesize.seed: is 4294967296: give a whole number from 0 to 4294967295");
  EXPECT_EQ(layerError(R"("drivers": [{"morph": "m", "gain": 1e300}])"),
            "layers[0].drivers[0].gain: is 1e+300: give a number from -100 to 100");
  EXPECT_EQ(layerError(R"("bias": {"attribute": "COLOR_0", "neutral": 2})"),
            "layers[0].bias.neutral: is 2: give a number from 0 to 1");
  EXPECT_EQ(layerError(R"("direction": {"axis": [1, 0]})"),
            "layers[0].direction.axis: is a list of 2: give a direction [x, y, z]");
  EXPECT_EQ(errorOf(R"({"mapSize": 0, "layers": [{"name": "a"}]})"),
            "mapSize: is 0: give a whole number from 16 to 8192");
  EXPECT_EQ(errorOf(R"({"weld": {"tolerance": -1}, "layers": [{"name": "a"}]})"),
            "weld.tolerance: is -1: give a number from 0 up");
  EXPECT_EQ(errorOf(R"({"rest": {"morphs": {"jawOpen": "a bit"}}, "layers": [{"name": "a"}]})"),
            "rest.morphs.jawOpen: is \"a bit\": give a number from -100 to 100");
  EXPECT_EQ(errorOf(R"({"rest": {"clip": -1}, "layers": [{"name": "a"}]})"),
            "rest.clip: is -1: give a whole number from 0 to 100000");
}

TEST_F(RecipeTest, TheZeroAxisIsRefused) {
  EXPECT_THAT(
      layerError(R"("direction": {"guides": [[[0, 1, 2]]]})"),
      testing::StartsWith(
          "layers[0].direction.guides[0]: is a list of 1: give a curve, which is a list of two or more "));
  EXPECT_THAT(
      layerError(R"("direction": {"guides": [[[0, 1, 2], [0, 1]]]})"),
      testing::StartsWith("layers[0].direction.guides[0][1]: is a list of 2: give a point [x, y, z]"));
  EXPECT_THAT(layerError(R"("direction": {"guides": [[[0, 1, 2], [0, 1, 1e300]]]})"),
              testing::StartsWith("layers[0].direction.guides[0][1][2]: "));
  EXPECT_THAT(layerError(R"("direction": {"guides": {}})"), testing::HasSubstr("guides.lines: is missing"));
  EXPECT_EQ(layerError(R"("direction": {"guides": {"lines": [[[0, 0, 0], [1, 0, 0]]]}})"),
            "layers[0].direction.guides.lines: is a list of 1: give the name of a mesh or node of the glTF "
            "file that "
            "holds lines; curves given as points stand in \"guides\" itself, [[[x, y, z], ...], ...]");
  EXPECT_EQ(layerError(R"("direction": {"guides": [[0, 0, 0], [1, 0, 0]]})"),
            "layers[0].direction.guides[0][0]: is 0: give a point [x, y, z]");
  EXPECT_EQ(layerError(R"("meshes": "Head")"),
            "layers[0].meshes: is \"Head\": give a list of one or more values, each the name of a mesh");
  EXPECT_THAT(layerError(R"("direction": {"texture": "gone.png"})"), testing::HasSubstr("gone.png"));
  EXPECT_EQ(layerError(R"("direction": {"axis": [0, 0, -0.0]})"),
            "layers[0].direction.axis: is the zero vector, which points nowhere: give the direction across "
            "the creases");
  EXPECT_THAT(layerError(R"("direction": {"axis": [1e-300, 0, 0]})"), testing::HasSubstr("zero vector"));
}

TEST_F(RecipeTest, FormsDoNotMix) {
  EXPECT_EQ(layerError(R"("mask": {"texture": "map.png", "attribute": "COLOR_0"})"),
            "layers[0].mask: has both \"texture\" and \"attribute\": give one of them");
  EXPECT_EQ(layerError(R"("mask": {"channel": "r"})"),
            "layers[0].mask: says nothing: give an object with \"texture\" or \"attribute\"");
  EXPECT_EQ(layerError(R"("compress": {"normal": "map.png", "depth": 1})"),
            "layers[0].compress.depth: does not go with \"normal\": it goes with \"height\"");
  EXPECT_EQ(errorOf(R"({"rest": {"morphs": {}, "time": 1}, "layers": [{"name": "a"}]})"),
            "rest.time: does not go with \"morphs\": it goes with \"clip\"");
}

TEST_F(RecipeTest, LayerNamesAreUniqueAndFitACsvHeader) {
  EXPECT_EQ(errorOf(R"({"layers": [{"name": "a"}, {"name": "b"}, {"name": "a"}]})"),
            "layers[2].name: \"a\" is also the name of layers[0]: give each layer a name of its own");
  for (const char* name : {"", "a,b", "a\\nb", "a\\\"b", "a\\u007fb"})
    EXPECT_EQ(errorOf(R"({"layers": [{"name": ")" + std::string(name) + R"("}]})"),
              "layers[0].name: is \"" + std::string(name) +
                  "\": give a name without commas, quotes or line breaks");
  EXPECT_EQ(read(R"({"layers": [{"name": "Stirn quer ü"}]})").layers[0].name, "Stirn quer ü");
}

TEST_F(RecipeTest, OneToSixteenLayers) {
  auto layers = [](int count) {
    std::string text = R"({"layers": [)";
    for (int i = 0; i < count; ++i) text += (i ? ", " : "") + (R"({"name": "l)" + std::to_string(i)) + "\"}";
    return text + "]}";
  };
  EXPECT_EQ(errorOf(layers(0)),
            "layers: is a list of 0: give a list of 1 to 16 values, each an object with \"name\"");
  EXPECT_EQ(errorOf(layers(17)),
            "layers: is a list of 17: give a list of 1 to 16 values, each an object with \"name\"");
  EXPECT_EQ(read(layers(16)).layers.size(), 16u);
}

TEST_F(RecipeTest, ImagesMustExist) {
  std::string missing = (folder_ / "gone.png").string();
  EXPECT_EQ(layerError(R"("mask": {"texture": "gone.png"})"),
            "layers[0].mask.texture: no such file " + missing + ": paths are relative to the recipe");
  EXPECT_EQ(layerError(R"("compress": {"normal": "gone.png"})"),
            "layers[0].compress.normal: no such file " + missing + ": paths are relative to the recipe");
  EXPECT_EQ(layerError(R"("stretch": {"synthesize": {}, "shading": "gone.png"})"),
            "layers[0].stretch.shading: no such file " + missing + ": paths are relative to the recipe");
  EXPECT_THAT(layerError(R"("compress": {"height": "."})"), testing::HasSubstr("no such file"));
  EXPECT_THAT(layerError(R"("compress": {"height": ""})"), testing::HasSubstr("give the path of an image"));
  EXPECT_EQ(std::get<MaskTexture>(layer(R"("mask": {"texture": "sub/../map.png"})").mask).texture,
            folder_ / "map.png");
}

TEST_F(RecipeTest, ARecipeThatCannotBeOpenedIsNamed) {
  const std::filesystem::path missing = folder_ / "no.json";
  for (const auto& [path, fault] : {std::pair{missing, ": no such file: check the path"},
                                    std::pair{folder_, ": is a directory: name a file in it"}})
    try {
      readRecipe(path);
      ADD_FAILURE() << "no error";
    } catch (const Error& error) {
      EXPECT_EQ(error.exit(), Exit::kBadData);
      EXPECT_EQ(error.what(), path.string() + fault);
    }
}

TEST_F(RecipeTest, EveryTruncationIsRefused) {
  std::string text = kEverything;
  for (size_t size = 0; size < text.size(); ++size)
    EXPECT_NE(errorOf(text.substr(0, size)), "no error") << size;
}

}  // namespace
}  // namespace furrow::pipeline
