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
  float* triangle_q;  // a row a layer of a pass
  float* q;           // a row of `padded` a layer of a pass
  float* bias;        // `padded`
  uint32_t* pairs;    // a row of `padded` a pair of layers of a pass: their weights
};
// Layers that share their triangles' edges and their rings' gathers.
inline constexpr uint32_t kMostInPass = 8;

// Cuts `memory` up; a cluster takes the bytes that the second form tells.
ClusterScratch scratchOf(const Cluster& cluster, uint32_t layers, std::byte* memory);
size_t scratchBytes(const Cluster& cluster, uint32_t layers);

using ClusterRun = void (*)(const ClusterFrameJob& job, const Cluster& cluster,
                            const ClusterScratch& scratch);

}  // namespace furrow
