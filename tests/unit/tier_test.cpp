// Which tier runs, and what happens when the OpenGL context under it is lost.

#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>
#include <memory>
#include <new>
#include <string>

#include "furrow/cluster_frame.h"
#include "furrow/gl/tiered_frame.h"
#include "sheets.h"
#include "tests/image/ball_asset.h"
#include "tests/image/gl_fixture.h"

namespace {

constexpr long kNever = -1;
long allocations_left = kNever;  // until they fail

}  // namespace

// gcc would see malloc() and delete together.
[[gnu::noinline]] void* operator new(size_t bytes) {
  if (allocations_left == 0) throw std::bad_alloc();
  if (allocations_left > 0) --allocations_left;
  if (void* memory = std::malloc(bytes > 0 ? bytes : 1)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, size_t) noexcept {
  std::free(memory);
}

namespace furrow::tests {
namespace {

using gl::Tier;
using testing::HasSubstr;

std::string wanted(const char* backend) {
  std::string_view tier;
  const Status status = gl::wantedTier(backend, tier);
  return status.ok() ? std::string(tier) : status.message;
}

TEST(TierChoice, TheHostThenTheEnvironmentThenTheBestThereIs) {
  unsetenv("FURROW_BACKEND");
  EXPECT_EQ(wanted("auto"), "auto");
  EXPECT_EQ(wanted(""), "auto");
  EXPECT_EQ(wanted("cpu"), "cpu");
  EXPECT_THAT(wanted("cuda"), HasSubstr("backend is \"cuda\" and not auto, gpu, gpu-raster or cpu"));
  setenv("FURROW_BACKEND", "gpu-raster", 1);
  EXPECT_EQ(wanted("auto"), "gpu-raster");
  EXPECT_EQ(wanted("gpu"), "gpu");
  setenv("FURROW_BACKEND", "GPU", 1);
  EXPECT_THAT(wanted("auto"), HasSubstr("FURROW_BACKEND is \"GPU\" and not auto, gpu"));
  setenv("FURROW_BACKEND", "", 1);
  EXPECT_EQ(wanted("auto"), "auto");
  unsetenv("FURROW_BACKEND");
}

TEST(TierChoice, WithoutAContext) {
  gl::TierChoice choice;
  ASSERT_TRUE(gl::chooseTier("auto", "no display", choice).ok());
  EXPECT_EQ(choice.tier, Tier::kCpu);
  EXPECT_THAT(choice.reason, HasSubstr("no display"));
  ASSERT_TRUE(gl::chooseTier("cpu", "", choice).ok());
  EXPECT_STREQ(choice.reason, "cpu, as asked for");
  for (const char* forced : {"gpu", "gpu-raster"}) {
    const Status status = gl::chooseTier(forced, "no display", choice);
    EXPECT_EQ(status.code, StatusCode::kUnavailable);
    EXPECT_THAT(status.message,
                HasSubstr(std::string("the ") + forced + " tier is not available: no display"));
  }
}

int resets_to_report = 0;
uint32_t reportedReset() {
  constexpr uint32_t kInnocentContextReset = 0x8254;
  return resets_to_report > 0 ? (--resets_to_report, kInnocentContextReset) : 0u;
}

class LostContext : public GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (!IsSkipped() && !support_.gpu) GTEST_SKIP() << support_.reason;
    palette_[1].m[7] = -0.21f;
    input_.palette = palette_;
    input_.morph_weights = morph_;
    resets_to_report = 0;
    gl::TieredFrame cpu;
    ASSERT_TRUE(cpu.create(ball_.view(), Tier::kCpu).ok());
    ASSERT_TRUE(cpu.run(input_).ok());
    expected_.assign(cpu.weights().begin(), cpu.weights().end());
  }

  void expectWeights(const gl::TieredFrame& frame) const {
    std::vector<int16_t> weights(frame.weights().begin(), frame.weights().end());
    if (frame.executor()) {
      weights.resize(expected_.size());
      frame.executor()->read(Buffer::kWeights, std::as_writable_bytes(std::span(weights)));
    }
    ASSERT_EQ(weights.size(), expected_.size());
    for (size_t i = 0; i < weights.size(); ++i) ASSERT_NEAR(weights[i], expected_[i], 3);
  }

  const BallAsset ball_;
  std::vector<Affine> palette_{2};
  std::vector<float> morph_{0.35f};
  FrameInput input_;
  std::vector<int16_t> expected_;
};

TEST_F(LostContext, EveryLossIsReportedAndCostsOneTier) {
  gl::TieredFrame frame;
  ASSERT_TRUE(frame.create(ball_.view(), Tier::kGpu, {}, reportedReset).ok());
  ASSERT_TRUE(frame.run(input_).ok());
  expectWeights(frame);
  EXPECT_STREQ(frame.reason(), "");
  for (const auto& [next, name] : {std::pair(Tier::kGpuRaster, "gpu-raster"), std::pair(Tier::kCpu, "cpu")}) {
    resets_to_report = 1;
    const Status status = frame.run(input_);
    EXPECT_EQ(status.code, StatusCode::kUnavailable);
    EXPECT_THAT(status.message, HasSubstr("lost (reset, through no fault of its own)"));
    EXPECT_THAT(status.message, HasSubstr(std::string("frames run on the ") + name + " tier"));
    EXPECT_STREQ(frame.reason(), status.message);
    EXPECT_EQ(frame.tier(), next);
    ASSERT_TRUE(frame.run(input_).ok());
    expectWeights(frame);
  }
  resets_to_report = 1;
  EXPECT_TRUE(frame.run(input_).ok());  // nobody asks any more
}

TEST_F(LostContext, WeightsEaseOnEveryTierAndBeginAnewOnEach) {
  gl::TieredFrame frame;
  ASSERT_TRUE(frame.create(ball_.view(), Tier::kGpu, {.ease = true}, reportedReset).ok());
  const std::vector<Ease> eases(ball_.view().layerCount(), Ease{1.0f, 1.0f});
  input_.eases = eases;
  for (Tier tier : {Tier::kGpu, Tier::kGpuRaster, Tier::kCpu}) {
    EXPECT_EQ(frame.tier(), tier);
    ASSERT_TRUE(frame.run(input_).ok());
    expectWeights(frame);  // a first frame is all the way there
    resets_to_report = 1;
    EXPECT_EQ(frame.run(input_).ok(), tier == Tier::kCpu);
  }
}

TEST_F(LostContext, EveryTierMakesLaplacianSteps) {
  gl::TieredFrame frame;
  const PlanOptions options{.laplace_steps = 3};
  ASSERT_TRUE(frame.create(ball_.view(), Tier::kCpu, options).ok());
  ASSERT_TRUE(frame.run(input_).ok());
  EXPECT_NE(std::vector(frame.weights().begin(), frame.weights().end()), expected_);
  expected_.assign(frame.weights().begin(), frame.weights().end());
  ASSERT_TRUE(frame.create(ball_.view(), Tier::kGpu, options, reportedReset).ok());
  for (Tier tier : {Tier::kGpu, Tier::kGpuRaster, Tier::kCpu}) {
    EXPECT_EQ(frame.tier(), tier);
    ASSERT_TRUE(frame.run(input_).ok());
    expectWeights(frame);
    resets_to_report = 1;
    EXPECT_EQ(frame.run(input_).ok(), tier == Tier::kCpu);
  }
}

// Without eases every weight is at its target, and a later frame begins there.
TEST_F(LostContext, FramesWithoutEasesGoAllTheWay) {
  const std::vector<Ease> eases(ball_.view().layerCount(), Ease{1e-6f, 1e-6f});
  for (Tier tier : {Tier::kGpu, Tier::kGpuRaster, Tier::kCpu}) {
    gl::TieredFrame frame;
    ASSERT_TRUE(frame.create(ball_.view(), tier, {.ease = true}).ok());
    FrameInput input = input_;
    const std::vector<Affine> rest(2);
    input.palette = rest;
    ASSERT_TRUE(frame.run(input).ok());
    ASSERT_TRUE(frame.run(input_).ok());
    input.eases = eases, input.seconds = 0.01f;
    ASSERT_TRUE(frame.run(input).ok());
    expectWeights(frame);  // hardly on the way back to rest
  }
}

// Between the last GPU tier and the cpu tier there is no memory.
TEST_F(LostContext, WithoutMemoryTheNextFrameTriesAgain) {
  int refused = 0;
  for (long left = 0; left < 400; left += 1 + left / 8) {
    gl::TieredFrame frame;
    ASSERT_TRUE(frame.create(ball_.view(), Tier::kGpuRaster, {}, reportedReset).ok());
    ASSERT_TRUE(frame.run(input_).ok());
    resets_to_report = 1;
    allocations_left = left;
    const Status lost = frame.run(input_), first = frame.run(input_);
    allocations_left = kNever;
    EXPECT_EQ(lost.code, StatusCode::kUnavailable);
    EXPECT_EQ(frame.tier(), Tier::kCpu);
    EXPECT_TRUE(first.ok() || first.code == StatusCode::kOutOfMemory) << first.message;
    refused += !first.ok();
    ASSERT_TRUE(frame.run(input_).ok());
    expectWeights(frame);
  }
  EXPECT_GT(refused, 10);
}

TEST_F(LostContext, ADestroyedContextIsALostOne) {
  gl::TieredFrame frame;
  ASSERT_TRUE(frame.create(ball_.view(), Tier::kGpu).ok());
  ASSERT_TRUE(frame.run(input_).ok());
  closeContext();
  EXPECT_EQ(frame.run(input_).code, StatusCode::kUnavailable);
  EXPECT_EQ(frame.tier(), Tier::kCpu);
  ASSERT_TRUE(frame.run(input_).ok());
  expectWeights(frame);
}

TEST_F(LostContext, AnotherContextInItsPlaceRunsTheNextTier) {
  auto frame = std::make_unique<gl::TieredFrame>();
  ASSERT_TRUE(frame->create(ball_.view(), Tier::kGpu).ok());
  closeContext();
  const preview::HeadlessContext another;
  EXPECT_THAT(frame->run(input_).message, HasSubstr("its objects are gone"));
  EXPECT_EQ(frame->tier(), Tier::kGpuRaster);
  ASSERT_TRUE(frame->run(input_).ok());
  expectWeights(*frame);
  frame.reset();  // while its context is current
}

// A fan of many turns: a point in more triangles than a cluster holds.
TEST(TieredFrame, TheCpuTierIsStagedWhereClustersCannotHoldTheAsset) {
  Primitive fan;
  constexpr uint32_t kBlades = 17000;
  fan.positions.push_back({0, 0, 0});
  for (uint32_t i = 0; i < kBlades; ++i) {
    const double angle = 0.5 * i;
    fan.positions.push_back({static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)), 0.0f});
    if (i > 0) fan.indices.insert(fan.indices.end(), {0u, i, i + 1});
  }
  const Asset asset = cookAsset(sceneOf(fan, [](glm::dvec3 p) { return glm::dvec3(0.7 * p.x, p.y, p.z); }),
                                recipeOf({axisLayer({1, 0, 0})}));
  ASSERT_EQ(Clusters().build(asset.view()).code, StatusCode::kUnavailable);
  gl::TieredFrame frame;
  const Status status = frame.create(asset.view(), Tier::kCpu);
  ASSERT_TRUE(status.ok()) << status.message;
  const std::vector<Affine> palette(asset.view().palette.size());
  const std::vector<float> morphs = {0.8f};
  FrameInput input;
  input.palette = palette;
  input.morph_weights = morphs;
  ASSERT_TRUE(frame.run(input).ok());
  const Frame expected = evaluate(asset.view(), morphs);
  EXPECT_EQ(std::vector(frame.weights().begin(), frame.weights().end()), expected.weights);
}

TEST(TieredFrame, PosesItself) {
  const BallAsset ball;
  gl::TieredFrame frame;
  const Status status = frame.create(ball.view(), Tier::kCpu, {.posed_by_host = true});
  EXPECT_EQ(status.code, StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message, HasSubstr("posed_by_host"));
}

}  // namespace
}  // namespace furrow::tests
