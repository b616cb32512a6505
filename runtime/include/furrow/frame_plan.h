#pragma once

// The gpu tier: the frame as a list of compute dispatches that a host records in its own graphics API.
// furrow::gl is one executor.
//
// Buffers are 32-bit words. Shader source is GLSL 4.30 made of text the runtime embeds (shaders/).

#include <span>
#include <vector>

#include "furrow/asset.h"
#include "furrow/jobs.h"

namespace furrow {

// Buffers of the plan. A host makes one of each size > 0 per asset (kPerAsset) or per instance
// (kPerInstance).
enum class Buffer : uint8_t {
  // Per asset, filled once from ResourceDesc::initial.
  kRestVertices = 0,  // kRestVertexWords (layout.h) a vertex
  kInfluences,        // a word each pair: joint | weight << 16
  kMorphEntries,      // AssetView::morph_entries
  kSurfaceIndices,    // AssetView::surface_indices
  kCoefficients,      // all layers, one after the other
  kRingOffsets,
  kRingTriangles,
  kRingWeights,  // uint16 pairs
  kVertexPoint,
  kBias,  // snorm16 pairs: weightStride a vertex; size 0 where no layer has a bias
  // Per instance, written by the host every frame.
  kPalette,       // Affine a palette entry
  kMorphWeights,  // float2 a morph, see writeMorphWeights()
  kFrame,         // FrameConstants (layout.h)
  // Per instance, written by the GPU.
  kPositions,  // float3 a vertex, posed; the host's own posed vertices where PlanOptions::posed_by_host
  kNormals,    // float3 a vertex
  kTangents,   // float4 a vertex
  kTriangleQ,  // float, a triangle a layer: layer * triangles + triangle
  kPointQ,     // float, a point a layer
  kWeights,    // snorm16 pairs: weightStride a vertex
  kCount,
};

enum class Lifetime : uint8_t { kPerAsset, kPerInstance };

struct BufferDesc {
  const char* name;
  Lifetime lifetime;
  uint64_t bytes;                      // 0: not used by this plan
  std::span<const std::byte> initial;  // empty: the host or the GPU fills it
};

enum class Shader : uint8_t { kDeform = 0, kCompress, kSmooth, kRespond, kCount };

struct Binding {
  uint32_t slot;
  Buffer buffer;
};

// Run `shader` with groups[0] x groups[1] work-groups, then make its writes visible to the next item (a
// storage barrier). Every binding is a storage buffer but Buffer::kFrame, which is a std140 uniform buffer.
struct Dispatch {
  const char* label;
  Shader shader;
  uint32_t groups[2];
  std::span<const Binding> bindings;
};

struct PlanOptions {
  bool posed_by_host = false;  // the host fills kPositions; the plan has no deform item
  bool normals = true;         // pose normals and tangents too
};

class FramePlan {
 public:
  FramePlan(const AssetView& asset, const PlanOptions& options);

  const BufferDesc& buffer(Buffer id) const { return buffers_[static_cast<size_t>(id)]; }
  std::span<const Dispatch> dispatches() const { return dispatches_; }

 private:
  BufferDesc buffers_[static_cast<size_t>(Buffer::kCount)] = {};
  std::vector<Dispatch> dispatches_;
  std::vector<std::vector<uint32_t>> words_;  // what `initial` points into where the asset has no such array
};

// Complete GLSL source of a shader, `#version` first.
const char* shaderSource(Shader shader);

// Everything that changes from frame to frame.
struct FrameInput {
  std::span<const Affine> palette;       // AssetView::palette, translations relative to the instance's origin
  std::span<const float> morph_weights;  // AssetView::morphs
  std::span<const float> region_weights;  // a layer, from driveRegions(); or empty: 0
  std::span<const Response> responses;    // a layer; or empty: those of the asset
  float scale = 1.0f;                     // uniform scale of the instance that the palette contains, > 0
};

// The bytes of Buffer::kFrame for one frame; `out` holds the buffer's size.
void writeFrameConstants(const AssetView& asset, const PlanOptions& options, const FrameInput& input,
                         std::span<std::byte> out);

// The bytes of Buffer::kMorphWeights: weight * position_step, weight * normal_step a morph.
void writeMorphWeights(const AssetView& asset, const FrameInput& input, std::span<std::byte> out);

}  // namespace furrow
