// Frame plans on OpenGL against the jobs. The raster form's tests run a second time where nothing newer than
// OpenGL 3.3 is to be had (tests/CMakeLists.txt).

#include "furrow/gl/executor.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "furrow/recapture.h"
#include "sheets.h"
#include "tests/image/ball_asset.h"
#include "tests/image/gl_fixture.h"

namespace furrow::tests {
namespace {

class ExecutorTest : public GlTest, public testing::WithParamInterface<Form> {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (IsSkipped()) return;
    if (std::getenv("MESA_GL_VERSION_OVERRIDE")) {
      ASSERT_EQ(epoxy_gl_version(), 33);
    }
    if (!(GetParam() == Form::kRaster ? support_.gpu_raster : support_.gpu)) GTEST_SKIP() << support_.reason;
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

  std::vector<Float3> posed() const {
    const AssetView& asset = ball_.view();
    std::vector<Float3> positions(asset.vertexCount());
    const DeformJob job{&asset, palette_, morph_, positions, {}, {}};
    EXPECT_TRUE(job.validate().ok());
    job.run(0, asset.vertexCount());
    return positions;
  }

  std::vector<int16_t> cpuWeights(const std::vector<Float3>& positions, uint32_t laplace_steps = 0) const {
    return cpuWeights(ball_.view(), positions, laplace_steps);
  }

  std::vector<int16_t> cpuWeights(const AssetView& asset, const std::vector<Float3>& positions,
                                  uint32_t laplace_steps, std::vector<float>* q = nullptr) const {
    std::vector<float> triangle_q(asset.triangleCount()), point_q(asset.pointCount()),
        smoothed(point_q.size());
    std::vector<int16_t> weights(size_t{asset.vertexCount()} * asset.weightStride());
    for (uint32_t layer = 0; layer < asset.layerCount(); ++layer) {
      CompressJob{&asset, layer, positions, 1.0f, triangle_q}.run(0, asset.triangleCount());
      SmoothJob{&asset, triangle_q, point_q}.run(0, asset.pointCount());
      for (uint32_t step = 0; step < laplace_steps; ++step) {
        LaplaceJob{&asset, triangle_q, point_q, frame_.laplace_rate, smoothed}.run(0, asset.pointCount());
        std::swap(point_q, smoothed);
      }
      RespondJob{&asset, layer, asset.layers[layer].response, 0.0f, point_q, weights}.run(
          0, asset.vertexCount());
      if (q) q->insert(q->end(), point_q.begin(), point_q.end());
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

TEST_P(ExecutorTest, RunsTheWholeFrameAsTheJobsDo) {
  const AssetView& asset = ball_.view();
  const FramePlan plan(asset, {.form = GetParam()});
  gl::Executor executor;
  const Status status = executor.create(plan);
  ASSERT_TRUE(status.ok()) << status.message;
  executor.upload(frame_);
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

// What an engine may have switched on between its own draws.
TEST_P(ExecutorTest, RunsInWhateverStateTheHostLeft) {
  const AssetView& asset = ball_.view();
  const FramePlan plan(asset, {.form = GetParam(), .normals = false, .ease = true, .point_q = true});
  GLuint buffers[2];
  glGenBuffers(2, buffers);
  for (const auto& [target, index] :
       {std::pair(GL_PIXEL_UNPACK_BUFFER, 0), std::pair(GL_PIXEL_PACK_BUFFER, 1)}) {
    glBindBuffer(target, buffers[index]);
    glBufferData(target, 16, nullptr, GL_STATIC_DRAW);
  }
  gl::Executor executor;
  const Status status = executor.create(plan);
  ASSERT_TRUE(status.ok()) << status.message;
  ASSERT_TRUE(executor.upload(frame_).ok());
  for (GLenum on : {GL_PRIMITIVE_RESTART, GL_SCISSOR_TEST, GL_DEPTH_TEST, GL_STENCIL_TEST, GL_CULL_FACE,
                    GL_CLIP_DISTANCE0, GL_COLOR_LOGIC_OP, GL_PROGRAM_POINT_SIZE, GL_RASTERIZER_DISCARD,
                    GL_FRAMEBUFFER_SRGB, GL_SAMPLE_COVERAGE})
    glEnable(on);
  glPrimitiveRestartIndex(5);
  glScissor(0, 0, 1, 1);
  glDepthFunc(GL_NEVER);
  glStencilFunc(GL_NEVER, 0, 0);
  glCullFace(GL_FRONT_AND_BACK);
  glLogicOp(GL_CLEAR);
  glPointSize(7.0f);
  glPolygonMode(GL_FRONT_AND_BACK, GL_LINE);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  glBlendEquation(GL_FUNC_SUBTRACT);
  ASSERT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
  ASSERT_TRUE(executor.run().ok());
  const size_t words = size_t{asset.vertexCount()} * asset.weightStride();
  expectSameWeights(read<int16_t>(executor, Buffer::kWeights, words), cpuWeights(posed()));
  const auto q = read<float>(executor, Buffer::kPointQ, size_t{asset.pointCount()} * asset.layerCount());
  std::vector<float> expected;
  cpuWeights(asset, posed(), 0, &expected);
  EXPECT_EQ(std::memcmp(q.data(), expected.data(), q.size() * sizeof(float)), 0);
  EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
  glDeleteBuffers(2, buffers);
}

TEST_P(ExecutorTest, TakesPosedVerticesFromTheHost) {
  const AssetView& asset = ball_.view();
  const FramePlan plan(asset, {.form = GetParam(), .posed_by_host = true});
  gl::Executor executor;
  ASSERT_TRUE(executor.create(plan).ok());
  EXPECT_EQ(executor.handle(Buffer::kRestVertices), 0u);
  EXPECT_NE(executor.handle(Buffer::kPositions), 0u);
  const auto positions = posed();
  executor.upload(frame_);
  executor.upload(Buffer::kPositions, std::as_bytes(std::span(positions)));
  executor.run();
  expectSameWeights(
      read<int16_t>(executor, Buffer::kWeights, size_t{asset.vertexCount()} * asset.weightStride()),
      cpuWeights(positions));
}

TEST_P(ExecutorTest, WhatIsNoNumberCountsAsAtRest) {
  const AssetView& asset = ball_.view();
  const FramePlan plan(asset, {.form = GetParam(), .posed_by_host = true});
  gl::Executor executor;
  ASSERT_TRUE(executor.create(plan).ok());
  auto positions = posed();
  const auto plain = cpuWeights(positions);
  for (uint32_t p = 0; p < asset.pointCount(); p += 40)
    positions[asset.point_vertex[p]].y = p % 80 == 0 ? NAN : INFINITY;
  ASSERT_TRUE(executor.upload(frame_).ok());
  executor.upload(Buffer::kPositions, std::as_bytes(std::span(positions)));
  ASSERT_TRUE(executor.run().ok());
  const auto expected = cpuWeights(positions);
  EXPECT_NE(expected, plain);
  expectSameWeights(read<int16_t>(executor, Buffer::kWeights, expected.size()), expected);
}

// Layers that measure different triangles: "b" none where its direction is along the normal, "d" none at all.
TEST_P(ExecutorTest, LayersOfAnyMeasureAndCoverage) {
  Primitive bent = sheet(24);
  for (glm::vec3& p : bent.positions) p.z = p.x < 0.5f ? 0.0f : (p.x - 0.5f) * (p.x - 0.5f);
  std::vector<pipeline::LayerRecipe> layers;
  const auto add = [&](const char* name, Measure measure, std::array<double, 3> axis) {
    layers.push_back(axisLayer(axis));
    layers.back().name = name;
    layers.back().measure = measure;
  };
  add("a", Measure::kDirectional, {1, 0.2, 0});
  add("b", Measure::kDirectional, {0, 0, 1});
  add("c", Measure::kArea, {1, 0, 0});
  add("d", Measure::kNone, {1, 0, 0});
  add("e", Measure::kPrincipal, {1, 0, 0});
  add("f", Measure::kDirectional, {0, 1, 0});
  add("g", Measure::kArea, {0, 1, 0});
  layers[1].response = {Curve::kLarsson, 0.8f, 2.0f, 1.0f, 3.0f};
  layers[2].response.curve = Curve::kOat;
  const Asset asset = cookAsset(
      sceneOf(
          std::move(bent),
          [](glm::dvec3 p) { return glm::dvec3(0.7 * p.x, p.y + 0.2 * p.x * p.y, 0.4 * p.z + 0.1 * p.y); }),
      recipeOf(layers));
  const AssetView& view = asset.view();
  Affine pose;
  pose.m[0] = 0.8f, pose.m[1] = 0.6f, pose.m[4] = -0.6f, pose.m[5] = 0.8f, pose.m[3] = 3.5f;
  const Frame staged = evaluate(view, {0.7f}, pose, 1.25f, 0.125f);

  const FramePlan plan(view, {.form = GetParam(), .normals = false, .point_q = true});
  gl::Executor executor;
  const Status status = executor.create(plan);
  ASSERT_TRUE(status.ok()) << status.message;
  const std::vector<Affine> palette(view.palette.size(), pose);
  const std::vector<float> morphs = {0.7f}, regions(view.layerCount(), 0.125f);
  executor.upload({palette, morphs, regions, {}, 1.25f});
  executor.run();
  EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
  const auto q = read<float>(executor, Buffer::kPointQ, size_t{view.pointCount()} * view.layerCount());
  for (uint32_t l = 0; l < view.layerCount(); ++l)
    EXPECT_EQ(std::memcmp(&q[size_t{l} * view.pointCount()], staged.q[l].data(),
                          staged.q[l].size() * sizeof(float)),
              0)
        << view.layers[l].name;
  expectSameWeights(
      read<int16_t>(executor, Buffer::kWeights, size_t{view.vertexCount()} * view.weightStride()),
      staged.weights);
}

// Weights on their way and fading out, over frames of different lengths and a cut.
TEST_P(ExecutorTest, WeightsFollowInTimeAsOnTheCpu) {
  const AssetView& asset = ball_.view();
  const FramePlan plan(asset, {.form = GetParam(), .normals = false, .ease = true});
  gl::Executor executor;
  ASSERT_TRUE(executor.create(plan).ok());
  const std::vector<Ease> eases = {{6.0f, 2.0f}, {0.0f, 3.0f}};
  std::vector<float> state(size_t{asset.vertexCount()} * asset.weightStride());
  frame_.eases = eases;
  const struct {
    float seconds, down, fade;
    bool reset;
  } steps[] = {{0.1f, 0.0f, 1.0f, true},
               {0.1f, 0.2f, 1.0f, false},
               {0.03f, 0.21f, 0.5f, false},
               {0.2f, 0.0f, 1.0f, false},
               {0.1f, 0.1f, 1.0f, true}};
  for (const auto& step : steps) {
    palette_[1].m[7] = -step.down;
    frame_.seconds = step.seconds;
    frame_.reset = step.reset;
    frame_.fade = step.fade;
    std::vector<int16_t> expected = cpuWeights(posed());
    const EaseJob ease{&asset, eases, step.seconds, step.reset, step.fade, state, expected};
    ASSERT_TRUE(ease.validate().ok());
    ease.run(0, asset.vertexCount());
    executor.upload(frame_);
    executor.run();
    const auto weights = read<int16_t>(executor, Buffer::kWeights, expected.size());
    for (size_t i = 0; i < weights.size(); ++i) ASSERT_NEAR(weights[i], expected[i], 4) << step.seconds;
  }
}

TEST_P(ExecutorTest, TargetsMayMoveNormalsAlone) {
  SourceScene scene = sceneOf(sheet(12), [](glm::dvec3 p) { return p; });
  scene.primitives[0].morphs[0].normals.assign(scene.primitives[0].positions.size(), {0.5f, 0.25f, 0.0f});
  const Asset asset = cookAsset(std::move(scene), recipeOf({axisLayer({1, 0, 0})}));
  const AssetView& view = asset.view();
  ASSERT_EQ(view.morphs[0].position_step, 0.0f);
  const std::vector<Affine> palette(view.palette.size());
  const std::vector<float> morphs = {0.8f};
  std::vector<Float3> positions(view.vertexCount()), normals(view.vertexCount());
  const DeformJob job{&view, palette, morphs, positions, normals, {}};
  ASSERT_TRUE(job.validate().ok());
  job.run(0, view.vertexCount());
  ASSERT_GT(normals[0].x, 0.3f);
  frame_.palette = palette;
  frame_.morph_weights = morphs;
  const FramePlan plan(view, {.form = GetParam()});
  gl::Executor executor;
  ASSERT_TRUE(executor.create(plan).ok());
  ASSERT_TRUE(executor.upload(frame_).ok());
  ASSERT_TRUE(executor.run().ok());
  const auto gpu = read<Float3>(executor, Buffer::kNormals, normals.size());
  for (size_t v = 0; v < normals.size(); ++v) ASSERT_NEAR(gpu[v].x, normals[v].x, 1e-5f);
}

TEST_P(ExecutorTest, DualQuaternionsPoseAsOnTheCpu) {
  const AssetView& asset = ball_.view();
  palette_[1] = {{0, -1, 0, 0.1f, 1, 0, 0, 0.2f, 0, 0, 1.5f, 0.3f}};
  std::vector<JointMotion> motions(2);
  splitPalette(palette_, motions);
  frame_.motions = motions;
  std::vector<Float3> positions(asset.vertexCount()), normals(asset.vertexCount());
  std::vector<Float4> tangents(asset.vertexCount());
  DeformJob job{&asset, palette_, morph_, positions, normals, tangents};
  job.skinning = Skinning::kDualQuaternion;
  job.motions = motions;
  ASSERT_TRUE(job.validate().ok());
  job.run(0, asset.vertexCount());
  const FramePlan plan(asset, {.form = GetParam(), .skinning = Skinning::kDualQuaternion});
  gl::Executor executor;
  ASSERT_TRUE(executor.create(plan).ok());
  executor.upload(frame_);
  executor.run();
  const auto gpu = read<Float3>(executor, Buffer::kPositions, positions.size());
  EXPECT_EQ(std::memcmp(gpu.data(), positions.data(), positions.size() * sizeof(Float3)), 0);
  const auto gpu_normals = read<Float3>(executor, Buffer::kNormals, normals.size());
  const auto gpu_tangents = read<Float4>(executor, Buffer::kTangents, tangents.size());
  for (size_t v = 0; v < normals.size(); ++v) {
    ASSERT_NEAR(gpu_normals[v].x, normals[v].x, 1e-5f);
    ASSERT_NEAR(gpu_normals[v].z, normals[v].z, 1e-5f);
    ASSERT_NEAR(gpu_tangents[v].y, tangents[v].y, 1e-5f);
    ASSERT_EQ(gpu_tangents[v].w, tangents[v].w);
  }
}

TEST_P(ExecutorTest, LayersThatAreSwitchedOffWeighNothing) {
  const AssetView& asset = ball_.view();
  const FramePlan plan(asset, {.form = GetParam(), .normals = false});
  gl::Executor executor;
  ASSERT_TRUE(executor.create(plan).ok());
  const std::vector<int16_t> all = cpuWeights(posed());
  const size_t stride = asset.weightStride();
  for (uint32_t active : {3u, 1u, 2u, 0u, 3u}) {
    frame_.active_layers = active;
    ASSERT_TRUE(executor.upload(frame_).ok());
    size_t drawn = 0, expected = 0;  // slices of the raster form
    ASSERT_TRUE(executor.run({}, [&](const Item& item) { drawn += item.kind == ItemKind::kClear; }).ok());
    for (const FramePlan::Slice& slice : plan.slices())
      expected += std::ranges::any_of(slice.layers,
                                      [&](uint32_t l) { return l != kAbsent && (active >> l & 1u) != 0; });
    EXPECT_EQ(drawn, expected) << active;
    const auto weights = read<int16_t>(executor, Buffer::kWeights, all.size());
    for (size_t i = 0; i < weights.size(); ++i)
      ASSERT_NEAR(weights[i], (active >> (i % stride) & 1u) ? all[i] : 0, 3) << active;
  }
}

TEST_P(ExecutorTest, MeasuresFromARecapturedRest) {
  const AssetView& asset = ball_.view();
  palette_[1].m[7] = -0.4f;
  const std::vector<Float3> rest = posed();
  std::vector<Layer> layers(asset.layers.begin(), asset.layers.end());
  std::vector<std::vector<float>> coefficients(layers.size());
  for (uint32_t l = 0; l < layers.size(); ++l) {
    coefficients[l].resize(layers[l].coefficients.size());
    const RecaptureJob job{&asset, l, rest, 1.0f, coefficients[l]};
    ASSERT_TRUE(job.validate().ok());
    job.run(0, asset.triangleCount());
    layers[l].coefficients = coefficients[l];
  }
  AssetView own = asset;
  own.layers = layers;
  const FramePlan plan(own, {.form = GetParam()});
  ASSERT_EQ(plan.options().form, GetParam());
  gl::Executor executor;
  ASSERT_TRUE(executor.create(plan).ok());
  palette_[1].m[7] = -0.1f;
  ASSERT_TRUE(executor.upload(frame_).ok());
  ASSERT_TRUE(executor.run().ok());
  const auto expected = cpuWeights(own, posed(), 0);
  expectSameWeights(read<int16_t>(executor, Buffer::kWeights, expected.size()), expected);
  EXPECT_NE(expected, cpuWeights(posed()));
}

class LaplaceTest : public ExecutorTest {};

TEST_P(LaplaceTest, StepsAsOnTheCpu) {
  const AssetView& asset = ball_.view();
  frame_.laplace_rate = 0.7f;
  const std::vector<int16_t> without = cpuWeights(posed());
  for (uint32_t steps : {1u, 2u, 5u}) {
    SCOPED_TRACE(steps);
    const FramePlan plan(asset, {.form = GetParam(), .laplace_steps = steps});
    ASSERT_EQ(plan.options().form, GetParam() == Form::kRaster ? Form::kRaster : Form::kStaged);
    gl::Executor executor;
    const Status status = executor.create(plan);
    ASSERT_TRUE(status.ok()) << status.message;
    ASSERT_TRUE(executor.upload(frame_).ok());
    ASSERT_TRUE(executor.run().ok());
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    std::vector<float> q;
    const auto expected = cpuWeights(asset, posed(), steps, &q);
    EXPECT_EQ(read<float>(executor, Buffer::kPointQ, q.size()), q);
    expectSameWeights(read<int16_t>(executor, Buffer::kWeights, expected.size()), expected);
    EXPECT_NE(expected, without);
  }
}

class ClusteredTest : public ExecutorTest {};

TEST_P(ClusteredTest, ManyInstancesInOneDispatch) {
  const AssetView& asset = ball_.view();
  constexpr uint32_t kInstances = 5;
  const FramePlan plan(asset, {.normals = false, .instances = kInstances});
  ASSERT_EQ(plan.items()[0].groups[1], kInstances);
  gl::Executor executor;
  ASSERT_TRUE(executor.create(plan).ok());
  const size_t words = size_t{asset.vertexCount()} * asset.weightStride();
  const auto pose = [&](uint32_t instance, float more) {
    palette_[1].m[7] = -0.05f * static_cast<float>(instance) - more;
    morph_[0] = 0.2f * static_cast<float>(instance);
    executor.upload(frame_, instance);
    return cpuWeights(posed());
  };
  const auto weightsOf = [&](uint32_t instance) {
    std::vector<int16_t> weights(words);
    executor.read(Buffer::kWeights, std::as_writable_bytes(std::span(weights)),
                  instance * plan.instanceBytes(Buffer::kWeights));
    return weights;
  };
  std::vector<std::vector<int16_t>> expected;
  for (uint32_t i = 0; i < kInstances; ++i) expected.push_back(pose(i, 0.0f));
  executor.run();
  for (uint32_t i = 1; i < kInstances; ++i) expectSameWeights(weightsOf(i), expected[i]);
  // Of the instances that are due, in any order; the others keep what they have.
  for (uint32_t i = 0; i < kInstances; ++i) {
    const auto moved = pose(i, 0.04f);
    if (i == 3 || i == 1) expected[i] = moved;
  }
  const uint32_t due[] = {3, 1};
  executor.run(due);
  for (uint32_t i = 1; i < kInstances; ++i) expectSameWeights(weightsOf(i), expected[i]);
  executor.run();
  expectSameWeights(weightsOf(2), pose(2, 0.04f));
}

// Their constants lie in a storage buffer, which holds more than a uniform buffer does.
TEST_P(ClusteredTest, AThousandInstances) {
  const AssetView& asset = ball_.view();
  const FramePlan plan(asset, {.normals = false, .instances = 1000});
  gl::Executor executor;
  const Status status = executor.create(plan);
  ASSERT_TRUE(status.ok()) << status.message;
  const uint32_t last[] = {999};
  ASSERT_TRUE(executor.upload(frame_, last[0]).ok());
  ASSERT_TRUE(executor.run(last).ok());
  std::vector<int16_t> weights(size_t{asset.vertexCount()} * asset.weightStride());
  executor.read(Buffer::kWeights, std::as_writable_bytes(std::span(weights)),
                last[0] * plan.instanceBytes(Buffer::kWeights));
  expectSameWeights(weights, cpuWeights(posed()));
}

// A point in more triangles than a cluster of the GPU holds.
TEST_P(ClusteredTest, WhatClustersCannotHoldIsStaged) {
  Primitive fan;
  constexpr uint32_t kBlades = 3000;
  fan.positions.push_back({0, 0, 0});
  for (uint32_t i = 0; i < kBlades; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kBlades;
    fan.positions.push_back({static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)), 0.0f});
    fan.indices.insert(fan.indices.end(), {0u, 1 + i, 1 + (i + 1) % kBlades});
  }
  const Asset asset = cookAsset(sceneOf(fan, [](glm::dvec3 p) { return glm::dvec3(0.7 * p.x, p.y, p.z); }),
                                recipeOf({axisLayer({1, 0, 0})}));
  const FramePlan plan(asset.view(), {.instances = 4});
  EXPECT_EQ(plan.options().form, Form::kStaged);
  EXPECT_EQ(plan.options().instances, 1u);
}

// What a frame debugger shows: a group for each item in the frame's, and the names of buffers.
TEST_P(ExecutorTest, EveryItemAndBufferIsLabelled) {
  if (epoxy_gl_version() < 43 && !epoxy_has_gl_extension("GL_KHR_debug")) GTEST_SKIP() << "no GL_KHR_debug";
  const FramePlan plan(ball_.view(), {.form = GetParam(), .ease = true});
  gl::Executor executor;
  ASSERT_TRUE(executor.create(plan).ok());
  for (size_t i = 0; i < static_cast<size_t>(Buffer::kCount); ++i) {
    const auto id = static_cast<Buffer>(i);
    char label[64] = {};
    if (executor.handle(id)) glGetObjectLabel(GL_BUFFER, executor.handle(id), sizeof label, nullptr, label);
    EXPECT_STREQ(label, executor.handle(id) ? plan.buffer(id).name : "");
  }
  std::vector<std::string> groups;
  glEnable(GL_DEBUG_OUTPUT);
  glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
  glDebugMessageCallback(
      [](GLenum, GLenum type, GLuint, GLenum, GLsizei, const GLchar* message, const void* user) {
        auto& seen =
            *const_cast<std::vector<std::string>*>(static_cast<const std::vector<std::string>*>(user));
        if (type == GL_DEBUG_TYPE_PUSH_GROUP) seen.emplace_back(message);
        if (type == GL_DEBUG_TYPE_POP_GROUP) seen.emplace_back();
      },
      &groups);
  ASSERT_TRUE(executor.upload(frame_).ok());
  ASSERT_TRUE(executor.run().ok());
  glDebugMessageCallback(nullptr, nullptr);
  glDisable(GL_DEBUG_OUTPUT);
  std::vector<std::string> expected = {"furrow"};
  for (const Item& item : plan.items()) {
    EXPECT_EQ(std::string_view(item.label).substr(0, 7), "furrow ");
    expected.insert(expected.end(), {item.label, ""});
  }
  expected.emplace_back();
  EXPECT_EQ(groups, expected);
}

TEST_P(ExecutorTest, CanBeMadeAgain) {
  const FramePlan plan(ball_.view(), {.form = GetParam()});
  gl::Executor executor;
  EXPECT_EQ(executor.handle(Buffer::kWeights), 0u);
  ASSERT_TRUE(executor.create(plan).ok());
  ASSERT_TRUE(executor.create(plan).ok());
  executor.upload(frame_);
  executor.run();
  EXPECT_NE(executor.handle(Buffer::kWeights), 0u);
}

INSTANTIATE_TEST_SUITE_P(Clustered, ExecutorTest, testing::Values(Form::kClustered));
INSTANTIATE_TEST_SUITE_P(Clustered, ClusteredTest, testing::Values(Form::kClustered));
INSTANTIATE_TEST_SUITE_P(Clustered, LaplaceTest, testing::Values(Form::kClustered));
INSTANTIATE_TEST_SUITE_P(Staged, LaplaceTest, testing::Values(Form::kStaged));
INSTANTIATE_TEST_SUITE_P(Raster, LaplaceTest, testing::Values(Form::kRaster));
INSTANTIATE_TEST_SUITE_P(Staged, ExecutorTest, testing::Values(Form::kStaged));
INSTANTIATE_TEST_SUITE_P(Raster, ExecutorTest, testing::Values(Form::kRaster));

}  // namespace
}  // namespace furrow::tests
