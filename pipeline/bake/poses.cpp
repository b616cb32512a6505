#include "pipeline/bake/poses.h"

#include <algorithm>
#include <cmath>

#include "pipeline/parallel.h"
#include "pipeline/scene/posing.h"

namespace furrow::pipeline {
namespace {

constexpr int kMostClipPoses = 64;  // over all clips
constexpr double kPosesASecond = 12.0;
constexpr size_t kMostBytes = size_t{64} << 20;  // of poses at a time

struct Wanted {
  const Clip* clip = nullptr;  // null: a morph target
  double time = 0.0;
  uint32_t morph = 0;
};

class Poser {
 public:
  Poser(const SourceScene& scene, const Surface& surface, const std::vector<uint32_t>& source_vertex)
      : scene_(scene),
        surface_(surface),
        source_vertex_(source_vertex),
        rest_(surface.positions.begin(), surface.positions.end()),
        surface_vertex_(rest_.size()) {
    for (uint32_t v = 0; v < rest_.size(); ++v) surface_vertex_[source_vertex[v]] = v;
  }

  struct Buffer {
    std::vector<glm::dvec3> positions;
    std::vector<char> moved;
    std::vector<uint32_t> touched;  // what moved, of a morph target
    SurfacePose pose() const { return {positions, moved, !touched.empty()}; }
  };

  void fill(const Wanted& wanted, Buffer& out) const {
    if (!wanted.clip) return morph(wanted.morph, out);
    out.touched.clear();
    out.positions.resize(rest_.size());
    out.moved.assign(rest_.size(), 1);
    Pose pose = defaultPose(scene_.rig);
    applyClip(scene_.rig, *wanted.clip, wanted.time, pose);
    const PosedRig posed = evaluate(scene_.rig, pose);
    const double scale = wholeScale(scene_.rig, posed);
    for (const SurfacePart& span : surface_.parts) {
      const std::vector<glm::dvec3> part = posePart(scene_, scene_.parts[span.source_part], posed);
      for (uint32_t v = span.vertex_begin; v < span.vertex_end; ++v)
        out.positions[v] = part[source_vertex_[v] - span.vertex_begin] / scale;
    }
  }

  bool moves(uint32_t morph) const {
    return std::ranges::any_of(surface_.parts, [&](const SurfacePart& span) {
      const MorphDelta* delta = deltaOf(span, morph);
      return delta && !delta->vertices.empty();
    });
  }

 private:
  const MorphDelta* deltaOf(const SurfacePart& span, uint32_t morph) const {
    const Part& part = scene_.parts[span.source_part];
    const std::vector<MorphDelta>& morphs = scene_.primitives[part.primitive].morphs;
    const bool has = morph >= part.first_morph && morph - part.first_morph < morphs.size();
    return has ? &morphs[morph - part.first_morph] : nullptr;
  }

  void morph(uint32_t morph, Buffer& out) const {
    if (out.touched.empty()) {
      out.positions = rest_;
      out.moved.assign(rest_.size(), 0);
    }
    for (const uint32_t v : out.touched) {
      out.positions[v] = rest_[v];
      out.moved[v] = 0;
    }
    out.touched.clear();
    for (const SurfacePart& span : surface_.parts) {
      const MorphDelta* delta = deltaOf(span, morph);
      if (!delta) continue;
      const glm::dmat3 linear(span.rest);
      for (size_t i = 0; i < delta->vertices.size(); ++i) {
        const uint32_t v = surface_vertex_[span.vertex_begin + delta->vertices[i]];
        out.positions[v] += linear * glm::dvec3(delta->positions[i]);
        out.moved[v] = 1;
        out.touched.push_back(v);
      }
    }
  }

  const SourceScene& scene_;
  const Surface& surface_;
  const std::vector<uint32_t>& source_vertex_;
  const std::vector<glm::dvec3> rest_;
  std::vector<uint32_t> surface_vertex_;
};

std::vector<Wanted> posesOf(const SourceScene& scene, const Poser& poser) {
  std::vector<Wanted> poses;
  for (uint32_t m = 0; m < scene.rig.morphs.size() && !scene.sequence; ++m)
    if (poser.moves(m)) poses.push_back({nullptr, 0.0, m});
  double seconds = 0.0;
  for (const Clip& clip : scene.rig.clips) seconds += clip.duration;
  const double rate = std::min(kPosesASecond, kMostClipPoses / std::max(seconds, 1e-6));
  for (const Clip& clip : scene.rig.clips) {
    const int count =
        scene.sequence
            ? static_cast<int>(std::clamp<size_t>(clip.channels[0].times.size(), 2, kMostClipPoses))
            : std::max(3, static_cast<int>(std::lround(clip.duration * rate)));
    for (int i = 0; i < count; ++i) poses.push_back({&clip, clip.duration * i / (count - 1), 0});
  }
  return poses;
}

}  // namespace

void forEachPose(const SourceScene& scene, const Surface& surface, const std::vector<uint32_t>& source_vertex,
                 uint32_t threads, const std::function<void(std::span<const SurfacePose>)>& visit) {
  const Poser poser(scene, surface, source_vertex);
  const std::vector<Wanted> wanted = posesOf(scene, poser);
  const size_t fit = kMostBytes / (surface.positions.size() * sizeof(glm::dvec3) + 1);
  std::vector<Poser::Buffer> buffers(std::clamp<size_t>(fit, 1, 8 * size_t{threads}));
  std::vector<SurfacePose> poses;
  for (size_t first = 0; first < wanted.size(); first += buffers.size()) {
    poses.resize(std::min(buffers.size(), wanted.size() - first));
    parallelFor(static_cast<uint32_t>(poses.size()), threads, [&](uint32_t i) {
      poser.fill(wanted[first + i], buffers[i]);
      poses[i] = buffers[i].pose();
    });
    visit(poses);
  }
}

}  // namespace furrow::pipeline
