#include "editor/session/posed_surface.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "furrow/jobs.h"
#include "pipeline/bake/nearest.h"
#include "pipeline/error.h"

namespace furrow::editor {
namespace {

glm::vec3 toVec(Float3 p) {
  return {p.x, p.y, p.z};
}

}  // namespace

PosedSurface::PosedSurface(const AssetView& asset)
    : asset_(asset), positions_(asset.vertexCount()), rest_(asset.vertexCount()) {
  for (const Part& part : asset.parts)
    for (uint32_t v = part.vertex_begin; v < part.vertex_end; ++v)
      rest_[v] = toVec(transformed(part.rest, asset.positions[v]));
}

void PosedSurface::pose(const FrameInput& input) {
  const DeformJob deform{&asset_, input.palette, input.morph_weights, positions_, {}, {}};
  if (const Status status = deform.validate(); !status.ok())
    throw pipeline::Error(pipeline::Exit::kBadData, "frame", status.message, "cook the asset again");
  deform.run(0, asset_.vertexCount());
}

glm::vec3 PosedSurface::at(uint32_t triangle, glm::vec3 barycentric) const {
  glm::vec3 sum(0.0f);
  for (int c = 0; c < 3; ++c)
    sum += barycentric[c] * toVec(positions_[asset_.indices[3 * size_t{triangle} + c]]);
  return sum;
}

glm::vec3 PosedSurface::restAt(uint32_t triangle, glm::vec3 barycentric) const {
  glm::vec3 sum(0.0f);
  for (int c = 0; c < 3; ++c) sum += barycentric[c] * rest_[asset_.indices[3 * size_t{triangle} + c]];
  return sum;
}

glm::vec3 PosedSurface::restNormal(uint32_t triangle) const {
  const uint32_t* v = &asset_.indices[3 * size_t{triangle}];
  const glm::vec3 n = glm::cross(rest_[v[1]] - rest_[v[0]], rest_[v[2]] - rest_[v[0]]);
  const float length = glm::length(n);
  return length > 0.0f ? n / length : glm::vec3(0.0f);
}

// Moller and Trumbore.
std::optional<SurfaceHit> PosedSurface::hit(glm::vec3 eye, glm::vec3 direction) const {
  std::optional<SurfaceHit> nearest;
  for (uint32_t t = 0; t < asset_.triangleCount(); ++t) {
    const uint32_t* v = &asset_.indices[3 * size_t{t}];
    const glm::vec3 a = toVec(positions_[v[0]]), e1 = toVec(positions_[v[1]]) - a,
                    e2 = toVec(positions_[v[2]]) - a;
    const glm::vec3 p = glm::cross(direction, e2);
    const float determinant = glm::dot(e1, p);
    if (!(std::abs(determinant) > 0.0f)) continue;
    const glm::vec3 from = eye - a;
    const float b1 = glm::dot(from, p) / determinant;
    if (b1 < 0.0f || b1 > 1.0f) continue;
    const glm::vec3 q = glm::cross(from, e1);
    const float b2 = glm::dot(direction, q) / determinant;
    if (b2 < 0.0f || b1 + b2 > 1.0f) continue;
    const float distance = glm::dot(e2, q) / determinant;
    if (distance > 0.0f && (!nearest || distance < nearest->distance))
      nearest = SurfaceHit{t, {1.0f - b1 - b2, b1, b2}, distance};
  }
  return nearest;
}

SurfaceHit PosedSurface::nearestAtRest(glm::vec3 rest) const {
  SurfaceHit nearest;
  float least = INFINITY;
  for (uint32_t t = 0; t < asset_.triangleCount(); ++t) {
    const uint32_t* v = &asset_.indices[3 * size_t{t}];
    const glm::vec3 barycentric(pipeline::nearestPlace({rest_[v[0]], rest_[v[1]], rest_[v[2]]}, rest));
    const glm::vec3 gap = restAt(t, barycentric) - rest;
    const float distance = glm::dot(gap, gap);
    if (!(distance < least)) continue;
    least = distance;
    nearest = {t, barycentric, std::sqrt(distance)};
  }
  return nearest;
}

std::vector<float> PosedSurface::stretches(uint32_t layer, float scale) const {
  std::vector<float> triangle_q(asset_.triangleCount()), q(asset_.pointCount()), stretches;
  const CompressJob compress{&asset_, layer, positions_, scale, triangle_q};
  const SmoothJob smooth{&asset_, triangle_q, q};
  if (!compress.validate().ok() || !smooth.validate().ok()) return stretches;
  compress.run(0, asset_.triangleCount());
  smooth.run(0, asset_.pointCount());
  const std::span<const uint8_t> mask = asset_.layers[layer].mask;
  for (uint32_t p = 0; p < asset_.pointCount(); ++p)
    if (mask.empty() || mask[asset_.point_vertex[p]] > 0)
      stretches.push_back(std::sqrt(std::max(q[p], 0.0f)));
  return stretches;
}

}  // namespace furrow::editor
