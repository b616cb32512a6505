#include "pipeline/maps/image.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <thread>

#include "pipeline/error.h"

namespace furrow::pipeline {
namespace {

class ImageTest : public testing::Test {
 protected:
  ImageTest() : folder_(testing::TempDir() + "furrow_image_test_" + std::to_string(std::random_device{}())) {
    std::filesystem::create_directories(folder_);
  }
  ~ImageTest() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_;
};

Image randomBytes(uint32_t width, uint32_t height, uint32_t channels) {
  Image image{width, height, channels, {}};
  std::mt19937 random(7);
  for (size_t i = 0; i < static_cast<size_t>(width) * height * channels; ++i) {
    image.pixels.push_back(static_cast<float>(random() & 255u) / 255.0f);
  }
  return image;
}

// Masks: the fourth channel is a layer like the others, also where it is 0.
TEST_F(ImageTest, EveryByteSurvivesInEveryNumberOfChannels) {
  for (uint32_t channels = 1; channels <= 4; ++channels) {
    Image image = randomBytes(37, 23, channels);
    image.at(5, 5)[channels - 1] = 0.0f;
    const auto file = folder_ / ("bytes" + std::to_string(channels) + ".png");
    writeImage(file, image);
    const Image back = readImage(file);
    ASSERT_EQ(back.width, image.width);
    ASSERT_EQ(back.height, image.height);
    ASSERT_EQ(back.channels, channels);
    for (size_t i = 0; i < image.pixels.size(); ++i) {
      ASSERT_EQ(back.pixels[i], image.pixels[i]) << "channel " << i % channels << " of " << channels;
    }
  }
}

// The first of them load the module.
TEST_F(ImageTest, ThreadsMayReadAndWriteAtOnce) {
  const Image image = randomBytes(16, 16, 4);
  std::vector<std::jthread> threads(8);
  for (size_t i = 0; i < threads.size(); ++i)
    threads[i] = std::jthread([&, file = folder_ / (std::to_string(i) + ".png")] {
      writeImage(file, image);
      EXPECT_EQ(readImage(file).pixels, image.pixels);
    });
}

TEST_F(ImageTest, WritesTheSameBytesTwiceAndLeavesNoTemporary) {
  const Image image = randomBytes(16, 16, 3);
  const auto bytes = [](const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  writeImage(folder_ / "a.png", image);
  writeImage(folder_ / "b.png", image);
  EXPECT_GT(bytes(folder_ / "a.png").size(), 0u);
  EXPECT_EQ(bytes(folder_ / "a.png"), bytes(folder_ / "b.png"));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 2);
}

TEST_F(ImageTest, RowsComeFromTheTop) {
  // A 1 x 2 PPM: red above blue.
  std::ofstream(folder_ / "two.ppm", std::ios::binary) << "P6\n1 2\n255\n"
                                                       << "\xff" << '\0' << '\0' << '\0' << '\0' << "\xff";
  const Image image = readImage(folder_ / "two.ppm");
  EXPECT_EQ(image.at(0, 0)[0], 1.0f);
  EXPECT_EQ(image.at(0, 1)[2], 1.0f);
}

std::string errorOf(const std::filesystem::path& file) {
  try {
    readImage(file);
  } catch (const Error& error) {
    EXPECT_EQ(error.exit(), Exit::kBadData);
    return error.what();
  }
  return "";
}

TEST_F(ImageTest, BadFilesAreNamedInOneLine) {
  std::ofstream(folder_ / "text.png") << "not an image";
  writeImage(folder_ / "whole.png", randomBytes(64, 64, 4));
  std::ifstream in(folder_ / "whole.png", std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(in), {});
  std::ofstream(folder_ / "cut.png", std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  for (const char* name : {"text.png", "cut.png", "absent.png"}) {
    const std::string message = errorOf(folder_ / name);
    EXPECT_THAT(message, testing::StartsWith((folder_ / name).string() + ": "));
    EXPECT_EQ(message.find('\n'), std::string::npos);
  }
}

TEST_F(ImageTest, EveryTruncationIsAnErrorOrAnImage) {
  writeImage(folder_ / "whole.png", randomBytes(8, 8, 4));
  std::ifstream in(folder_ / "whole.png", std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(in), {});
  for (size_t size = 0; size < bytes.size(); ++size) {
    std::ofstream(folder_ / "cut.png", std::ios::binary) << bytes.substr(0, size);
    try {
      EXPECT_EQ(readImage(folder_ / "cut.png").width, 8u);
    } catch (const Error&) {
    }
  }
}

TEST_F(ImageTest, CannotWriteIntoAMissingFolder) {
  try {
    writeImage(folder_ / "missing" / "a.png", randomBytes(4, 4, 1));
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.exit(), Exit::kEnvironment);
  }
}

TEST_F(ImageTest, WritesPngAlone) {
  try {
    writeImage(folder_ / "a.jpg", randomBytes(4, 4, 3));
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.exit(), Exit::kBadUsage);
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

TEST(SampleAt, IsAValueWhateverTheUvs) {
  const ByteImage image{2, 2, 1, {10, 20, 30, 40}};
  EXPECT_EQ(sampleAt(image, {0.25f, 0.25f}, 0), 10.0f / 255.0f);
  EXPECT_EQ(sampleAt(image, {-0.75f, 3.25f}, 0), 10.0f / 255.0f);
  for (const float far : {1e9f, -1e9f, 3e38f, -3e38f, INFINITY}) {
    const float value = sampleAt(image, {far, 0.25f}, 0);
    EXPECT_GE(value, 10.0f / 255.0f) << far;
    EXPECT_LE(value, 40.0f / 255.0f) << far;
  }
}

TEST(Resize, KeepsConstantsAndRampsAndHalvesByTheMean) {
  Image ramp{8, 4, 2, {}};
  for (uint32_t i = 0; i < 32; ++i) {
    ramp.pixels.push_back(static_cast<float>(i % 8));
    ramp.pixels.push_back(3.0f);
  }
  const Image large = resize(ramp, 16, 16);
  for (uint32_t x = 1; x < 15; ++x) {
    EXPECT_NEAR(large.at(x, 7)[0], (static_cast<float>(x) + 0.5f) / 2.0f - 0.5f, 1e-5f);
    EXPECT_NEAR(large.at(x, 7)[1], 3.0f, 1e-5f);
  }
  const Image small = resize(ramp, 4, 4);
  EXPECT_NEAR(small.at(1, 1)[0], 2.5f, 1e-5f);
  EXPECT_EQ(resize(ramp, 8, 4).pixels, ramp.pixels);
}

}  // namespace
}  // namespace furrow::pipeline
