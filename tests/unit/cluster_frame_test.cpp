// The clustered frame against the staged one: the same bits on every instruction set, split and thread.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#ifdef __unix__
#include <sys/mman.h>
#endif

#include <cstring>
#include <random>
#include <set>
#include <thread>

#include "furrow/furrow.h"
#include "furrow/recapture.h"
#include "sheets.h"

namespace {

using namespace furrow;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;
using tests::Frame;

std::vector<Simd> available() {
  std::vector<Simd> all;
  for (Simd simd : {Simd::kPortable, Simd::kSse4, Simd::kAvx2, Simd::kAvx512, Simd::kNeon})
    if (simdAvailable(simd)) all.push_back(simd);
  return all;
}

// A bumpy sheet of n x n quads that its morph target squeezes and bends.
pipeline::SourceScene bumpy(uint32_t n) {
  pipeline::Primitive sheet = tests::sheet(n);
  std::mt19937 random(7);
  std::uniform_real_distribution<float> jitter(-0.2f / static_cast<float>(n), 0.2f / static_cast<float>(n));
  for (glm::vec3& p : sheet.positions) p += glm::vec3(jitter(random), jitter(random), jitter(random));
  return tests::sceneOf(std::move(sheet), [](glm::dvec3 p) {
    return glm::dvec3(0.6 * p.x, p.y + 0.1 * p.x * p.x, 0.3 * p.x * p.y);
  });
}

pipeline::LayerRecipe layerOf(const char* name, Measure measure, std::array<double, 3> axis) {
  pipeline::LayerRecipe layer = tests::axisLayer(axis);
  layer.name = name;
  layer.measure = measure;
  return layer;
}

std::vector<int16_t> clusteredWeights(const Clusters& clusters, Simd simd, const Affine& pose, float weight,
                                      std::vector<Float3>* positions = nullptr, uint32_t threads = 1,
                                      float scale = 1.0f) {
  const AssetView& asset = *clusters.asset;
  const std::vector<Affine> palette(asset.palette.size(), pose);
  std::vector<float> morph_weights(asset.morphs.size(), 0.0f);
  morph_weights[0] = weight;
  std::vector<int16_t> weights(size_t{asset.vertexCount()} * asset.weightStride());
  ClusterFrameJob job;
  job.clusters = &clusters;
  job.palette = palette;
  job.morph_weights = morph_weights;
  if (positions) {
    positions->resize(asset.vertexCount());
    job.positions = *positions;
  }
  job.weights = weights;
  job.simd = simd;
  job.scale = scale;
  const Status status = job.validate();
  EXPECT_TRUE(status.ok()) << status.message;
  std::vector<std::jthread> pool;
  for (uint32_t i = 0; i < threads; ++i)
    pool.emplace_back([&, i] {
      std::vector<std::byte> scratch(clusters.scratchBytes() + 64);
      auto* aligned =
          reinterpret_cast<std::byte*>((reinterpret_cast<uintptr_t>(scratch.data()) + 63) & ~uintptr_t{63});
      job.run(clusters.count() * i / threads, clusters.count() * (i + 1) / threads,
              {aligned, clusters.scratchBytes()});
    });
  pool.clear();
  return weights;
}

TEST(ClusterFrame, SameBitsAsTheStagedFrame) {
  // Two layers do not cover everything: at the poles of their axis the direction is undefined.
  const Asset asset = tests::cookAsset(
      bumpy(61),
      tests::recipeOf({layerOf("a", Measure::kDirectional, {1, 0.2, 0}),
                       layerOf("b", Measure::kArea, {0, 1, 0}), layerOf("c", Measure::kPrincipal, {0, 1, 0}),
                       layerOf("d", Measure::kNone, {1, 0, 0}),
                       layerOf("e", Measure::kDirectional, {0, 0, 1})}));
  const AssetView& view = asset.view();
  Clusters clusters, large;
  ASSERT_TRUE(clusters.build(view).ok());
  ASSERT_TRUE(large.build(view, {.points = kClusterPoints}).ok());
  EXPECT_GT(clusters.count(), large.count());
  EXPECT_GT(large.count(), 1u);
  Affine pose;
  pose.m[0] = 0.8f, pose.m[1] = 0.6f, pose.m[4] = -0.6f, pose.m[5] = 0.8f, pose.m[3] = 3.5f;
  for (float weight : {0.0f, 0.37f, 1.0f}) {
    const Frame staged = tests::evaluate(view, {weight}, pose, 1.25f);
    for (Simd simd : available()) {
      std::vector<Float3> positions;
      EXPECT_EQ(clusteredWeights(clusters, simd, pose, weight, &positions, 1, 1.25f), staged.weights)
          << simdName(simd);
      ASSERT_EQ(positions.size(), staged.positions.size());
      EXPECT_EQ(std::memcmp(positions.data(), staged.positions.data(), positions.size() * sizeof(Float3)), 0)
          << simdName(simd);
      EXPECT_EQ(clusteredWeights(large, simd, pose, weight, nullptr, 1, 1.25f), staged.weights)
          << simdName(simd);
    }
    EXPECT_EQ(clusteredWeights(clusters, bestSimd(), pose, weight, nullptr, 3, 1.25f), staged.weights);
  }
}

// The cheap form of the response must not be told from I(alpha) - I_s(1 / alpha).
TEST(Respond, OneSidedIsTheWholeResponse) {
  for (const Response response :
       {Response{Curve::kLarsson, 1.0f, 4.0f, 1.0f, 4.0f}, Response{Curve::kLarsson, 1.7f, 2.5f, 1.0f, 9.0f},
        Response{Curve::kLarsson, 1.0f, 16.0f, 3.0f, 0.5f},
        Response{Curve::kLarsson, 0.7f, 4.0f, 0.9f, 4.0f}})
    for (double q = 1.0 / 64; q <= 4.0; q *= 1.003) {
      const double alpha = 1.0 / static_cast<float>(q);
      const auto intensity = [](double a, double lambda, double beta) {
        return std::max(0.0, 1.0 - 2.0 / (1.0 + std::pow(a / lambda, beta)));
      };
      EXPECT_NEAR(respond(response, static_cast<float>(q), 0.0f, 0.0f),
                  intensity(alpha, response.lambda, response.beta) -
                      intensity(1.0 / alpha, response.stretch_lambda, response.stretch_beta),
                  4e-6);
    }
}

// Any rig: more joints than 8 bits number, any number of influences, parts that are quantised differently.
TEST(ClusterFrame, SameBitsWhateverTheRig) {
  std::mt19937 random(5);
  for (uint32_t joints : {3u, 300u})
    for (uint32_t influences : {1u, 2u, 4u, 5u, 8u}) {
      pipeline::SourceScene scene = bumpy(40);
      scene.rig.palette.assign(2 * joints, {});
      const pipeline::Primitive sheet = scene.primitives[0];
      scene.primitives.push_back(sheet);
      scene.parts.push_back(scene.parts[0]);
      scene.parts[1].primitive = 1;
      for (glm::vec3& p : scene.primitives[1].positions) p = 7.0f * p + glm::vec3(1.0f, 0.0f, 0.0f);
      for (uint32_t i = 0; i < 2; ++i) {
        scene.parts[i].skinned = true;
        scene.parts[i].palette_begin = i * joints;
        scene.parts[i].palette_count = joints;
        pipeline::Primitive& primitive = scene.primitives[i];
        primitive.influences = influences;
        for (size_t k = 0; k < primitive.positions.size() * influences; ++k) {
          primitive.joints.push_back(static_cast<uint16_t>(random() % joints));
          primitive.weights.push_back(1.0f / static_cast<float>(influences));
        }
      }
      const Asset asset =
          tests::cookAsset(std::move(scene), tests::recipeOf({tests::axisLayer({1, 0.3, 0.1})}));
      const AssetView& view = asset.view();
      ASSERT_EQ(view.influences, influences);
      Clusters clusters;
      ASSERT_TRUE(clusters.build(view).ok());
      EXPECT_EQ(clusters.wideJoints(), joints == 300);
      const std::vector<Affine> palette = [&] {
        std::vector<Affine> some(view.palette.size());
        std::uniform_real_distribution<float> any(-0.2f, 0.2f);
        for (Affine& matrix : some)
          for (float& value : matrix.m) value += any(random);
        return some;
      }();
      const std::vector<float> morph_weights = {0.4f};
      std::vector<Float3> positions(view.vertexCount());
      DeformJob{&view, palette, morph_weights, positions, {}, {}}.run(0, view.vertexCount());
      std::vector<float> triangle_q(view.triangleCount()), q(view.pointCount());
      std::vector<int16_t> weights(view.vertexCount() * view.weightStride());
      CompressJob{&view, 0, positions, 1.0f, triangle_q}.run(0, view.triangleCount());
      SmoothJob{&view, triangle_q, q}.run(0, view.pointCount());
      RespondJob{&view, 0, view.layers[0].response, 0.0f, q, weights}.run(0, view.vertexCount());
      for (Simd simd : available()) {
        std::vector<Float3> posed(view.vertexCount());
        std::vector<int16_t> clustered(weights.size());
        std::vector<std::byte> scratch(clusters.scratchBytes());
        ClusterFrameJob job;
        job.clusters = &clusters;
        job.palette = palette;
        job.morph_weights = morph_weights;
        job.positions = posed;
        job.weights = clustered;
        job.simd = simd;
        ASSERT_TRUE(job.validate().ok());
        job.run(0, clusters.count(), scratch);
        EXPECT_EQ(clustered, weights) << joints << " " << influences << " " << simdName(simd);
        EXPECT_EQ(std::memcmp(posed.data(), positions.data(), posed.size() * sizeof(Float3)), 0)
            << joints << " " << influences << " " << simdName(simd);
      }
    }
}

TEST(ClusterFrame, SixteenLayersAndTheSmallestSurfaces) {
  std::vector<pipeline::LayerRecipe> layers;
  const std::string names = "abcdefghijklmnop";
  for (uint32_t l = 0; l < kMaxLayers; ++l) {
    const double angle = 0.3 * l;
    layers.push_back(layerOf(names.substr(l, 1).c_str(),
                             l % 5 == 3 ? Measure::kNone : static_cast<Measure>(l % 3),
                             {std::cos(angle), std::sin(angle), 0.1}));
  }
  pipeline::Primitive one;
  one.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  one.indices = {0, 1, 2};
  pipeline::Primitive loose = tests::sheet(3);  // with points in no triangle
  for (int i = 0; i < 9; ++i) loose.positions.push_back({0.1f * static_cast<float>(i), 3.0f, 1.0f});
  loose.uvs.clear();
  const auto squeeze = [](glm::dvec3 p) { return glm::dvec3(0.7 * p.x, 0.9 * p.y, p.z + 0.1 * p.x * p.x); };
  for (const pipeline::SourceScene& scene :
       {bumpy(40), tests::sceneOf(one, squeeze), tests::sceneOf(loose, squeeze)}) {
    const Asset asset = tests::cookAsset(scene, tests::recipeOf(layers));
    Clusters clusters;
    ASSERT_TRUE(clusters.build(asset.view()).ok());
    const Frame staged = tests::evaluate(asset.view(), {0.8f});
    for (Simd simd : available())
      EXPECT_EQ(clusteredWeights(clusters, simd, {}, 0.8f), staged.weights) << simdName(simd);
  }
}

// One, two, up to four and up to eight are each smoothed in a way of their own.
TEST(ClusterFrame, AnyNumberOfLayersSideBySide) {
  std::vector<pipeline::LayerRecipe> layers;
  for (const char* name : {"a", "b", "c", "d", "e", "f", "g", "h", "i", "j"}) {
    const double angle = 0.3 * static_cast<double>(layers.size());
    layers.push_back(layerOf(name, Measure::kDirectional, {std::cos(angle), std::sin(angle), 0.1}));
    const Asset asset = tests::cookAsset(bumpy(12), tests::recipeOf(layers));
    Clusters clusters;
    ASSERT_TRUE(clusters.build(asset.view(), {.points = 50}).ok());
    const Frame staged = tests::evaluate(asset.view(), {0.8f});
    for (Simd simd : available())
      EXPECT_EQ(clusteredWeights(clusters, simd, {}, 0.8f), staged.weights)
          << simdName(simd) << ", " << layers.size() << " layers";
  }
}

// Memory behind which nothing may be read.
class Exact {
 public:
#ifdef __unix__
  explicit Exact(size_t bytes) : whole_((bytes + kEdge - 1) / kEdge * kEdge) {
    memory_ = static_cast<std::byte*>(
        mmap(nullptr, whole_ + kEdge, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
    EXPECT_EQ(mprotect(memory_ + whole_, kEdge, PROT_NONE), 0);
    data_ = memory_ + whole_ - bytes;
  }
  ~Exact() {
    munmap(memory_, whole_ + kEdge);
  }
#else
  explicit Exact(size_t bytes) : memory_(new std::byte[bytes]), data_(memory_) {}
  ~Exact() {
    delete[] memory_;
  }
#endif
  Exact(const Exact&) = delete;
  Exact& operator=(const Exact&) = delete;
  std::byte* data() const {
    return data_;
  }

 private:
  static constexpr size_t kEdge = 1 << 16;  // whole pages
  size_t whole_ = 0;
  std::byte *memory_ = nullptr, *data_ = nullptr;
};

TEST(ClusterFrame, PosedByTheHostAtAnyStride) {
  const Asset asset = tests::cookAsset(bumpy(40), tests::recipeOf({tests::axisLayer({1, 0, 0})}));
  const AssetView& view = asset.view();
  Clusters clusters;
  ASSERT_TRUE(clusters.build(view).ok());
  const Frame staged = tests::evaluate(view, {1.0f});
  for (size_t stride : {size_t{12}, size_t{16}, size_t{32}, size_t{44}}) {
    const Exact buffer(stride * (view.vertexCount() - 1) + sizeof(Float3));
    for (uint32_t v = 0; v < view.vertexCount(); ++v)
      std::memcpy(buffer.data() + v * stride, &staged.positions[v], sizeof(Float3));
    std::vector<std::byte> scratch(clusters.scratchBytes());
    for (Simd simd : available()) {
      std::vector<int16_t> weights(staged.weights.size());
      ClusterFrameJob job;
      job.clusters = &clusters;
      job.posed = buffer.data();
      job.posed_stride = stride;
      job.weights = weights;
      job.simd = simd;
      ASSERT_TRUE(job.validate().ok());
      job.run(0, clusters.count(), scratch);
      EXPECT_EQ(weights, staged.weights) << stride << " " << simdName(simd);
    }
  }
}

#ifdef __unix__
// Memory that must not be touched.
class Forbidden {
 public:
  explicit Forbidden(size_t bytes)
      : bytes_(bytes), memory_(mmap(nullptr, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0)) {}
  Forbidden(const Forbidden&) = delete;
  Forbidden& operator=(const Forbidden&) = delete;
  ~Forbidden() { munmap(memory_, bytes_); }
  template <typename T>
  std::span<T> of(size_t count) const {
    EXPECT_LE(count * sizeof(T), bytes_);
    return {static_cast<T*>(memory_), count};
  }

 private:
  size_t bytes_;
  void* memory_;
};

// What is at rest or switched off costs nothing: it is not even read.
TEST(ClusterFrame, WhatIsNotActiveIsNotRead) {
  pipeline::SourceScene scene = bumpy(40);
  scene.primitives[0].morphs.push_back(scene.primitives[0].morphs[0]);
  scene.rig.morphs.push_back({"other", 0, 1, 0.0});
  const Asset asset = tests::cookAsset(std::move(scene), tests::recipeOf({tests::axisLayer({1, 0, 0})}));
  AssetView view = asset.view();
  ASSERT_EQ(view.morphs.size(), 2u);
  const Forbidden memory(1 << 22);
  std::vector<Morph> morphs(view.morphs.begin(), view.morphs.end());
  morphs[1].position_deltas = memory.of<int32_t>(morphs[1].position_deltas.size());
  morphs[1].normal_deltas = memory.of<int8_t>(morphs[1].normal_deltas.size());
  view.morphs = morphs;
  Clusters clusters;
  ASSERT_TRUE(clusters.build(view).ok());
  const Frame staged = tests::evaluate(asset.view(), {0.7f, 0.0f});
  EXPECT_EQ(clusteredWeights(clusters, bestSimd(), {}, 0.7f), staged.weights);
  std::vector<Float3> positions(view.vertexCount()), normals(positions.size());
  std::vector<Float4> tangents(positions.size());
  const std::vector<Affine> palette(view.palette.size());
  const std::vector<float> weights = {0.7f, 0.0f};
  const DeformJob deform{&view, palette, weights, positions, normals, tangents};
  ASSERT_TRUE(deform.validate().ok());
  deform.run(0, view.vertexCount());
  EXPECT_EQ(std::memcmp(positions.data(), staged.positions.data(), positions.size() * sizeof(Float3)), 0);

  std::vector<std::byte, LineAllocator<std::byte>> scratch(clusters.scratchBytes());
  std::vector<int16_t> none(staged.weights.size(), 1);
  ClusterFrameJob job;
  job.clusters = &clusters;
  job.posed = memory.of<std::byte>(1).data();  // with no layer to compute, no pose is looked at
  job.rest = memory.of<uint32_t>(clusters.restWords());
  job.active_layers = 0;
  job.weights = none;
  ASSERT_TRUE(job.validate().ok());
  job.run(0, clusters.count(), scratch);
  EXPECT_EQ(none, std::vector<int16_t>(none.size(), 0));
}
#endif

// In the captured pose one corner of the sheet is folded to a point and one vertex is nowhere: what lies
// there is measured no more.
TEST(ClusterFrame, ARestOfItsOwnGivesTheBitsOfTheStagedFrame) {
  const Asset asset = tests::cookAsset(
      bumpy(45),
      tests::recipeOf({layerOf("a", Measure::kDirectional, {1, 0.2, 0}),
                       layerOf("b", Measure::kArea, {0, 1, 0}), layerOf("c", Measure::kPrincipal, {0, 1, 0}),
                       layerOf("d", Measure::kNone, {1, 0, 0}),
                       layerOf("e", Measure::kDirectional, {0, 0, 1})}));
  const AssetView& view = asset.view();
  Clusters clusters;
  ASSERT_TRUE(clusters.build(view, {.points = 100}).ok());
  std::vector<Float3> rest = tests::evaluate(view, {0.5f}, {}, 1.0f).positions;
  for (Float3& p : rest) {
    if (p.x < 0.2f && p.y < 0.2f) p = {0.1f, 0.1f, 0.0f};
    p = {1.5f * p.x, 1.5f * p.y, 1.5f * p.z};
  }
  rest[view.point_vertex[view.pointCount() / 2]].x = NAN;

  std::vector<Layer> layers(view.layers.begin(), view.layers.end());
  std::vector<std::vector<float>> coefficients;
  size_t left_out = 0;
  for (uint32_t l = 0; l < view.layerCount(); ++l) {
    auto& own = coefficients.emplace_back(layers[l].coefficients.size());
    RecaptureJob{&view, l, rest, 1.5f, own}.run(0, view.triangleCount());
    for (size_t i = 0; i < own.size(); ++i) left_out += own[i] == 0.0f && layers[l].coefficients[i] != 0.0f;
    layers[l].coefficients = own;
  }
  EXPECT_GT(left_out, 20u);
  AssetView own = view;
  own.layers = layers;

  std::vector<uint32_t, LineAllocator<uint32_t>> words(clusters.restWords());
  const ClusterRecaptureJob recapture{&clusters, rest, 1.5f, words};
  ASSERT_TRUE(recapture.validate().ok());
  recapture.run(1, clusters.count());
  recapture.run(0, 1);
  std::vector<std::byte, LineAllocator<std::byte>> scratch(clusters.scratchBytes());
  for (float weight : {0.0f, 0.5f, 1.0f}) {
    const Frame staged = tests::evaluate(own, {weight});
    EXPECT_NE(staged.weights, tests::evaluate(view, {weight}).weights);
    for (Simd simd : available()) {
      std::vector<int16_t> weights(staged.weights.size());
      ClusterFrameJob job;
      job.clusters = &clusters;
      job.posed = reinterpret_cast<const std::byte*>(staged.positions.data());
      job.rest = words;
      job.weights = weights;
      job.simd = simd;
      ASSERT_TRUE(job.validate().ok());
      job.run(0, clusters.count(), scratch);
      EXPECT_EQ(weights, staged.weights) << simdName(simd) << " at " << weight;
    }
  }

  const std::span<uint32_t> all(words);
  EXPECT_FALSE((ClusterRecaptureJob{&clusters, rest, 1.5f, all.subspan(1)}.validate().ok()));
  EXPECT_FALSE((ClusterRecaptureJob{&clusters, rest, 0.0f, all}.validate().ok()));
  EXPECT_FALSE((ClusterRecaptureJob{&clusters, std::span(rest).subspan(1), 1.5f, all}.validate().ok()));
  EXPECT_FALSE((ClusterRecaptureJob{nullptr, rest, 1.5f, all}.validate().ok()));
}

// A host has no vertices for the part that no layer covers; the rings at the border know nothing of it.
TEST(ClusterFrame, WhatIsNoNumberStaysInItsLayer) {
  pipeline::SourceScene scene = tests::sceneOf(tests::sheet(20), [](glm::dvec3 p) { return p; });
  scene.primitives.push_back(scene.primitives[0]);
  for (glm::vec3& p : scene.primitives[1].positions) p.x += 1.0f;
  scene.parts.push_back(scene.parts[0]);
  scene.parts[1].primitive = 1;
  scene.parts[1].mesh = "covered";
  for (uint32_t count : {1u, 2u}) {
    std::vector<pipeline::LayerRecipe> layers(count, tests::axisLayer({1, 0, 0}));
    for (uint32_t l = 0; l < count; ++l) layers[l].name += std::to_string(l), layers[l].meshes = {"covered"};
    const Asset asset = tests::cookAsset(scene, tests::recipeOf(layers));
    const AssetView& view = asset.view();
    ASSERT_LT(view.pointCount(), view.vertexCount());
    std::vector<Float3> posed(view.positions.begin(), view.positions.end());
    for (Float3& p : posed) p = p.x < 0.99f ? Float3{NAN, NAN, NAN} : Float3{0.7f * p.x, p.y, p.z};
    std::vector<float> triangle_q(view.triangleCount()), q(view.pointCount());
    std::vector<int16_t> staged(view.vertexCount() * view.weightStride()), weights(staged.size());
    for (uint32_t l = 0; l < count; ++l) {
      CompressJob{&view, l, posed, 1.0f, triangle_q}.run(0, view.triangleCount());
      SmoothJob{&view, triangle_q, q}.run(0, view.pointCount());
      RespondJob{&view, l, view.layers[l].response, 0.0f, q, staged}.run(0, view.vertexCount());
    }
    Clusters clusters;
    ASSERT_TRUE(clusters.build(view).ok());
    std::vector<std::byte> scratch(clusters.scratchBytes());
    for (Simd simd : available()) {
      ClusterFrameJob job;
      job.clusters = &clusters;
      job.posed = reinterpret_cast<const std::byte*>(posed.data());
      job.weights = weights;
      job.simd = simd;
      ASSERT_TRUE(job.validate().ok());
      job.run(0, clusters.count(), scratch);
      EXPECT_EQ(weights, staged) << count << " " << simdName(simd);
    }
  }
}

TEST(ClusterFrame, EveryPointIsOwnedOnceAndRingsAreWhole) {
  const Asset asset = tests::cookAsset(bumpy(70), tests::recipeOf({tests::axisLayer({1, 0, 0})}));
  const AssetView& view = asset.view();
  Clusters clusters;
  ASSERT_TRUE(clusters.build(view).ok());
  std::multiset<uint32_t> owned;
  uint32_t triangles = 0, slots = 0;
  for (const Cluster& c : clusters.clusters) {
    EXPECT_LE(c.points, kFineClusterPoints);  // so small a sheet is cut fine, for threads
    for (uint32_t s = 0; s < c.vertices; ++s) owned.insert(clusters.words[c.slot_vertex + s]);
    triangles += c.triangles;
    slots += c.slots;
  }
  EXPECT_EQ(owned.size(), view.vertexCount());
  EXPECT_EQ(std::set<uint32_t>(owned.begin(), owned.end()).size(), view.vertexCount());
  // Compact clusters repeat little of their neighbours.
  EXPECT_EQ(clusters.words.capacity(), clusters.words.size());  // an asset's memory holds nothing idle
  EXPECT_LT(triangles, 1.25 * view.triangleCount());
  EXPECT_LT(slots, 1.35 * view.vertexCount());
}

// A sheet, four influences, one layer; a staged frame in fp32 moves 82.
TEST(ClusterFrame, AFrameMovesAtMost42BytesATriangle) {
  pipeline::SourceScene scene = tests::sceneOf(tests::sheet(222), [](glm::dvec3 p) { return p; });
  pipeline::Primitive& primitive = scene.primitives[0];
  scene.rig.palette.assign(98, {});
  scene.parts[0].skinned = true;
  scene.parts[0].palette_count = 98;
  primitive.influences = 4;
  for (const glm::vec3& p : primitive.positions)
    for (uint16_t k = 0; k < 4; ++k) {
      primitive.joints.push_back(static_cast<uint16_t>(94.0f * std::clamp(p.x, 0.0f, 1.0f)) + k);
      primitive.weights.push_back(0.25f);
    }
  const Asset asset = tests::cookAsset(std::move(scene), tests::recipeOf({tests::axisLayer({1, 0.2, 0})}));
  Clusters clusters;
  ASSERT_TRUE(clusters.build(asset.view()).ok());
  const double triangles = asset.view().triangleCount();
  EXPECT_LE(static_cast<double>(clusters.frameBytes(false)), 42.0 * triangles);
  EXPECT_LE(static_cast<double>(clusters.frameBytes(true)), 42.0 * triangles);
  // The weights, the coefficients and half the rings alone are more than this.
  EXPECT_GE(static_cast<double>(clusters.frameBytes(true)), 20.0 * triangles);
}

// Cones of `blades` triangles each around one point, squeezed along x by the morph target.
pipeline::SourceScene fan(uint32_t blades, uint32_t cones) {
  pipeline::Primitive fan;
  fan.positions.push_back({0, 0, 0});
  for (uint32_t cone = 0; cone < cones; ++cone)
    for (uint32_t i = 0; i < blades; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / blades;
      fan.positions.push_back({static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)),
                               0.3f * static_cast<float>(cone)});
      fan.indices.insert(fan.indices.end(),
                         {0u, 1 + cone * blades + i, 1 + cone * blades + (i + 1) % blades});
    }
  return tests::sceneOf(std::move(fan), [](glm::dvec3 p) { return glm::dvec3(0.7 * p.x, p.y, p.z); });
}

TEST(ClusterFrame, APointOfVeryManyTrianglesStillFits) {
  const Asset asset = tests::cookAsset(fan(3000, 1), tests::recipeOf({tests::axisLayer({1, 0, 0})}));
  Clusters clusters;
  ASSERT_TRUE(clusters.build(asset.view()).ok());
  EXPECT_EQ(clusteredWeights(clusters, bestSimd(), {}, 1.0f), tests::evaluate(asset.view(), {1.0f}).weights);
}

template <typename Struct>
Struct sized() {
  Struct out = {};
  out.size = sizeof out;
  return out;
}

// A host's log is warned, and frames are staged.
TEST(ClusterFrame, APointOfTooManyTrianglesIsAWarning) {
  const pipeline::Cooked cooked =
      pipeline::cook(fan(6000, 3), tests::recipeOf({tests::axisLayer({1, 0, 0})}), {});
  std::vector<std::pair<int32_t, std::string>> lines;
  auto host = sized<FurrowContextDesc>();
  host.user = &lines;
  host.log = [](void* user, int32_t severity, const char* message) {
    static_cast<decltype(lines)*>(user)->emplace_back(severity, message);
  };
  FurrowContext* context = nullptr;
  FurrowAsset* asset = nullptr;
  FurrowInstance* instance = nullptr;
  ASSERT_EQ(furrow_context_create(&host, &context, nullptr), FURROW_OK);
  EXPECT_THAT(lines, ElementsAre(Pair(FURROW_LOG_INFO, HasSubstr("cpu tier on"))));
  lines.clear();
  auto file = sized<FurrowAssetDesc>();
  file.bytes = cooked.bytes.data(), file.byte_count = cooked.bytes.size();
  ASSERT_EQ(furrow_asset_create(context, &file, &asset, nullptr), FURROW_OK);
  EXPECT_THAT(lines, ElementsAre(Pair(FURROW_LOG_WARNING, HasSubstr("too many triangles"))));

  auto desc = sized<FurrowInstanceDesc>();
  desc.features = FURROW_KEEP_POSITIONS;
  ASSERT_EQ(furrow_instance_create(asset, &desc, &instance, nullptr), FURROW_OK);
  const Affine identity;
  const float squeezed = 1.0f;
  auto frame = sized<FurrowFrame>();
  frame.palette = identity.m, frame.palette_count = 1;
  frame.morph_weights = &squeezed, frame.morph_count = 1;
  auto report = sized<FurrowFrameReport>();
  ASSERT_EQ(furrow_instance_frame(instance, &frame, &report, nullptr), FURROW_OK);
  EXPECT_TRUE(report.computed && !report.clustered);
  Asset same;
  ASSERT_TRUE(same.load(cooked.bytes).ok());
  const std::vector<int16_t> expected = tests::evaluate(same.view(), {squeezed}).weights;
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), furrow_instance_weights(instance)));
  furrow_instance_release(instance);
  furrow_asset_release(asset);
  furrow_context_release(context);
}

TEST(ClusterFrame, RefusesWhatDoesNotFit) {
  const Asset asset = tests::cookAsset(bumpy(4), tests::recipeOf({tests::axisLayer({1, 0, 0})}));
  Clusters clusters;
  EXPECT_FALSE(ClusterFrameJob().validate().ok());
  ASSERT_TRUE(clusters.build(asset.view()).ok());
  std::vector<int16_t> weights(asset.view().vertexCount() * asset.view().weightStride());
  std::vector<Float3> posed(asset.view().vertexCount());
  ClusterFrameJob job;
  job.clusters = &clusters;
  job.posed = reinterpret_cast<const std::byte*>(posed.data());
  job.weights = weights;
  EXPECT_TRUE(job.validate().ok());
  job.scale = 0.0f;
  EXPECT_FALSE(job.validate().ok());
  job.scale = 1.0f;
  job.weights = std::span(weights).first(3);
  EXPECT_FALSE(job.validate().ok());
  job.weights = weights;
  job.posed = nullptr;
  EXPECT_FALSE(job.validate().ok());
}

}  // namespace
