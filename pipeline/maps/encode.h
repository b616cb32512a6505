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
};

// Mip levels down to 1 x 1 and blocks of an array of images of one size, powers of two from 4, with the
// format's channels (else std::invalid_argument). No slices: an empty texture.
//   kBc5: channels 0, 1 are a unit normal's x, y in [-1, 1] (stored * 0.5 + 0.5); levels are averaged as
//   slopes x/z, y/z and renormalised. kBc4: channel 0 in [0, 1].   kRgba8: four channels in [0, 1], rounded
//   to the nearest; level 0 is exact for 8-bit sources.
EncodedTexture encode(TextureFormat format, std::span<const Image> slices);

}  // namespace furrow::pipeline
