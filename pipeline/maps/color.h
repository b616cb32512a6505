#pragma once

// The model's own images to GPU textures.

#include "pipeline/maps/encode.h"

namespace furrow::pipeline {

// `color` in four channels, its opacity from another image: from that one's alpha if it says anything, else
// from its first channel. As large as the larger one.
ByteImage withOpacity(const ByteImage& color, const ByteImage& opacity);

// Colours, sRGB-encoded, of 1 to 4 channels (one or two: grey, and opacity) to kBc1, or to kBc3 if `opacity`
// is asked for and not 1 everywhere. Levels are means of light, those of a see-through image weighted by
// opacity; a side longer than `longest` is halved until it is not. The errors are those of the encoded
// values.
EncodedTexture encodeColor(ByteImage image, bool opacity, uint32_t longest, uint32_t threads = 1);

// A tangent-space normal map to kBc5, x and y times `scale`; likewise halved. Throws Error (kBadData, `name`
// names the image) if it is none: less than 2 channels, or grey all over.
EncodedTexture encodeNormal(ByteImage image, float scale, uint32_t longest, const std::string& name,
                            uint32_t threads = 1);

}  // namespace furrow::pipeline
