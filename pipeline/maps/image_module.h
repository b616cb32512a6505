#pragma once

// The boundary between the pipeline and the module furrow_images, which alone links OpenImageIO and is loaded
// by the first image that is read: OpenImageIO draws in 260 libraries. Both sides come from one
// build. Functions may be called from any thread.

#include <cstddef>

namespace furrow::pipeline {

// A fault is one line, or null; it holds until the next call on the same thread.
struct ImageModule {
  struct Reading {
    bool opened;  // false: it is no image at all
    const char* fault;
  };
  // Where the pixels of an image of this size go: width * height * channels of them, rows from the top. Null
  // ends the reading.
  using Place = void* (*)(void* context, int width, int height, int depth, int channels);

  // Where an image is: in a file, or in memory (`data` is not null), and then `name` tells its format alone.
  struct Source {
    const char* name;
    const void* data;
    size_t size;
  };

  // Pixels are floats, or bytes.
  Reading (*read)(const Source& source, bool bytes, Place place, void* context);
};

// The module's only symbol.
using ImageModuleEntry = ImageModule (*)();
inline constexpr const char* kImageModuleEntry = "furrowImageModule";

}  // namespace furrow::pipeline
