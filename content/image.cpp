#include "content/image.h"

#include <png.h>

#include <cmath>
#include <glm/common.hpp>
#include <stdexcept>

namespace furrow::content {

std::array<uint8_t, 3> srgb(glm::dvec3 linear) {
  std::array<uint8_t, 3> bytes;
  for (int c = 0; c < 3; ++c) {
    const double x = glm::clamp(linear[c], 0.0, 1.0);
    bytes[c] = static_cast<uint8_t>(
        std::lround(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055)));
  }
  return bytes;
}

std::vector<uint8_t> encodePng(const Image& image) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = image.width;
  header.height = image.height;
  header.format = PNG_FORMAT_RGB;
  std::vector<uint8_t> bytes(PNG_IMAGE_PNG_SIZE_MAX(header));
  png_alloc_size_t size = bytes.size();
  if (!png_image_write_to_memory(&header, bytes.data(), &size, 0, image.rgb.data(), 0, nullptr))
    throw std::runtime_error(std::string("cannot write a PNG: ") + header.message);
  bytes.resize(size);
  return bytes;
}

}  // namespace furrow::content
