#pragma once

// Tangent frames of a mesh that has none.

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

namespace furrow::pipeline {

// Per vertex a unit tangent along +u, orthogonal to the normal, and in w the sign of the bitangent, which
// runs towards the top of the image
// (-v in glTF): bitangent = w * cross(normal, tangent). By MikkTSpace's rules (Mikkelsen 2008): the
// triangles' tangents, projected into the vertex's tangent plane and weighted by the corner's angle there,
// summed over all vertices that agree in position, normal and UV. The vertices are taken as they are: where
// mirrored and unmirrored triangles share one, the side with the larger angle rules.
//
// `normals` are unit, one a position; `uvs` as many or empty; `triangles` index them. A vertex without UVs,
// or of whose triangles none has an area in UV, gets any tangent orthogonal to its normal, w = 1.
std::vector<glm::vec4> tangents(std::span<const glm::vec3> positions, std::span<const glm::vec3> normals,
                                std::span<const glm::vec2> uvs, std::span<const glm::uvec3> triangles);

}  // namespace furrow::pipeline
