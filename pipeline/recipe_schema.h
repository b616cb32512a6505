#pragma once

// The one description of what a recipe may hold. The parser checks recipes against it;
// docs/recipe.schema.json and the tables of docs/recipe.md are written from it.

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace furrow::pipeline {

struct RecipeKey;

// Bounds that a reader need not be told of.
inline constexpr double kLength = 1e9;   // of the scene's unit
inline constexpr double kMany = 100000;  // items of a list

// What one value of a recipe may be.
struct RecipeShape {
  enum class Kind {
    kText,     // a string that is not empty
    kName,     // the same, fit for a column of a CSV file: no comma, quote or control character
    kFile,     // the path of a file that exists, relative to the recipe
    kWord,     // one of `words`
    kNumber,   // [min, max], or (min, max] if above_min
    kInteger,  // [min, max]
    kList,     // [min, max] values of shape inner[0]
    kObject,   // `keys`, and no other
    kMap,      // any keys, values of shape inner[0]
    kEither,   // one of `inner`, which a JSON value's type tells apart
  };

  Kind kind = Kind::kText;
  std::vector<std::string> words;
  double min = 0.0, max = 0.0;
  bool above_min = false;
  std::vector<RecipeShape> inner;
  std::vector<RecipeKey> keys;
  std::vector<std::string> forms;  // names of keys of which exactly one must be there; empty: no such rule
};

struct RecipeKey {
  std::string name;
  RecipeShape shape;
  std::string doc;
  bool required = false;
  std::string form = {};  // if not empty, the key may only stand beside this one
};

const RecipeShape& recipeShape();

// What to give where `shape` is asked for, in words.
std::string describe(const RecipeShape& shape);

// Throws Error (kBadData), whose message names `file` and the path of the key at fault, such as
// layers[0].response.beta.
void checkRecipe(const nlohmann::json& recipe, const std::filesystem::path& file);

// `text`, written in `file`, as a path.
std::filesystem::path recipePath(const std::filesystem::path& file, const std::string& text);

// docs/recipe.schema.json, a JSON Schema (draft 7).
std::string recipeSchemaText();

// The tables of all keys in docs/recipe.md.
std::string recipeTablesText();

}  // namespace furrow::pipeline
