#pragma once

// From a welded scene to the parts that the asset holds and the surface that all else is baked on.

#include <glm/vec4.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/bake/surface.h"
#include "pipeline/bake/weld.h"
#include "pipeline/pack/geometry.h"
#include "pipeline/recipe/recipe.h"
#include "pipeline/scene/source_scene.h"

namespace furrow::pipeline {

struct Packing {
  std::vector<PackedPart> parts;
  Surface surface;
  std::vector<uint32_t> source_vertex;  // a surface vertex
  std::vector<glm::u8vec4> colors;      // a surface vertex: AssetView::colors; empty: none
  std::vector<std::pair<uint32_t, uint32_t>> place_points;  // a slot of the hash: first point, count
  uint32_t influences = 1;                                  // of a vertex, at most
  double position_error = 0.0;                              // largest, in root space at rest
  float place_error = 0.0f;                                 // AssetView::place_error
  std::vector<std::string> warnings;
};

// A scene's rest pose as the recipe has it; `offsets`: a vertex in source order, from where `rest` puts it;
// empty unless another file is the rest.
struct RestPose {
  const Rest& rest;
  const std::vector<glm::dvec3>& offsets;

  // In root space, of all parts in source order. Throws Error (kBadData) where they are beyond all measure.
  std::vector<glm::vec3> positions(const SourceScene& scene) const;
};

// Packs every part and gives the scene the positions that the runtime will decode, so that all that follows
// is baked from those. `before`: the rest pose's positions until then. The scene's normals, tangents, UVs
// and indices and the weld's vertices are given back: the surface has them.
Packing packScene(SourceScene& scene, Weld& weld, const Recipe& recipe, const RestPose& rest,
                  const std::vector<glm::vec3>& before, GeometryCodec codec);

// Whether COLOR_0 is a colour: no layer reads its bias, mask or direction from it.
bool colorsAreColors(const Recipe& recipe);

std::span<const glm::uvec3> trianglesOf(const Primitive& primitive);

}  // namespace furrow::pipeline
