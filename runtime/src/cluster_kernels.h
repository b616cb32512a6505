#pragma once

// What the clustered frame's kernels, which are compiled for every instruction set, share with the rest.

#include "furrow/cluster_frame.h"

namespace furrow {

inline constexpr uint32_t kLineWords = 16;  // a cache line

// Before a cluster's packed pose: how its rest positions are stored. `quantized`: as 16-bit integers n, the
// coordinate being offset + step * (first + n), else as floats.
struct RestHeader {
  uint32_t quantized;
  int32_t first[3];
  float offset[3];
  float step;
};
inline constexpr uint32_t kRestHeaderWords = 16;

inline constexpr uint32_t kVertexPad = 128;  // vertices that a response works on at a time, at most

// Scratch memory of one cluster.
struct ClusterScratch {
  size_t padded;      // vertices, to kVertexPad
  float* positions;   // 4 a slot: x, y, z and anything
  float* triangle_q;  // kPack a triangle
  float* q;           // kPack times `padded`
  float* bias;        // `padded`
  uint32_t* pairs;    // `padded`: weights of two layers
};
inline constexpr uint32_t kPack = 4;  // layers that share their triangles' edges and their rings' gathers

// Cuts `memory` up; a cluster takes the bytes that the second form tells.
ClusterScratch scratchOf(const Cluster& cluster, std::byte* memory);
size_t scratchBytes(const Cluster& cluster);

using ClusterRun = void (*)(const ClusterFrameJob& job, const Cluster& cluster,
                            const ClusterScratch& scratch);

}  // namespace furrow
