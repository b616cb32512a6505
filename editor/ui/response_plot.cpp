#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "editor/ui/layer_panel.h"
#include "editor/ui/plot.h"
#include "editor/ui/widgets.h"
#include "furrow/jobs.h"

namespace furrow::editor::ui {
namespace {

constexpr float kLow = 0.4f, kHigh = 1.6f;  // length along d over that at rest
constexpr float kWeights = 0.5f / 0.46f;    // a little more than 1
constexpr size_t kBars = 60;

}  // namespace

void drawResponsePlot(const Response& response, bool linear, std::span<const float> stretches) {
  const Plot plot(8.6f * em(), {kLow, -kWeights}, {kHigh, kWeights});
  ImGui::Dummy(plot.size());
  mark("layer.curve");
  tooltip(
      "The weight (-1 to 1, upwards) that the surface gets at each length along the wrinkle direction, in "
      "% of the length at rest: left is squeezed, right is stretched. The bars show how much of the layer is "
      "there in the pose you see.");
  for (float length = 0.6f; length < 1.5f; length += 0.2f) {
    char label[16];
    std::snprintf(label, sizeof label, "%.0f%%", static_cast<double>(length * 100.0f));
    plot.lineUp(length, std::abs(length - 1.0f) < 0.01f, label);
  }
  for (float weight : {-1.0f, 0.0f, 1.0f}) plot.lineAcross(weight, weight == 0.0f);
  plot.topLabel("+1");
  plot.bottomLabel("-1");

  // Bars by the square root of the share: the few that are squeezed matter, not the many at rest.
  ImDrawList* list = ImGui::GetWindowDrawList();
  std::array<float, kBars> bars{};
  for (float length : stretches) {
    const float at = (length - kLow) / (kHigh - kLow) * static_cast<float>(kBars);
    bars[static_cast<size_t>(std::clamp(at, 0.0f, static_cast<float>(kBars - 1)))] += 1.0f;
  }
  for (size_t i = 0; i < kBars && !stretches.empty(); ++i) {
    if (bars[i] == 0.0f) continue;
    const float share = std::sqrt(bars[i] / static_cast<float>(stretches.size()));
    const auto edge = [](size_t bar) { return kLow + (kHigh - kLow) * static_cast<float>(bar) / kBars; };
    const float top = plot.at(1.0f, kWeights * (1.8f * share - 1.0f)).y;
    const ImU32 color =
        edge(i) + edge(i + 1) < 2.0f ? IM_COL32(236, 160, 72, 90) : IM_COL32(104, 158, 222, 90);
    list->AddRectFilled({plot.at(edge(i), 0.0f).x + 0.5f, std::min(top, plot.bottom() - 1.5f)},
                        {plot.at(edge(i + 1), 0.0f).x - 0.5f, plot.bottom()}, color);
  }

  constexpr int kSteps = 160;
  std::array<ImVec2, kSteps + 1> curve;
  Response shown = response;
  if (linear) shown.curve = Curve::kOat;
  for (int i = 0; i <= kSteps; ++i) {
    const float length = kLow + (kHigh - kLow) * static_cast<float>(i) / kSteps;
    curve[static_cast<size_t>(i)] = plot.at(length, respond(shown, length * length, 0.0f, 0.0f));
  }
  list->AddPolyline(curve.data(), kSteps + 1, Colors::kAccent, 0, 2.0f);
}

}  // namespace furrow::editor::ui
