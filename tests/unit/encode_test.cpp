#include "pipeline/maps/encode.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <stdexcept>

#include "tests/unit/texture_decoder.h"

namespace furrow::pipeline {
namespace {

Image constant(uint32_t width, uint32_t height, std::initializer_list<float> value) {
  Image image{width, height, static_cast<uint32_t>(value.size()), {}};
  for (uint32_t i = 0; i < width * height; ++i) {
    image.pixels.insert(image.pixels.end(), value);
  }
  return image;
}

// Creases 16 texels apart, slope up to 0.8.
Image creases(uint32_t size) {
  Image image{size, size, 2, {}};
  for (uint32_t y = 0; y < size; ++y) {
    for (uint32_t x = 0; x < size; ++x) {
      const float along = static_cast<float>(x) + 0.3f * static_cast<float>(y);
      const float slope = 0.8f * std::sin(2.0f * 3.14159265f * along / 16.0f);
      const float length = std::sqrt(1.0f + slope * slope * 1.09f);
      image.pixels.push_back(slope / length);
      image.pixels.push_back(0.3f * slope / length);
    }
  }
  return image;
}

TEST(Encode, MasksArePackedToTheBit) {
  std::mt19937 random(3);
  ByteImage a{64, 32, 4, {}}, b = a;
  std::vector<uint8_t> bytes;
  for (ByteImage* image : {&a, &b}) {
    for (int i = 0; i < 64 * 32 * 4; ++i) {
      bytes.push_back(static_cast<uint8_t>(random()));
      image->pixels.push_back(bytes.back());
    }
  }
  const EncodedTexture texture = encodeBytes(std::array{a, b});
  EXPECT_EQ(texture.levels, 7u);
  EXPECT_EQ(texture.slices, 2u);
  ASSERT_GE(texture.data.size(), bytes.size());
  for (size_t i = 0; i < bytes.size(); ++i) {
    ASSERT_EQ(static_cast<uint8_t>(texture.data[i]), bytes[i]);
  }
  EXPECT_EQ(decode(texture, 6, 1).pixels.size(), 4u);
}

TEST(Encode, MaskMipsAreMeans) {
  Image image = constant(4, 4, {0, 0, 0, 0});
  image.at(0, 0)[3] = 1.0f;
  image.at(1, 0)[3] = 1.0f;
  const EncodedTexture texture = encodeBytes(std::array{toBytes(image)});
  EXPECT_EQ(decode(texture, 1, 0).at(0, 0)[3], 128.0f / 255.0f);
  EXPECT_EQ(decode(texture, 2, 0).at(0, 0)[3], 32.0f / 255.0f);
  EXPECT_EQ(decode(texture, 2, 0).at(0, 0)[0], 0.0f);
}

// Measured: 0.019 root mean square, 0.073 at most, where x changes by up to 0.9 within a block: its seven
// steps are 0.13 wide.
TEST(Encode, NormalsKeepTheirDirectionThroughBc5) {
  const Image image = creases(64);
  const Image back = decode(encode(TextureFormat::kBc5, std::array{image}), 0, 0);
  double sum = 0.0;
  float most = 0.0f;
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    const float error = std::abs(back.pixels[i] * 2.0f - 1.0f - image.pixels[i]);
    sum += static_cast<double>(error) * error;
    most = std::max(most, error);
  }
  const double rms = std::sqrt(sum / static_cast<double>(image.pixels.size()));
  RecordProperty("rms", std::to_string(rms));
  RecordProperty("largest", std::to_string(most));
  EXPECT_LT(rms, 0.02);
  EXPECT_LT(most, 0.08f);
}

TEST(Encode, FactorsKeepTheirValueThroughBc4) {
  Image image{64, 64, 1, {}};
  for (int i = 0; i < 64 * 64; ++i) {
    image.pixels.push_back(0.25f + 0.25f * std::sin(static_cast<float>(i % 64) / 3.0f));
  }
  const Image back = decode(encode(TextureFormat::kBc4, std::array{image}), 0, 0);
  float most = 0.0f;
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    most = std::max(most, std::abs(back.pixels[i] - image.pixels[i]));
  }
  RecordProperty("largest", std::to_string(most));
  EXPECT_LT(most, 0.03f);
}

// The mean of normals would not do: that of (s, 0, 1) and (0, 0, 1), normalised, is not the normal of slope s
// / 2.
TEST(Encode, NormalMipsAreMeansOfSlopes) {
  const Image slope = constant(32, 32, {0.6f, -0.36f});
  const EncodedTexture texture = encode(TextureFormat::kBc5, std::array{slope});
  EXPECT_EQ(texture.levels, 6u);
  for (uint32_t level = 0; level < texture.levels; ++level) {
    const Image back = decode(texture, level, 0);
    for (size_t i = 0; i < back.pixels.size(); i += 2) {
      EXPECT_NEAR(back.pixels[i] * 2.0f - 1.0f, 0.6f, 1.01f / 255.0f);
      EXPECT_NEAR(back.pixels[i + 1] * 2.0f - 1.0f, -0.36f, 1.01f / 255.0f);
    }
  }

  Image half = constant(16, 16, {0.0f, 0.0f});
  for (uint32_t y = 0; y < 16; ++y) {
    for (uint32_t x = 0; x < 16; x += 2) {
      half.at(x, y)[0] = 0.8f;  // slope 4/3
    }
  }
  const Image back = decode(encode(TextureFormat::kBc5, std::array{half}), 1, 0);
  const float expected = (2.0f / 3.0f) / std::sqrt(1.0f + 4.0f / 9.0f);
  EXPECT_NEAR(back.at(3, 3)[0] * 2.0f - 1.0f, expected, 1.01f / 255.0f);
}

// A chart of one value on a ground of another: whatever level a filter reads, it finds the chart's alone.
TEST(Encode, WhatLiesOutsideTheChartsReachesNoLevel) {
  Image shading = constant(64, 32, {1.0f}), normal = constant(64, 32, {-0.9f, 0.2f}),
        mask = constant(64, 32, {0, 1, 0, 1});
  Coverage coverage(64 * 32, 0);
  for (uint32_t y = 5; y < 18; ++y) {
    for (uint32_t x = 23; x < 42; ++x) {
      coverage[y * 64 + x] = 1;
      shading.at(x, y)[0] = 0.4f;
      normal.at(x, y)[0] = 0.6f;
      normal.at(x, y)[1] = -0.3f;
      mask.at(x, y)[0] = 102.0f / 255.0f;
    }
  }
  const std::array cover = {coverage};
  const EncodedTexture bc4 = encode(TextureFormat::kBc4, std::array{shading}, cover),
                       bc5 = encode(TextureFormat::kBc5, std::array{normal}, cover, 3),
                       rgba = encodeBytes(std::array{toBytes(mask)}, cover, 2);
  EXPECT_EQ(bc5.data, encode(TextureFormat::kBc5, std::array{normal}, cover).data);
  for (uint32_t level = 0; level < bc4.levels; ++level) {
    for (const float v : decode(bc4, level, 0).pixels) {
      ASSERT_NEAR(v, 0.4f, 0.6f / 255.0f) << level;
    }
    const Image normals = decode(bc5, level, 0), masks = decode(rgba, level, 0);
    for (size_t i = 0; i < normals.pixels.size(); i += 2) {
      ASSERT_NEAR(normals.pixels[i] * 2.0f - 1.0f, 0.6f, 1.01f / 255.0f) << level;
      ASSERT_NEAR(normals.pixels[i + 1] * 2.0f - 1.0f, -0.3f, 1.01f / 255.0f) << level;
    }
    for (size_t i = 0; i < masks.pixels.size(); i += 4) {
      ASSERT_EQ(masks.pixels[i], 102.0f / 255.0f) << level;
    }
  }
}

TEST(Encode, AChartOfOneTexelReachesEveryLevel) {
  ByteImage mask{128, 128, 4, std::vector<uint8_t>(size_t{4} * 128 * 128, 0)};
  Coverage coverage(128 * 128, 0);
  const size_t texel = 77 * 128 + 50;
  coverage[texel] = 1;
  mask.pixels[4 * texel] = 102;
  const EncodedTexture texture = encodeBytes(std::array{mask}, std::array{coverage});
  for (uint32_t level = 0; level < texture.levels; ++level) {
    const Image back = decode(texture, level, 0);
    for (size_t i = 0; i < back.pixels.size(); i += 4) ASSERT_EQ(back.pixels[i], 102.0f / 255.0f) << level;
  }
}

TEST(Encode, ErrorsAreThoseOfTheDecodedTexture) {
  const Image normal = creases(64);
  Image factor{64, 64, 1, {}};
  for (int i = 0; i < 64 * 64; ++i) {
    factor.pixels.push_back(0.5f + 0.5f * std::sin(static_cast<float>(i)));
  }
  const EncodedTexture bc5 = encode(TextureFormat::kBc5, std::array{normal}),
                       bc4 = encode(TextureFormat::kBc4, std::array{factor});
  const Image normal_back = decode(bc5, 0, 0), factor_back = decode(bc4, 0, 0);
  double sum = 0.0, most = 0.0, factor_sum = 0.0, factor_most = 0.0;
  for (size_t i = 0; i < factor.pixels.size(); ++i) {
    const auto unit = [](double x, double y) {
      return std::array{x, y, std::sqrt(std::max(1.0 - x * x - y * y, 1.0 / 257.0))};
    };
    const auto n = unit(normal.pixels[2 * i], normal.pixels[2 * i + 1]);
    const auto m = unit(normal_back.pixels[2 * i] * 2.0 - 1.0, normal_back.pixels[2 * i + 1] * 2.0 - 1.0);
    const double degrees = std::acos(std::min(n[0] * m[0] + n[1] * m[1] + n[2] * m[2], 1.0)) * 57.29577951;
    sum += degrees * degrees;
    most = std::max(most, degrees);
    const double error = std::abs(double{factor.pixels[i]} - factor_back.pixels[i]);
    factor_sum += error * error;
    factor_most = std::max(factor_most, error);
  }
  EXPECT_NEAR(bc5.rms_error, std::sqrt(sum / 4096.0), 0.01 * bc5.rms_error);
  EXPECT_NEAR(bc5.largest_error, most, 0.01 * most);
  EXPECT_NEAR(bc4.rms_error, std::sqrt(factor_sum / 4096.0), 1e-5);
  EXPECT_NEAR(bc4.largest_error, factor_most, 1e-5);
  EXPECT_EQ(encode(TextureFormat::kBc4, std::array{constant(8, 8, {0.2f})}).largest_error, 0.0);
}

TEST(Encode, RefusesSizesAndChannelsThatDoNotFit) {
  EXPECT_THROW(encode(TextureFormat::kBc4, std::array{constant(10, 8, {0})}), std::invalid_argument);
  EXPECT_THROW(encode(TextureFormat::kBc4, std::array{constant(2, 8, {0})}), std::invalid_argument);
  EXPECT_THROW(encode(TextureFormat::kBc5, std::array{constant(8, 8, {0})}), std::invalid_argument);
  EXPECT_THROW(encode(TextureFormat::kBc4, std::array{constant(8, 8, {0}), constant(4, 8, {0})}),
               std::invalid_argument);
  EXPECT_THROW(encode(TextureFormat::kRgba8, std::array{constant(8, 8, {0, 0, 0, 0})}),
               std::invalid_argument);
  EXPECT_THROW(encode(TextureFormat::kBc4, std::array{constant(8, 8, {0})}, std::array{Coverage(16)}),
               std::invalid_argument);
  EXPECT_EQ(encode(TextureFormat::kBc4, {}).slices, 0u);
  EXPECT_EQ(encodeBytes({}).slices, 0u);
}

}  // namespace
}  // namespace furrow::pipeline
