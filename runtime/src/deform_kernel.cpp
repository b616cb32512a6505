// Compiled once for every instruction set (hwy/foreach_target.h), to the same bits.

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "src/deform_kernel.cpp"
#include "src/deform_kernel.h"

#include "src/targets.h"
// targets.h first: it says for what the others compile.
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cstring>

#include "src/dual_quaternion.h"
#include "src/skin-inl.h"

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
  if (allPositive(length)) [[likely]]
    return {v.x * inverse, v.y * inverse, v.z * inverse};
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

// Where kWidth vertices come from and go to; normals and tangents may be null. Of the last group of a job
// only `count` are wanted.
struct Group {
  uint32_t vertex, count;
  const uint16_t *joints, *weights;
  const float *positions, *normals, *tangents;
  float *out_positions, *out_normals, *out_tangents;
};

HWY_INLINE Matrices linear(const DeformJob& job, const Group& group) {
  const uint32_t influences = job.asset->influences;
  alignas(64) float weights[kMostInfluences * kWidth];
  for (uint32_t i = 0; i < kWidth * influences; i += kWidth)
    store(fromUint16(group.weights + i) * all(kUnorm16), weights + i);
  return blend(job.palette.data(), group.joints, influences, weights, influences, 1);
}

Matrices dualQuaternion(const DeformJob& job, const Group& group) {
  float entries[12][kWidth] = {};
  for (uint32_t i = 0; i < group.count; ++i) {
    const Affine matrix = blendMotions(*job.asset, job.motions, group.vertex + i);
    for (int e = 0; e < 12; ++e) entries[e][i] = matrix.m[e];
  }
  Matrices out;
  for (int e = 0; e < 12; ++e) out.m[e / 4][e % 4] = load(entries[e]);
  return out;
}

// Vectors at a time, since a core must have several of the long chains of square root and division at work.
constexpr uint32_t kTeam = 4;

HWY_INLINE void pose(const DeformJob& job, const Group (&groups)[kTeam], uint32_t count) {
  Vectors normals[kTeam], tangents[kTeam];
  Lanes signs[kTeam];
#if HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_NEON
  // gcc cannot see that these are set where they are read.
  for (uint32_t g = 0; g < kTeam; ++g) {
    signs[g] = all(0.0f);
    normals[g] = tangents[g] = {signs[g], signs[g], signs[g]};
  }
#endif
  for (uint32_t g = 0; g < count; ++g) {
    const Group& group = groups[g];
    const Matrices a = job.skinning == Skinning::kLinear ? linear(job, group) : dualQuaternion(job, group);
    Vectors p;
    load3(group.positions, p.x, p.y, p.z);
    transformPoints(a, p.x, p.y, p.z);
    store3(p.x, p.y, p.z, group.out_positions);
    if (!group.normals) continue;
    // By the cofactor matrix, which is right for unevenly scaled joints too, and outwards still where they
    // mirror.
    const Vectors cofactors[3] = {cross(a.m[1], a.m[2]), cross(a.m[2], a.m[0]), cross(a.m[0], a.m[1])};
    const Lanes hand =
        ifNegative(dot({a.m[0][0], a.m[0][1], a.m[0][2]}, cofactors[0]), all(-1.0f), all(1.0f));
    Vectors n;
    load3(group.normals, n.x, n.y, n.z);
    normals[g] = {hand * dot(cofactors[0], n), hand * dot(cofactors[1], n), hand * dot(cofactors[2], n)};
    if (!group.tangents) continue;
    Vectors t;
    load4(group.tangents, t.x, t.y, t.z, signs[g]);
    const auto row = [&](const Lanes(&m)[4]) HWY_ATTR { return (m[0] * t.x + m[1] * t.y) + m[2] * t.z; };
    tangents[g] = {row(a.m[0]), row(a.m[1]), row(a.m[2])};
    signs[g] = hand * signs[g];
  }
  for (uint32_t g = 0; g < count && groups[g].normals; ++g) {
    normals[g] = unit(normals[g]);
    store3(normals[g].x, normals[g].y, normals[g].z, groups[g].out_normals);
  }
  for (uint32_t g = 0; g < count && groups[g].tangents; ++g) {
    const Vectors &n = normals[g], &v = tangents[g];
    const Lanes along = dot(v, n);
    const Vectors t = unit({v.x - along * n.x, v.y - along * n.y, v.z - along * n.z});
    store4(t.x, t.y, t.z, signs[g], groups[g].out_tangents);
  }
}

// Memory for a group of fewer than kWidth vertices, in the company of zeros.
struct LastGroup {
  uint16_t joints[kMostInfluences * kWidth], weights[kMostInfluences * kWidth];
  float positions[3 * kWidth] = {}, normals[3 * kWidth] = {}, tangents[4 * kWidth] = {};

  Group of(const Group& from, uint32_t influences) {
    std::fill_n(joints, kWidth * influences, uint16_t{0});
    std::fill_n(weights, kWidth * influences, uint16_t{0});
    std::copy(from.joints, from.joints + from.count * influences, joints);
    std::copy(from.weights, from.weights + from.count * influences, weights);
    std::copy(from.positions, from.positions + 3 * from.count, positions);
    if (from.normals) std::copy(from.normals, from.normals + 3 * from.count, normals);
    if (from.tangents) std::copy(from.tangents, from.tangents + 4 * from.count, tangents);
    return {from.vertex,
            from.count,
            joints,
            weights,
            positions,
            from.normals ? normals : nullptr,
            from.tangents ? tangents : nullptr,
            positions,
            normals,
            tangents};
  }
  void copyOut(const Group& to) const {
    std::copy(positions, positions + 3 * to.count, to.out_positions);
    if (to.normals) std::copy(normals, normals + 3 * to.count, to.out_normals);
    if (to.tangents) std::copy(tangents, tangents + 4 * to.count, to.out_tangents);
  }
};

}  // namespace

void deformVertices(const DeformJob& job, const Float3* positions, const Float3* normals, uint32_t begin,
                    uint32_t end) {
  const AssetView& asset = *job.asset;
  const size_t influences = asset.influences;
  const bool with_tangents = !job.tangents.empty();
  const auto group = [&](uint32_t v) -> Group {
    return {v,
            std::min(kWidth, end - v),
            &asset.joints[v * influences],
            &asset.weights[v * influences],
            &positions[v].x,
            normals ? &normals[v].x : nullptr,
            with_tangents ? &asset.tangents[v].x : nullptr,
            &job.positions[v].x,
            normals ? &job.normals[v].x : nullptr,
            with_tangents ? &job.tangents[v].x : nullptr};
  };
  Group groups[kTeam];
  uint32_t v = begin;
  while (end - v >= kWidth) {
    const uint32_t count = std::min(kTeam, (end - v) / kWidth);
    for (uint32_t g = 0; g < count; ++g, v += kWidth) groups[g] = group(v);
    pose(job, groups, count);
  }
  if (v == end) return;
  LastGroup last;
  groups[0] = last.of(group(v), asset.influences);
  pose(job, groups, 1);
  last.copyOut(group(v));
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
