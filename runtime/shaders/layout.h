// Binding slots, constants and structures that C++ and the shaders share. This text is included by C++ and pasted in front of every shader.

#ifdef __cplusplus
#pragma once
#include <cstdint>
namespace furrow::gpu {
using uint = uint32_t;
#define FURROW_CONSTANT inline constexpr uint
#else
#define FURROW_CONSTANT const uint
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

struct LayerConstants {
  float lambda;
  float beta;
  float stretch_lambda;
  float stretch_beta;
  uint measure;
  uint curve;
  uint first_coefficient;  // word in kCoefficients
  float region;
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
  uint pad0;
  uint pad1;
  uint pad2;
  LayerConstants layer[kLayerLimit];
};

#ifdef __cplusplus
#undef FURROW_CONSTANT
static_assert(sizeof(LayerConstants) == 32 && sizeof(FrameConstants) == 48 + 32 * 16);
}  // namespace furrow::gpu
#endif
