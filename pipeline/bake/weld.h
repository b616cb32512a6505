#pragma once

// From vertices to points. Vertices at one place are one point if they also move alike: the same joints (by
// node) with the same weights, and the same displacement under every morph target; so lips that touch at rest
// stay two points, and a seam stays closed.

#include <cstddef>
#include <glm/vec3.hpp>
#include <vector>

#include "pipeline/scene/source_scene.h"

namespace furrow::pipeline {

struct Weld {
  std::vector<uint32_t> vertex_place;  // a source vertex; places are the slots of the hash
  std::vector<uint32_t>
      vertex_point;  // a source vertex; points of one place are told apart, numbered by first source vertex
  uint32_t places = 0, points = 0;
  std::vector<std::byte> hash;  // section for furrow::PlaceHash, from rest position to place
};

// `positions`: root-space rest positions of all parts' vertices in source order, float; equal bits are one
// place (-0 equals 0).
Weld weld(const SourceScene& scene, const std::vector<glm::vec3>& positions);

}  // namespace furrow::pipeline
