#pragma once

// The UV layout of the shown asset.

#include <imgui.h>

#include "editor/ui/state.h"

namespace furrow::editor::ui {

// The unit square of UV space, centred in the given rectangle, with the edges of the shown asset's triangles:
// those of the selected layer bright, the others dim.
void drawUvLayout(const State& state, const Shown& shown, ImVec2 low, ImVec2 size);

}  // namespace furrow::editor::ui
