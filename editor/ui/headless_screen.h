#pragma once

// A screen without a window: imgui drawn into a texture of the current OpenGL context (headless_context.h).

#include <memory>

#include "editor/ui/script.h"

namespace furrow::editor::ui {

class HeadlessScreen {
 public:
  // Makes the context of imgui; one at a time. `scale`: pixels for each of the usual ones.
  HeadlessScreen(int width, int height, float scale);
  ~HeadlessScreen();
  HeadlessScreen(const HeadlessScreen&) = delete;
  HeadlessScreen& operator=(const HeadlessScreen&) = delete;

  Screen screen();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Keys, navigation and files of imgui, the same for every screen.
void setUpImgui();

}  // namespace furrow::editor::ui
