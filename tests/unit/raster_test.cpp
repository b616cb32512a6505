#include "furrow/raster.h"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <random>
#include <vector>

#include "raster_shade.h"
#include "tests/unit/texture_decoder.h"

namespace furrow::tests {
namespace {

// A surface, and all that a picture of it needs.
Part opaquePart() {
  Part part{};
  part.base_color = {1.0f, 1.0f, 1.0f, 1.0f};
  return part;
}

struct Scene {
  std::vector<Float3> positions, colors, back_colors;
  std::vector<Float2> uvs;
  std::vector<uint32_t> indices;
  std::vector<int16_t> weights;
  Part part = opaquePart();
  Layer layer{};
  TextureSet set{};
  AssetView asset;

  std::vector<RasterVertex> vertices;
  std::vector<uint64_t> bins;
  std::vector<Float4> picture;
  std::vector<float> depth;
  std::vector<std::byte> scratch = std::vector<std::byte>(kRasterScratchBytes + 64);

  void add(Float3 a, Float3 b, Float3 c, Float3 color = {1, 1, 1}) {
    for (const Float3& p : {a, b, c}) {
      indices.push_back(static_cast<uint32_t>(positions.size()));
      positions.push_back(p);
      colors.push_back(color);
    }
  }

  RasterJob job(uint32_t width, uint32_t height, uint32_t samples) {
    uvs.resize(positions.size());
    colors.resize(positions.size());
    part.triangle_end = static_cast<uint32_t>(indices.size() / 3);
    asset.positions = positions;
    asset.uvs = uvs;
    asset.indices = indices;
    asset.parts = {&part, 1};
    asset.layers = {&layer, 1};
    asset.texture_sets = {&set, 1};
    vertices.resize(positions.size());
    bins.assign(rasterBinWords(asset.triangleCount(), width, height), ~uint64_t{0});
    picture.assign(size_t{width} * height, {-1, -1, -1, -1});
    depth.assign(size_t{width} * height, -1.0f);
    RasterJob job;
    job.asset = &asset;
    job.positions = positions;
    job.width = width;
    job.height = height;
    job.samples = samples;
    job.colors = colors;
    job.back_colors = back_colors;
    job.weights = weights;
    job.vertices = vertices;
    job.bins = bins;
    job.picture = picture;
    job.depth = depth;
    return job;
  }

  void run(const RasterJob& job, uint32_t pieces = 1) {
    const Status status = job.validate();
    ASSERT_TRUE(status.ok()) << status.message;
    const size_t address = reinterpret_cast<size_t>(scratch.data());
    const std::span<std::byte> aligned = std::span(scratch).subspan((64 - address % 64) % 64);
    const auto each = [&](uint32_t count, const auto& pass) {
      for (uint32_t i = pieces; i-- > 0;)
        pass(static_cast<uint32_t>(uint64_t{count} * i / pieces),
             static_cast<uint32_t>(uint64_t{count} * (i + 1) / pieces));
    };
    each(asset.vertexCount(), [&](uint32_t b, uint32_t e) { job.project(b, e); });
    each(rasterBatches(asset.triangleCount()), [&](uint32_t b, uint32_t e) { job.bin(b, e); });
    each(rasterTiles(job.width, job.height), [&](uint32_t b, uint32_t e) { job.draw(b, e, aligned); });
  }
};

// World units are pixels, from the top left corner; depth is z.
void usePixels(RasterJob& job) {
  const float m[16] = {2.0f / static_cast<float>(job.width),
                       0,
                       0,
                       -1,
                       0,
                       -2.0f / static_cast<float>(job.height),
                       0,
                       1,
                       0,
                       0,
                       1,
                       0,
                       0,
                       0,
                       0,
                       1};
  std::copy(m, m + 16, job.view_projection);
}

// From `height` above the plane y = 0, looking along -z and down by `down`; 90 degrees wide, near plane at 1.
void usePlaneView(RasterJob& job, float height, float down) {
  const float n = 1.0f, f = 1000.0f, a = (f + n) / (n - f), b = 2 * f * n / (n - f);
  const float c = std::cos(down), s = std::sin(down);
  // View: y' = c (y - h) - s z, z' = s (y - h) + c z (looking down turns -z towards -y).
  const float m[16] = {1, 0,  0,  0,         0, c, -s, -c * height, 0, a * s, a * c, -a * s * height + b,
                       0, -s, -c, s * height};
  std::copy(m, m + 16, job.view_projection);
}

// Grid of n x n jittered quads over [low, high]^2, as given by place(u, v).
template <typename Place>
Scene jitteredGrid(uint32_t n, float low, float high, const Place& place) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> jitter(-0.3f, 0.3f);
  const float step = (high - low) / static_cast<float>(n);
  std::vector<Float3> grid;
  for (uint32_t y = 0; y <= n; ++y)
    for (uint32_t x = 0; x <= n; ++x) {
      const bool edge = x == 0 || y == 0 || x == n || y == n;
      const float u = static_cast<float>(x) + (edge ? 0 : jitter(random)),
                  v = static_cast<float>(y) + (edge ? 0 : jitter(random));
      grid.push_back(place(low + step * u, low + step * v));
    }
  Scene scene;
  scene.positions = grid;
  scene.colors.assign(grid.size(), {1, 1, 1});
  for (uint32_t y = 0; y < n; ++y)
    for (uint32_t x = 0; x < n; ++x) {
      const uint32_t a = y * (n + 1) + x, b = a + 1, c = a + n + 1, d = c + 1;
      for (uint32_t i : {a, b, d, a, d, c}) scene.indices.push_back(i);
    }
  return scene;
}

// How often each sample is hit when every triangle is drawn alone, summed over a pixel's samples.
std::vector<float> hitsOneByOne(const Scene& whole, uint32_t side, uint32_t samples,
                                const std::function<void(RasterJob&)>& view) {
  std::vector<float> hits(size_t{side} * side, 0.0f);
  for (size_t t = 0; t < whole.indices.size(); t += 3) {
    Scene one;
    one.positions = whole.positions;
    one.colors = whole.colors;
    one.indices = {whole.indices[t], whole.indices[t + 1], whole.indices[t + 2]};
    RasterJob job = one.job(side, side, samples);
    view(job);
    one.run(job);
    for (size_t i = 0; i < hits.size(); ++i) hits[i] += one.picture[i].w;
  }
  return hits;
}

TEST(Raster, CountsPixelsOfTheTopLeftRule) {
  // Pixel centres on the long side belong to the triangle whose left or top side it is.
  const auto count = [](Float3 a, Float3 b, Float3 c) {
    Scene scene;
    scene.add(a, b, c);
    RasterJob job = scene.job(80, 70, 1);
    usePixels(job);
    scene.run(job);
    int pixels = 0;
    for (const Float4& p : scene.picture) {
      EXPECT_TRUE(p.w == 0.0f || p.w == 1.0f);
      pixels += p.w == 1.0f;
    }
    return pixels;
  };
  EXPECT_EQ(count({0, 0, 0}, {8, 0, 0}, {0, 8, 0}), 28);
  EXPECT_EQ(count({8, 0, 0}, {8, 8, 0}, {0, 8, 0}), 36);
  EXPECT_EQ(count({8, 0, 0}, {0, 8, 0}, {8, 8, 0}), 36);  // whichever way it is wound
  // Top and left edges on centres count, right and bottom ones do not: 4 x 4 of two triangles.
  EXPECT_EQ(count({60.5f, 60.5f, 0}, {64.5f, 60.5f, 0}, {60.5f, 64.5f, 0}) +
                count({64.5f, 60.5f, 0}, {64.5f, 64.5f, 0}, {60.5f, 64.5f, 0}),
            16);
  EXPECT_EQ(count({3, 3, 0}, {9, 9, 0}, {6, 6, 0}), 0);
  EXPECT_EQ(count({-5000, -5000, 0}, {9000, -5000, 0}, {-5000, 9000, 0}), 80 * 70);  // over the guard band
}

TEST(Raster, FourSamplesMeasureCoverageInQuarters) {
  Scene scene;  // covers x < 10.5: two of four samples of column 10 lie left of its middle
  scene.add({0, 0, 0}, {10.5f, 0, 0}, {0, 32, 0});
  scene.add({10.5f, 0, 0}, {10.5f, 32, 0}, {0, 32, 0});
  RasterJob job = scene.job(32, 32, 4);
  usePixels(job);
  scene.run(job);
  for (uint32_t y = 0; y < 32; ++y) {
    EXPECT_EQ(scene.picture[y * 32 + 9].w, 1.0f);
    EXPECT_EQ(scene.picture[y * 32 + 10].w, 0.5f);
    EXPECT_EQ(scene.picture[y * 32 + 11].w, 0.0f);
  }
}

TEST(Raster, SharedEdgesAreHitOnce) {
  constexpr uint32_t kSide = 150;  // not whole tiles
  for (uint32_t samples : {1u, 4u})
    for (float snap : {2.0f, 1024.0f}) {  // to half pixels, so that many edges pass through samples; freely
      const Scene grid = jitteredGrid(9, -3.0f, 153.0f, [&](float u, float v) {
        return Float3{std::round(u * snap) / snap, std::round(v * snap) / snap, 0.0f};
      });
      for (float hits : hitsOneByOne(grid, kSide, samples, usePixels)) ASSERT_EQ(hits, 1.0f);
    }
}

TEST(Raster, ClippingLeavesNoGapAndHitsNothingTwice) {
  constexpr uint32_t kSide = 96;
  constexpr float kDown = 0.3f, kHeight = 0.9f, kExtent = 900.0f;
  // The ground from behind the eye to the far distance: crosses the near plane and the guard band.
  const Scene ground = jitteredGrid(7, -kExtent, kExtent, [](float u, float v) {
    return Float3{u, 0.0f, v};
  });
  const auto view = [](RasterJob& job) { usePlaneView(job, kHeight, kDown); };
  const std::vector<float> hits = hitsOneByOne(ground, kSide, 1, view);
  int on_ground = 0;
  for (uint32_t y = 0; y < kSide; ++y)
    for (uint32_t x = 0; x < kSide; ++x) {
      // The ray through the pixel's centre, by hand.
      const float sx = (static_cast<float>(x) + 0.5f) / kSide * 2 - 1,
                  sy = 1 - (static_cast<float>(y) + 0.5f) / kSide * 2;
      const float dy = sy * std::cos(kDown) - std::sin(kDown), dz = -sy * std::sin(kDown) - std::cos(kDown);
      const float t = dy < 0.0f ? -kHeight / dy : INFINITY;
      const float where = std::max(std::abs(sx * t), std::abs(dz * t));
      if (t >= 1.02f && where < 0.97f * kExtent) {
        ASSERT_EQ(hits[y * kSide + x], 1.0f) << x << ' ' << y;
        ++on_ground;
      } else if (t < 0.98f || where > 1.03f * kExtent) {
        ASSERT_EQ(hits[y * kSide + x], 0.0f) << x << ' ' << y;
      }
    }
  EXPECT_GT(on_ground, 4000);
}

TEST(Raster, InterpolatesInPerspective) {
  // The colour is the place on the ground: compare with where the pixel's ray meets it. One triangle is
  // clipped in front of the eye, the others are not.
  constexpr uint32_t kSide = 128;
  constexpr float kDown = 0.5f, kHeight = 2.0f;
  for (float near_end : {40.0f, -3.0f}) {
    Scene scene;
    scene.add({-50, 0, near_end}, {60, 0, near_end}, {0, 0, -80});
    for (size_t v = 0; v < 3; ++v) scene.colors[v] = {scene.positions[v].x, scene.positions[v].z, 1.0f};
    RasterJob job = scene.job(kSide, kSide, 1);
    usePlaneView(job, kHeight, kDown);
    scene.run(job);
    int compared = 0;
    for (uint32_t y = 0; y < kSide; ++y)
      for (uint32_t x = 0; x < kSide; ++x) {
        const Float4 p = scene.picture[y * kSide + x];
        if (p.w == 0.0f) continue;
        const double sx = (x + 0.5) / kSide * 2 - 1, sy = 1 - (y + 0.5) / kSide * 2;
        const double dy = sy * std::cos(kDown) - std::sin(kDown),
                     dz = -sy * std::sin(kDown) - std::cos(kDown);
        const double t = -kHeight / dy;
        // Corners are snapped to 1/256 pixel, which moves a place by so much of what a pixel sees of it.
        const double pixel = 2.0 / kSide * t * t / kHeight;
        ASSERT_NEAR(p.x, sx * t, 0.006 * pixel + 1e-4) << x << ' ' << y;
        ASSERT_NEAR(p.y, dz * t, 0.006 * pixel + 1e-4) << x << ' ' << y;
        ASSERT_NEAR(p.z, 1.0f, 1e-6f);
        ++compared;
      }
    EXPECT_GT(compared, 3000);
  }
}

// Which samples a triangle through the near plane covers, and what they show, by the rays through them: a
// plane that is off by 0.1 % moves its edge by a pixel here.
TEST(Raster, TheNearPlaneCutsWhereItIs) {
  constexpr uint32_t kWidth = 256, kHeight = 4096;
  constexpr double kUp = 0.5, kFar = 40.0, kLeft = -0.6, kLeftZ = 6.0, kRight = 0.9, kRightZ = 9.0;
  Scene scene;
  scene.add({0, 0, -static_cast<float>(kFar)}, {static_cast<float>(kLeft), 0, static_cast<float>(kLeftZ)},
            {static_cast<float>(kRight), 0, static_cast<float>(kRightZ)});
  for (size_t v = 0; v < 3; ++v) scene.colors[v] = {scene.positions[v].x, scene.positions[v].z, 1.0f};
  RasterJob job = scene.job(kWidth, kHeight, 1);
  usePlaneView(job, static_cast<float>(kUp), 0.0f);
  scene.run(job);
  const auto placeOf = [](double x, double y) {
    const double distance = kUp / (y / kHeight * 2 - 1);
    return std::array{(x / kWidth * 2 - 1) * distance, -distance};
  };
  const auto inside = [&](double x, double y) {
    const auto [at, z] = placeOf(x, y);
    const double along = z + kFar;
    return z <= -1.0 && z > -kFar && at > kLeft * along / (kLeftZ + kFar) &&
           at < kRight * along / (kRightZ + kFar);
  };
  uint32_t covered = 0, near_edge = 0, unsure = 0;
  for (uint32_t row = kHeight / 2; row < kHeight; ++row)
    for (uint32_t column = 0; column < kWidth; ++column) {
      const double x = column + 0.5, y = row + 0.5, step = 0.02;
      const bool expected = inside(x, y);
      if (inside(x - step, y) != expected || inside(x + step, y) != expected ||
          inside(x, y - step) != expected || inside(x, y + step) != expected) {
        ++unsure;
        continue;
      }
      const Float4 p = scene.picture[row * kWidth + column];
      ASSERT_EQ(p.w, expected ? 1.0f : 0.0f) << column << ' ' << row;
      if (!expected) continue;
      ++covered;
      const auto [at, z] = placeOf(x, y);
      if (z < -1.01) continue;
      ++near_edge;
      ASSERT_NEAR(p.x, at, 5e-5) << column << ' ' << row;
      ASSERT_NEAR(p.y, z, 5e-5) << column << ' ' << row;
      ASSERT_NEAR(scene.depth[row * kWidth + column], (1001.0 - 2000.0 / -z) / 999.0, 5e-5);
    }
  EXPECT_GT(covered, 70'000u);
  EXPECT_GT(near_edge, 1000u);
  EXPECT_LT(unsure, 1000u);
}

TEST(Raster, TheNearestIsSeenInWhateverOrder) {
  // Two slanted walls that cross: left of the middle the red one is nearer.
  const Float3 red = {1, 0, 0}, green = {0, 1, 0};
  for (bool swapped : {false, true}) {
    Scene scene;
    const auto wall = [&](float left, float right, Float3 color) {
      scene.add({0, 0, left}, {64, 0, right}, {0, 64, left}, color);
      scene.add({64, 0, right}, {64, 64, right}, {0, 64, left}, color);
    };
    if (swapped) wall(0.5f, -0.5f, green);
    wall(-0.5f, 0.5f, red);
    if (!swapped) wall(0.5f, -0.5f, green);
    RasterJob job = scene.job(64, 64, 1);
    usePixels(job);
    scene.run(job);
    for (uint32_t y = 0; y < 64; ++y)
      for (uint32_t x = 0; x < 64; ++x) {
        ASSERT_EQ(scene.picture[y * 64 + x].x, x < 32 ? 1.0f : 0.0f) << x;
        const float at = (static_cast<float>(x) + 0.5f) / 64.0f - 0.5f;
        ASSERT_NEAR(scene.depth[y * 64 + x], -std::abs(at), 1e-6f);
      }
  }
}

TEST(Raster, OfEqualDepthsTheLaterWinsAndTheFarPlaneCuts) {
  Scene scene;
  scene.add({0, 0, 0.25f}, {128, 0, 0.25f}, {0, 128, 0.25f}, {1, 0, 0});
  scene.add({0, 0, 0.25f}, {128, 0, 0.25f}, {0, 128, 0.25f}, {0, 0, 1});
  scene.add({0, 0, 0.25f}, {128, 0, 0.25f}, {0, 128, -9.0f}, {0, 1, 0});  // before the near plane lower down
  scene.add({0, 0, 1.5f}, {128, 0, 1.5f}, {0, 128, 1.5f}, {1, 1, 0});
  RasterJob job = scene.job(64, 64, 1);
  usePixels(job);
  scene.run(job);
  for (uint32_t y = 0; y < 64; ++y) {
    // z = 0.25 - 9.25 y / 128 of the third reaches -1 at y = 17.3.
    EXPECT_EQ(scene.picture[y * 64].y, y < 17 ? 1.0f : 0.0f) << y;
    EXPECT_EQ(scene.picture[y * 64].z, y < 17 ? 0.0f : 1.0f) << y;
  }
  Scene beyond;
  beyond.add({0, 0, 0.5f}, {128, 0, 2.5f}, {0, 128, 0.5f});
  RasterJob cut = beyond.job(64, 64, 1);
  usePixels(cut);
  beyond.run(cut);  // z = 0.5 + 2 x / 128 is 1 at x = 32
  for (uint32_t x = 0; x < 64; ++x) EXPECT_EQ(beyond.picture[x].w, x < 32 ? 1.0f : 0.0f) << x;
}

TEST(Raster, SidesAreToldApartByTheWayTheyAreWound) {
  Scene scene;
  scene.add({0, 0, 0}, {0, 64, 0}, {64, 0, 0});    // counter-clockwise as seen: the front
  scene.add({64, 64, 0}, {0, 64, 0}, {64, 0, 0});  // clockwise
  scene.back_colors.assign(6, {0, 1, 0});
  RasterJob job = scene.job(64, 64, 4);
  usePixels(job);
  scene.run(job);
  EXPECT_EQ(scene.picture[10 * 64 + 10].x, 1.0f);
  EXPECT_EQ(scene.picture[50 * 64 + 50].x, 0.0f);
  EXPECT_EQ(scene.picture[50 * 64 + 50].y, 1.0f);
}

// A bumpy ground with a map and a mask, from behind the eye to the distance.
Scene busyScene(std::vector<std::byte>& map, std::vector<std::byte>& mask) {
  Scene scene = jitteredGrid(40, -60.0f, 60.0f, [](float u, float v) {
    return Float3{u, 0.4f * std::sin(u * 0.8f) * std::cos(v), v};
  });
  std::mt19937 random(3);
  for (const Float3& p : scene.positions) {
    scene.uvs.push_back({p.x * 0.05f, p.z * 0.05f});
    scene.weights.insert(scene.weights.end(), {static_cast<int16_t>(std::lround(32767 * std::sin(p.x))), 0});
  }
  for (Float3& c : scene.colors) c = {static_cast<float>(random() % 256) / 255.0f, 0.5f, 2.0f};
  map.resize(128 * 2);
  for (std::byte& b : map) b = static_cast<std::byte>(random() % 256);
  mask.resize(64 * 4);
  for (std::byte& b : mask) b = static_cast<std::byte>(random() % 256);
  scene.set.shading = {TextureFormat::kBc4, 16, 16, 2, 1, map};
  scene.set.masks = {TextureFormat::kRgba8, 8, 8, 1, 1, mask};
  scene.set.compress_slice[0] = 0;
  scene.set.stretch_slice[0] = 1;
  scene.set.windows[0] = {0.1f, 0.2f, 1.5f, 1.0f};
  scene.set.windows[1] = {0.0f, 0.0f, 1.0f, 1.0f};
  scene.layer.mask_slice = 2;
  return scene;
}

TEST(Raster, TheBitsDependNeitherOnTheSplitNorOnTheInstructionSet) {
  std::vector<std::byte> map, mask;
  Scene scene = busyScene(map, mask);
  std::vector<std::byte> color(16 * 16);  // the alpha of half the texels is below a half
  for (size_t i = 0; i < color.size(); ++i) color[i] = map[i % map.size()];
  const BaseMaps maps = {{TextureFormat::kBc3, 16, 16, 1, 1, color},
                         {1, 0.5f, 0, 1, 0, 0},
                         0.3f,
                         {},
                         {1, 0, 0, 1, 0, 0},
                         {},
                         {}};
  scene.asset.base_maps = {&maps, 1};
  scene.part.base_maps = 0;
  scene.part.base_color.w = 0.9f;
  RasterJob job = scene.job(200, 130, 4);
  usePlaneView(job, 3.0f, 0.2f);
  job.simd = Simd::kPortable;
  scene.run(job);
  const std::vector<Float4> expected = scene.picture;
  const std::vector<float> depth = scene.depth;
  int drawn = 0;
  for (const Float4& p : expected) drawn += p.w > 0.0f;
  EXPECT_GT(drawn, 8000);
  for (Simd simd : {Simd::kPortable, Simd::kSse4, Simd::kAvx2, Simd::kAvx512, Simd::kNeon}) {
    if (!simdAvailable(simd)) continue;
    for (uint32_t pieces : {1u, 3u, 7u}) {
      job = scene.job(200, 130, 4);
      usePlaneView(job, 3.0f, 0.2f);
      job.simd = simd;
      scene.run(job, pieces);
      EXPECT_EQ(std::memcmp(scene.picture.data(), expected.data(), expected.size() * sizeof(Float4)), 0)
          << simdName(simd) << ' ' << pieces;
      EXPECT_EQ(std::memcmp(scene.depth.data(), depth.data(), depth.size() * sizeof(float)), 0)
          << simdName(simd) << ' ' << pieces;
    }
  }
}

TEST(Raster, PositionsThatAreNotFiniteLeaveTheirTrianglesOut) {
  Scene scene;
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  scene.add({0, 0, 0}, {64, 0, 0}, {nan, 64, 0});
  scene.add({0, 0, 0}, {64, inf, 0}, {0, 64, 0});
  scene.add({0, 0, 0.5f}, {64, 0, 0.5f}, {0, 64, 0.5f}, {0, 1, 0});
  scene.add({0, 0, 0}, {3e38f, 0, 0}, {0, 3e38f, 3e38f});
  RasterJob job = scene.job(64, 64, 4);
  usePixels(job);
  scene.run(job);
  EXPECT_EQ(scene.picture[64 * 5 + 40].y, 1.0f);
  for (const Float4& p : scene.picture) ASSERT_TRUE(std::isfinite(p.x + p.y + p.z + p.w));
}

// A square of 64 pixels with uv from 0 to `repeats`.
Scene mappedSquare(float repeats, int16_t weight) {
  Scene scene;
  scene.positions = {{0, 0, 0}, {64, 0, 0}, {0, 64, 0}, {64, 64, 0}};
  scene.uvs = {{0, 0}, {repeats, 0}, {0, repeats}, {repeats, repeats}};
  scene.colors.assign(4, {1.0f, 0.5f, 0.25f});
  scene.indices = {0, 2, 1, 1, 2, 3};
  for (int v = 0; v < 4; ++v) scene.weights.insert(scene.weights.end(), {weight, 0});
  scene.set.compress_slice[0] = 0;
  scene.set.stretch_slice[0] = kAbsent;
  scene.set.windows[0] = {0, 0, 1, 1};
  scene.layer.mask_slice = kAbsent;
  return scene;
}

// A BC4 block whose four columns of texels have these codes.
std::vector<std::byte> columnsBlock(uint8_t e0, uint8_t e1, std::array<uint64_t, 4> codes) {
  uint64_t bits = e0 | static_cast<uint64_t>(e1) << 8;
  for (int i = 0; i < 16; ++i) bits |= codes[static_cast<size_t>(i % 4)] << (16 + 3 * i);
  std::vector<std::byte> block;
  for (int i = 0; i < 8; ++i) block.push_back(static_cast<std::byte>(bits >> (8 * i) & 255));
  return block;
}

float redAt(Scene& scene, uint32_t x, uint32_t y) {
  RasterJob job = scene.job(64, 64, 1);
  usePixels(job);
  scene.run(job);
  const Float4 p = scene.picture[y * 64 + x];
  EXPECT_NEAR(p.y, 0.5f * p.x, 1e-6f);  // creases are grey
  return p.x;
}

TEST(RasterShading, DarkensByIntensityTimesMap) {
  const std::vector<std::byte> map = columnsBlock(204, 51, {0, 0, 1, 1});  // W = 0.8 and 0.2
  Scene scene = mappedSquare(1.0f, 16384);
  scene.set.shading = {TextureFormat::kBc4, 4, 4, 1, 1, map};
  EXPECT_NEAR(redAt(scene, 15, 30), 1.0f - 0.5f * 0.8f, 1e-4f);  // between the texels 0 and 1
  EXPECT_NEAR(redAt(scene, 47, 30), 1.0f - 0.5f * 0.2f, 1e-4f);
  // Pixel 31 is at u = 31.5 / 64: 0.46875 of the way from texel 1 to texel 2.
  EXPECT_NEAR(redAt(scene, 31, 30), 1.0f - 0.5f * (0.8f + (0.2f - 0.8f) * 0.46875f), 1e-4f);
  // Pixel 0 is at texel -0.46875: the map repeats, and texel 3 is at the left of texel 0.
  EXPECT_NEAR(redAt(scene, 0, 30), 1.0f - 0.5f * (0.8f + (0.2f - 0.8f) * 0.46875f), 1e-4f);
  // A stretched surface has another map, here none.
  Scene stretched = mappedSquare(1.0f, -16384);
  stretched.set.shading = scene.set.shading;
  EXPECT_EQ(redAt(stretched, 15, 30), 1.0f);
  // Beside its window a map says nothing.
  scene.set.windows[0] = {0.5f, 0.0f, 2.0f, 1.0f};
  EXPECT_EQ(redAt(scene, 15, 30), 1.0f);
  EXPECT_NEAR(redAt(scene, 39, 30), 1.0f - 0.5f * 0.8f, 0.01f);  // a quarter into the window
}

// Weights and places on the maps are those of the point of the ground that a pixel's ray meets.
TEST(RasterShading, CreasesLieInPerspective) {
  constexpr uint32_t kSide = 128;
  constexpr float kDown = 0.5f, kHeight = 2.0f;
  Scene scene;
  scene.add({-50, 0, 40}, {60, 0, 40}, {0, 0, -80});
  scene.uvs = {{0.15f, 0.3f}, {0.85f, 0.3f}, {0.4f, 0.9f}};
  const int16_t weights[3] = {6553, 32767, 16384};
  for (const int16_t weight : weights) scene.weights.insert(scene.weights.end(), {weight, 0});
  scene.set.compress_slice[0] = 0;
  scene.set.stretch_slice[0] = kAbsent;
  scene.set.windows[0] = {0, 0, 1, 1};
  scene.layer.mask_slice = kAbsent;
  std::vector<std::byte> texels;  // as RGBA8, of which the first channel counts
  for (uint32_t y = 0; y < 4; ++y)
    for (uint32_t x = 0; x < 4; ++x) texels.insert(texels.end(), 4, static_cast<std::byte>(60 * x));
  for (const bool mapped : {false, true}) {
    scene.set.shading = {TextureFormat::kRgba8, 4, 4, 1, 1, texels};
    scene.part.texture_set = mapped ? 0 : kAbsent;
    RasterJob job = scene.job(kSide, kSide, 1);
    usePlaneView(job, kHeight, kDown);
    scene.run(job);
    int compared = 0;
    for (uint32_t y = 0; y < kSide; ++y)
      for (uint32_t x = 0; x < kSide; ++x) {
        const Float4 p = scene.picture[y * kSide + x];
        if (p.w == 0.0f) continue;
        const double sx = (x + 0.5) / kSide * 2 - 1, sy = 1 - (y + 0.5) / kSide * 2;
        const double t = -kHeight / (sy * std::cos(kDown) - std::sin(kDown));
        const double at_x = sx * t, at_z = (-sy * std::sin(kDown) - std::cos(kDown)) * t;
        const double c = (40 - at_z) / 120, b = (at_x + 50 * (1 - c)) / 110, a = 1 - b - c;
        const double w = (a * weights[0] + b * weights[1] + c * weights[2]) / 32767.0;
        const double u = a * scene.uvs[0].x + b * scene.uvs[1].x + c * scene.uvs[2].x;
        const double shade = mapped ? (u * 4 - 0.5) * 60 / 255 : job.vertex_shade;
        const double pixel = 2.0 / kSide * t * t / kHeight;  // on the ground, of 110
        ASSERT_NEAR(p.x, 1 - w * shade, 0.006 * pixel / 110 * 3 + 1e-4) << x << ' ' << y << ' ' << mapped;
        ++compared;
      }
    EXPECT_GT(compared, 3000);
  }
}

TEST(RasterShading, MasksOfTexturesAndOfVertices) {
  const std::vector<std::byte> map = columnsBlock(204, 51, {0, 0, 0, 0});
  const std::vector<std::byte> half = {std::byte{0}, std::byte{0}, std::byte{0}, std::byte{102}};
  Scene scene = mappedSquare(1.0f, 32767);
  scene.set.shading = {TextureFormat::kBc4, 4, 4, 1, 1, map};
  scene.set.masks = {TextureFormat::kRgba8, 1, 1, 1, 1, half};
  scene.layer.mask_slice = 3;
  EXPECT_NEAR(redAt(scene, 20, 20), 1.0f - 0.4f * 0.8f, 1e-4f);
  const std::vector<uint8_t> by_vertex(4, 51);
  scene.set.masks = {};
  scene.layer.mask = by_vertex;
  EXPECT_NEAR(redAt(scene, 20, 20), 1.0f - 0.2f * 0.8f, 1e-4f);
}

TEST(RasterShading, PartsWithoutMapsDarkenByVertex) {
  Scene scene = mappedSquare(1.0f, 16384);
  scene.part.texture_set = kAbsent;
  EXPECT_NEAR(redAt(scene, 20, 20), 1.0f - 0.5f * 0.55f, 1e-4f);
  Scene stretched = mappedSquare(1.0f, -16384);
  stretched.part.texture_set = kAbsent;
  EXPECT_EQ(redAt(stretched, 20, 20), 1.0f);
}

TEST(RasterShading, TheModelsOwnMapColoursTheLightAndNotTheGloss) {
  // Four columns of texels: sRGB red, red, blue, blue; then the same with opacity.
  const uint64_t block = 0xf800u | uint64_t{0x001f} << 16 | uint64_t{0x50505050} << 32;
  for (const bool with_opacity : {false, true}) {
    std::vector<std::byte> map(with_opacity ? 16 : 8, std::byte{0});
    std::memcpy(map.data() + map.size() - 8, &block, 8);
    BaseMaps maps = {{with_opacity ? TextureFormat::kBc3 : TextureFormat::kBc1, 4, 4, 1, 1, map},
                     {1, 0, 0, 1, 0, 0},
                     0.0f,
                     {},
                     {},
                     {},
                     {}};
    Scene scene = mappedSquare(1.0f, 0);
    const std::vector<Float3> gloss(4, {0.125f, 0.125f, 0.125f});
    const auto colorAt = [&](uint32_t x) {
      RasterJob job = scene.job(64, 64, 1);
      scene.asset.base_maps = {&maps, 1};
      scene.part.base_maps = 0;
      job.gloss = gloss;
      usePixels(job);
      scene.run(job);
      return scene.picture[30 * 64 + x];
    };
    const auto expectColor = [&](uint32_t x, Float3 expected) {
      const Float4 found = colorAt(x);
      EXPECT_NEAR(found.x, expected.x + 0.125f, 1e-4f) << x;
      EXPECT_NEAR(found.y, expected.y + 0.125f, 1e-4f) << x;
      EXPECT_NEAR(found.z, expected.z + 0.125f, 1e-4f) << x;
    };
    expectColor(15, {1, 0, 0});  // of the vertices' (1, 0.5, 0.25)
    expectColor(47, {0, 0, 0.25f});
    expectColor(31, {0.53125f, 0, 0.25f * 0.46875f});  // filtered as light
    maps.color_uv[4] = 0.5f;
    expectColor(15, {0, 0, 0.25f});
    maps.color_uv[4] = 0.0f;
    maps.color_uv[0] = 0.0f;  // a quarter turn: v runs along the columns
    maps.color_uv[2] = 1.0f;
    expectColor(47, {0.59375f, 0, 0.25f * 0.40625f});
  }
}

// A sheet whose map has nothing in its right half before one that has no map.
TEST(RasterShading, NothingIsThereWhereTheMapIsSeenThrough) {
  std::vector<std::byte> map = columnsBlock(255, 0, {0, 0, 1, 1});  // opacity 1, 1, 0, 0
  map.resize(16, std::byte{0xff});
  BaseMaps maps = {
      {TextureFormat::kBc3, 4, 4, 1, 1, map}, {1, 0, 0, 1, 0, 0}, 0.5f, {}, {1, 0, 0, 1, 0, 0}, {}, {}};
  Scene scene = mappedSquare(1.0f, 0);
  for (int i = 0; i < 4; ++i) {
    const Float3 p = scene.positions[static_cast<size_t>(i)];
    scene.positions.push_back({p.x, p.y, 0.5f});
    scene.uvs.push_back(scene.uvs[static_cast<size_t>(i)]);
    scene.colors.push_back({0, 0, 1});
    scene.weights.insert(scene.weights.end(), {0, 0});
  }
  scene.part.base_color.w = 1.0f;
  scene.part.base_maps = 0;
  scene.part.texture_set = kAbsent;
  const auto draw = [&](bool behind, bool behind_first, uint32_t samples) {
    const uint32_t front[] = {0, 2, 1, 1, 2, 3}, back[] = {4, 6, 5, 5, 6, 7};
    scene.indices.clear();
    if (behind && behind_first) scene.indices.assign(back, back + 6);
    scene.indices.insert(scene.indices.end(), front, front + 6);
    if (behind && !behind_first) scene.indices.insert(scene.indices.end(), back, back + 6);
    RasterJob job = scene.job(64, 64, samples);
    Part parts[2] = {scene.part, scene.part};
    parts[0].triangle_end = 2;
    parts[1].triangle_end = behind ? 4 : 2;
    parts[behind && behind_first ? 0 : 1].base_maps = kAbsent;
    if (!behind) parts[1].base_maps = 0;
    scene.asset.parts = parts;
    scene.asset.base_maps = {&maps, 1};
    usePixels(job);
    scene.run(job);
  };
  const auto at = [&](uint32_t x) { return scene.picture[30 * 64 + x]; };
  for (uint32_t samples : {1u, 4u}) {
    draw(false, false, samples);
    for (uint32_t x = 0; x < 64; ++x) {
      // The border of texel 0 repeats the last one: half way between, at 0 and at 31.5, half is left.
      const bool there = x < 32;
      EXPECT_EQ(at(x).w, there ? 1.0f : 0.0f) << x;
      EXPECT_EQ(scene.depth[30 * 64 + x], there ? 0.0f : 1.0f) << x;
    }
    for (bool behind_first : {false, true}) {
      draw(true, behind_first, samples);
      for (uint32_t x = 0; x < 64; ++x) EXPECT_EQ(at(x).x, x < 32 ? 1.0f : 0.0f) << x;
      EXPECT_EQ(scene.depth[30 * 64 + 40], 0.5f);
    }
  }
  scene.part.base_color.w = 0.4f;  // times the map's
  draw(false, false, 4);
  EXPECT_EQ(at(10).w, 0.0f);
  maps.opaque_from = 0.0f;  // no holes
  draw(false, false, 4);
  EXPECT_EQ(at(50).w, 0.5f);
  maps.opaque_from = 0.3f;
  draw(false, false, 4);
  EXPECT_EQ(at(10).w, 0.5f);
  EXPECT_EQ(at(50).w, 0.0f);
  maps.color.format = TextureFormat::kBc1;  // has no opacity
  maps.color.data = std::span(map).first(8);
  draw(false, false, 4);
  EXPECT_EQ(at(50).w, 0.5f);
}

TEST(RasterShading, SmallMapsAreReadFromSmallLevels) {
  // Level 0 is 1 everywhere, level 1 is 0.4, level 2 is 0: at 16 texels a side over 16 pixels level 0 is
  // seen, at two texels a pixel level 1, and in between a mean of both.
  std::vector<std::byte> map;
  for (const auto& [value, blocks] : {std::pair{255, 16}, {102, 4}, {0, 1}})
    for (int i = 0; i < blocks; ++i)
      for (std::byte b : columnsBlock(static_cast<uint8_t>(value), 0, {0, 0, 0, 0})) map.push_back(b);
  const auto seen = [&](float repeats) {
    Scene scene = mappedSquare(repeats, 32767);
    scene.set.shading = {TextureFormat::kBc4, 16, 16, 1, 3, map};
    return 1.0f - redAt(scene, 33, 21);
  };
  EXPECT_NEAR(seen(1.0f), 1.0f, 1e-4f);
  EXPECT_NEAR(seen(4.0f), 1.0f, 1e-4f);
  EXPECT_NEAR(seen(8.0f), 0.4f, 1e-4f);
  EXPECT_NEAR(seen(4.0f * std::sqrt(2.0f)), 0.7f, 1e-4f);
  EXPECT_NEAR(seen(16.0f), 0.0f, 1e-4f);
  EXPECT_NEAR(seen(100.0f), 0.0f, 1e-4f);
}

// A square of every opacity: its share of the samples, or the pixel as a whole where there is one.
TEST(RasterShading, APartsOpacityIsItsShareOfThePixel) {
  for (const auto& [opacity, of_four, of_one] : {std::array{0.0f, 0.0f, 0.0f},
                                                 {0.1f, 0.0f, 0.0f},
                                                 {0.2f, 0.25f, 0.0f},
                                                 {0.45f, 0.5f, 0.0f},
                                                 {0.6f, 0.5f, 1.0f},
                                                 {0.8f, 0.75f, 1.0f},
                                                 {1.0f, 1.0f, 1.0f},
                                                 {2.0f, 1.0f, 1.0f},
                                                 {NAN, 0.0f, 0.0f}}) {
    Scene scene = mappedSquare(1.0f, 0);
    scene.part.base_color.w = opacity;
    for (const uint32_t samples : {1u, 4u}) {
      RasterJob job = scene.job(64, 64, samples);
      usePixels(job);
      scene.run(job);
      EXPECT_NEAR(scene.picture[64 * 32 + 32].w, samples == 1 ? of_one : of_four, 1e-6f) << opacity;
    }
  }
}

TEST(RasterShading, DecodesBlocksAsTheFormatSays) {
  std::mt19937 random(11);
  std::vector<std::byte> map(8 * 6);  // 12 x 8 texels
  for (std::byte& b : map) b = static_cast<std::byte>(random() % 256);
  const Texture texture = {TextureFormat::kBc4, 12, 8, 1, 1, map};
  SliceSampler sampler;
  sampler.select(texture, {Wrap::kRepeat, Wrap::kRepeat});
  const float still[2] = {};
  for (uint32_t y = 0; y < 8; ++y)
    for (uint32_t x = 0; x < 12; ++x) {
      const float uv[2] = {(static_cast<float>(x) + 0.5f) / 12.0f, (static_cast<float>(y) + 0.5f) / 8.0f};
      const std::byte* block = &map[8 * (y / 4 * 3 + x / 4)];
      EXPECT_NEAR(sampler.at(0, 0, uv, still, still), pipeline::bc4Texel(block, x % 4, y % 4), 1e-5f);
    }
}

TEST(Raster, RefusesWhatDoesNotFit) {
  Scene scene;
  scene.add({0, 0, 0}, {8, 0, 0}, {0, 8, 0});
  const auto refused = [&](const char* part, const auto& change) {
    RasterJob job = scene.job(64, 64, 4);
    usePixels(job);
    change(job);
    const Status status = job.validate();
    EXPECT_FALSE(status.ok());
    EXPECT_THAT(status.message, testing::HasSubstr(part));
  };
  refused("asset", [](RasterJob& job) { job.asset = nullptr; });
  refused("pixels", [](RasterJob& job) { job.width = 0; });
  refused("pixels", [](RasterJob& job) { job.height = kMaxRasterSide + 1; });
  refused("samples", [](RasterJob& job) { job.samples = 2; });
  refused("positions", [](RasterJob& job) { job.positions = job.positions.first(2); });
  refused("vertices", [](RasterJob& job) { job.vertices = job.vertices.first(2); });
  refused("colors", [](RasterJob& job) { job.colors = {}; });
  refused("colors", [](RasterJob& job) { job.back_colors = job.colors.first(1); });
  refused("bins", [](RasterJob& job) { job.bins = job.bins.first(7); });
  refused("picture", [](RasterJob& job) { job.picture = job.picture.first(64); });
  refused("depth", [](RasterJob& job) { job.depth = job.depth.first(64); });
  refused("vertex_shade", [](RasterJob& job) { job.vertex_shade = NAN; });
  refused("view_projection", [](RasterJob& job) { job.view_projection[5] = INFINITY; });
}

}  // namespace
}  // namespace furrow::tests
