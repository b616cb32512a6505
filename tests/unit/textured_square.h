#pragma once

// A square with textures, as a file.

#include <array>

#include "pipeline/maps/image.h"
#include "tests/unit/gltf_builder.h"

namespace furrow::test {

using Color = std::array<uint8_t, 4>;
inline constexpr uint32_t kSide = 32;
inline constexpr std::array<Color, 4> kQuadrants = {
    {{200, 40, 30, 255}, {40, 160, 60, 255}, {50, 60, 180, 255}, {128, 128, 128, 255}}};

inline pipeline::ByteImage quadrants(uint32_t channels, const std::array<Color, 4>& colors = kQuadrants) {
  pipeline::ByteImage image{kSide, kSide, channels, {}};
  for (uint32_t y = 0; y < kSide; ++y)
    for (uint32_t x = 0; x < kSide; ++x) {
      const Color& color = colors[(y >= kSide / 2 ? 2 : 0) + (x >= kSide / 2 ? 1 : 0)];
      image.pixels.insert(image.pixels.end(), color.begin(), color.begin() + channels);
    }
  return image;
}

// A square of one material with UVs, in a file. `textures`: members of the root; `material`: of the material.
class Square {
 public:
  Square() {
    const int positions = builder_.add<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, "VEC3", 3);
    const int uvs = builder_.add<float>({0, 1, 1, 1, 1, 0, 0, 0}, "VEC2", 2);
    const int indices = builder_.add<uint16_t>({0, 1, 2, 0, 2, 3}, "SCALAR", 1);
    mesh_ = "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":" +
            std::to_string(positions) + ",\"TEXCOORD_0\":" + std::to_string(uvs) +
            "},\"indices\":" + std::to_string(indices) + ",\"material\":0}]}]";
  }

  // "bufferView":N of the bytes.
  std::string embedded(const std::vector<uint8_t>& bytes) {
    return "\"bufferView\":" + std::to_string(builder_.addView(bytes)) + ",\"mimeType\":\"image/any\"";
  }

  std::filesystem::path write(const std::string& name, const std::string& image, const std::string& texture,
                              const std::string& material, const std::string& more = "") const {
    return writeFile(name, builder_.glb(mesh_ + ",\"images\":[{" + image + "}],\"textures\":[{" + texture +
                                        "}],\"materials\":[{\"name\":\"skin\"," + material + "}]" + more));
  }

 private:
  GltfBuilder builder_;
  std::string mesh_;
};

}  // namespace furrow::test
