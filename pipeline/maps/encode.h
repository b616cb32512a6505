#pragma once

// Images to GPU textures: mip chains and block compression.

#include <cstddef>
#include <span>
#include <vector>

#include "furrow/asset.h"
#include "pipeline/maps/image.h"

namespace furrow::pipeline {

// A texture that owns its data; the layout is that of furrow::Texture.
struct EncodedTexture {
  TextureFormat format = TextureFormat::kRgba8;
  uint32_t width = 0, height = 0, slices = 0, levels = 0;
  std::vector<std::byte> data;
  // Of the largest level against its source, where it is covered: degrees between normals (kBc5), part of the
  // range of factors (kBc4); 0 for kRgba8, which stores its source to the bit.
  double rms_error = 0.0, largest_error = 0.0;
};

constexpr const char* textureFormatName(TextureFormat format) {
  constexpr const char* kNames[] = {"BC5", "BC4", "RGBA8", "BC1", "BC3"};
  return kNames[static_cast<size_t>(format)];
}

// For each texel of a slice, whether a chart has it (else 0). Empty: all texels.
using Coverage = std::vector<uint8_t>;

// Mip levels down to 1 x 1 and blocks of an array of images of one size, sides multiples of 4, with the
// format's channels (else std::invalid_argument). No slices: an empty texture. Smaller levels are means over
// the covered texels alone, and texels that are not covered take the value of the level above them, so that
// no filter brings in what lies outside the charts. Any number of threads gives the same bytes.
//   kBc5: channels 0, 1 are a unit normal's x, y in [-1, 1] (stored * 0.5 + 0.5); levels are averaged as
//   slopes x/z, y/z and renormalised. kBc4: channel 0 in [0, 1].
EncodedTexture encode(TextureFormat format, std::span<const Image> slices,
                      std::span<const Coverage> coverage = {}, uint32_t threads = 1);

// The same for kRgba8: four channels, sides of any size; covered texels of level 0 are stored to the bit.
EncodedTexture encodeBytes(std::span<const ByteImage> slices, std::span<const Coverage> coverage = {},
                           uint32_t threads = 1);

// A slice of the largest level, in [0, 1]: 2 channels of kBc5, 1 of kBc4, 4 of kRgba8.
Image decode(const Texture& texture, uint32_t slice);

}  // namespace furrow::pipeline
