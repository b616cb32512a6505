// Four painted masks of 4096 x 4096 texels, a file each, to one encoded texture.

#include <benchmark/benchmark.h>

#include <cmath>
#include <filesystem>
#include <random>

#include "pipeline/maps/encode.h"
#include "pipeline/maps/masks.h"

namespace furrow::pipeline {
namespace {

constexpr uint32_t kSize = 4096;

// Soft strokes with the grain of a brush, so that the files do not compress to nothing.
void paint(const std::filesystem::path& file, uint32_t seed) {
  Image image{kSize, kSize, 1, std::vector<float>(size_t{kSize} * kSize)};
  std::minstd_rand random(seed);
  for (uint32_t y = 0; y < kSize; ++y)
    for (uint32_t x = 0; x < kSize; ++x) {
      const float stroke =
          std::sin(0.002f * static_cast<float>(seed * x + y)) * std::sin(0.003f * static_cast<float>(y));
      const float grain = 0.01f * static_cast<float>(random() % 4);
      image.at(x, y)[0] = stroke > 0.1f ? stroke - grain : 0.0f;
    }
  writeImage(file, image);
}

void fourMasks(benchmark::State& state) {
  const auto folder = std::filesystem::temp_directory_path() /
                      ("furrow_mask_bench_" + std::to_string(std::random_device{}()));
  std::filesystem::create_directories(folder);
  std::vector<std::filesystem::path> files;
  for (uint32_t i = 0; i < 4; ++i) {
    files.push_back(folder / (std::to_string(i) + ".png"));
    paint(files.back(), i + 1);
  }
  const auto threads = static_cast<uint32_t>(state.range(0));
  for (auto _ : state) {
    const MaskImages images = readMasks(files, threads);
    std::array<MaskChannel, 4> channels;
    for (size_t i = 0; i < 4; ++i) {
      checkMask(files[i], images.at(files[i]), 0, "layer");
      channels[i] = {&images.at(files[i]), 0};
    }
    const std::array packed = {packMasks(channels, kSize, kSize, threads)};
    benchmark::DoNotOptimize(encodeBytes(packed, {}, threads));
  }
  std::filesystem::remove_all(folder);
}
BENCHMARK(fourMasks)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();

}  // namespace
}  // namespace furrow::pipeline
