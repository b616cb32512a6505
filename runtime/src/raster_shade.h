#pragma once

// The colour of a triangle at a place of the screen.

#include "furrow/raster.h"

namespace furrow {

inline constexpr uint32_t kMaxRasterLevels = 16;  // of a texture

// The slices of a texture, ready for fetches.
class SliceSampler {
 public:
  void select(const Texture& texture, const Wrap (&wrap)[2]);

  // One channel at uv, with `right` and `down` the change of uv over a pixel: trilinear, in [0, 1].
  float at(uint32_t slice, uint32_t channel, const float uv[2], const float right[2],
           const float down[2]) const;

  // The same of a colour: sRGB decoded before it is filtered.
  Float3 colorAt(const float uv[2], const float right[2], const float down[2]) const;
  float opacityAt(const float uv[2], const float right[2], const float down[2]) const;

 private:
  struct Level {
    const std::byte* data;
    size_t slice_bytes;
    uint32_t width, height;
  };

  // `texel(level, column, row)` filtered.
  template <typename Texel>
  auto filtered(const float uv[2], const float right[2], const float down[2], const Texel& texel) const;

  const Texture* texture_ = nullptr;
  Wrap wrap_[2] = {};
  Level levels_[kMaxRasterLevels] = {};
};

// What is worked out once for a triangle.
struct ShadedTriangle {
  struct ActiveLayer {
    uint32_t layer;
    float weights[3];  // of the corners
  };

  uint32_t id;
  uint32_t active_count;
  const uint32_t* corners;
  const Float3* colors;
  const Float3* gloss;
  const BaseMaps* base;   // with a colour map, or null
  float opacity;          // that the map's is multiplied by
  const TextureSet* set;  // with maps, or null
  double planes[3][3];    // x a[0] + y a[1] + a[2] is proportional to a corner's share
  ActiveLayer active[kMaxLayers];
};

class TriangleShader {
 public:
  static constexpr uint32_t kKept = 64;  // a power of two

  // `kept`: kKept triangles for the shader's use; rows of pixels come back to them.
  TriangleShader(const RasterJob& job, ShadedTriangle* kept);

  // In pixels from the top left corner. Outside the triangle: the colour of its nearest edge or corner, as
  // far as perspective allows.
  Float3 color(uint32_t triangle, double x, double y);

  // Whether one sees through the triangle anywhere, and how many samples it covers, the first ones, of those
  // that it hits in the pixel at whose centre this is.
  bool isSeenThrough(uint32_t triangle) const;
  uint32_t samplesSeenAt(uint32_t triangle, double x, double y);

 private:
  // Where a pixel is in a triangle: shares of the corners, and uv with its change over a pixel.
  struct Place {
    double share[3], edge[3];
  };
  // Of a pixel: uv, and its change over one to the right and one down.
  struct Footprint {
    float uv[2], right[2], down[2];
  };

  const ShadedTriangle& shaded(uint32_t triangle);
  static Place placeOf(const ShadedTriangle& triangle, double x, double y);
  Footprint footprint(const ShadedTriangle& triangle, const Place& place) const;
  Footprint onBaseMap(const BaseMaps& maps, const Footprint& at);
  float crease(const ShadedTriangle& triangle, const double* share, const Footprint& at);

  const RasterJob& job_;
  ShadedTriangle* kept_;
  const TextureSet* sampled_ = nullptr;
  const BaseMaps* painted_ = nullptr;
  bool any_seen_through_ = false;
  SliceSampler shading_, masks_, colors_;
};

}  // namespace furrow
