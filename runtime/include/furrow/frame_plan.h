#pragma once

// The frame on a GPU, as a list of items that a host records in its own graphics API. furrow::gl is one
// executor.
//
// Buffers are 32-bit words. Shader source is text that the runtime embeds (shaders/): for compute GLSL 4.30,
// HLSL and SPIR-V, for the raster form GLSL 3.30. docs/integration.md walks through it.

#include <span>
#include <vector>

#include "furrow/asset.h"
#include "furrow/jobs.h"
#include "furrow/skinning.h"

namespace furrow {

// How the frame is computed; every form gives the same weights.
enum class Form : uint8_t {
  kClustered = 0,  // compute, the fast path: one dispatch, a work-group a cluster and instance, no array
                   // between stages in memory. Needs 16 storage buffers and 21 KB of shared memory
  kStaged,  // compute: a dispatch a stage, over vertices, triangles, points and vertices; the reference, and
            // for assets that clusters cannot hold
  kRaster,  // OpenGL 3.3 without compute [Oat]: vertices are posed and answered by transform feedback,
            // q x angle is added up by blending points into a float target
};

// Buffers of the plan. A host makes one of each size > 0: kPerAsset ones once an asset, kPerInstance ones
// once a plan, holding PlanOptions::instances parts of one size, one behind the other.
enum class Buffer : uint8_t {
  // Per asset, filled once from BufferDesc::initial.
  kRestVertices = 0,  // float3 a vertex: positions; then 7 floats a vertex: normal, tangent
  kInfluences,        // a word each pair: joint | weight << 16
  kMorphEntries,      // AssetView::morph_entries
  kSurfaceIndices,    // AssetView::surface_indices; in the raster form, of the triangles of each slice
  kCoefficients,      // all layers, one after the other
  kRingOffsets,
  kRingTriangles,
  kRingWeights,   // uint16 pairs
  kMeasured,      // raster form: the records of each slice's triangles (layout.h)
  kClusterTable,  // clustered form: what each cluster is, and its morph targets (layout.h)
  kClusterData,   // clustered form: Clusters::words
  kVertexPoint,
  kBias,  // snorm16 pairs: weightStride a vertex; size 0 where no layer has a bias
  // Per instance, written by the host every frame.
  kPalette,       // Affine a palette entry, or JointMotion for dual quaternion skinning
  kMorphWeights,  // float2 a morph, see writeMorphWeights()
  kFrame,         // FrameConstants (layout.h), see writeFrame()
  kInstances,     // clustered form: the instances to run, a word each; at first all
  // Per instance, written by the GPU.
  kPositions,  // float3 a vertex, posed; the host's own posed vertices where PlanOptions::posed_by_host
  kNormals,    // float3 a vertex
  kTangents,   // float4 a vertex
  kTriangleQ,  // float, a triangle a layer: layer * triangles + triangle
  kPointQ,     // float, a point a layer
  kOtherQ,     // likewise: Laplacian steps go from one to the other, and end in kPointQ
  kState,      // float, weightStride a vertex: of attack and release; not initialised, see FrameInput::reset
  kNextState,  // raster form: likewise
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

// The raster form's targets: one array texture of RGBA32F, nearest filtering, one level; with Laplacian steps
// two of them. images 0: none.
struct SumsDesc {
  uint32_t width = 0, height = 0, slices = 0, images = 0;
};

enum class Shader : uint8_t {
  kCluster = 0,
  kDeform,
  kCompress,
  kSmooth,
  kLaplace,
  kRespond,
  kRasterDeform,
  kRasterMeasure,
  kRasterLaplace,
  kRasterEase,
  kRasterRespond,
  kRasterKeep,
  kCount
};

// How an item sees a buffer.
enum class Access : uint8_t {
  kUniform,    // std140 uniform buffer, at `slot` of these
  kStorage,    // storage buffer, at `slot` of these
  kFloats,     // buffer texture of R32F, at texture unit `slot`
  kWords,      // buffer texture of R32UI, at texture unit `slot`
  kSums,       // not a buffer: the first image of the sums as an array texture, at texture unit `slot`
  kIndices,    // index buffer of 32-bit indices
  kCapture,    // transform feedback buffer `slot`
  kOtherSums,  // as kSums, the second image
};

struct Binding {
  uint32_t slot;
  Buffer buffer;  // kCount for kSums and kOtherSums
  Access access;
  const char* name;  // of the uniform, sampler or block in the shader; null for kIndices and kCapture
};

enum class ItemKind : uint8_t {
  kDispatch,  // run `shader` with groups[0] x groups[1] work-groups; in the clustered form groups[1] is the
              // number of kInstances to run, where the host may put fewer than all
  kDraw,      // draw `count` points numbered from 0 with the rasteriser off, capturing `captured`; or, where
              // there are indices, `count` corners of triangles from index `first`, without depth, blended
              // ONE, ONE into slice `slice` of image `image` of the sums; the shader's uniform `item` is the
              // slice
  kClear,     // set that slice to 0
  kBarrier,   // what was written before is read after
};

struct Item {
  ItemKind kind;
  const char* label;
  Shader shader = Shader::kCount;
  uint32_t groups[2] = {};
  uint32_t first = 0, count = 0;
  uint32_t slice = 0, image = 0;
  std::span<const Binding> bindings = {};
  // What transform feedback captures: one output a kCapture binding, or all outputs side by side into the
  // only one.
  std::span<const char* const> captured = {};
};

struct PlanOptions {
  Form form = Form::kClustered;
  bool posed_by_host = false;  // the host fills kPositions, the plan poses nothing
  bool normals = true;         // pose normals and tangents too
  Skinning skinning = Skinning::kLinear;
  bool ease = false;           // attack and release of weights
  bool point_q = false;        // the clustered form writes kPointQ too, for tools
  uint32_t instances = 1;      // >= 1; more than one in the clustered form alone
  uint32_t laplace_steps = 0;  // extra smoothing steps over the points; a clustered plan becomes staged
};

// Everything that changes from frame to frame, of one instance.
struct FrameInput {
  std::span<const Affine> palette;       // AssetView::palette, translations relative to the instance's origin
  std::span<const float> morph_weights;  // AssetView::morphs
  std::span<const float> region_weights;      // a layer, from driveRegions(); or empty: 0
  std::span<const Response> responses;        // a layer; or empty: those of the asset
  float scale = 1.0f;                         // uniform scale of the instance that the palette contains, > 0
  std::span<const JointMotion> motions = {};  // a palette entry, for dual quaternion skinning: splitPalette()
  // As in EaseJob.
  std::span<const Ease> eases = {};  // a layer; or empty: at once
  float seconds = 0.0f;              // since the last frame, >= 0
  bool reset = false;                // for the first frame, cuts and teleports
  float fade = 1.0f;                 // [0, 1], with distance
  uint32_t active_layers = 0xffffu;  // bit l: layer l is computed; the others cost nothing and weigh 0
  float laplace_rate = 0.5f;         // [0, 1], of PlanOptions::laplace_steps
};

class FramePlan {
 public:
  // `asset` must outlive the plan. Allocates; nothing else here does.
  FramePlan(const AssetView& asset, const PlanOptions& options);

  const AssetView& asset() const { return *asset_; }
  // As asked for, but staged where clusters cannot hold the asset or there are Laplacian steps, and of one
  // instance in the forms that have no more.
  const PlanOptions& options() const { return options_; }
  const BufferDesc& buffer(Buffer id) const { return buffers_[static_cast<size_t>(id)]; }
  const SumsDesc& sums() const { return sums_; }
  std::span<const Item> items() const { return items_; }

  // Bytes of one instance in a kPerInstance buffer.
  uint64_t instanceBytes(Buffer id) const { return buffer(id).bytes / options_.instances; }

  // The bytes of kFrame for one frame of one instance; `out` holds instanceBytes().
  void writeFrame(const FrameInput& input, std::span<std::byte> out) const;
  // The bytes of kMorphWeights likewise: weight * position_step, weight * normal_step a morph.
  void writeMorphWeights(const FrameInput& input, std::span<std::byte> out) const;

  // A slice of the sums: up to three layers that measure the same triangles. Its clears and draws may be left
  // out where none of them is in FrameInput::active_layers.
  struct Slice {
    uint32_t layers[3];                 // kAbsent: none
    uint32_t first_word, record_words;  // in kMeasured, and of a triangle there
    uint32_t first, count;              // of its triangles' corners in kSurfaceIndices
  };
  std::span<const Slice> slices() const { return slices_; }

 private:
  BufferDesc& add(Buffer id, const char* name, Lifetime lifetime, uint64_t bytes);
  void fill(Buffer id, const char* name, std::span<const std::byte> initial);
  void fillWords(Buffer id, const char* name, std::vector<uint32_t> words);
  void addCommon();
  bool addClustered();
  void addStaged();
  void addRaster();
  void addSlices();

  const AssetView* asset_;
  PlanOptions options_;
  BufferDesc buffers_[static_cast<size_t>(Buffer::kCount)] = {};
  SumsDesc sums_;
  std::vector<Slice> slices_;
  std::vector<Item> items_;
  std::vector<std::vector<uint32_t>> words_;  // what `initial` points into where the asset has no such array
};

// Complete source of each stage of a shader; null: no such stage. `hlsl` has the entry point main of profile
// cs_5_1 or later. `spirv` is a module for Vulkan 1.0 with the entry point main: storage buffers in
// descriptor set 0, uniform buffers in set 1, bound to the slots of the bindings; empty where furrow was
// built without glslangValidator.
struct ShaderSource {
  const char *compute = nullptr, *vertex = nullptr, *geometry = nullptr, *fragment = nullptr;  // GLSL
  const char* hlsl = nullptr;
  std::span<const uint32_t> spirv = {};
};
const ShaderSource& shaderSource(Shader shader);

}  // namespace furrow
