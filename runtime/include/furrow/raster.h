#pragma once

// The software rasteriser: a posed, lit surface with its creases as pixels, for machines without a GPU. It
// draws lit Gouraud colours darkened by alpha shading, C = C0 (1 - I W) a layer [Larsson]: C0 is interpolated
// from the vertices, I = |w|, W comes from the asset's shading maps (bilinear, mip-mapped), and a part
// without maps darkens by the weights of its vertices alone. C0 may be times the model's own colour map.
// Where that map's opacity, times the part's, is below BaseMaps::opaque_from at a pixel's centre, nothing is
// there. A part whose own opacity (Part::base_color) is below 1 covers some of a pixel's samples
// (samplesSeen()), so that what is behind it shows without any order.
//
// A picture takes three passes, each split over the host's threads as it likes; a pass needs the whole result
// of the one before:
//
//   job.project(0, vertices)                            // to the screen
//   job.bin(0, rasterBatches(triangles))                // which triangles reach which tiles
//   job.draw(0, rasterTiles(width, height), scratch)    // depth, coverage, colour
//
// Nothing is allocated, locked or thrown; all memory is the host's, and its size follows from the counts of
// vertices, triangles and pixels. The picture is the same to the bit for every split and instruction set.
//
// Coverage is exact: positions are snapped to 1/256 pixel and edges are integers, so that triangles which
// share an edge leave no gap and hit no sample twice (top-left rule). Triangles are clipped at the near plane
// and at a guard band around the picture, in double and from both sides alike, samples are cut at the far
// plane. Attributes are perspective-correct. Both sides of triangles are drawn; of equal depths the later
// triangle wins.
//
// An engine that draws alpha shading itself draws the lit surface as always, then the same geometry once
// more, to multiply what is there by 1 - I W. State of the second pass:
//   depth      test EQUAL (or LESS_OR_EQUAL), no write, the same vertex shader arithmetic (`invariant
//              gl_Position`, `precise`) so that depths are equal to the bit
//   blend      color = 0 * source + source_color * destination: operation ADD, source factor ZERO,
//              destination factor SRC_COLOR (D3D11_BLEND_SRC_COLOR, VK_BLEND_FACTOR_SRC_COLOR,
//              glBlendFuncSeparate(GL_ZERO, GL_SRC_COLOR, GL_ZERO, GL_ONE)); alpha: ZERO and ONE, unchanged
//   output     the grey of furrowAlphaShade(vec3(1), I, W), multiplied over the layers (furrow_shade.glsl:
//              FurrowWrinkles::shading after furrowAddLayer)
//   target     linear values: a float or an sRGB format whose blending decodes (GL_FRAMEBUFFER_SRGB), before
//              tone mapping and fog; opaque geometry only
// Hardware without shaders has W as the alpha of a black texture, I as the alpha of the vertex colour, their
// product as fragment alpha, and the blend factors SRC_ALPHA and ONE_MINUS_SRC_ALPHA: one pass a layer.

#include <cstddef>
#include <span>

#include "furrow/asset.h"
#include "furrow/cluster_frame.h"

namespace furrow {

inline constexpr uint32_t kRasterTile = 64;       // pixels a side
inline constexpr uint32_t kRasterBatch = 512;     // triangles that bin() takes at a time
inline constexpr uint32_t kMaxRasterSide = 4096;  // pixels
inline constexpr uint32_t kMaxRasterSamples = 4;
// A thread's, for draw().
inline constexpr size_t kRasterScratchBytes = size_t{160} << 10;

constexpr uint32_t rasterBatches(uint32_t triangles) {
  return triangles / kRasterBatch + (triangles % kRasterBatch > 0);
}
constexpr uint32_t rasterTiles(uint32_t width, uint32_t height) {
  return ((width + kRasterTile - 1) / kRasterTile) * ((height + kRasterTile - 1) / kRasterTile);
}
// A bit for every triangle and tile: 32 bytes a triangle for a picture of 1024 x 1024.
constexpr size_t rasterBinWords(uint32_t triangles, uint32_t width, uint32_t height) {
  return size_t{rasterTiles(width, height)} * rasterBatches(triangles) * (kRasterBatch / 64);
}

// How many of a pixel's samples, the first ones, a surface of that opacity covers: the nearest share.
constexpr uint32_t samplesSeen(float opacity, uint32_t samples) {
  if (opacity >= 1.0f) return samples;
  return opacity > 0.0f ? static_cast<uint32_t>(opacity * static_cast<float>(samples) + 0.5f) : 0;
}

// A vertex on the screen, as project() leaves it.
struct RasterVertex {
  int32_t x, y;  // 1/256 pixel from the top left corner; or a mark: to be clipped, not to be drawn
  float z;       // depth, z / w
  float w;
};

struct RasterJob {
  const AssetView* asset = nullptr;
  std::span<const Float3> positions;  // posed, a vertex; triangles with one that is not finite are left out
  // Row-major: clip = M (p, 1). As OpenGL has it: a point is before the near plane where z < -w and behind
  // the far plane where z > w; +y is up.
  float view_projection[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  uint32_t width = 0, height = 0;  // 1 to kMaxRasterSide
  uint32_t samples = 4;            // a pixel: 1 (its centre) or 4 (the usual rotated grid)

  std::span<const Float3> colors;       // C0, linear, a vertex; may be empty if `picture` is
  std::span<const Float3> back_colors;  // of triangles seen clockwise; empty: `colors`
  // What the surface reflects in the colour of the light, a vertex: `colors` are then multiplied by the
  // parts' BaseMaps::color, as they would be of white, and these added. Empty: the map is not read.
  std::span<const Float3> gloss;
  std::span<const Float3> back_gloss;  // of triangles seen clockwise; not empty if both others are not
  std::span<const int16_t> weights;    // as the frame left them, weightStride() a vertex; empty: no creases
  float vertex_shade = 0.55f;          // [0, 1], W of parts without maps

  std::span<RasterVertex> vertices;  // memory, a vertex
  std::span<uint64_t> bins;          // memory, rasterBinWords()

  // out, width * height, rows from the top; either may be empty. Colour is linear and premultiplied by
  // coverage, which is w: put it over a background with rgb + (1 - w) background.
  std::span<Float4> picture;
  std::span<float> depth;  // z / w of the nearest sample, in [-1, 1]; 1 where there is nothing

  Simd simd = bestSimd();

  Status validate() const;
  void project(uint32_t begin, uint32_t end) const;  // items: vertices
  void bin(uint32_t begin, uint32_t end) const;      // items: rasterBatches()
  // Items: rasterTiles(), row by row from the top. `scratch`: kRasterScratchBytes, aligned to 64, for this
  // call alone.
  void draw(uint32_t begin, uint32_t end, std::span<std::byte> scratch) const;
};

}  // namespace furrow
