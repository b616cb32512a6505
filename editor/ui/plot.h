#pragma once

// A sheet with curves on it, as wide as the panel.

#include <imgui.h>

namespace furrow::editor::ui {

class Plot {
 public:
  // Fills the panel's width from the cursor on; the scale's labels stand below. Draws the sheet, but takes no
  // place in the panel: an item of size() does.
  Plot(float height, ImVec2 least, ImVec2 most);

  ImVec2 size() const { return size_; }
  ImVec2 at(float x, float y) const;     // the screen's place of two values
  ImVec2 valuesAt(ImVec2 screen) const;  // and back; within the sheet
  float bottom() const { return bottom_; }

  void lineUp(float x, bool strong, const char* label) const;
  void lineAcross(float y, bool strong) const;
  void topLabel(const char* label) const;
  void bottomLabel(const char* label) const;

 private:
  ImVec2 low_, size_, least_, most_;
  float bottom_;
};

}  // namespace furrow::editor::ui
