#pragma once

// A cooked asset (.furrow) in memory: geometry, points, layers and maps, ready to be read by the jobs
// (jobs.h) and the frame plan (frame_plan.h). Immutable after load(); any number of threads may read it.

#include <cstddef>
#include <memory>
#include <memory_resource>
#include <span>
#include <string_view>

#include "furrow/status.h"
#include "furrow/types.h"

namespace furrow {

inline constexpr uint32_t kFormatVersion =
    5;  // bumped, never renumbered; docs/format.md says what each version changed
inline constexpr uint32_t kMaxLayers = 16;
inline constexpr uint32_t kMaxPaletteEntries = 65536;

// How a layer measures the squeeze of a triangle, as q, 1 at rest (docs/architecture.md).
enum class Measure : uint8_t {
  kDirectional = 0,  // squared length ratio along the wrinkle direction [Larsson]
  kArea = 1,         // area ratio [Oat]
  kPrincipal = 2,    // the smaller eigenvalue of F^T F
  kNone = 3,         // q = 1: the layer is driven by region weights alone
};

// How a squeeze becomes a weight.
enum class Curve : uint8_t {
  kLarsson = 0,  // I(alpha) = max(0, 1 - 2 / (1 + (alpha / lambda)^beta))   [Larsson, eq. 4]
  kOat = 1,      // w = 1 - q                                               [Oat]
};

struct Response {
  Curve curve = Curve::kLarsson;
  float lambda = 1.0f;          // > 0; below 1 wrinkles at rest, 1 at the slightest squeeze, above 1 later
  float beta = 4.0f;            // > 0; larger is steeper
  float stretch_lambda = 1.0f;  // the same for the stretch response, which sees 1 / alpha
  float stretch_beta = 4.0f;
};

// A run of vertices and triangles with one node, skin and material.
struct Part {
  std::string_view mesh;      // of the source; may be empty
  std::string_view material;  // may be empty
  uint32_t vertex_begin, vertex_end;
  uint32_t triangle_begin, triangle_end;
  uint32_t source_vertex_begin;  // where this part's vertices begin in source order
  uint32_t texture_set;          // index into texture_sets, or kAbsent
  Float4 base_color;             // linear; for previews. w: opacity, what is behind shows through the rest
  Affine rest;                   // part space -> the scene root's space at rest
  bool has_normals, has_uvs;     // of the source; normals are computed where it had none, UVs are zero
  float roughness;               // [0, 1]; for previews
  // Positions are offset + step * n for whole numbers n >= 0, in float.
  Float3 position_offset;
  float position_step;
  uint32_t base_maps = kAbsent;  // index into base_maps, or kAbsent
};

// One matrix of the palette that poses the asset: palette[i] = world(node) * inverse_bind, where world()
// leads to the scene root. The vertices of a mesh without skin are bound to an entry of their own, so that
// every vertex is posed in the same way.
struct PaletteEntry {
  std::string_view node;
  uint32_t node_index;  // in the source file
  Affine inverse_bind;
};

// A morph target: p += weight * position_step * position_deltas[i] for vertex vertices[i] (ascending),
// normals likewise.
struct Morph {
  std::string_view name;  // may be empty; several meshes may have targets of one name
  float default_weight;
  float position_step, normal_step;
  std::span<const uint32_t> vertices;
  std::span<const int32_t> position_deltas;  // 3 a vertex, of 24 bits
  std::span<const int8_t> normal_deltas;     // 3 a vertex; empty if the target has none
};

struct Layer {
  std::string_view name;
  Measure measure;
  Response response;
  std::span<const float>
      coefficients;  // coefficientCount(measure) a triangle; all zero: the triangle is in no ring
  std::span<const int16_t> bias;       // a vertex, snorm16; empty: 0
  std::span<const uint8_t> mask;       // a vertex, unorm8; empty: 1
  std::span<const int8_t> directions;  // 4 a point: the unit direction in root space at rest, 3 x snorm8, and
                                       // the confidence in it, 0 to 127; empty for kNone
  uint32_t mask_slice;                 // channel mask_slice % 4 of slice mask_slice / 4 of TextureSet::masks
  uint32_t driver_begin, driver_end;   // in drivers()
};

// region weight of the layer += gain * curve(morph weight); see drivers.h
struct Driver {
  uint32_t morph;
  float gain;
  std::span<const Float2>
      curve;  // (in, out) by ascending in, straight between them, level outside; empty: out = in
};

enum class TextureFormat : uint8_t {
  kBc5 = 0,    // two channels, unorm: slope-space normal x, y
  kBc4 = 1,    // one channel, unorm
  kRgba8 = 2,  // four channels, unorm
  kBc1 = 3,    // colour, sRGB-encoded, opaque
  kBc3 = 4,    // colour, sRGB-encoded, and opacity
};

// An array texture with its full mip chain. Slice s of level l is at data[offset(l) + s * size(l)], levels
// from the largest.
struct Texture {
  TextureFormat format;
  uint32_t width, height, slices, levels;
  std::span<const std::byte> data;  // tightly packed: all slices of level 0, then of level 1, ...
  // What the encoding cost, measured by the cook in level 0: degrees between normals (BC5), part of the range
  // (BC4, BC1, BC3), 0 for masks, which are stored to the bit.
  float rms_error = 0.0f, largest_error = 0.0f;
};

// The maps of the parts that share one UV space (one material). Per layer, a slice of `normals` and of
// `shading` for the compress pose and for the stretch pose, kAbsent where it has no map there.
struct TextureSet {
  std::string_view name;
  Texture normals;  // BC5: n.xy * 0.5 + 0.5 of the wrinkle normal in tangent space, z = sqrt(1 - x^2 - y^2);
                    // slices 0: no maps
  Texture shading;  // BC4: the factor W of alpha shading, C = C0 (1 - I W); the slices are those of `normals`
  Texture masks;    // RGBA8: four layers a slice; slices 0: use Layer::mask
  uint32_t compress_slice[kMaxLayers];
  uint32_t stretch_slice[kMaxLayers];
  // A slice of `normals` and `shading`: the part of UV space it covers, as its low corner and 1 / its extent:
  // uv is found at fract(uv - xy) * zw, and outside the map where that exceeds 1 (there is no wrinkle there).
  Float4 windows[2 * kMaxLayers];
};

// What a map shows beyond its borders.
enum class Wrap : uint8_t {
  kRepeat = 0,
  kClamp = 1,   // its outermost texels
  kMirror = 2,  // every other one turned over
};

// The model's own maps, for previews; a game has its own. Made only where the source has them and the recipe
// does not leave them out.
struct BaseMaps {
  Texture color;       // BC1 or BC3, one slice, times Part::base_color; slices 0: white
  float color_uv[6];   // m: found at (m[0] u + m[2] v + m[4], m[1] u + m[3] v + m[5])
  float opaque_from;   // nothing is seen where the colour's opacity is below it
  Texture normal;      // BC5, one slice, as TextureSet::normals; slices 0: flat
  float normal_uv[6];  // as color_uv
  Wrap color_wrap[2];  // across and down the map
  Wrap normal_wrap[2];
};

constexpr uint32_t coefficientCount(Measure measure) {
  return measure == Measure::kDirectional ? 2u
         : measure == Measure::kArea      ? 1u
         : measure == Measure::kPrincipal ? 3u
                                          : 0u;
}

// Bytes of one slice of one level.
size_t textureLevelBytes(TextureFormat format, uint32_t width, uint32_t height, uint32_t level);

// The texel at column x, row y of a slice of a level, as it is stored: each channel in [0, 1], those that the
// format lacks 0, opacity 1. One at a time: for tools.
Float4 texelAt(const Texture& texture, uint32_t level, uint32_t slice, uint32_t x, uint32_t y);

// Where in a map, 0 to 1, `at` is found.
float wrapped(Wrap wrap, float at);

// All spans point into the asset. Vertices are in the asset's own order, which is the decoded one.
struct AssetView {
  // Per vertex, in part space (Part::rest leads to root space).
  std::span<const Float3> positions;
  std::span<const Float3> normals;
  std::span<const Float4> tangents;  // w: the sign of the bitangent
  std::span<const Float2> uvs;
  std::span<const uint32_t> source_vertex;  // a permutation of [0, vertices)
  std::span<const uint32_t> vertex_point;   // < points
  uint32_t influences = 1;                  // joints a vertex
  std::span<const uint16_t> joints;         // influences a vertex, palette indices
  std::span<const uint16_t> weights;        // influences a vertex, unorm16, sum exactly 65535

  std::span<const uint32_t> indices;  // 3 a triangle, vertices

  // The surface: the same triangles by the vertex that stands for each corner's point, and the rings.
  std::span<const uint32_t> surface_indices;  // 3 a triangle, vertices
  std::span<const uint32_t> point_vertex;     // the vertex that stands for the point
  std::span<const uint32_t> ring_offsets;     // points + 1
  std::span<const uint32_t> ring_triangles;
  std::span<const uint16_t> ring_weights;  // rest angles; each ring sums to exactly 65535

  // Morph deltas once more, gathered by vertex for the GPU: vertices + 1 offsets, then entries of 4 words.
  // Vertex v owns the entries [offset[v], offset[v + 1]), by ascending morph: for x, y and z a word of
  // position (24 bits, in steps) | normal << 24 (8 bits, in steps), then the morph.
  std::span<const uint32_t> morph_entries;  // empty without morphs

  std::span<const Part> parts;
  std::span<const PaletteEntry> palette;
  std::span<const Morph> morphs;
  std::span<const Layer> layers;
  std::span<const Driver> drivers;
  std::span<const TextureSet> texture_sets;

  std::string_view tool_version;   // of the furrow that cooked it
  std::string_view source;         // file name of what was cooked
  std::span<const std::byte> rig;  // the section the pipeline's tools read nodes and clips from; opaque here
  std::span<const std::byte> place_hash;   // the section PlaceHash reads
  std::span<const uint32_t> place_points;  // 2 a place: its first point, how many points
  // Measured by the cook, in root space: largest |asset - source| of a vertex at rest, and of the
  // displacement of a vertex by a morph target at weight 1.
  float position_error, morph_error;
  // 4 a vertex, empty if the source has none: what Part::base_color is multiplied by, red, green and blue
  // each as 255 times the square root of the linear value, then 255. For previews.
  std::span<const uint8_t> colors;
  std::span<const BaseMaps> base_maps;
  // Largest distance, in root space and the bind pose, from a position of the source that leads to a place to
  // the vertex that stands for the place's first point.
  float place_error = 0.0f;

  uint32_t vertexCount() const { return static_cast<uint32_t>(positions.size()); }
  uint32_t triangleCount() const { return static_cast<uint32_t>(indices.size() / 3); }
  uint32_t pointCount() const { return static_cast<uint32_t>(point_vertex.size()); }
  uint32_t layerCount() const { return static_cast<uint32_t>(layers.size()); }
  // int16 a vertex in a weight buffer: the layers, rounded up to even so that GPUs can read pairs.
  uint32_t weightStride() const { return (layerCount() + 1) & ~1u; }
};

class Asset {
 public:
  Asset();
  ~Asset();
  Asset(Asset&&) noexcept;
  Asset& operator=(Asset&&) noexcept;

  // Reads a whole .furrow file. Every byte is covered by a checksum and every count, offset and index is
  // checked before it is used, so that the spans of view() can be trusted. `file` may be freed afterwards. On
  // error the asset stays empty. `memory` holds what the asset keeps and must outlive it; working memory of
  // the call (decoding, Draco) is C++'s own.
  Status load(std::span<const std::byte> file,
              std::pmr::memory_resource* memory = std::pmr::new_delete_resource());

  const AssetView& view() const { return view_; }

  struct Storage;  // private to the runtime

 private:
  struct Free {
    void operator()(Storage* storage) const;
  };

  AssetView view_;
  std::unique_ptr<Storage, Free> storage_;
};

}  // namespace furrow
