// Compiled once for every instruction set (hwy/foreach_target.h). The expression order is that of the staged
// jobs, and nothing is fused, so that every one of them gives the same bits.

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "src/cluster_frame.cpp"
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128)
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "src/cluster_kernels.h"
#include "src/response_math.h"

HWY_BEFORE_NAMESPACE();
namespace furrow {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr float kUnorm16 = 1.0f / 65535.0f;

#if HWY_TARGET == HWY_SCALAR

// Four floats without SIMD.
constexpr uint32_t kBlocks = 1;
struct Lanes {
  float v[4];
};
template <typename Function>
HWY_INLINE Lanes each(Function f) {
  return {{f(0), f(1), f(2), f(3)}};
}
HWY_INLINE Lanes load(const float* p) {
  return {{p[0], p[1], p[2], p[3]}};
}
HWY_INLINE void store(Lanes a, float* p) {
  std::copy(a.v, a.v + 4, p);
}
HWY_INLINE Lanes all(float x) {
  return {{x, x, x, x}};
}
HWY_INLINE Lanes operator+(Lanes a, Lanes b) {
  return each([&](int i) { return a.v[i] + b.v[i]; });
}
HWY_INLINE Lanes operator-(Lanes a, Lanes b) {
  return each([&](int i) { return a.v[i] - b.v[i]; });
}
HWY_INLINE Lanes operator*(Lanes a, Lanes b) {
  return each([&](int i) { return a.v[i] * b.v[i]; });
}
HWY_INLINE Lanes root(Lanes a) {
  return each([&](int i) { return std::sqrt(a.v[i]); });
}
// q clamped to [0, kMaxQ], 1 where it is not a number.
HWY_INLINE Lanes clampQ(Lanes q) {
  return each([&](int i) { return q.v[i] >= 0.0f ? std::min(q.v[i], kMaxQ) : 1.0f; });
}
// a / b, 1 where b is not positive.
HWY_INLINE Lanes meanOrOne(Lanes a, Lanes b) {
  return each([&](int i) { return b.v[i] > 0.0f ? a.v[i] / b.v[i] : 1.0f; });
}
template <int kLane>
HWY_INLINE Lanes spread(Lanes a) {
  return all(a.v[kLane]);
}
HWY_INLINE void transpose(Lanes& a, Lanes& b, Lanes& c, Lanes& d) {
  const Lanes m[4] = {a, b, c, d};
  Lanes* out[4] = {&a, &b, &c, &d};
  for (int row = 0; row < 4; ++row)
    for (int k = 0; k < 4; ++k) out[row]->v[k] = m[k].v[row];
}
HWY_INLINE Lanes corners(const float* positions, const uint16_t* corner) {
  return load(positions + corner[0]);
}

// Of eight points.
struct Ring {
  Lanes low = all(0.0f), high = all(0.0f);
};
HWY_INLINE Lanes widened(const uint16_t* p) {
  return each([&](int i) { return static_cast<float>(p[i]); });
}
HWY_INLINE Lanes gather(const float* from, const uint16_t* index) {
  return each([&](int i) { return from[index[i]]; });
}
HWY_INLINE void addStep(Ring& sum, const float* triangle_q, const uint16_t* entry) {
  sum.low = sum.low + widened(entry + kRingLanes) * gather(triangle_q, entry);
  sum.high = sum.high + widened(entry + kRingLanes + 4) * gather(triangle_q, entry + 4);
}
HWY_INLINE void storeMean(const Ring& sum, const uint16_t* totals, float* q) {
  store(meanOrOne(sum.low, widened(totals)), q);
  store(meanOrOne(sum.high, widened(totals + 4)), q + 4);
}

#else

// One to four blocks of four floats.
using D = hn::CappedTag<float, 16>;
using D4 = hn::FixedTag<float, 4>;
constexpr uint32_t kBlocks = HWY_MAX_BYTES >= 64 ? 4 : HWY_MAX_BYTES >= 32 ? 2 : 1;
using Lanes = hn::Vec<D>;
using Block = hn::Vec<D4>;
HWY_INLINE Lanes load(const float* p) {
  return hn::LoadU(D(), p);
}
HWY_INLINE void store(Lanes a, float* p) {
  hn::StoreU(a, D(), p);
}
HWY_INLINE Lanes all(float x) {
  return hn::Set(D(), x);
}
HWY_INLINE Lanes root(Lanes a) {
  return hn::Sqrt(a);
}
// q clamped to [0, kMaxQ], 1 where it is not a number.
HWY_INLINE Lanes clampQ(Lanes q) {
  return hn::IfThenElse(q >= hn::Zero(D()), hn::Min(q, all(kMaxQ)), all(1.0f));
}
template <int kLane>
HWY_INLINE Lanes spread(Lanes a) {
  return hn::Broadcast<kLane>(a);
}
// In each block.
template <typename Tag, typename V>
HWY_INLINE void transposeBlocks(Tag d, V& a, V& b, V& c, V& e) {
  const V ac0 = hn::InterleaveLower(d, a, c), ac1 = hn::InterleaveUpper(d, a, c);
  const V be0 = hn::InterleaveLower(d, b, e), be1 = hn::InterleaveUpper(d, b, e);
  a = hn::InterleaveLower(d, ac0, be0);
  b = hn::InterleaveUpper(d, ac0, be0);
  c = hn::InterleaveLower(d, ac1, be1);
  e = hn::InterleaveUpper(d, ac1, be1);
}
HWY_INLINE void transpose(Lanes& a, Lanes& b, Lanes& c, Lanes& d) {
  transposeBlocks(D(), a, b, c, d);
}

// The positions of one corner of triangles 0, 4, 8 and 12, as many as there are blocks.
HWY_INLINE Lanes corners(const float* positions, const uint16_t* corner) {
#if HWY_MAX_BYTES >= 64
  const hn::FixedTag<float, 8> d8;
  return hn::Combine(
      D(), hn::Combine(d8, hn::LoadU(D4(), positions + corner[36]), hn::LoadU(D4(), positions + corner[24])),
      hn::Combine(d8, hn::LoadU(D4(), positions + corner[12]), hn::LoadU(D4(), positions + corner[0])));
#elif HWY_MAX_BYTES >= 32
  return hn::Combine(D(), hn::LoadU(D4(), positions + corner[12]), hn::LoadU(D4(), positions + corner[0]));
#else
  return hn::LoadU(D(), positions + corner[0]);
#endif
}

// Of eight points, in one vector or two.
using DRing = hn::CappedTag<float, 8>;
using RingLanes = hn::Vec<DRing>;
constexpr size_t kRingWidth = HWY_MAX_BYTES >= 32 ? 8 : 4;
struct Ring {
  RingLanes sum[8 / kRingWidth];
  HWY_INLINE Ring() {
    for (RingLanes& s : sum) s = hn::Zero(DRing());
  }
};
HWY_INLINE RingLanes widened(const uint16_t* p) {
  const hn::Rebind<uint16_t, DRing> d16;
  const hn::Rebind<int32_t, DRing> d32;
  return hn::ConvertTo(DRing(), hn::PromoteTo(d32, hn::LoadU(d16, p)));
}
HWY_INLINE Block gather4(const float* from, const uint16_t* index) {
#if HWY_ARCH_X86 && HWY_TARGET != HWY_EMU128  // four loads: gather instructions are slower on most CPUs
  uint64_t four;
  std::memcpy(&four, index, sizeof four);
  return Block{_mm_setr_ps(from[four & 0xffff], from[four >> 16 & 0xffff], from[four >> 32 & 0xffff],
                           from[four >> 48])};
#else
  const float values[4] = {from[index[0]], from[index[1]], from[index[2]], from[index[3]]};
  return hn::LoadU(D4(), values);
#endif
}
HWY_INLINE RingLanes gather(const float* from, const uint16_t* index) {
#if HWY_MAX_BYTES >= 32
  return hn::Combine(DRing(), gather4(from, index + 4), gather4(from, index));
#else
  return gather4(from, index);
#endif
}
HWY_INLINE void addStep(Ring& ring, const float* triangle_q, const uint16_t* entry) {
  for (size_t i = 0; i < 8 / kRingWidth; ++i)
    ring.sum[i] = ring.sum[i] +
                  widened(entry + kRingLanes + kRingWidth * i) * gather(triangle_q, entry + kRingWidth * i);
}
// The mean, 1 where the total is 0.
HWY_INLINE void storeMean(const Ring& ring, const uint16_t* totals, float* q) {
  for (size_t i = 0; i < 8 / kRingWidth; ++i) {
    const RingLanes total = widened(totals + kRingWidth * i);
    hn::StoreU(hn::IfThenElse(total > hn::Zero(DRing()), ring.sum[i] / total, hn::Set(DRing(), 1.0f)),
               DRing(), q + kRingWidth * i);
  }
}

#endif

constexpr uint32_t kFetchEvery = 4;  // neighbouring slots mostly share a cache line

// x, y, z and anything; the last vertex of an array must not be read beyond.
HWY_INLINE void copyPosition(const std::byte* from, bool last, float* to) {
  if (last) {
    std::memcpy(to, from, sizeof(Float3));
    to[3] = 0.0f;
  } else {
    std::memcpy(to, from, sizeof(Float4));
  }
}

HWY_INLINE void copyHostPositions(const ClusterFrameJob& job, const Cluster& c, const Cluster& next,
                                  float* out) {
  const uint32_t* vertex = &job.clusters->words[c.slot_vertex];
  const uint32_t* soon = &job.clusters->words[next.slot_vertex];
  const uint32_t last = job.clusters->asset->vertexCount() - 1;
  for (uint32_t s = 0; s < next.slots; s += kFetchEvery)
    hwy::Prefetch(job.posed + soon[s] * job.posed_stride);
  for (uint32_t s = 0; s < c.slots; ++s)
    copyPosition(job.posed + vertex[s] * job.posed_stride, vertex[s] == last, out + 4 * size_t{s});
}

HWY_INLINE void posePositions(const ClusterFrameJob& job, const Cluster& c, const Cluster& next, float* out) {
  const Clusters& clusters = *job.clusters;
  const AssetView& asset = *clusters.asset;
  const uint32_t* vertex = &clusters.words[c.slot_vertex];
  const uint32_t* soon = &clusters.words[next.slot_vertex];
  const uint32_t last = asset.vertexCount() - 1;
  for (uint32_t s = 0; s < next.slots; s += kFetchEvery) {
    hwy::Prefetch(&asset.positions[soon[s]]);
    hwy::Prefetch(&asset.joints[size_t{soon[s]} * asset.influences]);
    hwy::Prefetch(&asset.weights[size_t{soon[s]} * asset.influences]);
  }
  for (uint32_t s = 0; s < c.slots; ++s)
    copyPosition(reinterpret_cast<const std::byte*>(&asset.positions[vertex[s]]), vertex[s] == last,
                 out + 4 * size_t{s});

  const size_t index = static_cast<size_t>(&c - clusters.clusters.data());
  for (uint32_t r = clusters.morph_run_begin[index]; r < clusters.morph_run_begin[index + 1]; ++r) {
    const Clusters::MorphRun& run = clusters.morph_runs[r];
    if (job.morph_weights[run.morph] == 0.0f) continue;
    const Morph& morph = asset.morphs[run.morph];
    const float step = job.morph_weights[run.morph] * morph.position_step;
    for (uint32_t i = run.begin; i < run.end; ++i) {
      float* p = out + 4 * size_t{clusters.morph_slots[i]};
      const int32_t* delta = &morph.position_deltas[3 * size_t{clusters.morph_index[i]}];
      for (int k = 0; k < 3; ++k) p[k] = p[k] + step * static_cast<float>(delta[k]);
    }
  }

  const uint32_t influences = asset.influences;
  for (uint32_t s = 0; s < c.slots; ++s) {
    const uint16_t* joint = &asset.joints[size_t{vertex[s]} * influences];
    const uint16_t* weight = &asset.weights[size_t{vertex[s]} * influences];
#if HWY_TARGET == HWY_SCALAR
    using Row = Lanes;
    const auto row = [](const float* p) { return load(p); };
    const auto fill = [](float x) { return all(x); };
#else
    using Row = Block;
    const auto row = [](const float* p) { return hn::LoadU(D4(), p); };
    const auto fill = [](float x) { return hn::Set(D4(), x); };
#endif
    Row row0 = fill(0.0f), row1 = row0, row2 = row0, row3 = row0;
    for (uint32_t k = 0; k < influences; ++k) {
      if (weight[k] == 0) continue;
      const Row w = fill(static_cast<float>(weight[k]) * kUnorm16);
      const float* m = job.palette[joint[k]].m;
      row0 = row0 + w * row(m);
      row1 = row1 + w * row(m + 4);
      row2 = row2 + w * row(m + 8);
    }
    float* at = out + 4 * size_t{s};
#if HWY_TARGET == HWY_SCALAR
    transpose(row0, row1, row2, row3);
    store(((row0 * all(at[0]) + row1 * all(at[1])) + row2 * all(at[2])) + row3, at);
#else
    transposeBlocks(D4(), row0, row1, row2, row3);
    const Block p = row(at);
    hn::StoreU(
        ((row0 * hn::Broadcast<0>(p) + row1 * hn::Broadcast<1>(p)) + row2 * hn::Broadcast<2>(p)) + row3, D4(),
        at);
#endif
  }
  if (!job.positions.empty())
    for (uint32_t s = 0; s < c.vertices; ++s)
      std::memcpy(&job.positions[vertex[s]], out + 4 * size_t{s}, sizeof(Float3));
}

struct Edges {
  Lanes e1, e2;
};
HWY_INLINE Edges edges(const float* positions, const uint16_t* corner) {
  const Lanes p0 = corners(positions, corner);
  return {corners(positions, corner + 1) - p0, corners(positions, corner + 2) - p0};
}

// x + y + z of each triangle, from vectors that hold triangles i, i + 4, ... in their blocks.
HWY_INLINE Lanes sums(Lanes a, Lanes b, Lanes c, Lanes d) {
  transpose(a, b, c, d);
  return (a + b) + c;
}

// A measure gives q of 4 * kBlocks triangles; all-zero coefficients give 0.
struct Directional {
  static constexpr uint32_t kCoefficients = 2;
  template <int kLane>
  HWY_INLINE static Lanes square(const float* positions, const uint16_t* corner, Lanes c0, Lanes c1) {
    const Edges e = edges(positions, corner + 3 * kLane);
    const Lanes v = spread<kLane>(c0) * e.e1 + spread<kLane>(c1) * e.e2;
    return v * v;
  }
  HWY_INLINE static Lanes of(const float* positions, const uint16_t* corner, const float* c,
                             Lanes inverse_scale2) {
    const Lanes c0 = load(c), c1 = load(c + kTriangleLanes);
    return sums(square<0>(positions, corner, c0, c1), square<1>(positions, corner, c0, c1),
                square<2>(positions, corner, c0, c1), square<3>(positions, corner, c0, c1)) *
           inverse_scale2;
  }
};

// Edges by coordinate.
struct EdgeLanes {
  HWY_INLINE EdgeLanes(const float* positions, const uint16_t* corner) {
    Edges e[4];
    for (int i = 0; i < 4; ++i) e[i] = edges(positions, corner + 3 * i);
    transpose(e[0].e1, e[1].e1, e[2].e1, e[3].e1);
    transpose(e[0].e2, e[1].e2, e[2].e2, e[3].e2);
    x1 = e[0].e1, y1 = e[1].e1, z1 = e[2].e1;
    x2 = e[0].e2, y2 = e[1].e2, z2 = e[2].e2;
  }
  Lanes x1, y1, z1, x2, y2, z2;
};

struct Area {
  static constexpr uint32_t kCoefficients = 1;
  HWY_INLINE static Lanes of(const float* positions, const uint16_t* corner, const float* c,
                             Lanes inverse_scale2) {
    const EdgeLanes e(positions, corner);
    const Lanes x = e.y1 * e.z2 - e.z1 * e.y2;
    const Lanes y = e.z1 * e.x2 - e.x1 * e.z2;
    const Lanes z = e.x1 * e.y2 - e.y1 * e.x2;
    return (root((x * x + y * y) + z * z) * load(c)) * inverse_scale2;
  }
};

struct Principal {
  static constexpr uint32_t kCoefficients = 3;
  HWY_INLINE static Lanes of(const float* positions, const uint16_t* corner, const float* c,
                             Lanes inverse_scale2) {
    const EdgeLanes e(positions, corner);
    const Lanes c0 = load(c), c1 = load(c + kTriangleLanes), c2 = load(c + 2 * kTriangleLanes);
    const Lanes f1x = c0 * e.x1, f1y = c0 * e.y1, f1z = c0 * e.z1;
    const Lanes f2x = c1 * e.x1 + c2 * e.x2, f2y = c1 * e.y1 + c2 * e.y2, f2z = c1 * e.z1 + c2 * e.z2;
    const Lanes f11 = (f1x * f1x + f1y * f1y) + f1z * f1z;
    const Lanes f22 = (f2x * f2x + f2y * f2y) + f2z * f2z;
    const Lanes f12 = (f1x * f2x + f1y * f2y) + f1z * f2z;
    const Lanes half = all(0.5f) * (f11 - f22);
    return (all(0.5f) * (f11 + f22) - root(half * half + f12 * f12)) * inverse_scale2;
  }
};

// While a cluster is worked on, the memory of the next one is fetched, at the same pace: its words lie
// `ahead` bytes further on.
HWY_INLINE void fetch(const void* at, size_t ahead, size_t bytes) {
  for (size_t line = 0; line < bytes; line += 64) hwy::Prefetch(static_cast<const char*>(at) + ahead + line);
}

template <typename Measure>
HWY_INLINE void measure(const Cluster& c, size_t ahead, const uint16_t* corner, const float* coefficients,
                        float scale, const float* positions, float* q) {
  const Lanes inverse_scale2 = all(1.0f / (scale * scale));
  for (uint32_t group = 0; group < c.triangles; group += kTriangleLanes, corner += 3 * kTriangleLanes) {
    fetch(corner, ahead, 3 * kTriangleLanes * sizeof(uint16_t));
    fetch(coefficients, ahead, Measure::kCoefficients * kTriangleLanes * sizeof(float));
    for (uint32_t i = 0; i < kTriangleLanes; i += 4 * kBlocks)
      store(clampQ(Measure::of(positions, corner + 3 * i, coefficients + i, inverse_scale2)), q + group + i);
    coefficients += Measure::kCoefficients * kTriangleLanes;
  }
}

HWY_INLINE void smooth(const Cluster& c, size_t ahead, const uint32_t* words, const uint16_t* totals,
                       const float* triangle_q, float* q) {
  const uint32_t* chunk = words + c.chunks;
  for (uint32_t point = 0; point < c.points;
       point += kRingLanes, ++chunk, q += kRingLanes, totals += kRingLanes) {
    Ring ring;
    const auto* end = reinterpret_cast<const uint16_t*>(words + chunk[1]);
    for (const auto* entry = reinterpret_cast<const uint16_t*>(words + chunk[0]); entry < end;
         entry += 2 * kRingLanes) {
      if (!(reinterpret_cast<uintptr_t>(entry) & 63)) fetch(entry, ahead, 64);
      addStep(ring, triangle_q, entry);
    }
    storeMean(ring, totals, q);
  }
}

void runCluster(const ClusterFrameJob& job, const Cluster& c, const ClusterScratch& scratch) {
  const Clusters& clusters = *job.clusters;
  const AssetView& asset = *clusters.asset;
  const uint32_t* words = clusters.words.data();
  const size_t index = static_cast<size_t>(&c - clusters.clusters.data());
  const Cluster& next = clusters.clusters[std::min(index + 1, clusters.clusters.size() - 1)];
  const size_t ahead = size_t{next.slot_vertex - c.slot_vertex} * sizeof(uint32_t);
  if (job.posed)
    copyHostPositions(job, c, next, scratch.positions);
  else
    posePositions(job, c, next, scratch.positions);
  const auto* corner = reinterpret_cast<const uint16_t*>(words + c.corners);
  const auto* extra = reinterpret_cast<const uint16_t*>(words + c.extra_point);
  const uint32_t* vertex = words + c.slot_vertex;
  const size_t stride = asset.weightStride();
  for (uint32_t l = 0; l < asset.layerCount(); ++l) {
    const Layer& layer = asset.layers[l];
    if (c.covered >> l & 1u) {
      const auto* coefficients =
          reinterpret_cast<const float*>(words + clusters.layer_words[index * asset.layerCount() + l]);
      const auto* totals = reinterpret_cast<const uint16_t*>(
          coefficients + size_t{c.triangles} * coefficientCount(layer.measure));
      if (layer.measure == Measure::kDirectional)
        measure<Directional>(c, ahead, corner, coefficients, job.scale, scratch.positions,
                             scratch.triangle_q);
      else if (layer.measure == Measure::kArea)
        measure<Area>(c, ahead, corner, coefficients, job.scale, scratch.positions, scratch.triangle_q);
      else
        measure<Principal>(c, ahead, corner, coefficients, job.scale, scratch.positions, scratch.triangle_q);
      smooth(c, ahead, words, totals, scratch.triangle_q, scratch.q);
      for (uint32_t i = c.points; i < c.vertices; ++i) scratch.q[i] = scratch.q[extra[i - c.points]];
    } else {
      std::fill_n(scratch.q, c.vertices, 1.0f);
    }
    if (layer.bias.empty())
      std::fill_n(scratch.bias, c.vertices, 0.0f);
    else
      for (uint32_t i = 0; i < c.vertices; ++i)
        scratch.bias[i] = static_cast<float>(layer.bias[vertex[i]]) * (1.0f / 32767.0f);
    const Response& response = job.responses.empty() ? layer.response : job.responses[l];
    const float region = job.region_weights.empty() ? 0.0f : job.region_weights[l];
    withCurve(response, [&](const auto& curve) {
      respondBlock(curve, scratch.q, scratch.bias, region, c.vertices, scratch.weights);
    });
    for (uint32_t i = 0; i < c.vertices; ++i) job.weights[vertex[i] * stride + l] = scratch.weights[i];
  }
}

}  // namespace

ClusterRun clusterRun() {
  return &runCluster;
}

}  // namespace HWY_NAMESPACE
}  // namespace furrow
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#if HWY_ARCH_X86 && HWY_COMPILER_MSVC
#include <intrin.h>
#endif

namespace furrow {
namespace {

#if HWY_ARCH_X86 && !HWY_COMPILER_MSVC
bool cpuHasAvx2() {
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("fma");
}
bool cpuHasAvx512() {
  return cpuHasAvx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
         __builtin_cpu_supports("avx512cd");
}
bool cpuHasSse4() {
  return __builtin_cpu_supports("sse4.2") && __builtin_cpu_supports("pclmul") &&
         __builtin_cpu_supports("aes");
}
#elif HWY_ARCH_X86
bool cpuHas(int leaf, int word, int bit) {
  int words[4];
  __cpuidex(words, leaf, 0);
  return words[word] >> bit & 1;
}
// The operating system must save the registers too: XCR0.
bool cpuHasAvx2() {
  return cpuHas(1, 2, 27) && (_xgetbv(0) & 6) == 6 && cpuHas(7, 1, 5) && cpuHas(7, 1, 8) && cpuHas(1, 2, 12);
}
bool cpuHasAvx512() {
  return cpuHasAvx2() && (_xgetbv(0) & 0xe6) == 0xe6 && cpuHas(7, 1, 16) && cpuHas(7, 1, 17) &&
         cpuHas(7, 1, 28) && cpuHas(7, 1, 30) && cpuHas(7, 1, 31);
}
bool cpuHasSse4() {
  return cpuHas(1, 2, 20) && cpuHas(1, 2, 1) && cpuHas(1, 2, 25);
}
#endif

ClusterRun runOf(Simd simd) {
  switch (simd) {
#if HWY_TARGETS & HWY_SCALAR
    case Simd::kPortable:
      return N_SCALAR::clusterRun();
#elif HWY_TARGETS & HWY_EMU128
    case Simd::kPortable:
      return N_EMU128::clusterRun();
#endif
#if HWY_TARGETS & HWY_SSE4
    case Simd::kSse4:
      return cpuHasSse4() ? N_SSE4::clusterRun() : nullptr;
#endif
#if HWY_TARGETS & HWY_AVX2
    case Simd::kAvx2:
      return cpuHasAvx2() ? N_AVX2::clusterRun() : nullptr;
#endif
#if HWY_TARGETS & HWY_AVX3
    case Simd::kAvx512:
      return cpuHasAvx512() ? N_AVX3::clusterRun() : nullptr;
#endif
#if HWY_TARGETS & HWY_NEON
    case Simd::kNeon:
      return N_NEON::clusterRun();
#endif
    default:
      return nullptr;
  }
}

}  // namespace

const char* simdName(Simd simd) {
  constexpr const char* kNames[] = {"portable", "SSE4", "AVX2", "AVX-512", "NEON"};
  return kNames[static_cast<size_t>(simd)];
}

bool simdAvailable(Simd simd) {
  return runOf(simd) != nullptr;
}

Simd bestSimd() {
  static const Simd best = [] {
    for (Simd simd : {Simd::kNeon, Simd::kAvx512, Simd::kAvx2, Simd::kSse4})
      if (simdAvailable(simd)) return simd;
    return Simd::kPortable;
  }();
  return best;
}

Status ClusterFrameJob::validate() const {
  if (!clusters || !clusters->asset) return Status::error(StatusCode::kInvalidArgument, "frame: no clusters");
  const AssetView& asset = *clusters->asset;
  if (posed ? posed_stride < sizeof(Float3) || posed_stride % sizeof(float) != 0
            : palette.size() != asset.palette.size() || morph_weights.size() != asset.morphs.size())
    return Status::error(StatusCode::kInvalidArgument, "frame: the pose does not fit the asset");
  if (!positions.empty() && (posed || positions.size() < asset.vertexCount()))
    return Status::error(StatusCode::kInvalidArgument,
                         "frame: positions are too short, or posed by the host");
  if (weights.size() < size_t{asset.vertexCount()} * asset.weightStride())
    return Status::error(StatusCode::kInvalidArgument, "frame: weights are too short");
  if ((!responses.empty() && responses.size() != asset.layerCount()) ||
      (!region_weights.empty() && region_weights.size() != asset.layerCount()))
    return Status::error(StatusCode::kInvalidArgument,
                         "frame: responses or region weights are not one a layer");
  if (!(scale > 0.0f) || !std::isfinite(scale))
    return Status::error(StatusCode::kInvalidArgument, "frame: scale is not positive");
  for (uint32_t l = 0; l < asset.layerCount(); ++l) {
    const Response& r = responses.empty() ? asset.layers[l].response : responses[l];
    for (float value : {r.lambda, r.beta, r.stretch_lambda, r.stretch_beta})
      if (!(value > 0.0f) || !std::isfinite(value))
        return Status::error(StatusCode::kInvalidArgument, "frame: lambda and beta must be positive");
    if (!region_weights.empty() && !std::isfinite(region_weights[l]))
      return Status::error(StatusCode::kInvalidArgument, "frame: a region weight is not finite");
  }
  if (!simdAvailable(simd))
    return Status::error(StatusCode::kUnavailable, "frame: this CPU or build has no %s", simdName(simd));
  return {};
}

void ClusterFrameJob::run(uint32_t begin, uint32_t end, std::span<std::byte> scratch) const {
  const ClusterRun run_cluster = runOf(simd);
  for (uint32_t i = begin; i < end; ++i) {
    const Cluster& c = clusters->clusters[i];
    const size_t padded = (size_t{c.vertices} + kRingLanes - 1) / kRingLanes * kRingLanes;
    ClusterScratch s = {};
    s.positions = reinterpret_cast<float*>(scratch.data());
    s.triangle_q = s.positions + 4 * size_t{c.slots};
    s.q = s.triangle_q + c.triangles;
    s.bias = s.q + padded;
    s.weights = reinterpret_cast<int16_t*>(s.bias + padded);
    run_cluster(*this, c, s);
  }
}

}  // namespace furrow
#endif
