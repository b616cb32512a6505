// The software rasteriser on one thread: pictures of a bumpy sheet that fills them. The first argument is the
// side of a grid of quads (two triangles each), the second that of the picture in pixels, the third the
// instruction set (0 portable, 1 SSE4, 2 AVX2, 3 AVX-512), the fourth whether creases are drawn.

#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "../unit/sheets.h"
#include "furrow/raster.h"

namespace {

using namespace furrow;

void picture(benchmark::State& state) {
  const auto side = static_cast<uint32_t>(state.range(0)), pixels = static_cast<uint32_t>(state.range(1));
  pipeline::Primitive sheet = tests::sheet(side);
  for (glm::vec3& p : sheet.positions) p.z = 0.05f * std::sin(12.0f * p.x) * std::cos(9.0f * p.y);
  pipeline::LayerRecipe layer = tests::axisLayer({1, 0, 0});
  layer.compress = pipeline::MapSynthesized{};
  const Asset cooked =
      tests::cookAsset(tests::sceneOf(sheet, [](glm::dvec3 p) { return p; }), tests::recipeOf({layer}));
  const AssetView& asset = cooked.view();

  const std::vector<Float3> colors(asset.vertexCount(), {0.5f, 0.4f, 0.3f});
  const std::vector<int16_t> weights(size_t{asset.vertexCount()} * asset.weightStride(), 20000);
  std::vector<RasterVertex> vertices(asset.vertexCount());
  std::vector<uint64_t> bins(rasterBinWords(asset.triangleCount(), pixels, pixels));
  std::vector<Float4> out(size_t{pixels} * pixels);
  std::vector<std::byte> scratch(kRasterScratchBytes + 64);
  const size_t skip = (64 - reinterpret_cast<size_t>(scratch.data()) % 64) % 64;
  RasterJob job;
  job.asset = &asset;
  job.positions = asset.positions;
  const float view[16] = {2, 0, 0, -1, 0, 2, 0, -1, 0, 0, -1, 0, 0, 0, 0, 1};
  std::copy(view, view + 16, job.view_projection);
  job.width = job.height = pixels;
  job.colors = colors;
  if (state.range(3)) job.weights = weights;
  job.vertices = vertices;
  job.bins = bins;
  job.picture = out;
  job.simd = static_cast<Simd>(state.range(2));
  if (const Status status = job.validate(); !status.ok()) return state.SkipWithError(status.message);
  for (auto _ : state) {
    job.project(0, asset.vertexCount());
    job.bin(0, rasterBatches(asset.triangleCount()));
    job.draw(0, rasterTiles(pixels, pixels), std::span(scratch).subspan(skip));
    benchmark::DoNotOptimize(out.data());
  }
  const auto rate = [](double count) {
    return benchmark::Counter(count, benchmark::Counter::kIsIterationInvariantRate);
  };
  state.counters["pixels/s"] = rate(double{pixels * pixels * 1.0});
  state.counters["triangles/s"] = rate(static_cast<double>(asset.triangleCount()));
}

BENCHMARK(picture)
    ->ArgsProduct({{100, 400}, {1024}, {0, 1, 2, 3}, {0, 1}})
    ->Args({100, 2048, 2, 1})
    ->ArgNames({"side", "pixels", "simd", "creases"})
    ->Unit(benchmark::kMillisecond);

}  // namespace
