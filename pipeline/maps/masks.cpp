#include "pipeline/maps/masks.h"

#include <cmath>

#include "pipeline/error.h"
#include "pipeline/parallel.h"

namespace furrow::pipeline {
namespace {

constexpr uint32_t kLeastSide = 4;

// Whether nearly all texels are unit vectors that point out of the surface.
bool isNormalMap(const ByteImage& image) {
  if (image.channels < 3) {
    return false;
  }
  size_t normals = 0, bent = 0;
  for (size_t i = 0; i < image.pixels.size(); i += image.channels) {
    const auto at = [&](size_t c) { return static_cast<float>(image.pixels[i + c]) / 127.5f - 1.0f; };
    const float length2 = at(0) * at(0) + at(1) * at(1) + at(2) * at(2);
    normals += at(2) > 0.0f && length2 > 0.85f && length2 < 1.15f;
    bent += std::abs(at(0)) + std::abs(at(1)) > 0.05f;
  }
  const size_t texels = image.pixels.size() / image.channels;
  return normals > texels - texels / 50 && bent > 0;
}

// One channel at another size.
ByteImage resized(const MaskChannel& source, uint32_t width, uint32_t height) {
  const ByteImage& image = *source.image;
  Image plane{image.width, image.height, 1, std::vector<float>(size_t{image.width} * image.height)};
  for (size_t i = 0; i < plane.pixels.size(); ++i) {
    plane.pixels[i] = static_cast<float>(image.pixels[i * image.channels + source.channel]) / 255.0f;
  }
  return toBytes(resize(plane, width, height));
}

}  // namespace

MaskImages readMasks(std::span<const std::filesystem::path> files, uint32_t threads) {
  std::vector<ByteImage> images(files.size());
  parallelFor(static_cast<uint32_t>(files.size()), threads,
              [&](uint32_t i) { images[i] = readByteImage(files[i]); });
  MaskImages masks;
  for (size_t i = 0; i < files.size(); ++i) {
    masks.emplace(files[i], std::move(images[i]));
  }
  return masks;
}

void checkMask(const std::filesystem::path& file, const ByteImage& image, uint32_t channel,
               const std::string& layer) {
  const auto fail = [&](const std::string& wrong, const std::string& remedy) {
    throw Error(Exit::kBadData, file.string(), "the mask of layer \"" + layer + "\" " + wrong, remedy);
  };
  const std::string name(1, "rgba"[channel]);
  if (channel >= image.channels) {
    fail("is channel " + name + ", and the image has " + std::to_string(image.channels),
         "choose another channel");
  }
  if (image.width < kLeastSide || image.height < kLeastSide) {
    fail("is " + std::to_string(image.width) + " x " + std::to_string(image.height) + " texels",
         "give an image of at least 4 x 4");
  }
  if (channel < 3 && isNormalMap(image)) {
    fail("is a channel of a normal map", "name the image the mask is painted in");
  }
  const uint8_t first = image.pixels[channel];
  for (size_t i = channel; i < image.pixels.size(); i += image.channels) {
    if (image.pixels[i] != first) {
      return;
    }
  }
  if (first == 0) {
    fail("is empty: channel " + name + " is black everywhere", "paint it or choose another channel");
  }
  fail("is constant: channel " + name + " is " + std::to_string(first) + " everywhere",
       "choose another channel, or say \"mask\": \"none\" for the whole surface");
}

ByteImage packMasks(const std::array<MaskChannel, 4>& channels, uint32_t width, uint32_t height,
                    uint32_t threads) {
  ByteImage packed{width, height, 4, std::vector<uint8_t>(size_t{width} * height * 4)};
  std::array<MaskChannel, 4> sources = channels;
  std::array<ByteImage, 4> others;
  for (size_t c = 0; c < 4; ++c) {
    const ByteImage* image = channels[c].image;
    if (image && (image->width != width || image->height != height)) {
      others[c] = resized(channels[c], width, height);
      sources[c] = {&others[c], 0};
    }
  }
  parallelFor(height, threads, [&](uint32_t y) {
    for (size_t c = 0; c < 4; ++c) {
      if (!sources[c].image) {
        continue;
      }
      const uint8_t* from = sources[c].image->at(0, y) + sources[c].channel;
      const uint32_t stride = sources[c].image->channels;
      uint8_t* to = &packed.pixels[size_t{y} * width * 4 + c];
      for (uint32_t x = 0; x < width; ++x) {
        to[4 * x] = from[size_t{x} * stride];
      }
    }
  });
  return packed;
}

}  // namespace furrow::pipeline
