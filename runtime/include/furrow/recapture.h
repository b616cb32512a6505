#pragma once

// An instance's own rest: the pose handed in becomes the one in which its surface is relaxed, so that a
// character scanned, dressed or sculpted away from the asset's shape does not wrinkle as it stands.

#include <span>

#include "furrow/asset.h"
#include "furrow/cluster_frame.h"

namespace furrow {

// What the triangles of one layer are measured with after a recapture; the wrinkle direction is carried along
// with the surface. In the captured pose q is 1 on every triangle. Items: triangles.
//
//   directional  c / |c1 e1' + c2 e2'|, e' the captured edges
//   area         1 / (2 A'), A' the captured area
//   principal    as the cook makes them, from the captured edges
//
// Triangles that the layer leaves out stay out, and those that are degenerate or not finite in the captured
// pose join them. Weights of the rings stay the asset's: they only say how a point averages.
//
// An instance then uses its own copy of the view, which goes everywhere an asset is asked for:
//
//   std::vector<furrow::Layer> layers(view.layers.begin(), view.layers.end());
//   layers[l].coefficients = coefficients;  // of the instance
//   furrow::AssetView own = view;
//   own.layers = layers;
//
struct RecaptureJob {
  const AssetView* asset = nullptr;
  uint32_t layer = 0;
  std::span<const Float3> positions;  // of the new rest, a vertex
  float scale = 1.0f;                 // uniform scale of the instance that `positions` contain, > 0
  std::span<float> coefficients;      // out, coefficientCount(measure) a triangle

  Status validate() const;
  void run(uint32_t begin, uint32_t end) const;
};

// The same for the clustered frame, of all layers: ClusterFrameJob::rest, with the weights of the staged jobs
// to the bit. The asset's clusters serve all instances, recaptured or not. Items: clusters.
struct ClusterRecaptureJob {
  const Clusters* clusters = nullptr;
  std::span<const Float3> positions;  // of the new rest, a vertex
  float scale = 1.0f;                 // uniform scale of the instance that `positions` contain, > 0
  std::span<uint32_t> rest;           // out, Clusters::restWords(), aligned to 64

  Status validate() const;
  void run(uint32_t begin, uint32_t end) const;
};

}  // namespace furrow
