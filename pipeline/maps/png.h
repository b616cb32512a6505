#pragma once

// Pictures as PNG, through libpng: what furrow writes needs no OpenImageIO, whose packages draw in OpenGL.

#include <cstddef>
#include <vector>

#include "pipeline/maps/image.h"

namespace furrow::pipeline {

// A whole file; 1 to 4 channels, the same bytes for the same image. Throws std::bad_alloc.
std::vector<std::byte> encodePng(const ByteImage& image);

}  // namespace furrow::pipeline
