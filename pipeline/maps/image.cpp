#include "pipeline/maps/image.h"

#include <dlfcn.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <system_error>

#include "pipeline/error.h"
#include "pipeline/import/import.h"
#include "pipeline/maps/image_module.h"
#include "pipeline/maps/png.h"
#include "pipeline/pack/output_file.h"

namespace furrow::pipeline {
namespace {

constexpr int kMaxSide = 16384;  // of a texture on the GPUs furrow is for
constexpr float kMostUv = 1e6f;  // further out floats tell no texels apart

ImageModule loadImageModule() {
  const std::filesystem::path file = imageModuleFile();
  // Never closed: its libraries keep threads and thread-local data.
  void* const module = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  const auto entry = module ? reinterpret_cast<ImageModuleEntry>(dlsym(module, kImageModuleEntry)) : nullptr;
  if (!entry) {
    const char* const reason = dlerror();
    throw Error(
        Exit::kEnvironment, file.string(),
        "images cannot be read without this module (" + std::string(reason ? reason : "unknown reason") + ")",
        "put it back beside the program, from the same build, with OpenImageIO installed");
  }
  return entry();
}

const ImageModule& imageModule() {
  static const ImageModule module = loadImageModule();
  return module;
}

// `name`: for messages.
template <class AnyImage>
AnyImage read(const ImageModule::Source& source, const std::string& name) {
  AnyImage image;
  const auto place = [](void* context, int width, int height, int depth, int channels) -> void* {
    AnyImage& to = *static_cast<AnyImage*>(context);
    to.width = static_cast<uint32_t>(width);
    to.height = static_cast<uint32_t>(height);
    to.channels = static_cast<uint32_t>(channels);
    if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide || depth > 1 || channels < 1 ||
        channels > 4)
      return nullptr;
    to.pixels.resize(static_cast<size_t>(to.width) * to.height * to.channels);
    return to.pixels.data();
  };
  const ImageModule::Reading reading =
      imageModule().read(source, std::is_same_v<AnyImage, ByteImage>, place, &image);
  if (!reading.opened)
    throw Error(Exit::kBadData, name, std::string("it cannot be read as an image (") + reading.fault + ")",
                "give a PNG, JPEG, WebP, TGA, TIFF or EXR file");
  if (image.pixels.empty())
    throw Error(Exit::kBadData, name,
                "the image is " + std::to_string(image.width) + " x " + std::to_string(image.height) +
                    " with " + std::to_string(image.channels) + " channels",
                "give one of at most 16384 x 16384 texels and 1 to 4 channels");
  if (reading.fault)
    throw Error(Exit::kBadData, name, std::string("the image is damaged (") + reading.fault + ")",
                "export it again");
  return image;
}

template <class AnyImage>
AnyImage readBytesOf(std::span<const uint8_t> bytes, const std::string& name) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const char* format = text.starts_with("\x89PNG")    ? "embedded.png"
                       : text.starts_with("\xff\xd8") ? "embedded.jpg"
                       : text.starts_with("RIFF") && text.size() > 12 && text.substr(8, 4) == "WEBP"
                           ? "embedded.webp"
                           : nullptr;
  if (!format) throw Error(Exit::kBadData, name, "it is neither PNG nor JPEG nor WebP", "export it again");
  return read<AnyImage>({format, bytes.data(), bytes.size()}, name);
}

template <class AnyImage>
AnyImage readFile(const std::filesystem::path& file) {
  const auto embedded = embeddedImage(file);
  if (!embedded) return read<AnyImage>({file.c_str(), nullptr, 0}, file.string());
  const SourceImage& image = embedded->image;
  return image.file.empty() ? readBytesOf<AnyImage>(image.bytes, file.string())
                            : read<AnyImage>({image.file.c_str(), nullptr, 0}, image.file.string());
}

}  // namespace

std::filesystem::path imageModuleFile() {
  const std::filesystem::path folder = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  std::filesystem::path file = folder / FURROW_IMAGE_MODULE;
  const std::filesystem::path installed = folder / "../lib/furrow" / FURROW_IMAGE_MODULE;
  std::error_code error;
  if (!std::filesystem::exists(file, error) && std::filesystem::exists(installed, error)) file = installed;
  return file;
}

Image readImage(const std::filesystem::path& file) {
  Image image = readFile<Image>(file);
  if (!std::all_of(image.pixels.begin(), image.pixels.end(), [](float v) { return std::isfinite(v); }))
    throw Error(Exit::kBadData, file.string(), "the image holds values that are not finite",
                "export it again");
  return image;
}

ByteImage readByteImage(const std::filesystem::path& file) {
  return readFile<ByteImage>(file);
}

ByteImage readByteImage(std::span<const uint8_t> bytes, const std::string& name) {
  return readBytesOf<ByteImage>(bytes, name);
}

Image toFloats(const ByteImage& image) {
  Image floats{image.width, image.height, image.channels, std::vector<float>(image.pixels.size())};
  std::transform(image.pixels.begin(), image.pixels.end(), floats.pixels.begin(),
                 [](uint8_t v) { return static_cast<float>(v) / 255.0f; });
  return floats;
}

float sampleAt(const ByteImage& image, glm::vec2 uv, uint32_t channel) {
  if (!(std::abs(uv.x) < kMostUv && std::abs(uv.y) < kMostUv)) uv = glm::vec2(0.0f);
  const auto wrap = [](float t, uint32_t size) {
    const auto i = static_cast<int64_t>(std::floor(t)) % static_cast<int64_t>(size);
    return static_cast<uint32_t>(i < 0 ? i + size : i);
  };
  const float x = uv.x * static_cast<float>(image.width) - 0.5f,
              y = uv.y * static_cast<float>(image.height) - 0.5f;
  const float fx = x - std::floor(x), fy = y - std::floor(y);
  const auto at = [&](float dx, float dy) {
    return static_cast<float>(image.at(wrap(x + dx, image.width), wrap(y + dy, image.height))[channel]) /
           255.0f;
  };
  return (at(0, 0) * (1 - fx) + at(1, 0) * fx) * (1 - fy) + (at(0, 1) * (1 - fx) + at(1, 1) * fx) * fy;
}

ByteImage toBytes(const Image& image) {
  ByteImage bytes{image.width, image.height, image.channels, std::vector<uint8_t>(image.pixels.size())};
  std::transform(image.pixels.begin(), image.pixels.end(), bytes.pixels.begin(), [](float v) {
    return static_cast<uint8_t>(std::lround(std::clamp(v, 0.0f, 1.0f) * 255.0f));
  });
  return bytes;
}

void requirePngName(const std::filesystem::path& file) {
  if (file.extension() != ".png")
    throw Error(Exit::kBadUsage, file.string(), "images are written as PNG", "give a name that ends in .png");
}

void writeImage(const std::filesystem::path& file, const Image& image) {
  requirePngName(file);
  writeFile(file, encodePng(toBytes(image)));
}

Image resize(const Image& image, uint32_t width, uint32_t height, glm::dvec2 low, glm::dvec2 extent) {
  // One axis after the other; a triangle as wide as the coarser of the two grids, so that shrinking averages
  // and growing interpolates.
  const auto along = [](const Image& in, uint32_t size, double begin, double length, bool rows) {
    const uint32_t old_size = rows ? in.height : in.width, others = rows ? in.width : in.height;
    Image out{rows ? in.width : size, rows ? size : in.height, in.channels, {}};
    out.pixels.assign(static_cast<size_t>(out.width) * out.height * out.channels, 0.0f);
    const double scale = length * old_size / size, radius = std::max(scale, 1.0);
    for (uint32_t i = 0; i < size; ++i) {
      const double centre = begin * old_size + (i + 0.5) * scale - 0.5;
      const auto first = static_cast<int64_t>(std::ceil(centre - radius));
      const auto last = static_cast<int64_t>(std::floor(centre + radius));
      const auto falling = [&](int64_t j) {
        return 1.0 - std::abs(static_cast<double>(j) - centre) / radius;
      };
      double total = 0.0;
      for (int64_t j = first; j <= last; ++j) {
        total += falling(j);
      }
      for (int64_t j = first; j <= last; ++j) {
        const auto weight = static_cast<float>(falling(j) / total);
        const auto from = static_cast<uint32_t>((j % old_size + old_size) % old_size);
        for (uint32_t k = 0; weight > 0.0f && k < others; ++k) {
          const float* source = rows ? in.at(k, from) : in.at(from, k);
          float* target = rows ? out.at(k, i) : out.at(i, k);
          for (uint32_t c = 0; c < in.channels; ++c) {
            target[c] += weight * source[c];
          }
        }
      }
    }
    return out;
  };
  if (image.width == width && image.height == height && low == glm::dvec2(0.0) && extent == glm::dvec2(1.0)) {
    return image;
  }
  return along(along(image, width, low.x, extent.x, false), height, low.y, extent.y, true);
}

}  // namespace furrow::pipeline
