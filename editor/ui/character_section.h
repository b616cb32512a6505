#pragma once

#include "editor/preview/posed_frame.h"
#include "editor/ui/state.h"

namespace furrow::editor::ui {

// What holds for all layers of the recipe: the rest pose, the weld, the sizes of maps. `frame`: of the shown
// asset, or null; `unit`: the diagonal of the character.
void drawCharacterSection(State& state, const preview::PosedFrame* frame, float unit);

}  // namespace furrow::editor::ui
