#pragma once

#include "editor/preview/posed_frame.h"
#include "editor/ui/state.h"

namespace furrow::editor::ui {

// The layers of the recipe and everything about the selected one. `frame`: of the shown asset, or null.
void drawLayerPanel(State& state, const preview::PosedFrame* frame);

// The response over the length along d, 40 to 160% of that at rest, with a histogram of where the layer's
// points are now.
void drawResponsePlot(const Response& response, bool linear, std::span<const float> stretches);

}  // namespace furrow::editor::ui
