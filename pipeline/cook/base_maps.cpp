#include "pipeline/cook/base_maps.h"

#include <algorithm>
#include <set>

#include "pipeline/error.h"
#include "pipeline/input_file.h"
#include "pipeline/maps/color.h"

namespace furrow::pipeline {
namespace {

ByteImage decoded(const SourceImage& image, std::vector<std::filesystem::path>& dependencies) {
  if (image.file.empty()) return readByteImage(image.bytes, image.name);
  const std::vector<uint8_t> bytes = readBytes(image.file);
  if (std::ranges::find(dependencies, image.file) == dependencies.end()) dependencies.push_back(image.file);
  return readByteImage(bytes, image.file.string());
}

}  // namespace

SceneBaseMaps bakeBaseMaps(const SourceScene& scene, uint32_t longest, uint32_t threads) {
  SceneBaseMaps out;
  out.of_material.assign(scene.materials.size(), kNoIndex);
  std::set<uint32_t> shown;
  for (const Part& part : scene.parts)
    if (part.material < scene.materials.size() && !scene.primitives[part.primitive].uvs.empty())
      shown.insert(part.material);
  if (longest == 0) shown.clear();
  for (const uint32_t m : shown) {
    const Material& material = scene.materials[m];
    const auto known = std::ranges::find(out.maps, material.maps, &BakedBaseMaps::source);
    if (known != out.maps.end()) {
      out.of_material[m] = static_cast<uint32_t>(known - out.maps.begin());
      continue;
    }
    BakedBaseMaps maps{material.name, material.maps, {}, {}};
    const auto bake = [&](const MaterialMap& map, const char* use, const auto& encoded) {
      if (map.image == kNoIndex) return EncodedTexture();
      try {
        return encoded(decoded(scene.images[map.image], out.dependencies));
      } catch (const Error& error) {
        if (error.exit() == Exit::kEnvironment) throw;
        out.warnings.push_back("material \"" + material.name + "\": its " + use +
                               " texture is left out: " + error.what());
        return EncodedTexture();
      }
    };
    maps.color = bake(material.maps.color, "base colour", [&](ByteImage image) {
      return encodeColor(std::move(image), material.maps.opaque_from > 0.0f, longest, threads);
    });
    maps.normal = bake(material.maps.normal, "normal", [&](ByteImage image) {
      const SourceImage& source = scene.images[material.maps.normal.image];
      return encodeNormal(std::move(image), material.maps.normal_scale, longest, source.name, threads);
    });
    if (maps.color.slices + maps.normal.slices == 0) continue;
    out.of_material[m] = static_cast<uint32_t>(out.maps.size());
    out.maps.push_back(std::move(maps));
  }
  return out;
}

}  // namespace furrow::pipeline
