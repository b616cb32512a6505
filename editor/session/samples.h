#pragma once

// The demo characters, made on the user's machine when somebody first wants to see one.

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>

namespace furrow::editor {

class Samples {
 public:
  // `program`: furrow_content; `folder`: where the files go.
  Samples(std::filesystem::path program, std::filesystem::path folder);
  ~Samples();  // ends the program if it is at work, and leaves nothing of it
  Samples(const Samples&) = delete;
  Samples& operator=(const Samples&) = delete;

  // The program beside the running one and the user's cache.
  static std::filesystem::path usualProgram();
  static std::filesystem::path usualFolder();

  // Asks for NAME.glb; what is not there yet is made in the background.
  void ask(const std::string& name);
  bool making() const { return process_ > 0; }
  int made() const;  // of kCount files, while they are made
  static constexpr int kCount = 4;

  struct Result {
    std::filesystem::path file;
    std::string error;  // "FILE: what is wrong: what to do"; empty: `file` is there
  };
  std::optional<Result> take();  // once for every ask(), when it is answered

 private:
  std::filesystem::path fileOf(const std::string& name) const { return folder_ / (name + ".glb"); }

  std::filesystem::path program_, folder_, unfinished_;  // unfinished_: of this process alone
  std::string wanted_;
  pid_t process_ = 0;
};

}  // namespace furrow::editor
