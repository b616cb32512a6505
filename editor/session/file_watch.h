#pragma once

// Which of some files changed on disk, by their times and sizes.

#include <filesystem>
#include <map>
#include <vector>

namespace furrow::editor {

class FileWatch {
 public:
  // From now on these files, as they are now; those already watched keep the state that is known of them.
  void watch(const std::vector<std::filesystem::path>& files);
  void forget(const std::filesystem::path& file);  // its state until now: it was written by ourselves

  // The files that changed, came or went since they were last looked at.
  std::vector<std::filesystem::path> changed();

 private:
  struct State {
    std::filesystem::file_time_type time{};
    uintmax_t size = 0;
    bool operator==(const State&) const = default;
  };
  static State stateOf(const std::filesystem::path& file);

  std::map<std::filesystem::path, State> states_;
};

}  // namespace furrow::editor
