#include "pipeline/recipe/recipe_schema.h"

#include "furrow/asset.h"
#include "pipeline/recipe/arkit.h"

namespace furrow::pipeline {

namespace {

using Shape = JsonShape;
using Kind = JsonShape::Kind;

Shape make(Kind kind) {
  Shape shape;
  shape.kind = kind;
  return shape;
}
Shape make(Kind kind, double min, double max) {
  Shape shape = make(kind);
  shape.min = min;
  shape.max = max;
  return shape;
}
Shape text(const char* meaning) {
  Shape shape = make(Kind::kText);
  shape.meaning = meaning;
  return shape;
}
Shape file() {
  return make(Kind::kFile);
}
Shape image() {
  return make(Kind::kImage);
}
Shape number(double min, double max) {
  return make(Kind::kNumber, min, max);
}
Shape integer(double min, double max) {
  return make(Kind::kInteger, min, max);
}
Shape above(double min, double max) {
  Shape shape = number(min, max);
  shape.above_min = true;
  return shape;
}
Shape word(std::vector<std::string> words) {
  Shape shape = make(Kind::kWord);
  shape.words = std::move(words);
  return shape;
}
Shape wordOf(const std::array<const char*, 4>& names) {
  return word({names.begin(), names.end()});
}
Shape list(Shape item, double min, double max) {
  Shape shape = make(Kind::kList, min, max);
  shape.inner = {std::move(item)};
  return shape;
}
// Three numbers.
Shape vector(const char* meaning) {
  Shape shape = list(number(-kLength, kLength), 3, 3);
  shape.meaning = meaning;
  return shape;
}
Shape map(Shape item) {
  Shape shape = make(Kind::kMap);
  shape.inner = {std::move(item)};
  return shape;
}
Shape either(std::vector<Shape> shapes) {
  Shape shape = make(Kind::kEither);
  shape.inner = std::move(shapes);
  return shape;
}
Shape object(std::vector<JsonKey> keys) {
  Shape shape = make(Kind::kObject);
  shape.keys = std::move(keys);
  return shape;
}
Shape forms(std::vector<std::string> names, std::vector<JsonKey> keys) {
  Shape shape = object(std::move(keys));
  shape.forms = std::move(names);
  return shape;
}

Shape attribute() {
  return text("the name of a vertex attribute");
}

Shape describeRest() {
  return either(
      {word({"bind"}),
       forms({"clip", "morphs", "file"},
             {{"clip", either({text("the name of a clip"), integer(0, kMany)}), "Name or number of a clip."},
              {"time", number(0, kLength), "Seconds into the clip; default 0.", false, "clip"},
              {"morphs", map(number(-100, 100)), "Weights of morph targets by name; the others are 0."},
              {"file", file(), "A mesh of the same vertices in the same order, in the same unit."}})});
}

Shape describeDirection() {
  auto curve = list(vector("a point [x, y, z]"), 2, kMany);
  curve.meaning = "a curve, which is a list of two or more points [x, y, z]";
  auto guides = either(
      {list(curve, 1, kMany), object({{"lines",
                                       text("the name of a mesh or node of the glTF file that holds lines; "
                                            "curves given as points stand in "
                                            "\"guides\" itself, [[[x, y, z], ...], ...]"),
                                       "Name of a mesh or node of the glTF file that holds lines.", true}})});
  return either(
      {word({"animation", "map"}),
       forms({"axis", "attribute", "texture", "guides", "animation"},
             {{"axis", vector("a direction [x, y, z]"),
               "Direction across the creases, in the scene root's space; any length but 0."},
              {"attribute", attribute(), "A vertex attribute of 3 components that holds the direction."},
              {"texture", image(),
               "A flow map: the direction in red (along u) and green (up in the image), 0.5 is zero."},
              {"guides", guides,
               "Curves along the creases, near the surface: lists of points in the scene root's space at "
               "rest, or lines of the glTF file."},
              {"animation", object({}), "From the squeeze in the clips and morph targets."}})});
}

Shape describeResponse() {
  auto lambda = number(0.001, 1000), beta = number(0.001, 1000);
  return object(
      {{"fit", number(0.01, 0.99),
        "The weight that 95% of the layer's area reach at most under the animation; lambda and beta are "
        "worked "
        "out from it. Alone."},
       {"lambda", lambda,
        "Where wrinkles begin: below 1 at rest, 1 at the slightest squeeze, above 1 later; default 1."},
       {"beta", beta, "How steeply they grow; default 4."},
       {"stretch",
        object({{"lambda", lambda, "Default: the lambda beside it, or 1 if that is smaller."},
                {"beta", beta, "Default: the beta beside it."}}),
        "The response of the stretch map."}});
}

Shape channel() {
  return word({"r", "g", "b", "a"});
}

Shape describeMask() {
  return either(
      {word({"auto", "none"}), forms({"texture", "attribute"},
                                     {{"texture", image(), "An image: white is in the layer, black is not."},
                                      {"attribute", attribute(), "A vertex attribute, such as COLOR_0."},
                                      {"channel", channel(), "Of the image or attribute; default r."}})});
}

Shape describeMap() {
  Shape synthesis =
      object({{"preset", wordOf(kPresetNames),
               "Narrow valleys, fine lines, round folds or short bulges; default: skin where morph targets "
               "squeeze a surface that is no flat sheet, else cloth."},
              {"spacing", above(0, kLength),
               "Ridge to ridge, in the scene's unit; default: worked out from the surface."},
              {"depth", above(0, kLength),
               "Valley to ridge, in the scene's unit; default: worked out from the spacing."},
              {"seed", integer(0, 4294967295.0), "Another number gives another pattern; default 1."}});
  return either(
      {word({"none"}),
       forms(
           {"normal", "height", "synthesize"},
           {{"normal", image(), "A tangent-space normal map."},
            {"green", word({"opengl", "directx"}),
             "Whether its green channel points up or down in the image; default \"opengl\", up.", false,
             "normal"},
            {"height", image(), "A height map: white is high."},
            {"depth", above(0, kLength), "From black to white, in the scene's unit; default: worked out.",
             false, "height"},
            {"synthesize", synthesis, "A map made from the direction field; {} takes every default."},
            {"limit", above(0, 1), "Largest x^2 + y^2 of the map's normals; default 1: no limit."},
            {"light", vector("a direction [x, y, z]"),
             "Towards a light, in the scene root's space: the alpha-shading map shows the wrinkles lit from "
             "there."},
            {"shading", image(), "An alpha-shading map; default: derived from the wrinkles."}})});
}

Shape describeLayer() {
  Shape pair = list(number(-100, 100), 2, 2);
  pair.meaning = "a point [in, out], two numbers from -100 to 100";
  Shape meshes = list(text("the name of a mesh"), 1, kMany),
        materials = list(text("the name of a material"), 1, kMany);
  return object(
      {{"name", make(Kind::kName), "Name of the layer, unlike that of any other.", true},
       {"meshes", meshes,
        "The meshes it lies on, \"mesh 0\" by number where the file has no name; default all."},
       {"materials", materials,
        "The materials it lies on, \"material 0\" by number where the file has no name; default all."},
       {"direction", describeDirection(),
        "The direction across the creases; \"map\" takes it from the compress map, a normal or height map; "
        "default "
        "\"animation\"."},
       {"measure", wordOf(kMeasureNames),
        "How squeeze is measured; \"none\" for a layer that only drivers or the game move; default "
        "\"directional\"."},
       {"response", describeResponse(), "How squeeze becomes weight."},
       {"mask", describeMask(),
        "How far the layer reaches; default \"auto\": the surface, faded to where the animation squeezes "
        "it."},
       {"bias",
        forms({"texture", "attribute"},
              {{"texture", image(), "An image, read at the vertices."},
               {"attribute", attribute(), "A vertex attribute, such as COLOR_0."},
               {"channel", channel(), "Of the image or attribute; default r."},
               {"neutral", number(0, 1), "The value that leaves the weight alone; default 0.5."}}),
        "Painted offset of the weight: wrinkles at rest."},
       {"compress", describeMap(), "The map where the surface is squeezed; default {\"synthesize\": {}}."},
       {"stretch", describeMap(), "The map where it is stretched; default \"none\"."},
       {"drivers",
        either({word(driverTables()),
                list(object({{"morph", text("the name of a morph target"),
                              "Name of a morph target, or another spelling of it.", true},
                             {"gain", number(-100, 100), "Default 1."},
                             {"curve", list(pair, 1, 64),
                              "Points [in, out], straight between them and level outside: what the morph's "
                              "weight counts as; default: itself."}}),
                     0, kMany)}),
        "Morph targets whose weights are added to the layer's weight, or a ready table of ARKit's shapes."}});
}

}  // namespace

const JsonShape& recipeShape() {
  static const Shape shape = object(
      {{"$schema", text("the address of a schema"), "Where an editor finds this schema; not read."},
       {"rest", describeRest(), "The pose in which the surface is relaxed; default \"bind\", the bind pose."},
       {"weld",
        object(
            {{"tolerance", number(0, kLength),
              "Vertices at most so far apart, in the scene's unit, are one place; 0: equal positions alone. "
              "Default: a millionth of the largest coordinate, so that rounding opens no seam."}}),
        "How vertices are welded into points."},
       {"mapSize", integer(16, 8192),
        "Largest side of a wrinkle map, in texels; default: worked out, at most 2048."},
       {"previewSize", integer(0, 8192),
        "Largest side, in texels, of the model's own colour and normal maps, which the asset keeps for "
        "previews; 0 "
        "leaves them out. Default 1024."},
       {"hidden", list(text("the name of a mesh or material"), 1, kMany),
        "Meshes and materials that previews do not draw, such as a shell around the eyes that a game makes "
        "see-through; they are cooked all the same."},
       {"layers", list(describeLayer(), 1, kMaxLayers), "The wrinkle layers.", true}});
  return shape;
}

const JsonShape& manifestShape() {
  static const Shape shape =
      object({{"$schema", text("the address of a schema"), "Where an editor finds this schema; not read."},
              {"assets",
               list(object({{"source", text("the path of a file"),
                             "The mesh file; with \"sequence\", the relaxed mesh."},
                            {"sequence", text("a pattern of file names, such as \"frame_*.obj\""),
                             "Frames of a vertex animation, such as \"frame_*.obj\"."},
                            {"fps", number(0.001, 100000), "Frames a second of the sequence; default 24."},
                            {"recipe", text("the path of a file"),
                             "Default: one layer worked out from the animation."},
                            {"output", text("the path of a file"),
                             "The asset to write; folders are made as needed.", true},
                            {"geometry", word({"draco", "raw"}), "Default \"draco\"."}}),
                    1, kMany),
               "What to cook, each into an output of its own. Paths are relative to the manifest.", true}});
  return shape;
}

}  // namespace furrow::pipeline
