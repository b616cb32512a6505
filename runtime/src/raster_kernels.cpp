// Compiled once for every instruction set (hwy/foreach_target.h). Edges are integers and depths have one
// expression order with nothing fused: every instruction set gives the same bits.

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "src/raster_kernels.cpp"
#include "src/raster_kernels.h"

#include "src/targets.h"
// targets.h first: it says for what the others compile.
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace furrow {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using DF = hn::CappedTag<float, 16>;
using DI = hn::Rebind<int32_t, DF>;
using DU = hn::Rebind<uint32_t, DF>;

void fill(const RasterPatch& p, uint32_t samples, float* depth, uint32_t* triangles) {
  const DF df;
  const DI di;
  const DU du;
  const auto lanes = static_cast<uint32_t>(hn::Lanes(df));
  const auto triangle = hn::Set(du, p.triangle);
  const auto z_x = hn::Set(df, p.z_x), z_low = hn::Set(df, p.z_low), z_high = hn::Set(df, p.z_high);
  const auto lane = hn::Iota(di, 0);
  const auto lane_step = hn::Set(di, static_cast<int32_t>(lanes));
  const auto step0 = hn::Set(di, p.edge_x[0]), step1 = hn::Set(di, p.edge_x[1]),
             step2 = hn::Set(di, p.edge_x[2]);
  for (uint32_t s = 0; s < samples; ++s)
    for (uint32_t y = p.y0; y < p.y1; ++y) {
      const auto down = static_cast<int32_t>(y - p.y0);
      auto column = lane;
      const auto e0 = hn::Set(di, p.edge[s][0] + down * p.edge_y[0]),
                 e1 = hn::Set(di, p.edge[s][1] + down * p.edge_y[1]),
                 e2 = hn::Set(di, p.edge[s][2] + down * p.edge_y[2]);
      const auto z_row = hn::Set(df, p.z[s] + p.z_y * static_cast<float>(y));
      const size_t row = (size_t{s} * kRasterTile + y) * kRasterTile;
      for (uint32_t x = p.x0; x < p.x1; x += lanes, column = column + lane_step) {
        const auto outside = hn::Or(hn::Or(e0 + column * step0, e1 + column * step1), e2 + column * step2);
        const auto covered = hn::RebindMask(df, outside > hn::Set(di, -1));
        if (hn::AllFalse(df, covered)) continue;
        const auto at = hn::ConvertTo(df, column + hn::Set(di, static_cast<int32_t>(p.x0)));
        const auto z = hn::Min(hn::Max(z_row + z_x * at, z_low), z_high);
        const auto there = hn::Load(df, depth + row + x);
        const auto nearer = hn::And(covered, z <= there);
        hn::Store(hn::IfThenElse(nearer, z, there), df, depth + row + x);
        hn::Store(hn::IfThenElse(hn::RebindMask(du, nearer), triangle, hn::Load(du, triangles + row + x)), du,
                  triangles + row + x);
      }
    }
}

}  // namespace

RasterKernel rasterKernelHere() {
  return {static_cast<uint32_t>(hn::Lanes(DF())), fill};
}

}  // namespace HWY_NAMESPACE
}  // namespace furrow
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace furrow {

RasterKernel rasterKernel(Simd simd) {
  static constexpr RasterKernel (*kKernels[])() = FURROW_TARGETS(rasterKernelHere);
  return simdAvailable(simd) ? kKernels[static_cast<size_t>(simd)]() : RasterKernel();
}

}  // namespace furrow
#endif
