// Pictures without OpenGL, and beside those that OpenGL draws.

#include "editor/preview/software_picture.h"

#include <gmock/gmock.h>

#include <cmath>

#include "pipeline/error.h"
#include "tests/image/ball_asset.h"
#include "tests/image/gl_fixture.h"

namespace furrow::tests {
namespace {

using pipeline::Image;
using preview::RenderOptions;
using preview::Shading;
using preview::View;

constexpr uint32_t kSize = 160;

RenderOptions optionsFor(View view, Shading shading = Shading::kAlpha, float yaw = 0.0f) {
  RenderOptions options;
  options.width = options.height = kSize;
  options.tier = preview::Tier::kCpu;
  options.view = view;
  options.shading = shading;
  options.camera.distance = 4.6f;
  options.camera.yaw = yaw;
  return options;
}

// The ball with its upper half `down`.
struct Posed {
  explicit Posed(float down = 0.25f) {
    palette[1].m[7] = -down;
    input.palette = palette;
    input.morph_weights = morphs;
  }
  Affine palette[2];
  float morphs[1] = {0.3f};
  FrameInput input;
};

float green(const Image& image, float x, float y) {
  return image.at(static_cast<uint32_t>(x * kSize), static_cast<uint32_t>(y * kSize))[1];
}

// Mean over the colours, and the share of pixels that differ by more than 8 of 255 steps in one.
struct Difference {
  double mean = 0.0, apart = 0.0;
};
Difference difference(const Image& a, const Image& b) {
  Difference d;
  for (size_t i = 0; i < a.pixels.size(); i += 4) {
    double largest = 0.0;
    for (size_t c = 0; c < 3; ++c) {
      const double step = 255.0 * std::abs(a.pixels[i + c] - b.pixels[i + c]);
      d.mean += step / 3.0;
      largest = std::max(largest, step);
    }
    d.apart += largest > 8.0;
  }
  d.mean /= static_cast<double>(a.pixels.size() / 4);
  d.apart /= static_cast<double>(a.pixels.size() / 4);
  return d;
}

TEST(SoftwarePicture, TheSameBytesForAnyNumberOfThreads) {
  const BallAsset ball;
  const Posed posed;
  const Image one = softwarePicture(ball.view(), posed.input, optionsFor(View::kBeauty), 1);
  EXPECT_EQ(softwarePicture(ball.view(), posed.input, optionsFor(View::kBeauty), 3).pixels, one.pixels);
  EXPECT_EQ(one.width, kSize);
  EXPECT_EQ(one.pixels[3], 1.0f);
}

TEST(SoftwarePicture, CreasesDarkenWhereTheSurfaceIsSqueezed) {
  for (const bool maps : {true, false}) {
    const BallAsset ball({.maps = maps});
    const Posed squeezed, rest(0.0f);
    const Image creased = softwarePicture(ball.view(), squeezed.input, optionsFor(View::kBeauty), 1);
    const Image plain =
        softwarePicture(ball.view(), squeezed.input, optionsFor(View::kBeauty, Shading::kNone), 1);
    EXPECT_GT(difference(creased, plain).apart, 0.02);
    EXPECT_EQ(green(creased, 0.55f, 0.15f), green(plain, 0.55f, 0.15f));  // outside the mask
    for (size_t i = 0; i < plain.pixels.size(); ++i) ASSERT_LE(creased.pixels[i], plain.pixels[i] + 0.001f);
    EXPECT_NE(softwarePicture(ball.view(), rest.input, optionsFor(View::kBeauty, Shading::kNone), 1).pixels,
              plain.pixels);
  }
}

// A subject twice as bright as what is exposed as it is gets half the light; a dark one stays dark.
TEST(SoftwarePicture, BrightSubjectsAreNotBurntOut) {
  const BallAsset ball;
  const Posed posed;
  const auto grey = [&](float albedo) {
    AssetView view = ball.view();
    Part part = view.parts[0];
    part.base_color = {albedo, albedo, albedo, 1.0f};
    view.parts = {&part, 1};
    const Image image = softwarePicture(view, posed.input, optionsFor(View::kBeauty, Shading::kNone), 1);
    return green(image, 0.4f, 0.35f);
  };
  EXPECT_NEAR(grey(0.9f), grey(0.45f), 0.02f);
  EXPECT_LT(grey(0.9f), 0.93f);
  EXPECT_LT(grey(0.225f), grey(0.45f) - 0.1f);
}

TEST(SoftwarePicture, RefusesWhatItCannotDraw) {
  const BallAsset ball;
  const Posed posed;
  const auto refuse = [&](const RenderOptions& options, const char* part) {
    EXPECT_THAT([&] { softwarePicture(ball.view(), posed.input, options, 1); },
                testing::ThrowsMessage<pipeline::Error>(testing::HasSubstr(part)));
  };
  refuse(optionsFor(View::kBeauty, Shading::kInterpolated), "OpenGL");
  refuse(optionsFor(View::kBeauty, Shading::kBlend), "OpenGL");
  refuse(optionsFor(View::kDirection), "OpenGL");
  RenderOptions options = optionsFor(View::kBeauty);
  options.width = 4097;
  refuse(options, "4096");
  options = optionsFor(View::kWeight);
  options.layer = 2;
  refuse(options, "layer");
}

class SoftwareBesideOpenGl : public GlTest {};

// Light by vertex instead of by pixel, and the driver's own filters: nearly the same.
TEST_F(SoftwareBesideOpenGl, PicturesAreNearlyTheSame) {
  const Posed posed;
  for (const BallOptions& kind : {BallOptions{}, BallOptions{.masks = false}, BallOptions{.maps = false}}) {
    const BallAsset ball(kind);
    preview::Renderer renderer(ball.view());
    const RenderOptions options = optionsFor(View::kBeauty, Shading::kAlpha, 25.0f);
    const Image software = softwarePicture(ball.view(), posed.input, options, 1);
    const Difference d = difference(renderer.render(posed.input, options), software);
    EXPECT_LT(d.mean, 0.4);
    EXPECT_LT(d.apart, 0.01);
    const Image plain =
        softwarePicture(ball.view(), posed.input, optionsFor(View::kBeauty, Shading::kNone, 25.0f), 1);
    EXPECT_GT(difference(plain, software).mean, 2.0 * d.mean);  // creases weigh more
  }
}

// Values turn into colours at the vertices and not at the pixels.
TEST_F(SoftwareBesideOpenGl, ViewsAreMuchTheSame) {
  const Posed posed;
  const BallAsset ball;
  preview::Renderer renderer(ball.view());
  for (const View view :
       {View::kWeight, View::kMask, View::kBias, View::kConfidence, View::kPoint, View::kMorph}) {
    const RenderOptions options = optionsFor(view, Shading::kAlpha, 25.0f);
    const Difference d = difference(renderer.render(posed.input, options),
                                    softwarePicture(ball.view(), posed.input, options, 1));
    EXPECT_LT(d.mean, 1.5) << static_cast<int>(view);
    EXPECT_LT(d.apart, 0.1) << static_cast<int>(view);
  }
}

}  // namespace
}  // namespace furrow::tests
