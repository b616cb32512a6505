#pragma once

// What a CookMemory holds.

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/cook/base_maps.h"
#include "pipeline/cook/ground.h"
#include "pipeline/cook/layer_bake.h"
#include "pipeline/cook/map_bake.h"

namespace furrow::pipeline {

struct KeptLayer {
  BakedLayer baked;
  std::vector<std::filesystem::path> images;  // of directions, that were read
  std::optional<double> alpha;                // percentile95(), where a response was fitted to it
};

struct KeptResults {
  EncodedImages encoded;  // whatever the scene

  // Of the last cook of the scene.
  std::string ground_key;
  std::shared_ptr<Ground> ground;                            // null: none
  std::map<std::string, std::shared_ptr<KeptLayer>> layers;  // by layerKey()
  Patterns patterns;

  void forgetScene();
};

}  // namespace furrow::pipeline
