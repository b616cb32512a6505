// Poses of every kind, by known answers: skinning, key frames, streams, occlusion, fewer influences.

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "furrow/jobs.h"
#include "furrow/pose.h"

namespace {

using namespace furrow;

// Vertices without triangles.
struct Cloud {
  std::vector<Float3> positions, normals;
  std::vector<Float4> tangents;
  std::vector<uint16_t> joints, weights;
  std::vector<PaletteEntry> palette;
  std::vector<Morph> morphs;
  AssetView view;

  explicit Cloud(size_t joint_count) : palette(joint_count) {}
  void add(Float3 p, std::vector<std::pair<uint16_t, uint16_t>> influences) {
    positions.push_back(p);
    normals.push_back({0, 1, 0});
    tangents.push_back({1, 0, 0, 1});
    for (auto [joint, weight] : influences) joints.push_back(joint), weights.push_back(weight);
    view.influences = static_cast<uint32_t>(influences.size());
    view.positions = positions, view.normals = normals, view.tangents = tangents;
    view.joints = joints, view.weights = weights, view.palette = palette, view.morphs = morphs;
  }
};

struct Posed {
  std::vector<Float3> positions, normals;
  std::vector<Float4> tangents;
};

Posed pose(const Cloud& cloud, const std::vector<Affine>& palette, Skinning skinning) {
  Posed out;
  out.positions.resize(cloud.positions.size());
  out.normals.resize(cloud.positions.size());
  out.tangents.resize(cloud.positions.size());
  std::vector<JointMotion> motions(palette.size());
  splitPalette(palette, motions);
  const std::vector<float> weights(cloud.morphs.size(), 0.0f);
  const DeformJob job{&cloud.view, palette,      weights,  out.positions,
                      out.normals, out.tangents, skinning, motions};
  const Status status = job.validate();
  EXPECT_TRUE(status.ok()) << status.message;
  job.run(0, cloud.view.vertexCount());
  return out;
}

void expectNear(Float3 a, Float3 b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

// About the x axis.
Affine twist(double angle, Float3 move = {0, 0, 0}) {
  const auto c = static_cast<float>(std::cos(angle)), s = static_cast<float>(std::sin(angle));
  return {{1, 0, 0, move.x, 0, c, -s, move.y, 0, s, c, move.z}};
}

TEST(DualQuaternion, ATwistKeepsItsRadius) {
  Cloud cloud(2);
  cloud.add({0.3f, 1, 0}, {{0, 32768}, {1, 32767}});
  for (double degrees : {30.0, 90.0, 150.0, 179.0, -120.0}) {
    const double angle = degrees * std::numbers::pi / 180.0;
    const std::vector<Affine> palette = {twist(0.0), twist(angle)};
    // Linear blending shrinks the radius to cos(angle / 2) [Kavan et al.]; dual quaternions turn by half.
    const Posed linear = pose(cloud, palette, Skinning::kLinear);
    EXPECT_NEAR(std::hypot(linear.positions[0].y, linear.positions[0].z), std::cos(angle / 2), 2e-5);
    const Posed dual = pose(cloud, palette, Skinning::kDualQuaternion);
    const auto c = static_cast<float>(std::cos(angle / 2)), s = static_cast<float>(std::sin(angle / 2));
    expectNear(dual.positions[0], {0.3f, c, s}, 1e-4);  // half a unorm16 step at 179 degrees
    expectNear(dual.normals[0], {0, c, s}, 1e-4);
    expectNear({dual.tangents[0].x, dual.tangents[0].y, dual.tangents[0].z}, {1, 0, 0}, 1e-5);
  }
}

// Half way along a screw: half the angle, half the way along its axis, wherever the axis lies.
TEST(DualQuaternion, AScrewIsHalved) {
  Cloud cloud(2);
  cloud.add({0, 3, 0}, {{0, 32768}, {1, 32767}});
  // A quarter turn about the line y = 2, z = 0 along x, and 0.8 along it.
  Affine screw = twist(std::numbers::pi / 2, {0.8f, 2.0f, -2.0f});
  const Posed dual = pose(cloud, {Affine(), screw}, Skinning::kDualQuaternion);
  const float r = std::sqrt(0.5f);
  expectNear(dual.positions[0], {0.4f, 2.0f + r, r}, 5e-5);
}

TEST(DualQuaternion, OneJointMovesByItsMatrixWhateverItIs) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> any(-1.5f, 1.5f);
  Cloud cloud(1);
  for (int i = 0; i < 20; ++i) cloud.add({any(random), any(random), any(random)}, {{0, 65535}});
  for (int i = 0; i < 50; ++i) {
    std::vector<Affine> palette(1);
    for (float& value : palette[0].m) value = any(random);  // scale, shear and, every second time, a mirror
    if (i == 0) palette[0] = {{2, 0, 0, 1, 0, 2, 0, 1, 0, 0, 2, 1}};
    if (i == 1) palette[0] = {{-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    if (i == 2) palette[0] = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0}};    // flattens
    if (i == 3) palette[0] = {{1, 0, 0, 5, 0, -1, 0, 0, 0, 0, -1, 0}};  // half a turn
    const Posed linear = pose(cloud, palette, Skinning::kLinear);
    const Posed dual = pose(cloud, palette, Skinning::kDualQuaternion);
    for (size_t v = 0; v < cloud.positions.size(); ++v) {
      expectNear(dual.positions[v], linear.positions[v], 5e-6);
      if (i != 2) expectNear(dual.normals[v], linear.normals[v], 2e-4);
    }
  }
}

// A joint that swells about its own place: the blend is the linear one.
TEST(DualQuaternion, ScaledJointsBlendAsLinearOnesDo) {
  Cloud cloud(2);
  cloud.add({1.5f, 0.5f, 0}, {{0, 16384}, {1, 49151}});
  const std::vector<Affine> palette = {Affine(), {{2, 0, 0, -1, 0, 2, 0, 0, 0, 0, 2, 0}}};
  expectNear(pose(cloud, palette, Skinning::kDualQuaternion).positions[0],
             pose(cloud, palette, Skinning::kLinear).positions[0], 1e-6);
}

TEST(DualQuaternion, FramesAreOrthonormal) {
  Cloud cloud(3);
  std::mt19937 random(5);
  std::uniform_real_distribution<float> any(-1, 1);
  for (int i = 0; i < 50; ++i)
    cloud.add({any(random), any(random), any(random)}, {{0, 30000}, {1, 20000}, {2, 15535}});
  std::vector<Affine> palette(3);
  for (size_t j = 0; j < 3; ++j) {
    palette[j] = twist(2.0 * static_cast<double>(any(random)));
    palette[j].m[0] = 1.3f, palette[j].m[1] = 0.2f;
  }
  for (Skinning skinning : {Skinning::kLinear, Skinning::kDualQuaternion}) {
    const Posed out = pose(cloud, palette, skinning);
    for (size_t v = 0; v < out.normals.size(); ++v) {
      const Float3 n = out.normals[v];
      const Float4 t = out.tangents[v];
      EXPECT_NEAR(n.x * n.x + n.y * n.y + n.z * n.z, 1.0f, 1e-6);
      EXPECT_NEAR(t.x * t.x + t.y * t.y + t.z * t.z, 1.0f, 1e-6);
      EXPECT_NEAR(n.x * t.x + n.y * t.y + n.z * t.z, 0.0f, 1e-6);
    }
  }
}

TEST(Influences, TheStrongestStayAndFillUp) {
  Cloud cloud(5);
  cloud.add({0, 0, 0}, {{4, 10000}, {1, 30000}, {2, 20000}, {3, 5535}});
  cloud.add({0, 0, 0}, {{0, 65535}, {1, 0}, {2, 0}, {3, 0}});
  cloud.add({0, 0, 0}, {{0, 16384}, {1, 16384}, {2, 16384}, {3, 16383}});
  std::vector<uint16_t> joints(6), weights(6);
  const InfluencesJob job{&cloud.view, 2, joints, weights};
  ASSERT_TRUE(job.validate().ok());
  job.run(0, 3);
  EXPECT_EQ(joints, (std::vector<uint16_t>{1, 2, 0, 1, 0, 1}));
  EXPECT_EQ(weights, (std::vector<uint16_t>{39321, 26214, 65535, 0, 32768, 32767}));
  EXPECT_FALSE((InfluencesJob{&cloud.view, 5, joints, weights}).validate().ok());
  EXPECT_FALSE((InfluencesJob{&cloud.view, 0, joints, weights}).validate().ok());
  EXPECT_FALSE((InfluencesJob{&cloud.view, 3, joints, weights}).validate().ok());
}

TEST(Influences, AllOfThemChangeNoPose) {
  Cloud cloud(3);
  cloud.add({1, 2, 3}, {{2, 35535}, {0, 20000}, {1, 10000}});
  std::vector<uint16_t> joints(3), weights(3);
  InfluencesJob{&cloud.view, 3, joints, weights}.run(0, 1);
  EXPECT_EQ(joints, cloud.joints);
  EXPECT_EQ(weights, cloud.weights);
}

std::span<const std::byte> bytesOf(const auto& values) {
  return std::as_bytes(std::span(values));
}

TEST(Pose, KeyFramesLinearAndQuadratic) {
  const std::vector<Float3> a = {{0, 1, 2}, {3, 4, 5}}, b = {{1, 1, 4}, {3, 8, 1}};
  std::vector<Float3> out(2);
  PoseJob job;
  job.from.bytes = bytesOf(a), job.to.bytes = bytesOf(b), job.out = out;
  const auto at = [&](float time, KeyCurve curve) {
    job.time = time, job.curve = curve;
    EXPECT_TRUE(job.validate().ok());
    job.run(0, 2);
    return out;
  };
  expectNear(at(0.5f, KeyCurve::kLinear)[0], {0.5f, 1, 3}, 0);
  expectNear(at(0.5f, KeyCurve::kQuadratic)[0], {0.25f, 1, 2.5f}, 0);
  expectNear(at(0.5f, KeyCurve::kQuadratic)[1], {3, 5, 4}, 0);
  for (KeyCurve curve : {KeyCurve::kLinear, KeyCurve::kQuadratic}) {
    expectNear(at(0.0f, curve)[1], a[1], 0);
    expectNear(at(1.0f, curve)[1], b[1], 0);
  }
}

TEST(Pose, NormalsOfKeyFramesAreUnit) {
  const std::vector<Float3> a = {{1, 0, 0}, {1, 0, 0}}, b = {{0, 0, 1}, {-1, 0, 0}};
  std::vector<Float3> out(2);
  PoseJob job;
  job.from.bytes = bytesOf(a), job.to.bytes = bytesOf(b), job.time = 0.5f, job.unit = true, job.out = out;
  job.run(0, 2);
  const float r = std::sqrt(0.5f);
  expectNear(out[0], {r, 0, r}, 1e-7);
  expectNear(out[1], {0, 1, 0}, 0);
}

TEST(Pose, AnyStrideOffsetAndOrder) {
  for (size_t stride : {size_t{12}, size_t{13}, size_t{32}})
    for (size_t offset : {size_t{0}, size_t{5}}) {
      std::vector<std::byte> buffer(offset + 2 * stride + sizeof(Float3));  // exactly three elements
      for (size_t i = 0; i < 3; ++i) {
        const Float3 p = {static_cast<float>(i), 10.0f + static_cast<float>(i), 0.5f};
        std::memcpy(&buffer[offset + i * stride], &p, sizeof p);
      }
      const std::vector<uint32_t> element = {2, kAbsent, 0, 2};
      std::vector<Float3> out(4);
      PoseJob job;
      job.from = {buffer, offset, stride, VertexFormat::kFloat3};
      EXPECT_EQ(job.from.count(), 3u);
      job.element = element, job.out = out;
      ASSERT_TRUE(job.validate().ok());
      job.run(0, 2);
      job.run(2, 4);
      expectNear(out[0], {2, 12, 0.5f}, 0);
      EXPECT_TRUE(std::isnan(out[1].x));
      expectNear(out[2], {0, 10, 0.5f}, 0);
      expectNear(out[3], {2, 12, 0.5f}, 0);
      out[1] = {7, 7, 7};
      job.patch = true;  // another mesh has posed it
      job.run(0, 4);
      expectNear(out[1], {7, 7, 7}, 0);
      expectNear(out[3], {2, 12, 0.5f}, 0);
      const std::vector<uint32_t> beyond = {3, 0, 0, 0};
      job.element = beyond;
      EXPECT_FALSE(job.validate().ok());
      job.element = {};
      EXPECT_FALSE(job.validate().ok());  // four wanted, three there
      job.from.stride = 11;
      EXPECT_FALSE(job.validate().ok());
    }
}

TEST(Pose, EveryHalf) {
  // All 65536 of them; those that are finite against their definition.
  std::vector<uint16_t> halves(3 * 65536);
  for (uint32_t i = 0; i < 65536; ++i)
    halves[3 * i] = halves[3 * i + 1] = halves[3 * i + 2] = static_cast<uint16_t>(i);
  std::vector<Float3> out(65536);
  PoseJob job;
  job.from = {bytesOf(halves), 0, 6, VertexFormat::kHalf3};
  job.out = out;
  ASSERT_TRUE(job.validate().ok());
  job.run(0, 65536);
  for (uint32_t i = 0; i < 65536; ++i) {
    const uint32_t exponent = i >> 10 & 31, mantissa = i & 1023;
    const double sign = i & 0x8000 ? -1.0 : 1.0;
    if (exponent == 31) {
      EXPECT_EQ(std::isnan(out[i].x), mantissa != 0);
      if (mantissa == 0) {
        EXPECT_EQ(out[i].y, sign * std::numeric_limits<double>::infinity());
      }
      continue;
    }
    const double value = exponent == 0 ? std::ldexp(mantissa, -24)
                                       : std::ldexp(1024 + mantissa, static_cast<int>(exponent) - 25);
    EXPECT_EQ(out[i].x, sign * value);
    EXPECT_EQ(out[i].z, sign * value);
    EXPECT_EQ(std::signbit(out[i].y), sign < 0);
  }
}

TEST(Occlusion, IsCarriedAlongWithTheMorph) {
  Cloud cloud(1);
  const std::vector<uint32_t> moved = {1, 3};
  for (int m = 0; m < 3; ++m) cloud.morphs.push_back({"", 0.0f, 1.0f, 1.0f, moved, {}, {}});
  for (int i = 0; i < 4; ++i) cloud.add({0, 0, 0}, {{0, 65535}});
  const std::vector<float> rest = {1.0f, 0.75f, 0.5f, 0.25f}, first = {-0.5f, 0.25f}, second = {0.5f, -0.5f};
  const std::vector<std::span<const float>> deltas = {first, second, {}};
  std::vector<float> out(4);
  const auto at = [&](std::vector<float> weights) {
    const OcclusionJob job{&cloud.view, weights, rest, deltas, out};
    EXPECT_TRUE(job.validate().ok());
    job.run(0, 3);
    job.run(3, 4);
    return out;
  };
  EXPECT_EQ(at({0, 0, 0}), rest);
  EXPECT_EQ(at({1, 0, 1}), (std::vector<float>{1.0f, 0.25f, 0.5f, 0.5f}));
  EXPECT_EQ(at({0.5f, 1, 0}), (std::vector<float>{1.0f, 1.0f, 0.5f, 0.0f}));  // clamped both ways
  const std::vector<float> weights(2);
  EXPECT_FALSE((OcclusionJob{&cloud.view, weights, rest, deltas, out}).validate().ok());
}

// The expression order of skinning, written out: every instruction set must give these positions to the bit.
Float3 skinned(const Cloud& cloud, const std::vector<Affine>& palette, size_t v, double* normal) {
  float m[12] = {};
  const uint32_t influences = cloud.view.influences;
  for (uint32_t k = 0; k < influences; ++k) {
    const float w = static_cast<float>(cloud.view.weights[v * influences + k]) * (1.0f / 65535.0f);
    const Affine& joint = palette[cloud.view.joints[v * influences + k]];
    for (int i = 0; i < 12; ++i) m[i] = m[i] + w * joint.m[i];
  }
  // The normal by the inverse transpose, in double.
  const Float3 n = cloud.view.normals[v];
  double cofactors[9], determinant = 0.0, length = 0.0;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) {
      const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
      cofactors[3 * r + c] =
          double{m[4 * r1 + c1]} * m[4 * r2 + c2] - double{m[4 * r1 + c2]} * m[4 * r2 + c1];
    }
  for (int c = 0; c < 3; ++c) determinant += m[c] * cofactors[c];
  for (int r = 0; r < 3; ++r) {
    normal[r] =
        (cofactors[3 * r] * n.x + cofactors[3 * r + 1] * n.y + cofactors[3 * r + 2] * n.z) / determinant;
    length += normal[r] * normal[r];
  }
  for (int r = 0; r < 3; ++r) normal[r] /= std::sqrt(length);
  const Float3 p = cloud.view.positions[v];
  const auto row = [&](const float* a) { return ((a[0] * p.x + a[1] * p.y) + a[2] * p.z) + a[3]; };
  return {row(m), row(m + 4), row(m + 8)};
}

TEST(Skinning, EveryInstructionSetGivesTheSameBitsForAnyRange) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> any(-1.5f, 1.5f);
  for (uint32_t influences : {1u, 2u, 3u, 4u, 8u}) {
    Cloud cloud(7);
    for (int i = 0; i < 203; ++i) {
      std::vector<std::pair<uint16_t, uint16_t>> joints;
      uint32_t left = 65535;
      for (uint32_t k = 0; k + 1 < influences; ++k) {
        const uint32_t weight = random() % 5 == 0 ? 0 : static_cast<uint32_t>(random()) % (left / 2 + 1);
        joints.push_back({static_cast<uint16_t>(random() % 7), static_cast<uint16_t>(weight)});
        left -= weight;
      }
      joints.push_back({static_cast<uint16_t>(random() % 7), static_cast<uint16_t>(left)});
      cloud.add({any(random), any(random), any(random)}, joints);
    }
    std::vector<Affine> palette(7);
    for (Affine& matrix : palette)
      for (float& value : matrix.m) value = any(random);
    for (Skinning skinning : {Skinning::kLinear, Skinning::kDualQuaternion}) {
      const Posed whole = pose(cloud, palette, skinning);
      for (size_t v = 0; skinning == Skinning::kLinear && v < whole.positions.size(); ++v) {
        double normal[3];
        const Float3 expected = skinned(cloud, palette, v, normal);
        ASSERT_EQ(std::memcmp(&expected, &whole.positions[v], sizeof expected), 0) << influences << " " << v;
        expectNear(
            whole.normals[v],
            {static_cast<float>(normal[0]), static_cast<float>(normal[1]), static_cast<float>(normal[2])},
            2e-4);
      }
      std::vector<JointMotion> motions(palette.size());
      splitPalette(palette, motions);
      const std::vector<float> weights(cloud.morphs.size(), 0.0f);
      for (Simd simd : {Simd::kPortable, Simd::kSse4, Simd::kAvx2, Simd::kAvx512, Simd::kNeon}) {
        if (!simdAvailable(simd)) continue;
        Posed split = whole;
        for (auto* floats : {&split.positions, &split.normals})
          for (Float3& value : *floats) value = {7, 7, 7};
        DeformJob job{&cloud.view,   palette,        weights,  split.positions,
                      split.normals, split.tangents, skinning, motions};
        job.simd = simd;
        ASSERT_TRUE(job.validate().ok());
        const uint32_t cuts[] = {0, 1, 17, 64, 64, 129, 203};
        for (size_t i = 0; i + 1 < std::size(cuts); ++i) job.run(cuts[i], cuts[i + 1]);
        const auto same = [&](const auto& a, const auto& b) {
          return std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0;
        };
        EXPECT_TRUE(same(split.positions, whole.positions)) << influences << " " << simdName(simd);
        EXPECT_TRUE(same(split.normals, whole.normals)) << influences << " " << simdName(simd);
        EXPECT_TRUE(same(split.tangents, whole.tangents)) << influences << " " << simdName(simd);
      }
    }
  }
}

TEST(Skinning, RefusesMoreInfluencesThanTheKernelsHold) {
  Cloud cloud(1);
  cloud.add({0, 0, 0}, std::vector<std::pair<uint16_t, uint16_t>>(256, {0, 0}));
  const std::vector<Affine> palette(1);
  std::vector<Float3> out(1);
  EXPECT_FALSE((DeformJob{&cloud.view, palette, {}, out, {}, {}}.validate().ok()));
}

}  // namespace
