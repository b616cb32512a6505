#pragma once

// What differs between two sets of painted images, kept in tiles: a stroke changes a small part of an image,
// and undo goes a long way back.

#include <vector>

#include "pipeline/maps/image.h"

namespace furrow::editor {

// How one image becomes another.
struct ImageChange {
  struct Tile {
    uint32_t x, y;  // of its first texel
    std::vector<uint8_t> pixels;
  };
  std::filesystem::path file;
  // Another size or another number of channels: the whole image; null: it goes.
  bool whole = false;
  std::shared_ptr<const pipeline::ByteImage> image;
  std::vector<Tile> tiles;
};
using ImageChanges = std::vector<ImageChange>;

// The changes by which `from` becomes `to`.
ImageChanges changesBetween(const pipeline::Images& from, const pipeline::Images& to);
pipeline::Images changed(const pipeline::Images& from, const ImageChanges& changes);
size_t byteCount(const ImageChanges& changes);  // of their texels

}  // namespace furrow::editor
