// Direction fields of a head-sized ball, by number of triangles: from two guide curves, which have to be
// diffused the furthest, and from a squeeze that is known on a part of it.

#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>

#include "pipeline/bake/directions.h"

namespace furrow::pipeline {
namespace {

// About `triangles` of them.
Surface ball(int64_t triangles) {
  Surface surface;
  const auto rows = static_cast<uint32_t>(std::sqrt(static_cast<double>(triangles) / 4.0)),
             columns = 2 * rows;
  for (uint32_t row = 0; row <= rows; ++row)
    for (uint32_t column = 0; column < columns; ++column) {
      const double down = 0.05 + (std::numbers::pi - 0.1) * row / rows,
                   around = 2.0 * std::numbers::pi * column / columns;
      surface.point_normals.emplace_back(std::sin(down) * std::sin(around), std::cos(down),
                                         std::sin(down) * std::cos(around));
      surface.point_positions.push_back(0.1f * surface.point_normals.back());
      surface.vertex_point.push_back(row * columns + column);
    }
  surface.positions = surface.point_positions;
  for (uint32_t row = 0; row < rows; ++row)
    for (uint32_t column = 0; column < columns; ++column) {
      const uint32_t a = row * columns + column, b = row * columns + (column + 1) % columns;
      surface.triangles.emplace_back(a, a + columns, b);
      surface.triangles.emplace_back(b, a + columns, b + columns);
    }
  return surface;
}

void guides(benchmark::State& state) {
  const Surface surface = ball(state.range(0));
  const std::vector<bool> covered(surface.triangles.size(), true);
  std::vector<std::array<glm::dvec3, 2>> segments;
  for (const double height : {0.02, 0.05})
    for (double a = -0.8; a < 0.8; a += 0.05) {
      const double r = std::sqrt(0.01 - height * height);
      segments.push_back({glm::dvec3(r * std::sin(a), height, r * std::cos(a)),
                          glm::dvec3(r * std::sin(a + 0.05), height, r * std::cos(a + 0.05))});
    }
  for (auto _ : state) benchmark::DoNotOptimize(directionsFromGuides(surface, covered, segments));
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(surface.triangles.size()));
}
BENCHMARK(guides)->Arg(60'000)->Arg(1'000'000)->Arg(4'000'000)->Unit(benchmark::kMillisecond);

void squeeze(benchmark::State& state) {
  const Surface surface = ball(state.range(0));
  const std::vector<bool> covered(surface.triangles.size(), true);
  LineTensors tensors(surface.triangles.size(), glm::vec3(0.0f));
  for (size_t t = 0; t < tensors.size(); ++t)
    if (surface.positions[surface.triangles[t].x].z > 0.08f) tensors[t] = {0.1f, 0.0f, 0.02f};
  for (auto _ : state) benchmark::DoNotOptimize(directionsFromTensors(surface, covered, tensors));
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(surface.triangles.size()));
}
BENCHMARK(squeeze)->Arg(60'000)->Arg(1'000'000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace furrow::pipeline
