// Binding slots, constants and structures that C++ and the shaders share. This text is included by C++ and pasted in front of every shader.

#ifdef __cplusplus
#pragma once
#include <cstdint>
namespace furrow::gpu {
using uint = uint32_t;
#define FURROW_CONSTANT inline constexpr uint
#else
#ifndef FURROW_CONSTANT
#define FURROW_CONSTANT const uint
#endif
#endif

FURROW_CONSTANT kGroupSize = 128u;
FURROW_CONSTANT kLayerLimit = 16u;

// The measures and curves of asset.h.
FURROW_CONSTANT kMeasureDirectional = 0u;
FURROW_CONSTANT kMeasureArea = 1u;
FURROW_CONSTANT kMeasurePrincipal = 2u;
FURROW_CONSTANT kMeasureNone = 3u;
FURROW_CONSTANT kCurveLarsson = 0u;
FURROW_CONSTANT kCurveOat = 1u;

// Words of a vertex in kRestVertices: position 3, normal 3, tangent 4.
FURROW_CONSTANT kRestVertexWords = 10u;

// Raster form. The sums of point p are at (p % kSumsWidth, p / kSumsWidth). A record of kMeasured is the rest
// angles of a triangle's corners and then the coefficients of the layers.
FURROW_CONSTANT kSumsWidth = 1024u;
FURROW_CONSTANT kLayersASlice = 3u;
FURROW_CONSTANT kNoLayer = 0xffffffffu;

struct LayerConstants {
  float lambda;
  float beta;
  float stretch_lambda;
  float stretch_beta;
  uint measure;
  uint curve;
  uint first_coefficient;  // word in kCoefficients
  float region;
  uint slice;    // raster form: where the sums of q x angle are; kNoLayer: q is 1 everywhere
  uint channel;  // 0 to 2
  uint pad0;
  uint pad1;
};

// Raster form: a slice of the sums belongs to layers that measure the same triangles.
struct SliceConstants {
  uint layer0;  // kNoLayer: none
  uint layer1;
  uint layer2;
  uint first_word;    // in kMeasured
  uint record_words;  // a triangle
  uint pad0;
  uint pad1;
  uint pad2;
};

struct FrameConstants {
  uint vertices;
  uint triangles;
  uint points;
  uint layers;
  uint influences;
  uint morphs;
  uint with_normals;
  uint with_bias;
  float inverse_scale2;  // 1 / (instance scale)^2
  uint sums_height;      // raster form: rows of the sums
  uint pad0;
  uint pad1;
  LayerConstants layer[kLayerLimit];
  SliceConstants slice[kLayerLimit];
};

#ifdef __cplusplus
#undef FURROW_CONSTANT
static_assert(sizeof(LayerConstants) == 48 && sizeof(SliceConstants) == 32);
static_assert(sizeof(FrameConstants) == 48 + (48 + 32) * 16);
}  // namespace furrow::gpu
#endif
