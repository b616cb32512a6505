#pragma once

// Runs the real furrow tool (FURROW_TOOL) and keeps what it said.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include "tests/unit/gltf_builder.h"

extern char** environ;

namespace furrow::test {

#if defined(__SANITIZE_ADDRESS__)
inline constexpr bool kAddressSanitizer = true;
#elif defined(__has_feature)
inline constexpr bool kAddressSanitizer = __has_feature(address_sanitizer);
#else
inline constexpr bool kAddressSanitizer = false;
#endif

inline std::string readText(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// Calls job(i) for every i below `count`, a few at once: most of a run of the tool is its start, and ctest
// runs as many tests beside this one as there are cores.
template <typename Job>
void forEachInParallel(size_t count, const Job& job) {
  std::atomic<size_t> next = 0;
  const auto work = [&] {
    for (size_t i = next++; i < count; i = next++) job(i);
  };
  std::vector<std::jthread> threads(std::min<size_t>(count, 4));
  for (std::jthread& thread : threads) thread = std::jthread(work);
}

// Whether Python and its jsonschema are there to ask, and whether the file is valid by a schema of docs/.
inline bool knowsSchemas() {
  return std::system("python3 -c 'import jsonschema' 2>/dev/null") == 0;
}
inline bool validBySchema(const std::filesystem::path& schema, const std::filesystem::path& file) {
  const std::string check =
      "python3 -c 'import json, sys, jsonschema\n"
      "schema = json.load(open(sys.argv[1]))\n"
      "jsonschema.Draft7Validator.check_schema(schema)\n"
      "valid = jsonschema.Draft7Validator(schema).is_valid(json.load(open(sys.argv[2])))\n"
      "sys.exit(0 if valid else 9)' ";
  const int status = std::system((check + "'" + schema.string() + "' '" + file.string() + "'").c_str());
  EXPECT_TRUE(status == 0 || WEXITSTATUS(status) == 9) << "Python failed";
  return status == 0;
}

struct Outcome {
  int status = -1;  // of the exit; 128 + the signal that ended it
  std::string out, err;
};

// Every test has a folder of its own: sources in folder(), the tool's output in output(), which is empty at
// first.
class ToolTest : public ::testing::Test {
 protected:
  ToolTest() {
    // AddressSanitizer's guess at where modules' thread-local variables lie ends in a fault of its own.
    if (kAddressSanitizer) ::setenv("ASAN_OPTIONS", "intercept_tls_get_addr=0", 0);
    std::filesystem::create_directory(output());
    std::filesystem::create_directory(folder() / "said");
  }

  std::filesystem::path folder() const { return scratch_.path(); }
  std::filesystem::path output() const { return folder() / "output"; }

  std::filesystem::path write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder() / name, std::ios::binary) << bytes;
    return folder() / name;
  }

  // A library to be preloaded, in a folder without spaces: the loader takes them for ends of names.
  std::string preloaded(const std::filesystem::path& library) const {
    const std::filesystem::path link = folder() / library.filename();
    std::error_code is_there;
    std::filesystem::create_symlink(library, link, is_there);
    return link;
  }

  Outcome run(const std::vector<std::string>& arguments, const std::string& tool = FURROW_TOOL) const {
    const std::string said = folder() / "said" / std::to_string(runs_++), out = said + ".out",
                      err = said + ".err";
    const pid_t child = start(arguments, tool, out, err);
    Outcome outcome;
    int status = 0;
    if (child < 0 || waitpid(child, &status, 0) != child) {
      ADD_FAILURE() << tool << " did not start";
      return outcome;
    }
    outcome.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    outcome.out = readText(out);
    outcome.err = readText(err);
    return outcome;
  }

  // The process, to be waited for; -1 if there is none.
  pid_t start(const std::vector<std::string>& arguments, const std::string& tool = FURROW_TOOL,
              const std::string& out = "/dev/null", const std::string& err = "/dev/null") const {
    std::vector<std::string> words = {tool};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, 1, out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    posix_spawn_file_actions_addopen(&actions, 2, err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    pid_t child = 0;
    const int fault = posix_spawn(&child, tool.c_str(), &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    return fault == 0 ? child : -1;
  }

  // The tool refused with this status and one line that names `named`.
  void expectOneLine(const Outcome& outcome, int status, const std::string& named) const {
    EXPECT_EQ(outcome.status, status) << outcome.err;
    EXPECT_TRUE(outcome.err.starts_with("furrow: ")) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_TRUE(outcome.err.ends_with('\n')) << outcome.err;
    EXPECT_NE(outcome.err.find(named), std::string::npos) << outcome.err << "does not name " << named;
    EXPECT_EQ(outcome.out, "");
  }

  void expectNothingLeft() const {
    for (const auto& entry : std::filesystem::directory_iterator(output()))
      ADD_FAILURE() << entry.path() << " was left behind";
    for (const auto& entry : std::filesystem::directory_iterator(folder()))
      EXPECT_NE(entry.path().extension(), ".tmp") << entry.path() << " was left behind";
  }

  void expectRefused(const Outcome& outcome, int status, const std::string& named) const {
    expectOneLine(outcome, status, named);
    expectNothingLeft();
  }

 private:
  ScratchFolder scratch_;
  mutable std::atomic<size_t> runs_ = 0;
};

}  // namespace furrow::test
