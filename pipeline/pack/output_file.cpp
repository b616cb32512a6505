#include "pipeline/pack/output_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "pipeline/error.h"

namespace furrow::pipeline {
namespace {

bool writeAll(int descriptor, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes = bytes.subspan(static_cast<size_t>(written));
  }
  return true;
}

}  // namespace

void writeFile(const std::filesystem::path& file, std::span<const std::byte> bytes) {
  const auto fail = [&] {
    throw Error(Exit::kEnvironment, file.string(),
                std::string("cannot be written (") + std::strerror(errno) + ")",
                "choose a folder that exists, may be written to and has room");
  };
  if (std::filesystem::is_directory(file)) {
    errno = EISDIR;
    fail();
  }
  const std::filesystem::path temporary = file.string() + "." + std::to_string(::getpid()) + ".tmp";
  const int descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0) fail();
  bool done = writeAll(descriptor, bytes) && ::fsync(descriptor) == 0;
  int error = errno;
  if (::close(descriptor) != 0 && done) {
    done = false;
    error = errno;
  }
  if (done && ::rename(temporary.c_str(), file.c_str()) != 0) {
    done = false;
    error = errno;
  }
  if (done) return;
  ::unlink(temporary.c_str());
  errno = error;
  fail();
}

}  // namespace furrow::pipeline
