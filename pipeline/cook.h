#pragma once

// The cook: from a scene and a recipe to the bytes of a .furrow asset.

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "pipeline/pack/geometry_codec.h"
#include "pipeline/recipe.h"
#include "pipeline/scene/source_scene.h"

namespace furrow::pipeline {

struct CookOptions {
  GeometryCodec geometry = GeometryCodec::kDraco;
  uint32_t threads = 2;
  std::function<void(const char* stage)> progress = [](const char*) {};
};

// A texture of the asset, with its error against what it was encoded from as furrow::Texture has it.
struct TextureReport {
  std::string set;
  TextureFormat format = TextureFormat::kRgba8;
  uint32_t width = 0, height = 0, slices = 0;
  size_t bytes = 0;
  float rms_error = 0.0f, largest_error = 0.0f;
};

struct CookReport {
  uint32_t vertices = 0, triangles = 0, places = 0, points = 0, degenerate_triangles = 0, morphs = 0,
           clips = 0;
  double position_error = 0.0;  // root-space units
  double diagonal = 0.0;        // of the rest bounding box
  std::vector<TextureReport> textures;
  std::vector<std::string> warnings;
};

struct Cooked {
  std::vector<std::byte> bytes;  // a whole .furrow file, already loaded once to prove it sound
  CookReport report;
  std::vector<std::filesystem::path> dependencies;  // source, recipe and images
};

// Throws Error (kBadData) where scene and recipe do not fit. The same input gives the same bytes.
Cooked cook(SourceScene scene, const Recipe& recipe, const CookOptions& options);

}  // namespace furrow::pipeline
