#pragma once

// What one instruction set offers the clustered frame; cluster_frame.cpp fills a table of these for every
// target it is compiled for.

#include "furrow/cluster_frame.h"

namespace furrow {

// Scratch memory of one cluster.
struct ClusterScratch {
  float* positions;  // 4 a slot: x, y, z and anything
  float* triangle_q;
  float* q;          // an owned vertex, padded to kRingLanes
  float* bias;       // the same
  int16_t* weights;  // the same
};

using ClusterRun = void (*)(const ClusterFrameJob& job, const Cluster& cluster,
                            const ClusterScratch& scratch);

}  // namespace furrow
