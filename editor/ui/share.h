#pragma once

// Pictures for others: one, a turn of the character, or a clip as numbered PNG frames.

#include <filesystem>
#include <string>

#include "editor/ui/viewport.h"

namespace furrow::editor::ui {

struct ShareOptions {
  int width = 1280, height = 1280;  // pixels, 16 to 4096
  int frames = 48;                  // of a turntable, 2 to 2000
  int fps = 30;                     // of a clip, 1 to 120
};

class Share {
 public:
  ShareOptions options;

  void saveImage(State& state, Viewport& viewport, const preview::PosedFrame& frame,
                 const std::filesystem::path& file);
  void startTurntable(const std::filesystem::path& folder);
  void startClip(State& state, const std::filesystem::path& folder);
  bool running() const { return next_ < count_; }
  void cancel() { count_ = next_ = 0; }
  // Writes one frame of what was started and puts camera and time back as they were.
  void step(State& state, Viewport& viewport);
  void draw();  // options and progress

 private:
  std::filesystem::path folder_;
  int next_ = 0, count_ = 0;
  bool turns_ = false;
};

}  // namespace furrow::editor::ui
