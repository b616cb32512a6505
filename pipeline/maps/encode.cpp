#include "pipeline/maps/encode.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <stdexcept>

#define STB_DXT_IMPLEMENTATION
#include <stb/stb_dxt.h>

namespace furrow::pipeline {
namespace {

constexpr float kMinNormalZ = 1.0f / 64.0f;  // of a slope; steeper ones are cut off in the smaller levels

uint32_t channelCount(TextureFormat format) {
  return format == TextureFormat::kBc5 ? 2u : format == TextureFormat::kBc4 ? 1u : 4u;
}

uint8_t unorm8(float v) {
  return static_cast<uint8_t>(std::lround(std::clamp(v, 0.0f, 1.0f) * 255.0f));
}

// Each texel of the result is the mean of the 2 x 2 below it (2 x 1 where a side is already 1).
Image halved(const Image& image) {
  Image half;
  half.width = std::max(image.width / 2, 1u);
  half.height = std::max(image.height / 2, 1u);
  half.channels = image.channels;
  half.pixels.resize(static_cast<size_t>(half.width) * half.height * half.channels);
  for (uint32_t y = 0; y < half.height; ++y) {
    const uint32_t y0 = std::min(2 * y, image.height - 1), y1 = std::min(2 * y + 1, image.height - 1);
    for (uint32_t x = 0; x < half.width; ++x) {
      const uint32_t x0 = std::min(2 * x, image.width - 1), x1 = std::min(2 * x + 1, image.width - 1);
      const float *a = image.at(x0, y0), *b = image.at(x1, y0), *c = image.at(x0, y1), *d = image.at(x1, y1);
      for (uint32_t i = 0; i < image.channels; ++i) {
        half.at(x, y)[i] = 0.25f * ((a[i] + b[i]) + (c[i] + d[i]));
      }
    }
  }
  return half;
}

Image slopes(const Image& normals) {
  Image result = normals;
  for (size_t i = 0; i < result.pixels.size(); i += 2) {
    const float x = result.pixels[i], y = result.pixels[i + 1];
    const float z = std::max(std::sqrt(std::max(1.0f - x * x - y * y, 0.0f)), kMinNormalZ);
    result.pixels[i] = x / z;
    result.pixels[i + 1] = y / z;
  }
  return result;
}

Image normalsOf(const Image& slopes) {
  Image result = slopes;
  for (size_t i = 0; i < result.pixels.size(); i += 2) {
    const float x = result.pixels[i], y = result.pixels[i + 1];
    const float length = std::sqrt(x * x + y * y + 1.0f);
    result.pixels[i] = x / length;
    result.pixels[i + 1] = y / length;
  }
  return result;
}

// `image` holds what is stored, in [0, 1].
void append(TextureFormat format, const Image& image, std::vector<std::byte>& data) {
  if (format == TextureFormat::kRgba8) {
    for (const float v : image.pixels) {
      data.push_back(static_cast<std::byte>(unorm8(v)));
    }
    return;
  }
  const uint32_t channels = image.channels;
  for (uint32_t y = 0; y < image.height; y += 4) {
    for (uint32_t x = 0; x < image.width; x += 4) {
      std::array<unsigned char, 32> texels{};
      std::array<unsigned char, 16> block{};
      for (uint32_t i = 0; i < 16; ++i) {
        const float* texel =
            image.at(std::min(x + i % 4, image.width - 1), std::min(y + i / 4, image.height - 1));
        for (uint32_t c = 0; c < channels; ++c) {
          texels[i * channels + c] = unorm8(texel[c]);
        }
      }
      if (channels == 2) {
        stb_compress_bc5_block(block.data(), texels.data());
      } else {
        stb_compress_bc4_block(block.data(), texels.data());
      }
      const auto bytes = std::as_bytes(std::span(block)).first(8 * channels);
      data.insert(data.end(), bytes.begin(), bytes.end());
    }
  }
}

}  // namespace

EncodedTexture encode(TextureFormat format, std::span<const Image> slices) {
  EncodedTexture texture;
  texture.format = format;
  if (slices.empty()) {
    return texture;
  }
  texture.width = slices[0].width;
  texture.height = slices[0].height;
  texture.slices = static_cast<uint32_t>(slices.size());
  const uint32_t channels = channelCount(format);
  for (const Image& slice : slices) {
    if (slice.width != texture.width || slice.height != texture.height || slice.channels != channels ||
        slice.pixels.size() != static_cast<size_t>(slice.width) * slice.height * channels) {
      throw std::invalid_argument("encode: slices of different sizes or channels");
    }
  }
  if (!std::has_single_bit(texture.width) || !std::has_single_bit(texture.height) || texture.width < 4 ||
      texture.height < 4) {
    throw std::invalid_argument("encode: sides must be powers of two from 4");
  }
  texture.levels = static_cast<uint32_t>(std::bit_width(std::max(texture.width, texture.height)));

  size_t bytes = 0;
  for (uint32_t level = 0; level < texture.levels; ++level) {
    bytes += textureLevelBytes(format, texture.width, texture.height, level) * texture.slices;
  }
  texture.data.reserve(bytes);

  const bool normals = format == TextureFormat::kBc5;
  std::vector<Image> images(slices.begin(), slices.end());
  for (uint32_t level = 0; level < texture.levels; ++level) {
    for (Image& image : images) {
      if (level > 0) {
        image = halved(image);
      }
      if (!normals) {
        append(format, image, texture.data);
        continue;
      }
      Image stored = level > 0 ? normalsOf(image) : image;
      for (float& v : stored.pixels) {
        v = v * 0.5f + 0.5f;
      }
      append(format, stored, texture.data);
      if (level == 0) {
        image = slopes(image);
      }
    }
  }
  if (texture.data.size() != bytes) {
    throw std::logic_error("encode: levels of another size than the runtime expects");
  }
  return texture;
}

}  // namespace furrow::pipeline
