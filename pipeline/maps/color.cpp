#include "pipeline/maps/color.h"

#include <stb/stb_dxt.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "pipeline/error.h"
#include "pipeline/parallel.h"

namespace furrow::pipeline {
namespace {

// Between bytes of sRGB and light in steps of 1 / 65535.
struct Transfer {
  std::array<uint16_t, 256> light;
  std::array<uint8_t, 65536> byte;

  Transfer() {
    for (size_t b = 0; b < light.size(); ++b) {
      const double c = static_cast<double>(b) / 255.0;
      const double linear = c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
      light[b] = static_cast<uint16_t>(std::lround(linear * 65535.0));
    }
    for (size_t l = 0, b = 0; l < byte.size(); ++l) {
      while (b < 255 && 2 * l >= size_t{light[b]} + light[b + 1]) ++b;
      byte[l] = static_cast<uint8_t>(b);
    }
  }
};

const Transfer& transfer() {
  static const Transfer tables;
  return tables;
}

// Each texel from the 2 x 2 below it: mean(four texels, out).
template <typename Mean>
ByteImage halved(const ByteImage& fine, uint32_t threads, const Mean& mean) {
  ByteImage half{std::max(fine.width / 2, 1u), std::max(fine.height / 2, 1u), fine.channels, {}};
  half.pixels.resize(size_t{half.width} * half.height * half.channels);
  parallelFor(half.height, threads, [&](uint32_t y) {
    uint8_t* out = &half.pixels[size_t{y} * half.width * half.channels];
    const uint32_t below = std::min(2 * y + 1, fine.height - 1);
    for (uint32_t x = 0; x < half.width; ++x, out += half.channels) {
      const uint32_t right = std::min(2 * x + 1, fine.width - 1);
      const std::array<const uint8_t*, 4> texels = {fine.at(2 * x, 2 * y), fine.at(right, 2 * y),
                                                    fine.at(2 * x, below), fine.at(right, below)};
      mean(texels, out);
    }
  });
  return half;
}

ByteImage halvedColor(const ByteImage& fine, uint32_t threads) {
  return halved(fine, threads, [](const std::array<const uint8_t*, 4>& texels, uint8_t* out) {
    const Transfer& t = transfer();
    uint32_t opacity = 0;
    for (const uint8_t* texel : texels) opacity += texel[3];
    for (int c = 0; c < 3; ++c) {
      uint64_t sum = 0;
      for (const uint8_t* texel : texels) sum += uint64_t{opacity ? texel[3] : 1u} * t.light[texel[c]];
      out[c] = t.byte[sum / (opacity ? opacity : 4)];
    }
    out[3] = static_cast<uint8_t>((opacity + 2) / 4);
  });
}

ByteImage fourChannels(const ByteImage& image, bool opacity) {
  ByteImage out{image.width, image.height, 4, {}};
  out.pixels.reserve(size_t{image.width} * image.height * 4);
  const uint32_t n = image.channels;
  for (size_t i = 0; i < image.pixels.size(); i += n) {
    const uint8_t* p = &image.pixels[i];
    out.pixels.insert(out.pixels.end(), {p[0], p[n > 2 ? 1 : 0], p[n > 2 ? 2 : 0],
                                         opacity && n % 2 == 0 ? p[n - 1] : uint8_t{255}});
  }
  return out;
}

void shrink(ByteImage& image, uint32_t longest, const auto& half) {
  while (std::max(image.width, image.height) > std::max(longest, 1u)) image = half(image);
}

constexpr size_t blockBytes(bool opacity) {
  return opacity ? 16 : 8;
}

void encodeBlock(const ByteImage& image, uint32_t left, uint32_t top, bool opacity, std::byte* block) {
  std::array<uint8_t, 64> texels;
  for (uint32_t i = 0; i < 16; ++i)
    std::copy_n(image.at(std::min(left + i % 4, image.width - 1), std::min(top + i / 4, image.height - 1)), 4,
                &texels[4 * i]);
  std::array<unsigned char, 16> coded{};
  stb_compress_dxt_block(coded.data(), texels.data(), opacity, STB_DXT_HIGHQUAL);
  std::memcpy(block, coded.data(), blockBytes(opacity));
}

// Returns the sum of the squared errors of the texels inside, over all channels, and raises `most`.
double blockError(const ByteImage& image, uint32_t left, uint32_t top, bool opacity, const std::byte* block,
                  double& most) {
  const Texture one = {
      opacity ? TextureFormat::kBc3 : TextureFormat::kBc1, 4, 4, 1, 1, {block, blockBytes(opacity)}};
  double sum = 0.0;
  for (uint32_t y = 0; y < std::min(4u, image.height - top); ++y)
    for (uint32_t x = 0; x < std::min(4u, image.width - left); ++x) {
      const Float4 texel = texelAt(one, 0, 0, x, y);
      const std::array<float, 4> found = {texel.x, texel.y, texel.z, texel.w};
      const uint8_t* wanted = image.at(left + x, top + y);
      for (uint32_t c = 0; c < 4; ++c) {
        const double error = double{found[c]} - wanted[c] / 255.0;
        sum += error * error;
        most = std::max(most, std::abs(error));
      }
    }
  return sum;
}

}  // namespace

ByteImage withOpacity(const ByteImage& color, const ByteImage& opacity) {
  const uint32_t n = opacity.channels;
  bool has_alpha = false;
  for (size_t i = n - 1; n % 2 == 0 && i < opacity.pixels.size(); i += n)
    has_alpha |= opacity.pixels[i] != 255;
  const ByteImage colors = fourChannels(color, false);
  ByteImage out{std::max(color.width, opacity.width), std::max(color.height, opacity.height), 4, {}};
  out.pixels.reserve(size_t{4} * out.width * out.height);
  for (uint32_t y = 0; y < out.height; ++y)
    for (uint32_t x = 0; x < out.width; ++x) {
      const glm::vec2 at((static_cast<float>(x) + 0.5f) / static_cast<float>(out.width),
                         (static_cast<float>(y) + 0.5f) / static_cast<float>(out.height));
      const auto add = [&](const ByteImage& image, uint32_t channel) {
        out.pixels.push_back(static_cast<uint8_t>(std::lround(sampleAt(image, at, channel) * 255.0f)));
      };
      for (uint32_t c = 0; c < 3; ++c) add(colors, c);
      add(opacity, has_alpha ? n - 1 : 0);
    }
  return out;
}

EncodedTexture encodeColor(ByteImage image, bool opacity, uint32_t longest, uint32_t threads) {
  image = fourChannels(image, opacity);
  const auto half = [&](const ByteImage& fine) { return halvedColor(fine, threads); };
  shrink(image, longest, half);
  bool seen_through = false;
  for (size_t i = 3; i < image.pixels.size(); i += 4) seen_through |= image.pixels[i] != 255;
  EncodedTexture texture;
  texture.format = seen_through ? TextureFormat::kBc3 : TextureFormat::kBc1;
  texture.width = image.width;
  texture.height = image.height;
  texture.slices = 1;
  texture.levels = static_cast<uint32_t>(std::bit_width(std::max(image.width, image.height)));
  for (uint32_t level = 0; level < texture.levels; ++level) {
    if (level > 0) image = half(image);
    const size_t begin = texture.data.size();
    const size_t bytes = textureLevelBytes(texture.format, image.width, image.height, 0);
    texture.data.resize(begin + bytes);
    const uint32_t columns = (image.width + 3) / 4, rows = (image.height + 3) / 4;
    std::vector<double> sums(rows), most(rows);
    parallelFor(rows, threads, [&](uint32_t row) {
      for (uint32_t column = 0; column < columns; ++column) {
        std::byte* block = &texture.data[begin + (size_t{row} * columns + column) * blockBytes(seen_through)];
        encodeBlock(image, 4 * column, 4 * row, seen_through, block);
        if (level == 0) sums[row] += blockError(image, 4 * column, 4 * row, seen_through, block, most[row]);
      }
    });
    if (level > 0) continue;
    double sum = 0.0;
    for (double s : sums) sum += s;
    const double values = (seen_through ? 4.0 : 3.0) * image.width * image.height;
    texture.rms_error = std::sqrt(sum / values);
    texture.largest_error = *std::max_element(most.begin(), most.end());
  }
  return texture;
}

EncodedTexture encodeNormal(ByteImage image, float scale, uint32_t longest, const std::string& name,
                            uint32_t threads) {
  if (image.channels < 2)
    throw Error(Exit::kBadData, name, "a normal map needs red and green, and it has one channel",
                "export it again");
  bool grey = image.channels > 2;
  for (size_t i = 0; grey && i < image.pixels.size(); i += image.channels)
    grey = image.pixels[i] == image.pixels[i + 1] && image.pixels[i] == image.pixels[i + 2];
  if (grey) throw Error(Exit::kBadData, name, "it is grey, as height maps are", "give a normal map");
  shrink(image, longest, [&](const ByteImage& fine) {
    return halved(fine, threads, [&](const std::array<const uint8_t*, 4>& texels, uint8_t* out) {
      for (uint32_t c = 0; c < fine.channels; ++c)
        out[c] = static_cast<uint8_t>((texels[0][c] + texels[1][c] + texels[2][c] + texels[3][c] + 2) / 4);
    });
  });
  Image normal{image.width, image.height, 2, {}};
  normal.pixels.reserve(size_t{image.width} * image.height * 2);
  for (size_t i = 0; i < image.pixels.size(); i += image.channels) {
    // 127 and 128 both stand for 0 in files; the mean of them is as good.
    const auto value = [&](size_t c) { return static_cast<float>(image.pixels[i + c]) / 127.5f - 1.0f; };
    const float x = value(0), y = value(1);
    const float z = image.channels > 2 ? std::max(value(2), 1.0f / 64.0f)
                                       : std::sqrt(std::max(1.0f - x * x - y * y, 1.0f / 4096.0f));
    const double sx = double{scale} * x, sy = double{scale} * y;  // a float's square may be infinite
    const double length = std::sqrt(sx * sx + sy * sy + double{z} * z);
    normal.pixels.push_back(static_cast<float>(sx / length));
    normal.pixels.push_back(static_cast<float>(sy / length));
  }
  const auto blocks = [](uint32_t side) { return (side + 3) / 4 * 4; };
  return encode(TextureFormat::kBc5, {{resize(normal, blocks(normal.width), blocks(normal.height))}}, {},
                threads);
}

}  // namespace furrow::pipeline
