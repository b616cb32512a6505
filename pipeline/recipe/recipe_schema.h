#pragma once

// The one description of what a recipe may hold, and a manifest (manifest.h). docs/recipe.schema.json,
// docs/manifest.schema.json and the tables of docs/recipe.md are written from it.

#include <array>
#include <string>

#include "pipeline/recipe/json_shape.h"

namespace furrow::pipeline {

// The words for a Measure and a Preset, by their numbers.
inline constexpr std::array<const char*, 4> kMeasureNames = {"directional", "area", "principal", "none"};
inline constexpr std::array<const char*, 4> kPresetNames = {"skin", "skin_fine", "cloth", "cloth_puckers"};

const JsonShape& recipeShape();
const JsonShape& manifestShape();

// The tables of all keys in docs/recipe.md.
std::string recipeTablesText();

}  // namespace furrow::pipeline
