#include "pipeline/cook/base_maps.h"

#include <algorithm>
#include <bit>
#include <functional>
#include <set>
#include <span>

#include "pipeline/content_key.h"
#include "pipeline/error.h"
#include "pipeline/input_file.h"
#include "pipeline/maps/color.h"

namespace furrow::pipeline {
namespace {

std::string keyOf(std::span<const uint8_t> bytes, const char* use, const std::string& setting,
                  uint32_t longest) {
  return use + (' ' + contentKey(std::as_bytes(bytes))) + ' ' + setting + ' ' + std::to_string(longest);
}

}  // namespace

SceneBaseMaps bakeBaseMaps(const SourceScene& scene, uint32_t longest, uint32_t threads,
                           EncodedImages& known_images) {
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
    // made(bytes, decode) of an image, or nothing.
    const auto withImage = [&](uint32_t index, const char* use, const auto& made) {
      using Made = decltype(made(std::span<const uint8_t>(), std::function<ByteImage()>()));
      if (index == kNoIndex) return Made();
      const SourceImage& image = scene.images[index];
      try {
        const std::vector<uint8_t> read = image.file.empty() ? std::vector<uint8_t>() : readBytes(image.file);
        if (!image.file.empty() && std::ranges::find(out.dependencies, image.file) == out.dependencies.end())
          out.dependencies.push_back(image.file);
        const std::span<const uint8_t> bytes = image.file.empty() ? image.bytes : read;
        return made(bytes, [&] {
          return image.file.empty() ? readByteImage(bytes, image.name) : readByteImage(image.file);
        });
      } catch (const Error& error) {
        if (error.exit() == Exit::kEnvironment) throw;
        out.warnings.push_back((material.name.empty() ? "a material" : "material \"" + material.name + "\"") +
                               ": its " + use + " texture is left out: " + error.what());
        return Made();
      }
    };
    const auto bake = [&](uint32_t index, const char* use, const std::string& setting, const auto& encoded) {
      return withImage(index, use, [&](std::span<const uint8_t> bytes, const auto& decode) {
        const std::string key = keyOf(bytes, use, setting, longest);
        if (const auto found = known_images.find(key); found != known_images.end()) return found->second;
        return known_images[key] = encoded(decode());
      });
    };
    const ByteImage opacity =
        withImage(material.maps.opacity, "opacity",
                  [](std::span<const uint8_t>, const auto& decode) { return decode(); });
    const bool own = material.maps.opacity == kNoIndex,
               cut = material.maps.opaque_from > 0.0f && (own || !opacity.pixels.empty());
    const auto encodedColor = [&](ByteImage image) {
      if (!opacity.pixels.empty()) image = withOpacity(image, opacity);
      return encodeColor(std::move(image), cut, longest, threads);
    };
    if (material.maps.color.image != kNoIndex)
      maps.color = bake(material.maps.color.image, "base colour",
                        std::to_string(cut) + ' ' + contentKey(std::as_bytes(std::span(opacity.pixels))),
                        encodedColor);
    else if (!opacity.pixels.empty())
      maps.color = encodedColor({1, 1, 1, {255}});
    maps.normal = bake(
        material.maps.normal.image, "normal",
        std::to_string(std::bit_cast<uint32_t>(material.maps.normal_scale)), [&](ByteImage image) {
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
