/* integration BROW.furrow BROW.obj: the C of docs/integration.md as it stands there, in an engine that has
   loaded its own mesh from the source file. */

#define _DEFAULT_SOURCE /* madvise() */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include "c_2_1.inc" /* engineAllocate() */
#include "furrow/furrow.h"

static void engineRelease(void* user, void* memory, size_t bytes, size_t alignment) {
  (void)user, (void)bytes, (void)alignment;
  free(memory);
}

static void engineLog(void* user, int32_t severity, const char* message) {
  (void)user;
  printf("%d: %s\n", (int)severity, message);
}

static void engineParallelFor(void* user, uint32_t count, uint32_t grain, FurrowTask task, void* data) {
  uint32_t begin, worker = 0;
  (void)user;
  for (begin = 0; begin < count; begin += grain, worker = (worker + 1) % 8)
    task(data, begin, begin + grain < count ? begin + grain : count, worker);
}

static int fail(const char* message) {
  fprintf(stderr, "%s\n", message);
  return 1;
}

typedef struct Vertex {
  float position[3], other[9];
} Vertex;

static Vertex vertices[1024];
static uint32_t indices[8192];
static char bytes[1 << 20];

/* The vertices in the file's order and its polygons as triangles. */
static void readObj(const char* name, uint32_t* n, size_t* m) {
  char line[256];
  FILE* in = fopen(name, "r");
  while (in && fgets(line, sizeof line, in)) {
    float* p = vertices[*n].position;
    if (sscanf(line, "v %f %f %f", p, p + 1, p + 2) == 3) {
      ++*n;
    } else if (line[0] == 'f') {
      uint32_t corners = 0, first = 0, before = 0;
      char* word;
      for (word = strtok(line + 1, " \n"); word; word = strtok(NULL, " \n"), ++corners) {
        const uint32_t v = (uint32_t)strtoul(word, NULL, 10) - 1;
        if (corners == 0) first = v;
        if (corners >= 2) indices[(*m)++] = first, indices[(*m)++] = before, indices[(*m)++] = v;
        before = v;
      }
    }
  }
  if (in) fclose(in);
}

int main(int argc, char** argv) {
  void* engine = NULL;
  size_t count, size = sizeof vertices, m = 0;
  uint32_t n = 0, i;
  FILE* in = fopen(argc > 2 ? argv[1] : "", "rb");
  if (!in) return fail("no asset");
  count = fread(bytes, 1, sizeof bytes, in);
  fclose(in);
  readObj(argv[2], &n, &m);

#include "c_1_1.inc"
#include "c_1_2.inc"

  if (info.layers != 4) return fail("the asset has other layers than this test");

#include "c_3_1.inc"

  if (counts.matched != n || counts.missing != 0 || n == 0)
    return fail("the engine's vertices are not all bound");

  float *matrices = calloc(info.palette, 12 * sizeof(float)),
        *weights = calloc(info.morphs + 1, sizeof(float));
  const float dt = 1.0f / 60.0f;
  int8_t* stream = malloc(4 * (size_t)n);
  for (i = 0; i < info.palette; ++i)
    matrices[12 * i] = matrices[12 * i + 10] = 1.0f, matrices[12 * i + 5] = 0.6f; /* squeezed along y */
  size = 4 * (size_t)n;

#include "c_4_1.inc"
#include "c_4_2.inc"
#include "c_4_3.inc"

  if (status.code != FURROW_OK) return fail(status.message);
  for (i = 0; i < n; ++i) /* the squeeze is that of layer 0; layer 1 lies across it */
    if (stream[4 * i] < 60 || stream[4 * i + 1] > 1)
      return fail("a vertex of the engine has not the weight it should");
  if (w[0] < 15000) return fail("the asset's vertices have not the weights they should");

  float clip_from_object[16] = {0.8f, 0, 0, -0.4f, 0, 0.8f, 0, -0.3f, 0, 0, 0.5f, 0, 0, 0, 0, 1};
  float *lit = malloc(3 * sizeof(float) * info.vertices), *rgba = malloc(4 * sizeof(float) * 1024 * 1024);
  void* memory = engineAllocate(NULL, furrow_picture_memory(asset, 1024, 1024), 64);
  for (i = 0; i < 3 * info.vertices; ++i) lit[i] = 1.0f;

#include "c_5_1.inc"

  if (status.code != FURROW_OK) return fail(status.message);
  if (!(rgba[4 * (512 * 1024 + 512) + 3] == 1.0f) || !(rgba[4 * (512 * 1024 + 512)] < 0.9f))
    return fail("the picture does not show the creased surface in its middle");

  free(matrices), free(weights), free(stream), free(lit), free(rgba), free(memory);
  furrow_instance_release(instance);
  furrow_binding_release(binding);
  furrow_asset_release(asset);
  furrow_context_release(context);
  return 0;
}
