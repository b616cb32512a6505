#pragma once

// What the layers of a scene are baked on: its surface, welded and packed, and how the animation squeezes it.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "pipeline/bake/squeeze.h"
#include "pipeline/bake/topology.h"
#include "pipeline/bake/weld.h"
#include "pipeline/cook/packing.h"
#include "pipeline/pack/geometry_codec.h"
#include "pipeline/recipe/recipe.h"
#include "pipeline/scene/source_scene.h"

namespace furrow::pipeline {

struct Ground {
  SourceScene scene;  // with the positions that the runtime decodes; what the surface holds is released
  Weld weld;
  Packing packed;
  Squeeze squeeze;    // nothing unless a layer of the recipe needs it
  Topology topology;  // of the source's triangles
  std::vector<std::string> warnings;
  std::vector<std::filesystem::path> dependencies;
};

// `stage` is called before every step. Throws Error (kBadData; names `recipe_file`).
Ground makeGround(SourceScene scene, const Recipe& recipe, GeometryCodec codec,
                  const std::string& recipe_file, uint32_t threads,
                  const std::function<void(const char*)>& stage);

// All that the ground depends on but the scene; empty where it is read from another file, too.
std::string groundKey(const Recipe& recipe, GeometryCodec codec);

}  // namespace furrow::pipeline
