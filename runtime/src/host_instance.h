#pragma once

#include <span>

#include "furrow/jobs.h"
#include "furrow/recapture.h"
#include "host_asset.h"

// One block of memory: this, then the arrays.
struct FurrowInstance {
  FurrowInstance(FurrowAsset& of, uint32_t with) : asset(of), features(with) {}

  FurrowAsset& asset;
  uint32_t features;
  size_t bytes = 0;
  bool own_memory = false;

  std::span<int16_t> weights;
  std::span<furrow::Float3> positions, normals;  // empty: not kept
  std::span<furrow::Float4> tangents;
  std::span<furrow::JointMotion> motions;
  std::span<float> morph_weights;  // zeros, for hosts that give none
  std::span<std::span<const float>> occlusion_deltas;
  std::span<float> triangle_q, point_q[2];  // of the staged form
  std::span<float> eased;
  // Of its own rest: where its vertices are, what the clusters measure with, and, for the staged form, the
  // layers' coefficients one after the other.
  std::span<furrow::Float3> rest_positions;
  std::span<uint32_t> cluster_rest;
  std::span<float> coefficients;
  std::span<furrow::Layer> own_layers;
  std::span<std::byte> scratch;  // of all workers
  size_t scratch_each = 0;

  furrow::AssetView own_rest;  // the asset's with own_layers, after a recapture
  bool recaptured = false;
  float rest_scale = 1.0f;  // that rest_positions contain
  bool fresh = true;  // nothing to ease from
  uint64_t calls = 0;
  float pending_seconds = 0.0f;

  const furrow::AssetView& view() const { return recaptured ? own_rest : asset.view; }
};

namespace furrow {

// Lays an instance out at `memory`, which may be null; the bytes it needs.
size_t layOut(FurrowAsset& asset, uint32_t features, std::byte* memory, FurrowInstance** instance);

}  // namespace furrow
