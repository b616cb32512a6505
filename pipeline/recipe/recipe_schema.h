#pragma once

// The one description of what a recipe may hold, and a manifest (manifest.h). docs/recipe.schema.json,
// docs/manifest.schema.json and the tables of docs/recipe.md are written from it.

#include <string>

#include "pipeline/recipe/json_shape.h"

namespace furrow::pipeline {

const JsonShape& recipeShape();
const JsonShape& manifestShape();

// The tables of all keys in docs/recipe.md.
std::string recipeTablesText();

}  // namespace furrow::pipeline
