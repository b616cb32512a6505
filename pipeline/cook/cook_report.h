#pragma once

// What a cook found out, for people and for build systems.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "furrow/asset.h"
#include "pipeline/bake/topology.h"

namespace furrow::pipeline {

struct CookStage {
  std::string name;
  double seconds = 0.0;
};

struct LayerReport {
  std::string name;
  Response response;
  struct Fit {
    double target;  // the weight asked for
    double alpha;   // the squeeze that 95% of the layer's area stay at or below
    double weight;  // what the response makes of it
  };
  std::optional<Fit> fit;  // none: lambda and beta were given
  // Share of the area under its mask where its direction is little more than a guess.
  double low_confidence = 0.0;
};

// A texture of the asset, its errors as furrow::Texture has them.
struct TextureReport {
  std::string set;
  TextureFormat format = TextureFormat::kRgba8;
  uint32_t width = 0, height = 0, slices = 0;
  size_t bytes = 0;
  float rms_error = 0.0f, largest_error = 0.0f;
  bool own = false;  // of the model's own maps; `set` is then a material
};

struct CookReport {
  uint32_t vertices = 0, triangles = 0, places = 0, points = 0, morphs = 0, clips = 0;
  uint32_t polygons = 0;        // of more than three corners, in the source
  Topology topology;            // of the source's triangles
  double weld_tolerance = 0.0;  // root-space units
  double position_error = 0.0;  // of a vertex at rest, root-space units
  double morph_error = 0.0;     // of a displacement by a morph target at weight 1
  double diagonal = 0.0;        // of the rest bounding box
  size_t bytes = 0;             // of the asset
  std::vector<LayerReport> layers;
  std::vector<TextureReport> textures;
  std::vector<CookStage> stages;
  std::vector<std::string> warnings;
};

// The report as a JSON object; `asset` is the file it speaks of.
std::string reportText(const CookReport& report, const std::string& asset);

}  // namespace furrow::pipeline
