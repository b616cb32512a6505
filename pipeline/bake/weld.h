#pragma once

// From vertices to points. Vertices at one place are one point if they also move alike: the same joints (by
// node) with the same weights, and the same displacement under every morph target; so lips that touch at rest
// stay two points, and a seam stays closed.

#include <cstddef>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "pipeline/scene/source_scene.h"

namespace furrow::pipeline {

struct Weld {
  float tolerance = 0.0f;              // that was used, root-space units
  std::vector<uint32_t> vertex_place;  // a source vertex; places are numbered by first source vertex
  std::vector<uint32_t> vertex_point;  // a source vertex; points are numbered by first source vertex
  uint32_t places = 0, points = 0;
  std::vector<std::byte> hash;       // section for furrow::PlaceHash, from source position to slot
  std::vector<uint32_t> slot_place;  // a slot of the hash: one for every different source position
};

// Positions of all vertices in source order: in root space and the bind pose, placed by Part::rest as the
// asset stores it, so that who has the same positions and that matrix gets the same bits. Throws as
// requireInRange().
std::vector<glm::vec3> sourcePositions(const SourceScene& scene);

// Welds by those positions. Without a tolerance it is roundingTolerance() (places.h); 0 means equal bits (-0
// equals 0). Displacements may differ by the tolerance too, and by rounding where it is 0; weights by a step
// of 8 bits. `rest_offsets`: a vertex, where a rest from another file moves it (restOffsets()); it counts as
// one more displacement. Nothing is returned if the tolerance is far too coarse, see findPlaces().
std::optional<Weld> weld(const SourceScene& scene, std::optional<double> tolerance,
                         std::span<const glm::dvec3> rest_offsets = {});

}  // namespace furrow::pipeline
