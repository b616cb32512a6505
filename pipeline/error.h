#pragma once

// What the pipeline throws when a file, a recipe or the machine will not do.

#include <stdexcept>
#include <string>

namespace furrow::pipeline {

// Exit statuses of the tools.
enum class Exit : int { kDone = 0, kBadData = 1, kBadUsage = 2, kEnvironment = 3 };

// what() is the one line the tools print behind "furrow: ": "FILE: what is wrong: what to do".
class Error : public std::runtime_error {
 public:
  Error(Exit exit, const std::string& file, const std::string& what_is_wrong, const std::string& what_to_do)
      : std::runtime_error(file + ": " + what_is_wrong + ": " + what_to_do), exit_(exit) {}
  Exit exit() const { return exit_; }

 private:
  Exit exit_;
};

}  // namespace furrow::pipeline
