#pragma once

// Pictures that the content embeds.

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace furrow::content {

struct Image {
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> rgb;  // rows from the top
};

// A linear colour in sRGB.
std::array<uint8_t, 3> srgb(glm::dvec3 linear);

// Throws std::runtime_error if libpng refuses.
std::vector<uint8_t> encodePng(const Image& image);

}  // namespace furrow::content
