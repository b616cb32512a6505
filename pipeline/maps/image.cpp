#include "pipeline/maps/image.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <system_error>

#include "pipeline/error.h"

namespace furrow::pipeline {
namespace {

constexpr int kMaxSide = 16384;  // of a texture on the GPUs furrow is for

// OpenImageIO's messages may run over several lines.
std::string firstLine(const std::string& text) {
  const std::string line = text.substr(0, text.find('\n'));
  return line.empty() ? "unknown reason" : line;
}

}  // namespace

Image readImage(const std::filesystem::path& file) {
  // Without it a fourth channel is taken for alpha and the other three are multiplied by it.
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);
  const auto input = OIIO::ImageInput::open(file.string(), &config);
  if (!input) {
    throw Error(Exit::kBadData, file.string(),
                "it cannot be read as an image (" + firstLine(OIIO::geterror()) + ")",
                "give a PNG, JPEG, TGA, TIFF or EXR file");
  }
  const OIIO::ImageSpec& spec = input->spec();
  if (spec.width < 1 || spec.height < 1 || spec.width > kMaxSide || spec.height > kMaxSide ||
      spec.depth > 1 || spec.nchannels < 1 || spec.nchannels > 4) {
    throw Error(Exit::kBadData, file.string(),
                "the image is " + std::to_string(spec.width) + " x " + std::to_string(spec.height) +
                    " with " + std::to_string(spec.nchannels) + " channels",
                "give one of at most 16384 x 16384 texels and 1 to 4 channels");
  }
  Image image;
  image.width = static_cast<uint32_t>(spec.width);
  image.height = static_cast<uint32_t>(spec.height);
  image.channels = static_cast<uint32_t>(spec.nchannels);
  image.pixels.resize(static_cast<size_t>(image.width) * image.height * image.channels);
  bool read = false;
  if (spec.format.is_floating_point()) {
    read = input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, image.pixels.data());
  } else {
    // OpenImageIO multiplies by 1 / 255, which is not v / 255 to the last bit.
    std::vector<uint16_t> values(image.pixels.size());
    read = input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT16, values.data());
    std::transform(values.begin(), values.end(), image.pixels.begin(),
                   [](uint16_t v) { return static_cast<float>(v) / 65535.0f; });
  }
  if (!read) {
    const std::string reason = firstLine(input->geterror());
    throw Error(Exit::kBadData, file.string(), "the image is damaged (" + reason + ")", "export it again");
  }
  if (!std::all_of(image.pixels.begin(), image.pixels.end(), [](float v) { return std::isfinite(v); })) {
    throw Error(Exit::kBadData, file.string(), "the image holds values that are not finite",
                "export it again");
  }
  return image;
}

void writeImage(const std::filesystem::path& file, const Image& image) {
  const auto fail = [&](const std::string& reason) {
    throw Error(Exit::kEnvironment, file.string(), "the image cannot be written (" + firstLine(reason) + ")",
                "check the folder, the disk and that the name ends in .png");
  };
  const auto output = OIIO::ImageOutput::create(file.string());
  if (!output) {
    fail(OIIO::geterror());
  }
  std::vector<uint8_t> bytes(image.pixels.size());
  std::transform(image.pixels.begin(), image.pixels.end(), bytes.begin(), [](float v) {
    return static_cast<uint8_t>(std::lround(std::clamp(v, 0.0f, 1.0f) * 255.0f));
  });
  OIIO::ImageSpec spec(static_cast<int>(image.width), static_cast<int>(image.height),
                       static_cast<int>(image.channels), OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:UnassociatedAlpha", 1);

  std::filesystem::path temporary = file;
  temporary += ".part";
  const bool written = output->open(temporary.string(), spec) &&
                       output->write_image(OIIO::TypeDesc::UINT8, bytes.data()) && output->close();
  std::error_code error;
  if (written) {
    std::filesystem::rename(temporary, file, error);
  }
  if (!written || error) {
    const std::string reason = written ? error.message() : output->geterror();
    std::filesystem::remove(temporary, error);
    fail(reason);
  }
}

Image resize(const Image& image, uint32_t width, uint32_t height) {
  // One axis after the other; a triangle as wide as the coarser of the two grids, so that shrinking averages
  // and growing interpolates.
  const auto along = [](const Image& in, uint32_t size, bool rows) {
    const uint32_t old_size = rows ? in.height : in.width;
    Image out;
    out.width = rows ? in.width : size;
    out.height = rows ? size : in.height;
    out.channels = in.channels;
    out.pixels.assign(static_cast<size_t>(out.width) * out.height * out.channels, 0.0f);
    const double scale = static_cast<double>(old_size) / size;
    const double radius = std::max(scale, 1.0);
    for (uint32_t i = 0; i < size; ++i) {
      const double centre = (i + 0.5) * scale - 0.5;
      const auto first = static_cast<int64_t>(std::ceil(centre - radius));
      const auto last = static_cast<int64_t>(std::floor(centre + radius));
      double total = 0.0;
      for (int64_t j = first; j <= last; ++j) {
        total += 1.0 - std::abs(static_cast<double>(j) - centre) / radius;
      }
      for (int64_t j = first; j <= last; ++j) {
        const auto weight =
            static_cast<float>((1.0 - std::abs(static_cast<double>(j) - centre) / radius) / total);
        const auto from = static_cast<uint32_t>(std::clamp<int64_t>(j, 0, old_size - 1));
        const uint32_t others = rows ? in.width : in.height;
        for (uint32_t k = 0; k < others; ++k) {
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
  if (image.width == width && image.height == height) {
    return image;
  }
  return along(along(image, width, false), height, true);
}

}  // namespace furrow::pipeline
