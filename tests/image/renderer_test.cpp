// Pictures of a ball by hand. They are kept under the build folder's pictures/ for the eye; the tests look at
// what must hold in them.

#include "editor/preview/renderer.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <string>

#include "tests/image/ball_asset.h"
#include "tests/image/gl_fixture.h"

namespace furrow::tests {
namespace {

using gl::Tier;
using pipeline::ByteImage;
using pipeline::Image;
using preview::RenderOptions;
using preview::Shading;
using preview::View;

constexpr uint32_t kSize = 192;

struct Pose {
  float down = 0.0f;   // of the upper half
  float pinch = 0.0f;  // morph
};

RenderOptions optionsFor(View view, Shading shading = Shading::kInterpolated, float yaw = 0.0f) {
  RenderOptions options;
  options.width = options.height = kSize;
  options.tier = Tier::kCpu;
  options.view = view;
  options.shading = shading;
  options.camera.distance = 4.6f;
  options.camera.yaw = yaw;
  return options;
}

class RendererTest : public GlTest {
 protected:
  Image render(preview::Renderer& renderer, const RenderOptions& options, Pose pose = {}) {
    palette_[1].m[7] = -pose.down;
    morph_[0] = pose.pinch;
    Image image = renderer.render(input(), options);
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    const std::filesystem::path folder(FURROW_PICTURES);
    std::filesystem::create_directories(folder);
    writeImage(folder / (std::string(info->name()) + "_" + std::to_string(pictures_++) + ".png"), image);
    return image;
  }

  FrameInput input() {
    FrameInput frame;
    frame.palette = palette_;
    frame.morph_weights = morph_;
    return frame;
  }

  std::vector<Affine> palette_{2};
  std::vector<float> morph_{0.0f};

 private:
  int pictures_ = 0;
};

float largestDifference(const Image& a, const Image& b) {
  EXPECT_EQ(a.pixels.size(), b.pixels.size());
  float largest = 0.0f;
  for (size_t i = 0; i < a.pixels.size(); ++i)
    largest = std::max(largest, std::abs(a.pixels[i] - b.pixels[i]));
  return largest;
}

// How rough the picture is along one axis in a window given in parts of its size: the mean step between
// neighbours.
float roughness(const Image& image, float x0, float y0, float x1, float y1, bool vertical) {
  double sum = 0.0;
  int count = 0;
  const auto at = [&](float part) { return static_cast<uint32_t>(part * static_cast<float>(kSize)); };
  for (uint32_t y = at(y0); y < at(y1); ++y)
    for (uint32_t x = at(x0); x < at(x1); ++x) {
      sum += std::abs(image.at(x, y)[1] - (vertical ? image.at(x, y + 1) : image.at(x + 1, y))[1]);
      ++count;
    }
  return static_cast<float>(sum / count);
}

glm::vec3 pixel(const Image& image, float x, float y) {
  const float* p = image.at(static_cast<uint32_t>(x * kSize), static_cast<uint32_t>(y * kSize));
  return {p[0], p[1], p[2]};
}

TEST_F(RendererTest, TiersDrawTheSamePicture) {
  const BallAsset ball;
  preview::Renderer renderer(ball.view());
  for (Pose pose : {Pose{}, Pose{0.25f, 0.5f}, Pose{-0.3f, 0.0f}}) {
    RenderOptions options = optionsFor(View::kBeauty);
    const Image cpu = render(renderer, options, pose);
    for (Tier tier : {Tier::kGpuRaster, Tier::kGpu}) {
      if (tier == Tier::kGpu && !support_.gpu) continue;
      options.tier = tier;
      EXPECT_LE(largestDifference(render(renderer, options, pose), cpu), 2.5f / 255.0f);
    }
  }
}

int resets_to_report = 0;
uint32_t reportedReset() {
  constexpr uint32_t kInnocentContextReset = 0x8254;
  return resets_to_report > 0 ? (--resets_to_report, kInnocentContextReset) : 0u;
}

TEST_F(RendererTest, EveryLossOfTheContextCostsAPictureAndATier) {
  if (!support_.gpu) GTEST_SKIP() << support_.reason;
  const BallAsset ball;
  preview::Renderer renderer(ball.view(), reportedReset);
  RenderOptions options = optionsFor(View::kBeauty);
  const Pose pose{0.25f, 0.5f};
  const Image cpu = render(renderer, options, pose);
  options.tier = Tier::kGpu;
  for (int loss = 0; loss < 3; ++loss) {
    const auto before = static_cast<Tier>(loss), after = static_cast<Tier>(std::min(loss + 1, 2));
    render(renderer, options, pose);
    EXPECT_EQ(renderer.tier(), before);
    resets_to_report = 1;
    try {
      render(renderer, options, pose);
      ADD_FAILURE() << "no loss was reported";
    } catch (const preview::ContextLost& lost) {
      EXPECT_EQ(lost.tier(), before);
      EXPECT_EQ(lost.how(), "the OpenGL context was lost (reset, through no fault of its own)");
      EXPECT_EQ(lost.exit(), pipeline::Exit::kEnvironment);
    }
    EXPECT_LE(largestDifference(render(renderer, options, pose), cpu), 2.5f / 255.0f);
    EXPECT_EQ(renderer.tier(), after);
  }
}

// Its names are another context's by then, and neither deleted nor drawn with.
TEST_F(RendererTest, AnotherContextTakesThePlaceOfALostOne) {
  if (!support_.gpu) GTEST_SKIP() << support_.reason;
  const BallAsset ball;
  auto left = std::make_unique<preview::Renderer>(ball.view()),
       right = std::make_unique<preview::Renderer>(ball.view());
  RenderOptions options = optionsFor(View::kBeauty);
  options.tier = Tier::kGpu;
  const Image expected = render(*left, options);
  render(*right, options);
  closeContext();
  const preview::HeadlessContext another;
  EXPECT_THROW(render(*left, options), preview::ContextLost);
  EXPECT_LE(largestDifference(render(*left, options), expected), 2.5f / 255.0f);
  EXPECT_EQ(left->tier(), Tier::kGpuRaster);
  EXPECT_THROW(render(*right, options), preview::ContextLost);
  EXPECT_LE(largestDifference(render(*right, options), expected), 2.5f / 255.0f);
  EXPECT_LE(largestDifference(render(*left, options), expected), 2.5f / 255.0f);
  right.reset();
  EXPECT_LE(largestDifference(render(*left, options), expected), 2.5f / 255.0f);
  left.reset();  // while its context is current
}

TEST_F(RendererTest, SamePictureEveryTime) {
  const BallAsset ball;
  preview::Renderer first(ball.view()), second(ball.view());
  const Image a = render(first, optionsFor(View::kBeauty), {0.2f, 0.4f});
  render(first, optionsFor(View::kDirection), {0.0f, 1.0f});
  EXPECT_EQ(render(first, optionsFor(View::kBeauty), {0.2f, 0.4f}).pixels, a.pixels);
  EXPECT_EQ(render(second, optionsFor(View::kBeauty), {0.2f, 0.4f}).pixels, a.pixels);
}

TEST_F(RendererTest, AnotherAssetIsShownAsIfItWereTheFirst) {
  const BallAsset ball, same, plain({.maps = false}), by_vertex({.masks = false});
  preview::Renderer renderer(ball.view());
  const Pose pose{0.2f, 0.4f};
  const auto painted = std::make_shared<const ByteImage>(ByteImage{1, 1, 1, {128}});
  const std::vector<uint32_t> parts = {0};
  for (const BallAsset* next : {&same, &plain, &ball, &by_vertex, &same}) {
    RenderOptions options = optionsFor(View::kBeauty);
    options.mask = painted;
    options.mask_parts = parts;
    render(renderer, options, pose);  // leaves as much behind as a picture can
    render(renderer, optionsFor(View::kDirection), pose);
    renderer.show(next->view());
    preview::Renderer fresh(next->view());
    for (Tier tier : {Tier::kCpu, Tier::kGpuRaster})
      for (View view : {View::kBeauty, View::kDirection, View::kMask}) {
        options = optionsFor(view);
        options.tier = tier;
        const Image expected = render(fresh, options, pose);
        EXPECT_EQ(render(renderer, options, pose).pixels, expected.pixels);
      }
  }
}

TEST_F(RendererTest, AnotherAssetAfterALossIsDrawnInTheContextThatIsThere) {
  const BallAsset ball, other({.maps = false});
  preview::Renderer renderer(ball.view(), reportedReset);
  render(renderer, optionsFor(View::kBeauty));
  resets_to_report = 1;
  EXPECT_THROW(renderer.show(other.view()), preview::ContextLost);
  preview::Renderer fresh(other.view());
  const Image expected = render(fresh, optionsFor(View::kBeauty));
  EXPECT_EQ(render(renderer, optionsFor(View::kBeauty)).pixels, expected.pixels);
}

TEST_F(RendererTest, SqueezeRaisesLinesAcrossItAndRestDoesNot) {
  const BallAsset ball;
  preview::Renderer renderer(ball.view());
  const auto front = [](const Image& image, bool vertical) {
    return roughness(image, 0.45f, 0.45f, 0.55f, 0.6f, vertical);
  };
  const float smooth = front(render(renderer, optionsFor(View::kBeauty, Shading::kNone), {0.25f, 0}), true);
  const Image wrinkled = render(renderer, optionsFor(View::kBeauty), {0.25f, 0});
  EXPECT_GT(front(wrinkled, true), 4.0f * smooth);  // horizontal lines, one below the other
  EXPECT_GT(front(wrinkled, true), 3.0f * front(wrinkled, false));
  // Every method shows them.
  for (Shading shading : {Shading::kBlend, Shading::kAlpha})
    EXPECT_GT(front(render(renderer, optionsFor(View::kBeauty, shading), {0.25f, 0}), true), 3.0f * smooth);
  // At rest only the bias of "frown" on the left shows.
  const Image rest = render(renderer, optionsFor(View::kBeauty)),
              plain = render(renderer, optionsFor(View::kBeauty, Shading::kNone));
  EXPECT_EQ(pixel(rest, 0.6f, 0.5f), pixel(plain, 0.6f, 0.5f));
  EXPECT_LT(roughness(rest, 0.5f, 0.4f, 0.65f, 0.6f, true),
            1.2f * roughness(plain, 0.5f, 0.4f, 0.65f, 0.6f, true));
  // The other layer's lines run the other way.
  const Image pinched = render(renderer, optionsFor(View::kBeauty), {0, 1.0f});
  EXPECT_GT(roughness(pinched, 0.45f, 0.4f, 0.55f, 0.55f, false),
            3.0f * roughness(pinched, 0.45f, 0.4f, 0.55f, 0.55f, true));
}

TEST_F(RendererTest, BlinnShowsThemToo) {
  const BallAsset ball;
  preview::Renderer renderer(ball.view());
  RenderOptions options = optionsFor(View::kBeauty);
  const Image ggx = render(renderer, options, {0.25f, 0});
  options.lighting = preview::Lighting::kBlinn;
  const Image blinn = render(renderer, options, {0.25f, 0});
  options.shading = Shading::kNone;
  const float smooth = roughness(render(renderer, options, {0.25f, 0}), 0.45f, 0.45f, 0.55f, 0.6f, true);
  EXPECT_GT(roughness(blinn, 0.45f, 0.45f, 0.55f, 0.6f, true), 4.0f * smooth);
  EXPECT_GT(largestDifference(ggx, blinn), 0.03f);
}

TEST_F(RendererTest, NothingWrinklesOutsideTheMask) {
  const BallAsset ball;
  preview::Renderer renderer(ball.view());
  const Image wrinkled =
      render(renderer, optionsFor(View::kBeauty, Shading::kInterpolated, 180.0f), {0.25f, 0});
  const Image plain = render(renderer, optionsFor(View::kBeauty, Shading::kNone, 180.0f), {0.25f, 0});
  EXPECT_LE(largestDifference(wrinkled, plain), 1.5f / 255.0f);
}

TEST_F(RendererTest, WeightViewIsBlueWhereStretchedAndRedWhereSqueezed) {
  const BallAsset ball;
  preview::Renderer renderer(ball.view());
  const glm::vec3 squeezed = pixel(render(renderer, optionsFor(View::kWeight), {0.25f, 0}), 0.5f, 0.53f);
  const glm::vec3 stretched = pixel(render(renderer, optionsFor(View::kWeight), {-0.25f, 0}), 0.5f, 0.47f);
  const glm::vec3 rest = pixel(render(renderer, optionsFor(View::kWeight)), 0.5f, 0.5f);
  EXPECT_GT(squeezed.r, squeezed.b + 0.3f);
  EXPECT_GT(stretched.b, stretched.r + 0.3f);
  EXPECT_NEAR(rest.r, rest.b, 0.01f);
  EXPECT_NEAR(rest.r, rest.g, 0.01f);
}

TEST_F(RendererTest, ViewsShowMaskBiasAndConfidence) {
  const BallAsset ball;
  preview::Renderer renderer(ball.view());
  const Image mask = render(renderer, optionsFor(View::kMask));
  EXPECT_GT(pixel(mask, 0.5f, 0.5f).r, pixel(mask, 0.5f, 0.12f).r + 0.4f);
  RenderOptions options = optionsFor(View::kBias);
  options.layer = 1;
  const Image bias = render(renderer, options);
  EXPECT_GT(pixel(bias, 0.25f, 0.5f).r, pixel(bias, 0.25f, 0.5f).b + 0.3f);
  EXPECT_NEAR(pixel(bias, 0.7f, 0.5f).r, pixel(bias, 0.7f, 0.5f).b, 0.01f);
  const Image confidence = render(renderer, optionsFor(View::kConfidence));
  EXPECT_GT(pixel(confidence, 0.5f, 0.5f).g, pixel(confidence, 0.5f, 0.12f).g + 0.3f);
}

TEST_F(RendererTest, ValuesThatArePaintedShowInPlaceOfTheAssets) {
  const BallAsset ball;
  preview::Renderer renderer(ball.view());
  RenderOptions options = optionsFor(View::kBias);
  options.layer = 1;
  std::vector<float> values(ball.view().vertexCount());
  for (size_t v = 0; v < values.size(); ++v) values[v] = ball.view().positions[v].y > 0.0f ? 1.0f : 0.0f;
  const Image stored = render(renderer, options);
  options.bias = values;
  const Image painted = render(renderer, options);
  EXPECT_GT(largestDifference(stored, painted), 0.2f);
  const auto red = [&](float y) { return painted.at(kSize / 2, static_cast<uint32_t>(y * kSize))[0]; };
  EXPECT_GT(red(0.3f), red(0.7f) + 0.1f);
}

// Finer than the vertices are apart.
TEST_F(RendererTest, AMaskShowsEveryTexelOfItWhileItIsPainted) {
  constexpr uint32_t kTexels = 256;
  auto stripes = std::make_shared<ByteImage>(ByteImage{kTexels, 4, 1, {}});
  for (uint32_t i = 0; i < 4 * kTexels; ++i) stripes->pixels.push_back(i % 4 < 2 ? 255 : 0);
  const std::vector<uint32_t> parts = {0};
  for (const bool maps : {true, false}) {
    const BallAsset ball({.maps = maps});
    preview::Renderer renderer(ball.view());
    for (const Tier tier : {Tier::kCpu, Tier::kGpuRaster}) {
      RenderOptions options = optionsFor(View::kMask);
      options.tier = tier;
      options.mask = stripes;
      options.mask_parts = parts;
      const Image shown = render(renderer, options);
      int changes = 0;
      for (uint32_t x = kSize / 4; x < kSize * 3 / 4; ++x) {
        const auto bright = [&](uint32_t at) { return shown.at(at, kSize / 2)[0] > 0.4f; };
        changes += bright(x) != bright(x + 1);
      }
      EXPECT_GT(changes, 12);
      if (maps) continue;
      options.mask_parts = {};  // nothing on other parts
      EXPECT_LT(render(renderer, options).at(kSize / 2, kSize / 2)[0], 0.3f);
    }
  }
}

TEST_F(RendererTest, PaintedMaskAndBiasReachTheLitSurface) {
  const BallAsset ball;
  preview::Renderer renderer(ball.view());
  const Layer& layer = ball.view().layers[1];
  RenderOptions options = optionsFor(View::kBeauty);
  options.tier = preview::Tier::kCpu;
  options.layer = 1;
  const Image stored = render(renderer, options);

  // What the asset has, painted, is the same picture; anything else is another one.
  std::vector<float> bias(ball.view().vertexCount(), 0.0f);
  for (size_t v = 0; v < layer.bias.size(); ++v) bias[v] = static_cast<float>(layer.bias[v]) / 32767.0f;
  const Texture& masks = ball.view().texture_sets[0].masks;
  auto mask = std::make_shared<ByteImage>(ByteImage{masks.width, masks.height, 1, {}});
  for (uint32_t y = 0; y < masks.height; ++y)
    for (uint32_t x = 0; x < masks.width; ++x)
      mask->pixels.push_back(static_cast<uint8_t>(std::lround(texelAt(masks, 0, 0, x, y).y * 255.0f)));
  const std::vector<uint32_t> parts = {0};
  options.bias = bias;
  EXPECT_LE(largestDifference(stored, render(renderer, options)), 0.005f);
  options.mask = mask;
  options.mask_parts = parts;
  EXPECT_LE(largestDifference(stored, render(renderer, options)), 0.05f);
  const std::vector<float> all(bias.size(), 1.0f);
  options.bias = all;
  const Image creased = render(renderer, options);
  EXPECT_GT(largestDifference(stored, creased), 0.1f);
  options.mask = std::make_shared<ByteImage>(ByteImage{1, 1, 1, {0}});
  EXPECT_GT(largestDifference(creased, render(renderer, options)), 0.1f);

  // And it does not stay.
  options.mask = {};
  options.bias = {};
  EXPECT_EQ(largestDifference(stored, render(renderer, options)), 0.0f);
}

TEST_F(RendererTest, EveryStageOfEveryTierIsTimed) {
  const BallAsset ball;
  preview::Renderer renderer(ball.view());
  const std::map<Tier, std::vector<std::string>> stages = {
      {Tier::kGpu, {"upload", "draw"}},
      {Tier::kGpuRaster, {"upload", "deform", "measure", "respond", "draw"}},
      {Tier::kCpu, {"deform", "compress", "smooth", "respond", "upload", "draw"}}};
  for (const auto& [tier, names] : stages) {
    RenderOptions options = optionsFor(View::kBeauty);
    options.tier = tier;
    preview::StageTimes times;
    options.times = &times;
    render(renderer, options);
    double sum = 0.0;
    std::string said;
    for (const preview::StageTime& stage : times) {
      EXPECT_GE(stage.milliseconds, 0.0) << stage.name;
      sum += stage.milliseconds;
      said += std::string(stage.name) + " " + std::to_string(stage.milliseconds) + "  ";
    }
    std::printf("%s: %s ms\n", furrow::gl::tierName(tier), said.c_str());
    EXPECT_GT(sum, 0.0);
    for (const std::string& name : names) EXPECT_NE(said.find(name + " "), std::string::npos) << said;
    EXPECT_GT(times.size(), 2u) << said;  // more than what is around them
  }
}

TEST_F(RendererTest, MorphViewLightsUpWhatTheMorphMoves) {
  const BallAsset ball;
  preview::Renderer renderer(ball.view());
  const Image still = render(renderer, optionsFor(View::kMorph));
  const Image pinched = render(renderer, optionsFor(View::kMorph), {.pinch = 1.0f});
  const Image from_behind =
      render(renderer, optionsFor(View::kMorph, Shading::kNone, 180.0f), {.pinch = 1.0f});
  const auto warmest = [](const Image& image) {
    float most = 0.0f;
    for (uint32_t x = kSize / 4; x < kSize * 3 / 4; ++x)
      most = std::max(most, image.at(x, kSize / 2)[0] - image.at(x, kSize / 2)[2]);
    return most;
  };
  EXPECT_GT(warmest(pinched), 0.5f);
  EXPECT_LT(warmest(still), 0.05f);
  EXPECT_LT(warmest(from_behind), 0.05f);
  EXPECT_GT(still.at(kSize / 2, kSize / 2)[1], 0.4f);  // what stands still can be seen
}

TEST_F(RendererTest, LightsTurn) {
  const BallAsset ball;
  preview::Renderer renderer(ball.view());
  RenderOptions options = optionsFor(View::kBeauty, Shading::kNone);
  const auto leans = [&](float yaw) {  // to the right, if positive
    options.light_yaw = yaw;
    const Image image = render(renderer, options);
    return image.at(kSize * 7 / 10, kSize / 2)[1] - image.at(kSize * 3 / 10, kSize / 2)[1];
  };
  EXPECT_LT(leans(0.0f), -0.1f);  // the key stands on the left
  EXPECT_GT(leans(110.0f), 0.1f);
}

TEST_F(RendererTest, StrokesRunAlongTheDirection) {
  const BallAsset ball;
  preview::Renderer renderer(ball.view());
  RenderOptions options = optionsFor(View::kDirection);
  const Image upright = render(renderer, options);
  options.layer = 1;
  const Image level = render(renderer, options);
  const auto steps = [](const Image& image, bool vertical) {
    return roughness(image, 0.3f, 0.3f, 0.7f, 0.7f, vertical);
  };
  EXPECT_GT(steps(upright, false), 1.5f * steps(upright, true));
  EXPECT_GT(steps(level, true), 1.5f * steps(level, false));
}

// The seam's two sides and the pole's many vertices show one colour: no step along the seam is larger than
// beside it.
TEST_F(RendererTest, PointViewShowsNoSeam) {
  const BallAsset ball;
  preview::Renderer renderer(ball.view());
  const Image image = render(renderer, optionsFor(View::kPoint, Shading::kInterpolated, 180.0f));
  float seam = 0.0f, beside = 0.0f;
  for (uint32_t y = kSize / 4; y < 3 * kSize / 4; ++y)
    for (uint32_t x = kSize / 2 - 24; x < kSize / 2 + 24; ++x) {
      const float step = std::abs(image.at(x, y)[0] - image.at(x + 1, y)[0]);
      float& largest = x >= kSize / 2 - 2 && x <= kSize / 2 + 1 ? seam : beside;
      largest = std::max(largest, step);
    }
  EXPECT_LE(seam, beside * 1.2f);
}

TEST_F(RendererTest, WithoutMapsTheVerticesDarken) {
  const BallAsset ball({.maps = false});
  preview::Renderer renderer(ball.view());
  const Image plain = render(renderer, optionsFor(View::kBeauty, Shading::kNone), {0.25f, 0});
  const Image shaded = render(renderer, optionsFor(View::kBeauty), {0.25f, 0});
  EXPECT_LT(pixel(shaded, 0.5f, 0.53f).g, pixel(plain, 0.5f, 0.53f).g - 0.1f);
  EXPECT_EQ(pixel(shaded, 0.6f, 0.2f), pixel(plain, 0.6f, 0.2f));
}

TEST_F(RendererTest, MasksOfVerticesDoWhatMaskTexturesDo) {
  const BallAsset textured, by_vertex({.masks = false});
  preview::Renderer a(textured.view()), b(by_vertex.view());
  const Image x = render(a, optionsFor(View::kBeauty), {0.2f, 0.3f}),
              y = render(b, optionsFor(View::kBeauty), {0.2f, 0.3f});
  double mean = 0.0;
  for (size_t i = 0; i < x.pixels.size(); ++i) mean += std::abs(x.pixels[i] - y.pixels[i]);
  EXPECT_LT(mean / static_cast<double>(x.pixels.size()), 0.002);
}

TEST_F(RendererTest, LongPictures) {
  const BallAsset ball;
  preview::Renderer renderer(ball.view());
  RenderOptions options = optionsFor(View::kMask);
  options.width = 4096;
  options.height = 32;
  const Image wide = render(renderer, options);
  EXPECT_EQ(wide.width, 4096u);
  EXPECT_GT(wide.at(2048, 16)[0], 0.8f);
  EXPECT_LT(wide.at(10, 16)[0], 0.3f);
  EXPECT_EQ(wide.at(10, 16)[3], 1.0f);
}

TEST_F(RendererTest, RefusesWhatDoesNotFit) {
  const BallAsset ball;
  preview::Renderer renderer(ball.view());
  const auto refuse = [&](const FrameInput& frame, const RenderOptions& options, const char* part) {
    EXPECT_THAT([&] { renderer.render(frame, options); },
                testing::ThrowsMessage<pipeline::Error>(testing::HasSubstr(part)));
  };
  RenderOptions options = optionsFor(View::kWeight);
  options.layer = 2;
  refuse(input(), options, "layer does not exist");
  options = optionsFor(View::kBeauty);
  options.width = 4097;
  refuse(input(), options, "4097x192");
  options.width = 0;
  refuse(input(), options, "0x192");
  options = optionsFor(View::kBeauty);
  options.camera.distance = 0.0f;
  refuse(input(), options, "camera");
  FrameInput frame = input();
  frame.palette = frame.palette.first(1);
  refuse(frame, optionsFor(View::kBeauty), "palette");
  frame = input();
  frame.scale = NAN;
  refuse(frame, optionsFor(View::kBeauty), "scale");
  frame = input();
  frame.morph_weights = {};
  refuse(frame, optionsFor(View::kBeauty), "morph");
}

TEST(CameraTest, FitsTightlyFromEverySide) {
  const BallAsset ball({.maps = false});
  const auto positions = ball.view().positions;
  for (float aspect : {0.5f, 1.0f, 2.4f})
    for (float yaw : {0.0f, 70.0f, -160.0f})
      for (float pitch : {-89.0f, 0.0f, 35.0f}) {
        const preview::Camera camera = preview::fitCamera(positions, aspect, yaw, pitch);
        const preview::CameraFrame frame = preview::cameraFrame(camera, aspect);
        float reach = 0.0f;
        for (const Float3& p : positions) {
          const glm::vec4 clip = frame.view_projection * glm::vec4(p.x, p.y, p.z, 1.0f);
          ASSERT_GT(clip.w, 0.0f);
          ASSERT_LE(std::abs(clip.z), clip.w);
          reach = std::max(reach, std::max(std::abs(clip.x), std::abs(clip.y)) / clip.w);
        }
        EXPECT_LT(reach, 1.0f);
        EXPECT_GT(reach, 0.9f);
      }
}

TEST(CameraTest, YawZeroSeesTheFront) {
  const preview::CameraFrame frame = preview::cameraFrame({}, 1.0f);
  EXPECT_NEAR(frame.eye.z, 1.0f, 1e-6f);
  EXPECT_NEAR(frame.right.x, 1.0f, 1e-6f);
  EXPECT_NEAR(preview::cameraFrame({.yaw = 90.0f}, 1.0f).eye.x, 1.0f, 1e-6f);
  EXPECT_NEAR(preview::cameraFrame({.pitch = 90.0f}, 1.0f).eye.y, 1.0f, 1e-6f);
}

TEST(CameraTest, ASheetIsNotSeenEdgeOn) {
  const std::vector<uint32_t> indices = {0, 1, 2, 0, 2, 3}, back = {0, 2, 1, 0, 3, 2};
  const std::vector<Float3> floor = {{0, 5, 0}, {0, 5, 1}, {1, 5, 1}, {1, 5, 0}};
  const std::vector<Float3> side = {{5, 0, 0}, {5, 1, 0}, {5, 1, 1}, {5, 0, 1}};
  const std::vector<Float3> front = {{0, 0, 5}, {1, 0, 5}, {1, 1, 5}, {0, 1, 5}};
  EXPECT_EQ(preview::facing(floor, indices).pitch, 89.0f);
  EXPECT_EQ(preview::facing(floor, indices).yaw, 0.0f);
  EXPECT_EQ(preview::facing(floor, back).pitch, -89.0f);
  EXPECT_NEAR(preview::facing(side, indices).yaw, 90.0f, 1e-4f);
  EXPECT_NEAR(preview::facing(side, back).yaw, -90.0f, 1e-4f);
  EXPECT_EQ(preview::facing(side, indices).pitch, 0.0f);
  for (const auto& faces : {indices, back}) {
    EXPECT_EQ(preview::facing(front, faces).yaw, 0.0f);
    EXPECT_EQ(preview::facing(front, faces).pitch, 0.0f);
  }
  // A closed plate, from above.
  std::vector<Float3> plate = floor;
  for (const Float3& p : floor) plate.push_back({p.x, p.y - 0.01f, p.z});
  EXPECT_EQ(preview::facing(plate, std::vector<uint32_t>{0, 1, 2, 0, 2, 3, 4, 6, 5, 4, 7, 6}).pitch, 89.0f);
  const BallAsset ball({.maps = false});
  EXPECT_EQ(preview::facing(ball.view().positions, ball.view().indices).yaw, 0.0f);
  EXPECT_EQ(preview::facing({}, {}).pitch, 0.0f);
}

TEST(CameraTest, LeavesOutWhatIsNotFinite) {
  const std::vector<Float3> positions = {{0, 0, 0}, {1, 1, 0}, {NAN, 0, 0}, {0, INFINITY, 0}};
  const preview::Camera camera = preview::fitCamera(positions, 1.0f, 0.0f, 0.0f);
  EXPECT_NEAR(camera.target.x, 0.5f, 1e-5f);
  EXPECT_NEAR(camera.target.y, 0.5f, 1e-5f);
  EXPECT_TRUE(std::isfinite(camera.distance));
  EXPECT_GT(preview::fitCamera({}, 1.0f, 0.0f, 0.0f).distance, 0.0f);
}

}  // namespace
}  // namespace furrow::tests
