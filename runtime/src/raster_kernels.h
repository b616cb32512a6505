#pragma once

// What one instruction set offers the rasteriser; raster_kernels.cpp is compiled for each.

#include "furrow/raster.h"

namespace furrow {

inline constexpr uint32_t kRasterBlock = 32;  // pixels a side: in it an edge that passes fits 32 bits
inline constexpr uint32_t kNoTriangle = 0xffffffffu;

// A triangle over some pixels of a block.
struct RasterPatch {
  uint32_t x0, y0, x1, y1;             // in the block; x0 and x1 are multiples of the kernel's lanes
  int32_t edge[kMaxRasterSamples][3];  // at the samples of x0, y0; not negative: inside
  int32_t edge_x[3], edge_y[3];        // steps of a pixel
  float z[kMaxRasterSamples];          // at the samples of the block's first pixel
  float z_x, z_y, z_low, z_high;
  uint32_t triangle;
};

struct RasterKernel {
  uint32_t lanes;
  // Writes depth and triangle where the patch covers a sample and is not behind what is there. Both point to
  // the block's first pixel; rows are kRasterTile apart, samples kRasterTile^2.
  void (*fill)(const RasterPatch& patch, uint32_t samples, float* depth, uint32_t* triangles);
};

// fill is null if this build or CPU lacks it.
RasterKernel rasterKernel(Simd simd);

}  // namespace furrow
