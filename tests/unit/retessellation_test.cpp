// The direction field belongs to the surface: the demo face and a coarser one that shares a part of its
// vertices bake the same directions where its expressions squeeze it.

#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <vector>

#include "pipeline/cook/cook.h"
#include "pipeline/import/import.h"

namespace furrow::pipeline {
namespace {

// Takes away triangles until `share` of them are left; the vertices that stay keep all they have.
void coarsen(Primitive& primitive, double share) {
  std::vector<uint32_t> kept(primitive.indices.size());
  const size_t wanted = static_cast<size_t>(share * static_cast<double>(primitive.indices.size() / 3)) * 3;
  kept.resize(meshopt_simplify(kept.data(), primitive.indices.data(), primitive.indices.size(),
                               &primitive.positions[0].x, primitive.positions.size(), sizeof(glm::vec3),
                               wanted, 0.05f));
  primitive.indices = kept;
}

struct Baked {
  Asset asset;
  std::map<uint32_t, uint32_t> point_of_source;  // a source vertex that a triangle uses
};

Baked bake(SourceScene scene) {
  Recipe recipe = defaultRecipe();
  recipe.layers.front().compress = MapNone{};
  CookOptions options;
  options.geometry = GeometryCodec::kRaw;  // Draco would leave out the vertices that no triangle uses
  const Cooked cooked = cook(std::move(scene), recipe, options);
  Baked baked;
  const Status status = baked.asset.load(cooked.bytes);
  EXPECT_TRUE(status.ok()) << status.message;
  const AssetView& view = baked.asset.view();
  for (const uint32_t v : view.indices) baked.point_of_source[view.source_vertex[v]] = view.vertex_point[v];
  return baked;
}

struct Direction {
  glm::dvec3 line;
  double confidence = 0.0;
};

Direction directionAt(const Baked& baked, uint32_t point) {
  const int8_t* d = &baked.asset.view().layers[0].directions[4 * size_t{point}];
  return {glm::normalize(glm::dvec3(d[0], d[1], d[2])), d[3] / 127.0};
}

TEST(Retessellation, TheSameFaceAtTwoResolutionsBakesTheSameDirections) {
  SourceScene fine = import(FURROW_CONTENT "/face.glb");
  for (Primitive& primitive : fine.primitives) coarsen(primitive, 0.5);
  SourceScene coarse = fine;
  for (Primitive& primitive : coarse.primitives) coarsen(primitive, 0.5);
  const Baked a = bake(std::move(fine)), b = bake(std::move(coarse));

  // Of the points that the expressions squeeze (half of the automatic mask) and where both are this sure of
  // the direction, the share that agrees within 5 degrees. What is left lies where directions cross.
  const auto agreeing = [&](double confidence) {
    size_t points = 0, agree = 0;
    for (const auto& [source, point] : b.point_of_source) {
      const AssetView& view = a.asset.view();
      const uint32_t there = a.point_of_source.at(source);
      if (view.layers[0].mask[view.point_vertex[there]] < 128) continue;
      const Direction d = directionAt(a, there), e = directionAt(b, point);
      if (std::min(d.confidence, e.confidence) < confidence) continue;
      ++points;
      agree += std::abs(glm::dot(d.line, e.line)) >= std::cos(5.0 * std::numbers::pi / 180.0);
    }
    EXPECT_GT(points, 200u);
    return static_cast<double>(agree) / static_cast<double>(points);
  };
  EXPECT_GT(agreeing(0.25), 0.9);
  EXPECT_GT(agreeing(0.5), 0.95);
}

}  // namespace
}  // namespace furrow::pipeline
