// Compiled once for every instruction set (hwy/foreach_target.h). The expression order is that of the staged
// jobs, and nothing is fused, so that every one of them gives the same bits.

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "src/cluster_frame.cpp"
#include "src/targets.h"
// targets.h first: it says for what the others compile.
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "src/cluster_kernels.h"
#include "src/lanes-inl.h"
#include "src/respond-inl.h"
#include "src/skin-inl.h"

HWY_BEFORE_NAMESPACE();
namespace furrow {
namespace HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR

// Layers that are measured and smoothed at once.
constexpr uint32_t kPass = 4;

// The rings of kRingLanes points in kLayers layers, whose q lie side by side.
template <uint32_t kLayers>
struct Rings {
  float sum[kRingLanes][kLayers] = {};

  void addStep(const float* triangle_q, const uint16_t* entry) {
    for (uint32_t i = 0; i < kRingLanes; ++i)
      for (uint32_t l = 0; l < kLayers; ++l)
        sum[i][l] = sum[i][l] +
                    static_cast<float>(entry[kRingLanes + i]) * triangle_q[kLayers * size_t{entry[i]} + l];
  }
  void store(float* out, size_t step) const {
    for (uint32_t l = 0; l < kLayers; ++l)
      for (uint32_t i = 0; i < kRingLanes; ++i) out[l * step + i] = sum[i][l];
  }
};

template <uint32_t kLayers>
HWY_INLINE void storeSideBySide(const Lanes (&q)[kLayers], float* out) {
  for (uint32_t i = 0; i < kWidth; ++i)
    for (uint32_t l = 0; l < kLayers; ++l) out[kLayers * i + l] = q[l].v[i];
}

#else

// Layers that are measured and smoothed at once.
constexpr uint32_t kPass = HWY_MAX_BYTES >= 32 ? 8 : 4;
static_assert(kPass <= kMostInPass);

// kRingLanes floats, in one vector or two.
using DRing = hn::CappedTag<float, kRingLanes>;
using RingVector = hn::Vec<DRing>;
constexpr uint32_t kRingWidth = HWY_MAX_BYTES >= 32 ? 8 : 4;
constexpr uint32_t kRingVectors = kRingLanes / kRingWidth;

HWY_INLINE Block gather4(const float* from, const uint16_t* index) {
#if HWY_ARCH_X86 && HWY_TARGET != HWY_EMU128  // four loads: gather instructions are slower on most CPUs
  uint32_t pairs[2];
  std::memcpy(pairs, index, sizeof pairs);
  return Block{_mm_setr_ps(from[pairs[0] & 0xffff], from[pairs[0] >> 16], from[pairs[1] & 0xffff],
                           from[pairs[1] >> 16])};
#else
  const float values[4] = {from[index[0]], from[index[1]], from[index[2]], from[index[3]]};
  return hn::LoadU(D4(), values);
#endif
}
HWY_INLINE RingVector gather(const float* from, const uint16_t* index) {
#if HWY_MAX_BYTES >= 32
  return hn::Combine(DRing(), gather4(from, index + 4), gather4(from, index));
#else
  return gather4(from, index);
#endif
}
HWY_INLINE RingVector ringWeights(const uint16_t* p) {
  const hn::Rebind<uint16_t, DRing> d16;
  const hn::Rebind<int32_t, DRing> d32;
  return hn::ConvertTo(DRing(), hn::PromoteTo(d32, hn::LoadU(d16, p)));
}

// The rings of kRingLanes points in kLayers layers, whose q lie side by side.
template <uint32_t kLayers>
struct Rings {
  using DLayers = hn::FixedTag<float, kLayers>;
  hn::Vec<DLayers> sum[kRingLanes];

  HWY_INLINE Rings() {
    for (auto& s : sum) s = hn::Zero(DLayers());
  }
  HWY_INLINE void addStep(const float* triangle_q, const uint16_t* entry) {
    for (uint32_t i = 0; i < kRingLanes; i += 4, entry += 4) {
      const auto weights = weightsOf(entry + kRingLanes);
      sum[i] = sum[i] + hn::Broadcast<0>(weights) * load(triangle_q, entry[0]);
      sum[i + 1] = sum[i + 1] + hn::Broadcast<1>(weights) * load(triangle_q, entry[1]);
      sum[i + 2] = sum[i + 2] + hn::Broadcast<2>(weights) * load(triangle_q, entry[2]);
      sum[i + 3] = sum[i + 3] + hn::Broadcast<3>(weights) * load(triangle_q, entry[3]);
    }
  }
  // Layer l's sums to `out + l * step`.
  HWY_INLINE void store(float* out, size_t step) {
    const DLayers d;
    for (uint32_t i = 0; i < kRingLanes; i += 4) {
      const auto* s = sum + i;
      const auto ac0 = hn::InterleaveLower(d, s[0], s[2]), ac1 = hn::InterleaveUpper(d, s[0], s[2]);
      const auto be0 = hn::InterleaveLower(d, s[1], s[3]), be1 = hn::InterleaveUpper(d, s[1], s[3]);
      storeRows(hn::InterleaveLower(d, ac0, be0), out + i, 4 * step);
      storeRows(hn::InterleaveUpper(d, ac0, be0), out + step + i, 4 * step);
      storeRows(hn::InterleaveLower(d, ac1, be1), out + 2 * step + i, 4 * step);
      storeRows(hn::InterleaveUpper(d, ac1, be1), out + 3 * step + i, 4 * step);
    }
  }

 private:
  // Of four points, in each block.
  HWY_INLINE static hn::Vec<DLayers> weightsOf(const uint16_t* p) {
    const hn::Rebind<uint16_t, D4> d16;
    const hn::Rebind<int32_t, D4> d32;
    const Block weights = hn::ConvertTo(D4(), hn::PromoteTo(d32, hn::LoadU(d16, p)));
    if constexpr (kLayers == 8)
      return hn::Combine(DLayers(), weights, weights);
    else
      return weights;
  }
  HWY_INLINE static hn::Vec<DLayers> load(const float* triangle_q, size_t triangle) {
    return hn::LoadU(DLayers(), triangle_q + kLayers * triangle);
  }
  // Four points of layer l, and of layer l + 4 where there are so many.
  HWY_INLINE static void storeRows(hn::Vec<DLayers> row, float* out, size_t step) {
    if constexpr (kLayers == 8) {
      hn::StoreU(hn::LowerHalf(D4(), row), D4(), out);
      hn::StoreU(hn::UpperHalf(D4(), row), D4(), out + step);
    } else {
      hn::StoreU(row, D4(), out);
    }
  }
};

template <>
struct Rings<1> {
  RingVector sum[kRingVectors];

  HWY_INLINE Rings() {
    for (RingVector& s : sum) s = hn::Zero(DRing());
  }
  HWY_INLINE void addStep(const float* triangle_q, const uint16_t* entry) {
    for (uint32_t i = 0; i < kRingVectors; ++i, entry += kRingWidth)
      sum[i] = sum[i] + ringWeights(entry + kRingLanes) * gather(triangle_q, entry);
  }
  HWY_INLINE void store(float* out, size_t) const {
    for (uint32_t i = 0; i < kRingVectors; ++i) hn::StoreU(sum[i], DRing(), out + kRingWidth * i);
  }
};

#if HWY_MAX_BYTES >= 32

// Lane i from lane from(i).
template <typename From>
HWY_INLINE Lanes permuted(Lanes a, From from) {
  alignas(64) int32_t lanes[kWidth];
  for (uint32_t i = 0; i < kWidth; ++i) lanes[i] = static_cast<int32_t>(from(i));
  return hn::TableLookupLanes(a, hn::SetTableIndices(D(), lanes));
}

// A point is a block: kBlocks points a vector.
template <>
struct Rings<4> {
  static constexpr uint32_t kVectors = kRingLanes / kBlocks;
  Lanes sum[kVectors];

  HWY_INLINE Rings() {
    for (Lanes& s : sum) s = all(0.0f);
  }
  HWY_INLINE void addStep(const float* triangle_q, const uint16_t* entry) {
#if HWY_MAX_BYTES >= 64
    const Lanes weights = hn::ZeroExtendVector(D(), ringWeights(entry + kRingLanes));
#else
    const Lanes weights = ringWeights(entry + kRingLanes);
#endif
    for (uint32_t v = 0; v < kVectors; ++v, entry += kBlocks)
      sum[v] = sum[v] + permuted(weights, [v](uint32_t i) { return kBlocks * v + i / 4; }) *
                            gatherBlocks([&](int i) HWY_ATTR { return triangle_q + 4 * size_t{entry[i]}; });
  }
  HWY_INLINE void store(float* out, size_t step) {
    for (Lanes& s : sum) s = permuted(s, [](uint32_t i) { return i % kBlocks * 4 + i / kBlocks; });
    for (uint32_t v = 0; v < kVectors; v += 4 / kBlocks, out += 4) {
#if HWY_MAX_BYTES >= 64
      storeBlocks(sum[v], out, step);
#else
      const hn::Repartition<double, D> pairs;
      const auto ab = hn::BitCast(pairs, sum[v]), cd = hn::BitCast(pairs, sum[v + 1]);
      storeBlocks(hn::BitCast(D(), hn::InterleaveLower(pairs, ab, cd)), out, 2 * step);
      storeBlocks(hn::BitCast(D(), hn::InterleaveUpper(pairs, ab, cd)), out + step, 2 * step);
#endif
    }
  }
};

#endif
#if HWY_MAX_BYTES >= 64

// Points i and i + 4 in vector i, their layers side by side.
template <>
struct Rings<8> {
  Lanes sum[4];

  HWY_INLINE Rings() {
    for (Lanes& s : sum) s = all(0.0f);
  }
  HWY_INLINE void addStep(const float* triangle_q, const uint16_t* entry) {
    const Lanes weights = hn::ZeroExtendVector(D(), ringWeights(entry + kRingLanes));
    for (uint32_t i = 0; i < 4; ++i) {
      const __m512 first = _mm512_castps256_ps512(_mm256_loadu_ps(triangle_q + 8 * size_t{entry[i]}));
      const Lanes q{
          _mm512_mask_broadcast_f32x8(first, 0xff00, _mm256_loadu_ps(triangle_q + 8 * size_t{entry[i + 4]}))};
      sum[i] = sum[i] + permuted(weights, [i](uint32_t lane) { return i + lane / 8 * 4; }) * q;
    }
  }
  HWY_INLINE void store(float* out, size_t step) {
    transpose(sum[0], sum[1], sum[2], sum[3]);
    const hn::Half<D> half;
    for (uint32_t l = 0; l < 4; ++l, out += step) {
      const auto low = hn::LowerHalf(half, sum[l]), high = hn::UpperHalf(half, sum[l]);
      hn::StoreU(hn::LowerHalf(D4(), low), D4(), out);
      hn::StoreU(hn::UpperHalf(D4(), low), D4(), out + 4 * step);
      hn::StoreU(hn::LowerHalf(D4(), high), D4(), out + 4);
      hn::StoreU(hn::UpperHalf(D4(), high), D4(), out + 4 * step + 4);
    }
  }
};

#endif

// Points 0, 1, 4 and 5, then the others; each has both its layers side by side.
template <>
struct Rings<2> {
  RingVector sum[kRingVectors][2];

  HWY_INLINE Rings() {
    for (auto& s : sum) s[0] = s[1] = hn::Zero(DRing());
  }
  HWY_INLINE void addStep(const float* triangle_q, const uint16_t* entry) {
    const DRing d;
    for (uint32_t i = 0; i < kRingVectors; ++i, entry += kRingWidth) {
      const RingVector weights = ringWeights(entry + kRingLanes);
      sum[i][0] = sum[i][0] + hn::InterleaveLower(d, weights, weights) * gatherPairs(triangle_q, entry);
      sum[i][1] = sum[i][1] + hn::InterleaveUpper(d, weights, weights) * gatherPairs(triangle_q, entry + 2);
    }
  }
  HWY_INLINE void store(float* out, size_t step) const {
    const DRing d;
    for (uint32_t i = 0; i < kRingVectors; ++i) {
      const auto low = hn::InterleaveLower(d, sum[i][0], sum[i][1]),
                 high = hn::InterleaveUpper(d, sum[i][0], sum[i][1]);
      hn::StoreU(hn::InterleaveLower(d, low, high), d, out + kRingWidth * i);
      hn::StoreU(hn::InterleaveUpper(d, low, high), d, out + step + kRingWidth * i);
    }
  }

 private:
  HWY_INLINE static Block pairs(const float* from, const uint16_t* index) {
    const hn::FixedTag<float, 2> d;
    return hn::Combine(D4(), hn::LoadU(d, from + 2 * size_t{index[1]}),
                       hn::LoadU(d, from + 2 * size_t{index[0]}));
  }
  HWY_INLINE static RingVector gatherPairs(const float* from, const uint16_t* index) {
#if HWY_MAX_BYTES >= 32
    return hn::Combine(DRing(), pairs(from, index + 4), pairs(from, index));
#else
    return pairs(from, index);
#endif
  }
};

// q of kWidth triangles in kLayers layers, the layers of each triangle side by side.
template <uint32_t kLayers>
HWY_INLINE void storeSideBySide(Lanes (&q)[kLayers], float* out) {
  if constexpr (kLayers == 1) {
    store(q[0], out);
  } else if constexpr (kLayers == 2) {
    storeBlocks(hn::InterleaveLower(D(), q[0], q[1]), out, 8);
    storeBlocks(hn::InterleaveUpper(D(), q[0], q[1]), out + 4, 8);
  } else {
    Lanes rows[kLayers];  // four layers of every fourth triangle each
    for (uint32_t l = 0; l < kLayers; l += 4) {
      transpose(q[l], q[l + 1], q[l + 2], q[l + 3]);
      for (uint32_t i = 0; i < 4; ++i) rows[(kLayers * i + l) / 4] = q[l + i];
    }
    for (uint32_t i = 0; i < kLayers; i += kBlocks) storeColumns(rows + i, out + 4 * i, 4 * kLayers);
  }
}

#endif

HWY_INLINE void fetch(const void* at) {
#if HWY_ARCH_X86
  _mm_prefetch(static_cast<const char*>(at), _MM_HINT_T0);
#else
  hwy::Prefetch(at);
#endif
}

// The memory of the next cluster is fetched while one is worked on, in equal steps.
class Ahead {
 public:
  Ahead(const ClusterFrameJob& job, const Cluster& c, const Cluster& next)
      : posed_(job.posed),
        stride_(job.posed_stride),
        every_(job.posed ? std::max(1u, static_cast<uint32_t>(40 / job.posed_stride)) : 1) {
    const uint32_t steps = c.triangles / kTriangleLanes + (c.points + kRingLanes - 1) / kRingLanes;
    const uint32_t* words = job.clusters->words.data();
    word_ = words + (job.posed ? next.slot_vertex : next.pose);
    words_end_ = words + next.end;
    words_a_step_ =
        (static_cast<uint32_t>(words_end_ - word_) / (2 * kLineWords) / steps + 1) * 2 * kLineWords;
    vertex_ = words + next.slot_vertex;
    vertices_end_ = vertex_ + (job.posed ? next.slots : 0);
    vertices_a_step_ = (static_cast<uint32_t>(vertices_end_ - vertex_) / every_ / steps + 1) * every_;
  }
  HWY_INLINE void step() {
    const uint32_t *word = word_, *vertex = vertex_;
    const uint32_t* const step_end = std::min(word + words_a_step_, words_end_);
    for (; word < step_end; word += 2 * kLineWords) fetch(word), fetch(word + kLineWords);
    const uint32_t* const vertices_end = std::min(vertex + vertices_a_step_, vertices_end_);
    for (; vertex < vertices_end; vertex += every_) fetch(posed_ + *vertex * stride_);
    word_ = word, vertex_ = vertex;
  }

 private:
  const std::byte* posed_;
  const size_t stride_;
  const uint32_t every_;  // neighbouring slots mostly share a cache line
  const uint32_t *word_, *words_end_, *vertex_, *vertices_end_;
  uint32_t words_a_step_, vertices_a_step_;
};

// Bit l: layer l is measured in the cluster.
HWY_INLINE uint32_t measuredLayers(const ClusterFrameJob& job, const Cluster& c) {
  return c.covered & job.active_layers;
}

// Slots to be posed: the halo is for measuring alone.
HWY_INLINE uint32_t posedSlots(const ClusterFrameJob& job, const Cluster& c) {
  return measuredLayers(job, c) != 0 ? c.slots : c.vertices;
}

// f(i) for i in [begin, end): loops this short cost as much as what is in them.
template <typename Function>
HWY_INLINE void inFours(uint32_t begin, uint32_t end, Function f) {
  for (; begin + 4 <= end; begin += 4) f(begin), f(begin + 1), f(begin + 2), f(begin + 3);
  for (; begin < end; ++begin) f(begin);
}

// Where the weights will be stored: what is not in a cache then would hold up all that follows.
HWY_INLINE void fetchWeights(const ClusterFrameJob& job, const Cluster& c) {
  const uint32_t* vertex = &job.clusters->words[c.slot_vertex];
  const size_t stride = job.clusters->asset->weightStride();
  for (uint32_t i = 0; i < c.vertices; i += 4) fetch(job.weights.data() + vertex[i] * stride);
}

// x, y, z and anything; the last vertex of the host's array must not be read beyond. All that the loop needs
// is in variables of its own, for the compiler must take `out` to be anywhere.
HWY_NOINLINE void copyHostPositions(const ClusterFrameJob& job, const Cluster& c, float* out) {
  const uint32_t* vertex = &job.clusters->words[c.slot_vertex];
  const std::byte* posed = job.posed;
  const size_t stride = job.posed_stride;
  const uint32_t last = c.last_slot, slots = c.slots;
  const auto copy = [=](uint32_t i) {
    std::memcpy(out + 4 * size_t{i}, posed + vertex[i] * stride, sizeof(Float4));
  };
  inFours(0, last, copy);
  if (last == slots) return;
  std::memcpy(out + 4 * size_t{last}, posed + vertex[last] * stride, sizeof(Float3));
  out[4 * size_t{last} + 3] = 0.0f;
  inFours(last + 1, slots, copy);
}

// Positions of kPoseLanes slots by coordinate: theirs begin at 0, kPoseLanes and 2 * kPoseLanes.
HWY_INLINE void unpackRest(const RestHeader& rest, const uint32_t* group, float* out) {
  if (!rest.quantized) {
    std::memcpy(out, group, 3 * kPoseLanes * sizeof(float));
    return;
  }
  const auto* steps = reinterpret_cast<const uint16_t*>(group);
  for (uint32_t k = 0; k < 3; ++k)
    for (uint32_t i = k * kPoseLanes; i < (k + 1) * kPoseLanes; i += kWidth)
      store(all(rest.offset[k]) + all(rest.step) * fromUint16(steps + i, rest.first[k]), out + i);
}

// unorm16, the first of each slot being what the others leave of 65535: kPoseLanes an influence.
HWY_INLINE void unpackWeights(const uint16_t* packed, uint32_t influences, float* out) {
  for (uint32_t i = 0; i < kPoseLanes; i += kWidth) {
    Lanes first = all(65535.0f);
    for (uint32_t k = 1; k < influences; ++k) {
      const Lanes w = fromUint16(packed + (k - 1) * kPoseLanes + i);
      first = first - w;
      store(w * all(kUnorm16), out + k * kPoseLanes + i);
    }
    store(first * all(kUnorm16), out + i);
  }
}

// Adds the active morph targets to positions by coordinate.
bool addMorphs(const ClusterFrameJob& job, const Cluster& c, const RestHeader& rest, const uint32_t* group,
               uint32_t group_words, float* out) {
  const Clusters& clusters = *job.clusters;
  const size_t index = static_cast<size_t>(&c - clusters.clusters.data());
  const auto runs = std::span(clusters.morph_runs)
                        .subspan(clusters.morph_run_begin[index],
                                 clusters.morph_run_begin[index + 1] - clusters.morph_run_begin[index]);
  const auto active = [&](const Clusters::MorphRun& run) { return job.morph_weights[run.morph] != 0.0f; };
  if (std::none_of(runs.begin(), runs.end(), active)) return false;
  for (uint32_t s = 0; s < posedSlots(job, c); s += kPoseLanes, group += group_words)
    unpackRest(rest, group, out + 4 * size_t{s});
  for (const Clusters::MorphRun& run : runs) {
    if (!active(run)) continue;
    const Morph& morph = clusters.asset->morphs[run.morph];
    const float step = job.morph_weights[run.morph] * morph.position_step;
    for (uint32_t i = run.begin; i < run.end; ++i) {
      const size_t slot = clusters.morph_slots[i];
      float* p = out + 4 * (slot / kPoseLanes * kPoseLanes) + slot % kPoseLanes;
      const int32_t* delta = &morph.position_deltas[3 * size_t{clusters.morph_index[i]}];
      for (size_t k = 0; k < 3; ++k)
        p[k * kPoseLanes] = p[k * kPoseLanes] + step * static_cast<float>(delta[k]);
    }
  }
  return true;
}

template <typename Joint>
HWY_NOINLINE void posePositions(const ClusterFrameJob& job, const Cluster& c, float* out) {
  const Clusters& clusters = *job.clusters;
  const uint32_t influences = clusters.asset->influences;
  RestHeader rest;
  std::memcpy(&rest, &clusters.words[c.pose], sizeof rest);
  const uint32_t* group = &clusters.words[c.pose] + kRestHeaderWords;
  const uint32_t group_words = clusters.poseGroupWords(rest.quantized != 0);
  const uint32_t rest_words = (rest.quantized ? 3 : 6) * kPoseLanes / 2;
  const bool morphed = addMorphs(job, c, rest, group, group_words, out);
  alignas(64) float weights[kMostInfluences * kPoseLanes];
  const uint32_t slots = posedSlots(job, c);
  for (uint32_t s = 0; s < slots; s += kPoseLanes, group += group_words, out += 4 * kPoseLanes) {
    alignas(64) float p[3 * kPoseLanes];
    if (morphed)
      std::memcpy(p, out, sizeof p);
    else
      unpackRest(rest, group, p);
    const auto* packed = reinterpret_cast<const uint16_t*>(group + rest_words);
    const auto* joints = reinterpret_cast<const Joint*>(packed + (influences - 1) * kPoseLanes);
    unpackWeights(packed, influences, weights);
    for (uint32_t i = 0; i < kPoseLanes; i += kWidth) {
      Lanes x = load(p + i), y = load(p + kPoseLanes + i), z = load(p + 2 * kPoseLanes + i), w = all(0.0f);
      transformPoints(
          blend(job.palette.data(), joints + i * influences, influences, weights + i, 1, kPoseLanes), x, y,
          z);
      store4(x, y, z, w, out + 4 * i);
    }
  }
}

// The positions of one corner of triangles 0, 4, 8 and 12, as many as there are blocks.
HWY_INLINE Lanes corners(const float* positions, const uint16_t* corner) {
  return gatherBlocks([&](int i) HWY_ATTR { return positions + corner[12 * i]; });
}

// Edges of kWidth triangles by coordinate.
struct Edges {
  Edges() = default;
  HWY_INLINE Edges(const float* positions, const uint16_t* corner) {
    Lanes e1[4], e2[4];
    for (int i = 0; i < 4; ++i) {
      const Lanes p0 = corners(positions, corner + 3 * i);
      e1[i] = corners(positions, corner + 3 * i + 1) - p0;
      e2[i] = corners(positions, corner + 3 * i + 2) - p0;
    }
    transpose(e1[0], e1[1], e1[2], e1[3]);
    transpose(e2[0], e2[1], e2[2], e2[3]);
    x1 = e1[0], y1 = e1[1], z1 = e1[2];
    x2 = e2[0], y2 = e2[1], z2 = e2[2];
  }
  Lanes x1, y1, z1, x2, y2, z2;
};

// A measure gives q of kWidth triangles, from the coefficients at c; all-zero coefficients give 0.

struct Directional {
  static constexpr uint32_t kCoefficients = 2;
  HWY_INLINE static Lanes of(const Edges& e, const float* c, Lanes inverse_scale2) {
    const Lanes c0 = load(c), c1 = load(c + kTriangleLanes);
    const Lanes x = c0 * e.x1 + c1 * e.x2, y = c0 * e.y1 + c1 * e.y2, z = c0 * e.z1 + c1 * e.z2;
    return ((x * x + y * y) + z * z) * inverse_scale2;
  }
};

struct Area {
  static constexpr uint32_t kCoefficients = 1;
  HWY_INLINE static Lanes of(const Edges& e, const float* c, Lanes inverse_scale2) {
    const Lanes x = e.y1 * e.z2 - e.z1 * e.y2;
    const Lanes y = e.z1 * e.x2 - e.x1 * e.z2;
    const Lanes z = e.x1 * e.y2 - e.y1 * e.x2;
    return (root((x * x + y * y) + z * z) * load(c)) * inverse_scale2;
  }
};

struct Principal {
  static constexpr uint32_t kCoefficients = 3;
  HWY_INLINE static Lanes of(const Edges& e, const float* c, Lanes inverse_scale2) {
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

// q clamped to [0, kMaxQ]. What is not a number is 1, but 0 with coefficients that are all zero: it must not
// be seen in a ring that the triangle is not in.
template <typename Measured>
HWY_INLINE Lanes clampedQ(const Edges& edges, const float* c, Lanes inverse_scale2) {
  const Lanes q = Measured::of(edges, c, inverse_scale2);
  if (allNotNegative(q)) [[likely]]
    return atMost(q, kMaxQ);
  const Lanes zero = all(0.0f);
  Lanes used = zero;
  for (uint32_t k = 0; k < Measured::kCoefficients; ++k) {
    const Lanes one = load(c + k * kTriangleLanes);
    used = used + ifNegative(one, zero - one, one);
  }
  const Lanes otherwise = ifNegative(q, zero, ifPositive(used, all(1.0f), zero));
  return ifNotNegative(q, atMost(q, kMaxQ), otherwise);
}

HWY_INLINE Lanes clampedQ(Measure measure, const Edges& edges, const float* c, Lanes inverse_scale2) {
  return measure == Measure::kDirectional ? clampedQ<Directional>(edges, c, inverse_scale2)
         : measure == Measure::kArea      ? clampedQ<Area>(edges, c, inverse_scale2)
                                          : clampedQ<Principal>(edges, c, inverse_scale2);
}

// The layers of a pass that a cluster measures.
struct Pass {
  uint32_t count = 0;
  bool directional = true;  // all of them
  Measure measures[kPass];
  const float* coefficients[kPass];
};

// Of up to kLayers layers.
template <uint32_t kLayers, bool kDirectional>
HWY_NOINLINE void measure(const Cluster& c, const uint16_t* corner, const Pass& pass, Lanes inverse_scale2,
                          const float* positions, Ahead& ahead, float* triangle_q) {
  for (uint32_t group = 0; group < c.triangles; group += kTriangleLanes) {
    ahead.step();
    for (uint32_t i = 0; i < kTriangleLanes; i += kWidth) {
      const Edges edges(positions, corner + 3 * (group + i));
      Lanes q[kLayers];
      for (uint32_t l = 0; l < kLayers; ++l) {
        if (l > kLayers / 2 && l >= pass.count)  // what the compiler knows of needs no branch
          q[l] = all(0.0f);
        else if constexpr (kDirectional)
          q[l] = clampedQ<Directional>(edges, pass.coefficients[l] + Directional::kCoefficients * group + i,
                                       inverse_scale2);
        else
          q[l] =
              clampedQ(pass.measures[l], edges,
                       pass.coefficients[l] + coefficientCount(pass.measures[l]) * group + i, inverse_scale2);
      }
      storeSideBySide(q, triangle_q + kLayers * (group + i));
    }
  }
}

template <uint32_t kLayers>
HWY_NOINLINE void smooth(const Cluster& c, const uint32_t* words, const float* triangle_q, Ahead& ahead,
                         float* sums, size_t step) {
  const uint32_t* chunk = words + c.chunks;
  for (uint32_t point = 0; point < c.points; point += kRingLanes, ++chunk) {
    ahead.step();
    Rings<kLayers> rings;
    const auto* end = reinterpret_cast<const uint16_t*>(words + chunk[1]);
    for (const auto* entry = reinterpret_cast<const uint16_t*>(words + chunk[0]); entry < end;
         entry += 2 * kRingLanes)
      rings.addStep(triangle_q, entry);
    rings.store(sums + point, step);
  }
}

// Sums become means, 1 where the ring has no weight in the layer.
HWY_INLINE void divide(const uint16_t* totals, uint32_t points, float* q) {
  for (uint32_t i = 0; i < points; i += kWidth) {
    const Lanes total = fromUint16(totals + i);
    store(ifPositive(total, load(q + i) / total, all(1.0f)), q + i);
  }
}

// q of the layers of a pass that the cluster measures, of its vertices: a row each, and how many rows.
HWY_INLINE uint32_t measureLayers(const ClusterFrameJob& job, const Cluster& c, uint32_t first, Ahead& ahead,
                                  const ClusterScratch& scratch) {
  const Clusters& clusters = *job.clusters;
  const AssetView& asset = *clusters.asset;
  const uint32_t* words = clusters.words.data();
  const uint32_t* measured_with = job.rest.empty() ? words + c.layers : job.rest.data() + c.rest;
  const size_t index = static_cast<size_t>(&c - clusters.clusters.data());
  Pass pass;
  const float* totals[kPass];
  for (uint32_t l = first; l < std::min(first + kPass, asset.layerCount()); ++l) {
    if (!(measuredLayers(job, c) >> l & 1u)) continue;
    const Measure measure = asset.layers[l].measure;
    const auto* coefficients = reinterpret_cast<const float*>(
        measured_with + (clusters.layer_words[index * asset.layerCount() + l] - c.layers));
    totals[pass.count] = coefficients + size_t{c.triangles} * coefficientCount(measure);
    pass.directional = pass.directional && measure == Measure::kDirectional;
    pass.measures[pass.count] = measure;
    pass.coefficients[pass.count++] = coefficients;
  }
  const auto run = [&](auto layers) HWY_ATTR {
    const auto* corner = reinterpret_cast<const uint16_t*>(words + c.corners);
    const Lanes inverse_scale2 = all(1.0f / (job.scale * job.scale));
    if (pass.directional)
      measure<layers, true>(c, corner, pass, inverse_scale2, scratch.positions, ahead, scratch.triangle_q);
    else
      measure<layers, false>(c, corner, pass, inverse_scale2, scratch.positions, ahead, scratch.triangle_q);
    smooth<layers>(c, words, scratch.triangle_q, ahead, scratch.q, scratch.padded);
  };
  if (pass.count == 0)
    return 0;
  else if (pass.count == 1)
    run(std::integral_constant<uint32_t, 1>());
  else if (pass.count == 2)
    run(std::integral_constant<uint32_t, 2>());
  else if (pass.count <= 4)
    run(std::integral_constant<uint32_t, 4>());
  else
    run(std::integral_constant<uint32_t, kPass>());
  const auto* extra = reinterpret_cast<const uint16_t*>(words + c.extra_point);
  for (uint32_t l = 0; l < pass.count; ++l) {
    float* q = scratch.q + l * scratch.padded;
    divide(reinterpret_cast<const uint16_t*>(totals[l]), c.points, q);
    for (uint32_t i = c.points; i < c.vertices; ++i) q[i] = q[extra[i - c.points]];
  }
  return pass.count;
}

// One half of the weights of a pair of layers.
void respondLayer(const ClusterFrameJob& job, const Cluster& c, uint32_t l, const float* q, float* bias,
                  uint32_t* pairs) {
  const Layer& layer = job.clusters->asset->layers[l];
  const uint32_t* vertex = &job.clusters->words[c.slot_vertex];
  if (!(job.active_layers >> l & 1u)) {
    if (l % 2 == 0) std::fill_n(pairs, c.vertices, 0u);
    return;
  }
  if (layer.bias.empty())
    std::fill_n(bias, c.vertices, 0.0f);
  else
    for (uint32_t i = 0; i < c.vertices; ++i)
      bias[i] = static_cast<float>(layer.bias[vertex[i]]) * (1.0f / 32767.0f);
  respondPairs(job.responses.empty() ? layer.response : job.responses[l], q, bias,
               job.region_weights.empty() ? 0.0f : job.region_weights[l], c.vertices, l % 2 != 0, pairs);
}

// Rows of pairs side by side, a vertex.
HWY_INLINE void storePairs(const uint32_t* vertex, uint32_t count, const uint32_t* pairs, uint32_t rows,
                           size_t padded, int16_t* weights, size_t stride) {
  for (; rows >= 2; rows -= 2, pairs += 2 * padded, weights += 4)
    inFours(0, count, [=](uint32_t i) {
      const uint32_t two[] = {pairs[i], pairs[padded + i]};
      std::memcpy(weights + vertex[i] * stride, two, sizeof two);
    });
  if (rows > 0)
    inFours(0, count,
            [=](uint32_t i) { std::memcpy(weights + vertex[i] * stride, pairs + i, sizeof(uint32_t)); });
}

}  // namespace

void runCluster(const ClusterFrameJob& job, const Cluster& c, const ClusterScratch& scratch) {
  const Clusters& clusters = *job.clusters;
  const AssetView& asset = *clusters.asset;
  const uint32_t* vertex = &clusters.words[c.slot_vertex];
  const size_t index = static_cast<size_t>(&c - clusters.clusters.data());
  Ahead ahead(job, c, clusters.clusters[std::min(index + 1, clusters.clusters.size() - 1)]);
  fetchWeights(job, c);
  if (job.posed) {
    if (measuredLayers(job, c) != 0) copyHostPositions(job, c, scratch.positions);
  } else if (measuredLayers(job, c) != 0 || !job.positions.empty()) {
    if (clusters.wideJoints())
      posePositions<uint16_t>(job, c, scratch.positions);
    else
      posePositions<uint8_t>(job, c, scratch.positions);
    if (!job.positions.empty())
      inFours(0, c.vertices, [vertex, from = scratch.positions, to = job.positions.data()](uint32_t i) {
        std::memcpy(to + vertex[i], from + 4 * size_t{i}, sizeof(Float3));
      });
  }
  for (uint32_t first = 0; first < asset.layerCount(); first += kPass) {
    const uint32_t count = std::min(kPass, asset.layerCount() - first);
    const uint32_t measured = measureLayers(job, c, first, ahead, scratch);
    float* unmeasured = scratch.q + measured * scratch.padded;
    if (measured < count) std::fill_n(unmeasured, c.vertices, 1.0f);
    float* q = scratch.q;
    for (uint32_t l = 0; l < count; ++l) {
      const bool covered = measuredLayers(job, c) >> (first + l) & 1u;
      respondLayer(job, c, first + l, covered ? q : unmeasured, scratch.bias,
                   scratch.pairs + l / 2 * scratch.padded);
      if (covered) q += scratch.padded;
    }
    storePairs(vertex, c.vertices, scratch.pairs, (count + 1) / 2, scratch.padded, &job.weights[first],
               asset.weightStride());
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace furrow
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace furrow {
namespace {

constexpr ClusterRun kRuns[] = FURROW_TARGETS(runCluster);

}  // namespace

Status ClusterFrameJob::validate() const {
  if (!clusters || !clusters->asset) return Status::error(StatusCode::kInvalidArgument, "frame: no clusters");
  const AssetView& asset = *clusters->asset;
  if (posed ? posed_stride < sizeof(Float3) || posed_stride % sizeof(float) != 0
            : palette.size() != asset.palette.size() || morph_weights.size() != asset.morphs.size())
    return Status::error(StatusCode::kInvalidArgument, "frame: the pose does not fit the asset");
  if (!positions.empty() && (posed || positions.size() < asset.vertexCount()))
    return Status::error(StatusCode::kInvalidArgument,
                         "frame: positions are too short, or posed by the host");
  if (!rest.empty() && rest.size() < clusters->restWords())
    return Status::error(StatusCode::kInvalidArgument, "frame: the rest is too short");
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
  const ClusterRun run_cluster = kRuns[static_cast<size_t>(simd)];
  for (uint32_t i = begin; i < end; ++i)
    run_cluster(*this, clusters->clusters[i],
                scratchOf(clusters->clusters[i], clusters->asset->layerCount(), scratch.data()));
}

}  // namespace furrow
#endif
