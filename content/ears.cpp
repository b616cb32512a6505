#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <map>
#include <span>

#include "content/face_parts.h"
#include "content/head.h"
#include "content/solids.h"
#include "content/surface_net.h"

// The ear is sculpted as a distance like the head, joined to it, and meshed by surface nets [Gibson 1998]
// where it stands out of the head.

namespace furrow::content {
namespace {

using glm::dvec2;
using glm::dvec3;

// In the ear's own frame: u to the back, v up, w away from the head, from the mouth of the ear canal.
struct Frame {
  dvec3 origin{7.05, -2.75, -7.3};
  dvec3 u = glm::normalize(dvec3(0.40, 0.14, -0.90));
  dvec3 w = glm::normalize(glm::cross(u, dvec3(0.06, 1.0, 0.16)));
  dvec3 v = glm::cross(w, u);
  dvec3 local(dvec3 p) const {
    const dvec3 q = p - origin;
    return {glm::dot(q, u), glm::dot(q, v), glm::dot(q, w)};
  }
};

double tube(dvec3 p, std::span<const glm::dvec4> nodes) {
  double best = 1e9;
  for (size_t k = 0; k + 1 < nodes.size(); ++k) {
    const dvec3 a(nodes[k]), b(nodes[k + 1]), e = b - a;
    const double t = std::clamp(glm::dot(p - a, e) / glm::dot(e, e), 0.0, 1.0);
    best = std::min(best, glm::distance(p, glm::mix(a, b, t)) - glm::mix(nodes[k].w, nodes[k + 1].w, t));
  }
  return best;
}

// Position and radius along the ridges: the helix from its root in the bowl to the lobe, the antihelix with
// its two legs.
constexpr std::array<glm::dvec4, 14> kHelix{{{0.55, 0.05, 0.30, 0.14},
                                             {0.0, 0.2, 0.50, 0.20},
                                             {-0.45, 0.75, 0.62, 0.26},
                                             {-0.55, 1.55, 0.72, 0.29},
                                             {-0.2, 2.35, 0.85, 0.30},
                                             {0.45, 2.85, 0.98, 0.30},
                                             {1.2, 2.95, 1.10, 0.30},
                                             {1.85, 2.65, 1.18, 0.30},
                                             {2.25, 2.05, 1.22, 0.29},
                                             {2.38, 1.25, 1.20, 0.27},
                                             {2.25, 0.4, 1.10, 0.25},
                                             {1.95, -0.4, 0.98, 0.24},
                                             {1.6, -1.1, 0.85, 0.25},
                                             {1.25, -1.7, 0.72, 0.27}}};
constexpr std::array<glm::dvec4, 6> kAntihelix{{{0.75, -1.15, 0.74, 0.22},
                                                {1.2, -0.75, 0.86, 0.24},
                                                {1.45, -0.05, 0.98, 0.25},
                                                {1.42, 0.65, 1.02, 0.25},
                                                {1.2, 1.3, 1.00, 0.24},
                                                {1.15, 2.1, 0.92, 0.2}}};
constexpr std::array<glm::dvec4, 3> kLowerLeg{
    {{1.3, 1.0, 1.00, 0.22}, {0.75, 1.35, 0.82, 0.2}, {0.1, 1.5, 0.62, 0.16}}};

}  // namespace

double earDistance(dvec3 point) {
  static const Frame frame;
  const dvec3 p = frame.local(point);
  // The shell stands away from the head towards the back.
  const double lift = 0.5 + 0.20 * p.x;
  double d = ellipsoid({p.x, p.y, p.z - lift}, {0.95, 0.75, 0.0}, {1.55, 2.25, 0.22});
  d = join(d, ellipsoid({p.x, p.y, p.z - lift}, {0.75, -1.2, 0.0}, {0.95, 1.3, 0.22}), 0.3);
  d = join(d, ellipsoid(p, {0.5, -0.1, -0.1}, {0.95, 1.5, 0.75}), 0.5);
  d = join(d, ellipsoid(p, {0.6, -2.15, 0.5}, {0.72, 0.78, 0.26}), 0.35);
  d = carve(d, ellipsoid(p, {0.5, -0.2, 0.85}, {0.78, 0.95, 0.75}), 0.25);
  d = join(d, tube(p, kAntihelix), 0.22);
  d = join(d, tube(p, kLowerLeg), 0.2);
  d = join(d, tube(p, kHelix), 0.16);
  d = join(d, ellipsoid(p, {0.62, -1.25, 0.72}, {0.34, 0.28, 0.28}), 0.25);
  d = join(d, ellipsoid(p, {-0.40, -0.5, 0.42}, {0.34, 0.62, 0.42}), 0.35);
  return d;
}

namespace {

double headWithEar(dvec3 p) {
  return join(head::distance(p), earDistance(p), 0.3);
}

}  // namespace

FacePart ears() {
  const SurfaceNet net = surfaceNet(headWithEar, {5.6, -6.0, -11.2}, {9.8, 1.0, -5.6}, 0.165);
  FacePart part;
  for (dvec3 p : net.points) {
    // Its rim lies under the skin, which is coarser there.
    p -= head::normal(p) * 0.09 * smoothRamp(0.07, 0.0, head::distance(p));
    part.addPoint(p, p.y < head::lipLine(0), p.y < 0);
  }
  static const Frame frame;
  // A chart each for what faces out and what faces in.
  std::map<std::pair<uint32_t, bool>, uint32_t> vertex_of;
  for (const std::array<uint32_t, 4>& quad : net.quads) {
    // What lies on the bare head is the skin's.
    const auto stands_out = [&](uint32_t p) { return head::distance(net.points[p]) > 0.004; };
    if (std::ranges::none_of(quad, stands_out)) continue;
    const dvec3 normal =
        glm::cross(net.points[quad[2]] - net.points[quad[0]], net.points[quad[3]] - net.points[quad[1]]);
    const bool outward = glm::dot(normal, frame.w) > 0;
    std::array<uint32_t, 4> corners{};
    for (int k = 0; k < 4; ++k) {
      const auto [slot, fresh] =
          vertex_of.try_emplace({quad[k], outward}, static_cast<uint32_t>(part.mesh.vertices.size()));
      if (fresh) {
        const dvec3 q = frame.local(net.points[quad[k]]);
        part.mesh.addVertex(quad[k],
                            {(outward ? 0.02 : 0.52) + (q.x + 2.0) * 0.08, 0.05 + (q.y + 4.0) * 0.11});
      }
      corners[k] = slot->second;
    }
    part.mesh.addQuad(corners[0], corners[1], corners[2], corners[3]);
  }
  for (SurfaceMesh::Vertex& vertex : part.mesh.vertices) vertex.uv = glm::clamp(vertex.uv, 0.0, 1.0);

  for (const dvec3& p : part.mesh.points) {
    const dvec3 n = glm::normalize(slopeOf(headWithEar, p));
    // Thin, and full of blood.
    part.colors.push_back(
        skinColor(p) * skinOcclusion(p, n) *
        glm::mix(dvec3(1), dvec3(1.04, 0.86, 0.82), smoothRamp(0.05, 0.6, head::distance(p))));
  }
  part.materials.assign(part.mesh.triangles.size(), kEar);

  return withMirrorImage(std::move(part));
}

}  // namespace furrow::content
