#pragma once

// Rows of a panel that hold an image of the selected layer.

#include <filesystem>
#include <functional>
#include <string>

#include "editor/ui/state.h"

namespace furrow::editor::ui {

using Chosen = std::function<void(const std::filesystem::path&)>;

// Asks for an image.
void chooseImage(State& state, Chosen chosen);

// The image's name on a button that chooses another; `none` where there is none yet.
void imageRow(State& state, const std::string& id, const char* label, const std::filesystem::path& now,
              const char* none, const char* tip, Chosen chosen, float spare = 0.0f);

// The same with a button that takes the image away.
void clearableImage(State& state, const std::string& id, const char* label, const std::filesystem::path& now,
                    const char* none, const char* tip, Chosen chosen,
                    const std::function<void(pipeline::LayerRecipe&)>& clear);

}  // namespace furrow::editor::ui
