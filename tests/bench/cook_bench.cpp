// The cook by stages on one thread: a generated head of stated size, morphed and unskinned, without maps.

#include <benchmark/benchmark.h>

#include "../unit/sheets.h"

namespace {

using namespace furrow;

constexpr uint32_t kTargets = 60;

// A ball with a brow and a nose of about 2 n^2 triangles; every target pulls a patch of it to one side.
pipeline::SourceScene head(uint32_t n) {
  pipeline::Primitive ball = tests::sheet(n);
  for (size_t v = 0; v < ball.positions.size(); ++v) {
    const glm::dvec3 p = ball.positions[v];
    const double around = 6.2 * (p.x - 0.5), up = 3.0 * (p.y - 0.5);
    const glm::dvec3 out(std::sin(around) * std::cos(up), std::sin(up), std::cos(around) * std::cos(up));
    const double nose = std::exp(-40.0 * (around * around + up * up)), brow = 0.02 * std::cos(5.0 * up);
    ball.positions[v] = glm::vec3((0.1 + 0.02 * nose + 0.1 * brow) * out);
    ball.normals.push_back(glm::vec3(out));
  }
  pipeline::SourceScene scene = tests::sceneOf(ball, [](glm::dvec3 p) { return p; });
  pipeline::Primitive& primitive = scene.primitives[0];
  primitive.morphs.clear();
  scene.rig.morphs.clear();
  for (uint32_t m = 0; m < kTargets; ++m) {
    const glm::dvec3 centre = primitive.positions[(m * 7919u + 13u) % primitive.positions.size()];
    pipeline::MorphDelta& delta = primitive.morphs.emplace_back();
    for (uint32_t v = 0; v < primitive.positions.size(); ++v) {
      const glm::dvec3 away = glm::dvec3(primitive.positions[v]) - centre;
      const double near = 1.0 - glm::dot(away, away) / (0.06 * 0.06);
      if (near <= 0.0) continue;
      delta.vertices.push_back(v);
      delta.positions.push_back(glm::vec3(-0.4 * near * near * away));
    }
    scene.rig.morphs.push_back({"target" + std::to_string(m), 0, m, 0.0});
  }
  return scene;
}

void cookHead(benchmark::State& state) {
  const pipeline::SourceScene scene = head(static_cast<uint32_t>(std::sqrt(state.range(0) / 2)));
  pipeline::LayerRecipe layer = tests::axisLayer({0, 1, 0});
  if (state.range(1)) {
    layer.direction = pipeline::DirectionAnimation{};
    layer.mask = pipeline::MaskAuto{};
  }
  const pipeline::Recipe recipe = tests::recipeOf({layer});
  pipeline::CookOptions options;
  options.threads = 1;
  pipeline::CookReport report;
  for (auto _ : state) {
    state.PauseTiming();
    pipeline::SourceScene copy = scene;
    state.ResumeTiming();
    report = pipeline::cook(std::move(copy), recipe, options).report;
  }
  for (const pipeline::CookStage& stage : report.stages) state.counters[stage.name] = stage.seconds;
  state.counters["bytes"] = static_cast<double>(report.bytes);
  state.counters["triangles/s"] = benchmark::Counter(static_cast<double>(report.triangles),
                                                     benchmark::Counter::kIsIterationInvariantRate);
}

// Triangles; 1: direction and mask from the animation, 0: a constant direction.
BENCHMARK(cookHead)
    ->ArgsProduct({{15'000, 60'000, 240'000}, {0, 1}})
    ->ArgNames({"triangles", "animation"})
    ->Unit(benchmark::kMillisecond);

}  // namespace
