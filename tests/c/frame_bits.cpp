// frame_bits ASSET.furrow...: a line with a hash for everything that frames give, by every kind of deformer.
// The same lines come out for every instruction set and CPU.

#include <cstring>
#include <memory>

#include "host.h"

namespace {

using namespace furrow::tests;

// FNV-1a.
void print(const char* what, const void* data, size_t bytes) {
  uint64_t hash = 0xcbf29ce484222325u;
  for (size_t i = 0; i < bytes; ++i)
    hash = (hash ^ static_cast<const unsigned char*>(data)[i]) * 0x100000001b3u;
  std::printf("%s %016llx\n", what, static_cast<unsigned long long>(hash));
}

void printAll(const FurrowInstance* instance, const FurrowAssetInfo& info) {
  const size_t vertices = info.vertices;
  print("weights", furrow_instance_weights(instance), vertices * info.weight_stride * sizeof(int16_t));
  if (const float* positions = furrow_instance_positions(instance))
    print("positions", positions, vertices * 3 * sizeof(float));
  if (const float* normals = furrow_instance_normals(instance)) {
    print("normals", normals, vertices * 3 * sizeof(float));
    print("tangents", furrow_instance_tangents(instance), vertices * 4 * sizeof(float));
  }
}

void printPicture(const FurrowAsset* asset, const FurrowInstance* instance, const FurrowAssetInfo& info) {
  constexpr uint32_t kSide = 128;
  const std::vector<float> colors(3 * size_t{info.vertices}, 0.5f);
  std::vector<float> pixels(4 * kSide * kSide), depth(kSide * kSide);
  const size_t bytes = furrow_picture_memory(asset, kSide, kSide);
  std::vector<char> memory(bytes + 64);
  void* aligned = memory.data();
  size_t space = memory.size();
  FurrowPicture picture = {};
  picture.size = sizeof picture;
  picture.positions = furrow_instance_positions(instance);
  const float view[16] = {1.5f, 0.2f, 0, 0.1f, -0.2f, 1.5f, 0.1f, 0, 0, 0, -1.2f, 1.0f, 0, 0, -0.4f, 2.5f};
  std::memcpy(picture.view_projection, view, sizeof view);
  picture.width = picture.height = kSide;
  picture.colors = colors.data();
  picture.weights = furrow_instance_weights(instance);
  picture.memory = std::align(64, bytes, aligned, space);
  picture.memory_bytes = bytes;
  picture.picture = pixels.data();
  picture.depth = depth.data();
  FurrowStatus status;
  must(furrow_picture_draw(asset, &picture, &status), status);
  print("picture", pixels.data(), pixels.size() * sizeof(float));
  print("depth", depth.data(), depth.size() * sizeof(float));
}

void printFrames(const char* file) {
  FurrowContext* context = nullptr;
  FurrowStatus status;
  must(furrow_context_create(nullptr, &context, &status), status);
  std::fprintf(stderr, "%s: %s\n", file, furrow_context_simd(context));
  FurrowAsset* asset = loadAsset(context, readFile(file));
  const FurrowAssetInfo info = infoOf(asset);
  const std::vector<float> palette = squeezed(info, 0.7f), morphs(info.morphs, 0.3f);
  FurrowFrame frame = paletteFrame(palette);
  frame.morph_weights = morphs.data(), frame.morph_count = info.morphs;
  for (uint32_t features : {0u, uint32_t{FURROW_KEEP_POSITIONS}, uint32_t{FURROW_KEEP_NORMALS},
                            uint32_t{FURROW_KEEP_NORMALS} | FURROW_USE_DUAL_QUATERNIONS,
                            uint32_t{FURROW_USE_LAPLACE}, uint32_t{FURROW_USE_RECAPTURE}}) {
    FurrowInstance* instance = makeInstance(asset, features);
    frame.skinning = (features & FURROW_USE_DUAL_QUATERNIONS) != 0;  // FURROW_SKINNING_DUAL_QUATERNION is 1
    frame.laplace_steps = features & FURROW_USE_LAPLACE ? 2 : 0;
    if (features & FURROW_USE_RECAPTURE) {
      const std::vector<float> rest = squeezed(info, 1.2f);
      const FurrowFrame pose = paletteFrame(rest);
      must(furrow_instance_recapture(instance, &pose, &status), status);
    }
    must(furrow_instance_frame(instance, &frame, nullptr, &status), status);
    std::printf("features %u\n", features);
    printAll(instance, info);
    if (furrow_instance_positions(instance)) printPicture(asset, instance, info);
    furrow_instance_release(instance);
  }
  furrow_asset_release(asset);
  furrow_context_release(context);
}

}  // namespace

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) printFrames(argv[i]);
  return argc > 1 ? 0 : 2;
}
