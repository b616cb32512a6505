#pragma once

// The surface that the bake works on: decoded geometry in the asset's vertex order, welded into points, in
// the scene root's space at rest.

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <string>
#include <vector>

namespace furrow::pipeline {

struct SurfacePart {
  uint32_t vertex_begin = 0, vertex_end = 0;
  uint32_t triangle_begin = 0, triangle_end = 0;
  uint32_t source_part = 0;  // index into SourceScene::parts
  glm::dmat4 rest{1.0};      // part space -> root space at rest
  bool has_uvs = false;
};

struct Surface {
  std::vector<SurfacePart> parts;

  // Per vertex. Positions, normals and tangents are in root space at rest, normals and tangents unit and
  // tangent orthogonal to normal.
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;
  std::vector<glm::vec4> tangents;  // bitangent = w * cross(normal, tangent)
  std::vector<glm::vec2> uvs;
  std::vector<uint32_t> vertex_point;

  std::vector<glm::uvec3> triangles;       // vertices
  std::vector<glm::vec3> point_positions;  // per point
  std::vector<glm::vec3> point_normals;    // per point, unit (+Y where it has none)

  glm::uvec3 trianglePoints(size_t t) const {
    return {vertex_point[triangles[t].x], vertex_point[triangles[t].y], vertex_point[triangles[t].z]};
  }
};

// What a layer's wrinkles follow, per point of the surface.
struct LayerField {
  std::vector<glm::vec3> direction;  // unit, tangent to the surface; d and -d are the same
  std::vector<float> confidence;     // [0, 1]
  std::vector<float> strength;       // [0, 1]: the mask, how far the layer reaches
};

}  // namespace furrow::pipeline
