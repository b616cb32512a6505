#include "pipeline/scene/posing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

#include "pipeline/import/import.h"
#include "tests/unit/gltf_builder.h"

namespace furrow::pipeline {
namespace {

std::filesystem::path corpus(const std::string& file) {
  return std::filesystem::path(FURROW_CORPUS) / file;
}

#define SKIP_WITHOUT(file) \
  if (!std::filesystem::exists(corpus(file))) GTEST_SKIP() << corpus(file) << " is not here"

void expectNear(const glm::dvec3& actual, const glm::dvec3& expected, double tolerance = 1e-6) {
  EXPECT_NEAR(actual.x, expected.x, tolerance);
  EXPECT_NEAR(actual.y, expected.y, tolerance);
  EXPECT_NEAR(actual.z, expected.z, tolerance);
}

std::vector<glm::dvec3> poseAt(const SourceScene& scene, const Part& part, size_t clip, double time) {
  Pose pose = defaultPose(scene.rig);
  applyClip(scene.rig, scene.rig.clips[clip], time, pose);
  return posePart(scene, part, evaluate(scene.rig, pose));
}

// The specification's formulas once more, on plain arrays (column-major matrices) and by recursion.
using Matrix = std::array<double, 16>;

Matrix multiply(const Matrix& a, const Matrix& b) {
  Matrix out{};
  for (size_t column = 0; column < 4; ++column)
    for (size_t row = 0; row < 4; ++row)
      for (size_t k = 0; k < 4; ++k) out[4 * column + row] += a[4 * k + row] * b[4 * column + k];
  return out;
}

Matrix localOf(const Node& node) {
  Matrix m{};
  if (node.has_matrix) {
    for (size_t i = 0; i < 16; ++i) m[i] = node.matrix[static_cast<int>(i / 4)][static_cast<int>(i % 4)];
    return m;
  }
  const double x = node.rotation.x, y = node.rotation.y, z = node.rotation.z, w = node.rotation.w;
  const double sx = node.scale.x, sy = node.scale.y, sz = node.scale.z;
  return {sx * (1 - 2 * (y * y + z * z)),
          sx * 2 * (x * y + z * w),
          sx * 2 * (x * z - y * w),
          0,
          sy * 2 * (x * y - z * w),
          sy * (1 - 2 * (x * x + z * z)),
          sy * 2 * (y * z + x * w),
          0,
          sz * 2 * (x * z + y * w),
          sz * 2 * (y * z - x * w),
          sz * (1 - 2 * (x * x + y * y)),
          0,
          node.translation.x,
          node.translation.y,
          node.translation.z,
          1};
}

Matrix worldOf(const std::vector<Node>& nodes, uint32_t n) {
  const Matrix local = localOf(nodes[n]);
  return nodes[n].parent == kNoIndex ? local : multiply(worldOf(nodes, nodes[n].parent), local);
}

glm::dquat slerpOf(const std::array<double, 4>& a, std::array<double, 4> b, double t) {
  double dot = 0.0;
  for (size_t i = 0; i < 4; ++i) dot += a[i] * b[i];
  if (dot < 0.0)
    for (double& c : b) c = -c;
  const double angle = std::acos(std::min(std::abs(dot), 1.0));
  const double p = angle < 1e-9 ? 1 - t : std::sin((1 - t) * angle) / std::sin(angle);
  const double q = angle < 1e-9 ? t : std::sin(t * angle) / std::sin(angle);
  return {p * a[3] + q * b[3], p * a[0] + q * b[0], p * a[1] + q * b[1], p * a[2] + q * b[2]};
}

// Nodes of the rig under a clip whose channels are all LINEAR translations, rotations and scales.
std::vector<Node> linearNodes(const Rig& rig, const Clip& clip, double time) {
  std::vector<Node> nodes = rig.nodes;
  for (const Channel& channel : clip.channels) {
    EXPECT_EQ(channel.interpolation, Interpolation::kLinear);
    const std::vector<float>& times = channel.times;
    size_t k = 0;
    while (k + 2 < times.size() && time >= times[k + 1]) ++k;
    const size_t next = std::min(k + 1, times.size() - 1);
    const double t =
        next == k ? 0.0
                  : std::clamp((time - times[k]) / (static_cast<double>(times[next]) - times[k]), 0.0, 1.0);
    const auto key = [&](size_t i, size_t width) {
      std::array<double, 4> out{};
      double square = 0.0;
      for (size_t c = 0; c < width; ++c) {
        out[c] = channel.values[i * width + c];
        square += out[c] * out[c];
      }
      // Exporters round quaternions; what is slerped is their direction.
      for (size_t c = 0; c < width && width == 4; ++c) out[c] /= std::sqrt(square);
      return out;
    };
    if (channel.path == ChannelPath::kRotation) {
      nodes[channel.node].rotation = slerpOf(key(k, 4), key(next, 4), t);
      continue;
    }
    const std::array<double, 4> a = key(k, 3), b = key(next, 3);
    glm::dvec3& target =
        channel.path == ChannelPath::kScale ? nodes[channel.node].scale : nodes[channel.node].translation;
    target = {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])};
  }
  return nodes;
}

void expectSkinned(const SourceScene& scene, const std::vector<Node>& nodes,
                   const std::vector<glm::dvec3>& posed) {
  const Part& part = scene.parts.at(0);
  const Primitive& primitive = scene.primitives.at(part.primitive);
  ASSERT_TRUE(part.skinned);
  ASSERT_EQ(posed.size(), primitive.positions.size());
  std::vector<Matrix> palette;
  for (uint32_t j = 0; j < part.palette_count; ++j) {
    const PaletteEntry& entry = scene.rig.palette[part.palette_begin + j];
    Matrix inverse_bind{};
    for (size_t i = 0; i < 16; ++i)
      inverse_bind[i] = entry.inverse_bind[static_cast<int>(i / 4)][static_cast<int>(i % 4)];
    palette.push_back(multiply(worldOf(nodes, entry.node), inverse_bind));
  }
  for (size_t v = 0; v < posed.size(); ++v) {
    Matrix blend{};
    for (size_t i = v * primitive.influences; i < (v + 1) * primitive.influences; ++i)
      for (size_t c = 0; c < 16; ++c) blend[c] += primitive.weights[i] * palette[primitive.joints[i]][c];
    const glm::dvec3 p(primitive.positions[v]);
    glm::dvec3 expected;
    for (int row = 0; row < 3; ++row) {
      const size_t r = static_cast<size_t>(row);
      expected[row] = blend[r] * p.x + blend[4 + r] * p.y + blend[8 + r] * p.z + blend[12 + r];
    }
    expectNear(posed[v], expected, 1e-9);
  }
}

TEST(Posing, SimpleSkinBendsAsWorkedByHand) {
  SKIP_WITHOUT("skinned/simple_skin/simple_skin.gltf");
  const SourceScene scene = import(corpus("skinned/simple_skin/simple_skin.gltf"));
  const Part& part = scene.parts.at(0);
  // Joint matrices at rest: both move by (-0.5, 0, 0).
  const auto rest = posePart(scene, part, evaluate(scene.rig, defaultPose(scene.rig)));
  expectNear(rest[9], {0.5, 2.0, 0.0});
  // At 1 s the upper joint, at (0, 1, 0), is turned by 90 degrees about z.
  const auto bent = poseAt(scene, part, 0, 1.0);
  expectNear(bent[0], {-0.5, 0.0, 0.0});
  expectNear(bent[4], {-0.25, 0.75, 0.0});
  expectNear(bent[9], {-1.0, 1.5, 0.0});
  // Half-way to the key at 0.5 s (0.383, 0.924) the turn is half of that key's.
  const double angle = std::atan2(0.383, 0.924);
  const double c = std::cos(angle), s = std::sin(angle);
  expectNear(poseAt(scene, part, 0, 0.25)[9], {0.5 * c - s, 1.0 + 0.5 * s + c, 0.0});
  // Before and behind the clip its ends hold.
  expectNear(poseAt(scene, part, 0, -3.0)[9], rest[9]);
  expectNear(poseAt(scene, part, 0, 99.0)[9], rest[9]);
  expectSkinned(scene, linearNodes(scene.rig, scene.rig.clips[0], 3.3), poseAt(scene, part, 0, 3.3));
}

TEST(Posing, CesiumManWalksAsTheSpecificationSays) {
  SKIP_WITHOUT("skinned/CesiumMan.glb");
  const SourceScene scene = import(corpus("skinned/CesiumMan.glb"));
  expectSkinned(scene, scene.rig.nodes,
                posePart(scene, scene.parts[0], evaluate(scene.rig, defaultPose(scene.rig))));
  for (const double time : {0.0, 0.31, 1.0, scene.rig.clips.at(0).duration})
    expectSkinned(scene, linearNodes(scene.rig, scene.rig.clips[0], time),
                  poseAt(scene, scene.parts[0], 0, time));
}

TEST(Posing, SimpleMorphMovesItsTip) {
  SKIP_WITHOUT("morph/SimpleMorph/SimpleMorph.gltf");
  const SourceScene scene = import(corpus("morph/SimpleMorph/SimpleMorph.gltf"));
  const Part& part = scene.parts.at(0);
  // The mesh's own weights are 0.5 and 0.5; targets move the tip by (-1, 1, 0) and (1, 1, 0).
  expectNear(posePart(scene, part, evaluate(scene.rig, defaultPose(scene.rig)))[2], {0.5, 1.5, 0.0});
  expectNear(poseAt(scene, part, 0, 1.5)[2], {1.0, 2.0, 0.0});
  expectNear(poseAt(scene, part, 0, 3.0)[2], {-0.5, 1.5, 0.0});
  expectNear(poseAt(scene, part, 0, 1.5)[1], {1.0, 0.0, 0.0});
}

TEST(Posing, CubicSplinesAndRotationsOfAllAnimations) {
  SKIP_WITHOUT("skinned/03_all_animations/03_all_animations.gltf");
  const SourceScene scene = import(corpus("skinned/03_all_animations/03_all_animations.gltf"));
  const Rig& rig = scene.rig;
  ASSERT_EQ(rig.clips.size(), 3u);
  const auto nodeAt = [&](size_t clip, double time, uint32_t node) {
    Pose pose = defaultPose(rig);
    applyClip(rig, rig.clips[clip], time, pose);
    return pose.nodes[node];
  };
  // No tangents: 2 (3 u^2 - 2 u^3).
  expectNear(nodeAt(0, 0.25, 2).translation, {0.3125, 0.0, 0.0});
  expectNear(nodeAt(0, 1.0, 2).translation, {2.0, 0.0, 0.0});
  expectNear(nodeAt(1, 1.5, 3).scale, {1.5, 2.5, 1.5});
  // Half a turn about y in a second, so that 0.5 s is a quarter.
  const glm::dquat quarter = nodeAt(2, 0.5, 1).rotation;
  EXPECT_NEAR(std::abs(quarter.y), std::numbers::sqrt2 / 2, 1e-6);
  EXPECT_NEAR(std::abs(quarter.w), std::numbers::sqrt2 / 2, 1e-6);
  // The cube hangs on the sphere, above which it stands by 4.
  const auto cube =
      std::find_if(scene.parts.begin(), scene.parts.end(), [](const Part& p) { return p.mesh == "Cube"; });
  ASSERT_NE(cube, scene.parts.end());
  const auto rest = posePart(scene, *cube, evaluate(rig, defaultPose(rig)));
  const auto raised = poseAt(scene, *cube, 0, 1.0);
  for (size_t v = 0; v < rest.size(); ++v) {
    expectNear(rest[v],
               glm::dvec3(scene.primitives[cube->primitive].positions[v]) + glm::dvec3(0.0, 4.0, 0.0));
    expectNear(raised[v], rest[v] + glm::dvec3(2.0, 0.0, 0.0));
  }
}

Rig oneNode(Channel channel) {
  Rig rig;
  rig.nodes.resize(1);
  rig.morphs = {{"a", 0, 0, 0.25}, {"b", 0, 1, 0.5}};
  rig.clips.push_back({"clip", static_cast<double>(channel.times.back()), {std::move(channel)}});
  return rig;
}

Pose poseOf(const Rig& rig, double time) {
  Pose pose = defaultPose(rig);
  applyClip(rig, rig.clips[0], time, pose);
  return pose;
}

TEST(Posing, CubicSplineWithTangentsByHand) {
  // Keys 0 and 1 at 0 s and 2 s, out-tangent 1, in-tangents t: at half-way 2 * 0.125 * 1 + 0.5 * 1 - 2 *
  // 0.125
  // * t.
  const Rig rig = oneNode({0,
                           ChannelPath::kTranslation,
                           Interpolation::kCubicSpline,
                           {0.0f, 2.0f},
                           {9, 9, 9, 0, 0, 0, 1, 1, 1, /**/ 0, 4, -2, 1, 1, 1, 9, 9, 9}});
  expectNear(poseOf(rig, 1.0).nodes[0].translation, {0.75, -0.25, 1.25}, 1e-12);
  expectNear(poseOf(rig, -1.0).nodes[0].translation, glm::dvec3(0.0), 0.0);
  expectNear(poseOf(rig, 2.0).nodes[0].translation, glm::dvec3(1.0), 0.0);
}

TEST(Posing, StepHoldsTheKeyBefore) {
  const Rig rig = oneNode({0, ChannelPath::kScale, Interpolation::kStep, {1.0f, 2.0f}, {1, 2, 3, 4, 5, 6}});
  expectNear(poseOf(rig, 1.999).nodes[0].scale, {1, 2, 3}, 0.0);
  expectNear(poseOf(rig, 2.0).nodes[0].scale, {4, 5, 6}, 0.0);
}

TEST(Posing, WeightsOfEveryInterpolation) {
  const Rig linear = oneNode({0, ChannelPath::kWeights, Interpolation::kLinear, {0.0f, 4.0f}, {0, 1, 1, 0}});
  EXPECT_THAT(poseOf(linear, 1.0).morph_weights, ::testing::ElementsAre(0.25, 0.75));
  const Rig cubic = oneNode({0,
                             ChannelPath::kWeights,
                             Interpolation::kCubicSpline,
                             {0.0f, 1.0f},
                             {0, 0, 0, 0, 0, 8, /**/ 0, 0, 1, 1, 0, 0}});
  EXPECT_THAT(poseOf(cubic, 0.5).morph_weights, ::testing::ElementsAre(0.5, 1.5));
  EXPECT_THAT(defaultPose(linear).morph_weights, ::testing::ElementsAre(0.25, 0.5));
}

TEST(Posing, RotationTakesTheShorterWay) {
  // 0 and 90 degrees about z, the second with its sign turned.
  const float h = static_cast<float>(std::numbers::sqrt2 / 2);
  const Rig rig =
      oneNode({0, ChannelPath::kRotation, Interpolation::kLinear, {0.0f, 1.0f}, {0, 0, 0, 1, 0, 0, -h, -h}});
  const glm::dquat q = poseOf(rig, 0.5).nodes[0].rotation;
  EXPECT_NEAR(q.z / q.w, std::tan(std::numbers::pi / 8), 1e-7);
}

TEST(Posing, ChildBeforeParentAndNegativeScale) {
  test::GltfBuilder file;
  file.add<float>({1, 2, 3, 2, 2, 3, 1, 4, 3}, "VEC3", 3);
  // The child (first in the file) scales by (1, 2, 1), its parent mirrors x, turns by 90 degrees about z and
  // moves.
  const std::string members = R"("nodes":[{"mesh":0,"scale":[1,2,1],"translation":[0,0,10]},
    {"children":[0],"scale":[-1,1,1],"rotation":[0,0,0.70710678118654752,0.70710678118654752],"translation":[5,0,0]},
    {"mesh":0,"matrix":[0,1,0,0,-1,0,0,0,0,0,1,0,7,0,0,1]}],"scenes":[{"nodes":[1,2]}],"scene":0,
    "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}])";
  const SourceScene scene = import(test::writeFile("mirror.glb", file.glb(members)));
  ASSERT_EQ(scene.primitives.size(), 1u);
  ASSERT_EQ(scene.parts.size(), 2u);
  const PosedRig rest = evaluate(scene.rig, defaultPose(scene.rig));
  // (1, 2, 3) -> (1, 4, 13) -> (-1, 4, 13) -> (-4, -1, 13) -> (1, -1, 13)
  expectNear(posePart(scene, scene.parts[0], rest)[0], {1, -1, 13}, 1e-12);
  // The matrix turns by 90 degrees about z and moves by 7: (-2, 1, 3) + (7, 0, 0).
  expectNear(posePart(scene, scene.parts[1], rest)[0], {5, 1, 3}, 1e-12);
}

// A root, two joints below it and a mesh of its own beside them; inverse bind matrices with a scale.
TEST(Posing, AWholeModelThatIsScaledIsToldFromScaledJoints) {
  Rig rig;
  rig.nodes.resize(4);
  rig.nodes[0].scale = glm::dvec3(0.01);
  for (uint32_t n = 1; n < 4; ++n) rig.nodes[n].parent = n == 2 ? 1 : 0;
  for (uint32_t n = 1; n < 4; ++n)
    rig.palette.push_back({n, glm::scale(glm::dmat4(1.0), glm::dvec3(n == 3 ? 1.0 : 100.0))});
  const auto scaleOf = [&](const auto& change) {
    Pose pose = defaultPose(rig);
    change(pose.nodes);
    return wholeScale(rig, evaluate(rig, pose));
  };
  using Nodes = std::vector<Node>;
  const glm::dquat turn = glm::angleAxis(1.0, glm::normalize(glm::dvec3(1, 2, 3)));
  EXPECT_EQ(scaleOf([](Nodes&) {}), 1.0);
  EXPECT_EQ(scaleOf([&](Nodes& nodes) { nodes[0].rotation = nodes[2].rotation = turn; }), 1.0);
  EXPECT_NEAR(scaleOf([&](Nodes& nodes) {
                nodes[0].scale = glm::dvec3(0.005);
                nodes[0].rotation = nodes[1].rotation = turn;
                nodes[2].translation = {5, 0, 0};
              }),
              0.5, 1e-12);
  EXPECT_NEAR(scaleOf([](Nodes& nodes) { nodes[1].scale = nodes[3].scale = glm::dvec3(3.0); }), 3.0, 1e-12);
  EXPECT_NEAR(scaleOf([](Nodes& nodes) { nodes[0].scale = glm::dvec3(-0.02); }), 2.0, 1e-12);
  EXPECT_EQ(scaleOf([](Nodes& nodes) { nodes[1].scale = glm::dvec3(0.5); }), 1.0);
  EXPECT_EQ(scaleOf([](Nodes& nodes) { nodes[0].scale = {0.01, 0.005, 0.01}; }), 1.0);
  EXPECT_EQ(scaleOf([](Nodes& nodes) { nodes[0].scale = glm::dvec3(0.0); }), 1.0);
}

TEST(Posing, MorphsMoveBeforeTheSkinTurns) {
  SourceScene scene;
  scene.rig.nodes.resize(2);
  scene.rig.nodes[0].rotation = {std::numbers::sqrt2 / 2, 0.0, 0.0, std::numbers::sqrt2 / 2};
  scene.rig.nodes[1].translation = {0.0, 0.0, 8.0};
  scene.rig.palette = {{0, glm::dmat4(1.0)}, {1, glm::dmat4(1.0)}};
  scene.rig.morphs = {{"m", 0, 0, 0.5}};
  Primitive primitive;
  primitive.positions = {{1, 0, 0}, {0, 0, 0}};
  primitive.influences = 4;
  primitive.joints = {0, 1, 0, 0, /**/ 1, 0, 0, 0};
  primitive.weights = {0.75f, 0.25f, 0, 0, /**/ 1, 0, 0, 0};
  primitive.morphs = {{{0}, {{2, 0, 0}}, {}}};
  scene.primitives.push_back(primitive);
  Part part;
  part.skinned = true;
  part.palette_count = 2;
  scene.parts.push_back(part);
  const auto posed = posePart(scene, part, evaluate(scene.rig, defaultPose(scene.rig)));
  // (1, 0, 0) + 0.5 (2, 0, 0) = (2, 0, 0); 0.75 (0, 2, 0) + 0.25 (2, 0, 8).
  expectNear(posed[0], {0.5, 1.5, 2.0}, 1e-12);
  expectNear(posed[1], {0.0, 0.0, 8.0}, 1e-12);
}

}  // namespace
}  // namespace furrow::pipeline
