#include "pipeline/maps/encode.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>
#include <stdexcept>

#include "pipeline/parallel.h"

#define STB_DXT_IMPLEMENTATION
#include <stb/stb_dxt.h>

namespace furrow::pipeline {
namespace {

constexpr float kMinNormalZ = 1.0f / 64.0f;  // of a slope; steeper ones are cut off
constexpr float kLeastZ2 = 1.0f / 257.0f;    // that the runtime decodes
constexpr uint32_t kBand = 16;               // rows of a level that a thread takes at once

// A level of a mip chain, its texels in memory of somebody else's.
template <class T>
struct Level {
  uint32_t width = 0, height = 0;
  T* texels = nullptr;
  Coverage weights;  // 255 where all below is covered; empty: everywhere

  size_t weight(size_t texel) const { return weights.empty() ? 255u : weights[texel]; }
};

template <class Run>
void forBands(uint32_t rows, uint32_t threads, const Run& run) {
  parallelFor((rows + kBand - 1) / kBand, threads,
              [&](uint32_t band) { run(band * kBand, std::min(rows, (band + 1) * kBand)); });
}

template <class T>
T mean(float sum, float weight) {
  return std::is_integral_v<T> ? static_cast<T>(sum / weight + 0.5f) : static_cast<T>(sum / weight);
}

// Each texel is the mean of the 2 x 2 below it (2 x 1 where a side is already 1).
template <size_t kChannels, class T>
void halve(const Level<T>& fine, Level<T>& half, uint32_t threads) {
  if (!fine.weights.empty()) {
    half.weights.resize(size_t{half.width} * half.height);
  }
  forBands(half.height, threads, [&](uint32_t begin, uint32_t end) {
    for (uint32_t y = begin; y < end; ++y) {
      const size_t row0 = size_t{std::min(2 * y, fine.height - 1)} * fine.width,
                   row1 = size_t{std::min(2 * y + 1, fine.height - 1)} * fine.width;
      for (uint32_t x = 0; x < half.width; ++x) {
        const size_t x0 = std::min(2 * x, fine.width - 1), x1 = std::min(2 * x + 1, fine.width - 1);
        const std::array<size_t, 4> from = {row0 + x0, row0 + x1, row1 + x0, row1 + x1};
        const size_t to = size_t{y} * half.width + x;
        T* texel = half.texels + to * kChannels;
        if (fine.weights.empty()) {
          for (size_t c = 0; c < kChannels; ++c) {
            const auto at = [&](int i) { return fine.texels[from[i] * kChannels + c]; };
            if constexpr (std::is_integral_v<T>) {
              texel[c] = static_cast<T>((at(0) + at(1) + at(2) + at(3) + 2) / 4);
            } else {
              texel[c] = 0.25f * ((at(0) + at(1)) + (at(2) + at(3)));
            }
          }
          continue;
        }
        float total = 0.0f;
        std::array<float, kChannels> sums{};
        for (const size_t i : from) {
          const float weight = fine.weights[i];
          total += weight;
          for (size_t c = 0; c < kChannels; ++c) {
            sums[c] += weight * static_cast<float>(fine.texels[i * kChannels + c]);
          }
        }
        half.weights[to] = static_cast<uint8_t>((total + 3.0f) / 4.0f);  // a little stays a little
        for (size_t c = 0; c < kChannels; ++c) {
          texel[c] = total > 0.0f ? mean<T>(sums[c], total) : T{};
        }
      }
    }
  });
}

// Texels without weight take the value of the level above.
template <size_t kChannels, class T>
void fill(const Level<T>& half, Level<T>& fine, uint32_t threads) {
  if (fine.weights.empty()) {
    return;
  }
  forBands(fine.height, threads, [&](uint32_t begin, uint32_t end) {
    for (uint32_t y = begin; y < end; ++y) {
      for (uint32_t x = 0; x < fine.width; ++x) {
        const size_t to = size_t{y} * fine.width + x;
        if (fine.weights[to] == 0) {
          const size_t from =
              size_t{std::min(y / 2, half.height - 1)} * half.width + std::min(x / 2, half.width - 1);
          std::copy_n(half.texels + from * kChannels, kChannels, fine.texels + to * kChannels);
        }
      }
    }
  });
}

// Completes a chain of which level 0 is there.
template <size_t kChannels, class T>
void complete(std::span<Level<T>> levels, uint32_t threads) {
  for (size_t l = 1; l < levels.size(); ++l) {
    halve<kChannels>(levels[l - 1], levels[l], threads);
  }
  for (size_t l = levels.size() - 1; l > 0; --l) {
    fill<kChannels>(levels[l], levels[l - 1], threads);
  }
}

template <class AnyImage>
EncodedTexture sized(TextureFormat format, std::span<const AnyImage> slices, uint32_t channels,
                     std::span<const Coverage> coverage) {
  EncodedTexture texture;
  texture.format = format;
  if (slices.empty()) {
    return texture;
  }
  texture.width = slices[0].width;
  texture.height = slices[0].height;
  texture.slices = static_cast<uint32_t>(slices.size());
  const size_t texels = size_t{texture.width} * texture.height;
  for (const AnyImage& slice : slices) {
    if (slice.width != texture.width || slice.height != texture.height || slice.channels != channels ||
        slice.pixels.size() != texels * channels || texels == 0) {
      throw std::invalid_argument("encode: slices of different sizes or channels");
    }
  }
  if (!coverage.empty() && coverage.size() != slices.size()) {
    throw std::invalid_argument("encode: coverage of another number of slices");
  }
  for (const Coverage& c : coverage) {
    if (!c.empty() && c.size() != texels) {
      throw std::invalid_argument("encode: coverage of another size");
    }
  }
  texture.levels = static_cast<uint32_t>(std::bit_width(std::max(texture.width, texture.height)));
  size_t bytes = 0;
  for (uint32_t level = 0; level < texture.levels; ++level) {
    bytes += textureLevelBytes(format, texture.width, texture.height, level) * texture.slices;
  }
  texture.data.resize(bytes);
  return texture;
}

std::byte* dataOf(EncodedTexture& texture, uint32_t level, uint32_t slice) {
  size_t offset = 0;
  for (uint32_t l = 0; l < level; ++l) {
    offset += textureLevelBytes(texture.format, texture.width, texture.height, l) * texture.slices;
  }
  return texture.data.data() + offset +
         textureLevelBytes(texture.format, texture.width, texture.height, level) * slice;
}

template <class T>
std::vector<Level<T>> chain(const EncodedTexture& texture, std::span<const Coverage> coverage,
                            uint32_t slice) {
  std::vector<Level<T>> levels(texture.levels);
  for (uint32_t l = 0; l < texture.levels; ++l) {
    levels[l].width = std::max(texture.width >> l, 1u);
    levels[l].height = std::max(texture.height >> l, 1u);
  }
  if (!coverage.empty()) {
    levels[0].weights = coverage[slice];
    for (uint8_t& weight : levels[0].weights) {
      weight = weight != 0 ? 255 : 0;
    }
  }
  return levels;
}

uint8_t unorm8(float v) {
  return static_cast<uint8_t>(std::clamp(v, 0.0f, 1.0f) * 255.0f + 0.5f);
}

// The sixteen values of half a BC5 block or of a BC4 block, in [0, 1] (Direct3D 11, "BC4 format").
std::array<float, 16> decodedBlock(const unsigned char* block) {
  const float a = block[0] / 255.0f, b = block[1] / 255.0f;
  std::array<float, 8> values = {a, b};
  for (int i = 2; i < 8; ++i) {
    const auto t = static_cast<float>(i - 1);
    values[i] = block[0] > block[1] ? (a * (7.0f - t) + b * t) / 7.0f
                : i < 6             ? (a * (5.0f - t) + b * t) / 5.0f
                                    : static_cast<float>(i - 6);
  }
  uint64_t bits = 0;
  for (int i = 0; i < 6; ++i) {
    bits |= uint64_t{block[2 + i]} << (8 * i);
  }
  std::array<float, 16> texels{};
  for (int i = 0; i < 16; ++i) {
    texels[i] = values[bits >> (3 * i) & 7u];
  }
  return texels;
}

struct Error2 {
  double sum = 0.0, most = 0.0;  // of squares
  uint64_t count = 0;

  void add(const Error2& e) {
    sum += e.sum;
    most = std::max(most, e.most);
    count += e.count;
  }
};

float squaredDistance(float x, float y, float other_x, float other_y) {
  const auto z = [](float a, float b) { return std::sqrt(std::max(1.0f - a * a - b * b, kLeastZ2)); };
  const float dx = x - other_x, dy = y - other_y, dz = z(x, y) - z(other_x, other_y);
  return dx * dx + dy * dy + dz * dz;
}

// Blocks of a level that holds slopes (two channels) or factors (one).
template <size_t kChannels>
Error2 writeBlocks(const Level<float>& level, std::byte* data, uint32_t threads) {
  const uint32_t columns = (level.width + 3) / 4, rows = (level.height + 3) / 4;
  std::vector<Error2> errors(rows);
  parallelFor(rows, threads, [&](uint32_t row) {
    for (uint32_t column = 0; column < columns; ++column) {
      std::array<float, 16 * kChannels> values{};
      std::array<unsigned char, 16 * kChannels> texels{};
      std::array<size_t, 16> from{};
      for (uint32_t i = 0; i < 16; ++i) {
        from[i] = size_t{std::min(4 * row + i / 4, level.height - 1)} * level.width +
                  std::min(4 * column + i % 4, level.width - 1);
        const float* source = level.texels + from[i] * kChannels;
        const float length =
            kChannels == 2
                ? std::sqrt(source[0] * source[0] + source[kChannels - 1] * source[kChannels - 1] + 1.0f)
                : 1.0f;
        for (size_t c = 0; c < kChannels; ++c) {
          values[i * kChannels + c] = source[c] / length;
          texels[i * kChannels + c] =
              unorm8(kChannels == 2 ? values[i * kChannels + c] * 0.5f + 0.5f : values[i * kChannels + c]);
        }
      }
      std::array<unsigned char, 8 * kChannels> block{};
      if constexpr (kChannels == 2) {
        stb_compress_bc5_block(block.data(), texels.data());
      } else {
        stb_compress_bc4_block(block.data(), texels.data());
      }
      std::memcpy(data + (size_t{row} * columns + column) * block.size(), block.data(), block.size());
      const auto first = decodedBlock(block.data()), second = decodedBlock(block.data() + block.size() - 8);
      for (size_t i = 0; i < 16; ++i) {
        if (level.weight(from[i]) == 0) {
          continue;
        }
        const float error = kChannels == 2 ? squaredDistance(values[2 * i], values[2 * i + 1],
                                                             first[i] * 2.0f - 1.0f, second[i] * 2.0f - 1.0f)
                                           : (values[i] - first[i]) * (values[i] - first[i]);
        errors[row].add({error, error, 1});
      }
    }
  });
  Error2 total;
  for (const Error2& error : errors) {
    total.add(error);
  }
  return total;
}

template <size_t kChannels>
EncodedTexture encodeBlocks(TextureFormat format, std::span<const Image> slices,
                            std::span<const Coverage> coverage, uint32_t threads) {
  EncodedTexture texture = sized(format, slices, kChannels, coverage);
  if (texture.width % 4 != 0 || texture.height % 4 != 0) {
    throw std::invalid_argument("encode: sides must be multiples of 4");
  }
  Error2 error;
  for (uint32_t slice = 0; slice < texture.slices; ++slice) {
    std::vector<Level<float>> levels = chain<float>(texture, coverage, slice);
    std::vector<std::vector<float>> texels(levels.size());
    for (size_t l = 0; l < levels.size(); ++l) {
      texels[l].resize(size_t{levels[l].width} * levels[l].height * kChannels);
      levels[l].texels = texels[l].data();
    }
    texels[0] = slices[slice].pixels;
    levels[0].texels = texels[0].data();
    for (size_t i = 0; kChannels == 2 && i < texels[0].size(); i += 2) {
      float &x = texels[0][i], &y = texels[0][i + 1];
      const float z = std::max(std::sqrt(std::max(1.0f - x * x - y * y, 0.0f)), kMinNormalZ);
      x /= z;
      y /= z;
    }
    complete<kChannels>(std::span(levels), threads);
    for (uint32_t l = 0; l < texture.levels; ++l) {
      const Error2 e = writeBlocks<kChannels>(levels[l], dataOf(texture, l, slice), threads);
      if (l == 0) {
        error.add(e);
      }
    }
  }
  // The chord between unit normals to the angle.
  const auto shown = [&](double squared) {
    return kChannels == 2
               ? 2.0 * std::asin(std::min(std::sqrt(squared) / 2.0, 1.0)) * 180.0 / std::numbers::pi
               : std::sqrt(squared);
  };
  texture.rms_error = shown(error.sum / static_cast<double>(std::max<uint64_t>(error.count, 1)));
  texture.largest_error = shown(error.most);
  return texture;
}

}  // namespace

EncodedTexture encode(TextureFormat format, std::span<const Image> slices, std::span<const Coverage> coverage,
                      uint32_t threads) {
  if (format == TextureFormat::kRgba8) {
    throw std::invalid_argument("encode: kRgba8 is made of bytes");
  }
  return format == TextureFormat::kBc5 ? encodeBlocks<2>(format, slices, coverage, threads)
                                       : encodeBlocks<1>(format, slices, coverage, threads);
}

EncodedTexture encodeBytes(std::span<const ByteImage> slices, std::span<const Coverage> coverage,
                           uint32_t threads) {
  EncodedTexture texture = sized(TextureFormat::kRgba8, slices, 4, coverage);
  for (uint32_t slice = 0; slice < texture.slices; ++slice) {
    std::vector<Level<uint8_t>> levels = chain<uint8_t>(texture, coverage, slice);
    for (uint32_t l = 0; l < texture.levels; ++l) {
      levels[l].texels = reinterpret_cast<uint8_t*>(dataOf(texture, l, slice));
    }
    std::memcpy(levels[0].texels, slices[slice].pixels.data(), slices[slice].pixels.size());
    complete<4>(std::span(levels), threads);
  }
  return texture;
}

Image decode(const Texture& texture, uint32_t slice) {
  const uint32_t channels = texture.format == TextureFormat::kBc5   ? 2
                            : texture.format == TextureFormat::kBc4 ? 1
                                                                    : 4;
  Image image{texture.width, texture.height, channels, {}};
  image.pixels.resize(size_t{image.width} * image.height * channels);
  const size_t bytes = textureLevelBytes(texture.format, texture.width, texture.height, 0);
  const auto* data = reinterpret_cast<const unsigned char*>(texture.data.data()) + bytes * slice;
  if (texture.format == TextureFormat::kRgba8) {
    std::transform(data, data + bytes, image.pixels.begin(),
                   [](unsigned char v) { return static_cast<float>(v) / 255.0f; });
    return image;
  }
  for (uint32_t y = 0; y < image.height; y += 4) {
    for (uint32_t x = 0; x < image.width; x += 4) {
      for (uint32_t c = 0; c < channels; ++c, data += 8) {
        const std::array<float, 16> texels = decodedBlock(data);
        for (uint32_t i = 0; i < 16; ++i) {
          if (x + i % 4 < image.width && y + i / 4 < image.height) {
            image.at(x + i % 4, y + i / 4)[c] = texels[i];
          }
        }
      }
    }
  }
  return image;
}

}  // namespace furrow::pipeline
