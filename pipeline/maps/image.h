#pragma once

// Images in memory and their files (through OpenImageIO).

#include <cstdint>
#include <filesystem>
#include <vector>

namespace furrow::pipeline {

// Rows from the top, channels interleaved, values as in the file scaled to [0, 1] for integer formats; no colour conversion, no premultiplied
// alpha.
struct Image {
  uint32_t width = 0, height = 0, channels = 0;
  std::vector<float> pixels;

  const float* at(uint32_t x, uint32_t y) const { return &pixels[(static_cast<size_t>(y) * width + x) * channels]; }
  float* at(uint32_t x, uint32_t y) { return &pixels[(static_cast<size_t>(y) * width + x) * channels]; }
};

// Throws Error (kBadData: it is not an image; names the file and the reason).
Image readImage(const std::filesystem::path& file);

// 8 bits a channel, format by extension (PNG); written to a temporary beside the file, then renamed. Throws Error (kEnvironment).
void writeImage(const std::filesystem::path& file, const Image& image);

}  // namespace furrow::pipeline
