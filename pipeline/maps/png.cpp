#include "pipeline/maps/png.h"

#include <png.h>

#include <new>

namespace furrow::pipeline {

std::vector<std::byte> encodePng(const ByteImage& image) {
  constexpr png_uint_32 kFormats[] = {PNG_FORMAT_GRAY, PNG_FORMAT_GA, PNG_FORMAT_RGB, PNG_FORMAT_RGBA};
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = image.width;
  header.height = image.height;
  header.format = kFormats[image.channels - 1];
  std::vector<std::byte> bytes(PNG_IMAGE_PNG_SIZE_MAX(header));
  png_alloc_size_t size = bytes.size();
  // It has no other way to fail: the image is in memory and so is the file, which is large enough.
  if (!png_image_write_to_memory(&header, bytes.data(), &size, 0, image.pixels.data(), 0, nullptr))
    throw std::bad_alloc();
  bytes.resize(size);
  return bytes;
}

}  // namespace furrow::pipeline
