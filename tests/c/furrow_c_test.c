/* furrow_c_test FACE.furrow SLEEVE.furrow: furrow.h from C99, by known answers. Prints what fails; status 1
   if anything did. */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "furrow/furrow.h"

static int failures = 0;
#define CHECK(condition)                                     \
  do {                                                       \
    if (!(condition)) {                                      \
      printf("%s:%d: %s\n", __FILE__, __LINE__, #condition); \
      ++failures;                                            \
    }                                                        \
  } while (0)
#define CHECK_OK(call)                                                      \
  do {                                                                      \
    if ((call) != FURROW_OK) {                                              \
      printf("%s:%d: %s: %s\n", __FILE__, __LINE__, #call, status.message); \
      ++failures;                                                           \
    }                                                                       \
  } while (0)
/* It fails with the code and a message. */
#define CHECK_REFUSED(expected, call)                                                                 \
  do {                                                                                                \
    memset(&status, 0, sizeof status);                                                                \
    if ((call) != (expected) || status.code != (expected) || status.message[0] == 0) {                \
      printf("%s:%d: %s: code %d, \"%s\"\n", __FILE__, __LINE__, #call, status.code, status.message); \
      ++failures;                                                                                     \
    }                                                                                                 \
  } while (0)

/* ---- a host ---- */

typedef struct Host {
  long allocations, live_bytes, fail_after; /* fail_after < 0: never */
  int warnings, infos, calls;
  int reversed; /* ranges from the last to the first */
} Host;

static void* hostAllocate(void* user, size_t bytes, size_t alignment) {
  Host* host = user;
  char *raw, *aligned;
  if (host->fail_after == 0) return NULL;
  if (host->fail_after > 0) --host->fail_after;
  raw = malloc(bytes + alignment + sizeof raw);
  if (!raw) return NULL;
  aligned = raw + sizeof raw;
  aligned += (alignment - (size_t)aligned % alignment) % alignment;
  memcpy(aligned - sizeof raw, &raw, sizeof raw);
  ++host->allocations;
  host->live_bytes += (long)bytes;
  return aligned;
}

static void hostRelease(void* user, void* memory, size_t bytes, size_t alignment) {
  Host* host = user;
  char* raw;
  (void)alignment;
  memcpy(&raw, (char*)memory - sizeof raw, sizeof raw);
  host->live_bytes -= (long)bytes;
  free(raw);
}

static void hostLog(void* user, int32_t severity, const char* message) {
  Host* host = user;
  if (severity == FURROW_LOG_WARNING)
    ++host->warnings;
  else
    ++host->infos;
  CHECK(message[0] != 0 && !strchr(message, '\n'));
}

static void hostParallel(void* user, uint32_t count, uint32_t grain, FurrowTask task, void* data) {
  Host* host = user;
  const uint32_t ranges = (count + grain - 1) / grain;
  uint32_t i;
  ++host->calls;
  for (i = 0; i < ranges; ++i) {
    const uint32_t k = host->reversed ? ranges - 1 - i : i;
    const uint32_t end = (k + 1) * grain < count ? (k + 1) * grain : count;
    task(data, k * grain, end, i % 3);
  }
}

static void hostWrong(void* user, uint32_t count, uint32_t grain, FurrowTask task, void* data) {
  (void)user, (void)grain;
  task(data, 0, count, 99);
}

static FurrowContextDesc hostDesc(Host* host) {
  FurrowContextDesc desc = {.size = sizeof desc};
  desc.user = host;
  desc.allocate = hostAllocate;
  desc.release = hostRelease;
  desc.log = hostLog;
  desc.parallel_for = hostParallel;
  desc.workers = 3;
  return desc;
}

typedef struct File {
  void* bytes;
  size_t count;
} File;

static File readFile(const char* name) {
  File file = {NULL, 0};
  FILE* in = fopen(name, "rb");
  long size;
  if (!in) exit(2);
  fseek(in, 0, SEEK_END);
  size = ftell(in);
  rewind(in);
  file.bytes = malloc((size_t)size);
  file.count = fread(file.bytes, 1, (size_t)size, in);
  fclose(in);
  return file;
}

static FurrowAsset* loadAsset(FurrowContext* context, File file, uint32_t influences, uint32_t flags) {
  FurrowStatus status;
  FurrowAssetDesc desc = {.size = sizeof desc};
  FurrowAsset* asset = NULL;
  desc.bytes = file.bytes, desc.byte_count = file.count;
  desc.influences = influences, desc.flags = flags;
  CHECK_OK(furrow_asset_create(context, &desc, &asset, &status));
  return asset;
}

/* Every entry the same matrix. */
static float* makePalette(uint32_t entries, float squeeze) {
  float* palette = calloc(entries, 12 * sizeof(float));
  uint32_t i;
  for (i = 0; i < entries; ++i) palette[12 * i] = squeeze, palette[12 * i + 5] = palette[12 * i + 10] = 1.0f;
  return palette;
}

static FurrowFrame paletteFrame(const float* palette, const FurrowAssetInfo* info) {
  FurrowFrame frame = {.size = sizeof frame};
  frame.palette = palette;
  frame.palette_count = info->palette;
  frame.ignore_drivers = 1;
  return frame;
}

static int16_t* copyWeights(const FurrowInstance* instance, const FurrowAssetInfo* info) {
  const size_t bytes = sizeof(int16_t) * info->vertices * info->weight_stride;
  int16_t* copy = malloc(bytes);
  memcpy(copy, furrow_instance_weights(instance), bytes);
  return copy;
}

static int sameWeights(const FurrowInstance* instance, const int16_t* expected, const FurrowAssetInfo* info) {
  const int16_t* w = furrow_instance_weights(instance);
  uint32_t v, l;
  for (v = 0; v < info->vertices; ++v)
    for (l = 0; l < info->layers; ++l)
      if (w[v * info->weight_stride + l] != expected[v * info->weight_stride + l]) return 0;
  return 1;
}

static FurrowInstance* makeInstance(FurrowAsset* asset, uint32_t features) {
  FurrowStatus status;
  FurrowInstanceDesc desc = {.size = sizeof desc};
  FurrowInstance* instance = NULL;
  desc.features = features;
  CHECK_OK(furrow_instance_create(asset, &desc, &instance, &status));
  return instance;
}

/* ---- what is tested ---- */

/* The ABI on machines of 64 bits: the last field of each struct, and where it ends. A field that is added
   begins where its struct ended; in the padding before, an older program has garbage and an older library
   looks at nothing. */
static void testLayout(void) {
#define LAYOUT(type, field, offset, bytes) \
  { #type, offsetof(type, field), offset, sizeof(type), bytes }
  const struct {
    const char* name;
    size_t offset, expected_offset, bytes, expected_bytes;
  } layouts[] = {
      LAYOUT(FurrowStatus, message, 4, 196),
      LAYOUT(FurrowContextDesc, simd, 52, 56),
      LAYOUT(FurrowAssetDesc, flags, 28, 32),
      LAYOUT(FurrowAssetInfo, tool_version, 88, 96),
      LAYOUT(FurrowGeometry, point_vertex, 64, 72),
      LAYOUT(FurrowResponse, stretch_beta, 16, 20),
      LAYOUT(FurrowLayerInfo, driver_end, 60, 64),
      LAYOUT(FurrowMorphInfo, moved, 24, 32),
      LAYOUT(FurrowPaletteInfo, inverse_bind, 20, 72),
      LAYOUT(FurrowPartInfo, rest, 64, 112),
      LAYOUT(FurrowDriverInfo, curve, 24, 32),
      LAYOUT(FurrowTexture, bytes, 32, 40),
      LAYOUT(FurrowTextureSetInfo, windows, 264, 776),
      LAYOUT(FurrowStream, format, 32, 40),
      LAYOUT(FurrowBindDesc, tolerance, 120, 128),
      LAYOUT(FurrowBindCounts, missing, 20, 24),
      LAYOUT(FurrowInstanceDesc, memory_bytes, 24, 32),
      LAYOUT(FurrowEase, release, 4, 8),
      LAYOUT(FurrowPosedMesh, binding, 80, 88),
      LAYOUT(FurrowFrame, occlusion, 144, 152),
      LAYOUT(FurrowFrameReport, clustered, 12, 16),
      LAYOUT(FurrowReadDesc, stride, 48, 56),
      LAYOUT(FurrowPlanDesc, rest, 40, 48),
      LAYOUT(FurrowPlanInfo, sums_images, 56, 64),
      LAYOUT(FurrowBufferInfo, initial, 40, 48),
      LAYOUT(FurrowItemInfo, image, 64, 72),
      LAYOUT(FurrowBindingInfo, name, 24, 32),
      LAYOUT(FurrowShaderSource, spirv_bytes, 56, 64),
      LAYOUT(FurrowPicture, depth, 168, 176),
  };
  size_t i;
  for (i = 0; sizeof(void*) == 8 && i < sizeof layouts / sizeof layouts[0]; ++i)
    if (layouts[i].offset != layouts[i].expected_offset || layouts[i].bytes != layouts[i].expected_bytes)
      printf("%s: %zu of %zu bytes, it was %zu of %zu\n", layouts[i].name, layouts[i].offset,
             layouts[i].bytes, layouts[i].expected_offset, layouts[i].expected_bytes),
          ++failures;
}

static void testContext(void) {
  FurrowStatus status;
  Host host = {0, 0, -1, 0, 0, 0, 0};
  FurrowContextDesc desc = hostDesc(&host);
  FurrowContext* context = NULL;
  struct {
    FurrowContextDesc desc;
    size_t newer;
  } newer;

  CHECK(furrow_version() == (FURROW_VERSION_MAJOR << 16 | FURROW_VERSION_MINOR << 8 | FURROW_VERSION_PATCH));
  CHECK(furrow_format_version() >= 3);
  CHECK_OK(furrow_context_create(NULL, &context, &status));
  CHECK(furrow_context_simd(context)[0] != 0);
  furrow_context_release(context);
  CHECK_OK(furrow_context_create(&desc, &context, &status));
  CHECK(host.infos == 1 && host.live_bytes > 0);
  furrow_context_release(context);
  CHECK(host.live_bytes == 0);

  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_context_create(&desc, NULL, &status));
  CHECK(furrow_context_create(&desc, NULL, NULL) == FURROW_INVALID_ARGUMENT);
  desc.size = 0;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_context_create(&desc, &context, &status));
  CHECK(context == NULL);
  desc.size = 1000000;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_context_create(&desc, &context, &status));
  desc = hostDesc(&host), desc.release = NULL;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_context_create(&desc, &context, &status));
  desc = hostDesc(&host), desc.simd = 77;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_context_create(&desc, &context, &status));
  desc = hostDesc(&host), desc.simd = FURROW_SIMD_NEON; /* or this is an ARM */
  CHECK(furrow_context_create(&desc, &context, &status) == FURROW_UNAVAILABLE || status.code == FURROW_OK);
  furrow_context_release(context);
  desc = hostDesc(&host), host.fail_after = 0;
  CHECK_REFUSED(FURROW_OUT_OF_MEMORY, furrow_context_create(&desc, &context, &status));

  /* A newer header: its fields may be there while they say nothing. */
  host.fail_after = -1;
  memset(&newer, 0, sizeof newer);
  newer.desc = hostDesc(&host), newer.desc.size = sizeof newer;
  CHECK_OK(furrow_context_create(&newer.desc, &context, &status));
  furrow_context_release(context);
  newer.newer = 1;
  CHECK_REFUSED(FURROW_UNSUPPORTED_FEATURE, furrow_context_create(&newer.desc, &context, &status));
  /* An older one: it ends earlier. */
  desc = hostDesc(&host), desc.size = offsetof(FurrowContextDesc, log);
  CHECK_OK(furrow_context_create(&desc, &context, &status));
  CHECK(host.live_bytes > 0);
  furrow_context_release(context);
  furrow_context_release(NULL);
  CHECK(host.live_bytes == 0);
}

static void testAsset(FurrowContext* context, Host* host, File file) {
  FurrowStatus status;
  FurrowAsset* asset = loadAsset(context, file, 0, 0);
  FurrowAssetInfo info = {.size = sizeof info};
  FurrowAssetDesc desc = {.size = sizeof desc};
  FurrowGeometry geometry = {.size = sizeof geometry};
  uint32_t i, drivers = 0;

  CHECK_OK(furrow_asset_info(asset, &info, &status));
  CHECK(info.size == sizeof info && info.vertices > 1000 && info.triangles > 1000 &&
        info.points <= info.vertices);
  CHECK(info.clustered && info.weight_stride >= info.layers && info.weight_stride % 2 == 0);
  CHECK(info.memory_bytes > 100u * info.vertices && (long)info.memory_bytes <= host->live_bytes);
  CHECK(strstr(info.source, ".glb") && info.tool_version[0] != 0);
  CHECK_OK(furrow_asset_geometry(asset, &geometry, &status));
  for (i = 0; i < info.vertices; ++i)
    CHECK(geometry.vertex_point[i] < info.points && geometry.source_vertex[i] < info.vertices);
  for (i = 0; i < info.layers; ++i) {
    FurrowLayerInfo layer = {.size = sizeof layer};
    CHECK_OK(furrow_layer_info(asset, i, &layer, &status));
    CHECK(layer.response.beta > 0.0f && layer.measure <= FURROW_MEASURE_NONE);
    CHECK(furrow_layer_find(asset, layer.name) == i);
    drivers += layer.driver_end - layer.driver_begin;
  }
  CHECK(drivers == info.drivers);
  CHECK(furrow_layer_find(asset, "no such layer") == FURROW_NONE &&
        furrow_layer_find(asset, NULL) == FURROW_NONE);
  for (i = 0; i < info.morphs; ++i) {
    FurrowMorphInfo morph = {.size = sizeof morph};
    CHECK_OK(furrow_morph_info(asset, i, &morph, &status));
    CHECK(furrow_morph_find(asset, morph.name) <= i);
    CHECK(morph.vertices == 0 || morph.moved[morph.vertices - 1] < info.vertices);
  }
  for (i = 0; i < info.palette; ++i) {
    FurrowPaletteInfo entry = {.size = sizeof entry};
    CHECK_OK(furrow_palette_info(asset, i, &entry, &status));
    CHECK(isfinite(entry.inverse_bind[0]));
  }
  for (i = 0; i < info.drivers; ++i) {
    FurrowDriverInfo driver = {.size = sizeof driver};
    CHECK_OK(furrow_driver_info(asset, i, &driver, &status));
    CHECK(driver.morph < info.morphs);
  }
  for (i = 0; i < info.parts; ++i) {
    FurrowPartInfo part = {.size = sizeof part};
    CHECK_OK(furrow_part_info(asset, i, &part, &status));
    CHECK(part.vertex_begin < part.vertex_end && part.vertex_end <= info.vertices);
  }
  for (i = 0; i < info.texture_sets; ++i) {
    FurrowTextureSetInfo set = {.size = sizeof set};
    uint64_t bytes = 0;
    uint32_t level;
    CHECK_OK(furrow_texture_set_info(asset, i, &set, &status));
    for (level = 0; level < set.normals.levels; ++level)
      bytes += set.normals.slices *
               furrow_texture_level_bytes(set.normals.format, set.normals.width, set.normals.height, level);
    CHECK(bytes == set.normals.bytes && (bytes == 0 || set.normals.data));
    CHECK(set.normals.slices == 0 || set.windows[0][2] >= 1.0f);
  }
  {
    FurrowLayerInfo layer = {.size = sizeof layer};
    FurrowMorphInfo morph = {.size = sizeof morph};
    FurrowPartInfo part = {.size = sizeof part};
    FurrowPaletteInfo entry = {.size = sizeof entry};
    FurrowDriverInfo driver = {.size = sizeof driver};
    FurrowTextureSetInfo set = {.size = sizeof set};
    FurrowAssetInfo none = {0};
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_layer_info(asset, info.layers, &layer, &status));
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_morph_info(asset, info.morphs, &morph, &status));
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_part_info(asset, info.parts, &part, &status));
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_palette_info(asset, info.palette, &entry, &status));
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_driver_info(asset, info.drivers, &driver, &status));
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_texture_set_info(asset, info.texture_sets, &set, &status));
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_layer_info(NULL, 0, &layer, &status));
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_asset_info(asset, NULL, &status));
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_asset_info(asset, &none, &status));
    none.size = offsetof(FurrowAssetInfo, points); /* an older header: no more than that is written */
    none.points = 12345;
    CHECK_OK(furrow_asset_info(asset, &none, &status));
    CHECK(none.vertices == info.vertices && none.points == 12345);
  }
  CHECK(furrow_texture_level_bytes(99, 4, 4, 0) == 0);
  furrow_asset_retain(asset);
  furrow_asset_release(asset);
  CHECK_OK(furrow_asset_info(asset, &info, &status));
  furrow_asset_release(asset);
  furrow_asset_release(NULL);

  desc.bytes = file.bytes, desc.byte_count = file.count - 1;
  CHECK_REFUSED(FURROW_BAD_DATA, furrow_asset_create(context, &desc, &asset, &status));
  CHECK(asset == NULL);
  desc.bytes = "not an asset at all, but longer than its header", desc.byte_count = 40;
  CHECK_REFUSED(FURROW_BAD_DATA, furrow_asset_create(context, &desc, &asset, &status));
  desc.byte_count = 0;
  CHECK_REFUSED(FURROW_BAD_DATA, furrow_asset_create(context, &desc, &asset, &status));
  desc.bytes = NULL;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_asset_create(context, &desc, &asset, &status));
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_asset_create(context, NULL, &asset, &status));
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_asset_create(NULL, &desc, &asset, &status));
  desc.bytes = file.bytes, desc.byte_count = file.count, desc.flags = 64;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_asset_create(context, &desc, &asset, &status));
  desc.flags = 0;
}

/* Memory that runs out anywhere is an error and leaks nothing. */
static void testOutOfMemory(FurrowContext* context, Host* host, File file) {
  FurrowStatus status;
  FurrowAsset* asset = NULL;
  FurrowAssetDesc desc = {.size = sizeof desc, .bytes = file.bytes, .byte_count = file.count};
  const long before = host->live_bytes;
  long i;
  for (i = 0; i < 400; i += 1 + i / 16) {
    host->fail_after = i;
    if (furrow_asset_create(context, &desc, &asset, &status) == FURROW_OK) break;
    CHECK(status.code == FURROW_OUT_OF_MEMORY && host->live_bytes == before);
  }
  CHECK(i > 16);
  host->fail_after = -1;
  furrow_asset_release(asset);
  CHECK(host->live_bytes == before);
}

static uint16_t toHalf(float x) { /* towards 0 */
  int e;
  const float m = frexpf(fabsf(x), &e);
  if (m == 0.0f || e + 14 <= 0) return 0;
  return (uint16_t)((x < 0 ? 0x8000 : 0) | (e + 14) << 10 | (int)(m * 2048.0f - 1024.0f));
}
static float fromHalf(uint16_t h) {
  const float size = h & 0x7fff ? ldexpf((float)(1024 + (h & 1023)), (h >> 10 & 31) - 25) : 0.0f;
  return h & 0x8000 ? -size : size;
}

/* Halves at odd places give the weights of the floats that they are. */
static void testHalves(FurrowInstance* instance, const FurrowAssetInfo* info, const float* positions) {
  FurrowStatus status;
  FurrowFrame frame = {.size = sizeof frame};
  FurrowPosedMesh mesh;
  float* floats = malloc(12 * (size_t)info->vertices);
  unsigned char* halves = calloc(info->vertices, 9);
  int16_t* expected;
  uint32_t v, k;
  for (v = 0; v < info->vertices; ++v)
    for (k = 0; k < 3; ++k) {
      const uint16_t half = toHalf(positions[3 * v + k]);
      memcpy(halves + 9 * v + 3 + 2 * k, &half, 2);
      floats[3 * v + k] = fromHalf(half);
      CHECK(fabsf(floats[3 * v + k] - positions[3 * v + k]) <= fabsf(positions[3 * v + k]) / 1024.0f + 1e-4f);
    }
  memset(&mesh, 0, sizeof mesh);
  mesh.from.data = floats, mesh.from.bytes = 12 * (size_t)info->vertices;
  frame.meshes = &mesh, frame.mesh_count = 1;
  CHECK_OK(furrow_instance_frame(instance, &frame, NULL, &status));
  expected = copyWeights(instance, info);
  mesh.from.data = halves, mesh.from.bytes = 9 * (size_t)info->vertices, mesh.from.format = FURROW_HALF3;
  mesh.from.offset = 3, mesh.from.stride = 9;
  CHECK_OK(furrow_instance_frame(instance, &frame, NULL, &status));
  CHECK(sameWeights(instance, expected, info));
  free(floats), free(halves), free(expected);
}

/* The pose by every way in: the same weights. */
static void testPoses(FurrowContext* context, File file) {
  FurrowStatus status;
  FurrowAsset *asset = loadAsset(context, file, 0, 0),
              *staged = loadAsset(context, file, 0, FURROW_ASSET_STAGED);
  FurrowAssetInfo info = {.size = sizeof info};
  FurrowInstance *plain, *posing, *normals, *by_stages;
  FurrowFrameReport report = {.size = sizeof report};
  FurrowFrame frame, meshes = {.size = sizeof meshes};
  FurrowPosedMesh mesh;
  float *palette, *packed, *zero;
  unsigned char* wide;
  int16_t* expected;
  uint32_t v, strongest = 0;
  const float* positions;

  CHECK_OK(furrow_asset_info(asset, &info, &status));
  palette = makePalette(info.palette, 0.7f);
  frame = paletteFrame(palette, &info);
  plain = makeInstance(asset, 0);
  for (v = 0; v < info.vertices; ++v) CHECK(furrow_instance_weights(plain)[v * info.weight_stride] == 0);
  CHECK_OK(furrow_instance_frame(plain, &frame, &report, &status));
  CHECK(report.computed && report.clustered);
  expected = copyWeights(plain, &info);
  for (v = 0; v < info.vertices * info.weight_stride; ++v)
    if ((uint32_t)abs(expected[v]) > strongest) strongest = (uint32_t)abs(expected[v]);
  CHECK(strongest > 3000); /* squeezed to 0.7 */
  CHECK(furrow_instance_positions(plain) == NULL && furrow_instance_normals(plain) == NULL);

  posing = makeInstance(asset, FURROW_KEEP_POSITIONS);
  CHECK_OK(furrow_instance_frame(posing, &frame, &report, &status));
  CHECK(sameWeights(posing, expected, &info) && report.clustered);
  positions = furrow_instance_positions(posing);
  CHECK(positions != NULL);
  normals = makeInstance(asset, FURROW_KEEP_NORMALS);
  CHECK_OK(furrow_instance_frame(normals, &frame, &report, &status));
  CHECK(sameWeights(normals, expected, &info) && report.clustered);
  CHECK(memcmp(positions, furrow_instance_positions(normals), 12 * (size_t)info.vertices) == 0);
  for (v = 0; v < info.vertices; ++v) {
    const float *n = furrow_instance_normals(normals) + 3 * v, *t = furrow_instance_tangents(normals) + 4 * v;
    CHECK(fabsf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1.0f) < 1e-5f);
    CHECK(fabsf(n[0] * t[0] + n[1] * t[1] + n[2] * t[2]) < 1e-5f);
  }
  by_stages = makeInstance(staged, 0);
  CHECK_OK(furrow_instance_frame(by_stages, &frame, &report, &status));
  CHECK(sameWeights(by_stages, expected, &info) && report.computed && !report.clustered);

  /* The host's own vertices: packed, and in a buffer with an odd stride. */
  packed = malloc(12 * (size_t)info.vertices);
  memcpy(packed, positions, 12 * (size_t)info.vertices);
  wide = calloc(info.vertices, 29);
  for (v = 0; v < info.vertices; ++v) memcpy(wide + 29 * v + 5, packed + 3 * v, 12);
  memset(&mesh, 0, sizeof mesh);
  mesh.from.data = packed, mesh.from.bytes = 12 * (size_t)info.vertices;
  meshes.meshes = &mesh, meshes.mesh_count = 1;
  CHECK_OK(furrow_instance_frame(plain, &meshes, &report, &status));
  CHECK(sameWeights(plain, expected, &info) && report.clustered);
  CHECK_OK(furrow_instance_frame(by_stages, &meshes, &report, &status));
  CHECK(sameWeights(by_stages, expected, &info));
  testHalves(posing, &info, packed);
  mesh.from.data = wide, mesh.from.bytes = 29 * (size_t)info.vertices, mesh.from.offset = 5,
  mesh.from.stride = 29;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_frame(plain, &meshes, &report, &status));
  CHECK(!report.computed && sameWeights(plain, expected, &info));
  CHECK_OK(furrow_instance_frame(posing, &meshes, &report, &status));
  CHECK(sameWeights(posing, expected, &info));

  /* Half way in time from a key frame twice as wide: the pose again. */
  mesh.from.data = packed, mesh.from.bytes = 12 * (size_t)info.vertices, mesh.from.offset = 0,
  mesh.from.stride = 12;
  zero = calloc(info.vertices, 12);
  mesh.to = mesh.from;
  mesh.from.data = zero;
  for (v = 0; v < 3 * info.vertices; ++v) packed[v] *= 2.0f;
  meshes.key_time = 0.5f;
  CHECK_OK(furrow_instance_frame(posing, &meshes, &report, &status));
  CHECK(sameWeights(posing, expected, &info));
  for (v = 0; v < 3 * info.vertices; ++v) packed[v] *= 2.0f;
  meshes.key_curve = FURROW_KEYS_QUADRATIC;
  CHECK_OK(furrow_instance_frame(posing, &meshes, &report, &status));
  CHECK(sameWeights(posing, expected, &info));
  meshes.key_curve = 2;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_frame(posing, &meshes, &report, &status));

  /* Scale is no squeeze. */
  for (v = 0; v < info.palette; ++v) palette[12 * v] = palette[12 * v + 5] = palette[12 * v + 10] = 2.0f;
  frame.scale = 2.0f;
  CHECK_OK(furrow_instance_frame(plain, &frame, NULL, NULL));
  for (v = 0; v < info.palette; ++v) palette[12 * v] = palette[12 * v + 5] = palette[12 * v + 10] = 1.0f;
  frame.scale = 0.0f;
  CHECK_OK(furrow_instance_frame(posing, &frame, NULL, NULL));
  for (v = 0; v < info.vertices; ++v)
    CHECK(abs(furrow_instance_weights(plain)[v * info.weight_stride] -
              furrow_instance_weights(posing)[v * info.weight_stride]) <= 3);

  free(palette), free(expected), free(packed), free(wide), free(zero);
  furrow_instance_release(plain), furrow_instance_release(posing);
  furrow_instance_release(normals), furrow_instance_release(by_stages);
  furrow_asset_release(asset), furrow_asset_release(staged);
}

static void testDualQuaternions(FurrowContext* context, File file) {
  FurrowStatus status;
  FurrowAsset *asset = loadAsset(context, file, 0, 0), *light = loadAsset(context, file, 1, 0);
  FurrowAssetInfo info = {.size = sizeof info};
  FurrowInstance *linear, *dual, *single;
  FurrowFrame frame;
  float* palette;
  uint32_t v, i, moved = 0;
  float most = 0.0f;

  CHECK_OK(furrow_asset_info(asset, &info, &status));
  palette = makePalette(info.palette, 1.0f);
  frame = paletteFrame(palette, &info);
  linear = makeInstance(asset, FURROW_KEEP_POSITIONS);
  dual = makeInstance(asset, FURROW_USE_DUAL_QUATERNIONS);
  frame.skinning = FURROW_SKINNING_DUAL_QUATERNION;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_frame(linear, &frame, NULL, &status));
  /* One rigid motion of all joints: both ways move alike. */
  for (i = 0; i < info.palette; ++i) {
    float* m = palette + 12 * i;
    m[5] = 0.8f, m[6] = -0.6f, m[9] = 0.6f, m[10] = 0.8f, m[3] = 3.0f;
  }
  CHECK_OK(furrow_instance_frame(dual, &frame, NULL, &status));
  frame.skinning = FURROW_SKINNING_LINEAR;
  CHECK_OK(furrow_instance_frame(linear, &frame, NULL, &status));
  for (v = 0; v < 3 * info.vertices; ++v) {
    const float d = fabsf(furrow_instance_positions(dual)[v] - furrow_instance_positions(linear)[v]);
    most = d > most ? d : most;
  }
  CHECK(most < 2e-6f);

  /* One joint a vertex, and another one moved: everything follows one of the two, nothing is between. */
  single = makeInstance(light, FURROW_KEEP_POSITIONS);
  for (i = 0; i < info.palette; ++i)
    memset(palette + 12 * i, 0, 48), palette[12 * i] = palette[12 * i + 5] = palette[12 * i + 10] = 1.0f;
  CHECK_OK(furrow_instance_frame(single, &frame, NULL, &status));
  {
    float* rest = malloc(12 * (size_t)info.vertices);
    memcpy(rest, furrow_instance_positions(single), 12 * (size_t)info.vertices);
    palette[12 * (info.palette - 1) + 3] = 16.0f;
    CHECK_OK(furrow_instance_frame(single, &frame, NULL, &status));
    for (v = 0; v < info.vertices; ++v) {
      const float d = furrow_instance_positions(single)[3 * v] - rest[3 * v];
      CHECK(fabsf(d) < 1e-4f || fabsf(d - 16.0f) < 1e-4f);
      moved += d > 1.0f;
    }
    CHECK(moved > 0 && moved < info.vertices);
    free(rest);
  }
  CHECK_OK(furrow_asset_info(light, &info, &status));
  CHECK(info.influences == 1);
  free(palette);
  furrow_instance_release(linear), furrow_instance_release(dual), furrow_instance_release(single);
  furrow_asset_release(asset), furrow_asset_release(light);
}

/* From the rest of `frame`, another pose has the same weights in both forms, with and without clusters and
   Laplacian steps. */
static void testRestOfItsOwn(FurrowContext* context, File file, FurrowFrame frame) {
  FurrowStatus status;
  FurrowAsset* assets[2];
  FurrowAssetInfo info = {.size = sizeof info};
  FurrowInstance* instances[3];
  FurrowFrameReport report = {.size = sizeof report};
  float* palette;
  int16_t* expected;
  int i, steps;
  assets[0] = loadAsset(context, file, 0, FURROW_ASSET_STAGED), assets[1] = loadAsset(context, file, 0, 0);
  CHECK_OK(furrow_asset_info(assets[0], &info, &status));
  palette = makePalette(info.palette, 0.8f);
  instances[0] = makeInstance(assets[0], FURROW_USE_RECAPTURE);
  instances[1] = makeInstance(assets[1], FURROW_USE_RECAPTURE);
  instances[2] = makeInstance(assets[1], FURROW_USE_RECAPTURE | FURROW_USE_LAPLACE);
  for (i = 0; i < 3; ++i) CHECK_OK(furrow_instance_recapture(instances[i], &frame, &status));
  frame.palette = palette;
  for (steps = 0; steps < 3; steps += 2) {
    frame.laplace_steps = (uint32_t)steps;
    CHECK_OK(furrow_instance_frame(instances[0], &frame, &report, &status));
    CHECK(!report.clustered);
    expected = copyWeights(instances[0], &info);
    for (i = steps ? 2 : 1; i < 3; ++i) {
      CHECK_OK(furrow_instance_frame(instances[i], &frame, &report, &status));
      CHECK(report.clustered == (steps == 0) && sameWeights(instances[i], expected, &info));
    }
    free(expected);
  }
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_frame(instances[1], &frame, &report, &status));
  for (i = 0; i < 3; ++i) furrow_instance_release(instances[i]);
  furrow_asset_release(assets[0]), furrow_asset_release(assets[1]);
  free(palette);
}

static void testResponse(FurrowContext* context, File file) {
  FurrowStatus status;
  FurrowAsset* asset = loadAsset(context, file, 0, 0);
  FurrowAssetInfo info = {.size = sizeof info};
  FurrowInstance* instance = makeInstance(asset, FURROW_USE_EASE | FURROW_USE_LAPLACE | FURROW_USE_RECAPTURE);
  FurrowFrame frame;
  FurrowFrameReport report = {.size = sizeof report};
  FurrowResponse responses[FURROW_MAX_LAYERS];
  FurrowEase eases[FURROW_MAX_LAYERS];
  float regions[FURROW_MAX_LAYERS];
  float* palette;
  int16_t* expected;
  const int16_t* w = furrow_instance_weights(instance);
  float before[3];
  uint32_t i, l;

  CHECK_OK(furrow_asset_info(asset, &info, &status));
  palette = makePalette(info.palette, 1.0f);
  frame = paletteFrame(palette, &info);
  CHECK_OK(furrow_instance_frame(instance, &frame, &report, &status));
  expected = copyWeights(instance, &info);

  /* A region weight is added: at rest it is the weight, but where the bias clamps. */
  for (l = 0; l < FURROW_MAX_LAYERS; ++l) regions[l] = 0.25f;
  frame.region_weights = regions;
  CHECK_OK(furrow_instance_frame(instance, &frame, &report, &status));
  for (i = 0; i < info.vertices; ++i)
    CHECK(abs(w[i * info.weight_stride] - expected[i * info.weight_stride] - 8192) <= 2 ||
          w[i * info.weight_stride] == 32767);
  regions[0] = NAN;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_frame(instance, &frame, &report, &status));
  regions[0] = 0.25f;

  /* Attack: after 1 / rate seconds, 1 - 1/e of the way; in one step or in many; release alike. */
  for (l = 0; l < FURROW_MAX_LAYERS; ++l) eases[l].attack = 2.0f, eases[l].release = 4.0f, regions[l] = 0.0f;
  frame.eases = eases;
  frame.reset = 1;
  CHECK_OK(furrow_instance_frame(instance, &frame, &report, &status));
  CHECK(sameWeights(instance, expected, &info));
  frame.reset = 0;
  for (l = 0; l < FURROW_MAX_LAYERS; ++l) regions[l] = 0.5f;
  frame.seconds = 0.05f;
  for (i = 0; i < 10; ++i) CHECK_OK(furrow_instance_frame(instance, &frame, &report, &status));
  for (i = 0; i < info.vertices; ++i)
    if (expected[i * info.weight_stride] == 0)
      CHECK(abs(w[i * info.weight_stride] - (int)(16384 * (1 - exp(-1.0)))) <= 12);
  frame.every = 5, frame.phase = 0; /* the same time in skipped frames comes to the same */
  {
    int16_t* half = copyWeights(instance, &info);
    int computed = 0;
    frame.reset = 1;
    for (l = 0; l < FURROW_MAX_LAYERS; ++l) regions[l] = 0.0f;
    CHECK_OK(furrow_instance_frame(instance, &frame, &report, &status));
    frame.reset = 0;
    for (l = 0; l < FURROW_MAX_LAYERS; ++l) regions[l] = 0.5f;
    for (i = 0; i < 10; ++i) {
      CHECK_OK(furrow_instance_frame(instance, &frame, &report, &status));
      computed += report.computed;
    }
    CHECK(computed == 2);
    for (i = 0; i < 5 && !report.computed; ++i)
      CHECK_OK(furrow_instance_frame(instance, &frame, &report, &status));
    for (i = 0; i < info.vertices; ++i)
      if (expected[i * info.weight_stride] == 0)
        CHECK(w[i * info.weight_stride] > 0 &&
              w[i * info.weight_stride] <= half[i * info.weight_stride] + 2500);
    free(half);
  }
  { /* phases take turns */
    FurrowInstance *even = makeInstance(asset, 0), *odd = makeInstance(asset, 0);
    FurrowFrame turn = paletteFrame(palette, &info);
    turn.every = 2;
    for (i = 0; i < 5; ++i) {
      FurrowFrameReport other = {.size = sizeof other};
      turn.phase = 0;
      CHECK_OK(furrow_instance_frame(even, &turn, &report, &status));
      turn.phase = 1;
      CHECK_OK(furrow_instance_frame(odd, &turn, &other, &status));
      CHECK(report.computed == (i % 2 == 0) &&
            other.computed == (i == 0 || i % 2 == 1)); /* the first always */
    }
    furrow_instance_release(even), furrow_instance_release(odd);
  }
  frame.every = 0;
  frame.seconds = -1.0f;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_frame(instance, &frame, &report, &status));
  frame.seconds = 0.0f;

  /* Fade. */
  frame.eases = NULL;
  frame.fade_out = 0.75f;
  CHECK_OK(furrow_instance_frame(instance, &frame, &report, &status));
  for (i = 0; i < info.vertices; ++i)
    if (expected[i * info.weight_stride] == 0) CHECK(abs(w[i * info.weight_stride] - 4096) <= 1);
  memcpy(before, furrow_instance_positions(instance), sizeof before);
  frame.fade_out = 1.0f;
  palette[0] = 0.5f; /* a pose that is not looked at */
  CHECK_OK(furrow_instance_frame(instance, &frame, &report, &status));
  CHECK(report.computed && !report.clustered);
  for (i = 0; i < info.vertices * info.weight_stride; ++i) CHECK(w[i] == 0);
  CHECK(memcmp(furrow_instance_positions(instance), before, sizeof before) == 0);
  palette[0] = 1.0f;
  frame.fade_out = 0.0f, frame.eases = eases; /* then at the targets at once, however slow the ease */
  for (l = 0; l < FURROW_MAX_LAYERS; ++l) regions[l] = 0.25f;
  CHECK_OK(furrow_instance_frame(instance, &frame, &report, &status));
  for (i = 0; i < info.vertices; ++i)
    if (expected[i * info.weight_stride] == 0) CHECK(abs(w[i * info.weight_stride] - 8192) <= 1);
  frame.eases = NULL;
  frame.fade_out = 1.5f;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_frame(instance, &frame, &report, &status));
  frame.fade_out = 0.0f;
  for (l = 0; l < FURROW_MAX_LAYERS; ++l) regions[l] = 0.0f;

  /* At rest, more smoothing changes next to nothing, and takes the staged way. */
  frame.laplace_steps = 3;
  CHECK_OK(furrow_instance_frame(instance, &frame, &report, &status));
  CHECK(!report.clustered);
  for (i = 0; i < info.vertices; ++i)
    CHECK(abs(w[i * info.weight_stride] - expected[i * info.weight_stride]) <= 40);
  frame.laplace_steps = 0;

  /* A squeezed pose as rest is at rest; forgotten, it is squeezed. */
  for (i = 0; i < info.palette; ++i) palette[12 * i] = 0.6f;
  memcpy(before, furrow_instance_positions(instance), sizeof before);
  CHECK_OK(furrow_instance_recapture(instance, &frame, &status));
  CHECK(memcmp(furrow_instance_positions(instance), before, sizeof before) == 0); /* of the last frame */
  CHECK_OK(furrow_instance_frame(instance, &frame, &report, &status));
  CHECK(report.clustered);
  for (i = 0; i < info.vertices; ++i)
    CHECK(abs(w[i * info.weight_stride] - expected[i * info.weight_stride]) <= 60);
  testRestOfItsOwn(context, file, frame);
  CHECK_OK(furrow_instance_forget_rest(instance, &status));
  CHECK_OK(furrow_instance_frame(instance, &frame, &report, &status));
  CHECK(report.clustered);
  l = 0;
  for (i = 0; i < info.vertices; ++i)
    l += abs(w[i * info.weight_stride] - expected[i * info.weight_stride]) > 3000;
  CHECK(l > info.vertices / 10);

  /* A steep response; one that is none. */
  for (l = 0; l < FURROW_MAX_LAYERS; ++l) {
    const FurrowResponse oat = {FURROW_CURVE_OAT, 1.0f, 1.0f, 1.0f, 1.0f};
    responses[l] = oat;
  }
  frame.responses = responses;
  CHECK_OK(furrow_instance_frame(instance, &frame, &report, &status));
  for (i = 0; i < info.vertices; ++i) /* 1 - q, q >= 0.36 */
    CHECK(w[i * info.weight_stride] - expected[i * info.weight_stride] <= 0.66 * 32767);
  responses[0].lambda = 0.0f;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_frame(instance, &frame, &report, &status));
  responses[0].lambda = 1.0f, responses[0].curve = 7;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_frame(instance, &frame, &report, &status));
  frame.responses = NULL;

  /* What does not fit. */
  frame.palette_count = info.palette + 1;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_frame(instance, &frame, &report, &status));
  frame.palette_count = info.palette, frame.palette = NULL;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_frame(instance, &frame, &report, &status));
  frame.palette = palette, frame.skinning = 9;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_frame(instance, &frame, &report, &status));
  frame.skinning = 0, frame.scale = -1.0f;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_frame(instance, &frame, &report, &status));
  frame.scale = 1.0f;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_frame(instance, NULL, &report, &status));
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_frame(NULL, &frame, &report, &status));
  frame.size = 3;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_frame(instance, &frame, &report, &status));
  frame.size = sizeof frame;
  {
    FurrowInstance* bare = makeInstance(asset, 0);
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_recapture(bare, &frame, &status));
    frame.laplace_steps = 1;
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_frame(bare, &frame, &report, &status));
    frame.laplace_steps = 0, frame.eases = eases;
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_frame(bare, &frame, &report, &status));
    furrow_instance_release(bare);
  }
  furrow_instance_release(NULL);
  free(palette), free(expected);
  furrow_instance_release(instance);
  furrow_asset_release(asset);
}

/* Layers that are switched off weigh nothing and leave the others as they are, in either form. */
static void testInactiveLayers(FurrowContext* context, File file) {
  FurrowStatus status;
  FurrowAsset* asset = loadAsset(context, file, 0, 0);
  FurrowAssetInfo info = {.size = sizeof info};
  FurrowInstance* instance = makeInstance(asset, FURROW_USE_LAPLACE);
  FurrowFrame frame;
  FurrowFrameReport report = {.size = sizeof report};
  float *palette, *morphs;
  uint32_t i, l, mask;
  CHECK_OK(furrow_asset_info(asset, &info, &status));
  palette = makePalette(info.palette, 0.7f);
  morphs = calloc(info.morphs + 1, sizeof(float));
  frame = paletteFrame(palette, &info);
  frame.morph_weights = morphs, frame.morph_count = info.morphs;
  for (frame.laplace_steps = 0; frame.laplace_steps < 2; ++frame.laplace_steps) {
    int16_t* all;
    frame.inactive_layers = 0;
    CHECK_OK(furrow_instance_frame(instance, &frame, &report, &status));
    CHECK(report.clustered == (frame.laplace_steps == 0));
    all = copyWeights(instance, &info);
    for (mask = 0; mask < 1u << info.layers; ++mask) {
      const int16_t* w = furrow_instance_weights(instance);
      frame.inactive_layers = mask;
      CHECK_OK(furrow_instance_frame(instance, &frame, &report, &status));
      for (i = 0; i < info.vertices * info.weight_stride; ++i) {
        l = i % info.weight_stride;
        if (l < info.layers && w[i] != (mask >> l & 1u ? 0 : all[i])) break;
      }
      CHECK(i == info.vertices * info.weight_stride);
    }
    free(all);
  }
  frame.laplace_steps = 0, frame.inactive_layers = 0xffffffffu; /* those that the asset lacks say nothing */
  CHECK_OK(furrow_instance_frame(instance, &frame, &report, &status));
  if (info.morphs > 0) {
    morphs[info.morphs - 1] = NAN;
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_frame(instance, &frame, &report, &status));
  }
  free(palette), free(morphs);
  furrow_instance_release(instance);
  furrow_asset_release(asset);
}

/* Morph weights drive regions and carry occlusion along. */
static void testMorphs(FurrowContext* context, File face) {
  FurrowStatus status;
  FurrowAsset* asset = loadAsset(context, face, 0, 0);
  FurrowAssetInfo info = {.size = sizeof info};
  FurrowInstance* instance = makeInstance(asset, 0);
  FurrowFrame frame;
  float *palette, *weights, *rest, *out, *delta;
  const float** deltas;
  int16_t* still;
  uint32_t i, moved = 0;
  FurrowMorphInfo morph = {.size = sizeof morph};

  CHECK_OK(furrow_asset_info(asset, &info, &status));
  CHECK(info.morphs > 0);
  palette = makePalette(info.palette, 1.0f);
  weights = calloc(info.morphs, sizeof(float));
  frame = paletteFrame(palette, &info);
  frame.morph_weights = weights, frame.morph_count = info.morphs;
  CHECK_OK(furrow_instance_frame(instance, &frame, NULL, &status));
  still = copyWeights(instance, &info);
  weights[0] = 1.0f;
  CHECK_OK(furrow_instance_frame(instance, &frame, NULL, &status));
  for (i = 0; i < info.vertices * info.weight_stride; ++i)
    moved += furrow_instance_weights(instance)[i] != still[i];
  CHECK(moved > 100);
  if (info.drivers > 0) { /* the drivers add what they say */
    FurrowDriverInfo driver = {.size = sizeof driver};
    CHECK_OK(furrow_driver_info(asset, 0, &driver, &status));
    weights[0] = 0.0f, weights[driver.morph] = 0.125f;
    CHECK_OK(furrow_instance_frame(instance, &frame, NULL, &status));
    free(still);
    still = copyWeights(instance, &info);
    frame.ignore_drivers = 0;
    CHECK_OK(furrow_instance_frame(instance, &frame, NULL, &status));
    CHECK(!sameWeights(instance, still, &info));
    weights[driver.morph] = 0.0f, weights[0] = 1.0f;
  }
  frame.morph_count = info.morphs + 1;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_frame(instance, &frame, NULL, &status));
  frame.morph_count = info.morphs;

  CHECK_OK(furrow_morph_info(asset, 0, &morph, &status));
  rest = malloc(info.vertices * sizeof(float));
  out = malloc(info.vertices * sizeof(float));
  delta = malloc(morph.vertices * sizeof(float));
  deltas = calloc(info.morphs, sizeof(float*));
  for (i = 0; i < info.vertices; ++i) rest[i] = 0.75f, out[i] = -1.0f;
  for (i = 0; i < morph.vertices; ++i) delta[i] = -0.5f;
  deltas[0] = delta;
  weights[0] = 0.5f;
  frame.occlusion = out, frame.occlusion_rest = rest, frame.occlusion_deltas = deltas;
  CHECK_OK(furrow_instance_frame(instance, &frame, NULL, &status));
  for (i = 0; i < morph.vertices; ++i) out[morph.moved[i]] += 0.25f;
  for (i = 0; i < info.vertices; ++i) CHECK(out[i] == 0.75f);
  frame.occlusion_rest = NULL;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_frame(instance, &frame, NULL, &status));

  free(palette), free(weights), free(still), free(rest), free(out), free(delta), free(deltas);
  furrow_instance_release(instance);
  furrow_asset_release(asset);
}

/* Weights of all vertices whose triangles were posed whole; that is, of nearly all. */
static int sameWherePosed(const FurrowInstance* instance, const int16_t* expected,
                          const FurrowAssetInfo* info, const FurrowGeometry* geometry,
                          const unsigned char* posed) {
  unsigned char* tainted = calloc(info->points, 1);
  const int16_t* w = furrow_instance_weights(instance);
  uint32_t i, c, l, left_out = 0;
  int same = 1;
  for (i = 0; i < info->points; ++i) tainted[i] = !posed[i];
  for (i = 0; i < 3 * info->triangles; i += 3)
    for (c = 0; c < 9; ++c)
      if (!posed[geometry->vertex_point[geometry->indices[i + c / 3]]])
        tainted[geometry->vertex_point[geometry->indices[i + c % 3]]] = 1;
  for (i = 0; i < info->vertices; ++i) {
    left_out += tainted[geometry->vertex_point[i]];
    for (l = 0; l < info->layers && !tainted[geometry->vertex_point[i]]; ++l)
      same = same && w[i * info->weight_stride + l] == expected[i * info->weight_stride + l];
  }
  free(tainted);
  return same && left_out < info->vertices / 50;
}

static void markPosed(const FurrowBinding* binding, uint32_t vertices, const FurrowAssetInfo* info,
                      unsigned char* posed) {
  uint32_t v;
  for (v = 0; v < vertices; ++v)
    if (furrow_binding_points(binding)[v] < info->points) posed[furrow_binding_points(binding)[v]] = 1;
}

/* The engine's vertices: the asset's, backwards and in halves of two meshes. */
static void testBinding(FurrowContext* context, Host* host, File file) {
  FurrowStatus status;
  FurrowAsset *asset = loadAsset(context, file, 0, 0), *other = loadAsset(context, file, 0, 0);
  FurrowAssetInfo info = {.size = sizeof info};
  FurrowGeometry geometry = {.size = sizeof geometry};
  FurrowPartInfo part = {.size = sizeof part};
  FurrowInstance* instance = makeInstance(asset, FURROW_KEEP_POSITIONS);
  FurrowBinding *binding = NULL, *mine = NULL;
  FurrowBindDesc desc = {.size = sizeof desc};
  FurrowBindCounts counts = {.size = sizeof counts};
  FurrowReadDesc read = {.size = sizeof read};
  FurrowFrame frame, meshes = {.size = sizeof meshes};
  FurrowPosedMesh mesh;
  float *positions, *palette, *out, *posed;
  uint32_t* indices;
  unsigned char* covered;
  int16_t* expected;
  uint32_t i, v;

  CHECK_OK(furrow_asset_info(asset, &info, &status));
  CHECK_OK(furrow_asset_geometry(asset, &geometry, &status));
  CHECK_OK(furrow_part_info(asset, 0, &part, &status));
  positions = malloc(12 * (size_t)info.vertices);
  indices = malloc(12 * (size_t)info.triangles);
  for (v = 0; v < info.vertices; ++v)
    memcpy(positions + 3 * v, geometry.positions + 3 * (info.vertices - 1 - v), 12);
  for (i = 0; i < 3 * info.triangles; ++i) indices[i] = info.vertices - 1 - geometry.indices[i];
  desc.positions.data = positions, desc.positions.bytes = 12 * (size_t)info.vertices;
  desc.vertices = info.vertices, desc.indices = indices, desc.index_count = 3 * (size_t)info.triangles;
  memcpy(desc.to_root, part.rest, sizeof desc.to_root);
  desc.tolerance = 2.0f * info.position_error;
  CHECK_OK(furrow_binding_create(asset, &desc, &binding, &counts, &status));
  CHECK(counts.matched > 0.99 * info.vertices &&
        counts.matched + counts.ambiguous + counts.unmatched == info.vertices);
  for (v = 0; v < info.vertices; ++v) {
    const uint32_t point = furrow_binding_points(binding)[v];
    CHECK(point >= FURROW_NONE - 1 || point == geometry.vertex_point[info.vertices - 1 - v]);
  }

  palette = makePalette(info.palette, 0.7f);
  frame = paletteFrame(palette, &info);
  CHECK_OK(furrow_instance_frame(instance, &frame, NULL, &status));
  expected = copyWeights(instance, &info);
  out = calloc(info.vertices, sizeof(float) * (info.layers + 1));
  read.binding = binding, read.format = FURROW_WEIGHTS_FLOAT, read.out = out;
  read.stride = sizeof(float) * (info.layers + 1), read.bytes = read.stride * info.vertices;
  CHECK_OK(furrow_instance_read(instance, &read, &status));
  for (v = 0; v < info.vertices; ++v)
    for (i = 0; i < info.layers; ++i) {
      const uint32_t point = furrow_binding_points(binding)[v];
      const float w =
          point >= FURROW_NONE - 1
              ? 0.0f
              : (float)expected[(size_t)geometry.point_vertex[point] * info.weight_stride + i] / 32767.0f;
      CHECK(fabsf(out[v * (info.layers + 1) + i] - w) < 1e-6f);
      CHECK(out[v * (info.layers + 1) + info.layers] == 0.0f); /* between the strides nothing is written */
    }
  {
    int8_t* bytes = malloc(info.vertices);
    read.binding = NULL, read.format = FURROW_WEIGHTS_SNORM8, read.layer_begin = info.layers - 1,
    read.layer_count = 1;
    read.out = bytes, read.stride = 0, read.bytes = info.vertices;
    CHECK_OK(furrow_instance_read(instance, &read, &status));
    for (v = 0; v < info.vertices; ++v)
      CHECK(bytes[v] == lround(expected[v * info.weight_stride + info.layers - 1] / 32767.0 * 127.0));
    read.bytes = info.vertices - 1;
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_read(instance, &read, &status));
    read.bytes = info.vertices, read.layer_count = 2;
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_read(instance, &read, &status));
    read.layer_count = 1, read.format = 9;
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_read(instance, &read, &status));
    read.format = 0, read.out = NULL;
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_read(instance, &read, &status));
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_read(instance, NULL, &status));
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_read(NULL, &read, &status));
    free(bytes);
  }

  /* The pose in the engine's order, as floats; the points that were bound weigh the same. */
  posed = malloc(12 * (size_t)info.vertices);
  for (v = 0; v < info.vertices; ++v)
    memcpy(posed + 3 * v,
           furrow_instance_positions(instance) +
               3 * (size_t)geometry.point_vertex[geometry.vertex_point[info.vertices - 1 - v]],
           12);
  memset(&mesh, 0, sizeof mesh);
  mesh.from.data = posed, mesh.from.bytes = 12 * (size_t)info.vertices, mesh.binding = binding;
  meshes.meshes = &mesh, meshes.mesh_count = 1;
  CHECK_OK(furrow_instance_frame(instance, &meshes, NULL, &status));
  covered = calloc(info.points, 1);
  markPosed(binding, info.vertices, &info, covered);
  CHECK(sameWherePosed(instance, expected, &info, &geometry, covered));
  {
    FurrowPosedMesh two[2];
    two[0] = mesh, two[1] = mesh;
    meshes.meshes = two, meshes.mesh_count = 2;
    CHECK_OK(furrow_instance_frame(instance, &meshes, NULL, &status));
    CHECK(sameWherePosed(instance, expected, &info, &geometry, covered));
    two[1].binding = NULL;
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_frame(instance, &meshes, NULL, &status));
    meshes.meshes = &mesh, meshes.mesh_count = 1;
  }
  /* Two meshes, the lower and the upper half of the vertices; triangles that cross belong to neither. */
  {
    FurrowPosedMesh two[2];
    FurrowBinding* half[2];
    FurrowBindDesc part_desc = desc;
    uint32_t* corners = malloc(12 * (size_t)info.triangles);
    uint32_t h;
    memset(covered, 0, info.points);
    for (h = 0; h < 2; ++h) {
      const uint32_t begin = h ? info.vertices / 2 : 0, end = h ? info.vertices : info.vertices / 2;
      size_t count = 0;
      for (i = 0; i < 3 * info.triangles; i += 3)
        if (indices[i] >= begin && indices[i] < end && indices[i + 1] >= begin && indices[i + 1] < end &&
            indices[i + 2] >= begin && indices[i + 2] < end)
          for (v = 0; v < 3; ++v) corners[count++] = indices[i + v] - begin;
      part_desc.positions.data = positions + 3 * (size_t)begin,
      part_desc.positions.bytes = 12 * (size_t)(end - begin);
      part_desc.vertices = end - begin, part_desc.indices = corners, part_desc.index_count = count;
      CHECK_OK(furrow_binding_create(asset, &part_desc, &half[h], NULL, &status));
      markPosed(half[h], end - begin, &info, covered);
      two[h] = mesh;
      two[h].from.data = posed + 3 * (size_t)begin, two[h].from.bytes = 12 * (size_t)(end - begin);
      two[h].binding = half[h];
    }
    meshes.meshes = two, meshes.mesh_count = 2;
    CHECK_OK(furrow_instance_frame(instance, &meshes, NULL, &status));
    CHECK(sameWherePosed(instance, expected, &info, &geometry, covered));
    meshes.mesh_count = 1; /* half of the points are at rest now */
    CHECK_OK(furrow_instance_frame(instance, &meshes, NULL, &status));
    CHECK(!sameWherePosed(instance, expected, &info, &geometry, covered));
    furrow_binding_release(half[0]), furrow_binding_release(half[1]);
    free(corners);
    meshes.meshes = &mesh;
  }
  mesh.from.bytes -= 1;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_frame(instance, &meshes, NULL, &status));
  mesh.from.bytes += 1, mesh.from.format = 5;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_frame(instance, &meshes, NULL, &status));
  mesh.from.format = 0, mesh.from.data = NULL;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_frame(instance, &meshes, NULL, &status));
  mesh.from.data = posed;

  /* Nothing of the mesh: no error, and the counts say it. */
  for (v = 0; v < 3 * info.vertices; ++v) positions[v] += 1000.0f;
  CHECK_OK(furrow_binding_create(asset, &desc, &mine, &counts, &status));
  CHECK(counts.matched == 0 && counts.unmatched == info.vertices && counts.missing == info.points);
  mesh.binding = mine; /* no point is posed: as at rest */
  CHECK_OK(furrow_instance_frame(instance, &meshes, NULL, &status));
  furrow_binding_release(mine);
  mesh.binding = binding;

  CHECK_OK(furrow_binding_create(other, &desc, &mine, NULL, &status));
  mesh.binding = mine;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_frame(instance, &meshes, NULL, &status));
  furrow_binding_release(mine);
  indices[0] = info.vertices;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_binding_create(asset, &desc, &mine, &counts, &status));
  CHECK(mine == NULL);
  indices[0] = 0, desc.vertices = info.vertices + 1;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_binding_create(asset, &desc, &mine, &counts, &status));
  {
    const long allocations = host->allocations; /* what cannot be is refused before memory is asked for */
    desc.vertices = 0xffffffffu;
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_binding_create(asset, &desc, &mine, &counts, &status));
    desc.vertices = info.vertices, desc.positions.offset = (size_t)-8;
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_binding_create(asset, &desc, &mine, &counts, &status));
    desc.positions.offset = 0, desc.positions.stride = (size_t)-12;
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_binding_create(asset, &desc, &mine, &counts, &status));
    desc.positions.stride = 0;
    CHECK(host->allocations == allocations);
  }
  desc.positions.stride = 4;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_binding_create(asset, &desc, &mine, &counts, &status));
  desc.positions.stride = 0, desc.index_count -= 1;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_binding_create(asset, &desc, &mine, &counts, &status));
  desc.index_count += 1, desc.to_root[3] += NAN;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_binding_create(asset, &desc, &mine, &counts, &status));
  memcpy(desc.to_root, part.rest, sizeof desc.to_root), counts.size = 0;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_binding_create(asset, &desc, &mine, &counts, &status));
  counts.size = sizeof counts, desc.tolerance = -1.0f;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_binding_create(asset, &desc, &mine, &counts, &status));
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_binding_create(asset, NULL, &mine, &counts, &status));
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_binding_create(NULL, &desc, &mine, &counts, &status));
  desc.tolerance = 0.0f, host->fail_after = 1;
  CHECK_REFUSED(FURROW_OUT_OF_MEMORY, furrow_binding_create(asset, &desc, &mine, &counts, &status));
  host->fail_after = -1;
  furrow_binding_release(NULL);
  CHECK(furrow_binding_points(NULL) == NULL);

  free(positions), free(indices), free(palette), free(expected), free(out), free(posed), free(covered);
  furrow_binding_release(binding);
  furrow_instance_release(instance);
  furrow_asset_release(asset), furrow_asset_release(other);
}

/* Memory of the host's, and another asset under a running instance. */
static void testMemoryAndReload(FurrowContext* context, Host* host, File face, File sleeve) {
  FurrowStatus status;
  FurrowAsset *a = loadAsset(context, face, 0, 0), *again = loadAsset(context, face, 0, 0),
              *b = loadAsset(context, sleeve, 0, 0);
  FurrowAssetInfo info = {.size = sizeof info}, other = {.size = sizeof other};
  FurrowInstanceDesc desc = {.size = sizeof desc};
  FurrowInstance* instance = NULL;
  FurrowFrame frame;
  FurrowEase eases[FURROW_MAX_LAYERS];
  float regions[FURROW_MAX_LAYERS];
  char *memory, *aligned;
  float* palette;
  int16_t* expected;
  size_t bytes, more, l;
  long before;

  CHECK_OK(furrow_asset_info(a, &info, &status));
  CHECK_OK(furrow_asset_info(b, &other, &status));
  bytes = furrow_instance_memory(a, NULL);
  CHECK(bytes >= 2u * info.vertices * info.weight_stride && bytes < 4u * 64u * info.vertices + 400000);
  desc.features = FURROW_USE_EASE;
  more = furrow_instance_memory(a, &desc);
  CHECK(more >= bytes + 4u * info.vertices * info.layers);
  memory = malloc(more + 64);
  aligned = memory + (64 - (size_t)memory % 64) % 64;
  desc.memory = aligned, desc.memory_bytes = more;
  before = host->live_bytes;
  CHECK_OK(furrow_instance_create(a, &desc, &instance, &status));
  CHECK(host->live_bytes == before && (char*)instance == aligned && furrow_instance_asset(instance) == a);
  furrow_instance_release(instance);
  desc.memory_bytes = more - 1;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_create(a, &desc, &instance, &status));
  desc.memory_bytes = more, desc.memory = aligned + 4;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_create(a, &desc, &instance, &status));
  desc.memory = NULL, desc.features = 1u << 20;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_create(a, &desc, &instance, &status));
  CHECK(furrow_instance_memory(a, &desc) == 0 && furrow_instance_memory(NULL, NULL) == 0);
  desc.features = FURROW_USE_EASE;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_create(NULL, &desc, &instance, &status));
  host->fail_after = 0;
  CHECK_REFUSED(FURROW_OUT_OF_MEMORY, furrow_instance_create(a, &desc, &instance, &status));
  host->fail_after = -1;

  /* Eased weights live on in the same asset loaded anew. */
  desc.memory = aligned;
  CHECK_OK(furrow_instance_create(a, &desc, &instance, &status));
  palette = makePalette(info.palette > other.palette ? info.palette : other.palette, 1.0f);
  frame = paletteFrame(palette, &info);
  for (l = 0; l < FURROW_MAX_LAYERS; ++l) eases[l].attack = eases[l].release = 1.0f, regions[l] = 0.5f;
  frame.eases = eases, frame.region_weights = regions;
  CHECK_OK(furrow_instance_frame(instance, &frame, NULL, &status));
  expected = copyWeights(instance, &info);
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_reload(&instance, again, aligned, more, &status));
  CHECK((char*)instance == aligned && furrow_instance_asset(instance) == a);
  for (l = 0; l < FURROW_MAX_LAYERS; ++l) regions[l] = 0.0f;
  CHECK_OK(
      furrow_instance_reload(&instance, again, NULL, 0, &status)); /* no time passes: the weights stand */
  CHECK(furrow_instance_asset(instance) == again);
  CHECK_OK(furrow_instance_frame(instance, &frame, NULL, &status));
  CHECK(sameWeights(instance, expected, &info));
  /* Another asset: it begins anew. */
  CHECK_OK(furrow_instance_reload(&instance, b, NULL, 0, &status));
  frame = paletteFrame(palette, &other);
  frame.eases = eases;
  CHECK_OK(furrow_instance_frame(instance, &frame, NULL, &status));
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_reload(NULL, b, NULL, 0, &status));
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_reload(&instance, NULL, NULL, 0, &status));
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_reload(&instance, a, aligned, 10, &status));
  CHECK(furrow_instance_asset(instance) == b);
  CHECK_OK(furrow_instance_frame(instance, &frame, NULL, &status));

  free(memory), free(palette), free(expected);
  furrow_instance_release(instance);
  furrow_asset_release(a), furrow_asset_release(again), furrow_asset_release(b);
}

/* In a frame of every third call, with time going by: a reload between calls changes nothing in the same
   asset. Layers of the same names on another mesh begin anew. */
static void testReloadInTime(FurrowContext* context, File brow, File cuff) {
  FurrowStatus status;
  FurrowAsset *a = loadAsset(context, brow, 0, 0), *again = loadAsset(context, brow, 0, 0),
              *other = loadAsset(context, cuff, 0, 0);
  FurrowInstance *stays = makeInstance(a, FURROW_USE_EASE), *goes = makeInstance(a, FURROW_USE_EASE);
  FurrowAssetInfo info = {.size = sizeof info}, fewer = {.size = sizeof fewer};
  FurrowFrameReport one = {.size = sizeof one}, two = {.size = sizeof two};
  FurrowFrame frame;
  FurrowEase eases[FURROW_MAX_LAYERS];
  float regions[FURROW_MAX_LAYERS], *palette;
  int16_t* expected;
  uint32_t call, l, v;
  CHECK_OK(furrow_asset_info(a, &info, &status));
  CHECK_OK(furrow_asset_info(other, &fewer, &status));
  CHECK(info.palette == fewer.palette && fewer.vertices < info.vertices && info.layers == fewer.layers);
  palette = makePalette(info.palette, 1.0f);
  frame = paletteFrame(palette, &info);
  for (l = 0; l < FURROW_MAX_LAYERS; ++l) eases[l].attack = eases[l].release = 1.0f, regions[l] = 0.0f;
  frame.eases = eases, frame.region_weights = regions, frame.every = 3, frame.seconds = 0.25f;
  for (call = 0; call < 10; ++call) {
    CHECK_OK(furrow_instance_frame(stays, &frame, &one, &status));
    CHECK_OK(furrow_instance_frame(goes, &frame, &two, &status));
    CHECK(one.computed == two.computed && one.computed == (call % 3 == 0));
    expected = copyWeights(stays, &info);
    if (two.computed) CHECK(sameWeights(goes, expected, &info));
    free(expected);
    if (call % 3 == 1) CHECK_OK(furrow_instance_reload(&goes, call == 4 ? a : again, NULL, 0, &status));
    for (l = 0; l < FURROW_MAX_LAYERS; ++l) regions[l] = 0.75f;
  }
  CHECK(furrow_instance_weights(goes)[3] > 16000 &&
        furrow_instance_weights(goes)[3] < 24000); /* on the way */

  CHECK_OK(furrow_instance_reload(&goes, other, NULL, 0, &status));
  for (l = 0; l < FURROW_MAX_LAYERS; ++l) regions[l] = 0.0f;
  frame.every = 0, frame.seconds = 0.0f;
  CHECK_OK(furrow_instance_frame(goes, &frame, NULL, &status));
  for (v = 0; v < fewer.vertices; ++v) CHECK(furrow_instance_weights(goes)[v * fewer.weight_stride + 3] == 0);
  free(palette);
  furrow_instance_release(stays), furrow_instance_release(goes);
  furrow_asset_release(a), furrow_asset_release(again), furrow_asset_release(other);
}

/* A host whose job system runs ranges in any order gets the same bits; one that breaks its word is told. */
static void testJobs(Host* host, FurrowContext* context, File file) {
  FurrowStatus status;
  FurrowContext *single = NULL, *wrong = NULL, *plain = NULL;
  FurrowContextDesc desc = hostDesc(host);
  FurrowAsset* assets[4];
  FurrowInstance* instances[4];
  FurrowAssetInfo info = {.size = sizeof info};
  FurrowFrame frame;
  float* palette;
  int16_t* expected;
  int i;

  desc.parallel_for = NULL;
  CHECK_OK(furrow_context_create(&desc, &single, &status));
  desc.parallel_for = hostWrong;
  CHECK_OK(furrow_context_create(&desc, &wrong, &status));
  desc.parallel_for = NULL, desc.simd = FURROW_SIMD_PORTABLE;
  CHECK_OK(furrow_context_create(&desc, &plain, &status));
  CHECK(strcmp(furrow_context_simd(plain), "portable") == 0);
  assets[0] = loadAsset(single, file, 0, 0), assets[1] = loadAsset(context, file, 0, 0);
  assets[2] = loadAsset(wrong, file, 0, 0), assets[3] = loadAsset(plain, file, 0, 0);
  for (i = 0; i < 4; ++i) instances[i] = makeInstance(assets[i], FURROW_KEEP_NORMALS | FURROW_USE_LAPLACE);
  CHECK_OK(furrow_asset_info(assets[0], &info, &status));
  palette = makePalette(info.palette, 0.8f);
  frame = paletteFrame(palette, &info);
  for (i = 0; i < 2; ++i) {
    frame.laplace_steps = (uint32_t)(2 * i);
    CHECK_OK(furrow_instance_frame(instances[0], &frame, NULL, &status));
    expected = copyWeights(instances[0], &info);
    for (host->reversed = 0; host->reversed < 2; ++host->reversed) {
      host->calls = 0;
      CHECK_OK(furrow_instance_frame(instances[1], &frame, NULL, &status));
      CHECK(host->calls >= 2 && sameWeights(instances[1], expected, &info));
    }
    CHECK_OK(furrow_instance_frame(instances[3], &frame, NULL, &status));
    CHECK(sameWeights(instances[3], expected, &info));
    free(expected);
  }
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_instance_frame(instances[2], &frame, NULL, &status));
  for (i = 0; i < 4; ++i) furrow_instance_release(instances[i]), furrow_asset_release(assets[i]);
  furrow_context_release(single), furrow_context_release(wrong), furrow_context_release(plain);
  free(palette);
}

/* Every form of the frame as a plan that can be recorded. */
static const float* coefficientsOf(const FurrowPlan* plan, size_t* count) {
  FurrowStatus status;
  FurrowBufferInfo buffer;
  uint32_t b = 0;
  do {
    memset(&buffer, 0, sizeof buffer);
    buffer.size = sizeof buffer;
    CHECK_OK(furrow_plan_buffer(plan, b++, &buffer, &status));
  } while (status.code == FURROW_OK && strcmp(buffer.name, "furrow coefficients") != 0);
  *count = buffer.bytes / sizeof(float);
  return buffer.initial;
}

/* Laplacian steps are dispatches of their own; a recaptured rest is measured from, whatever becomes of the
   instance that has it. */
static void testPlanOptions(FurrowContext* context, File file, FurrowAsset* asset, FurrowFrame frame) {
  FurrowStatus status;
  FurrowPlanDesc desc = {.size = sizeof desc};
  FurrowPlanInfo about = {.size = sizeof about};
  FurrowAssetInfo info = {.size = sizeof info};
  FurrowPlan *plain = NULL, *plan = NULL;
  FurrowInstance* instance = makeInstance(asset, FURROW_USE_RECAPTURE);
  FurrowAsset* other;
  const FurrowEase at_once[FURROW_MAX_LAYERS] = {{0.0f, 0.0f}};
  float *palette, constants[1024];
  const float *before, *after;
  uint32_t i, measured = 0, cleared[2] = {0, 0};
  size_t count, same;
  CHECK_OK(furrow_asset_info(asset, &info, &status));

  desc.form = FURROW_FORM_STAGED;
  CHECK_OK(furrow_plan_create(asset, &desc, &plain, &status));
  CHECK_OK(furrow_plan_info(plain, &about, &status));
  i = about.items;
  desc.form = FURROW_FORM_CLUSTERED, desc.laplace_steps = 3;
  CHECK_OK(furrow_plan_create(asset, &desc, &plan, &status));
  CHECK_OK(furrow_plan_info(plan, &about, &status));
  CHECK(about.form == FURROW_FORM_STAGED && about.items == i + 2 * 3);
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT,
                furrow_plan_write(plan, FURROW_BUFFER_FRAME, &frame, constants, sizeof constants, &status));
  frame.laplace_steps = 3;
  CHECK_OK(furrow_plan_write(plan, FURROW_BUFFER_FRAME, &frame, constants, sizeof constants, &status));
  frame.laplace_rate = 2.0f;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT,
                furrow_plan_write(plan, FURROW_BUFFER_FRAME, &frame, constants, sizeof constants, &status));
  frame.laplace_rate = 0.0f, frame.laplace_steps = 0;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT,
                furrow_plan_write(plan, FURROW_BUFFER_FRAME, &frame, constants, sizeof constants, &status));
  frame.laplace_steps = 3, frame.eases = at_once;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT,
                furrow_plan_write(plan, FURROW_BUFFER_FRAME, &frame, constants, sizeof constants, &status));
  frame.laplace_steps = 0, frame.eases = NULL;
  furrow_plan_release(plan);
  desc.form = FURROW_FORM_RASTER, desc.laplace_steps = 0;
  CHECK_OK(furrow_plan_create(asset, &desc, &plan, &status));
  CHECK_OK(furrow_plan_info(plan, &about, &status));
  CHECK(about.sums_images == 1);
  i = about.items;
  furrow_plan_release(plan);
  desc.laplace_steps = 3;
  CHECK_OK(furrow_plan_create(asset, &desc, &plan, &status));
  CHECK_OK(furrow_plan_info(plan, &about, &status));
  CHECK(about.form == FURROW_FORM_RASTER && about.sums_images == 2);
  CHECK(about.items == i + 3 * (2 * about.sums_slices + 1));
  for (i = 0; i < about.items; ++i) { /* from image to image, at last to the first */
    FurrowItemInfo item = {.size = sizeof item};
    CHECK_OK(furrow_plan_item(plan, i, &item, &status));
    cleared[item.image] += item.kind == FURROW_ITEM_CLEAR;
  }
  CHECK(cleared[0] == 2 * about.sums_slices && cleared[1] == 2 * about.sums_slices);
  furrow_plan_release(plan);
  desc.form = FURROW_FORM_STAGED, desc.laplace_steps = 100000;
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_plan_create(asset, &desc, &plan, &status));
  desc.laplace_steps = 0;

  /* Dual quaternions: a turn, 0 for no shift, what is not a turn; another shift changes its four numbers
   * alone. */
  desc.skinning = FURROW_SKINNING_DUAL_QUATERNION;
  CHECK_OK(furrow_plan_create(asset, &desc, &plan, &status));
  {
    const size_t bytes = 17 * sizeof(float) * info.palette;
    float *motions = malloc(bytes), *shifted = malloc(bytes), *moved = makePalette(info.palette, 1.0f);
    FurrowFrame turned = frame;
    turned.palette = moved;
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT,
                  furrow_plan_write(plan, FURROW_BUFFER_PALETTE, &turned, motions, bytes - 1, &status));
    CHECK_OK(furrow_plan_write(plan, FURROW_BUFFER_PALETTE, &turned, motions, bytes, &status));
    moved[3] = 2.0f;
    CHECK_OK(furrow_plan_write(plan, FURROW_BUFFER_PALETTE, &turned, shifted, bytes, &status));
    CHECK(memcmp(motions, shifted, 4 * sizeof(float)) == 0 && memcmp(motions, shifted, bytes) != 0);
    CHECK(memcmp(motions + 17, shifted + 17, bytes - 17 * sizeof(float)) == 0);
    CHECK(fabsf(fabsf(motions[0]) + fabsf(motions[1]) + fabsf(motions[2]) + fabsf(motions[3]) - 1.0f) <
          1e-5f);
    free(motions), free(shifted), free(moved);
  }
  furrow_plan_release(plan);
  desc.skinning = FURROW_SKINNING_LINEAR;

  /* Twice as large, half as much a unit of length. */
  palette = makePalette(info.palette, 2.0f);
  for (i = 0; i < info.palette; ++i) palette[12 * i + 5] = palette[12 * i + 10] = 2.0f;
  frame.palette = palette;
  desc.rest = instance; /* without a rest of its own, the asset's */
  CHECK_OK(furrow_plan_create(asset, &desc, &plan, &status));
  before = coefficientsOf(plain, &count), after = coefficientsOf(plan, &same);
  CHECK(count == same && memcmp(before, after, count * sizeof(float)) == 0);
  furrow_plan_release(plan);
  frame.morph_weights = NULL;
  CHECK_OK(furrow_instance_recapture(instance, &frame, &status));
  CHECK_OK(furrow_plan_create(asset, &desc, &plan, &status));
  furrow_instance_release(instance);
  after = coefficientsOf(plan, &same);
  CHECK(count == same);
  for (i = 0; i < count; ++i) {
    if (before[i] == 0.0f || after[i] == 0.0f) continue; /* excluded, or degenerate now */
    ++measured;
    if (fabsf(after[i] / before[i] - 0.5f) > 1e-3f) break;
  }
  CHECK(i == count && measured > count / 4);
  CHECK_OK(furrow_plan_write(plan, FURROW_BUFFER_FRAME, &frame, constants, sizeof constants, &status));
  furrow_plan_release(plan), furrow_plan_release(plain);

  other = loadAsset(context, file, 0, 0);
  desc.rest = instance = makeInstance(other, FURROW_USE_RECAPTURE);
  CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_plan_create(asset, &desc, &plan, &status));
  furrow_instance_release(instance), furrow_asset_release(other);
  free(palette);
}

static void testPlan(FurrowContext* context, File file) {
  FurrowStatus status;
  FurrowAsset* asset = loadAsset(context, file, 0, 0);
  FurrowAssetInfo info = {.size = sizeof info};
  FurrowFrame frame;
  FurrowPlan* plan = NULL;
  float *palette, *weights;
  uint32_t form, i, b;

  CHECK_OK(furrow_asset_info(asset, &info, &status));
  palette = makePalette(info.palette, 0.7f);
  weights = calloc(info.morphs + 1, sizeof(float));
  weights[0] = 0.5f;
  frame = paletteFrame(palette, &info);
  frame.morph_weights = weights, frame.morph_count = info.morphs;
  for (form = FURROW_FORM_CLUSTERED; form <= FURROW_FORM_RASTER; ++form) {
    FurrowPlanDesc desc = {.size = sizeof desc};
    FurrowPlanInfo about = {.size = sizeof about};
    uint64_t instance_bytes = 0, asset_bytes = 0;
    int dispatches = 0, draws = 0, barriers = 0, weights_found = 0;
    desc.form = form, desc.normals = 1;
    if (form == FURROW_FORM_CLUSTERED) desc.instances = 10;
    desc.ease = form != FURROW_FORM_STAGED;
    CHECK_OK(furrow_plan_create(asset, &desc, &plan, &status));
    CHECK_OK(furrow_plan_info(plan, &about, &status));
    CHECK(about.form == form && about.instances == (form == FURROW_FORM_CLUSTERED ? 10u : 1u));
    CHECK((about.sums_slices > 0) == (form == FURROW_FORM_RASTER));
    for (i = 0; i < about.buffers; ++i) {
      FurrowBufferInfo buffer = {.size = sizeof buffer};
      unsigned char* out;
      CHECK_OK(furrow_plan_buffer(plan, i, &buffer, &status));
      if (buffer.bytes == 0) continue;
      CHECK(buffer.name[0] != 0 && buffer.bytes % 4 == 0);
      CHECK(!buffer.per_instance || buffer.bytes == about.instances * buffer.instance_bytes);
      CHECK(!buffer.initial || !buffer.per_instance || buffer.role == FURROW_BUFFER_INSTANCES);
      if (buffer.per_instance)
        instance_bytes += buffer.instance_bytes;
      else
        asset_bytes += buffer.bytes;
      if (buffer.role == FURROW_BUFFER_WEIGHTS) {
        CHECK(buffer.instance_bytes == 2u * info.vertices * info.weight_stride);
        weights_found = 1;
      }
      if (buffer.role < FURROW_BUFFER_FRAME || buffer.role > FURROW_BUFFER_MORPH_WEIGHTS) continue;
      out = malloc(buffer.instance_bytes + 4);
      memset(out, 0xcd, buffer.instance_bytes + 4);
      CHECK_OK(furrow_plan_write(plan, buffer.role, &frame, out, buffer.instance_bytes, &status));
      CHECK(out[buffer.instance_bytes] == 0xcd);
      if (buffer.role == FURROW_BUFFER_PALETTE) CHECK(memcmp(out, palette, 48 * (size_t)info.palette) == 0);
      if (buffer.role == FURROW_BUFFER_MORPH_WEIGHTS)
        CHECK(((float*)(void*)out)[0] != 0.0f && ((float*)(void*)out)[2] == 0.0f);
      CHECK_REFUSED(FURROW_INVALID_ARGUMENT,
                    furrow_plan_write(plan, buffer.role, &frame, out, buffer.instance_bytes - 1, &status));
      CHECK_REFUSED(FURROW_INVALID_ARGUMENT,
                    furrow_plan_write(plan, buffer.role, &frame, NULL, buffer.instance_bytes, &status));
      CHECK_REFUSED(FURROW_INVALID_ARGUMENT,
                    furrow_plan_write(plan, buffer.role, NULL, out, buffer.instance_bytes, &status));
      free(out);
    }
    CHECK(weights_found && instance_bytes == about.instance_bytes && asset_bytes == about.asset_bytes);
    for (i = 0; i < about.items; ++i) {
      FurrowItemInfo item = {.size = sizeof item};
      CHECK_OK(furrow_plan_item(plan, i, &item, &status));
      dispatches += item.kind == FURROW_ITEM_DISPATCH, draws += item.kind == FURROW_ITEM_DRAW;
      barriers += item.kind == FURROW_ITEM_BARRIER;
      if (item.kind == FURROW_ITEM_DISPATCH || item.kind == FURROW_ITEM_DRAW) {
        FurrowShaderSource source = {.size = sizeof source};
        CHECK(item.label[0] != 0 && item.bindings > 0);
        CHECK_OK(furrow_shader_source(item.shader, &source, &status));
        if (item.kind == FURROW_ITEM_DISPATCH)
          CHECK(strstr(source.compute, "#version 430") && item.groups[0] > 0 && item.groups[1] > 0 &&
                source.hlsl && source.spirv_bytes % 4 == 0 &&
                (source.spirv_bytes == 0 || source.spirv[0] == 0x07230203));
        else
          CHECK(strstr(source.vertex, "#version 330") && item.count > 0);
      }
      for (b = 0; b < item.bindings; ++b) {
        FurrowBindingInfo binding = {.size = sizeof binding};
        FurrowBufferInfo buffer = {.size = sizeof buffer};
        CHECK_OK(furrow_plan_binding(plan, i, b, &binding, &status));
        CHECK(binding.access <= FURROW_ACCESS_CAPTURE &&
              (binding.buffer < about.buffers) == (binding.access != FURROW_ACCESS_SUMS));
        if (binding.access != FURROW_ACCESS_SUMS)
          CHECK_OK(furrow_plan_buffer(plan, binding.buffer, &buffer, &status));
      }
      {
        FurrowBindingInfo binding = {.size = sizeof binding};
        CHECK_REFUSED(FURROW_INVALID_ARGUMENT,
                      furrow_plan_binding(plan, i, item.bindings, &binding, &status));
      }
    }
    CHECK(form == FURROW_FORM_RASTER ? draws > 0 && dispatches == 0
                                     : draws == 0 && dispatches == (form == FURROW_FORM_STAGED ? 4 : 1));
    CHECK(barriers > 0);
    {
      FurrowItemInfo item = {.size = sizeof item};
      FurrowBufferInfo buffer = {.size = sizeof buffer};
      char frame_bytes[4096];
      CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_plan_item(plan, about.items, &item, &status));
      CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_plan_buffer(plan, about.buffers, &buffer, &status));
      CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_plan_write(plan, FURROW_BUFFER_WEIGHTS, &frame,
                                                               frame_bytes, sizeof frame_bytes, &status));
      frame.scale = -1.0f;
      CHECK_REFUSED(FURROW_INVALID_ARGUMENT,
                    furrow_plan_write(plan, FURROW_BUFFER_FRAME, &frame, weights, 1 << 20, &status));
      frame.scale = 0.0f, frame.laplace_steps = 1;
      CHECK_REFUSED(FURROW_INVALID_ARGUMENT,
                    furrow_plan_write(plan, FURROW_BUFFER_FRAME, &frame, weights, 1 << 20, &status));
      frame.laplace_steps = 0;
    }
    furrow_plan_release(plan);
  }
  {
    FurrowPlanDesc desc = {.size = sizeof desc};
    FurrowPlanInfo about = {.size = sizeof about};
    FurrowShaderSource source = {.size = sizeof source};
    desc.form = 3;
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_plan_create(asset, &desc, &plan, &status));
    CHECK(plan == NULL);
    desc.form = 0, desc.instances = 1u << 20;
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_plan_create(asset, &desc, &plan, &status));
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_plan_create(asset, NULL, &plan, &status));
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_plan_info(NULL, &about, &status));
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_shader_source(1000, &source, &status));
  }
  furrow_plan_release(NULL);
  testPlanOptions(context, file, asset, frame);
  free(palette), free(weights);
  furrow_asset_release(asset);
}

/* The surface at rest from the front, white, with every weight at `weight`; picture and depth are 4 and 1
   floats a pixel. */
static void drawPicture(FurrowAsset* asset, int16_t weight, float* picture, float* depth) {
  FurrowStatus status;
  FurrowAssetInfo info = {.size = sizeof info};
  FurrowGeometry geometry = {.size = sizeof geometry};
  FurrowPicture desc = {.size = sizeof desc};
  float low[3] = {1e9f, 1e9f, 1e9f}, high[3] = {-1e9f, -1e9f, -1e9f}, size = 0.0f;
  float* colors;
  int16_t* weights;
  char* raw;
  size_t i;
  int c;
  CHECK_OK(furrow_asset_info(asset, &info, &status));
  CHECK_OK(furrow_asset_geometry(asset, &geometry, &status));
  colors = malloc(3 * sizeof(float) * info.vertices);
  weights = malloc(sizeof(int16_t) * info.weight_stride * info.vertices);
  for (i = 0; i < 3 * (size_t)info.vertices; ++i) {
    colors[i] = 1.0f;
    if (geometry.positions[i] < low[i % 3]) low[i % 3] = geometry.positions[i];
    if (geometry.positions[i] > high[i % 3]) high[i % 3] = geometry.positions[i];
  }
  for (i = 0; i < (size_t)info.weight_stride * info.vertices; ++i) weights[i] = weight;
  for (c = 0; c < 3; ++c)
    if (high[c] - low[c] > size) size = high[c] - low[c];
  for (c = 0; c < 3; ++c) {
    const float scale = (c == 2 ? -1.8f : 1.8f) / size;
    desc.view_projection[5 * c] = scale, desc.view_projection[4 * c + 3] = -scale * (low[c] + high[c]) / 2.0f;
  }
  desc.view_projection[15] = 1.0f;
  desc.positions = geometry.positions, desc.colors = colors, desc.weights = weights;
  desc.width = 150, desc.height = 130, desc.picture = picture, desc.depth = depth;
  desc.memory_bytes = furrow_picture_memory(asset, 150, 130);
  raw = malloc(desc.memory_bytes + 64);
  desc.memory = raw + (64 - (size_t)raw % 64) % 64;
  CHECK(desc.memory_bytes > 0);
  CHECK_OK(furrow_picture_draw(asset, &desc, &status));
  if (weight == 0) {
    FurrowPicture wrong = desc;
    wrong.memory_bytes -= 64;
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_picture_draw(asset, &wrong, &status));
    wrong = desc, wrong.memory = (char*)desc.memory + 8;
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_picture_draw(asset, &wrong, &status));
    wrong = desc, wrong.positions = NULL;
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_picture_draw(asset, &wrong, &status));
    wrong = desc, wrong.samples = 3;
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_picture_draw(asset, &wrong, &status));
    wrong = desc, wrong.colors = NULL;
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_picture_draw(asset, &wrong, &status));
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_picture_draw(asset, NULL, &status));
    CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_picture_draw(NULL, &desc, &status));
    CHECK(furrow_picture_memory(asset, 0, 10) == 0 && furrow_picture_memory(asset, 10, 4097) == 0);
    {
      /* What is mirrored is added. Without back_gloss, no back_colors. */
      float* gloss = malloc(3 * sizeof(float) * info.vertices);
      float* added = malloc(16 * 150 * 130);
      for (i = 0; i < 3 * (size_t)info.vertices; ++i) colors[i] = 0.75f, gloss[i] = 0.25f;
      wrong = desc, wrong.gloss = gloss, wrong.back_colors = colors;
      CHECK_REFUSED(FURROW_INVALID_ARGUMENT, furrow_picture_draw(asset, &wrong, &status));
      wrong.back_gloss = gloss, wrong.picture = added;
      CHECK_OK(furrow_picture_draw(asset, &wrong, &status));
      for (i = 0; i < 4 * 150 * 130 && fabsf(added[i] - picture[i]) < 1e-5f; ++i) continue;
      CHECK(i == 4 * 150 * 130);
      free(gloss), free(added);
    }
  }
  free(raw), free(colors), free(weights);
}

/* The same bits from a host with jobs and from one thread; creases darken and nothing else changes. */
static void testPicture(FurrowContext* context, Host* host, File file) {
  enum { kPixels = 150 * 130 };
  FurrowStatus status;
  FurrowContext* alone = NULL;
  FurrowAsset *asset = NULL, *other = NULL;
  float* pictures[3];
  float* depths[3];
  int i, covered = 0, darker = 0;
  long allocations;
  CHECK_OK(furrow_context_create(NULL, &alone, &status));
  asset = loadAsset(context, file, 0, 0), other = loadAsset(alone, file, 0, 0);
  for (i = 0; i < 3; ++i) pictures[i] = malloc(16 * kPixels), depths[i] = malloc(4 * kPixels);
  allocations = host->allocations;
  drawPicture(asset, 0, pictures[0], depths[0]);
  drawPicture(asset, 32767, pictures[1], depths[1]);
  CHECK(host->allocations == allocations);
  drawPicture(other, 32767, pictures[2], depths[2]);
  CHECK(memcmp(pictures[1], pictures[2], 16 * kPixels) == 0 &&
        memcmp(depths[1], depths[2], 4 * kPixels) == 0);
  CHECK(memcmp(depths[0], depths[1], 4 * kPixels) == 0);
  for (i = 0; i < kPixels; ++i) {
    const float *plain = pictures[0] + 4 * i, *creased = pictures[1] + 4 * i;
    CHECK(plain[3] == creased[3] && fabsf(plain[0] - plain[3]) < 1e-5f && creased[0] <= plain[0]);
    CHECK((depths[0][i] < 1.0f) == (plain[3] > 0.0f) && depths[0][i] >= -1.0f);
    covered += plain[3] == 1.0f, darker += creased[0] < 0.9f * plain[0];
  }
  CHECK(covered > kPixels / 20 && darker > covered / 50);
  for (i = 0; i < 3; ++i) free(pictures[i]), free(depths[i]);
  furrow_asset_release(asset), furrow_asset_release(other), furrow_context_release(alone);
}

int main(int argc, char** argv) {
  FurrowStatus status;
  Host host = {0, 0, -1, 0, 0, 0, 0};
  FurrowContextDesc desc = hostDesc(&host);
  FurrowContext* context = NULL;
  File face, sleeve, brow, cuff;
  if (argc < 5) return 2;
  face = readFile(argv[1]), sleeve = readFile(argv[2]), brow = readFile(argv[3]), cuff = readFile(argv[4]);
  testLayout();
  testContext();
  CHECK_OK(furrow_context_create(&desc, &context, &status));
  testAsset(context, &host, face);
  testOutOfMemory(context, &host, sleeve);
  testPoses(context, sleeve);
  testDualQuaternions(context, sleeve);
  testResponse(context, sleeve);
  testInactiveLayers(context, sleeve);
  testMorphs(context, face);
  testBinding(context, &host, sleeve);
  testMemoryAndReload(context, &host, face, sleeve);
  testReloadInTime(context, brow, cuff);
  testJobs(&host, context, sleeve);
  testPlan(context, face);
  testPicture(context, &host, sleeve);
  CHECK(furrow_instance_weights(NULL) == NULL && furrow_instance_asset(NULL) == NULL);
  CHECK(furrow_instance_positions(NULL) == NULL && furrow_instance_normals(NULL) == NULL &&
        furrow_instance_tangents(NULL) == NULL);
  furrow_context_release(context);
  CHECK(host.live_bytes == 0 && host.warnings == 0);
  free(face.bytes), free(sleeve.bytes), free(brow.bytes), free(cuff.bytes);
  printf("%d failures\n", failures);
  return failures ? 1 : 0;
}
