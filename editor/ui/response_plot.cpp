#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "editor/ui/layer_panel.h"
#include "editor/ui/widgets.h"
#include "furrow/jobs.h"

namespace furrow::editor::ui {
namespace {

constexpr float kLow = 0.4f, kHigh = 1.6f;  // length along d over that at rest
constexpr size_t kBars = 60;

}  // namespace

void drawResponsePlot(const Response& response, bool linear, std::span<const float> stretches) {
  const ImVec2 low = ImGui::GetCursorScreenPos();
  const ImVec2 size = {ImGui::GetContentRegionAvail().x, 8.6f * em()};
  ImGui::Dummy(size);
  mark("layer.curve");
  tooltip(
      "The weight (-1 to 1, upwards) that the surface gets at each length along the wrinkle direction, in "
      "% of the length at rest: left is squeezed, right is stretched. The bars show how much of the layer is "
      "there in the pose you see.");
  ImDrawList* list = ImGui::GetWindowDrawList();
  const float text = 0.8f * em(), bottom = low.y + size.y - 1.2f * em(), right = low.x + size.x;
  list->AddRectFilled(low, {right, low.y + size.y}, IM_COL32(22, 23, 25, 255), 4.0f);
  const auto x = [&](float length) { return low.x + size.x * (length - kLow) / (kHigh - kLow); };
  const auto y = [&](float weight) { return bottom - (bottom - low.y) * (0.5f + 0.46f * weight); };
  for (float length = 0.6f; length < 1.5f; length += 0.2f) {
    const bool rest = std::abs(length - 1.0f) < 0.01f;
    list->AddLine({x(length), low.y}, {x(length), bottom},
                  rest ? IM_COL32(255, 255, 255, 60) : Colors::kGrid);
    char label[16];
    std::snprintf(label, sizeof label, "%.0f%%", static_cast<double>(length * 100.0f));
    const float width = ImGui::GetFont()->CalcTextSizeA(text, 1e9f, 0.0f, label).x;
    list->AddText(ImGui::GetFont(), text, {x(length) - 0.5f * width, bottom + 0.15f * em()}, Colors::kDim,
                  label);
  }
  for (float weight : {-1.0f, 0.0f, 1.0f})
    list->AddLine({low.x, y(weight)}, {right, y(weight)},
                  weight == 0.0f ? IM_COL32(255, 255, 255, 60) : Colors::kGrid);
  list->AddText(ImGui::GetFont(), text, {low.x + 4.0f, low.y + 1.0f}, Colors::kDim, "+1");
  list->AddText(ImGui::GetFont(), text, {low.x + 4.0f, bottom - text - 1.0f}, Colors::kDim, "-1");

  // Bars by the square root of the share: the few that are squeezed matter, not the many at rest.
  std::array<float, kBars> bars{};
  for (float length : stretches) {
    const float at = (length - kLow) / (kHigh - kLow) * static_cast<float>(kBars);
    bars[static_cast<size_t>(std::clamp(at, 0.0f, static_cast<float>(kBars - 1)))] += 1.0f;
  }
  for (size_t i = 0; i < kBars && !stretches.empty(); ++i) {
    if (bars[i] == 0.0f) continue;
    const float share = std::sqrt(bars[i] / static_cast<float>(stretches.size()));
    const float x0 = low.x + size.x * static_cast<float>(i) / static_cast<float>(kBars),
                x1 = low.x + size.x * static_cast<float>(i + 1) / static_cast<float>(kBars);
    const ImU32 color = 0.5f * (x0 + x1) < x(1.0f) ? IM_COL32(236, 160, 72, 90) : IM_COL32(104, 158, 222, 90);
    list->AddRectFilled({x0 + 0.5f, bottom - std::max(share * 0.9f * (bottom - low.y), 1.5f)},
                        {x1 - 0.5f, bottom}, color);
  }

  constexpr int kSteps = 160;
  std::array<ImVec2, kSteps + 1> curve;
  Response shown = response;
  if (linear) shown.curve = Curve::kOat;
  for (int i = 0; i <= kSteps; ++i) {
    const float length = kLow + (kHigh - kLow) * static_cast<float>(i) / kSteps;
    curve[static_cast<size_t>(i)] = {x(length), y(respond(shown, length * length, 0.0f, 0.0f))};
  }
  list->AddPolyline(curve.data(), kSteps + 1, Colors::kAccent, 0, 2.0f);
}

}  // namespace furrow::editor::ui
