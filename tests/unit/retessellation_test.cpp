// The direction field belongs to the surface: the demo face and a coarser one that shares a part of its
// vertices bake the same directions where its expressions squeeze it.

#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <map>
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

// What a layer's field is at a point: the tangent plane, a line in it, and how sure it is.
struct Line {
  glm::dvec3 normal, direction;
  double confidence = 0.0;
};

std::vector<Line> linesOf(const AssetView& view) {
  std::vector<Line> lines(view.pointCount(), Line{glm::dvec3(0.0), glm::dvec3(0.0)});
  for (size_t i = 0; i + 2 < view.indices.size(); i += 3) {
    std::array<glm::dvec3, 3> p;
    for (int c = 0; c < 3; ++c) {
      const Float3 at = view.positions[view.indices[i + c]];
      p[c] = {at.x, at.y, at.z};
    }
    for (int c = 0; c < 3; ++c)
      lines[view.vertex_point[view.indices[i + c]]].normal += glm::cross(p[1] - p[0], p[2] - p[0]);
  }
  for (size_t point = 0; point < lines.size(); ++point) {
    const int8_t* d = &view.layers[0].directions[4 * point];
    lines[point].normal = glm::normalize(lines[point].normal);
    lines[point].direction = glm::normalize(glm::dvec3(d[0], d[1], d[2]));
    lines[point].confidence = d[3] / 127.0;
  }
  return lines;
}

// Degrees between two lines whose planes are laid into each other by the least rotation: a coarser surface
// cuts corners, which tilts its planes in the folds of lids and lips.
double apart(const Line& a, const Line& b) {
  const double c = glm::dot(a.normal, b.normal);
  const glm::dvec3 axis = glm::cross(b.normal, a.normal);
  const glm::dvec3 turned =
      c * b.direction + glm::cross(axis, b.direction) + axis * (glm::dot(axis, b.direction) / (1.0 + c));
  return glm::degrees(std::acos(std::min(1.0, std::abs(glm::dot(a.direction, turned)))));
}

// As complex numbers of twice the angle and the length of the confidence, of which the field is made.
double difference(const Line& a, const Line& b) {
  const double turn = std::cos(2.0 * glm::radians(apart(a, b)));
  return std::sqrt(a.confidence * a.confidence + b.confidence * b.confidence -
                   2.0 * a.confidence * b.confidence * turn);
}

// Wherever the expressions squeeze the face (half of the automatic mask). A line field that follows a face
// has singular points, in which its length, the confidence, is 0 and around which the lines turn by half a
// turn [Knoeppel et al. 2013]; moved by a hair, it turns the lines beside it by any angle. So where it is
// short, what must agree is the field. Planes more than 60 degrees apart, where coarsening has folded the
// edge of a lid or a lip, have no direction in common.
TEST(Retessellation, TheSameFaceAtTwoResolutionsBakesTheSameDirections) {
  SourceScene fine = import(FURROW_CONTENT "/face.glb"), coarse = fine;
  for (Primitive& primitive : coarse.primitives) coarsen(primitive, 0.5);
  const Baked a = bake(std::move(fine)), b = bake(std::move(coarse));
  const std::vector<Line> fine_lines = linesOf(a.asset.view()), coarse_lines = linesOf(b.asset.view());

  size_t folded = 0, all = 0, sure = 0, all_agree = 0, sure_agree = 0;
  for (const auto& [source, point] : b.point_of_source) {
    const AssetView& view = a.asset.view();
    const uint32_t there = a.point_of_source.at(source);
    if (view.layers[0].mask[view.point_vertex[there]] < 128) continue;
    const Line &line = fine_lines[there], &other = coarse_lines[point];
    if (glm::dot(line.normal, other.normal) < 0.5) {
      ++folded;
      continue;
    }
    const double confidence = std::min(line.confidence, other.confidence), degrees = apart(line, other);
    ++all;
    all_agree += degrees <= 5.0;
    if (confidence >= 0.1) {
      ++sure;
      sure_agree += degrees <= 5.0;
    }
    EXPECT_TRUE(degrees <= 5.0 || (confidence < 0.35 && difference(line, other) <= 0.15))
        << source << ": " << degrees << " degrees at confidence " << confidence;
  }
  const auto share = [](size_t part, size_t whole) {
    return static_cast<double>(part) / static_cast<double>(whole);
  };
  EXPECT_GT(all, 1000u);
  EXPECT_LT(share(folded, all), 0.02);
  EXPECT_GT(share(sure, all), 0.8);
  EXPECT_GT(share(sure_agree, sure), 0.99);
  EXPECT_GT(share(all_agree, all), 0.96);
}

}  // namespace
}  // namespace furrow::pipeline
