#pragma once

#include "editor/session/samples.h"
#include "editor/ui/actions.h"
#include "editor/ui/sample_pictures.h"
#include "editor/ui/state.h"

namespace furrow::editor::ui {

// Lists folders and files of some kinds; everything can be reached by keyboard. One is open at a time.
class FileDialog {
 public:
  // `title`: begins with what is done with the file. `kinds`: endings such as ".glb", empty: folders alone.
  // `saving`: the name may be that of a new file, and an existing one is asked about.
  void open(const std::string& title, const std::filesystem::path& start, std::vector<std::string> kinds,
            bool saving, std::function<void(const std::filesystem::path&)> chosen);
  void draw();

 private:
  void list();
  void accept(const std::filesystem::path& file);

  struct Entry {
    std::string name;
    bool folder;
  };
  std::string title_, name_, problem_, overwrite_;
  std::filesystem::path folder_;
  std::vector<std::string> kinds_;
  std::vector<Entry> entries_;
  std::function<void(const std::filesystem::path&)> chosen_;
  bool open_ = false, saving_ = false, appearing_ = false;
};

// What becomes of unsaved work, before State::leaving is done.
void drawLeaving(State& state);

// The recipe changed on disk while there are edits.
void drawConflict(State& state);

// Every action with its key.
void drawKeys(State& state, const std::vector<Action>& actions);

// What went wrong and what there is to know, latest last.
void drawProblems(State& state);

// The files that were opened last; their ids begin with `where`.
void drawRecent(State& state, const char* where,
                const std::function<void(const std::filesystem::path&)>& open);

// Before anything is open: what to do, the samples, the recent files.
void drawFirstStart(State& state, Samples& samples, SamplePictures& pictures,
                    const std::function<void(const std::filesystem::path&)>& open);

}  // namespace furrow::editor::ui
