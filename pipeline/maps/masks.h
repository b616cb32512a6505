#pragma once

// Painted masks: from image files to the channels of a texture, in bytes from end to end.

#include <array>
#include <filesystem>
#include <map>
#include <span>
#include <string>

#include "pipeline/maps/image.h"

namespace furrow::pipeline {

// Images by path, each read once though several masks may be channels of it.
using MaskImages = std::map<std::filesystem::path, ByteImage>;

// Throws Error as readImage().
MaskImages readMasks(std::span<const std::filesystem::path> files, uint32_t threads);

// Throws Error (kBadData), which names the file and the layer, if the channel cannot be a mask: it is not
// there, the image has less than 4 texels a side or is a normal map, the channel is empty (black) or one
// value everywhere.
void checkMask(const std::filesystem::path& file, const ByteImage& image, uint32_t channel,
               const std::string& layer);

struct MaskChannel {
  const ByteImage* image = nullptr;  // null: black
  uint32_t channel = 0;
};

// Four channels side by side: to the bit where an image has this size, else resized.
ByteImage packMasks(const std::array<MaskChannel, 4>& channels, uint32_t width, uint32_t height,
                    uint32_t threads);

}  // namespace furrow::pipeline
