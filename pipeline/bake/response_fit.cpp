#include "pipeline/bake/response_fit.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>

#include "furrow/jobs.h"
#include "pipeline/legible.h"
#include "pipeline/parallel.h"
#include "rest_surface.h"

namespace furrow::pipeline {
namespace {

constexpr double kShare = 0.95;
constexpr double kLeastBeta = 1.0, kMostBeta = 16.0;
constexpr uint32_t kGap = 16;  // items between two runs that cost less than another run

constexpr size_t kLarge =
    1'000'000;  // triangles from which on layers are not measured at once, to save memory

struct Run {
  uint32_t begin = 0, end = 0;
};

std::vector<Run> runsOf(const std::vector<bool>& wanted) {
  std::vector<Run> runs;
  for (uint32_t i = 0; i < wanted.size(); ++i) {
    if (!wanted[i]) continue;
    if (runs.empty() || i > runs.back().end + kGap) runs.push_back({i, i});
    runs.back().end = i + 1;
  }
  return runs;
}

// The points where a layer shows, and the triangles round them.
struct Reach {
  std::vector<Run> points, triangles;
};

Reach reachOf(const MeasuredLayer& layer, const Rings& rings, size_t triangle_count) {
  std::vector<bool> points(layer.strength.size()), triangles(triangle_count);
  for (size_t p = 0; p < points.size(); ++p) points[p] = layer.strength[p] > 0.0f;
  Reach reach{runsOf(points), {}};
  for (const Run& run : reach.points)
    for (uint32_t i = rings.offsets[run.begin]; i < rings.offsets[run.end]; ++i)
      triangles[rings.triangles[i]] = true;
  reach.triangles = runsOf(triangles);
  return reach;
}

}  // namespace

std::vector<std::vector<float>> largestAlpha(const SourceScene& scene, const Surface& surface,
                                             const std::vector<uint32_t>& source_vertex, const Rings& rings,
                                             std::span<const MeasuredLayer> layers, uint32_t threads) {
  const size_t points = surface.point_positions.size(), triangles = surface.triangles.size();
  // As much of an asset as the jobs read.
  std::vector<uint32_t> point_vertex(points, kNoIndex), corners;
  for (uint32_t v = 0; v < surface.vertex_point.size(); ++v)
    if (uint32_t& stands = point_vertex[surface.vertex_point[v]]; stands == kNoIndex) stands = v;
  for (size_t t = 0; t < triangles; ++t)
    for (int c = 0; c < 3; ++c) corners.push_back(point_vertex[surface.trianglePoints(t)[c]]);
  std::vector<Layer> asset_layers(layers.size());
  for (size_t l = 0; l < layers.size(); ++l) {
    asset_layers[l].measure = layers[l].measure;
    asset_layers[l].coefficients = layers[l].coefficients;
  }
  AssetView asset;
  asset.surface_indices = corners;
  asset.ring_offsets = rings.offsets;
  asset.ring_triangles = rings.triangles;
  asset.ring_weights = rings.weights;
  asset.layers = asset_layers;

  std::vector<Reach> reaches;
  for (const MeasuredLayer& layer : layers) reaches.push_back(reachOf(layer, rings, triangles));

  std::vector<std::vector<float>> largest(layers.size(), std::vector<float>(points, 1.0f));
  std::vector<std::vector<Float3>> posed;
  forEachPose(scene, surface, source_vertex, threads, [&](std::span<const SurfacePose> poses) {
    posed.resize(poses.size());
    parallelFor(static_cast<uint32_t>(poses.size()), threads, [&](uint32_t i) {
      posed[i].resize(poses[i].positions.size());
      std::ranges::transform(poses[i].positions, posed[i].begin(), [&](const glm::dvec3& position) {
        const glm::vec3 p(position - poses[i].positions[0]);
        return Float3{p.x, p.y, p.z};
      });
    });
    const bool large = triangles > kLarge;
    parallelFor(static_cast<uint32_t>(layers.size()), large ? 1 : threads, [&](uint32_t l) {
      std::vector<float> triangle_q(triangles), q(points);
      for (const std::vector<Float3>& positions : posed) {
        for (const Run& run : reaches[l].triangles)
          CompressJob{&asset, l, positions, 1.0f, triangle_q}.run(run.begin, run.end);
        for (const Run& run : reaches[l].points) {
          SmoothJob{&asset, triangle_q, q}.run(run.begin, run.end);
          for (uint32_t p = run.begin; p < run.end; ++p)
            largest[l][p] = std::max(largest[l][p], 1.0f / std::max(q[p], kMinQ));
        }
      }
    });
  });
  return largest;
}

double percentile95(const Surface& surface, const std::vector<bool>& covered,
                    const std::vector<float>& strength, const std::vector<float>& alpha) {
  std::vector<double> area(alpha.size(), 0.0);
  for (size_t t = 0; t < surface.triangles.size(); ++t) {
    if (!covered[t]) continue;
    const glm::uvec3 p = surface.trianglePoints(t);
    const glm::dvec3 a = surface.point_positions[p.x];
    const double third = glm::length(glm::cross(glm::dvec3(surface.point_positions[p.y]) - a,
                                                glm::dvec3(surface.point_positions[p.z]) - a)) /
                         6.0;
    for (int c = 0; c < 3; ++c) area[p[c]] += third * double{strength[p[c]]};
  }
  std::vector<uint32_t> order(alpha.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return alpha[a] < alpha[b]; });
  const double wanted = kShare * std::accumulate(area.begin(), area.end(), 0.0);
  double below = 0.0;
  for (uint32_t p : order) {
    below += area[p];
    if (below >= wanted && area[p] > 0.0) return double{alpha[p]};
  }
  return 1.0;
}

ResponseFit fitResponse(double alpha, double target) {
  // I(alpha) = target where (alpha / lambda)^beta = (1 + target) / (1 - target).
  const double ratio = (1.0 + target) / (1.0 - target);
  const double beta = std::clamp(std::log(ratio) / std::log(alpha), kLeastBeta, kMostBeta);
  const double lambda = std::max(1.0, alpha / std::pow(ratio, 1.0 / beta));
  ResponseFit fit;
  fit.response.lambda = fit.response.stretch_lambda = static_cast<float>(legible(lambda));
  fit.response.beta = fit.response.stretch_beta = static_cast<float>(legible(beta));
  fit.weight = double{respond(fit.response, static_cast<float>(1.0 / alpha), 0.0f, 0.0f)};
  return fit;
}

}  // namespace furrow::pipeline
