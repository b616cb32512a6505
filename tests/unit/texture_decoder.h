#pragma once

// Block-compressed textures back to images, written from the formats' specification.

#include <algorithm>

#include "pipeline/maps/encode.h"

namespace furrow::pipeline {

// The eight values of a BC4 block as the formats' specification has them (Direct3D 11, "BC4 format").
inline float bc4Texel(const std::byte* block, uint32_t x, uint32_t y) {
  const auto byte = [&](int i) { return static_cast<uint64_t>(block[i]); };
  const float a = static_cast<float>(byte(0)) / 255.0f, b = static_cast<float>(byte(1)) / 255.0f;
  uint64_t bits = 0;
  for (int i = 0; i < 6; ++i) {
    bits |= byte(2 + i) << (8 * i);
  }
  const auto index = static_cast<int>(bits >> (3 * (4 * y + x)) & 7u);
  if (index < 2) {
    return index == 0 ? a : b;
  }
  if (byte(0) > byte(1)) {
    return (a * static_cast<float>(8 - index) + b * static_cast<float>(index - 1)) / 7.0f;
  }
  if (index >= 6) {
    return index == 6 ? 0.0f : 1.0f;
  }
  return (a * static_cast<float>(6 - index) + b * static_cast<float>(index - 1)) / 5.0f;
}

// One slice of one level.
inline Image decode(const EncodedTexture& texture, uint32_t level, uint32_t slice) {
  const uint32_t width = std::max(texture.width >> level, 1u), height = std::max(texture.height >> level, 1u);
  const uint32_t channels = texture.format == TextureFormat::kBc5   ? 2
                            : texture.format == TextureFormat::kBc4 ? 1
                                                                    : 4;
  size_t offset = 0;
  for (uint32_t l = 0; l < level; ++l) {
    offset += textureLevelBytes(texture.format, texture.width, texture.height, l) * texture.slices;
  }
  offset += textureLevelBytes(texture.format, texture.width, texture.height, level) * slice;
  Image image{width, height, channels, {}};
  for (uint32_t y = 0; y < height; ++y) {
    for (uint32_t x = 0; x < width; ++x) {
      for (uint32_t c = 0; c < channels; ++c) {
        if (texture.format == TextureFormat::kRgba8) {
          image.pixels.push_back(static_cast<float>(texture.data[offset + (y * width + x) * 4 + c]) / 255.0f);
        } else {
          const size_t block = offset + ((y / 4) * ((width + 3) / 4) + x / 4) * 8 * channels + 8 * c;
          image.pixels.push_back(bc4Texel(&texture.data[block], x % 4, y % 4));
        }
      }
    }
  }
  return image;
}

}  // namespace furrow::pipeline
