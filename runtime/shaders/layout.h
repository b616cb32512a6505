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

// Work-groups lie in rows of this many where one row does not hold them.
FURROW_CONSTANT kGroupColumns = 32768u;

// kRestVertices: the positions, 3 words a vertex, then normals and tangents, 7 words a vertex.
FURROW_CONSTANT kRestFrameWords = 7u;
// Words of a joint in kPalette: a matrix, or a JointMotion for dual quaternion skinning.
FURROW_CONSTANT kMatrixWords = 12u;
FURROW_CONSTANT kMotionWords = 17u;

// Clustered form. What a cluster holds at most, so that it stays in 32 KiB of shared memory.
FURROW_CONSTANT kClusterPointLimit = 256u;
FURROW_CONSTANT kClusterSlotLimit = 768u;
FURROW_CONSTANT kClusterTriangleLimit = 2304u;
// kClusterTable: kClusterWords words a cluster, what Cluster (cluster_frame.h) says of its part of kClusterData,
// then a word a layer: where its coefficients are there. Behind the clusters their morph targets: a run is a
// target, and where in the table its entries begin and end; an entry is as in AssetView::morph_entries, with the
// slot in place of the target.
FURROW_CONSTANT kClusterPoints = 0u;
FURROW_CONSTANT kClusterVertices = 1u;
FURROW_CONSTANT kClusterSlots = 2u;
FURROW_CONSTANT kClusterTriangles = 3u;
FURROW_CONSTANT kClusterSlotVertex = 4u;
FURROW_CONSTANT kClusterExtraPoint = 5u;
FURROW_CONSTANT kClusterCorners = 6u;
FURROW_CONSTANT kClusterChunks = 7u;
FURROW_CONSTANT kClusterCovered = 8u;
FURROW_CONSTANT kClusterRuns = 9u;  // of kRunWords words each
FURROW_CONSTANT kClusterRunsEnd = 10u;
FURROW_CONSTANT kClusterWords = 11u;
FURROW_CONSTANT kRunWords = 3u;
FURROW_CONSTANT kEntryWords = 4u;

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
  float attack;  // share of the way to its target that a weight goes in this frame, see EaseJob
  float release;
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
  float fade;            // of the weights, with distance
  uint sums_height;      // raster form: rows of the sums
  uint joints;           // of the palette
  uint dual_quaternions;
  uint posed_by_host;
  uint with_ease;
  uint with_point_q;
  uint active_layers;  // bit l: layer l is computed, else its weights are 0
  float laplace_rate;  // of a Laplacian step
  uint pad1;
  uint pad2;
  LayerConstants layer[kLayerLimit];
  SliceConstants slice[kLayerLimit];
};

#ifdef __cplusplus
#undef FURROW_CONSTANT
static_assert(sizeof(LayerConstants) == 48 && sizeof(SliceConstants) == 32);
static_assert(sizeof(FrameConstants) == 80 + (48 + 32) * 16);
}  // namespace furrow::gpu
#endif
