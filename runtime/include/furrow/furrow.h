#ifndef FURROW_FURROW_H
#define FURROW_FURROW_H

// furrow for engines, in C99: load assets, bind vertex buffers, pose, read wrinkle weights. It covers what
// the C++ headers beside it offer, and they can be used together.
//
// Rules that hold for every function:
//
// - It returns a code, FURROW_OK or what went wrong, and writes code and message to `status`, which may be
//   NULL. The message is English, one line, empty on success. On failure nothing was changed and an object's
//   out parameter is NULL. No exception leaves a function, and no call with NULL or sizes that do not fit
//   crashes; pointers to freed objects and to memory shorter than said cannot be told.
// - Structs begin with `size`: set it to sizeof. Fields that you do not know are then never read or written,
//   so a program keeps working with newer libraries; zero in a field means the default, so begin with
//   `FurrowFrame frame = {.size = sizeof frame}`, or in C++ `FurrowFrame frame = {}; frame.size = sizeof
//   frame;`. A library that is older than your header refuses a field it does not know, unless it is zero.
//   Structs without `size`, of which there are arrays or which are parts of others, are as they are for ever.
// - Threads: contexts, assets, bindings and plans may be used by any number of threads at once. An instance
//   belongs to one thread at a time, any thread. Nothing is locked and nothing waits.
// - Names are UTF-8, end in 0 and live as long as their asset. Vertices are in the asset's order unless a
//   binding says otherwise. Matrices are the upper three rows of an affine 4x4 matrix, row-major, for column
//   vectors. Space is glTF's: right-handed, +Y up, v of uvs downwards; lengths are in the source's unit.
//
// Memory: contexts, assets, bindings and instances, and all they hold, come from the context's allocator. By
// C++'s operator new come working memory of furrow_asset_create() (decoding, Draco among it; about the
// asset's size once more) and of furrow_binding_create() with a tolerance, given back before the call
// returns, and what a plan holds, given back when it is released. furrow_instance_frame() allocates nothing,
// takes no lock and makes no system call; neither do reading, recapture and furrow_plan_write(). A large
// asset lies in a few large blocks: an allocator that has pages of 2 MiB for those makes frames of a million
// triangles a few percent faster (docs/integration.md).

#include <stddef.h>
#include <stdint.h>

// Define FURROW_SHARED in programs that link the DLL on Windows.
#if defined(_WIN32) && defined(FURROW_BUILD)
#define FURROW_API __declspec(dllexport)
#elif defined(_WIN32) && defined(FURROW_SHARED)
#define FURROW_API __declspec(dllimport)
#elif defined(__GNUC__)
#define FURROW_API __attribute__((visibility("default")))
#else
#define FURROW_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define FURROW_VERSION_MAJOR 0
#define FURROW_VERSION_MINOR 1
#define FURROW_VERSION_PATCH 0
#define FURROW_MAX_LAYERS 16
#define FURROW_NONE 0xffffffffu  // no index

// Of the library: major << 16 | minor << 8 | patch.
FURROW_API uint32_t furrow_version(void);
// The asset format it reads.
FURROW_API uint32_t furrow_format_version(void);

enum {
  FURROW_OK = 0,
  FURROW_BAD_DATA = 1,             // the bytes are not a sound furrow asset
  FURROW_UNSUPPORTED_VERSION = 2,  // a sound asset of a format that this library does not read
  FURROW_UNSUPPORTED_FEATURE =
      3,  // needs a part that this library was built without, or a field it is too old for
  FURROW_OUT_OF_MEMORY = 4,
  FURROW_INVALID_ARGUMENT = 5,  // NULL, a size that does not fit, an index too large, a number not finite
  FURROW_UNAVAILABLE = 6        // this machine does not have it
};

typedef struct FurrowStatus {
  int32_t code;
  char message[192];
} FurrowStatus;

// ---- Context: the host's allocator, log and job system ----

typedef struct FurrowContext FurrowContext;

// One range of a piece of work.
typedef void (*FurrowTask)(void* data, uint32_t begin, uint32_t end, uint32_t worker);

enum { FURROW_LOG_INFO = 0, FURROW_LOG_WARNING = 1 };

// Instruction sets of the cpu tier; all of them give the same bits.
enum {
  FURROW_SIMD_BEST = 0,
  FURROW_SIMD_PORTABLE = 1,
  FURROW_SIMD_SSE4 = 2,
  FURROW_SIMD_AVX2 = 3,
  FURROW_SIMD_AVX512 = 4,
  FURROW_SIMD_NEON = 5
};

typedef struct FurrowContextDesc {
  size_t size;
  void* user;  // handed to every hook
  // Memory of `alignment`, a power of two up to 64, or NULL; both or none, then operator new. Called from
  // whatever thread calls furrow.
  void* (*allocate)(void* user, size_t bytes, size_t alignment);
  void (*release)(void* user, void* memory, size_t bytes, size_t alignment);
  // One line, no line break. May be NULL.
  void (*log)(void* user, int32_t severity, const char* message);
  // Calls task(data, begin, end, worker) for ranges that make up [0, count), in any order, on any threads,
  // and returns when all have returned. Ranges of `grain` items or more are worth a job. `worker`, below
  // `workers`, is never in two calls of the same parallel_for at once. Ranges or workers beyond those are not
  // run, and the call fails when all have returned, what it writes being half done. NULL: the calling thread
  // does everything.
  void (*parallel_for)(void* user, uint32_t count, uint32_t grain, FurrowTask task, void* data);
  uint32_t workers;  // 0: 1
  uint32_t simd;
} FurrowContextDesc;

// `desc` may be NULL. The context lives until it and all that was made with it are released.
FURROW_API int32_t furrow_context_create(const FurrowContextDesc* desc, FurrowContext** context,
                                         FurrowStatus* status);
FURROW_API void furrow_context_release(FurrowContext* context);
// "AVX2" and the like: what the cpu tier runs on.
FURROW_API const char* furrow_context_simd(const FurrowContext* context);

// ---- Assets ----

typedef struct FurrowAsset FurrowAsset;

enum {
  // Leave the clustered form out: 30 bytes a triangle less and 10 a layer, and frames take about twice as
  // long.
  FURROW_ASSET_STAGED = 1
};

typedef struct FurrowAssetDesc {
  size_t size;
  const void* bytes;  // a whole .furrow file; not needed after the call
  size_t byte_count;
  uint32_t influences;  // keep so many of the strongest joints a vertex, rescaled; 0: all of them
  uint32_t flags;
} FurrowAssetDesc;

// Any thread. The asset is immutable and counted: create gives one reference, instances and bindings hold
// their own.
FURROW_API int32_t furrow_asset_create(FurrowContext* context, const FurrowAssetDesc* desc,
                                       FurrowAsset** asset, FurrowStatus* status);
FURROW_API void furrow_asset_retain(FurrowAsset* asset);
FURROW_API void furrow_asset_release(FurrowAsset* asset);

typedef struct FurrowAssetInfo {
  size_t size;
  uint32_t vertices, triangles, points;
  uint32_t layers, morphs, palette, parts, texture_sets, drivers;
  uint32_t influences;     // joints a vertex
  uint32_t weight_stride;  // int16 a vertex in weight buffers: the layers, rounded up to even
  int32_t clustered;       // 0: every frame is staged
  float position_error;    // largest |asset - source| of a vertex at rest, in root space
  float morph_error;       // of a displacement at weight 1
  uint64_t memory_bytes;   // what it holds from the allocator, textures included
  uint64_t texture_bytes;  // of all texture sets
  const char* source;      // file name of what was cooked
  const char* tool_version;
} FurrowAssetInfo;
FURROW_API int32_t furrow_asset_info(const FurrowAsset* asset, FurrowAssetInfo* info, FurrowStatus* status);

// The arrays of an asset; valid as long as it.
typedef struct FurrowGeometry {
  size_t size;
  const float *positions, *normals;             // 3 a vertex, in part space at rest
  const float* tangents;                        // 4 a vertex, w: the sign of the bitangent
  const float* uvs;                             // 2 a vertex
  const uint32_t* indices;                      // 3 a triangle
  const uint32_t* source_vertex;                // a vertex: which one of the source it is
  const uint32_t *vertex_point, *point_vertex;  // a vertex: its point; a point: its vertex
} FurrowGeometry;
FURROW_API int32_t furrow_asset_geometry(const FurrowAsset* asset, FurrowGeometry* geometry,
                                         FurrowStatus* status);

enum {
  FURROW_MEASURE_DIRECTIONAL = 0,
  FURROW_MEASURE_AREA = 1,
  FURROW_MEASURE_PRINCIPAL = 2,
  FURROW_MEASURE_NONE = 3
};
enum { FURROW_CURVE_LARSSON = 0, FURROW_CURVE_OAT = 1 };

// How a squeeze becomes a weight; furrow/asset.h has the formulas.
typedef struct FurrowResponse {
  uint32_t curve;
  float lambda, beta;                  // > 0
  float stretch_lambda, stretch_beta;  // > 0
} FurrowResponse;

typedef struct FurrowLayerInfo {
  size_t size;
  const char* name;
  uint32_t measure;
  FurrowResponse response;
  int32_t has_bias;
  uint32_t mask_slice;  // channel mask_slice % 4 of slice mask_slice / 4 of the masks texture; FURROW_NONE
  const uint8_t* mask;  // a vertex, unorm8; NULL: 1
  uint32_t driver_begin, driver_end;
} FurrowLayerInfo;
FURROW_API int32_t furrow_layer_info(const FurrowAsset* asset, uint32_t layer, FurrowLayerInfo* info,
                                     FurrowStatus* status);
// The layer of that name; FURROW_NONE.
FURROW_API uint32_t furrow_layer_find(const FurrowAsset* asset, const char* name);

typedef struct FurrowMorphInfo {
  size_t size;
  const char* name;  // may be empty; several may have one name
  float default_weight;
  uint32_t vertices;      // how many it moves
  const uint32_t* moved;  // which, ascending
} FurrowMorphInfo;
FURROW_API int32_t furrow_morph_info(const FurrowAsset* asset, uint32_t morph, FurrowMorphInfo* info,
                                     FurrowStatus* status);
FURROW_API uint32_t furrow_morph_find(const FurrowAsset* asset, const char* name);  // the first one

// palette[i] = world(node) * inverse_bind, world() leading to the scene root.
typedef struct FurrowPaletteInfo {
  size_t size;
  const char* node;
  uint32_t node_index;  // in the source file
  float inverse_bind[12];
} FurrowPaletteInfo;
FURROW_API int32_t furrow_palette_info(const FurrowAsset* asset, uint32_t entry, FurrowPaletteInfo* info,
                                       FurrowStatus* status);

typedef struct FurrowPartInfo {
  size_t size;
  const char *mesh, *material;
  uint32_t vertex_begin, vertex_end, triangle_begin, triangle_end;
  uint32_t source_vertex_begin;
  uint32_t texture_set;  // FURROW_NONE
  float base_color[4];   // linear; opacity last
  float rest[12];        // part space -> root space at rest
} FurrowPartInfo;
FURROW_API int32_t furrow_part_info(const FurrowAsset* asset, uint32_t part, FurrowPartInfo* info,
                                    FurrowStatus* status);

// region weight of the layer += gain * curve(weight of the morph); furrow/drivers.h
typedef struct FurrowDriverInfo {
  size_t size;
  uint32_t morph;
  float gain;
  uint32_t curve_points;  // 0: the identity
  const float* curve;     // 2 a point: in, out
} FurrowDriverInfo;
FURROW_API int32_t furrow_driver_info(const FurrowAsset* asset, uint32_t driver, FurrowDriverInfo* info,
                                      FurrowStatus* status);

enum { FURROW_FORMAT_BC5 = 0, FURROW_FORMAT_BC4 = 1, FURROW_FORMAT_RGBA8 = 2 };

// An array texture, tightly packed: all slices of level 0, then of level 1, ...
typedef struct FurrowTexture {
  uint32_t format, width, height, slices, levels;  // slices 0: there is none
  const void* data;
  uint64_t bytes;
} FurrowTexture;

typedef struct FurrowTextureSetInfo {
  size_t size;
  const char* name;
  FurrowTexture normals;  // BC5: xy of the wrinkle normal in tangent space
  FurrowTexture shading;  // BC4: alpha shading factors; the slices are those of `normals`
  FurrowTexture masks;    // RGBA8: four layers a slice
  uint32_t compress_slice[FURROW_MAX_LAYERS], stretch_slice[FURROW_MAX_LAYERS];  // FURROW_NONE: no map
  float windows[2 * FURROW_MAX_LAYERS]
               [4];  // a slice: the low corner and 1 / the extent of its part of UV space
} FurrowTextureSetInfo;
FURROW_API int32_t furrow_texture_set_info(const FurrowAsset* asset, uint32_t set, FurrowTextureSetInfo* info,
                                           FurrowStatus* status);
// Bytes of one slice of one level.
FURROW_API size_t furrow_texture_level_bytes(uint32_t format, uint32_t width, uint32_t height,
                                             uint32_t level);

// ---- Bindings: the engine's own vertex buffers ----

typedef struct FurrowBinding FurrowBinding;

enum { FURROW_FLOAT3 = 0, FURROW_HALF3 = 1 };

// Element i: three numbers at data + offset + i * stride, of any alignment.
typedef struct FurrowStream {
  const void* data;
  size_t bytes;  // that may be read from `data`
  size_t offset;
  size_t stride;  // 0: tightly packed
  uint32_t format;
} FurrowStream;

// One mesh of the engine, in the bind pose.
typedef struct FurrowBindDesc {
  size_t size;
  FurrowStream positions;
  uint32_t vertices;
  const uint32_t* indices;  // 3 a triangle; NULL: places where surfaces touch are ambiguous
  size_t index_count;
  float to_root[12];  // a similarity: from `positions` to the asset's root space. Exact positions of the
                      // source need no tolerance with FurrowPartInfo.rest here. All zero: the identity
  float tolerance;    // root-space units; well below the edges' lengths
} FurrowBindDesc;

typedef struct FurrowBindCounts {
  size_t size;
  uint32_t matched, ambiguous, unmatched;  // vertices of the engine
  uint32_t missing;                        // points of the asset that none of them is
} FurrowBindCounts;

// `counts` may be NULL. A binding in which nothing matched is no error: look at the counts. Vertices go to
// the places of the source by a hash of their position, which is held against the place: a stranger does not
// match (furrow/bind.h has the chances).
FURROW_API int32_t furrow_binding_create(FurrowAsset* asset, const FurrowBindDesc* desc,
                                         FurrowBinding** binding, FurrowBindCounts* counts,
                                         FurrowStatus* status);
FURROW_API void furrow_binding_release(FurrowBinding* binding);
// A vertex: its point, FURROW_NONE where unmatched, FURROW_NONE - 1 where ambiguous.
FURROW_API const uint32_t* furrow_binding_points(const FurrowBinding* binding);

// ---- Instances ----

typedef struct FurrowInstance FurrowInstance;

// What an instance keeps memory for.
enum {
  FURROW_KEEP_POSITIONS = 1,        // posed positions, to be read; needed by halves, bindings, key frames
  FURROW_KEEP_NORMALS = 2,          // posed normals and tangents, to be read; includes the above
  FURROW_USE_DUAL_QUATERNIONS = 4,  // includes FURROW_KEEP_POSITIONS
  FURROW_USE_LAPLACE = 8,           // extra smoothing; includes FURROW_KEEP_POSITIONS
  FURROW_USE_RECAPTURE = 16,        // a rest of its own; includes FURROW_KEEP_POSITIONS
  FURROW_USE_EASE = 32              // attack and release
};

typedef struct FurrowInstanceDesc {
  size_t size;
  uint32_t features;
  void* memory;  // furrow_instance_memory() bytes, aligned to 64, for the instance's life; NULL: allocated
  size_t memory_bytes;
} FurrowInstanceDesc;

// Bytes an instance needs; `desc->memory` is not looked at. 0 on error.
FURROW_API size_t furrow_instance_memory(const FurrowAsset* asset, const FurrowInstanceDesc* desc);
// `desc` may be NULL. Weights are 0 until the first frame.
FURROW_API int32_t furrow_instance_create(FurrowAsset* asset, const FurrowInstanceDesc* desc,
                                          FurrowInstance** instance, FurrowStatus* status);
FURROW_API void furrow_instance_release(FurrowInstance* instance);
FURROW_API FurrowAsset* furrow_instance_asset(const FurrowInstance* instance);  // not retained

// How fast a layer's weight follows, in 1/s (after 1 / rate seconds, 63 % of the way); not above 0, or
// infinite: at once. Attack where it grows away from 0, release else.
typedef struct FurrowEase {
  float attack, release;
} FurrowEase;

// Posed vertices of the host: in the asset's order, or of a mesh that was bound.
typedef struct FurrowPosedMesh {
  FurrowStream from;
  FurrowStream to;               // the second of two key frames; data NULL: none
  const FurrowBinding* binding;  // NULL: the asset's order, and then this is the only mesh
} FurrowPosedMesh;

enum { FURROW_SKINNING_LINEAR = 0, FURROW_SKINNING_DUAL_QUATERNION = 1 };
enum { FURROW_KEYS_LINEAR = 0, FURROW_KEYS_QUADRATIC = 1 };

// Everything that a frame takes. Arrays are read during the call only.
typedef struct FurrowFrame {
  size_t size;

  // The pose: either palette and morph weights ...
  const float* palette;  // 12 an entry, translations relative to an origin near the character
  uint32_t palette_count;
  uint32_t skinning;
  const float* morph_weights;  // with `meshes`, for the drivers alone; NULL: 0
  uint32_t morph_count;
  // ... or posed vertices, in object space. Points that no mesh has count as at rest.
  const FurrowPosedMesh* meshes;
  uint32_t mesh_count;
  float key_time;  // between key frames, [0, 1]
  uint32_t key_curve;
  float scale;  // uniform scale of the instance that the pose contains; 0: 1

  // The response. Arrays have an entry a layer; NULL: the asset's, 0, at once.
  const FurrowResponse* responses;
  const float* region_weights;  // scripted, [-1, 1]
  int32_t ignore_drivers;       // else the drivers' answers to the morph weights are added
  uint32_t inactive_layers;     // bit l: layer l is not computed and weighs 0, as for those out of sight
  uint32_t laplace_steps;       // extra smoothing steps over the points
  float laplace_rate;           // of a step, (0, 1]; 0: 1/2

  // In time.
  const FurrowEase* eases;
  float seconds;  // since the last frame
  int32_t reset;  // weights go to their targets at once: the first frame, cuts, teleports
  // [0, 1] with distance: weights times 1 - fade_out. At 1 nothing is computed: weights are 0, the positions
  // and normals of the last computed frame stand, and the next frame below 1 resets.
  float fade_out;
  // Compute in every nth call (0: each), the first, and those that reset. In between the weights, positions
  // and normals of the last computed frame stand, and its time is added to the next: what is eased comes to
  // the same. Give instances phases of their own to spread the work.
  uint32_t every, phase;

  // Occlusion carried along with the morph targets [GPU Gems, ch. 4]: out = clamp(rest + sum of weight *
  // delta, 0, 1). Of a vertex; `deltas`: a pointer a target, beside FurrowMorphInfo.moved, or NULL.
  const float* occlusion_rest;
  const float* const* occlusion_deltas;
  float* occlusion;
} FurrowFrame;

typedef struct FurrowFrameReport {
  size_t size;
  int32_t computed;   // 0: the last frame's weights stand
  int32_t clustered;  // the fast form was used
} FurrowFrameReport;

// One frame on the cpu tier. `report` may be NULL.
//
// The clustered form is used wherever it can be: for a palette with linear skinning and no normals kept it
// poses on the way; every other pose is brought to float positions first. The staged form, with the same bits
// in its weights, does what clusters cannot: Laplacian steps, and assets that have no clusters.
FURROW_API int32_t furrow_instance_frame(FurrowInstance* instance, const FurrowFrame* frame,
                                         FurrowFrameReport* report, FurrowStatus* status);

// The pose of `frame` becomes the instance's rest: it does not wrinkle there, and wrinkle directions are
// carried along with the surface. Other fields but the scale say nothing. Needs FURROW_USE_RECAPTURE; lasts
// until the next recapture, reload or furrow_instance_forget_rest().
FURROW_API int32_t furrow_instance_recapture(FurrowInstance* instance, const FurrowFrame* frame,
                                             FurrowStatus* status);
FURROW_API int32_t furrow_instance_forget_rest(FurrowInstance* instance, FurrowStatus* status);

// Hot reload: the instance goes over to another asset, say one cooked anew, between two of its frames; other
// instances keep theirs until they do the same, and the last one frees the old asset. Load the new one on any
// thread. Kept: features and what is handed in with each frame (match layers and morphs by name where their
// numbers changed). Kept where both assets have the same number of vertices: the eased weights of layers that
// have the name in both. Reset: other weights to 0, a recaptured rest, positions. Bindings belong to an
// asset: make new ones. `memory` as for furrow_instance_create(), with furrow_instance_memory() of the new
// asset and beside the old memory, which is free afterwards. The instance's address changes: `instance` is
// written.
FURROW_API int32_t furrow_instance_reload(FurrowInstance** instance, FurrowAsset* asset, void* memory,
                                          size_t memory_bytes, FurrowStatus* status);

// Of the last computed frame; valid until the next one. Weights are snorm16 (w * 32767),
// FurrowAssetInfo.weight_stride a vertex; positions and normals 3 floats, tangents 4. NULL: not kept. Normals
// and tangents are posed by palettes alone: a host that poses its own vertices has its own normals.
FURROW_API const int16_t* furrow_instance_weights(const FurrowInstance* instance);
FURROW_API const float* furrow_instance_positions(const FurrowInstance* instance);
FURROW_API const float* furrow_instance_normals(const FurrowInstance* instance);
FURROW_API const float* furrow_instance_tangents(const FurrowInstance* instance);

enum { FURROW_WEIGHTS_SNORM16 = 0, FURROW_WEIGHTS_FLOAT = 1, FURROW_WEIGHTS_SNORM8 = 2 };

// Weights as an engine wants them: in its own vertex order, some layers, any stride.
typedef struct FurrowReadDesc {
  size_t size;
  const FurrowBinding* binding;  // NULL: the asset's order. Vertices without a point get 0
  uint32_t format;
  uint32_t layer_begin, layer_count;  // layer_count 0: all from layer_begin
  void* out;                          // layer_count numbers a vertex, at out + i * stride
  size_t bytes;                       // that may be written
  size_t stride;                      // 0: tightly packed
} FurrowReadDesc;
FURROW_API int32_t furrow_instance_read(const FurrowInstance* instance, const FurrowReadDesc* desc,
                                        FurrowStatus* status);

// ---- Frame plans: the frame on a GPU, recorded in the engine's own graphics API ----

// What buffers to make, what to bind and what to run; furrow/frame_plan.h says more, docs/integration.md
// walks through it. A plan does not change; any number of threads may read it.
typedef struct FurrowPlan FurrowPlan;

enum {
  FURROW_FORM_CLUSTERED = 0,  // compute, the fast path; without clusters or with Laplacian steps, the next
  FURROW_FORM_STAGED = 1,     // compute, a dispatch a stage
  FURROW_FORM_RASTER = 2      // OpenGL 3.3, without compute
};

typedef struct FurrowPlanDesc {
  size_t size;
  uint32_t form;
  int32_t posed_by_host;  // the host fills FURROW_BUFFER_POSITIONS, the plan poses nothing
  int32_t normals;        // pose normals and tangents too
  uint32_t skinning;
  // Attack and release of weights; set FurrowFrame.reset in the first frame. At FurrowFrame.fade_out 1 a plan
  // that is executed computes and eases on, where furrow_instance_frame() computes nothing and then resets:
  // set reset in the next frame below 1 for the same weights.
  int32_t ease;
  uint32_t instances;  // 0: 1; more in the clustered form alone
  // Extra smoothing, as FurrowFrame.laplace_steps then says again; makes a clustered plan staged.
  uint32_t laplace_steps;
  // Of this asset; its recaptured rest, if it has one, takes the place of the asset's. Read during the call
  // only. NULL: none.
  const FurrowInstance* rest;
} FurrowPlanDesc;

FURROW_API int32_t furrow_plan_create(FurrowAsset* asset, const FurrowPlanDesc* desc, FurrowPlan** plan,
                                      FurrowStatus* status);
FURROW_API void furrow_plan_release(FurrowPlan* plan);

typedef struct FurrowPlanInfo {
  size_t size;
  uint32_t form;       // as it came out
  uint32_t instances;  // likewise
  uint32_t buffers, items, shaders;
  uint32_t sums_width, sums_height, sums_slices;  // raster form: an array texture of RGBA32F; else 0
  uint64_t asset_bytes;                           // GPU memory of the plan's buffers, once an asset
  uint64_t instance_bytes;                        // for each instance
  uint32_t sums_images;                           // of these array textures: 2 with Laplacian steps, else 1
} FurrowPlanInfo;
FURROW_API int32_t furrow_plan_info(const FurrowPlan* plan, FurrowPlanInfo* info, FurrowStatus* status);

// What a host does with a buffer.
enum {
  FURROW_BUFFER_INTERNAL = 0,  // nothing but to make and bind it
  // written by furrow_plan_write(), every frame
  FURROW_BUFFER_FRAME = 1,
  FURROW_BUFFER_PALETTE = 2,
  FURROW_BUFFER_MORPH_WEIGHTS = 3,
  FURROW_BUFFER_INSTANCES = 4,  // the instances to run, a word each; at first all
  // to be read, or drawn with; `posed_by_host`: the first one is the host's
  FURROW_BUFFER_POSITIONS = 5,  // 3 floats a vertex
  FURROW_BUFFER_NORMALS = 6,    // 3 floats a vertex
  FURROW_BUFFER_TANGENTS = 7,   // 4 floats a vertex
  FURROW_BUFFER_WEIGHTS = 8     // snorm16, FurrowAssetInfo.weight_stride a vertex
};

typedef struct FurrowBufferInfo {
  size_t size;
  const char* name;
  uint32_t role;
  int32_t per_instance;     // `instances` parts of one size, one behind the other; else one an asset
  uint64_t bytes;           // 0: this plan does not use it
  uint64_t instance_bytes;  // of one instance, where per_instance
  const void* initial;      // `bytes` to fill it with once; NULL: none
} FurrowBufferInfo;
FURROW_API int32_t furrow_plan_buffer(const FurrowPlan* plan, uint32_t buffer, FurrowBufferInfo* info,
                                      FurrowStatus* status);

enum { FURROW_ITEM_DISPATCH = 0, FURROW_ITEM_DRAW = 1, FURROW_ITEM_CLEAR = 2, FURROW_ITEM_BARRIER = 3 };

// furrow/frame_plan.h says what each kind asks for.
typedef struct FurrowItemInfo {
  size_t size;
  uint32_t kind;
  const char* label;  // for the debugger
  uint32_t shader;    // for furrow_shader_source(); FURROW_NONE
  uint32_t groups[2];
  uint32_t first, count, slice;
  uint32_t bindings;
  uint32_t captured_count;
  const char* const* captured;
  uint32_t image;  // raster form: which of the sums' images it clears or draws in
} FurrowItemInfo;
FURROW_API int32_t furrow_plan_item(const FurrowPlan* plan, uint32_t item, FurrowItemInfo* info,
                                    FurrowStatus* status);

// How an item sees a buffer.
enum {
  FURROW_ACCESS_UNIFORM = 0,    // std140 uniform buffer, at `slot` of these
  FURROW_ACCESS_STORAGE = 1,    // storage buffer, at `slot` of these
  FURROW_ACCESS_FLOATS = 2,     // buffer texture of R32F, at texture unit `slot`
  FURROW_ACCESS_WORDS = 3,      // buffer texture of R32UI, at texture unit `slot`
  FURROW_ACCESS_SUMS = 4,       // not a buffer: the first image of the sums, at texture unit `slot`
  FURROW_ACCESS_INDICES = 5,    // index buffer of 32 bits
  FURROW_ACCESS_CAPTURE = 6,    // transform feedback buffer `slot`
  FURROW_ACCESS_OTHER_SUMS = 7  // as FURROW_ACCESS_SUMS, the second image
};

typedef struct FurrowBindingInfo {
  size_t size;
  uint32_t slot;
  uint32_t buffer;  // FURROW_NONE for the sums
  uint32_t access;
  const char* name;  // in the shader; NULL for indices and captures
} FurrowBindingInfo;
FURROW_API int32_t furrow_plan_binding(const FurrowPlan* plan, uint32_t item, uint32_t binding,
                                       FurrowBindingInfo* info, FurrowStatus* status);

// Complete sources; NULL: no such stage. SPIR-V is for Vulkan 1.0, entry point main: storage buffers in set
// 0, uniform buffers in set 1, bound to the slots; 0 bytes where furrow was built without its compiler.
typedef struct FurrowShaderSource {
  size_t size;
  const char *compute, *vertex, *geometry, *fragment;  // GLSL
  const char* hlsl;                                    // compute, entry point main
  const uint32_t* spirv;                               // compute
  size_t spirv_bytes;
} FurrowShaderSource;
FURROW_API int32_t furrow_shader_source(uint32_t shader, FurrowShaderSource* source, FurrowStatus* status);

// What a FURROW_BUFFER_FRAME, _PALETTE or _MORPH_WEIGHTS buffer takes for one frame of one instance; `out`
// has room for its instance_bytes, is aligned to 4, and may be mapped memory: it is written once, in order.
// Of `frame`, what the buffer holds is read: everything but palette, skinning and morph weights (but for the
// drivers); the palette; the morph weights. Which instances run when is the host's to say, in the instances'
// buffer: `every` and `phase` say nothing here, and `seconds` are those since the instance last ran. Neither
// allocates nor waits.
FURROW_API int32_t furrow_plan_write(const FurrowPlan* plan, uint32_t role, const FurrowFrame* frame,
                                     void* out, size_t bytes, FurrowStatus* status);

// ---- Pictures without a GPU: the software rasteriser ----

// A posed surface with its creases as pixels; furrow/raster.h says how it is drawn, and what state an engine
// sets that draws alpha shading itself.
typedef struct FurrowPicture {
  size_t size;
  const float* positions;     // posed, 3 a vertex in the asset's order, as furrow_instance_positions()
  float view_projection[16];  // row-major, clip = M (p, 1), near plane at z = -w, far plane at w, +y up
  uint32_t width, height;     // 1 to 4096
  uint32_t samples;           // a pixel: 1 or 4; 0: 4
  const float* colors;        // 3 a vertex: lit, linear; NULL if there is no `picture`
  const float* back_colors;   // of triangles seen clockwise; NULL: `colors`
  // The light that the surface mirrors, 3 a vertex: `colors`, lit as white is, are then multiplied by the
  // model's own colour map, where the asset has it, and this is added. NULL: the map is not read.
  const float* gloss;
  const float* back_gloss;  // of triangles seen clockwise; with `back_colors` and `gloss`
  const int16_t* weights;   // as furrow_instance_weights(); NULL: no creases
  float vertex_shade;       // of parts without maps, [0, 1]; 0: 0.55
  void* memory;             // furrow_picture_memory() bytes, aligned to 64
  size_t memory_bytes;
  float* picture;  // out, 4 a pixel from the top: linear colour times coverage, coverage; or NULL
  float* depth;    // out, a pixel: z / w in [-1, 1], 1 where there is nothing; or NULL
} FurrowPicture;
// Bytes; 0 for a size that cannot be drawn.
FURROW_API size_t furrow_picture_memory(const FurrowAsset* asset, uint32_t width, uint32_t height);
// By the context's jobs; allocates nothing, takes no lock. Pictures of one asset may be drawn at once.
FURROW_API int32_t furrow_picture_draw(const FurrowAsset* asset, const FurrowPicture* picture,
                                       FurrowStatus* status);

#ifdef __cplusplus
}
#endif

#endif
