#include "pipeline/cook/ground.h"

#include <algorithm>

#include "pipeline/error.h"
#include "pipeline/import/import.h"
#include "pipeline/release.h"
#include "pipeline/scene/rest.h"

namespace furrow::pipeline {
namespace {

// Depths that are worked out are those of a face where morph targets squeeze the layer.
bool needsSqueeze(const Map& map) {
  const auto* height = std::get_if<MapHeight>(&map);
  return std::holds_alternative<MapSynthesized>(map) || (height && height->depth == 0.0);
}

bool needsSqueeze(const Recipe& recipe) {
  return std::any_of(recipe.layers.begin(), recipe.layers.end(), [](const LayerRecipe& layer) {
    return std::holds_alternative<DirectionAnimation>(layer.direction) ||
           std::holds_alternative<MaskAuto>(layer.mask) || needsSqueeze(layer.compress) ||
           needsSqueeze(layer.stretch);
  });
}

// Draco drops faces without area, so the source's are looked at.
Topology topologyOf(const SourceScene& scene, const Weld& weld, const std::vector<glm::vec3>& rest) {
  std::vector<glm::uvec3> triangles;
  size_t count = 0;
  for (const Part& part : scene.parts) count += trianglesOf(scene.primitives[part.primitive]).size();
  triangles.reserve(count);
  uint32_t first_vertex = 0;
  for (const Part& part : scene.parts) {
    const Primitive& primitive = scene.primitives[part.primitive];
    for (const glm::uvec3& t : trianglesOf(primitive)) triangles.push_back(t + first_vertex);
    first_vertex += static_cast<uint32_t>(primitive.positions.size());
  }
  return inspect(rest, weld.vertex_point, triangles);
}

}  // namespace

Ground makeGround(SourceScene scene, const Recipe& recipe, GeometryCodec codec,
                  const std::string& recipe_file, uint32_t threads,
                  const std::function<void(const char*)>& stage) {
  Ground ground;
  ground.scene = std::move(scene);
  stage("welding");
  std::vector<glm::dvec3> rest_offsets;  // a vertex in source order; empty unless another file is the rest
  if (const auto* other = std::get_if<RestFile>(&recipe.rest)) {
    const SourceScene file = import(other->file);
    rest_offsets = restOffsets(ground.scene, file);
    ground.dependencies = file.dependencies;
  }
  std::optional<Weld> made = weld(ground.scene, recipe.weld_tolerance, rest_offsets);
  if (!made)
    throw Error(Exit::kBadData, recipe_file,
                "weld.tolerance: thousands of vertices lie within a few of it of each other",
                "give a length well below that of the edges, or leave it out");
  ground.weld = std::move(*made);
  const RestPose rest{recipe.rest, rest_offsets};
  std::vector<glm::vec3> source_rest = rest.positions(ground.scene);
  ground.topology = topologyOf(ground.scene, ground.weld, source_rest);
  stage("packing geometry");
  ground.packed = packScene(ground.scene, ground.weld, recipe, rest, source_rest, codec);
  ground.warnings = std::move(ground.packed.warnings);
  release(source_rest);
  stage("measuring the animation");
  if (needsSqueeze(recipe)) {
    ground.squeeze =
        measureSqueeze(ground.scene, ground.packed.surface, ground.packed.source_vertex, threads);
    if (!ground.squeeze.any)
      ground.warnings.push_back(
          "no clip and no morph target squeezes it: wrinkles will only come from bias, region weights and "
          "drivers");
  }
  return ground;
}

std::string groundKey(const Recipe& recipe, GeometryCodec codec) {
  if (std::holds_alternative<RestFile>(recipe.rest)) return {};
  Recipe alone;
  alone.rest = recipe.rest;
  alone.weld_tolerance = recipe.weld_tolerance;
  return recipeText(alone, "/key") + (codec == GeometryCodec::kDraco ? " draco" : " raw") +
         (needsSqueeze(recipe) ? " squeezed" : "") + (colorsAreColors(recipe) ? " colored" : "");
}

}  // namespace furrow::pipeline
