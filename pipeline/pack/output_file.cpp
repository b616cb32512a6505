#include "pipeline/pack/output_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <string>

#include "pipeline/error.h"

namespace furrow::pipeline {
namespace {

constexpr std::string_view kSuffix = ".tmp";

bool writeAll(int descriptor, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes = bytes.subspan(static_cast<size_t>(written));
  }
  return true;
}

// A temporary that has a name only once it is linked; open() and whatever follows tell faults by errno.
class Temporary {
 public:
  explicit Temporary(const std::filesystem::path& file) : file_(file.string()) {
    const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
    descriptor_ = ::open(folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
    if (descriptor_ >= 0)
      ::flock(descriptor_, LOCK_EX | LOCK_NB);
    else if (errno == EOPNOTSUPP || errno == EISDIR || errno == EINVAL)
      openNamed();
  }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  ~Temporary() {
    const int error = errno;
    if (named_) ::unlink(name_.c_str());
    if (descriptor_ >= 0) ::close(descriptor_);
    errno = error;
  }

  bool becomes(const std::filesystem::path& file, std::span<const std::byte> bytes) {
    if (descriptor_ < 0 || !writeAll(descriptor_, bytes) || ::fsync(descriptor_) != 0) return false;
    if (!named_) {
      const std::string self = "/proc/self/fd/" + std::to_string(descriptor_);
      nextName();
      if (::linkat(AT_FDCWD, self.c_str(), AT_FDCWD, name_.c_str(), AT_SYMLINK_FOLLOW) != 0) return false;
      named_ = true;
    }
    if (::rename(name_.c_str(), file.c_str()) != 0) return false;
    named_ = false;
    return true;
  }

 private:
  void nextName() {
    static std::atomic<uint32_t> count = 0;
    name_ = file_ + '.' + std::to_string(::getpid()) + '-' + std::to_string(count++);
    name_ += kSuffix;
  }

  // On a file system without nameless files: until it is locked, another writer may take it for a leftover.
  void openNamed() {
    struct stat status {};
    do {
      if (named_) ::close(descriptor_);
      nextName();
      descriptor_ = ::open(name_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      named_ = descriptor_ >= 0;
      if (named_) ::flock(descriptor_, LOCK_EX);
    } while (named_ && ::fstat(descriptor_, &status) == 0 && status.st_nlink == 0);
  }

  std::string file_, name_;
  int descriptor_ = -1;
  bool named_ = false;
};

// Removes what killed writers of `file` left: temporaries that nobody holds a lock on.
void removeLeftovers(const std::filesystem::path& file) {
  const std::string prefix = file.filename().string() + '.';
  std::error_code error;
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(prefix) || !name.ends_with(kSuffix) || name.size() < prefix.size() + kSuffix.size())
      continue;
    const std::string number = name.substr(prefix.size(), name.size() - prefix.size() - kSuffix.size());
    if (number.empty() || number.find_first_not_of("0123456789-") != std::string::npos) continue;
    const int descriptor = ::open(entry.path().c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
    if (descriptor < 0) continue;
    if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0) ::unlink(entry.path().c_str());
    ::close(descriptor);
  }
}

bool writeThrough(const std::filesystem::path& file, std::span<const std::byte> bytes) {
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_CLOEXEC);
  const bool written = descriptor >= 0 && writeAll(descriptor, bytes);
  const int error = errno;
  if (descriptor >= 0) ::close(descriptor);
  errno = error;
  return written;
}

// Follows links, to what is not there yet, too.
bool replace(std::filesystem::path file, std::span<const std::byte> bytes) {
  constexpr int kMostLinks = 40;  // as the kernel has it
  std::error_code ignored;
  for (int i = 0; std::filesystem::is_symlink(file, ignored); ++i) {
    errno = ELOOP;
    if (i == kMostLinks) return false;
    file = file.parent_path() / std::filesystem::read_symlink(file, ignored);
  }
  removeLeftovers(file);
  return Temporary(file).becomes(file, bytes);
}

}  // namespace

void writeFile(const std::filesystem::path& file, std::span<const std::byte> bytes) {
  std::error_code ignored;
  const auto status = std::filesystem::status(file, ignored);
  errno = EISDIR;
  if (std::filesystem::is_directory(status) ||
      !(std::filesystem::is_other(status) ? writeThrough(file, bytes) : replace(file, bytes)))
    throw Error(Exit::kEnvironment, file.string(),
                std::string("cannot be written (") + std::strerror(errno) + ")",
                "choose a folder that exists, may be written to and has room");
}

}  // namespace furrow::pipeline
