#include "pipeline/bake/squeeze.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "pipeline/bake/poses.h"
#include "pipeline/bake/rest_view.h"
#include "pipeline/parallel.h"

namespace furrow::pipeline {
namespace {

constexpr double kNoise = 0.01;  // a squeeze below one percent is not one
constexpr double kSeen = 0.05;   // from which one by a morph target counts as its work

class Meter {
 public:
  Meter(const Surface& surface, Squeeze& squeeze) : squeeze_(squeeze), rest_(surface.triangles.size()) {
    squeeze.tensor.assign(surface.triangles.size(), glm::vec3(0.0f));
    squeeze.peak.assign(surface.triangles.size(), 0.0f);
    squeeze.by_morph.assign(surface.triangles.size(), 0);
    for (size_t t = 0; t < rest_.size(); ++t) {
      const glm::uvec3 corners = surface.triangles[t];
      const TriangleFrame frame = triangleFrame(surface.positions[corners.x], surface.positions[corners.y],
                                                surface.positions[corners.z]);
      if (frame.e1x * frame.e2y > 0.0 && !isDegenerate(restView(surface), t))
        rest_[t] = {static_cast<float>(frame.e1x), static_cast<float>(frame.e2x),
                    static_cast<float>(frame.e2y)};
    }
  }

  void measure(size_t t, glm::dvec3 a, glm::dvec3 b, glm::dvec3 c, bool by_morph) {
    const Rest rest = rest_[t];
    if (rest.e1x == 0.0f) return;
    const glm::dvec3 f1 = (b - a) / double{rest.e1x};
    const glm::dvec3 f2 = ((c - a) - f1 * double{rest.e2x}) / double{rest.e2y};
    const double xx = glm::dot(f1, f1), xy = glm::dot(f1, f2), yy = glm::dot(f2, f2);
    const double half = 0.5 * (xx - yy);
    const double spread = std::sqrt(half * half + xy * xy);
    const double smallest = std::sqrt(std::max(0.0, 0.5 * (xx + yy) - spread));
    const double s = 1.0 - smallest;
    if (!(s > kNoise)) return;
    // Double angle of the direction of the smallest stretch is opposite to that of the largest.
    const double cos2 = spread > 0.0 ? -half / spread : 0.0;
    const double sin2 = spread > 0.0 ? -xy / spread : 0.0;
    const double weight = s * s;
    squeeze_.tensor[t] +=
        glm::vec3(weight * 0.5 * (1.0 + cos2), weight * 0.5 * sin2, weight * 0.5 * (1.0 - cos2));
    squeeze_.peak[t] = std::max(squeeze_.peak[t], static_cast<float>(s));
    if (by_morph && s > kSeen) squeeze_.by_morph[t] = 1;
  }

 private:
  struct Rest {
    float e1x = 0.0f, e2x = 0.0f, e2y = 0.0f;  // as in TriangleFrame; zero: no plane
  };

  Squeeze& squeeze_;
  std::vector<Rest> rest_;
};

}  // namespace

TriangleFrame triangleFrame(glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) {
  TriangleFrame frame{};
  frame.e1x = glm::length(b - a);
  frame.x = frame.e1x > 0.0 ? (b - a) / frame.e1x : glm::dvec3(1.0, 0.0, 0.0);
  frame.e2x = glm::dot(c - a, frame.x);
  const glm::dvec3 up = (c - a) - frame.e2x * frame.x;
  frame.e2y = glm::length(up);
  frame.y = frame.e2y > 0.0 ? up / frame.e2y : glm::dvec3(0.0);
  return frame;
}

Squeeze measureSqueeze(const SourceScene& scene, const Surface& surface,
                       const std::vector<uint32_t>& source_vertex, uint32_t threads) {
  Squeeze squeeze;
  Meter meter(surface, squeeze);
  forEachPose(scene, surface, source_vertex, threads, [&](std::span<const SurfacePose> poses) {
    parallelRanges(surface.triangles.size(), threads, [&](size_t begin, size_t end) {
      for (const SurfacePose& pose : poses)
        for (size_t t = begin; t < end; ++t) {
          const glm::uvec3 c = surface.triangles[t];
          if (pose.moved[c.x] | pose.moved[c.y] | pose.moved[c.z])
            meter.measure(t, pose.positions[c.x], pose.positions[c.y], pose.positions[c.z], pose.by_morph);
        }
    });
  });
  squeeze.any = std::ranges::any_of(squeeze.peak, [](float peak) { return peak > 0.0f; });
  return squeeze;
}

}  // namespace furrow::pipeline
