#pragma once

// The UV layout of the shown asset.

#include <imgui.h>

#include <array>

#include "editor/ui/state.h"

namespace furrow::editor::ui {

// A triangle's UVs moved by whole tiles, so that its middle lies in the unit square.
std::array<Float2, 3> onFirstTile(Float2 a, Float2 b, Float2 c);

// The unit square of UV space, centred in the given rectangle, with the edges of the shown asset's triangles:
// those of the selected layer bright, the others dim.
void drawUvLayout(const State& state, const Shown& shown, ImVec2 low, ImVec2 size);

}  // namespace furrow::editor::ui
