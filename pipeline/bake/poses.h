#pragma once

// The poses that stand for a scene's animation: every morph target at 1, and every clip, sampled 12 times a
// second, about 64 poses in all at most, at least 3 a clip. Of a sequence the frames, or 64 of its poses.

#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "pipeline/bake/surface.h"
#include "pipeline/scene/source_scene.h"

namespace furrow::pipeline {

struct SurfacePose {
  std::span<const glm::dvec3> positions;  // a surface vertex, in root space, without wholeScale()
  std::span<const char> moved;            // a surface vertex; 0: it stands where it is at rest
  bool by_morph = false;                  // else by a clip
};

// `scene` holds the positions that `surface` was made from; `source_vertex` maps surface vertices to source
// order. Calls visit() for the poses in their order, several at a time, as many as are worth two threads and
// 64 MB; from this thread.
void forEachPose(const SourceScene& scene, const Surface& surface, const std::vector<uint32_t>& source_vertex,
                 uint32_t threads, const std::function<void(std::span<const SurfacePose>)>& visit);

}  // namespace furrow::pipeline
