// Real files that nobody here wrote, in many poses: every form of the frame gives the same weights. On the
// cpu tier to the bit, for any instruction set and split and on both sides of every seam; on the gpu tiers
// within 1e-4.

#include <cstring>
#include <random>
#include <thread>

#include "editor/preview/loaded_asset.h"
#include "editor/preview/posed_frame.h"
#include "furrow/gl/executor.h"
#include "furrow/recapture.h"
#include "pipeline/import/import.h"
#include "pipeline/scene/posing.h"
#include "tests/image/gl_fixture.h"
#include "tests/unit/sheets.h"

namespace furrow::tests {
namespace {

const std::filesystem::path kCorpus = FURROW_CORPUS;

// Of the glTF files in a folder of the corpus, those that there is something to cook in; the others are for
// corpus_test to judge.
std::vector<std::string> filesIn(const std::string& folder) {
  std::vector<std::string> names;
  if (!std::filesystem::is_directory(kCorpus / folder)) return names;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(kCorpus / folder))
    if (const auto extension = entry.path().extension(); extension == ".gltf" || extension == ".glb")
      names.push_back(entry.path());
  std::sort(names.begin(), names.end());
  return names;
}

// A layer of every measure.
pipeline::Recipe recipeOfMeasures() {
  std::vector<pipeline::LayerRecipe> layers;
  for (Measure measure :
       {Measure::kDirectional, Measure::kArea, Measure::kPrincipal, Measure::kDirectional}) {
    pipeline::LayerRecipe& layer = layers.emplace_back(axisLayer({0.3, 1.0, 0.2}, 3.0f));
    layer.name += std::to_string(layers.size());
    layer.measure = measure;
  }
  layers.back().direction = pipeline::DirectionAnimation{};
  return recipeOf(std::move(layers));
}

// At rest, in its clips, with its morph targets, and with every palette entry bent a little on its own.
std::vector<preview::PosedFrame> posesOf(const preview::LoadedAsset& loaded) {
  const AssetView& view = loaded.asset.view();
  const pipeline::Pose rest = pipeline::defaultPose(loaded.rig);
  std::vector<preview::PosedFrame> frames;
  const auto add = [&](const pipeline::Pose& pose, float scale = 1.0f) {
    frames.push_back(preview::poseFrame(view, pipeline::evaluate(loaded.rig, pose), {}, scale));
  };
  add(rest);
  for (size_t c = 0; c < std::min<size_t>(loaded.rig.clips.size(), 2); ++c)
    for (double part : {0.3, 0.8}) {
      pipeline::Pose pose = rest;
      pipeline::applyClip(loaded.rig, loaded.rig.clips[c], part * loaded.rig.clips[c].duration, pose);
      add(pose);
    }
  if (!view.morphs.empty()) {
    pipeline::Pose pose = rest;
    for (size_t m = 0; m < pose.morph_weights.size(); ++m) pose.morph_weights[m] = m % 3 == 0 ? 0.7 : 0.2;
    add(pose);
  }
  add(rest, 1.25f);
  std::mt19937 random(11);
  std::uniform_real_distribution<float> part(-0.15f, 0.15f);
  for (Affine& m : frames.back().palette)
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column)
        m.m[4 * row + column] +=
            part(random) * std::abs(m.m[4 * row + (column + 1) % 3] + 0.5f * m.m[4 * row + row]);
  return frames;
}

constexpr uint32_t kLaplaceSteps = 3;

struct Weighed {
  std::vector<Float3> positions;
  std::vector<int16_t> weights;
};

Weighed staged(const AssetView& view, const FrameInput& input, uint32_t laplace_steps = 0) {
  Weighed out{std::vector<Float3>(view.vertexCount()),
              std::vector<int16_t>(size_t{view.vertexCount()} * view.weightStride())};
  DeformJob deform{&view, input.palette, input.morph_weights, out.positions, {}, {}};
  deform.simd = Simd::kPortable;
  EXPECT_TRUE(deform.validate().ok());
  deform.run(0, view.vertexCount());
  std::vector<float> triangle_q(view.triangleCount()), point_q(view.pointCount()), other_q(point_q.size());
  for (uint32_t l = 0; l < view.layerCount(); ++l) {
    CompressJob{&view, l, out.positions, input.scale, triangle_q}.run(0, view.triangleCount());
    SmoothJob{&view, triangle_q, point_q}.run(0, view.pointCount());
    for (uint32_t step = 0; step < laplace_steps; ++step, std::swap(point_q, other_q))
      LaplaceJob{&view, triangle_q, point_q, input.laplace_rate, other_q}.run(0, view.pointCount());
    RespondJob{&view, l, view.layers[l].response, input.region_weights[l], point_q, out.weights}.run(
        0, view.vertexCount());
  }
  return out;
}

// On so many threads, the last clusters first.
Weighed clustered(const Clusters& clusters, const FrameInput& input, Simd simd, uint32_t threads,
                  std::span<const uint32_t> rest = {}) {
  const AssetView& view = *clusters.asset;
  Weighed out{std::vector<Float3>(view.vertexCount()),
              std::vector<int16_t>(size_t{view.vertexCount()} * view.weightStride())};
  ClusterFrameJob job;
  job.clusters = &clusters;
  job.palette = input.palette;
  job.morph_weights = input.morph_weights;
  job.region_weights = input.region_weights;
  job.scale = input.scale;
  job.positions = out.positions;
  job.rest = rest;
  job.weights = out.weights;
  job.simd = simd;
  EXPECT_TRUE(job.validate().ok());
  std::vector<std::jthread> pool;
  for (uint32_t i = threads; i-- > 0;)
    pool.emplace_back([&, i] {
      std::vector<std::byte> memory(clusters.scratchBytes() + 64);
      void* scratch = memory.data();
      size_t space = memory.size();
      std::align(64, clusters.scratchBytes(), scratch, space);
      job.run(clusters.count() * i / threads, clusters.count() * (i + 1) / threads,
              {static_cast<std::byte*>(scratch), space});
    });
  pool.clear();
  return out;
}

// From a rest of its own, which the instance has in `positions`.
void expectFromRest(const Clusters& clusters, const std::vector<Float3>& positions, const FrameInput& input) {
  const AssetView& view = *clusters.asset;
  std::vector<Layer> layers(view.layers.begin(), view.layers.end());
  std::vector<std::vector<float>> coefficients;
  for (uint32_t l = 0; l < view.layerCount(); ++l) {
    auto& own = coefficients.emplace_back(layers[l].coefficients.size());
    RecaptureJob{&view, l, positions, input.scale, own}.run(0, view.triangleCount());
    layers[l].coefficients = own;
  }
  AssetView own = view;
  own.layers = layers;
  std::vector<uint32_t, LineAllocator<uint32_t>> rest(clusters.restWords());
  ClusterRecaptureJob{&clusters, positions, input.scale, rest}.run(0, clusters.count());
  EXPECT_EQ(clustered(clusters, input, bestSimd(), 2, rest).weights, staged(own, input).weights);
}

bool sameBits(const Weighed& a, const Weighed& b) {
  return a.weights == b.weights &&
         std::memcmp(a.positions.data(), b.positions.data(), a.positions.size() * sizeof(Float3)) == 0;
}

void expectOneWeightAPoint(const AssetView& view, const std::vector<int16_t>& weights) {
  const size_t stride = view.weightStride();
  for (uint32_t v = 0; v < view.vertexCount(); ++v) {
    const uint32_t other = view.point_vertex[view.vertex_point[v]];
    ASSERT_EQ(std::memcmp(&weights[v * stride], &weights[other * stride], stride * sizeof(int16_t)), 0) << v;
  }
}

class CorpusForms : public GlTest, public testing::WithParamInterface<const char*> {
 protected:
  void SetUp() override {
    if (!std::filesystem::is_directory(kCorpus)) GTEST_SKIP() << "there is no " << kCorpus;
    GlTest::SetUp();
  }

  void expectOnGpu(const AssetView& view, const std::vector<preview::PosedFrame>& frames,
                   const std::vector<Weighed>& expected, uint32_t laplace_steps = 0) const {
    for (Form form : {Form::kClustered, Form::kStaged, Form::kRaster}) {
      if (form != Form::kRaster && !support_.gpu) continue;
      if (form == Form::kClustered && laplace_steps > 0) continue;  // the staged one
      SCOPED_TRACE(static_cast<int>(form));
      const bool by_host = form == Form::kRaster;
      const FramePlan plan(
          view, {.form = form, .posed_by_host = by_host, .normals = false, .laplace_steps = laplace_steps});
      gl::Executor executor;
      const Status status = executor.create(plan);
      ASSERT_TRUE(status.ok()) << status.message;
      for (size_t f = 0; f < frames.size(); ++f) {
        if (by_host) executor.upload(Buffer::kPositions, std::as_bytes(std::span(expected[f].positions)));
        ASSERT_TRUE(executor.upload(frames[f].input).ok());
        ASSERT_TRUE(executor.run().ok());
        std::vector<int16_t> weights(expected[f].weights.size());
        executor.read(Buffer::kWeights, std::as_writable_bytes(std::span(weights)));
        for (size_t i = 0; i < weights.size(); ++i)
          ASSERT_NEAR(weights[i], expected[f].weights[i], 3) << "pose " << f << ", weight " << i;
      }
    }
  }
};

TEST_P(CorpusForms, GiveTheSameWeights) {
  size_t files = 0, moved = 0;
  for (const std::string& name : filesIn(GetParam())) {
    SCOPED_TRACE(name);
    preview::LoadedAsset loaded;
    try {
      loaded = preview::loadAsset(name, pipeline::cook(pipeline::import(name), recipeOfMeasures(), {}).bytes);
    } catch (const pipeline::Error&) {
      continue;
    }
    const AssetView& view = loaded.asset.view();
    Clusters clusters;
    ASSERT_TRUE(clusters.build(view).ok());
    const std::vector<preview::PosedFrame> frames = posesOf(loaded);
    std::vector<Weighed> expected, smoothed;
    for (const preview::PosedFrame& frame : frames) {
      const Weighed& reference = expected.emplace_back(staged(view, frame.input));
      expectOneWeightAPoint(view, reference.weights);
      smoothed.push_back(staged(view, frame.input, kLaplaceSteps));
      for (Simd simd : {Simd::kPortable, Simd::kSse4, Simd::kAvx2, Simd::kAvx512, Simd::kNeon}) {
        if (!simdAvailable(simd)) continue;
        for (uint32_t threads : {1u, 3u})
          EXPECT_TRUE(sameBits(clustered(clusters, frame.input, simd, threads), reference))
              << simdName(simd) << ' ' << threads << " threads, pose " << expected.size() - 1;
      }
    }
    for (size_t f = 0; f + 1 < frames.size(); ++f)
      expectFromRest(clusters, expected[f].positions, frames.back().input);
    expectOnGpu(view, frames, expected);
    expectOnGpu(view, frames, smoothed, kLaplaceSteps);
    ++files;
    moved += std::any_of(expected.back().weights.begin(), expected.back().weights.end(),
                         [](int16_t w) { return std::abs(w) > 3000; });
  }
  EXPECT_GT(files, 0u);
  EXPECT_GT(2 * moved, files);  // there was something to weigh
}

INSTANTIATE_TEST_SUITE_P(Corpus, CorpusForms, testing::Values("face", "garment", "morph", "odd", "skinned"),
                         [](const auto& folder) { return std::string(folder.param); });

}  // namespace
}  // namespace furrow::tests
