// The demo characters on every tier: all layers of all vertices agree with the clustered frame of the cpu
// tier, from the same pose.

#include <cstring>
#include <fstream>
#include <iterator>
#include <random>

#include "furrow/cluster_frame.h"
#include "furrow/drivers.h"
#include "furrow/gl/executor.h"
#include "tests/image/gl_fixture.h"

namespace furrow::tests {
namespace {

class ContentTiers : public GlTest, public testing::WithParamInterface<const char*> {};

TEST_P(ContentTiers, AgreeOnEveryWeight) {
  std::ifstream in(std::string(FURROW_ASSETS "/") + GetParam(), std::ios::binary);
  const std::vector<char> file((std::istreambuf_iterator<char>(in)), {});
  Asset asset;
  ASSERT_TRUE(asset.load(std::as_bytes(std::span(file))).ok()) << FURROW_ASSETS;
  const AssetView& view = asset.view();

  // Joints turn and move a little, every morph target takes part.
  std::mt19937 random(3);
  std::uniform_real_distribution<float> part(0.0f, 1.0f);
  std::vector<Affine> palette(view.palette.size());
  for (const Part& each : view.parts)
    for (uint32_t i = each.vertex_begin * view.influences; i < each.vertex_end * view.influences; ++i)
      palette[view.joints[i]] = each.rest;
  for (Affine& m : palette) {
    m.m[1] += 0.1f * part(random) * m.m[0];
    m.m[4] -= 0.1f * part(random) * m.m[0];
  }
  std::vector<float> morphs(view.morphs.size()), regions(view.layerCount());
  for (float& weight : morphs) weight = part(random) < 0.5f ? 0.0f : 0.6f * part(random);
  driveRegions(view, morphs, {}, regions);
  FrameInput input;
  input.palette = palette;
  input.morph_weights = morphs;
  input.region_weights = regions;

  Clusters clusters;
  ASSERT_TRUE(clusters.build(view).ok());
  std::vector<Float3> positions(view.vertexCount());
  std::vector<int16_t> expected(size_t{view.vertexCount()} * view.weightStride());
  std::vector<std::byte> scratch(clusters.scratchBytes() + 64);
  void* aligned = scratch.data();
  size_t space = scratch.size();
  std::align(64, clusters.scratchBytes(), aligned, space);
  ClusterFrameJob job;
  job.clusters = &clusters;
  job.palette = palette;
  job.morph_weights = morphs;
  job.region_weights = regions;
  job.positions = positions;
  job.weights = expected;
  ASSERT_TRUE(job.validate().ok());
  job.run(0, clusters.count(), {static_cast<std::byte*>(aligned), space});
  std::vector<int> spread(view.layerCount());
  for (size_t i = 0; i < expected.size(); ++i)
    if (const size_t l = i % view.weightStride(); l < spread.size())
      spread[l] = std::max(spread[l], std::abs(static_cast<int>(expected[i])));
  EXPECT_GT(*std::max_element(spread.begin(), spread.end()), 10000);

  for (Form form : {Form::kClustered, Form::kStaged, Form::kRaster}) {
    if (form != Form::kRaster && !support_.gpu) continue;
    const FramePlan plan(view, {.form = form, .normals = false});
    ASSERT_EQ(plan.options().form, form);
    gl::Executor executor;
    const Status status = executor.create(plan);
    ASSERT_TRUE(status.ok()) << status.message;
    ASSERT_TRUE(executor.upload(input).ok());
    ASSERT_TRUE(executor.run().ok());
    std::vector<Float3> posed(positions.size());
    executor.read(Buffer::kPositions, std::as_writable_bytes(std::span(posed)));
    EXPECT_EQ(std::memcmp(posed.data(), positions.data(), posed.size() * sizeof(Float3)), 0);
    std::vector<int16_t> weights(expected.size());
    executor.read(Buffer::kWeights, std::as_writable_bytes(std::span(weights)));
    for (size_t i = 0; i < weights.size(); ++i)
      ASSERT_NEAR(weights[i], expected[i], 3)
          << "form " << static_cast<int>(form) << ", vertex " << i / view.weightStride();
  }
}

INSTANTIATE_TEST_SUITE_P(Demo, ContentTiers, testing::Values("face.furrow", "sleeve.furrow"));

}  // namespace
}  // namespace furrow::tests
