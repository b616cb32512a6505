#pragma once

// Which of some files changed on disk, by their times and sizes.

#include <filesystem>
#include <map>
#include <vector>

namespace furrow::editor {

struct FileState {
  std::filesystem::file_time_type time{};
  uintmax_t size = 0;
  bool operator==(const FileState&) const = default;
};
using FileStates = std::map<std::filesystem::path, FileState>;

FileState stateOf(const std::filesystem::path& file);  // all zero: it is not there

class FileWatch {
 public:
  // From now on these files, as they are now; those already watched keep the state that is known of them.
  void watch(const std::vector<std::filesystem::path>& files);
  // The same for states that were looked up before the files were read.
  void watchSince(const FileStates& states) { states_.insert(states.begin(), states.end()); }
  void forget(const std::filesystem::path& file);  // its state until now: it was written by ourselves

  // The files that changed, came or went since they were last looked at.
  std::vector<std::filesystem::path> changed();

 private:
  FileStates states_;
};

}  // namespace furrow::editor
