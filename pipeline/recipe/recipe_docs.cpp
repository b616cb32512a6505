#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "pipeline/recipe/recipe_schema.h"

namespace furrow::pipeline {

namespace {

using Shape = JsonShape;
using Kind = JsonShape::Kind;

// ---- the schema ----

using ordered = nlohmann::ordered_json;

ordered bound(double number) {
  return number == std::floor(number) ? ordered(static_cast<int64_t>(number)) : ordered(number);
}

ordered schemaOf(const Shape& shape);

// `form` is empty for an object without forms.
ordered schemaOfForm(const Shape& shape, const std::string& form) {
  ordered properties = ordered::object(), required = ordered::array();
  for (const JsonKey& key : shape.keys) {
    bool other_form =
        key.name != form && std::find(shape.forms.begin(), shape.forms.end(), key.name) != shape.forms.end();
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
    case Kind::kImage:
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

// ---- the tables ----

struct Row {
  std::string key, value, meaning;
};

// Rows of the keys below `shape`, named from there.
std::vector<Row> rowsBelow(const Shape& shape);

std::vector<Row> rowsOf(const JsonKey& key) {
  std::vector<Row> rows = {{key.name, describe(key.shape), key.doc}};
  if (key.required) rows[0].meaning += " Required.";
  if (!key.form.empty()) rows[0].meaning += " Beside `" + key.form + "`.";
  for (Row row : rowsBelow(key.shape)) {
    row.key = key.name + row.key;
    rows.push_back(std::move(row));
  }
  return rows;
}

std::vector<Row> rowsBelow(const Shape& shape) {
  std::vector<Row> rows;
  for (const Shape& inner : shape.inner)
    for (Row row : rowsBelow(inner)) {
      if (shape.kind == Kind::kList) row.key = "[]" + row.key;
      rows.push_back(std::move(row));
    }
  for (const JsonKey& key : shape.keys)
    for (Row row : rowsOf(key)) {
      row.key = '.' + row.key;
      rows.push_back(std::move(row));
    }
  return rows;
}

bool sameBelow(const JsonKey& a, const JsonKey& b) {
  const std::vector<Row> below_a = rowsBelow(a.shape), below_b = rowsBelow(b.shape);
  return std::equal(below_a.begin(), below_a.end(), below_b.begin(), below_b.end(),
                    [](const Row& x, const Row& y) { return x.key == y.key && x.meaning == y.meaning; });
}

// One row a key, those below it after it; not below `apart`, which has a table of its own, and not twice
// where two keys hold the same.
std::string table(const Shape& shape, const std::string& apart) {
  std::string text = "| key | value | meaning |\n|---|---|---|\n";
  for (size_t k = 0; k < shape.keys.size(); ++k) {
    const JsonKey& key = shape.keys[k];
    std::vector<Row> rows = rowsOf(key);
    const auto end = shape.keys.begin() + static_cast<std::ptrdiff_t>(k);
    const auto twin = std::find_if(shape.keys.begin(), end,
                                   [&](const JsonKey& earlier) { return sameBelow(earlier, key); });
    if (twin != end && rows.size() > 1) {
      rows.resize(1);
      rows[0].meaning += " With the keys of `" + twin->name + "`.";
    }
    if (key.name == apart) rows.resize(1);
    for (const Row& row : rows) text += "| `" + row.key + "` | " + row.value + " | " + row.meaning + " |\n";
  }
  return text;
}

}  // namespace

std::string schemaText(const JsonShape& shape, const char* title) {
  ordered schema = {{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", title}};
  schema.update(schemaOf(shape));
  return schema.dump(2) + '\n';
}

std::string recipeTablesText() {
  const JsonKey& layers = recipeShape().keys.back();
  return "### The recipe\n\n" + table(recipeShape(), layers.name) + "\n### A layer\n\n" +
         table(layers.shape.inner[0], "");
}

}  // namespace furrow::pipeline
