#include "pipeline/bake/poses.h"

#include <algorithm>
#include <cmath>

#include "pipeline/scene/posing.h"

namespace furrow::pipeline {
namespace {

constexpr int kMostClipPoses = 64;  // over all clips
constexpr double kPosesASecond = 12.0;

}  // namespace

void forEachPose(const SourceScene& scene, const Surface& surface, const std::vector<uint32_t>& source_vertex,
                 const std::function<void(const SurfacePose&)>& visit) {
  const std::vector<glm::dvec3> rest(surface.positions.begin(), surface.positions.end());
  std::vector<glm::dvec3> positions = rest;
  std::vector<char> moved(rest.size(), 0);
  std::vector<uint32_t> surface_vertex(rest.size());
  for (uint32_t v = 0; v < rest.size(); ++v) surface_vertex[source_vertex[v]] = v;

  std::vector<uint32_t> touched;
  for (uint32_t m = 0; m < scene.rig.morphs.size() && !scene.sequence; ++m) {
    for (const SurfacePart& span : surface.parts) {
      const Part& part = scene.parts[span.source_part];
      const Primitive& primitive = scene.primitives[part.primitive];
      if (m < part.first_morph || m - part.first_morph >= primitive.morphs.size()) continue;
      const MorphDelta& delta = primitive.morphs[m - part.first_morph];
      const glm::dmat3 linear(span.rest);
      for (size_t i = 0; i < delta.vertices.size(); ++i) {
        const uint32_t v = surface_vertex[span.vertex_begin + delta.vertices[i]];
        positions[v] += linear * glm::dvec3(delta.positions[i]);
        moved[v] = 1;
        touched.push_back(v);
      }
    }
    if (!touched.empty()) visit({positions, moved, true});
    for (uint32_t v : touched) {
      positions[v] = rest[v];
      moved[v] = 0;
    }
    touched.clear();
  }

  std::fill(moved.begin(), moved.end(), char{1});
  double seconds = 0.0;
  for (const Clip& clip : scene.rig.clips) seconds += clip.duration;
  const double rate = std::min(kPosesASecond, kMostClipPoses / std::max(seconds, 1e-6));
  for (const Clip& clip : scene.rig.clips) {
    const int poses =
        scene.sequence
            ? static_cast<int>(std::clamp<size_t>(clip.channels[0].times.size(), 2, kMostClipPoses))
            : std::max(3, static_cast<int>(std::lround(clip.duration * rate)));
    for (int i = 0; i < poses; ++i) {
      Pose pose = defaultPose(scene.rig);
      applyClip(scene.rig, clip, clip.duration * i / (poses - 1), pose);
      const PosedRig posed = evaluate(scene.rig, pose);
      const double scale = wholeScale(scene.rig, posed);
      for (const SurfacePart& span : surface.parts) {
        const std::vector<glm::dvec3> part = posePart(scene, scene.parts[span.source_part], posed);
        for (uint32_t v = span.vertex_begin; v < span.vertex_end; ++v)
          positions[v] = part[source_vertex[v] - span.vertex_begin] / scale;
      }
      visit({positions, moved, false});
    }
  }
}

}  // namespace furrow::pipeline
