#include "editor/session/samples.h"

#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <system_error>

namespace furrow::editor {

namespace fs = std::filesystem;

Samples::Samples(fs::path program, fs::path folder)
    : program_(std::move(program)), folder_(std::move(folder)) {}

Samples::~Samples() {
  if (!making()) return;
  kill(process_, SIGTERM);
  waitpid(process_, nullptr, 0);
  std::error_code ignored;
  fs::remove_all(unfinished_, ignored);
}

fs::path Samples::usualProgram() {
  std::error_code error;
  return fs::read_symlink("/proc/self/exe", error).parent_path() / "furrow_content";
}

fs::path Samples::usualFolder() {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  const fs::path base = cache && *cache ? fs::path(cache)
                        : home          ? fs::path(home) / ".cache"
                                        : fs::temp_directory_path();
  return base / "furrow" / ("samples-" FURROW_VERSION);
}

void Samples::ask(const std::string& name) {
  wanted_ = name;
  std::error_code error;
  if (making() || fs::exists(fileOf(name), error)) return;
  fs::create_directories(folder_.parent_path(), error);
  std::string program = program_.string(), folder = folder_.string() + ".XXXXXX";
  if (!mkdtemp(folder.data())) return;
  unfinished_ = folder;
  char* arguments[] = {program.data(), folder.data(), nullptr};
  if (posix_spawn(&process_, program.c_str(), nullptr, nullptr, arguments, environ) == 0) return;
  process_ = 0;
  fs::remove_all(unfinished_, error);
}

int Samples::made() const {
  int files = 0;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(unfinished_, error))
    files += entry.path().extension() == ".glb";
  return files;
}

std::optional<Samples::Result> Samples::take() {
  if (wanted_.empty()) return std::nullopt;
  std::error_code error;
  if (making()) {
    int status = 0;
    if (waitpid(process_, &status, WNOHANG) == 0) return std::nullopt;
    process_ = 0;
    // Whole or not at all; in place of a folder that lost some, and not of one that somebody else has made
    // meanwhile.
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
      if (!fs::exists(fileOf(wanted_), error)) fs::remove_all(folder_, error);
      fs::rename(unfinished_, folder_, error);
    }
    fs::remove_all(unfinished_, error);
  }
  const Result result{fileOf(wanted_), {}};
  wanted_.clear();
  if (fs::exists(result.file, error)) return result;
  if (!fs::exists(program_, error))
    return Result{result.file,
                  program_.string() + ": the samples cannot be made: put furrow_content beside the editor"};
  return Result{result.file,
                folder_.string() +
                    ": the samples cannot be made there: set XDG_CACHE_HOME to a folder that may be "
                    "written to and has room"};
}

}  // namespace furrow::editor
