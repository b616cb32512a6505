#include "pipeline/maps/image.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <memory>
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

// An image file that has been opened and is of a size furrow takes.
class ImageFile {
 public:
  explicit ImageFile(const std::filesystem::path& file) : file_(file) {
    // Without it a fourth channel is taken for alpha and the other three are multiplied by it.
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);
    input_ = OIIO::ImageInput::open(file.string(), &config);
    if (!input_) {
      throw Error(Exit::kBadData, file.string(),
                  "it cannot be read as an image (" + firstLine(OIIO::geterror()) + ")",
                  "give a PNG, JPEG, TGA, TIFF or EXR file");
    }
    const OIIO::ImageSpec& s = spec();
    if (s.width < 1 || s.height < 1 || s.width > kMaxSide || s.height > kMaxSide || s.depth > 1 ||
        s.nchannels < 1 || s.nchannels > 4) {
      throw Error(Exit::kBadData, file.string(),
                  "the image is " + std::to_string(s.width) + " x " + std::to_string(s.height) + " with " +
                      std::to_string(s.nchannels) + " channels",
                  "give one of at most 16384 x 16384 texels and 1 to 4 channels");
    }
  }

  const OIIO::ImageSpec& spec() const { return input_->spec(); }

  template <class AnyImage>
  AnyImage sized() const {
    AnyImage image;
    image.width = static_cast<uint32_t>(spec().width);
    image.height = static_cast<uint32_t>(spec().height);
    image.channels = static_cast<uint32_t>(spec().nchannels);
    image.pixels.resize(static_cast<size_t>(image.width) * image.height * image.channels);
    return image;
  }

  void read(OIIO::TypeDesc type, void* pixels) {
    if (!input_->read_image(0, 0, 0, spec().nchannels, type, pixels)) {
      throw Error(Exit::kBadData, file_.string(),
                  "the image is damaged (" + firstLine(input_->geterror()) + ")", "export it again");
    }
  }

 private:
  const std::filesystem::path& file_;
  std::unique_ptr<OIIO::ImageInput> input_;
};

}  // namespace

Image readImage(const std::filesystem::path& file) {
  ImageFile input(file);
  Image image = input.sized<Image>();
  if (input.spec().format.is_floating_point()) {
    input.read(OIIO::TypeDesc::FLOAT, image.pixels.data());
  } else {
    // OpenImageIO multiplies by 1 / 255, which is not v / 255 to the last bit.
    std::vector<uint16_t> values(image.pixels.size());
    input.read(OIIO::TypeDesc::UINT16, values.data());
    std::transform(values.begin(), values.end(), image.pixels.begin(),
                   [](uint16_t v) { return static_cast<float>(v) / 65535.0f; });
  }
  if (!std::all_of(image.pixels.begin(), image.pixels.end(), [](float v) { return std::isfinite(v); })) {
    throw Error(Exit::kBadData, file.string(), "the image holds values that are not finite",
                "export it again");
  }
  return image;
}

ByteImage readByteImage(const std::filesystem::path& file) {
  ImageFile input(file);
  if (input.spec().format.is_floating_point()) {
    return toBytes(readImage(file));
  }
  ByteImage image = input.sized<ByteImage>();
  input.read(OIIO::TypeDesc::UINT8, image.pixels.data());
  return image;
}

ByteImage toBytes(const Image& image) {
  ByteImage bytes{image.width, image.height, image.channels, std::vector<uint8_t>(image.pixels.size())};
  std::transform(image.pixels.begin(), image.pixels.end(), bytes.pixels.begin(), [](float v) {
    return static_cast<uint8_t>(std::lround(std::clamp(v, 0.0f, 1.0f) * 255.0f));
  });
  return bytes;
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
  const ByteImage bytes = toBytes(image);
  OIIO::ImageSpec spec(static_cast<int>(image.width), static_cast<int>(image.height),
                       static_cast<int>(image.channels), OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:UnassociatedAlpha", 1);

  std::filesystem::path temporary = file;
  temporary += ".part";
  const bool written = output->open(temporary.string(), spec) &&
                       output->write_image(OIIO::TypeDesc::UINT8, bytes.pixels.data()) && output->close();
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
