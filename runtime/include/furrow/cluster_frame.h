#pragma once

// The clustered frame: pose, compress, smooth and respond in one pass over the surface, the fast path of the
// cpu tier. The staged jobs (jobs.h) are its reference: the weights are the same bits.
//
// The surface is cut into clusters of points that fit a core's own caches. A cluster holds the points it
// owns, a halo of points that their rings reach (posed again rather than waited for) and the triangles of its
// points' rings, so that nothing passes between stages through memory and clusters depend on nothing but the
// pose.

#include <cstddef>
#include <memory_resource>
#include <span>
#include <vector>

#include "furrow/jobs.h"
#include "furrow/simd.h"

namespace furrow {

// Points a cluster owns at most: larger ones repeat less of their neighbours, and what a core works on, 80
// KiB for a layer, stays in its second cache. Assets of fewer than 16 such clusters are cut finer, for the
// sake of threads that share them.
inline constexpr uint32_t kClusterPoints = 2048;
inline constexpr uint32_t kFineClusterPoints = 896;
inline constexpr uint32_t kThreadClusters = 16;

// Triangles are measured this many at a time: their coefficients lie side by side, first the first of each.
inline constexpr uint32_t kTriangleLanes = 16;
// Rings of this many points lie side by side, padded to the longest of them.
inline constexpr uint32_t kRingLanes = 8;
// Slots are posed this many at a time.
inline constexpr uint32_t kPoseLanes = 16;

// What a cluster may hold.
struct ClusterLimits {
  uint32_t points = 0;         // owned; 0: what suits a CPU, kFineClusterPoints to kClusterPoints
  uint32_t slots = 16384;      // at most so many: a corner is 4 * slot in 16 bits
  uint32_t triangles = 65520;  // at most so many: a ring entry has 16 bits
};

// Takes memory at cache lines.
template <typename T>
struct LineAllocator : std::pmr::polymorphic_allocator<T> {
  using std::pmr::polymorphic_allocator<T>::polymorphic_allocator;
  template <typename U>
  struct rebind {
    using other = LineAllocator<U>;
  };
  T* allocate(size_t count) { return static_cast<T*>(this->resource()->allocate(count * sizeof(T), 64)); }
  void deallocate(T* memory, size_t count) { this->resource()->deallocate(memory, count * sizeof(T), 64); }
};

// One cluster: where its data begin in Clusters::words. 16-bit data lie two to a word, the lower first.
struct Cluster {
  uint32_t points;  // owned; the first slots
  uint32_t
      vertices;    // owned: a slot for each point's first vertex, then for the other vertices of those points
  uint32_t slots;  // vertices and halo
  uint32_t last_slot;    // of the asset's last vertex; `slots`: not here
  uint32_t triangles;    // a multiple of kTriangleLanes: the last ones may be empty
  uint32_t slot_vertex;  // a word a slot: the asset's vertex
  uint32_t extra_point;  // 16 bits a vertex beyond the points: its point
  uint32_t corners;      // 16 bits, 3 a triangle: 4 * slot
  uint32_t layers;       // where layer_words begin
  uint32_t rest;         // where they begin in an instance's own rest
  uint32_t
      chunks;  // a word for every kRingLanes points, and one more: where their ring begins in words. A step
               // of a ring has 16 bits a point, its triangle, then 16 bits a point, that triangle's weight
  uint32_t covered;  // bit l: layer l measures a triangle here
  // What poses the slots, kPoseLanes at a time: 16 words of header, then for each kPoseLanes slots their rest
  // positions x, y, z (16 bits each as steps of the part's quantisation, else floats), the weights of their
  // joints but the first (unorm16, kPoseLanes an influence) and their joints (8 or 16 bits, slot by slot).
  uint32_t pose;
  uint32_t end;  // of the cluster's words, which begin with the pose
};

// How an asset's surface is cut. Immutable after build(); any number of threads and instances may read it.
class Clusters {
 public:
  // `memory` holds what build() makes; it must outlive the clusters. Working memory of build() is C++'s own.
  explicit Clusters(std::pmr::memory_resource* memory = std::pmr::new_delete_resource());

  // Takes O(n log n) time and about 32 bytes a triangle and 10 more a layer, and allocates; `asset` must
  // outlive it. Fails with kOutOfMemory, or kUnavailable where a single point is in more triangles than a
  // cluster may hold (about 16,000): such an asset has the staged jobs alone. The same asset gives the same
  // clusters everywhere.
  Status build(const AssetView& asset, const ClusterLimits& limits = {});

  uint32_t count() const { return static_cast<uint32_t>(clusters.size()); }
  // Bytes of scratch memory that every thread needs, aligned to 64.
  size_t scratchBytes() const { return scratch_bytes_; }
  // Bytes that a frame reads and writes all told: with positions that the host has posed, 12 bytes each, or
  // posed by the palette (without the palette, morph targets and biases, and no positions written).
  uint64_t frameBytes(bool posed) const;

  // Joints take 16 bits, since the palette has more than 256 entries.
  bool wideJoints() const { return asset->palette.size() > 256; }
  // Words of an instance's own rest (recapture.h): for each cluster what its layers have in `words`.
  size_t restWords() const { return rest_words_; }
  // Words of kPoseLanes slots in a cluster's pose.
  uint32_t poseGroupWords(bool quantized) const {
    return kPoseLanes / 2 * ((quantized ? 3 : 6) + asset->influences - 1) +
           kPoseLanes / 4 * asset->influences * (wideJoints() ? 2 : 1);
  }

  struct MorphRun {
    uint32_t morph;
    uint32_t begin, end;  // in morph_slots and morph_index
  };

  const AssetView* asset = nullptr;
  std::pmr::vector<Cluster> clusters;
  std::vector<uint32_t, LineAllocator<uint32_t>> words;
  // layerCount() a cluster, for the layers it covers: first the coefficients, coefficientCount(measure) x
  // kTriangleLanes floats for every kTriangleLanes triangles, then 16 bits a point: the ring's weights that
  // are in the layer; 0: none.
  std::pmr::vector<uint32_t> layer_words;
  std::pmr::vector<uint32_t> morph_run_begin;  // clusters + 1, in morph_runs
  std::pmr::vector<MorphRun> morph_runs;       // a cluster: its morph targets, ascending
  std::pmr::vector<uint16_t> morph_slots;
  std::pmr::vector<uint32_t> morph_index;  // a slot of a run: which of Morph::vertices

 private:
  size_t scratch_bytes_ = 0, rest_words_ = 0;
};

// One frame of one instance. Items: clusters, any number of threads on disjoint ranges. Does not allocate,
// lock or throw.
struct ClusterFrameJob {
  const Clusters* clusters = nullptr;

  // Either the host's posed vertices: float x, y, z at posed + i * posed_stride, in the asset's vertex order.
  const std::byte* posed = nullptr;
  size_t posed_stride = sizeof(Float3);  // at least 12, a multiple of 4
  // Or, with posed null, a palette and morph weights as for DeformJob, posed on the way.
  std::span<const Affine> palette;
  std::span<const float> morph_weights;
  std::span<Float3> positions;  // out, posed by the palette, a vertex; or empty

  std::span<const uint32_t> rest;         // the instance's own, of ClusterRecaptureJob; or empty: the asset's
  float scale = 1.0f;                     // uniform scale of the instance that the pose contains, > 0
  std::span<const Response> responses;    // a layer; or empty: the asset's
  std::span<const float> region_weights;  // a layer; or empty: 0
  uint32_t active_layers = 0xffffu;       // bit l: layer l is computed; the others cost nothing and weigh 0
  std::span<int16_t> weights;             // out, weightStride() a vertex
  Simd simd = bestSimd();

  Status validate() const;
  // `scratch`: Clusters::scratchBytes(), aligned to 64, for this call alone.
  void run(uint32_t begin, uint32_t end, std::span<std::byte> scratch) const;
};

}  // namespace furrow
