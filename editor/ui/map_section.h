#pragma once

#include "editor/ui/state.h"

namespace furrow::editor::ui {

// The compress or the stretch map of the selected layer. `unit`: the diagonal of the character, to which the
// ranges of lengths belong.
void drawMapSection(State& state, const pipeline::LayerRecipe& layer, bool stretch, float unit);

}  // namespace furrow::editor::ui
