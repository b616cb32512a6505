#pragma once

// What textures take in a file, where they are packed.

#include <cstddef>
#include <span>

namespace furrow::pipeline {

struct TextureBytes {
  size_t maps = 0;  // wrinkle maps and masks
  size_t own = 0;   // of the model's own maps
};

// Of a whole .furrow file that the runtime has loaded.
TextureBytes textureBytes(std::span<const std::byte> file);

}  // namespace furrow::pipeline
