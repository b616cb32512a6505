/* plain ASSET: a C engine with libfurrow alone: loads, poses at rest, reads a weight. */

#include <stdio.h>
#include <stdlib.h>

#include "furrow/furrow.h"

static int fail(const FurrowStatus *status) {
  fprintf(stderr, "%s\n", status->message);
  return 1;
}

int main(int argc, char **argv) {
  static char bytes[1 << 24];
  FurrowStatus status;
  FurrowContext *context;
  FurrowAsset *asset;
  FurrowInstance *instance;
  FurrowAssetDesc file = {.size = sizeof file, .bytes = bytes};
  FurrowAssetInfo info = {.size = sizeof info};
  FurrowFrame frame = {.size = sizeof frame};
  float *palette;
  uint32_t i;
  FILE *in = fopen(argc > 1 ? argv[1] : "", "rb");
  if (!in) return 2;
  file.byte_count = fread(bytes, 1, sizeof bytes, in);
  fclose(in);

  if (furrow_context_create(NULL, &context, &status)) return fail(&status);
  if (furrow_asset_create(context, &file, &asset, &status)) return fail(&status);
  if (furrow_asset_info(asset, &info, &status)) return fail(&status);
  if (furrow_instance_create(asset, NULL, &instance, &status)) return fail(&status);
  palette = calloc(info.palette, 12 * sizeof(float));
  for (i = 0; i < info.palette; ++i) palette[12 * i] = palette[12 * i + 5] = palette[12 * i + 10] = 1.0f;
  frame.palette = palette, frame.palette_count = info.palette;
  if (furrow_instance_frame(instance, &frame, NULL, &status)) return fail(&status);
  printf("%u vertices, %u layers, the first weight is %d\n", info.vertices, info.layers,
         furrow_instance_weights(instance)[0]);

  free(palette);
  furrow_instance_release(instance);
  furrow_asset_release(asset);
  furrow_context_release(context);
  return 0;
}
