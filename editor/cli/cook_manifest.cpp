#include "editor/cli/cook_manifest.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <mutex>
#include <optional>
#include <vector>

#include "editor/cli/open_asset.h"
#include "editor/cli/outputs.h"
#include "pipeline/cook/manifest.h"
#include "pipeline/error.h"
#include "pipeline/pack/output_file.h"
#include "pipeline/parallel.h"

extern char** environ;

namespace furrow::cli {
namespace {

using pipeline::Error;
using pipeline::Exit;
using pipeline::ManifestAsset;

struct ChildOutcome {
  int status = 0;     // as waitpid() tells it
  std::string lines;  // what it printed
};

ChildOutcome runSelf(std::vector<std::string> words) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const auto fail = [](int error) {
    throw Error(Exit::kEnvironment, "furrow",
                std::string("no process can be started (") + std::strerror(error) + ")",
                "close other programs or give a smaller -j");
  };
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) fail(errno);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
  pid_t child = 0;
  const int fault = ::posix_spawn(&child, "/proc/self/exe", &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  ::close(ends[1]);
  ChildOutcome outcome;
  std::array<char, 4096> buffer;
  while (fault == 0) {
    const ssize_t count = ::read(ends[0], buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    outcome.lines.append(buffer.data(), static_cast<size_t>(count));
  }
  ::close(ends[0]);
  if (fault != 0) fail(fault);
  while (::waitpid(child, &outcome.status, 0) < 0 && errno == EINTR) {
  }
  return outcome;
}

bool holds(const std::filesystem::path& file, std::span<const std::byte> bytes) {
  std::error_code error;
  if (std::filesystem::file_size(file, error) != bytes.size() || error) return false;
  std::ifstream in(file, std::ios::binary);
  return std::equal(std::istreambuf_iterator<char>(in), {}, reinterpret_cast<const char*>(bytes.data()),
                    reinterpret_cast<const char*>(bytes.data()) + bytes.size());
}

bool isNewer(const std::filesystem::path& file, std::vector<std::filesystem::path> inputs) {
  std::error_code error;
  inputs.push_back(std::filesystem::read_symlink("/proc/self/exe", error));  // build rules depend on the tool
  const auto time = std::filesystem::last_write_time(file, error);
  return !error && std::all_of(inputs.begin(), inputs.end(), [&](const std::filesystem::path& input) {
    return std::filesystem::last_write_time(input, error) < time && !error;
  });
}

// Writes the asset, unless the file holds these bytes already and is newer than every input and this program:
// then nothing that is made of it need be made again. Returns whether it was written.
bool deliver(const std::filesystem::path& output, std::span<const std::byte> bytes,
             const std::vector<std::filesystem::path>& inputs) {
  if (isNewer(output, inputs) && holds(output, bytes)) return false;
  pipeline::writeFile(output, bytes);
  return true;
}

class ManifestCook {
 public:
  explicit ManifestCook(const ManifestOptions& options)
      : options_(options),
        assets_(pipeline::readManifest(options.manifest)),
        files_(assets_.size()),
        faults_(assets_.size()) {
    options_.jobs = std::min(options_.jobs, static_cast<uint32_t>(assets_.size()));
  }

  void run() {
    const auto begin = std::chrono::steady_clock::now();
    const auto count = static_cast<uint32_t>(assets_.size());
    pipeline::parallelFor(count, options_.jobs, [&](uint32_t i) { listFiles(i); });
    if (!options_.depfile.empty()) writeDepfile();
    pipeline::parallelFor(count, options_.jobs, [&](uint32_t i) { cook(i); });
    clearLine();

    std::string done;
    const auto tell = [&](uint32_t number, const char* what) {
      if (number > 0) done += (done.empty() ? "" : ", ") + std::to_string(number) + what;
    };
    tell(cooked_, " cooked");
    tell(cached_, " from the cache");
    tell(current_, " up to date");
    if (failed_ > 0)
      throw Error(Exit::kBadData, options_.manifest.string(),
                  std::to_string(failed_) + " of " + std::to_string(count) + " assets failed" +
                      (done.empty() ? "" : " (" + done + ")"),
                  "see the lines above");
    if (!options_.quiet)
      std::fprintf(stderr, "furrow: %s: %s, %.2f s\n", options_.manifest.c_str(), done.c_str(),
                   std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }

 private:
  void listFiles(uint32_t i) {
    try {
      files_[i] = pipeline::filesOf(assets_[i].request);
    } catch (const Error& error) {
      faults_[i] = error.what();
    }
  }

  std::vector<std::filesystem::path> dependencies(uint32_t i) const {
    std::vector<std::filesystem::path> all = files_[i];
    all.push_back(options_.manifest);
    return all;
  }

  void writeDepfile() const {
    std::string rules;
    for (uint32_t i = 0; i < assets_.size(); ++i) {
      refuseToOverwrite({options_.depfile, assets_[i].output}, dependencies(i));
      rules += makeRule(assets_[i].output, dependencies(i));
    }
    writeText(options_.depfile, rules);
  }

  void cook(uint32_t i) {
    const ManifestAsset& asset = assets_[i];
    started(asset);
    std::string lines;
    uint32_t* outcome = &failed_;
    try {
      std::error_code ignored;
      std::filesystem::create_directories(asset.output.parent_path(), ignored);
      if (!faults_[i].empty()) {
        lines = "furrow: " + faults_[i] + '\n';
      } else if (const std::optional<bool> written = takeFromCache(i, lines)) {
        outcome = *written ? &cached_ : &current_;
      } else {
        ChildOutcome child = runSelf(arguments(asset));
        lines = std::move(child.lines);
        if (child.status == 0) outcome = &cooked_;
        if (WIFSIGNALED(child.status))
          lines += "furrow: " + asset.output.string() + ": its cook was ended by signal " +
                   std::to_string(WTERMSIG(child.status)) + ": run 'furrow cook' on it alone\n";
      }
    } catch (const Error& error) {
      lines = std::string("furrow: ") + error.what() + '\n';
    }
    finished(asset, *outcome, lines);
  }

  // Whether the output had to be written; nullopt: it must be cooked.
  std::optional<bool> takeFromCache(uint32_t i, std::string& lines) const {
    if (options_.cache.empty()) return std::nullopt;
    const ManifestAsset& asset = assets_[i];
    const auto found = pipeline::CookCache(options_.cache).find(pipeline::cookKey(asset.request, files_[i]));
    if (!found) return std::nullopt;
    refuseToOverwrite({asset.output}, files_[i]);
    const bool written = deliver(asset.output, found->bytes, dependencies(i));
    if (written && !options_.quiet) lines = warningLines(asset.request.source.name(), found->warnings);
    return written;
  }

  std::vector<std::string> arguments(const ManifestAsset& asset) const {
    const pipeline::CookRequest& request = asset.request;
    std::vector<std::string> words = {"furrow", "cook"};
    const auto add = [&](const char* option, const std::string& value) {
      words.push_back(std::string(option) + '=' + value);
    };
    add("--output", asset.output.string());
    add("--threads", std::to_string((options_.threads + options_.jobs - 1) / options_.jobs));
    if (!request.recipe.empty()) add("--recipe", request.recipe.string());
    if (request.geometry == pipeline::GeometryCodec::kRaw) add("--geometry", "raw");
    if (!options_.cache.empty()) add("--cache", options_.cache.string());
    if (options_.quiet) words.push_back("--quiet");
    if (!request.source.pattern.empty()) {
      add("--sequence", request.source.pattern.string());
      char fps[32];
      std::snprintf(fps, sizeof fps, "%.17g", request.source.fps);
      add("--fps", fps);
    }
    if (!request.source.base.empty()) words.insert(words.end(), {"--", request.source.base.string()});
    return words;
  }

  void started(const ManifestAsset& asset) {
    const std::lock_guard lock(mutex_);
    cooking_.push_back(asset.output.filename().string());
    drawLine();
  }

  void finished(const ManifestAsset& asset, uint32_t& outcome, const std::string& lines) {
    const std::lock_guard lock(mutex_);
    ++outcome;
    cooking_.erase(std::find(cooking_.begin(), cooking_.end(), asset.output.filename().string()));
    clearLine();
    std::fputs(lines.c_str(), stderr);
    drawLine();
  }

  void clearLine() const {
    if (terminal_) std::fputs("\r\033[K", stderr);
  }

  void drawLine() const {
    if (!terminal_) return;
    clearLine();
    std::fprintf(stderr, "furrow: %s: %u of %zu done", options_.manifest.filename().c_str(),
                 cooked_ + cached_ + current_ + failed_, assets_.size());
    if (!cooking_.empty()) std::fprintf(stderr, ", cooking %s", cooking_[0].c_str());
    if (cooking_.size() > 1) std::fprintf(stderr, " and %zu more", cooking_.size() - 1);
  }

  ManifestOptions options_;
  const std::vector<ManifestAsset> assets_;
  std::vector<std::vector<std::filesystem::path>> files_;  // that the cook may read
  std::vector<std::string> faults_;                        // why they cannot be told
  const bool terminal_ = !options_.quiet && ::isatty(STDERR_FILENO);
  std::mutex mutex_;
  std::vector<std::string> cooking_;
  uint32_t cooked_ = 0, cached_ = 0, current_ = 0, failed_ = 0;
};

}  // namespace

void cookManifest(const ManifestOptions& options) {
  ManifestCook(options).run();
}

}  // namespace furrow::cli
