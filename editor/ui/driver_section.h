#pragma once

#include "editor/ui/state.h"

namespace furrow::editor::ui {

// The drivers of the selected layer, with their gains and curves.
void drawDrivers(State& state, const pipeline::LayerRecipe& layer);

}  // namespace furrow::editor::ui
