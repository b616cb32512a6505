#include "furrow/gl/executor.h"

#include <bit>
#include <cmath>
#include <vector>

#include "furrow/jobs.h"
#include "tests/image/ball_asset.h"
#include "tests/image/gl_fixture.h"

namespace furrow::tests {
namespace {

class ExecutorTest : public GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (!IsSkipped() && !support_.gpu) GTEST_SKIP() << support_.reason;
    palette_[1].m[7] = -0.21f;
    palette_[1].m[1] = 0.1f;
    frame_.palette = palette_;
    frame_.morph_weights = morph_;
  }

  template <typename T>
  static std::vector<T> read(const gl::Executor& executor, Buffer buffer, size_t count) {
    std::vector<T> values(count);
    executor.read(buffer, std::as_writable_bytes(std::span(values)));
    return values;
  }

  void upload(gl::Executor& executor, const FramePlan& plan, const PlanOptions& options) {
    std::vector<std::byte> bytes(plan.buffer(Buffer::kFrame).bytes);
    writeFrameConstants(ball_.view(), options, frame_, bytes);
    executor.upload(Buffer::kFrame, bytes);
    if (options.posed_by_host) return;
    bytes.resize(plan.buffer(Buffer::kMorphWeights).bytes);
    writeMorphWeights(ball_.view(), frame_, bytes);
    executor.upload(Buffer::kMorphWeights, bytes);
    executor.upload(Buffer::kPalette, std::as_bytes(frame_.palette));
  }

  std::vector<Float3> posed() const {
    const AssetView& asset = ball_.view();
    std::vector<Float3> positions(asset.vertexCount());
    const DeformJob job{&asset, palette_, morph_, positions, {}, {}};
    EXPECT_TRUE(job.validate().ok());
    job.run(0, asset.vertexCount());
    return positions;
  }

  std::vector<int16_t> cpuWeights(const std::vector<Float3>& positions) const {
    const AssetView& asset = ball_.view();
    std::vector<float> triangle_q(asset.triangleCount()), point_q(asset.pointCount());
    std::vector<int16_t> weights(size_t{asset.vertexCount()} * asset.weightStride());
    for (uint32_t layer = 0; layer < asset.layerCount(); ++layer) {
      CompressJob{&asset, layer, positions, 1.0f, triangle_q}.run(0, asset.triangleCount());
      SmoothJob{&asset, triangle_q, point_q}.run(0, asset.pointCount());
      RespondJob{&asset, layer, asset.layers[layer].response, 0.0f, point_q, weights}.run(
          0, asset.vertexCount());
    }
    return weights;
  }

  static void expectSameWeights(const std::vector<int16_t>& gpu, const std::vector<int16_t>& cpu) {
    ASSERT_EQ(gpu.size(), cpu.size());
    int largest = 0, spread = 0;
    for (size_t i = 0; i < gpu.size(); ++i) {
      largest = std::max(largest, std::abs(gpu[i] - cpu[i]));
      spread = std::max(spread, std::abs(static_cast<int>(cpu[i])));
    }
    EXPECT_GT(spread, 10000);  // there was something to weigh
    EXPECT_LE(largest, 3);     // 1e-4 of 32767
  }

  const BallAsset ball_;
  std::vector<Affine> palette_{2};
  std::vector<float> morph_{0.35f};
  FrameInput frame_;
};

TEST_F(ExecutorTest, RunsTheWholeFrameAsTheJobsDo) {
  const AssetView& asset = ball_.view();
  const PlanOptions options;
  const FramePlan plan(asset, options);
  gl::Executor executor;
  const Status status = executor.create(plan);
  ASSERT_TRUE(status.ok()) << status.message;
  upload(executor, plan, options);
  executor.run();
  const auto expected = posed();
  const auto positions = read<Float3>(executor, Buffer::kPositions, asset.vertexCount());
  for (size_t v = 0; v < expected.size(); ++v) {
    EXPECT_EQ(std::bit_cast<uint32_t>(positions[v].x), std::bit_cast<uint32_t>(expected[v].x));
    EXPECT_EQ(std::bit_cast<uint32_t>(positions[v].y), std::bit_cast<uint32_t>(expected[v].y));
    EXPECT_EQ(std::bit_cast<uint32_t>(positions[v].z), std::bit_cast<uint32_t>(expected[v].z));
  }
  const size_t words = size_t{asset.vertexCount()} * asset.weightStride();
  const auto weights = read<int16_t>(executor, Buffer::kWeights, words);
  expectSameWeights(weights, cpuWeights(expected));
  executor.run();
  EXPECT_EQ(read<int16_t>(executor, Buffer::kWeights, words), weights);
}

TEST_F(ExecutorTest, TakesPosedVerticesFromTheHost) {
  const AssetView& asset = ball_.view();
  PlanOptions options;
  options.posed_by_host = true;
  const FramePlan plan(asset, options);
  gl::Executor executor;
  ASSERT_TRUE(executor.create(plan).ok());
  EXPECT_EQ(executor.handle(Buffer::kRestVertices), 0u);
  EXPECT_NE(executor.handle(Buffer::kPositions), 0u);
  const auto positions = posed();
  upload(executor, plan, options);
  executor.upload(Buffer::kPositions, std::as_bytes(std::span(positions)));
  executor.run();
  expectSameWeights(
      read<int16_t>(executor, Buffer::kWeights, size_t{asset.vertexCount()} * asset.weightStride()),
      cpuWeights(positions));
}

TEST_F(ExecutorTest, CanBeMadeAgain) {
  const PlanOptions options;
  const FramePlan plan(ball_.view(), options);
  gl::Executor executor;
  EXPECT_EQ(executor.handle(Buffer::kWeights), 0u);
  ASSERT_TRUE(executor.create(plan).ok());
  ASSERT_TRUE(executor.create(plan).ok());
  upload(executor, plan, options);
  executor.run();
  EXPECT_NE(executor.handle(Buffer::kWeights), 0u);
}

}  // namespace
}  // namespace furrow::tests
