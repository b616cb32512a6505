#pragma once

#include "editor/preview/posed_frame.h"
#include "editor/ui/share.h"

namespace furrow::editor::ui {

// A slider for every morph target and region, with search, the breathing test, and the pictures to share.
void drawPlayPanel(State& state, const preview::PosedFrame* frame, Share& share);

// Clip, transport and time.
void drawTimeline(State& state);

}  // namespace furrow::editor::ui
