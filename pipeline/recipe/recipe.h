#pragma once

// What the artist asks of the cook. Recipes are JSON; docs/recipe.schema.json is their published schema and
// docs/recipe.md explains them.

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "furrow/asset.h"
#include "pipeline/maps/authored.h"
#include "pipeline/maps/synthesis.h"

namespace furrow::pipeline {

// Pose in which the surface is relaxed.
struct RestBind {};
struct RestClip {
  std::string clip;  // name or number
  double time = 0.0;
};
struct RestMorphs {
  std::map<std::string, double> weights;
};
struct RestFile {
  std::filesystem::path file;  // absolute; its vertices correspond to the source's by their order
};
using Rest = std::variant<RestBind, RestClip, RestMorphs, RestFile>;

// Source of d, which lies ACROSS the creases.
struct DirectionAnimation {};
struct DirectionAxis {
  std::array<double, 3> axis{};  // root space, any length but 0
};
struct DirectionAttribute {
  std::string name;  // a 3-component vertex attribute, in the mesh's space
};
struct DirectionTexture {
  std::filesystem::path texture;  // absolute; a flow map, see ImageKind::kFlow
};
struct DirectionMap {};   // the structure of the layer's own `compress`, a normal or height map
struct DirectionGuides {  // ALONG the creases
  std::vector<std::vector<std::array<double, 3>>>
      curves;         // poly-lines of 2 or more points in root space at rest
  std::string lines;  // or, if not empty, a mesh or node of SourceScene::lines
};
using Direction = std::variant<DirectionAnimation, DirectionAxis, DirectionAttribute, DirectionTexture,
                               DirectionMap, DirectionGuides>;

struct MaskTexture {
  std::filesystem::path texture;  // absolute
  uint32_t channel = 0;           // 0 to 3: r g b a
};
struct MaskAttribute {
  std::string name;  // e.g. COLOR_0
  uint32_t channel = 0;
};
struct MaskAuto {};  // the surface, faded to where the clips squeeze it
struct MaskNone {};  // the whole surface
using Mask = std::variant<MaskAuto, MaskNone, MaskTexture, MaskAttribute>;

struct Bias {
  std::string attribute;  // a vertex attribute
  uint32_t channel = 0;
  double neutral = 0.5;
  std::filesystem::path texture = {};  // if not empty, an image (absolute) in place of the attribute
};

struct MapNone {};
struct MapNormal {
  std::filesystem::path texture;
  Green green = Green::kOpenGl;
};
struct MapHeight {
  std::filesystem::path texture;
  double depth = 0.0;  // root-space units between black and white; 0: as for MapSynthesized
};
struct MapSynthesized {
  std::optional<Preset> preset;  // default: skin if morph targets squeeze what is no flat sheet, else cloth
  double spacing = 0.0;          // 0: worked out from the size of the surface
  double depth = 0.0;
  uint32_t seed = 1;
};
using Map = std::variant<MapNone, MapNormal, MapHeight, MapSynthesized>;

// What is done to a map wherever it comes from.
struct MapFinish {
  std::optional<std::filesystem::path> shading;  // authored alpha-shading map
  std::optional<std::array<double, 3>>
      light;           // or W as lit from there: root space, any length but 0; else from the relief
  double limit = 1.0;  // largest x^2 + y^2 of its normals, (0, 1]
};

struct DriverRecipe {
  std::string morph;
  double gain = 1.0;
  std::vector<std::array<double, 2>> curve = {};  // morph weight, what becomes of it; by ascending weight
};

struct LayerRecipe {
  std::string name;
  std::vector<std::string> meshes, materials;  // empty: all
  Direction direction = DirectionAnimation{};
  Measure measure = Measure::kDirectional;
  Response response;          // with measure "area" and no "response" given: Curve::kOat
  std::optional<double> fit;  // lambda and beta are worked out: the weight that the animation's squeeze gets
  Mask mask = MaskAuto{};
  std::optional<Bias> bias;
  Map compress = MapSynthesized{};
  Map stretch = MapNone{};
  MapFinish compress_finish, stretch_finish;
  std::vector<DriverRecipe> drivers;
  std::string driver_table;  // of pipeline/arkit.h, in place of `drivers`
};

struct Recipe {
  std::filesystem::path file;                // empty for the default recipe
  std::vector<std::filesystem::path> files;  // every file that `file` names, absolute
  Rest rest = RestBind{};
  std::optional<double> weld_tolerance;  // default: worked out from the bounding box
  uint32_t map_size =
      0;  // largest side of a wrinkle map in texels; 0: worked out from the spacing, at most 2048
  uint32_t preview_size = 1024;  // longest side of the model's own maps that are kept for previews; 0: none
  std::vector<std::string> hidden;  // meshes and materials that previews do not draw
  std::vector<LayerRecipe> layers;
};

// One layer named "wrinkles" over everything, directions from the animation, synthesised map.
Recipe defaultRecipe();

// Reads and checks a recipe; paths in it are relative to it and come out absolute. Throws Error, kEnvironment
// if the file cannot be opened, else kBadData: not JSON (with line and column), a key that stands twice, an
// unknown key (names where it stands and the nearest known one), a wrong type or range, 0 or more than
// kMaxLayers layers, two layers of one name, a named image that does not exist.
Recipe readRecipe(const std::filesystem::path& file);

// The same of a text that is in memory, as if it stood in `file`.
Recipe parseRecipe(const std::string& text, const std::filesystem::path& file);

// Whether a recipe can hold this text: it is UTF-8 and not empty.
bool isRecipeText(const std::string& text);

// The recipe as JSON that readRecipe() reads back as the same recipe from `file`, to which its paths are
// relative.
std::string recipeText(const Recipe& recipe, const std::filesystem::path& file);

}  // namespace furrow::pipeline
