#include "editor/session/file_watch.h"

#include <system_error>

namespace furrow::editor {

FileState stateOf(const std::filesystem::path& file) {
  std::error_code error;
  FileState state;
  state.time = std::filesystem::last_write_time(file, error);
  if (error) return {};
  state.size = std::filesystem::file_size(file, error);
  return error ? FileState{} : state;
}

void FileWatch::watch(const std::vector<std::filesystem::path>& files) {
  FileStates states;
  for (const std::filesystem::path& file : files) {
    const auto known = states_.find(file);
    states[file] = known == states_.end() ? stateOf(file) : known->second;
  }
  states_ = std::move(states);
}

void FileWatch::forget(const std::filesystem::path& file) {
  const auto known = states_.find(file);
  if (known != states_.end()) known->second = stateOf(file);
}

std::vector<std::filesystem::path> FileWatch::changed() {
  std::vector<std::filesystem::path> files;
  for (auto& [file, state] : states_) {
    const FileState now = stateOf(file);
    if (now == state) continue;
    state = now;
    files.push_back(file);
  }
  return files;
}

}  // namespace furrow::editor
