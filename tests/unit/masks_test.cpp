#include "pipeline/maps/masks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "pipeline/error.h"
#include "pipeline/maps/encode.h"

namespace furrow::pipeline {
namespace {

using testing::HasSubstr;

class MasksTest : public testing::Test {
 protected:
  MasksTest() : folder_(testing::TempDir() + "furrow_masks_test_" + std::to_string(std::random_device{}())) {
    std::filesystem::create_directories(folder_);
  }
  ~MasksTest() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_;
};

ByteImage painted(uint32_t width, uint32_t height, uint32_t channels, uint32_t seed) {
  ByteImage image{width, height, channels, {}};
  std::mt19937 random(seed);
  for (size_t i = 0; i < size_t{width} * height * channels; ++i)
    image.pixels.push_back(static_cast<uint8_t>(random()));
  return image;
}

Image floats(const ByteImage& bytes) {
  Image image{bytes.width, bytes.height, bytes.channels, {}};
  for (const uint8_t v : bytes.pixels) image.pixels.push_back(static_cast<float>(v) / 255.0f);
  return image;
}

// From files through the packer and the encoder: every bit, also of colours under an alpha of 0.
TEST_F(MasksTest, PaintedBytesArriveToTheBit) {
  ByteImage colours = painted(20, 12, 4, 1);
  const ByteImage grey = painted(20, 12, 1, 2);
  for (size_t i = 3; i < colours.pixels.size(); i += 8) colours.pixels[i] = 0;
  writeImage(folder_ / "colours.png", floats(colours));
  writeImage(folder_ / "grey.png", floats(grey));
  const std::vector<std::filesystem::path> files = {folder_ / "colours.png", folder_ / "grey.png"};
  const MaskImages images = readMasks(files, 2);
  EXPECT_EQ(images.at(files[0]).pixels, colours.pixels);
  const ByteImage packed = packMasks(
      {{{&images.at(files[0]), 3}, {&images.at(files[1]), 0}, {}, {&images.at(files[0]), 1}}}, 20, 12, 2);
  const EncodedTexture texture = encodeBytes(std::array{packed});
  for (size_t i = 0; i < 20 * 12; ++i) {
    ASSERT_EQ(static_cast<uint8_t>(texture.data[4 * i]), colours.pixels[4 * i + 3]);
    ASSERT_EQ(static_cast<uint8_t>(texture.data[4 * i + 1]), grey.pixels[i]);
    ASSERT_EQ(static_cast<uint8_t>(texture.data[4 * i + 2]), 0);
    ASSERT_EQ(static_cast<uint8_t>(texture.data[4 * i + 3]), colours.pixels[4 * i + 1]);
  }
}

TEST_F(MasksTest, SmallerOnesAreResizedAmongLargerOnes) {
  const ByteImage large = painted(16, 16, 1, 3), small{8, 8, 2, std::vector<uint8_t>(128, 77)};
  const ByteImage packed = packMasks({{{&large, 0}, {&small, 1}, {}, {}}}, 16, 16, 1);
  for (size_t i = 0; i < 256; ++i) {
    ASSERT_EQ(packed.pixels[4 * i], large.pixels[i]);
    ASSERT_EQ(packed.pixels[4 * i + 1], 77);
  }
}

std::string messageOf(const ByteImage& image, uint32_t channel) {
  try {
    checkMask("mask.png", image, channel, "brow");
  } catch (const Error& error) {
    EXPECT_EQ(error.exit(), Exit::kBadData);
    EXPECT_THAT(error.what(), HasSubstr("mask.png: the mask of layer \"brow\""));
    return error.what();
  }
  return "";
}

TEST_F(MasksTest, EveryFaultHasItsMessage) {
  EXPECT_EQ(messageOf(painted(8, 8, 3, 4), 2), "");
  EXPECT_THAT(messageOf(painted(8, 8, 3, 4), 3), HasSubstr("is channel a, and the image has 3"));
  EXPECT_THAT(messageOf(painted(2, 8, 1, 4), 0), HasSubstr("is 2 x 8 texels"));
  EXPECT_THAT(messageOf({8, 8, 1, std::vector<uint8_t>(64, 0)}, 0),
              HasSubstr("is empty: channel r is black"));
  EXPECT_THAT(messageOf({8, 8, 1, std::vector<uint8_t>(64, 200)}, 0),
              HasSubstr("is constant: channel r is 200"));
  ByteImage normals{8, 8, 3, {}};
  for (int i = 0; i < 64; ++i) {
    const bool bent = i % 3 == 0;
    normals.pixels.insert(normals.pixels.end(), {static_cast<uint8_t>(bent ? 180 : 128), 128,
                                                 static_cast<uint8_t>(bent ? 244 : 255)});
  }
  for (uint32_t channel : {0u, 1u, 2u}) EXPECT_THAT(messageOf(normals, channel), HasSubstr("normal map"));
  std::vector<std::filesystem::path> missing = {folder_ / "a.png"};
  EXPECT_THROW(readMasks(missing, 2), Error);
}

}  // namespace
}  // namespace furrow::pipeline
