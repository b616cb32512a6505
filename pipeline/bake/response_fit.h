#pragma once

// Fits the response of a layer to the animation: how strongly it is squeezed there, and the lambda and beta
// that turn that squeeze into a chosen weight.

#include <span>
#include <vector>

#include "furrow/asset.h"
#include "pipeline/bake/poses.h"

namespace furrow {
struct Rings;
}

namespace furrow::pipeline {

struct MeasuredLayer {
  Measure measure;
  std::span<const float> coefficients;  // coefficientCount(measure) a triangle
  std::span<const float> strength;      // a point: 0: it is not asked about
};

// Per layer and point, the largest alpha over all poses of bake/poses.h: measured and smoothed by the
// runtime's own jobs, from poses that are not quantised as those of an asset are. 1 where nobody asks.
std::vector<std::vector<float>> largestAlpha(const SourceScene& scene, const Surface& surface,
                                             const std::vector<uint32_t>& source_vertex, const Rings& rings,
                                             std::span<const MeasuredLayer> layers, uint32_t threads);

// The alpha that 95% of a layer's area stay at or below. A point's area is a third of that of the `covered`
// triangles around it, times its mask `strength`. 1 for a layer without area.
double percentile95(const Surface& surface, const std::vector<bool>& covered,
                    const std::vector<float>& strength, const std::vector<float>& alpha);

struct ResponseFit {
  Response response;    // of Larsson's curve
  double weight = 0.0;  // that it gives to the squeeze it was fitted to
};

// The response that gives `target`, in (0, 1), to a squeeze of `alpha`, which must be above 1: lambda 1 and
// beta from 1 to 16; a larger lambda where beta would have to be below 1; beta 16 and a weight that falls
// short where it would have to be above 16.
ResponseFit fitResponse(double alpha, double target);

}  // namespace furrow::pipeline
