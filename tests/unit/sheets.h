#pragma once

// Small scenes with known answers, and one frame of the cpu tier.

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "furrow/jobs.h"
#include "pipeline/cook/cook.h"

namespace furrow::tests {

using pipeline::MorphDelta;
using pipeline::Primitive;
using pipeline::SourceScene;

// A scene of one mesh on one node; its morph target "deform" takes every vertex p to deform(p).
inline SourceScene sceneOf(Primitive primitive, const std::function<glm::dvec3(glm::dvec3)>& deform) {
  SourceScene scene;
  scene.file = "test.glb";
  MorphDelta delta;
  for (uint32_t v = 0; v < primitive.positions.size(); ++v) {
    const glm::dvec3 moved = deform(primitive.positions[v]);
    delta.vertices.push_back(v);
    delta.positions.push_back(glm::vec3(moved - glm::dvec3(primitive.positions[v])));
  }
  primitive.morphs.push_back(std::move(delta));
  scene.primitives.push_back(std::move(primitive));
  scene.rig.nodes.push_back({});
  scene.rig.palette.push_back({});
  scene.rig.morphs.push_back({"deform", 0, 0, 0.0});
  pipeline::Part part;
  part.mesh = "sheet";
  scene.parts.push_back(part);
  return scene;
}

// A unit sheet in the xy plane of n x n quads, every second one cut along the other diagonal.
inline Primitive sheet(uint32_t n) {
  Primitive p;
  for (uint32_t y = 0; y <= n; ++y)
    for (uint32_t x = 0; x <= n; ++x) {
      p.positions.push_back({static_cast<float>(x) / static_cast<float>(n),
                             static_cast<float>(y) / static_cast<float>(n), 0.0f});
      p.uvs.push_back({p.positions.back().x, 1.0f - p.positions.back().y});
    }
  for (uint32_t y = 0; y < n; ++y)
    for (uint32_t x = 0; x < n; ++x) {
      const uint32_t a = y * (n + 1) + x, b = a + 1, c = a + n + 1, d = c + 1;
      const uint32_t one[] = {a, b, d, a, d, c}, other[] = {a, b, c, b, d, c};
      p.indices.insert(p.indices.end(), (x + y) % 2 ? other : one, ((x + y) % 2 ? other : one) + 6);
    }
  return p;
}

// Two primitives of one mesh, side by side as they are, that nothing moves.
inline SourceScene twoParts(Primitive left, Primitive right) {
  SourceScene scene = sceneOf(std::move(left), [](glm::dvec3 p) { return p; });
  scene.primitives[0].morphs.clear();
  scene.rig.morphs.clear();
  scene.primitives.push_back(std::move(right));
  scene.parts.push_back(scene.parts[0]);
  scene.parts[1].primitive = 1;
  return scene;
}

inline pipeline::LayerRecipe axisLayer(std::array<double, 3> axis, float beta = 4.0f) {
  pipeline::LayerRecipe layer;
  layer.name = "layer";
  layer.direction = pipeline::DirectionAxis{axis};
  layer.mask = pipeline::MaskNone{};
  layer.compress = pipeline::MapNone{};
  layer.response.beta = layer.response.stretch_beta = beta;
  return layer;
}

inline pipeline::Recipe recipeOf(std::vector<pipeline::LayerRecipe> layers) {
  pipeline::Recipe recipe;
  recipe.layers = std::move(layers);
  return recipe;
}

inline Asset cookAsset(SourceScene scene, const pipeline::Recipe& recipe,
                       pipeline::GeometryCodec codec = pipeline::GeometryCodec::kDraco) {
  pipeline::CookOptions options;
  options.geometry = codec;
  const pipeline::Cooked cooked = pipeline::cook(std::move(scene), recipe, options);
  Asset asset;
  const Status status = asset.load(cooked.bytes);
  if (!status.ok()) throw std::runtime_error(status.message);
  return asset;
}

struct Frame {
  std::vector<Float3> positions;
  std::vector<std::vector<float>> q;  // a layer, a point
  std::vector<int16_t> weights;       // weightStride a vertex
  std::vector<double> alpha, weight;  // layer 0, in source order
};

// `pieces`: how many ranges every job is split into.
inline Frame evaluate(const AssetView& asset, std::vector<float> morph_weights, Affine pose = {},
                      float scale = 1.0f, float region = 0.0f, uint32_t pieces = 1) {
  Frame frame;
  const std::vector<Affine> palette(asset.palette.size(), pose);
  morph_weights.resize(asset.morphs.size());
  frame.positions.resize(asset.vertexCount());
  frame.weights.resize(size_t{asset.vertexCount()} * asset.weightStride());
  const auto run = [&](const auto& job, uint32_t count) {
    const Status status = job.validate();
    if (!status.ok()) throw std::runtime_error(status.message);
    for (uint32_t i = 0; i < pieces; ++i)
      job.run(static_cast<uint32_t>(uint64_t{count} * i / pieces),
              static_cast<uint32_t>(uint64_t{count} * (i + 1) / pieces));
  };
  run(DeformJob{&asset, palette, morph_weights, frame.positions, {}, {}}, asset.vertexCount());
  std::vector<float> triangle_q(asset.triangleCount());
  for (uint32_t l = 0; l < asset.layerCount(); ++l) {
    std::vector<float>& q = frame.q.emplace_back(asset.pointCount());
    run(CompressJob{&asset, l, frame.positions, scale, triangle_q}, asset.triangleCount());
    run(SmoothJob{&asset, triangle_q, q}, asset.pointCount());
    run(RespondJob{&asset, l, asset.layers[l].response, region, q, frame.weights}, asset.vertexCount());
  }
  frame.alpha.resize(asset.vertexCount());
  frame.weight.resize(asset.vertexCount());
  for (uint32_t v = 0; v < asset.vertexCount(); ++v) {
    frame.alpha[asset.source_vertex[v]] = 1.0 / std::max(frame.q[0][asset.vertex_point[v]], kMinQ);
    frame.weight[asset.source_vertex[v]] = frame.weights[size_t{v} * asset.weightStride()] / 32767.0;
  }
  return frame;
}

}  // namespace furrow::tests
