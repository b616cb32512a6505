#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>

#include "content/models.h"
#include "content/noise.h"
#include "content/surface_mesh.h"

// A square of cloth that hangs from its upper edge; metres, facing +Z.

namespace furrow::content {
namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double kHalf = 0.30;       // of the side
constexpr dvec2 kPinch{0.02, 0.03};  // where two fingers gather it

double gauss(double x) {
  return std::exp(-x * x);
}

dvec3 atRest(dvec2 p) {
  const double low = (kHalf - p.y) / (2 * kHalf);  // 0 at the edge that holds it
  const double hang =
      0.006 * low * std::sin(9.0 * p.x + 2.0 * low) + 0.004 * valueNoise({p.x * 7, p.y * 4, 2});
  return {p.x, p.y, hang};
}

// The lower edge is drawn aside; the upper one stays.
dvec3 shear(dvec2 p) {
  const double low = (kHalf - p.y) / (2 * kHalf);
  return {0.24 * low, 0.035 * low * low,
          0.015 * low * std::sin(glm::pi<double>() * (p.x + kHalf) / (2 * kHalf))};
}

dvec3 pinch(dvec2 p) {
  const dvec2 q = p - kPinch;
  const double r = glm::length(q);
  return dvec3(-q * 0.62 * gauss(r / 0.12), 0.055 * gauss(r / 0.055) + 0.012 * gauss(r / 0.14));
}

// Two hands push the sides together.
dvec3 squeeze(dvec2 p) {
  return {-0.26 * p.x, 0.0, 0.012 * std::cos(glm::pi<double>() * p.x / (2 * kHalf))};
}

}  // namespace

Scene buildPanel() {
  constexpr uint32_t kSide = 96;
  SurfaceMesh mesh;
  std::vector<dvec2> flat;
  for (uint32_t j = 0; j <= kSide; ++j)
    for (uint32_t i = 0; i <= kSide; ++i) {
      const dvec2 uv(static_cast<double>(i) / kSide, static_cast<double>(j) / kSide);
      flat.push_back((2.0 * uv - 1.0) * kHalf);
      mesh.points.push_back(atRest(flat.back()));
      mesh.addVertex(j * (kSide + 1) + i, 0.01 + 0.98 * uv);
    }
  for (uint32_t j = 0; j < kSide; ++j)
    for (uint32_t i = 0; i < kSide; ++i) {
      const uint32_t a = j * (kSide + 1) + i, b = a + kSide + 1;
      mesh.addQuad(a, a + 1, b + 1, b);
    }

  const std::vector<dvec3> normals = pointNormals(mesh, mesh.points);
  Mesh panel;
  panel.name = "Panel";
  Primitive& cloth = panel.primitives.emplace_back();
  std::vector<glm::vec3> around_pinch;
  std::vector<glm::vec4> masks;
  for (size_t p = 0; p < flat.size(); ++p) {
    cloth.positions.emplace_back(mesh.points[p]);
    cloth.normals.emplace_back(normals[p]);
    cloth.uvs.emplace_back(mesh.vertices[p].uv.x, 1 - mesh.vertices[p].uv.y);
    const dvec2 q = flat[p] - kPinch;
    around_pinch.emplace_back(glm::length(q) > 1e-9 ? glm::normalize(glm::vec3(-q.y, q.x, 0))
                                                    : glm::vec3(1, 0, 0));
    masks.emplace_back(smoothRamp(0.24, 0.10, glm::length(q)), 0, 0, 1);
    // A woven check with a hem.
    const double edge = kHalf - std::max(std::abs(flat[p].x), std::abs(flat[p].y));
    const auto band = [](double x) {
      return smoothRamp(0.25, 0.4, std::abs(std::fmod(x / 0.15 + 10.25, 1.0) - 0.5));
    };
    const double check = 0.5 * (band(flat[p].x) + band(flat[p].y));
    const dvec3 color = glm::mix(dvec3(0.42, 0.075, 0.06), dvec3(0.60, 0.48, 0.36), check);
    cloth.colors.emplace_back(glm::vec3(color * (edge < 0.016 ? 0.6 : 1.0)), 1.0f);
  }
  for (const SurfaceMesh::Triangle& triangle : mesh.triangles)
    cloth.indices.insert(cloth.indices.end(), triangle.vertices.begin(), triangle.vertices.end());
  cloth.vec3_attributes = {{"_DIR_PINCH", std::move(around_pinch)}};
  cloth.vec4_attributes = {{"_MASK_A", std::move(masks)}};

  for (const auto& [name, move] :
       {std::pair{"shear", &shear}, std::pair{"pinch", &pinch}, std::pair{"squeeze", &squeeze}}) {
    panel.morphs.emplace_back(name);
    Morph& morph = cloth.morphs.emplace_back();
    std::vector<dvec3> posed;
    for (size_t p = 0; p < flat.size(); ++p) posed.push_back(mesh.points[p] + move(flat[p]));
    const std::vector<dvec3> posed_normals = pointNormals(mesh, posed);
    for (size_t p = 0; p < flat.size(); ++p) {
      morph.positions.emplace_back(posed[p] - mesh.points[p]);
      morph.normals.emplace_back(posed_normals[p] - normals[p]);
    }
  }

  Scene scene;
  scene.materials = {{"cloth", glm::vec3(1), 0.8f, true}};
  scene.meshes = {std::move(panel)};
  scene.nodes = {{"Panel", -1, {}, 0}};
  Clip clip;
  clip.name = "pull";
  clip.weights.push_back({0, {}});
  for (int key = 0; key <= 180; ++key) {
    const double t = key / 30.0;
    const auto pulse = [t](double begin) {
      return static_cast<float>(smoothRamp(begin, begin + 0.8, t) * smoothRamp(begin + 2.0, begin + 1.2, t));
    };
    clip.times.push_back(static_cast<float>(t));
    clip.weights[0].weights.push_back({pulse(0.0), pulse(2.0), pulse(4.0)});
  }
  scene.clips = {std::move(clip)};
  return scene;
}

}  // namespace furrow::content
