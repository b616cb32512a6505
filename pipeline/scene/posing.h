#pragma once

// Poses of a rig, as the glTF 2.0 specification says (3.5 nodes, 3.7.3 skins, 3.11 animations, appendix C
// interpolation), in double.

#include <glm/vec3.hpp>

#include "pipeline/scene/source_scene.h"

namespace furrow::pipeline {

// The file's own node transforms and morph weights.
Pose defaultPose(const Rig& rig);

// Overwrites what the clip animates with its values at `time`, clamped to the clip.
void applyClip(const Rig& rig, const Clip& clip, double time, Pose& pose);

// Local to root space, a node.
std::vector<glm::dmat4> worldMatrices(const std::vector<Node>& nodes);

// World matrices of the nodes and from them the palette.
PosedRig evaluate(const Rig& rig, const Pose& pose);

// The uniform scale that the pose gives to the whole model, against the default pose, rotations and moves
// aside: a clip that scales the root squeezes nothing. 1 where single joints or meshes are scaled, or by
// axis.
double wholeScale(const Rig& rig, const PosedRig& pose);

// Root-space position of every vertex of `part` under the pose: morphs first, then the skin (weights as they
// stand in the primitive) or the node. The reference that the runtime's deform job is held against.
std::vector<glm::dvec3> posePart(const SourceScene& scene, const Part& part, const PosedRig& pose);

}  // namespace furrow::pipeline
