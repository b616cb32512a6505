#pragma once

// Images in memory and their files. They are read through OpenImageIO, which is in the module furrow_images;
// the first image loads it from the program's folder or ../lib/furrow, and without it readImage throws Error
// (kEnvironment).

#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <map>
#include <memory>
#include <span>
#include <string>
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

// The same in 8 bits a channel.
struct ByteImage {
  uint32_t width = 0, height = 0, channels = 0;
  std::vector<uint8_t> pixels;

  const uint8_t* at(uint32_t x, uint32_t y) const {
    return &pixels[(static_cast<size_t>(y) * width + x) * channels];
  }
};

// Images that stand in for the files of these absolute paths, such as painted ones that are not saved yet.
using Images = std::map<std::filesystem::path, std::shared_ptr<const ByteImage>>;

// An image file, or an image in a glTF file ("head.glb#wrinkles", see embeddedImage()). At most 16384 texels
// a side and 4 channels. Throws Error (kBadData: it is not such an image, or damaged; names the file and the
// reason).
Image readImage(const std::filesystem::path& file);

// The same in bytes: 8-bit files to the bit, others rounded.
ByteImage readByteImage(const std::filesystem::path& file);

// The same of a PNG, JPEG or WebP file that is in memory, called `name` in messages.
ByteImage readByteImage(std::span<const uint8_t> bytes, const std::string& name);

// The same in floats.
Image toFloats(const ByteImage& image);

// Where the module is: beside the program or, installed, in ../lib/furrow.
std::filesystem::path imageModuleFile();
// A channel at a place of UV space, bilinear, repeated over the edges; in [0, 1].
float sampleAt(const ByteImage& image, glm::vec2 uv, uint32_t channel);

// Values cut to [0, 1] and rounded to the nearest of 256.
ByteImage toBytes(const Image& image);

// Throws Error (kBadUsage) for a name that does not end in .png.
void requirePngName(const std::filesystem::path& file);

// PNG of 8 bits a channel, whole or not at all (pack/output_file.h). Throws Error (kEnvironment; as above).
void writeImage(const std::filesystem::path& file, const Image& image);

// The image at another size, or a window of it: from `low` over `extent`, in sides. Triangle-filtered, and
// repeated over its edges as UVs are; the same pixels if the size is the same and the window is the whole.
Image resize(const Image& image, uint32_t width, uint32_t height, glm::dvec2 low = glm::dvec2(0.0),
             glm::dvec2 extent = glm::dvec2(1.0));

}  // namespace furrow::pipeline
