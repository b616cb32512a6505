#include "furrow/recapture.h"

#include <algorithm>
#include <cmath>

#include "rest_surface.h"

namespace furrow {
namespace {

Status checkPose(std::span<const Float3> positions, float scale, const AssetView& asset) {
  if (positions.size() < asset.vertexCount())
    return Status::error(StatusCode::kInvalidArgument, "recapture: positions are too short");
  if (!(scale > 0.0f) || !std::isfinite(scale))
    return Status::error(StatusCode::kInvalidArgument, "recapture: scale is not positive");
  return {};
}

bool measures(std::span<const float> c) {
  return std::any_of(c.begin(), c.end(), [](float value) { return value != 0.0f; });
}

// What takes the place of a triangle's coefficients `c` in a pose of its corners; zeros: nothing.
void recapture(Measure measure, std::span<float> c, Float3 (&p)[3], float scale) {
  if (!measures(c)) return;
  const float before[2] = {c[0], c.size() > 1 ? c[1] : 0.0f};
  std::ranges::fill(c, 0.0f);
  for (Float3& at : p) at = {at.x / scale, at.y / scale, at.z / scale};
  if (isNeedle(p[0], p[1], p[2])) return;
  if (measure != Measure::kDirectional) {
    const uint32_t corners[] = {0, 1, 2};
    float numbers[3] = {};
    makeCoefficients({p, corners, corners}, measure, {}, 0, 1, numbers);
    std::copy_n(numbers, c.size(), c.begin());
    return;
  }
  const auto along = [&](auto coordinate) {
    return double{before[0]} * (double{coordinate(p[1])} - coordinate(p[0])) +
           double{before[1]} * (double{coordinate(p[2])} - coordinate(p[0]));
  };
  const double x = along([](Float3 v) { return v.x; }), y = along([](Float3 v) { return v.y; }),
               z = along([](Float3 v) { return v.z; });
  const double length = std::sqrt((x * x + y * y) + z * z);
  for (size_t k = 0; k < 2; ++k) c[k] = static_cast<float>(before[k] / length);
  if (!std::isfinite(c[0]) || !std::isfinite(c[1])) std::ranges::fill(c, 0.0f);
}

// Where number k of triangle t of a cluster lies among a layer's coefficients.
size_t laneOf(uint32_t t, uint32_t k, uint32_t each) {
  return size_t{t / kTriangleLanes * each + k} * kTriangleLanes + t % kTriangleLanes;
}

void recaptureTriangles(const ClusterRecaptureJob& job, const Cluster& c, Measure measure, const float* from,
                        float* to) {
  const uint32_t each = coefficientCount(measure);
  const uint32_t* vertex = &job.clusters->words[c.slot_vertex];
  const auto* corner = reinterpret_cast<const uint16_t*>(&job.clusters->words[c.corners]);
  for (uint32_t t = 0; t < c.triangles; ++t, corner += 3) {
    float numbers[3];
    Float3 p[3];
    for (uint32_t k = 0; k < 3; ++k) p[k] = job.positions[vertex[corner[k] / 4]];
    for (uint32_t k = 0; k < each; ++k) numbers[k] = from[laneOf(t, k, each)];
    recapture(measure, {numbers, each}, p, job.scale);
    for (uint32_t k = 0; k < each; ++k) to[laneOf(t, k, each)] = numbers[k];
  }
}

// The weights of each ring that are in the layer.
void weighRings(const Clusters& clusters, const Cluster& c, uint32_t each, const float* coefficients,
                uint16_t* totals) {
  const auto measured = [&](uint32_t t) {
    for (uint32_t k = 0; k < each; ++k)
      if (coefficients[laneOf(t, k, each)] != 0.0f) return true;
    return false;
  };
  std::fill_n(totals, (c.points + kTriangleLanes - 1) / kTriangleLanes * kTriangleLanes, uint16_t{0});
  const uint32_t* chunk = &clusters.words[c.chunks];
  for (uint32_t point = 0; point < c.points; point += kRingLanes, ++chunk) {
    const auto* end = reinterpret_cast<const uint16_t*>(clusters.words.data() + chunk[1]);
    for (const auto* entry = reinterpret_cast<const uint16_t*>(clusters.words.data() + chunk[0]); entry < end;
         entry += 2 * kRingLanes)
      for (uint32_t lane = 0; lane < kRingLanes; ++lane)
        if (measured(entry[lane])) totals[point + lane] += entry[kRingLanes + lane];
  }
}

}  // namespace

Status RecaptureJob::validate() const {
  if (!asset) return Status::error(StatusCode::kInvalidArgument, "recapture: no asset");
  if (layer >= asset->layerCount())
    return Status::error(StatusCode::kInvalidArgument, "recapture: layer %u, the asset has %u", layer,
                         asset->layerCount());
  if (coefficients.size() < size_t{asset->triangleCount()} * coefficientCount(asset->layers[layer].measure))
    return Status::error(StatusCode::kInvalidArgument, "recapture: coefficients are too short");
  return checkPose(positions, scale, *asset);
}

void RecaptureJob::run(uint32_t begin, uint32_t end) const {
  const Layer& from = asset->layers[layer];
  const size_t each = coefficientCount(from.measure);
  for (size_t t = begin; each > 0 && t < end; ++t) {
    Float3 p[3];
    for (size_t k = 0; k < 3; ++k) p[k] = positions[asset->surface_indices[3 * t + k]];
    std::copy_n(&from.coefficients[each * t], each, &coefficients[each * t]);
    recapture(from.measure, coefficients.subspan(each * t, each), p, scale);
  }
}

Status ClusterRecaptureJob::validate() const {
  if (!clusters || !clusters->asset)
    return Status::error(StatusCode::kInvalidArgument, "recapture: no clusters");
  if (rest.size() < clusters->restWords())
    return Status::error(StatusCode::kInvalidArgument, "recapture: the rest is too short");
  return checkPose(positions, scale, *clusters->asset);
}

void ClusterRecaptureJob::run(uint32_t begin, uint32_t end) const {
  const uint32_t layers = clusters->asset->layerCount();
  for (uint32_t i = begin; i < end; ++i) {
    const Cluster& c = clusters->clusters[i];
    for (uint32_t l = 0; l < layers; ++l) {
      if (!(c.covered >> l & 1u)) continue;
      const Measure measure = clusters->asset->layers[l].measure;
      const uint32_t word = clusters->layer_words[size_t{i} * layers + l];
      auto* out = reinterpret_cast<float*>(&rest[c.rest + (word - c.layers)]);
      recaptureTriangles(*this, c, measure, reinterpret_cast<const float*>(&clusters->words[word]), out);
      const size_t coefficients = size_t{c.triangles} * coefficientCount(measure);
      weighRings(*clusters, c, coefficientCount(measure), out,
                 reinterpret_cast<uint16_t*>(out + coefficients));
    }
  }
}

}  // namespace furrow
