#pragma once

// What the parts of an asset take in a file, where they are packed.

#include <cstddef>
#include <span>

namespace furrow::pipeline {

struct SectionBytes {
  size_t geometry = 0;  // vertices, triangles, points
  size_t morphs = 0;    // of the morph targets
  size_t layers = 0;    // bias, masks and directions by vertex or point
  size_t maps = 0;      // wrinkle maps, and masks in textures
  size_t own_maps = 0;  // the model's own
  size_t place_hash = 0;
  size_t rig = 0;
};

// Of a whole .furrow file that the runtime has loaded. What is left are names, numbers and the header.
SectionBytes sectionBytes(std::span<const std::byte> file);

}  // namespace furrow::pipeline
