// furrow.h's pictures: the rasteriser over the host's jobs.

#include "furrow/raster.h"
#include "host_asset.h"

namespace furrow {
namespace {

constexpr uint32_t kVertexGrain = 2048;
constexpr size_t kAlignment = 64;

size_t aligned(size_t bytes) {
  return (bytes + kAlignment - 1) / kAlignment * kAlignment;
}

// What lies in a picture's memory, in this order.
struct Layout {
  Layout(const FurrowAsset& asset, uint32_t width, uint32_t height)
      : vertices(aligned(asset.view.vertexCount() * sizeof(RasterVertex))),
        bins(aligned(rasterBinWords(asset.view.triangleCount(), width, height) * sizeof(uint64_t))),
        scratch(kRasterScratchBytes * asset.context.desc.workers) {}
  size_t bytes() const { return vertices + bins + scratch; }

  size_t vertices, bins, scratch;
};
static_assert(kRasterScratchBytes % kAlignment == 0);

bool drawable(uint32_t width, uint32_t height) {
  return width >= 1 && height >= 1 && width <= kMaxRasterSide && height <= kMaxRasterSide;
}

Status draw(const FurrowAsset& asset, const FurrowPicture& in) {
  const AssetView& view = asset.view;
  if (!drawable(in.width, in.height)) return invalid("picture: sides are from 1 to 4096 pixels");
  if (!in.positions) return invalid("picture.positions is NULL");
  const Layout layout(asset, in.width, in.height);
  if (!in.memory || in.memory_bytes < layout.bytes() ||
      reinterpret_cast<uintptr_t>(in.memory) % kAlignment != 0)
    return invalid("picture.memory is less than furrow_picture_memory() or not aligned to 64");
  const size_t vertices = view.vertexCount(), pixels = size_t{in.width} * in.height;
  auto* memory = static_cast<std::byte*>(in.memory);
  std::byte* scratch = memory + layout.vertices + layout.bins;
  RasterJob job;
  job.asset = &view;
  job.positions = {reinterpret_cast<const Float3*>(in.positions), vertices};
  std::copy(std::begin(in.view_projection), std::end(in.view_projection), job.view_projection);
  job.width = in.width;
  job.height = in.height;
  if (in.samples != 0) job.samples = in.samples;
  if (in.colors) job.colors = {reinterpret_cast<const Float3*>(in.colors), vertices};
  if (in.back_colors) job.back_colors = {reinterpret_cast<const Float3*>(in.back_colors), vertices};
  if (in.gloss) job.gloss = {reinterpret_cast<const Float3*>(in.gloss), vertices};
  if (in.back_gloss) job.back_gloss = {reinterpret_cast<const Float3*>(in.back_gloss), vertices};
  if (in.weights) job.weights = {in.weights, vertices * view.weightStride()};
  if (in.vertex_shade != 0.0f) job.vertex_shade = in.vertex_shade;
  job.vertices = {reinterpret_cast<RasterVertex*>(memory), vertices};
  job.bins = {reinterpret_cast<uint64_t*>(memory + layout.vertices),
              rasterBinWords(view.triangleCount(), in.width, in.height)};
  if (in.picture) job.picture = {reinterpret_cast<Float4*>(in.picture), pixels};
  if (in.depth) job.depth = {in.depth, pixels};
  job.simd = asset.context.simd;
  if (const Status status = job.validate(); !status.ok()) return status;
  const FurrowContext& context = asset.context;
  const bool projected = parallel(context, view.vertexCount(), kVertexGrain,
                                  [&](uint32_t begin, uint32_t end, uint32_t) { job.project(begin, end); });
  const bool binned =
      projected && parallel(context, rasterBatches(view.triangleCount()), 1,
                            [&](uint32_t begin, uint32_t end, uint32_t) { job.bin(begin, end); });
  return soundness(
      binned &&
      parallel(context, rasterTiles(in.width, in.height), 1,
               [&](uint32_t begin, uint32_t end, uint32_t worker) {
                 job.draw(begin, end, {scratch + worker * kRasterScratchBytes, kRasterScratchBytes});
               }));
}

}  // namespace
}  // namespace furrow

size_t furrow_picture_memory(const FurrowAsset* asset, uint32_t width, uint32_t height) {
  return asset && furrow::drawable(width, height) ? furrow::Layout(*asset, width, height).bytes() : 0;
}

int32_t furrow_picture_draw(const FurrowAsset* asset, const FurrowPicture* picture, FurrowStatus* status) {
  return furrow::guarded(status, [&] {
    FurrowPicture in;
    if (furrow::Status read = furrow::readStruct(picture, in, "picture"); !read.ok()) return read;
    return asset ? furrow::draw(*asset, in) : furrow::invalid("the asset is NULL");
  });
}
