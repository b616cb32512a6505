// Files that appear whole or not at all, whoever writes them and whatever ends the writer.

#include "pipeline/pack/output_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdarg>
#include <functional>
#include <random>
#include <thread>
#include <utility>

#include "pipeline/error.h"
#include "tests/unit/gltf_builder.h"

namespace {

// Plays a file system on which every file has a name, and a machine on which much happens before it is
// locked.
bool all_have_names = false;
std::function<void()> before_lock;

}  // namespace

// In place of the C library's.
extern "C" int open(const char* path, int flags, ...) {
  if (all_have_names && (flags & O_TMPFILE) == O_TMPFILE) {
    errno = EOPNOTSUPP;
    return -1;
  }
  std::va_list more;
  va_start(more, flags);
  const mode_t mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(more, mode_t) : 0;
  va_end(more);
  return static_cast<int>(::syscall(SYS_openat, AT_FDCWD, path, flags, mode));
}

extern "C" int flock(int descriptor, int operation) noexcept {
  if (before_lock) std::exchange(before_lock, {})();
  return static_cast<int>(::syscall(SYS_flock, descriptor, operation));
}

namespace furrow::pipeline {
namespace {

class OutputFile : public ::testing::TestWithParam<bool> {
 protected:
  OutputFile() { all_have_names = GetParam(); }
  ~OutputFile() override { all_have_names = false; }

  std::filesystem::path folder() const { return scratch_.path(); }
  std::filesystem::path file() const { return folder() / "asset.furrow"; }

  // Megabytes of one byte.
  static std::vector<std::byte> of(int value) {
    return std::vector<std::byte>(size_t{1} << 20, std::byte(value));
  }

  // Whether the file is one of the writers' as a whole.
  bool isWhole() const {
    std::ifstream in(file(), std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(in), {});
    return bytes.size() == size_t{1} << 20 && bytes.find_first_not_of(bytes[0]) == std::string::npos;
  }

  bool hasNameless() const {
    const int nameless = ::open(folder().c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0600);
    if (nameless >= 0) ::close(nameless);
    return nameless >= 0;
  }

  std::vector<std::string> others() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder()))
      if (entry.path() != file()) names.push_back(entry.path().filename());
    return names;
  }

 private:
  test::ScratchFolder scratch_;
};

TEST_P(OutputFile, IsOldOrNewWhenItsWriterIsKilled) {
  writeFile(file(), of(0));
  std::mt19937 random(5);
  for (int kill = 0; kill < 60; ++kill) {
    const pid_t writer = ::fork();
    if (writer == 0)
      for (int value = 1;; ++value) writeFile(file(), of(value));
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 12000u));
    ::kill(writer, SIGKILL);
    ::waitpid(writer, nullptr, 0);
    ASSERT_TRUE(isWhole());
    ASSERT_LE(others().size(), 1u);
    writeFile(file(), of(0));
    ASSERT_TRUE(others().empty()) << "the next writer removes it";
  }
}

TEST_P(OutputFile, AKillAmidstWritingLeavesNoName) {
  writeFile(file(), of(0));
  const pid_t writer = ::fork();
  if (writer == 0) {
    const rlimit half{size_t{1} << 19, RLIM_INFINITY};
    ::setrlimit(RLIMIT_FSIZE, &half);
    ::signal(SIGXFSZ, SIG_DFL);
    writeFile(file(), of(1));
    ::_exit(0);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(writer, &status, 0), writer);
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_TRUE(isWhole());
  if (hasNameless()) {
    EXPECT_TRUE(others().empty());
  }
  writeFile(file(), of(0));
  EXPECT_TRUE(others().empty()) << "the next writer removes it";
}

TEST_P(OutputFile, AWriterWhoseFileIsTakenForALeftoverWritesAnother) {
  before_lock = [&] { writeFile(file(), of(2)); };
  writeFile(file(), of(1));
  EXPECT_TRUE(isWhole());
  EXPECT_EQ(std::ifstream(file()).get(), 1);
  EXPECT_TRUE(others().empty());
}

TEST_P(OutputFile, WritersAtOnceDoNotDisturbEachOther) {
  {
    std::vector<std::jthread> writers;
    for (int value = 1; value <= 6; ++value)
      writers.emplace_back([&, value] {
        for (int i = 0; i < 10; ++i) {
          writeFile(file(), of(value));
          EXPECT_TRUE(isWhole());
        }
      });
  }
  EXPECT_TRUE(others().empty());
}

TEST_P(OutputFile, OnlyLeftoversOfTheDeadAreRemoved) {
  const auto make = [&](const char* name) { std::ofstream(folder() / name) << "x"; };
  for (const char* name : {"asset.furrow.12-3.tmp", "asset.furrow.notes.tmp", "asset.furrow..tmp",
                           "asset.furrow.tmp", "other.furrow.1-1.tmp"})
    make(name);
  make("asset.furrow.77-0.tmp");
  const int alive = ::open((folder() / "asset.furrow.77-0.tmp").c_str(), O_WRONLY | O_CLOEXEC);
  ASSERT_EQ(::flock(alive, LOCK_EX), 0);
  writeFile(file(), of(1));
  EXPECT_EQ(others().size(), 5u);
  EXPECT_FALSE(std::filesystem::exists(folder() / "asset.furrow.12-3.tmp"));
  ::close(alive);
  writeFile(file(), of(1));
  EXPECT_EQ(others().size(), 4u);
  EXPECT_FALSE(std::filesystem::exists(folder() / "asset.furrow.77-0.tmp"));
}

// As /dev/null, which must not become a file.
TEST_P(OutputFile, APipeIsWrittenTo) {
  const std::filesystem::path pipe = folder() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  std::string read;
  std::jthread reader([&] {
    const int end = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    while (read.empty()) {
      char bytes[16];
      if (const ssize_t count = ::read(end, bytes, sizeof bytes); count > 0)
        read.assign(bytes, static_cast<size_t>(count));
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ::close(end);
  });
  const std::string text = "furrow";
  writeFile(pipe, std::as_bytes(std::span(text)));
  reader.join();
  EXPECT_EQ(read, text);
  EXPECT_TRUE(std::filesystem::is_fifo(pipe));
}

TEST_P(OutputFile, ALinkToNothingYetStaysALink) {
  const std::filesystem::path first = folder() / "first", second = folder() / "second";
  std::filesystem::create_symlink("second", first);
  std::filesystem::create_symlink(file().filename(), second);
  writeFile(first, of(1));
  EXPECT_TRUE(std::filesystem::is_symlink(first) && std::filesystem::is_symlink(second));
  EXPECT_TRUE(isWhole());

  for (const char* nowhere : {"missing/asset.furrow", "lost"}) {
    const std::filesystem::path lost = folder() / "lost";
    std::filesystem::remove(lost);
    std::filesystem::create_symlink(nowhere, lost);
    EXPECT_THROW(writeFile(lost, of(1)), Error) << nowhere;
    EXPECT_TRUE(std::filesystem::is_symlink(lost)) << nowhere;
  }
}

TEST_P(OutputFile, ALinkStaysALink) {
  std::filesystem::create_directory(folder() / "far");
  const std::filesystem::path target = folder() / "far" / "target";
  std::ofstream(target) << "old";
  std::filesystem::create_symlink(target, file());
  writeFile(file(), of(1));
  EXPECT_TRUE(std::filesystem::is_symlink(file()));
  EXPECT_EQ(std::filesystem::file_size(target), size_t{1} << 20);
}

INSTANTIATE_TEST_SUITE_P(Where, OutputFile, testing::Bool(), [](const auto& named) {
  return std::string(named.param ? "AllFilesHaveNames" : "FilesCanBeNameless");
});

}  // namespace
}  // namespace furrow::pipeline
