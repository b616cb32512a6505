#pragma once

#include "editor/preview/posed_frame.h"
#include "editor/ui/state.h"

namespace furrow::editor::ui {

// A slider for every morph target and region, with search, and the breathing test.
void drawPlayPanel(State& state, const preview::PosedFrame* frame);

// Clip, transport and time.
void drawTimeline(State& state);

}  // namespace furrow::editor::ui
