#pragma once

// The cook: from a scene and a recipe to the bytes of a .furrow asset.

#include <cstddef>
#include <functional>
#include <vector>

#include "pipeline/cook/cook_memory.h"
#include "pipeline/cook/cook_report.h"
#include "pipeline/maps/image.h"
#include "pipeline/pack/geometry_codec.h"
#include "pipeline/recipe/recipe.h"
#include "pipeline/scene/source_scene.h"

namespace furrow::pipeline {

struct CookOptions {
  GeometryCodec geometry = GeometryCodec::kDraco;
  uint32_t threads = 2;
  // Called before every stage; an exception of its own ends the cook.
  std::function<void(const char* stage)> progress = [](const char*) {};
  Images images = {};            // masks, biases and directions that are not read from their files
  CookMemory* memory = nullptr;  // of earlier cooks of the same scene; this one leaves its own
};

struct Cooked {
  std::vector<std::byte> bytes;  // a whole .furrow file
  Asset asset;                   // loaded from it, which proves it sound
  Recipe recipe;                 // with all that was left open worked out; cooks to the same bytes
  CookReport report;
  std::vector<std::filesystem::path> dependencies;  // source, recipe and images
};

// Throws Error (kBadData) where scene and recipe do not fit. The same input gives the same bytes.
Cooked cook(SourceScene scene, const Recipe& recipe, const CookOptions& options);

}  // namespace furrow::pipeline
