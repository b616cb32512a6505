#include "editor/document/image_change.h"

#include <algorithm>

namespace furrow::editor {
namespace {

using pipeline::ByteImage;
using pipeline::Images;

constexpr uint32_t kTile = 64;  // texels a side

// Calls for the rows of a tile: first byte in the image, number of bytes.
template <typename Row>
void forRows(const ByteImage& image, uint32_t x, uint32_t y, const Row& row) {
  const size_t bytes = size_t{std::min(kTile, image.width - x)} * image.channels;
  for (uint32_t i = y; i < std::min(y + kTile, image.height); ++i)
    row((size_t{i} * image.width + x) * image.channels, bytes);
}

std::vector<ImageChange::Tile> tilesBetween(const ByteImage& from, const ByteImage& to) {
  std::vector<ImageChange::Tile> tiles;
  for (uint32_t y = 0; y < to.height; y += kTile)
    for (uint32_t x = 0; x < to.width; x += kTile) {
      bool differs = false;
      forRows(to, x, y, [&](size_t begin, size_t bytes) {
        differs = differs || !std::equal(&to.pixels[begin], &to.pixels[begin] + bytes, &from.pixels[begin]);
      });
      if (!differs) continue;
      ImageChange::Tile& tile = tiles.emplace_back(ImageChange::Tile{x, y, {}});
      forRows(to, x, y, [&](size_t begin, size_t bytes) {
        tile.pixels.insert(tile.pixels.end(), &to.pixels[begin], &to.pixels[begin] + bytes);
      });
    }
  return tiles;
}

}  // namespace

ImageChanges changesBetween(const Images& from, const Images& to) {
  ImageChanges changes;
  for (const auto& [file, image] : from)
    if (!to.contains(file)) changes.push_back({file, true, nullptr, {}});
  for (const auto& [file, image] : to) {
    const auto old = from.find(file);
    if (old != from.end() && old->second == image) continue;
    if (old == from.end() || old->second->width != image->width || old->second->height != image->height ||
        old->second->channels != image->channels)
      changes.push_back({file, true, image, {}});
    else
      changes.push_back({file, false, nullptr, tilesBetween(*old->second, *image)});
  }
  return changes;
}

Images changed(const Images& from, const ImageChanges& changes) {
  Images images = from;
  for (const ImageChange& change : changes) {
    if (change.whole) {
      if (change.image)
        images[change.file] = change.image;
      else
        images.erase(change.file);
      continue;
    }
    auto image = std::make_shared<ByteImage>(*images.at(change.file));
    for (const ImageChange::Tile& tile : change.tiles) {
      auto pixel = tile.pixels.begin();
      forRows(*image, tile.x, tile.y, [&](size_t begin, size_t bytes) {
        const auto end = pixel + static_cast<std::ptrdiff_t>(bytes);
        std::copy(pixel, end, image->pixels.begin() + static_cast<std::ptrdiff_t>(begin));
        pixel = end;
      });
    }
    images[change.file] = std::move(image);
  }
  return images;
}

size_t byteCount(const ImageChanges& changes) {
  size_t bytes = 0;
  for (const ImageChange& change : changes) {
    if (change.image) bytes += change.image->pixels.size();
    for (const ImageChange::Tile& tile : change.tiles) bytes += tile.pixels.size();
  }
  return bytes;
}

}  // namespace furrow::editor
