// Synthesis of one layer's maps for a head-like surface of 50,000 triangles: spacing 1/60 of the height, 2048
// x 2048 texels.

#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>

#include "pipeline/maps/synthesis.h"
#include "tests/unit/surfaces.h"

namespace furrow::pipeline {
namespace {

// An ellipsoid whose one chart fills the texture; the layer covers all of it, which is the worst case.
struct Head {
  static constexpr uint32_t kColumns = 250, kRows = 100;  // 50,000 triangles

  static glm::vec3 unit(double u, double v) {
    const double around = 2.0 * std::numbers::pi * u, down = 0.05 + (std::numbers::pi - 0.1) * v;
    return glm::vec3(std::sin(down) * std::sin(around), std::cos(down), std::sin(down) * std::cos(around));
  }

  static constexpr glm::vec3 kRadii{0.08f, 0.12f, 0.1f};
  Surface surface = tests::grid(
      kColumns, kRows, [](double u, double v) { return kRadii * unit(u, v); },
      [](double u, double v) { return unit(u, v) / kRadii; }, true);
  LayerField field = tests::along(surface, {0, 1, 0});
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
    benchmark::DoNotOptimize(
        synthesis.draw(mapTexels(head.surface, chartsOf(head.surface, parts), {2048, 2048}, 16),
                       static_cast<uint32_t>(state.range(0))));
  }
}
BENCHMARK(draw)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace furrow::pipeline
