#include "pipeline/recipe_schema.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "furrow/asset.h"
#include "pipeline/error.h"

namespace furrow::pipeline {

namespace {

using json = nlohmann::json;
using Shape = RecipeShape;
using Kind = RecipeShape::Kind;

// ---- the description ----

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
Shape text() {
  return make(Kind::kText);
}
Shape file() {
  return make(Kind::kFile);
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
Shape word(std::vector<std::string> words, std::vector<std::string> planned = {}) {
  Shape shape = make(Kind::kWord);
  shape.words = std::move(words);
  shape.planned = std::move(planned);
  return shape;
}
Shape list(Shape item, double min, double max) {
  Shape shape = make(Kind::kList, min, max);
  shape.inner = {std::move(item)};
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
Shape object(std::vector<RecipeKey> keys) {
  Shape shape = make(Kind::kObject);
  shape.keys = std::move(keys);
  return shape;
}
Shape forms(std::vector<std::string> names, std::vector<RecipeKey> keys,
            std::vector<std::string> planned = {}) {
  Shape shape = object(std::move(keys));
  shape.forms = std::move(names);
  shape.planned = std::move(planned);
  return shape;
}

constexpr double kLength = 1e9;   // of the scene's unit
constexpr double kMany = 100000;  // items of a list without a bound of its own

Shape describeRest() {
  return either(
      {word({"bind"}),
       forms({"clip", "morphs"},
             {{"clip", either({text(), integer(0, kMany)}), "Name or number of a clip."},
              {"time", number(0, kLength), "Seconds into the clip; default 0.", false, "clip"},
              {"morphs", map(number(-100, 100)), "Weights of morph targets by name; the others are 0."}},
             {"file"})});
}

Shape describeDirection() {
  return either({word({"animation"}, {"texture", "guides", "map"}),
                 forms({"axis", "attribute", "animation"},
                       {{"axis", list(number(-kLength, kLength), 3, 3),
                         "Direction across the creases, in the scene root's space; any length but 0."},
                        {"attribute", text(), "A vertex attribute of 3 components that holds the direction."},
                        {"animation", object({}), "From the squeeze in the clips and morph targets."}},
                       {"texture", "guides", "map"})});
}

Shape describeResponse() {
  auto lambda = number(0.001, 1000), beta = number(0.001, 1000);
  return object(
      {{"lambda", lambda,
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
      {word({"auto", "none"}),
       forms({"texture", "attribute"}, {{"texture", file(), "An image: white is in the layer, black is not."},
                                        {"attribute", text(), "A vertex attribute, such as COLOR_0."},
                                        {"channel", channel(), "Of the image or attribute; default r."}})});
}

Shape describeMap() {
  Shape synthesis = object(
      {{"preset", word({"skin", "skin_fine", "cloth", "cloth_puckers"}),
        "Narrow valleys, fine crossing lines, round folds or short bulges; default: skin or cloth, worked "
        "out from the rig."},
       {"spacing", above(0, kLength),
        "Ridge to ridge, in the scene's unit; default: worked out from the surface."},
       {"depth", above(0, kLength),
        "Valley to ridge, in the scene's unit; default: worked out from the spacing."},
       {"seed", integer(0, 4294967295.0), "Another number gives another pattern; default 1."}});
  return either(
      {word({"none"}),
       forms(
           {"normal", "height", "synthesize"},
           {{"normal", file(), "A tangent-space normal map."},
            {"green", word({"opengl", "directx"}),
             "Whether its green channel points up or down in the image; default \"opengl\", up.", false,
             "normal"},
            {"height", file(), "A height map: white is high."},
            {"depth", above(0, kLength), "From black to white, in the scene's unit; default: worked out.",
             false, "height"},
            {"synthesize", synthesis, "A map made from the direction field; {} takes every default."},
            {"limit", above(0, 1), "Largest x^2 + y^2 of the map's normals; default 1: no limit."},
            {"light", list(number(-kLength, kLength), 3, 3),
             "Towards a light, in the scene root's space: the alpha-shading map shows the wrinkles lit from "
             "there."},
            {"shading", file(), "An alpha-shading map; default: derived from the wrinkles."}})});
}

Shape describeLayer() {
  Shape names = list(text(), 1, kMany);
  return object(
      {{"name", make(Kind::kName), "Name of the layer, unlike that of any other.", true},
       {"meshes", names, "The meshes it lies on; default all."},
       {"materials", names, "The materials it lies on; default all."},
       {"direction", describeDirection(), "The direction across the creases; default \"animation\"."},
       {"measure", word({"directional", "area", "principal", "none"}),
        "How squeeze is measured; \"none\" for a layer that only drivers or the game move; default "
        "\"directional\"."},
       {"response", describeResponse(), "How squeeze becomes weight."},
       {"mask", describeMask(),
        "How far the layer reaches; default \"auto\": the surface, faded to where the animation squeezes "
        "it."},
       {"bias",
        object({{"attribute", text(), "A vertex attribute, such as COLOR_0.", true},
                {"channel", channel(), "Default r."},
                {"neutral", number(0, 1), "The value that leaves the weight alone; default 0.5."}}),
        "Painted offset of the weight: wrinkles at rest."},
       {"compress", describeMap(), "The map where the surface is squeezed; default {\"synthesize\": {}}."},
       {"stretch", describeMap(), "The map where it is stretched; default \"none\"."},
       {"drivers",
        list(object({{"morph", text(), "Name of a morph target.", true},
                     {"gain", number(-100, 100), "Default 1."}}),
             0, kMany),
        "Morph targets whose weights are added to the layer's weight."}});
}

// ---- the check ----

std::string inQuotes(const std::string& text) {
  return '"' + text + '"';
}

std::string joined(const std::vector<std::string>& parts, const char* last) {
  std::string result;
  for (size_t i = 0; i < parts.size(); ++i) {
    if (i != 0) result += i + 1 == parts.size() ? last : ", ";
    result += parts[i];
  }
  return result;
}

std::string quotedList(std::vector<std::string> names) {
  for (std::string& name : names) name = inQuotes(name);
  return joined(names, " or ");
}

std::string plain(double number) {
  return number == std::floor(number) && std::abs(number) < 1e15
             ? std::to_string(static_cast<int64_t>(number))
             : json(number).dump();
}

// What to give where `shape` is asked for.
std::string wanted(const Shape& shape) {
  switch (shape.kind) {
    case Kind::kText:
      return "a text that is not empty";
    case Kind::kName:
      return "a name without commas, quotes or line breaks";
    case Kind::kFile:
      return "the path of a file";
    case Kind::kWord:
      return quotedList(shape.words);
    case Kind::kNumber:
      if (shape.max < kLength) return "a number from " + plain(shape.min) + " to " + plain(shape.max);
      return shape.above_min  ? "a number above " + plain(shape.min)
             : shape.min == 0 ? "a number from 0 up"
                              : "a number";
    case Kind::kInteger:
      return "a whole number from " + plain(shape.min) + " to " + plain(shape.max);
    case Kind::kList: {
      std::string count = shape.min == shape.max ? plain(shape.min) + " values"
                          : shape.max < kMany    ? plain(shape.min) + " to " + plain(shape.max) + " values"
                          : shape.min == 1       ? "one or more values"
                                                 : "values";
      return "a list of " + count + ", each " + wanted(shape.inner[0]);
    }
    case Kind::kObject:
      if (!shape.forms.empty()) return "an object with " + quotedList(shape.forms);
      return shape.keys.empty() ? "an empty object" : "an object";
    case Kind::kMap:
      return "an object whose values are each " + wanted(shape.inner[0]);
    case Kind::kEither: {
      std::vector<std::string> parts;
      for (const Shape& s : shape.inner) parts.push_back(wanted(s));
      return joined(parts, ", or ");
    }
  }
  return {};
}

std::string shown(const json& value) {
  if (value.is_object()) return "an object";
  if (value.is_array()) return "a list of " + std::to_string(value.size());
  std::string text = value.dump(-1, ' ', true);
  return text.size() <= 60 ? text : text.substr(0, 57) + "...";
}

bool hasType(const json& value, const Shape& shape) {
  switch (shape.kind) {
    case Kind::kText:
    case Kind::kName:
    case Kind::kFile:
    case Kind::kWord:
      return value.is_string();
    case Kind::kNumber:
    case Kind::kInteger:
      return value.is_number();
    case Kind::kList:
      return value.is_array();
    case Kind::kObject:
    case Kind::kMap:
      return value.is_object();
    case Kind::kEither:
      return std::any_of(shape.inner.begin(), shape.inner.end(),
                         [&](const Shape& s) { return hasType(value, s); });
  }
  return false;
}

size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 0; i < a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i + 1;
    for (size_t j = 0; j < b.size(); ++j) {
      size_t change = diagonal + (a[i] != b[j]);
      diagonal = row[j + 1];
      row[j + 1] = std::min({change, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

class Checker {
 public:
  explicit Checker(const std::filesystem::path& recipe) : recipe_(recipe) {}

  void check(const json& value, const Shape& shape, const std::string& path) const {
    if (!hasType(value, shape)) failValue(value, shape, path);
    switch (shape.kind) {
      case Kind::kText:
        if (value.get_ref<const std::string&>().empty()) failValue(value, shape, path);
        break;
      case Kind::kName: {
        const auto& name = value.get_ref<const std::string&>();
        bool bad = std::any_of(name.begin(), name.end(), [](char c) {
          return c == ',' || c == '"' || c == 0x7f || static_cast<unsigned char>(c) < 0x20;
        });
        if (bad || name.empty()) failValue(value, shape, path);
        break;
      }
      case Kind::kFile:
        checkFile(value, shape, path);
        break;
      case Kind::kWord:
        if (!contains(shape.words, value.get_ref<const std::string&>())) failValue(value, shape, path);
        break;
      case Kind::kInteger:
      case Kind::kNumber: {
        double number = value.get<double>();
        if (!(number >= shape.min && number <= shape.max) || (shape.above_min && number == shape.min) ||
            (shape.kind == Kind::kInteger && !value.is_number_integer()))
          failValue(value, shape, path);
        break;
      }
      case Kind::kList: {
        double count = static_cast<double>(value.size());
        if (count < shape.min || count > shape.max) failValue(value, shape, path);
        for (size_t i = 0; i < value.size(); ++i)
          check(value[i], shape.inner[0], path + '[' + std::to_string(i) + ']');
        break;
      }
      case Kind::kMap:
        for (const auto& [name, item] : value.items()) check(item, shape.inner[0], below(path, name));
        break;
      case Kind::kObject:
        checkObject(value, shape, path);
        break;
      case Kind::kEither:
        checkEither(value, shape, path);
        break;
    }
  }

 private:
  [[noreturn]] void fail(const std::string& path, const std::string& wrong, const std::string& remedy) const {
    throw Error(Exit::kBadData, recipe_.string(), path.empty() ? wrong : path + ": " + wrong, remedy);
  }
  [[noreturn]] void failValue(const json& value, const Shape& shape, const std::string& path) const {
    fail(path, path.empty() ? "the recipe is " + shown(value) : "is " + shown(value),
         "give " + wanted(shape));
  }

  static std::string below(const std::string& path, const std::string& key) {
    return path.empty() ? key : path + '.' + key;
  }

  void checkFile(const json& value, const Shape& shape, const std::string& path) const {
    const auto& name = value.get_ref<const std::string&>();
    if (name.empty() || name.find('\0') != std::string::npos) failValue(value, shape, path);
    std::filesystem::path found = recipePath(recipe_, name);
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(found, ignored))
      fail(path, "no such file " + found.string(), "paths are relative to the recipe");
  }

  // A string that is none of the words is judged by all alternatives, so that the message names them all.
  void checkEither(const json& value, const Shape& shape, const std::string& path) const {
    for (const Shape& s : shape.inner) {
      if (!hasType(value, s)) continue;
      if (s.kind == Kind::kWord && contains(s.planned, value.get_ref<const std::string&>()))
        fail(path, shown(value) + " is not supported yet in this version", "give " + wanted(shape));
      if (s.kind == Kind::kWord && !contains(s.words, value.get_ref<const std::string&>()))
        failValue(value, shape, path);
      return check(value, s, path);
    }
  }

  void checkObject(const json& value, const Shape& shape, const std::string& path) const {
    for (const auto& [name, item] : value.items()) {
      if (contains(shape.planned, name))
        fail(below(path, name), "not supported yet in this version", "use " + quotedList(shape.forms));
      if (std::none_of(shape.keys.begin(), shape.keys.end(),
                       [&, &n = name](const RecipeKey& k) { return k.name == n; }))
        failUnknown(name, shape, path);
    }
    if (!shape.forms.empty()) {
      std::vector<std::string> given;
      for (const std::string& form : shape.forms)
        if (value.contains(form)) given.push_back(form);
      if (given.empty()) fail(path, "says nothing", "give " + wanted(shape));
      if (given.size() > 1)
        fail(path, "has both " + inQuotes(given[0]) + " and " + inQuotes(given[1]), "give one of them");
      for (const RecipeKey& key : shape.keys)
        if (!key.form.empty() && key.form != given[0] && value.contains(key.name))
          fail(below(path, key.name), "does not go with " + inQuotes(given[0]),
               "it goes with " + inQuotes(key.form));
    }
    for (const RecipeKey& key : shape.keys) {
      auto found = value.find(key.name);
      if (found != value.end())
        check(*found, key.shape, below(path, key.name));
      else if (key.required)
        fail(below(path, key.name), "is missing", "give " + wanted(key.shape));
    }
  }

  [[noreturn]] void failUnknown(const std::string& name, const Shape& shape, const std::string& path) const {
    if (shape.keys.empty()) fail(below(path, name), "no such key", "give an empty object");
    auto nearest =
        std::min_element(shape.keys.begin(), shape.keys.end(), [&](const RecipeKey& a, const RecipeKey& b) {
          return editDistance(name, a.name) < editDistance(name, b.name);
        });
    fail(below(path, name), "no such key", "did you mean " + inQuotes(nearest->name) + "?");
  }

  const std::filesystem::path& recipe_;
};

// ---- the schema ----

using ordered = nlohmann::ordered_json;

ordered bound(double number) {
  return number == std::floor(number) ? ordered(static_cast<int64_t>(number)) : ordered(number);
}

ordered schemaOf(const Shape& shape);

// `form` is empty for an object without forms.
ordered schemaOfForm(const Shape& shape, const std::string& form) {
  ordered properties = ordered::object(), required = ordered::array();
  for (const RecipeKey& key : shape.keys) {
    bool other_form = key.name != form && contains(shape.forms, key.name);
    if (other_form || (!key.form.empty() && key.form != form)) continue;
    ordered property = {{"description", key.doc}};
    property.update(schemaOf(key.shape));
    properties[key.name] = property;
    if (key.required || key.name == form) required.push_back(key.name);
  }
  ordered schema = {{"type", "object"}, {"properties", properties}};
  if (!required.empty()) schema["required"] = required;
  schema["additionalProperties"] = false;
  return schema;
}

ordered schemaOf(const Shape& shape) {
  switch (shape.kind) {
    case Kind::kText:
    case Kind::kFile:
      return {{"type", "string"}, {"minLength", 1}};
    case Kind::kName:
      return {{"type", "string"}, {"pattern", "^[^,\"\\u0000-\\u001f\\u007f]+$"}};
    case Kind::kWord:
      return {{"enum", shape.words}};
    case Kind::kNumber:
      return {{"type", "number"},
              {shape.above_min ? "exclusiveMinimum" : "minimum", bound(shape.min)},
              {"maximum", bound(shape.max)}};
    case Kind::kInteger:
      return {{"type", "integer"}, {"minimum", bound(shape.min)}, {"maximum", bound(shape.max)}};
    case Kind::kList:
      return {{"type", "array"},
              {"items", schemaOf(shape.inner[0])},
              {"minItems", bound(shape.min)},
              {"maxItems", bound(shape.max)}};
    case Kind::kMap:
      return {{"type", "object"}, {"additionalProperties", schemaOf(shape.inner[0])}};
    case Kind::kObject: {
      if (shape.forms.empty()) return schemaOfForm(shape, {});
      ordered alternatives = ordered::array();
      for (const std::string& form : shape.forms) alternatives.push_back(schemaOfForm(shape, form));
      return {{"oneOf", alternatives}};
    }
    case Kind::kEither: {
      ordered alternatives = ordered::array();
      for (const Shape& s : shape.inner) {
        ordered schema = schemaOf(s);
        if (schema.contains("oneOf"))
          for (const ordered& form : schema["oneOf"]) alternatives.push_back(form);
        else
          alternatives.push_back(schema);
      }
      return {{"oneOf", alternatives}};
    }
  }
  return {};
}

}  // namespace

const RecipeShape& recipeShape() {
  static const Shape shape = object(
      {{"$schema", text(), "Where an editor finds this schema; not read."},
       {"rest", describeRest(), "The pose in which the surface is relaxed; default \"bind\", the bind pose."},
       {"weld",
        object({{"tolerance", number(0, kLength),
                 "Vertices at most so far apart, in the scene's unit, are one place; default 0."}}),
        "How vertices are welded into points."},
       {"mapSize", integer(16, 8192),
        "Largest side of a wrinkle map, in texels; default: worked out, at most 2048."},
       {"layers", list(describeLayer(), 1, kMaxLayers), "The wrinkle layers.", true}});
  return shape;
}

std::filesystem::path recipePath(const std::filesystem::path& file, const std::string& text) {
  std::filesystem::path named(std::u8string(text.begin(), text.end()));
  return (std::filesystem::absolute(file).parent_path() / named).lexically_normal();
}

void checkRecipe(const json& recipe, const std::filesystem::path& file) {
  Checker(file).check(recipe, recipeShape(), "");
}

std::string recipeSchemaText() {
  ordered schema = {{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", "furrow recipe"}};
  schema.update(schemaOf(recipeShape()));
  return schema.dump(2) + '\n';
}

}  // namespace furrow::pipeline
