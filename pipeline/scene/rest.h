#pragma once

// The rest pose: where every vertex lies, in the scene root's space, when the surface is relaxed.

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "pipeline/recipe/recipe.h"
#include "pipeline/scene/source_scene.h"

namespace furrow::pipeline {

// Part space -> root space in the bind pose, for every part. A mesh without skin: its node's world matrix. A
// skin: what its topmost joint makes of the mesh under the file's own node transforms, its uniform scale
// replaced by the median over the joints; so a unit factor that the file hides in its inverse bind matrices
// is counted once, and nodes above the skeleton change nothing.
std::vector<glm::dmat4> bindMatrices(const SourceScene& scene);

// Root-space rest positions of all vertices in source order; a RestFile counts as the bind pose, see
// restOffsets(). Throws Error (kBadData) where the recipe names a clip or morph the file lacks.
std::vector<glm::dvec3> restPositions(const SourceScene& scene, const Rest& rest);

// From every vertex's place in the bind pose to its place in `file`, root space, source order. The files' own
// lists of vertices correspond. Throws Error (kBadData) naming `file` where they do not: other vertices,
// other edges, another unit of length.
std::vector<glm::dvec3> restOffsets(const SourceScene& scene, const SourceScene& file);

// Throws Error (kBadData) naming the scene's file where a position is so far out, or all of them so close
// together but not at one place, that the squares of lengths there are no floats (the transforms of its nodes
// and skins may lead there, whatever the mesh holds).
void requireInRange(const SourceScene& scene, std::span<const glm::vec3> positions);

// By name, or by number if no clip has that name; null if there is none.
const Clip* findClip(const Rig& rig, const std::string& name_or_number);

// "a, b, c" for error messages, at most `most` of them.
std::string joinNames(const std::vector<std::string>& names, size_t most = 12);

}  // namespace furrow::pipeline
