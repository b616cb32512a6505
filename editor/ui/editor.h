#pragma once

// The editor's screen: one frame of the whole user interface between ImGui::NewFrame() and ImGui::Render().
// Knows no window: a window (main.cpp) or a script (script.h) feeds the events.

#include <array>
#include <optional>

#include "editor/session/samples.h"
#include "editor/ui/actions.h"
#include "editor/ui/dialogs.h"
#include "editor/ui/share.h"
#include "editor/ui/viewport.h"

namespace furrow::editor::ui {

class Editor {
 public:
  // Needs a current OpenGL 3.3 core context, as long as it lives.
  Editor(Session& session, Settings& settings);

  State& state() { return state_; }
  void frame(double seconds);                    // since the last one
  void open(const std::filesystem::path& file);  // asks about unsaved work first
  // A take plays; anything else is opened.
  void drop(const std::filesystem::path& file);
  void askToQuit();
  bool quit() const { return state_.quit; }
  // After frame() threw preview::ContextLost: the next one needs another context.
  void contextLost(const preview::ContextLost& lost);
  bool working() const { return state_.session.cooking() || share_.running() || samples_.making(); }
  // Whether pictures change without any event: a window must not sleep.
  bool busy() const;
  std::string title() const;  // of the window

 private:
  void makeActions();
  std::vector<Action> fileActions();
  std::vector<Action> editActions();
  std::vector<Action> brushKeys();
  std::vector<Action> viewActions();
  std::vector<Action> cameraActions();
  std::vector<Action> screenActions();
  std::vector<Action> playActions();
  std::vector<Action> helpActions();
  std::vector<Action> viewKeys();
  void drawMenuBar();
  void drawToolbar();
  void drawTools();
  void drawLooks();
  void drawStatus();
  void drawBanner(ImVec2 low, float width);
  void drawDialogs();
  void openDialog();
  void takeSample();
  void playTake(const std::filesystem::path& file);
  void keepSelection();

  State state_;
  std::vector<Action> actions_;
  Viewport viewport_;
  Share share_;
  Samples samples_{Samples::usualProgram(), Samples::usualFolder()};
  SamplePictures sample_pictures_;
  FileDialog files_;
  std::optional<preview::PosedFrame> frame_;
  const Action* waiting_ = nullptr;  // for what is typed to be taken over
  uint64_t told_ = 0;                // messages already seen
  size_t selected_ = 0;              // place of the selected layer in the recipe
  int tool_rows_ = 1;                // of the toolbar
  std::array<float, 5> group_widths_{};
};

}  // namespace furrow::editor::ui
