#include "furrow/raster.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "src/raster_geometry.h"
#include "src/raster_kernels.h"
#include "src/raster_shade.h"

namespace furrow {
namespace {

// Of one sample and of four, in sixteenths of a pixel: edges are evaluated there, and nowhere between.
constexpr int64_t kFine = 16;
struct Offset {
  int32_t x, y;
};
constexpr Offset kSampleOffsets[2][kMaxRasterSamples] = {{{8, 8}}, {{6, 2}, {14, 6}, {2, 10}, {10, 14}}};
static_assert(kSubpixels % kFine == 0 && kRasterTile % kRasterBlock == 0);

constexpr uint32_t kTilePixels = kRasterTile * kRasterTile;
static_assert(kRasterScratchBytes >=
              8 * kMaxRasterSamples * kTilePixels + TriangleShader::kKept * sizeof(ShadedTriangle));
constexpr uint32_t kBatchWords = kRasterBatch / 64;

uint32_t columnsOf(const RasterJob& job) {
  return (job.width + kRasterTile - 1) / kRasterTile;
}

// The words of a tile's batch.
size_t binAt(const RasterJob& job, uint32_t tile, uint32_t batch) {
  return (size_t{tile} * rasterBatches(job.asset->triangleCount()) + batch) * kBatchWords;
}

// Whole pixels around some points, cut to [low, high).
struct Bounds {
  int32_t x0, y0, x1, y1;
  bool empty() const { return x0 >= x1 || y0 >= y1; }
};
Bounds boundsOf(std::span<const RasterVertex> points, const Bounds& limit) {
  Bounds b = {points[0].x, points[0].y, points[0].x, points[0].y};
  for (const RasterVertex& p : points.subspan(1)) {
    b.x0 = std::min(b.x0, p.x);
    b.y0 = std::min(b.y0, p.y);
    b.x1 = std::max(b.x1, p.x);
    b.y1 = std::max(b.y1, p.y);
  }
  const auto pixel = [](int32_t at) {
    return at >= 0 ? at / kSubpixels : -((-at + kSubpixels - 1) / kSubpixels);
  };
  return {std::max(pixel(b.x0), limit.x0), std::max(pixel(b.y0), limit.y0),
          std::min(pixel(b.x1) + 1, limit.x1), std::min(pixel(b.y1) + 1, limit.y1)};
}

struct Edge {
  int64_t x, y, constant;  // x at + y at + constant, at in sixteenths of a pixel; not negative: inside
};

// A triangle of positive area, ready for its blocks.
struct Triangle {
  Edge edges[3];
  double x, y, z, z_x, z_y;  // a corner in pixels, its depth, and steps of a pixel
  float z_low, z_high;
  uint32_t id;
};

// False if it covers nothing.
bool setUp(RasterVertex a, RasterVertex b, RasterVertex c, uint32_t id, Triangle& triangle) {
  int64_t area = int64_t{b.x - a.x} * (c.y - a.y) - int64_t{b.y - a.y} * (c.x - a.x);
  if (area == 0) return false;
  if (area < 0) {
    std::swap(b, c);
    area = -area;
  }
  const RasterVertex corners[3] = {a, b, c};
  for (int i = 0; i < 3; ++i) {
    const RasterVertex &from = corners[i], &to = corners[(i + 1) % 3];
    const int64_t x = int64_t{from.y} - to.y, y = int64_t{to.x} - from.x;
    const bool top_left = x > 0 || (x == 0 && y > 0);
    const int64_t constant = -(x * from.x + y * from.y) - (top_left ? 0 : 1);
    // (kSubpixels / kFine) n + constant >= 0 for whole n is n + floor(constant / (kSubpixels / kFine)) >= 0.
    static_assert(kSubpixels / kFine == 16);
    triangle.edges[i] = {x, y, constant >> 4};
  }
  const double per_pixel = kSubpixels / static_cast<double>(area);
  const double z_b = double{b.z} - a.z, z_c = double{c.z} - a.z;
  triangle.x = a.x * (1.0 / kSubpixels);
  triangle.y = a.y * (1.0 / kSubpixels);
  triangle.z = a.z;
  triangle.z_x = (z_b * (c.y - a.y) - z_c * (b.y - a.y)) * per_pixel;
  triangle.z_y = (z_c * (b.x - a.x) - z_b * (c.x - a.x)) * per_pixel;
  triangle.z_low = std::min({a.z, b.z, c.z});
  triangle.z_high = std::max({a.z, b.z, c.z});
  triangle.id = id;
  return true;
}

// A tile while it is drawn.
struct Tile {
  Bounds bounds;  // in pixels
  float* depth;
  uint32_t* triangles;
};

// What draws the triangles of a tile.
struct Filler {
  const RasterKernel& kernel;
  uint32_t samples;
  TriangleShader& shader;
};

// A patch of a triangle that one sees through, row by row: samples behind which something else is seen become
// what they were. `depth` and `triangles` point to the first pixel of its block, which is x, y of the
// picture.
void fillSeenThrough(RasterPatch patch, const Filler& filler, int32_t x, int32_t y, float* depth,
                     uint32_t* triangles) {
  float depth_before[kMaxRasterSamples][kRasterBlock];
  uint32_t triangles_before[kMaxRasterSamples][kRasterBlock];
  for (const uint32_t last = patch.y1; patch.y0 < last; ++patch.y0) {
    patch.y1 = patch.y0 + 1;
    const auto at = [&](uint32_t sample, uint32_t column) {
      return (size_t{sample} * kRasterTile + patch.y0) * kRasterTile + column;
    };
    for (uint32_t s = 0; s < filler.samples; ++s) {
      std::copy(depth + at(s, patch.x0), depth + at(s, patch.x1), depth_before[s]);
      std::copy(triangles + at(s, patch.x0), triangles + at(s, patch.x1), triangles_before[s]);
    }
    filler.kernel.fill(patch, filler.samples, depth, triangles);
    for (uint32_t column = patch.x0; column < patch.x1; ++column) {
      const uint32_t i = column - patch.x0;
      const auto changed = [&](uint32_t s) {
        return triangles[at(s, column)] != triangles_before[s][i] ||
               depth[at(s, column)] != depth_before[s][i];
      };
      bool any = false;
      for (uint32_t s = 0; s < filler.samples; ++s) any = any || changed(s);
      if (!any) continue;
      const uint32_t seen = filler.shader.samplesSeenAt(
          patch.triangle, x + static_cast<int32_t>(column) + 0.5, y + static_cast<int32_t>(patch.y0) + 0.5);
      for (uint32_t s = seen; s < filler.samples; ++s) {
        depth[at(s, column)] = depth_before[s][i];
        triangles[at(s, column)] = triangles_before[s][i];
      }
    }
    for (uint32_t s = 0; s < filler.samples && patch.y0 + 1 < last; ++s)
      for (int i = 0; i < 3; ++i) patch.edge[s][i] += patch.edge_y[i];
  }
}

// The part of a triangle in the block at x, y, given in pixels; `bounds` lie in it.
void fillBlock(const Triangle& triangle, const Bounds& bounds, int32_t x, int32_t y, const Tile& tile,
               const Filler& filler) {
  const auto& [kernel, samples, shader] = filler;
  const uint32_t mask = kernel.lanes - 1;
  RasterPatch patch;
  patch.x0 = static_cast<uint32_t>(bounds.x0 - x) & ~mask;
  patch.x1 = (static_cast<uint32_t>(bounds.x1 - x) + mask) & ~mask;
  patch.y0 = static_cast<uint32_t>(bounds.y0 - y);
  patch.y1 = static_cast<uint32_t>(bounds.y1 - y);
  const int64_t first_x = kFine * (x + static_cast<int32_t>(patch.x0)),
                first_y = kFine * (y + static_cast<int32_t>(patch.y0));
  const int64_t across = kFine * (patch.x1 - patch.x0), along = kFine * (patch.y1 - patch.y0);
  const Offset* offsets = kSampleOffsets[samples > 1];
  for (int i = 0; i < 3; ++i) {
    const Edge& edge = triangle.edges[i];
    const int64_t at = edge.x * first_x + edge.y * first_y + edge.constant;
    const int64_t far_x = edge.x * across, far_y = edge.y * along;
    if (at + std::max<int64_t>(far_x, 0) + std::max<int64_t>(far_y, 0) < 0) return;
    // An edge that does not pass may be too large for 32 bits, and need not be looked at.
    const bool passes = at + std::min<int64_t>(far_x, 0) + std::min<int64_t>(far_y, 0) < 0;
    patch.edge_x[i] = passes ? static_cast<int32_t>(edge.x * kFine) : 0;
    patch.edge_y[i] = passes ? static_cast<int32_t>(edge.y * kFine) : 0;
    for (uint32_t s = 0; s < samples; ++s)
      patch.edge[s][i] =
          passes ? static_cast<int32_t>(at + edge.x * offsets[s].x + edge.y * offsets[s].y) : 0;
  }
  for (uint32_t s = 0; s < samples; ++s)
    patch.z[s] =
        static_cast<float>(triangle.z + triangle.z_x * (x + offsets[s].x * (1.0 / kFine) - triangle.x) +
                           triangle.z_y * (y + offsets[s].y * (1.0 / kFine) - triangle.y));
  patch.z_x = static_cast<float>(triangle.z_x);
  patch.z_y = static_cast<float>(triangle.z_y);
  patch.z_low = triangle.z_low;
  patch.z_high = triangle.z_high;
  patch.triangle = triangle.id;
  const size_t origin =
      static_cast<size_t>(y - tile.bounds.y0) * kRasterTile + static_cast<size_t>(x - tile.bounds.x0);
  if (shader.isSeenThrough(triangle.id))
    fillSeenThrough(patch, filler, x, y, tile.depth + origin, tile.triangles + origin);
  else
    kernel.fill(patch, samples, tile.depth + origin, tile.triangles + origin);
}

void fillPolygon(const ScreenPolygon& polygon, uint32_t id, const Tile& tile, const Filler& filler) {
  constexpr auto kBlock = static_cast<int32_t>(kRasterBlock);
  for (uint32_t i = 2; i < polygon.count; ++i) {
    const RasterVertex points[3] = {polygon.points[0], polygon.points[i - 1], polygon.points[i]};
    const Bounds bounds = boundsOf(points, tile.bounds);
    Triangle triangle;
    if (bounds.empty() || !setUp(points[0], points[1], points[2], id, triangle)) continue;
    for (int32_t y = bounds.y0 - (bounds.y0 - tile.bounds.y0) % kBlock; y < bounds.y1; y += kBlock)
      for (int32_t x = bounds.x0 - (bounds.x0 - tile.bounds.x0) % kBlock; x < bounds.x1; x += kBlock)
        fillBlock(triangle,
                  {std::max(bounds.x0, x), std::max(bounds.y0, y), std::min(bounds.x1, x + kBlock),
                   std::min(bounds.y1, y + kBlock)},
                  x, y, tile, filler);
  }
}

// A pixel from the triangles at its samples; each of them is shaded once.
Float4 pixelColor(const uint32_t* triangles, uint32_t samples, TriangleShader& shader, int32_t x, int32_t y) {
  uint32_t seen[kMaxRasterSamples];
  float shares[kMaxRasterSamples];
  uint32_t count = 0;
  const float share = 1.0f / static_cast<float>(samples);
  for (uint32_t s = 0; s < samples; ++s) {
    const uint32_t triangle = triangles[size_t{s} * kTilePixels];
    uint32_t i = 0;
    while (i < count && seen[i] != triangle) ++i;
    if (i == count) {
      seen[count] = triangle;
      shares[count++] = 0.0f;
    }
    shares[i] += share;
  }
  Float4 sum = {0.0f, 0.0f, 0.0f, 0.0f};
  for (uint32_t i = 0; i < count; ++i) {
    if (seen[i] == kNoTriangle) continue;
    const Float3 c = shader.color(seen[i], x + 0.5, y + 0.5);
    const float w = shares[i];
    sum = {sum.x + w * c.x, sum.y + w * c.y, sum.z + w * c.z, sum.w + w};
  }
  return sum;
}

}  // namespace

Status RasterJob::validate() const {
  const auto fail = [](const char* message) {
    return Status::error(StatusCode::kInvalidArgument, "raster: %s", message);
  };
  if (!asset) return fail("no asset");
  if (width == 0 || height == 0 || width > kMaxRasterSide || height > kMaxRasterSide)
    return Status::error(StatusCode::kInvalidArgument, "raster: sides are from 1 to %u pixels",
                         kMaxRasterSide);
  if (samples != 1 && samples != 4) return fail("samples are 1 or 4");
  const size_t count = asset->vertexCount(), pixels = size_t{width} * height;
  if (positions.size() < count || vertices.size() < count) return fail("positions or vertices are too short");
  if ((!picture.empty() && colors.size() < count) || (!back_colors.empty() && back_colors.size() < count))
    return fail("colors are too short");
  if ((!gloss.empty() && gloss.size() < count) || (!back_gloss.empty() && back_gloss.size() < count) ||
      (!back_colors.empty() && gloss.empty() != back_gloss.empty()))
    return fail("gloss is too short");
  if (!weights.empty() && weights.size() < count * asset->weightStride())
    return fail("weights are too short");
  if (bins.size() < rasterBinWords(asset->triangleCount(), width, height)) return fail("bins are too short");
  if ((!picture.empty() && picture.size() < pixels) || (!depth.empty() && depth.size() < pixels))
    return fail("picture or depth are too short");
  if (!(vertex_shade >= 0.0f) || vertex_shade > 1.0f) return fail("vertex_shade is not in [0, 1]");
  for (float value : view_projection)
    if (!std::isfinite(value)) return fail("view_projection is not finite");
  for (const TextureSet& set : asset->texture_sets)
    if (std::max(set.shading.levels, set.masks.levels) > kMaxRasterLevels)
      return fail("a texture has more than 16 levels");
  for (const BaseMaps& maps : asset->base_maps)
    if (maps.color.levels > kMaxRasterLevels) return fail("a texture has more than 16 levels");
  if (!rasterKernel(simd).fill)
    return Status::error(StatusCode::kUnavailable, "raster: this CPU or build has no %s", simdName(simd));
  return {};
}

void RasterJob::project(uint32_t begin, uint32_t end) const {
  for (uint32_t v = begin; v < end; ++v) vertices[v] = screenVertex(*this, clipPoint(*this, positions[v]));
}

void RasterJob::bin(uint32_t begin, uint32_t end) const {
  constexpr auto kSide = static_cast<int32_t>(kRasterTile);
  const uint32_t columns = columnsOf(*this), tiles = rasterTiles(width, height);
  const Bounds picture_bounds = {0, 0, static_cast<int32_t>(width), static_cast<int32_t>(height)};
  for (uint32_t batch = begin; batch < end; ++batch) {
    for (uint32_t tile = 0; tile < tiles; ++tile)
      std::fill_n(&bins[binAt(*this, tile, batch)], kBatchWords, 0);
    const uint32_t first = batch * kRasterBatch,
                   last = std::min(first + kRasterBatch, asset->triangleCount());
    for (uint32_t t = first; t < last; ++t) {
      const ScreenPolygon polygon = screenPolygon(*this, t);
      if (polygon.count < 3) continue;
      const Bounds b = boundsOf({polygon.points, polygon.count}, picture_bounds);
      if (b.empty()) continue;
      for (int32_t y = b.y0 / kSide; y <= (b.y1 - 1) / kSide; ++y)
        for (int32_t x = b.x0 / kSide; x <= (b.x1 - 1) / kSide; ++x)
          bins[binAt(*this, static_cast<uint32_t>(y) * columns + static_cast<uint32_t>(x), batch) +
               (t - first) / 64] |= uint64_t{1} << (t - first) % 64;
    }
  }
}

void RasterJob::draw(uint32_t begin, uint32_t end, std::span<std::byte> scratch) const {
  const RasterKernel kernel = rasterKernel(simd);
  const uint32_t columns = columnsOf(*this), batches = rasterBatches(asset->triangleCount());
  Tile tile;
  tile.depth = reinterpret_cast<float*>(scratch.data());
  tile.triangles = reinterpret_cast<uint32_t*>(tile.depth + kMaxRasterSamples * kTilePixels);
  TriangleShader shader(*this,
                        reinterpret_cast<ShadedTriangle*>(tile.triangles + kMaxRasterSamples * kTilePixels));
  for (uint32_t index = begin; index < end; ++index) {
    const uint32_t x0 = index % columns * kRasterTile, y0 = index / columns * kRasterTile;
    const uint32_t x1 = std::min(x0 + kRasterTile, width), y1 = std::min(y0 + kRasterTile, height);
    tile.bounds = {static_cast<int32_t>(x0), static_cast<int32_t>(y0), static_cast<int32_t>(x1),
                   static_cast<int32_t>(y1)};
    std::fill_n(tile.depth, samples * kTilePixels, 1.0f);
    std::fill_n(tile.triangles, samples * kTilePixels, kNoTriangle);
    const uint64_t* words = &bins[binAt(*this, index, 0)];
    for (size_t word = 0; word < size_t{batches} * kBatchWords; ++word)
      for (uint64_t bits = words[word]; bits != 0; bits &= bits - 1) {
        const auto t = static_cast<uint32_t>(64 * word) + static_cast<uint32_t>(std::countr_zero(bits));
        fillPolygon(screenPolygon(*this, t), t, tile, {kernel, samples, shader});
      }
    for (uint32_t y = y0; y < y1; ++y)
      for (uint32_t x = x0; x < x1; ++x) {
        const size_t in_tile = size_t{y - y0} * kRasterTile + (x - x0), pixel = size_t{y} * width + x;
        if (!picture.empty())
          picture[pixel] = pixelColor(tile.triangles + in_tile, samples, shader,
                                      tile.bounds.x0 + static_cast<int32_t>(x - x0), static_cast<int32_t>(y));
        if (!depth.empty()) {
          depth[pixel] = tile.depth[in_tile];
          for (uint32_t s = 1; s < samples; ++s)
            depth[pixel] = std::min(depth[pixel], tile.depth[size_t{s} * kTilePixels + in_tile]);
        }
      }
  }
}

}  // namespace furrow
