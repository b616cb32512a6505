// Synthesis of one layer's maps for a head-like surface of 50,000 triangles: spacing 1/60 of the height, 2048
// x 2048 texels.

#include <benchmark/benchmark.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "pipeline/bake/tangents.h"
#include "pipeline/maps/synthesis.h"

namespace furrow::pipeline {
namespace {

constexpr uint32_t kColumns = 250, kRows = 100;  // 50,000 triangles

// An ellipsoid whose one chart fills the texture; the layer covers all of it, which is the worst case.
struct Head {
  Surface surface;
  LayerField field;

  Head() {
    for (uint32_t row = 0; row <= kRows; ++row) {
      for (uint32_t column = 0; column <= kColumns; ++column) {
        const double u = column / static_cast<double>(kColumns), v = row / static_cast<double>(kRows);
        const double around = 2.0 * std::numbers::pi * u, down = 0.05 + (std::numbers::pi - 0.1) * v;
        const glm::dvec3 unit(std::sin(down) * std::sin(around), std::cos(down),
                              std::sin(down) * std::cos(around));
        surface.positions.emplace_back(glm::dvec3(0.08, 0.12, 0.1) * unit);
        surface.normals.emplace_back(glm::normalize(unit / glm::dvec3(0.08, 0.12, 0.1)));
        surface.uvs.emplace_back(u, v);
        surface.vertex_point.push_back(row * kColumns + column % kColumns);
      }
    }
    for (uint32_t v = 0; v < surface.positions.size(); ++v) {
      if (v % (kColumns + 1) != kColumns) {
        surface.point_positions.push_back(surface.positions[v]);
        surface.point_normals.push_back(surface.normals[v]);
      }
    }
    for (uint32_t row = 0; row < kRows; ++row) {
      for (uint32_t column = 0; column < kColumns; ++column) {
        const uint32_t a = row * (kColumns + 1) + column, b = a + 1, c = a + kColumns + 1, d = c + 1;
        surface.triangles.emplace_back(a, c, b);
        surface.triangles.emplace_back(b, c, d);
      }
    }
    surface.tangents = tangents(surface.positions, surface.normals, surface.uvs, surface.triangles);
    SurfacePart part;
    part.vertex_end = static_cast<uint32_t>(surface.positions.size());
    part.triangle_end = static_cast<uint32_t>(surface.triangles.size());
    part.has_uvs = true;
    surface.parts = {part};
    for (const glm::vec3& normal : surface.point_normals) {
      field.direction.push_back(glm::normalize(glm::vec3(0, 1, 0) - normal * normal.y));
    }
    field.confidence.assign(surface.point_positions.size(), 1.0f);
    field.strength.assign(surface.point_positions.size(), 1.0f);
  }
};

const SynthesisSettings kSettings = {Preset::kSkin, 0.004, 0.0005, 1};

void prepare(benchmark::State& state) {
  const Head head;
  for (auto _ : state) {
    benchmark::DoNotOptimize(Synthesis(head.surface, head.field, kSettings));
  }
}
BENCHMARK(prepare)->Unit(benchmark::kMillisecond);

void draw(benchmark::State& state) {
  const Head head;
  const Synthesis synthesis(head.surface, head.field, kSettings);
  const std::vector<uint32_t> parts = {0};
  for (auto _ : state) {
    benchmark::DoNotOptimize(synthesis.draw(mapTexels(head.surface, parts, {2048, 2048}, 16),
                                            static_cast<uint32_t>(state.range(0))));
  }
}
BENCHMARK(draw)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace furrow::pipeline
