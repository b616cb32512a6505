#include "editor/ui/plot.h"

#include <algorithm>

#include "editor/ui/widgets.h"

namespace furrow::editor::ui {
namespace {

float textSize() {
  return 0.8f * em();
}

ImU32 lineColor(bool strong) {
  return strong ? IM_COL32(255, 255, 255, 60) : Colors::kGrid;
}

void label(ImVec2 at, const char* text) {
  ImGui::GetWindowDrawList()->AddText(ImGui::GetFont(), textSize(), at, Colors::kDim, text);
}

}  // namespace

Plot::Plot(float height, ImVec2 least, ImVec2 most)
    : low_(ImGui::GetCursorScreenPos()),
      size_(ImGui::GetContentRegionAvail().x, height),
      least_(least),
      most_(most),
      bottom_(low_.y + height - 1.2f * em()) {
  ImGui::GetWindowDrawList()->AddRectFilled(low_, {low_.x + size_.x, low_.y + size_.y},
                                            IM_COL32(22, 23, 25, 255), 4.0f);
}

ImVec2 Plot::at(float x, float y) const {
  return {low_.x + size_.x * (x - least_.x) / (most_.x - least_.x),
          bottom_ - (bottom_ - low_.y) * (y - least_.y) / (most_.y - least_.y)};
}

ImVec2 Plot::valuesAt(ImVec2 screen) const {
  const float right = (screen.x - low_.x) / size_.x, up = (bottom_ - screen.y) / (bottom_ - low_.y);
  return {least_.x + std::clamp(right, 0.0f, 1.0f) * (most_.x - least_.x),
          least_.y + std::clamp(up, 0.0f, 1.0f) * (most_.y - least_.y)};
}

void Plot::lineUp(float x, bool strong, const char* text) const {
  const float across = at(x, 0.0f).x;
  ImGui::GetWindowDrawList()->AddLine({across, low_.y}, {across, bottom_}, lineColor(strong));
  const float width = ImGui::GetFont()->CalcTextSizeA(textSize(), 1e9f, 0.0f, text).x;
  label({std::clamp(across - 0.5f * width, low_.x + 2.0f, low_.x + size_.x - width - 2.0f),
         bottom_ + 0.15f * em()},
        text);
}

void Plot::lineAcross(float y, bool strong) const {
  const float up = at(0.0f, y).y;
  ImGui::GetWindowDrawList()->AddLine({low_.x, up}, {low_.x + size_.x, up}, lineColor(strong));
}

void Plot::topLabel(const char* text) const {
  label({low_.x + 4.0f, low_.y + 1.0f}, text);
}

void Plot::bottomLabel(const char* text) const {
  label({low_.x + 4.0f, bottom_ - textSize() - 1.0f}, text);
}

}  // namespace furrow::editor::ui
