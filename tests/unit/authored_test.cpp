#include "pipeline/maps/authored.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <numbers>
#include <random>

#include "pipeline/bake/tangents.h"
#include "pipeline/error.h"
#include "pipeline/maps/synthesis.h"

namespace furrow::pipeline {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
const std::vector<uint32_t> kPart = {0};

class AuthoredTest : public testing::Test {
 protected:
  AuthoredTest()
      : folder_(testing::TempDir() + "furrow_authored_test_" + std::to_string(std::random_device{}())) {
    std::filesystem::create_directories(folder_);
  }
  ~AuthoredTest() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write(const std::vector<std::array<float, 3>>& colours) const {
    Image image{static_cast<uint32_t>(colours.size()), 1, 3, {}};
    for (const auto& colour : colours) image.pixels.insert(image.pixels.end(), colour.begin(), colour.end());
    writeImage(folder_ / "map.png", image);
    return folder_ / "map.png";
  }

  std::filesystem::path folder_;
};

std::array<float, 3> coloured(float x, float y, float z) {
  return {x * 0.5f + 0.5f, y * 0.5f + 0.5f, z * 0.5f + 0.5f};
}

TEST_F(AuthoredTest, GreenIsUpForOpenGlAndDownForDirectX) {
  const auto file = write({coloured(0.48f, 0.64f, 0.6f), coloured(0, 0, 1)});
  const Image up = readNormals(file, Green::kOpenGl), down = readNormals(file, Green::kDirectX);
  EXPECT_NEAR(up.at(0, 0)[0], 0.8f, 0.02f);
  EXPECT_NEAR(up.at(0, 0)[1], 0.64f / 0.6f, 0.02f);
  EXPECT_EQ(down.at(0, 0)[0], up.at(0, 0)[0]);
  EXPECT_EQ(down.at(0, 0)[1], -up.at(0, 0)[1]);
}

// A map that a tool blurred: shorter than 1, the same direction.
TEST_F(AuthoredTest, NormalsAreRenormalised) {
  const Image slopes =
      readNormals(write({coloured(0.384f, 0.0f, 0.64f), coloured(0, 0, 0.9f)}), Green::kOpenGl);
  const Image normal = mapsFromSlopes(slopes, {4, 4}).normal;
  EXPECT_NEAR(slopes.at(0, 0)[0], 0.6f, 0.02f);
  for (size_t i = 0; i < normal.pixels.size(); i += 2)
    EXPECT_LE(std::hypot(normal.pixels[i], normal.pixels[i + 1]), 0.6f / std::sqrt(1.36f) + 0.02f);
}

template <typename Read>
std::string faultOf(const Read& read) {
  try {
    read();
  } catch (const Error& e) {
    EXPECT_EQ(e.exit(), Exit::kBadData);
    return e.what();
  }
  return "";
}

TEST_F(AuthoredTest, WhatIsNoNormalMapIsRefused) {
  const auto error = [](const std::filesystem::path& file) {
    return faultOf([&] { readNormals(file, Green::kOpenGl); });
  };
  EXPECT_THAT(error(write({{0.1f, 0.1f, 0.1f}, {0.5f, 0.5f, 0.5f}})),
              testing::HasSubstr("100% of its texels"));
  EXPECT_THAT(error(write({coloured(0, 0, -1), coloured(0, 0, 1)})), testing::HasSubstr("50% of its texels"));
  EXPECT_THAT(error(write({coloured(0.008f, 0, 1), coloured(0, -0.008f, 1)})),
              testing::HasSubstr("all upright"));
  writeImage(folder_ / "grey.png", {4, 4, 1, std::vector<float>(16, 0.5f)});
  EXPECT_THAT(error(folder_ / "grey.png"), testing::HasSubstr("one channel"));
}

TEST_F(AuthoredTest, HeightsThatAreNoReliefAreRefused) {
  const auto error = [](const std::filesystem::path& file) { return faultOf([&] { readHeights(file); }); };
  EXPECT_EQ(error(write({{0.1f, 0, 0}, {0.2f, 0, 0}})), "");
  EXPECT_THAT(error(write({{0.1f, 0, 0}, {0.1f, 1, 1}})), testing::HasSubstr("one height everywhere"));
  // Two texels of red 0.5 and 2, as shared exponents.
  const std::string_view header = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n";
  const char texels[] = {'\x80', 0, 0, '\x80', '\x80', 0, 0, '\x82'};
  std::ofstream(folder_ / "tall.hdr", std::ios::binary)
      .write(header.data(), std::ssize(header))
      .write(texels, sizeof texels);
  EXPECT_THAT(error(folder_ / "tall.hdr"), testing::HasSubstr("its heights go from 0.5"));
}

// A sheet 2 wide and 0.5 high in z = 0 seen from +z; the image's right is +x (or -x, mirrored), its top +y.
Surface sheet(bool mirrored) {
  Surface surface;
  for (uint32_t i = 0; i < 4; ++i) {
    const float u = static_cast<float>(i % 2), v = static_cast<float>(i / 2);
    surface.positions.emplace_back(2.0f * u, 0.5f * (1.0f - v), 0.0f);
    surface.normals.emplace_back(0, 0, 1);
    surface.uvs.emplace_back(mirrored ? 1.0f - u : u, v);
    surface.vertex_point.push_back(i);
  }
  surface.point_positions = surface.positions;
  surface.point_normals = surface.normals;
  surface.triangles = {{0, 2, 1}, {1, 2, 3}};
  surface.tangents = tangents(surface.positions, surface.normals, surface.uvs, surface.triangles);
  SurfacePart part;
  part.vertex_end = 4;
  part.triangle_end = 2;
  part.has_uvs = true;
  surface.parts = {part};
  return surface;
}

Image heights(uint32_t size, const std::function<double(double, double)>& height) {
  Image image{size, size, 1, {}};
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x)
      image.pixels.push_back(static_cast<float>(height((x + 0.5) / size, (y + 0.5) / size)));
  return image;
}

TEST_F(AuthoredTest, HeightsHaveTheirSlopeOnTheSurface) {
  const uint32_t size = 256;
  const Image wave = heights(size, [](double u, double v) {
    return 0.5 + 0.2 * std::sin(kTurn * 3.0 * u) + 0.2 * std::sin(kTurn * 2.0 * v);
  });
  const double depth = 0.1;
  for (const bool mirrored : {false, true}) {
    const Surface surface = sheet(mirrored);
    const TexelMap texels = mapTexels(surface, chartsOf(surface, kPart), {size, size}, 2);
    const WrinkleMaps maps = mapsFromHeights(wave, surface, texels, depth);
    for (uint32_t y = 0; y < size; y += 7) {
      for (uint32_t x = 0; x < size; x += 7) {
        const double u = (x + 0.5) / size, v = (y + 0.5) / size;
        // Along the tangent, which is +u on the mirrored sheet too, and up the image.
        const double right = depth * 0.2 * kTurn * 3.0 * std::cos(kTurn * 3.0 * u) / 2.0;
        const double up = -depth * 0.2 * kTurn * 2.0 * std::cos(kTurn * 2.0 * v) / 0.5;
        const double length = std::sqrt(1.0 + right * right + up * up);
        ASSERT_NEAR(maps.normal.at(x, y)[0], -right / length, 2e-3) << x << ' ' << y << mirrored;
        ASSERT_NEAR(maps.normal.at(x, y)[1], -up / length, 2e-3) << x << ' ' << y << mirrored;
      }
    }
  }
}

TEST_F(AuthoredTest, AWindowShowsItsPartOfTheHeights) {
  const Image wave =
      heights(64, [](double u, double v) { return 0.5 + 0.25 * std::sin(kTurn * u) * std::cos(kTurn * v); });
  const Surface surface = sheet(false);
  const WrinkleMaps whole =
      mapsFromHeights(wave, surface, mapTexels(surface, chartsOf(surface, kPart), {64, 64}, 2), 0.2);
  const WrinkleMaps part = mapsFromHeights(
      wave, surface, mapTexels(surface, chartsOf(surface, kPart), {16, 24, {0.875, 0.25}, {0.25, 0.375}}, 2),
      0.2);
  for (uint32_t y = 0; y < 24; ++y)
    for (uint32_t x = 0; x < 16; ++x)
      for (uint32_t c = 0; c < 2; ++c)
        ASSERT_NEAR(part.normal.at(x, y)[c], whole.normal.at((x + 56) % 64, y + 16)[c], 1e-5f);
}

TEST_F(AuthoredTest, ShadingIsDarkInValleysOnly) {
  const uint32_t size = 128;
  const Image wave = heights(size, [](double u, double) { return 0.5 + 0.3 * std::cos(kTurn * 8.0 * u); });
  const Surface surface = sheet(false);
  const TexelMap texels = mapTexels(surface, chartsOf(surface, kPart), {size, size}, 2);
  const WrinkleMaps from_heights = mapsFromHeights(wave, surface, texels, 0.02);
  Image slopes{size, size, 2, {}};
  for (size_t i = 0; i < from_heights.normal.pixels.size(); i += 2) {
    const float x = from_heights.normal.pixels[i];
    slopes.pixels.insert(slopes.pixels.end(), {x / std::sqrt(1.0f - x * x), 0.0f});
  }
  const WrinkleMaps from_slopes = mapsFromSlopes(slopes, texels.grid);
  for (const Image& shading : {from_heights.shading, from_slopes.shading}) {
    EXPECT_EQ(shading.at(0, 40)[0], 0.0f);               // a ridge
    EXPECT_NEAR(shading.at(8, 40)[0], kDarkest, 0.02f);  // a valley
    EXPECT_NEAR(shading.at(8 + 16 * 3, 90)[0], kDarkest, 0.02f);
  }
  const WrinkleMaps flat =
      mapsFromHeights(heights(16, [](double, double) { return 0.5; }), surface, texels, 1.0);
  for (const float w : flat.shading.pixels) EXPECT_EQ(w, 0.0f);
}

TEST_F(AuthoredTest, LimitsCutNormalsOffWithoutTurningThem) {
  Image normal{2, 1, 2, {0.6f, 0.7f, -0.5f, 0.5f}};
  limitNormals(normal, 0.6f);
  EXPECT_NEAR(std::hypot(normal.pixels[0], normal.pixels[1]), std::sqrt(0.6f), 1e-6f);
  EXPECT_NEAR(normal.pixels[0] / normal.pixels[1], 6.0f / 7.0f, 1e-6f);
  EXPECT_EQ(normal.pixels[2], -0.5f);
}

// W is what is missing of the light that the flat surface gets.
TEST_F(AuthoredTest, LitShadingIsTheLightThatIsMissing) {
  for (const bool mirrored : {false, true}) {
    const Surface surface = sheet(mirrored);
    const TexelMap texels = mapTexels(surface, chartsOf(surface, kPart), {4, 4}, 2);
    const float right = mirrored ? -1.0f : 1.0f;
    Image normal{4, 4, 2, std::vector<float>(32, 0.0f)};
    normal.pixels[2] = 0.6f * right;  // faces +x
    normal.pixels[4] = -0.6f * right;
    normal.pixels[7] = 0.6f;  // faces +y
    // 36.87 degrees over the sheet, from -x.
    const Image shading = litShading(normal, surface, texels, {-0.8, 0.0, 0.6});
    EXPECT_EQ(shading.pixels[0], 0.0f);
    EXPECT_NEAR(shading.pixels[1], 1.0f, 1e-6f);  // (-0.8 * 0.6 + 0.6 * 0.8) / 0.6 = 0 of its light
    EXPECT_EQ(shading.pixels[2], 0.0f);           // more light than flat
    EXPECT_NEAR(shading.pixels[3], 0.2f, 1e-6f);  // 0.8 * 0.6 / 0.6
    // A light in the surface's plane is taken to stand 30 degrees over it: 0.866 * 0.6 - 0.8 * 0.5 > 0.
    EXPECT_EQ(litShading(normal, surface, texels, {1.0, 0.0, 0.0}).pixels[2], 1.0f);
    EXPECT_EQ(litShading(normal, surface, texels, {1.0, 0.0, 0.0}).pixels[1], 0.0f);
  }
}

}  // namespace
}  // namespace furrow::pipeline
