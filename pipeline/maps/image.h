#pragma once

// Images in memory and their files, through OpenImageIO. That is in the module furrow_images, which the first
// image file loads from the program's folder or ../lib/furrow; without it readImage and writeImage throw
// Error (kEnvironment).

#include <cstdint>
#include <filesystem>
#include <vector>

namespace furrow::pipeline {

// Rows from the top, channels interleaved, values as in the file scaled to [0, 1] for integer formats; no
// colour conversion, no premultiplied alpha.
struct Image {
  uint32_t width = 0, height = 0, channels = 0;
  std::vector<float> pixels;

  const float* at(uint32_t x, uint32_t y) const {
    return &pixels[(static_cast<size_t>(y) * width + x) * channels];
  }
  float* at(uint32_t x, uint32_t y) { return &pixels[(static_cast<size_t>(y) * width + x) * channels]; }
};

// At most 16384 texels a side and 4 channels. Throws Error (kBadData: it is not such an image, or damaged;
// names the file and the reason).
Image readImage(const std::filesystem::path& file);

// 8 bits a channel, format by extension (PNG); written to a temporary beside the file, then renamed. Throws
// Error (kEnvironment).
void writeImage(const std::filesystem::path& file, const Image& image);

// The image at another size, triangle-filtered over its edges held; the same pixels if the size is the same.
Image resize(const Image& image, uint32_t width, uint32_t height);

}  // namespace furrow::pipeline
