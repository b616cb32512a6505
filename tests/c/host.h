#pragma once

// What the tests of furrow.h share: files, and instances that are set up in one line.

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <vector>

#include "furrow/furrow.h"

namespace furrow::tests {

inline int failures = 0;

#define FURROW_CHECK(condition)                                          \
  do {                                                                   \
    if (!(condition)) {                                                  \
      std::printf("%s:%d: %s\n", __FILE__, __LINE__, #condition);        \
      __atomic_fetch_add(&furrow::tests::failures, 1, __ATOMIC_RELAXED); \
    }                                                                    \
  } while (0)

inline std::vector<char> readFile(const char* name) {
  std::ifstream in(name, std::ios::binary);
  std::vector<char> bytes((std::istreambuf_iterator<char>(in)), {});
  if (bytes.empty()) std::printf("%s: cannot be read\n", name), std::exit(2);
  return bytes;
}

inline void must(int32_t code, const FurrowStatus& status) {
  if (code != FURROW_OK) std::printf("%s\n", status.message), std::exit(2);
}

inline FurrowAsset* loadAsset(FurrowContext* context, const std::vector<char>& file, uint32_t flags = 0) {
  FurrowStatus status;
  FurrowAsset* asset = nullptr;
  FurrowAssetDesc desc = {};
  desc.size = sizeof desc, desc.bytes = file.data(), desc.byte_count = file.size(), desc.flags = flags;
  must(furrow_asset_create(context, &desc, &asset, &status), status);
  return asset;
}

inline FurrowAssetInfo infoOf(const FurrowAsset* asset) {
  FurrowStatus status;
  FurrowAssetInfo info = {};
  info.size = sizeof info;
  must(furrow_asset_info(asset, &info, &status), status);
  return info;
}

inline FurrowGeometry geometryOf(const FurrowAsset* asset) {
  FurrowStatus status;
  FurrowGeometry geometry = {};
  geometry.size = sizeof geometry;
  must(furrow_asset_geometry(asset, &geometry, &status), status);
  return geometry;
}

inline FurrowPartInfo partOf(const FurrowAsset* asset, uint32_t number) {
  FurrowStatus status;
  FurrowPartInfo part = {};
  part.size = sizeof part;
  must(furrow_part_info(asset, number, &part, &status), status);
  return part;
}

inline FurrowInstance* makeInstance(FurrowAsset* asset, uint32_t features) {
  FurrowStatus status;
  FurrowInstance* instance = nullptr;
  FurrowInstanceDesc desc = {};
  desc.size = sizeof desc, desc.features = features;
  must(furrow_instance_create(asset, &desc, &instance, &status), status);
  return instance;
}

// All joints squeezed along x and turned a little.
inline std::vector<float> squeezed(const FurrowAssetInfo& info, float squeeze) {
  std::vector<float> palette(12 * size_t{info.palette}, 0.0f);
  for (size_t i = 0; i < info.palette; ++i) {
    float* m = &palette[12 * i];
    m[0] = squeeze, m[5] = 0.96f, m[6] = -0.28f, m[9] = 0.28f, m[10] = 0.96f;
  }
  return palette;
}

inline FurrowFrame paletteFrame(const std::vector<float>& palette) {
  FurrowFrame frame = {};
  frame.size = sizeof frame;
  frame.palette = palette.data(), frame.palette_count = static_cast<uint32_t>(palette.size() / 12);
  return frame;
}

}  // namespace furrow::tests
