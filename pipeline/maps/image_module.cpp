#include "pipeline/maps/image_module.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <string>
#include <vector>

namespace furrow::pipeline {
namespace {

// OpenImageIO's messages may run over several lines.
const char* fault(const std::string& text) {
  thread_local std::string line;
  line = text.substr(0, text.find('\n'));
  return line.empty() ? "unknown reason" : line.c_str();
}

// libpng writes its errors to stderr, beside those that OpenImageIO hands on. While one of these lives,
// nothing gets there.
class Silence {
 public:
  Silence() {
    const std::lock_guard lock(mutex_);
    if (users_++ > 0) return;
    std::fflush(stderr);
    stderr_ = ::dup(STDERR_FILENO);
    const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
    if (stderr_ >= 0 && nowhere >= 0) ::dup2(nowhere, STDERR_FILENO);
    if (nowhere >= 0) ::close(nowhere);
  }
  ~Silence() {
    const std::lock_guard lock(mutex_);
    if (--users_ > 0 || stderr_ < 0) return;
    ::dup2(stderr_, STDERR_FILENO);
    ::close(stderr_);
  }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  static inline std::mutex mutex_;
  static inline int users_ = 0, stderr_ = -1;
};

// OpenImageIO multiplies by alpha what WebP has not, whatever it is told.
template <typename T>
void divideByAlpha(T* pixels, size_t count, float whole) {
  for (T* p = pixels; p != pixels + 4 * count; p += 4)
    for (int c = 0; c < 3 && p[3] > T(0); ++c) {
      const float value = std::min(static_cast<float>(p[c]) * whole / static_cast<float>(p[3]), whole);
      p[c] = std::is_integral_v<T> ? static_cast<T>(value + 0.5f) : static_cast<T>(value);
    }
}

ImageModule::Reading read(const ImageModule::Source& source, bool bytes, ImageModule::Place place,
                          void* context) {
  // Without it a fourth channel is taken for alpha and the other three are multiplied by it.
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);
  const Silence silence;
  OIIO::Filesystem::IOMemReader memory(const_cast<void*>(source.data), source.size);
  const auto input = OIIO::ImageInput::create(source.name, true, &config, source.data ? &memory : nullptr);
  if (!input) return {false, fault(OIIO::geterror())};
  const OIIO::ImageSpec& spec = input->spec();
  void* const pixels = place(context, spec.width, spec.height, spec.depth, spec.nchannels);
  if (!pixels) return {true, "refused"};
  bool done = false;
  if (bytes || spec.format.is_floating_point()) {
    const OIIO::TypeDesc type = bytes ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc::FLOAT;
    done = input->read_image(0, 0, 0, spec.nchannels, type, pixels);
  } else {
    // OpenImageIO multiplies by 1 / 255, which is not v / 255 to the last bit.
    std::vector<uint16_t> values(static_cast<size_t>(spec.width) * spec.height * spec.nchannels);
    done = input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT16, values.data());
    std::transform(values.begin(), values.end(), static_cast<float*>(pixels),
                   [](uint16_t v) { return static_cast<float>(v) / 65535.0f; });
  }
  const size_t count = size_t{static_cast<unsigned>(spec.width)} * static_cast<unsigned>(spec.height);
  if (done && spec.nchannels == 4 && std::strcmp(input->format_name(), "webp") == 0) {
    if (bytes)
      divideByAlpha(static_cast<uint8_t*>(pixels), count, 255.0f);
    else
      divideByAlpha(static_cast<float*>(pixels), count, 1.0f);
  }
  return {true, done ? nullptr : fault(input->geterror())};
}

}  // namespace
}  // namespace furrow::pipeline

extern "C" [[gnu::visibility("default")]] furrow::pipeline::ImageModule furrowImageModule();

furrow::pipeline::ImageModule furrowImageModule() {
  return {furrow::pipeline::read};
}
