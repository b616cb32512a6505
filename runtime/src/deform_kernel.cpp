// Compiled once for every instruction set (hwy/foreach_target.h), to the same bits.

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "src/deform_kernel.cpp"
#include "src/deform_kernel.h"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cstring>

#include "src/dual_quaternion.h"
#include "src/skin-inl.h"
#include "src/targets.h"

HWY_BEFORE_NAMESPACE();
namespace furrow {
namespace HWY_NAMESPACE {
namespace {

struct Vectors {
  Lanes x, y, z;
};

// Unit vectors; +Y where there is no direction.
HWY_INLINE Vectors unit(const Vectors& v) {
  const Lanes length = root((v.x * v.x + v.y * v.y) + v.z * v.z), inverse = all(1.0f) / length;
  const Lanes zero = all(0.0f), one = all(1.0f);
  return {ifPositive(length, v.x * inverse, zero), ifPositive(length, v.y * inverse, one),
          ifPositive(length, v.z * inverse, zero)};
}

HWY_INLINE Vectors cross(const Lanes (&a)[4], const Lanes (&b)[4]) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

HWY_INLINE Lanes dot(const Vectors& a, const Vectors& b) {
  return (a.x * b.x + a.y * b.y) + a.z * b.z;
}

// Where kWidth vertices come from and go to; normals and tangents may be null.
struct Group {
  const float *positions, *normals, *tangents;
  float *out_positions, *out_normals, *out_tangents;
};

HWY_INLINE void pose(const Matrices& a, const Group& group) {
  Vectors p;
  load3(group.positions, p.x, p.y, p.z);
  transformPoints(a, p.x, p.y, p.z);
  store3(p.x, p.y, p.z, group.out_positions);
  if (!group.normals) return;
  // By the cofactor matrix, which is right for unevenly scaled joints too, and outwards still where they
  // mirror.
  const Vectors cofactors[3] = {cross(a.m[1], a.m[2]), cross(a.m[2], a.m[0]), cross(a.m[0], a.m[1])};
  const Lanes hand = ifNegative(dot({a.m[0][0], a.m[0][1], a.m[0][2]}, cofactors[0]), all(-1.0f), all(1.0f));
  Vectors n;
  load3(group.normals, n.x, n.y, n.z);
  n = unit({hand * dot(cofactors[0], n), hand * dot(cofactors[1], n), hand * dot(cofactors[2], n)});
  store3(n.x, n.y, n.z, group.out_normals);
  if (!group.tangents) return;
  Vectors t;
  Lanes w = all(0.0f);
  load4(group.tangents, t.x, t.y, t.z, w);
  const auto row = [&](const Lanes(&m)[4]) HWY_ATTR { return (m[0] * t.x + m[1] * t.y) + m[2] * t.z; };
  const Vectors v = {row(a.m[0]), row(a.m[1]), row(a.m[2])};
  const Lanes along = dot(v, n);
  t = unit({v.x - along * n.x, v.y - along * n.y, v.z - along * n.z});
  store4(t.x, t.y, t.z, hand * w, group.out_tangents);
}

HWY_INLINE Matrices linear(const DeformJob& job, const uint16_t* joints, const uint16_t* weights,
                           float* scratch) {
  const uint32_t influences = job.asset->influences;
  for (uint32_t i = 0; i < kWidth * influences; i += kWidth)
    store(fromUint16(weights + i) * all(kUnorm16), scratch + i);
  return blend(job.palette.data(), joints, influences, scratch, influences, 1);
}

// Of the first `count` vertices.
Matrices dualQuaternion(const DeformJob& job, uint32_t vertex, uint32_t count) {
  float entries[12][kWidth] = {};
  for (uint32_t i = 0; i < count; ++i) {
    const Affine matrix = blendMotions(*job.asset, job.motions, vertex + i);
    for (int e = 0; e < 12; ++e) entries[e][i] = matrix.m[e];
  }
  Matrices out;
  for (int e = 0; e < 12; ++e) out.m[e / 4][e % 4] = load(entries[e]);
  return out;
}

}  // namespace

void deformVertices(const DeformJob& job, const Float3* positions, const Float3* normals, uint32_t begin,
                    uint32_t end) {
  const AssetView& asset = *job.asset;
  const size_t influences = asset.influences;
  const bool with_tangents = !job.tangents.empty();
  alignas(64) float weights[kMostInfluences * kWidth];
  for (uint32_t v = begin; v < end; v += kWidth) {
    const uint32_t count = std::min(kWidth, end - v);
    const uint16_t* joint = &asset.joints[v * influences];
    const uint16_t* weight = &asset.weights[v * influences];
    Group group = {&positions[v].x,
                   normals ? &normals[v].x : nullptr,
                   with_tangents ? &asset.tangents[v].x : nullptr,
                   &job.positions[v].x,
                   normals ? &job.normals[v].x : nullptr,
                   with_tangents ? &job.tangents[v].x : nullptr};
    if (count == kWidth) {
      pose(job.skinning == Skinning::kLinear ? linear(job, joint, weight, weights)
                                             : dualQuaternion(job, v, kWidth),
           group);
      continue;
    }
    // The last ones are posed elsewhere, in the company of zeros.
    uint16_t joints_there[kMostInfluences * kWidth] = {}, weights_there[kMostInfluences * kWidth] = {};
    std::copy(joint, joint + count * influences, joints_there);
    std::copy(weight, weight + count * influences, weights_there);
    float there[10 * kWidth] = {};
    const float* from[] = {group.positions, group.normals, group.tangents};
    float* to[] = {group.out_positions, group.out_normals, group.out_tangents};
    float* at[] = {there, there + 3 * kWidth, there + 6 * kWidth};
    const uint32_t floats[] = {3 * count, 3 * count, 4 * count};
    for (int i = 0; i < 3; ++i)
      if (from[i]) std::copy(from[i], from[i] + floats[i], at[i]);
    pose(job.skinning == Skinning::kLinear ? linear(job, joints_there, weights_there, weights)
                                           : dualQuaternion(job, v, count),
         {at[0], from[1] ? at[1] : nullptr, from[2] ? at[2] : nullptr, at[0], at[1], at[2]});
    for (int i = 0; i < 3; ++i)
      if (from[i]) std::copy(at[i], at[i] + floats[i], to[i]);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace furrow
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace furrow {

DeformRun deformRun(Simd simd) {
  constexpr DeformRun kRuns[] = FURROW_TARGETS(deformVertices);
  return kRuns[static_cast<size_t>(simd)];
}

}  // namespace furrow
#endif
