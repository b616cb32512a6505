#include "editor/ui/image_row.h"

#include <utility>

#include "editor/ui/widgets.h"

namespace furrow::editor::ui {

void chooseImage(State& state, Chosen chosen) {
  state.file_chosen = std::move(chosen);
  state.dialog = Dialog::kTexture;
}

void imageRow(State& state, const std::string& id, const char* label, const std::filesystem::path& now,
              const char* none, const char* tip, Chosen chosen, float spare) {
  row(label);
  const float width = ImGui::CalcItemWidth() - spare;
  const std::string text =
      now.empty() ? none
                  : fitted(now.filename().string(), width - 2.0f * ImGui::GetStyle().FramePadding.x, true);
  const std::string whole = now.empty() ? tip : now.filename().string() + ": " + tip;  // the name may be cut
  if (button(id.c_str(), text.c_str(), whole.c_str(), true, width)) chooseImage(state, std::move(chosen));
}

void clearableImage(State& state, const std::string& id, const char* label, const std::filesystem::path& now,
                    const char* none, const char* tip, Chosen chosen,
                    const std::function<void(pipeline::LayerRecipe&)>& clear) {
  const float gap = 4.0f, width = now.empty() ? 0.0f : 3.8f * em();
  imageRow(state, id, label, now, none, tip, std::move(chosen), now.empty() ? 0.0f : width + gap);
  if (now.empty()) return;
  ImGui::SameLine(0.0f, gap);
  if (button((id + ".clear").c_str(), "Clear", "Take it away", true, width))
    state.edit(std::string("Clear ") + label, clear);
}

}  // namespace furrow::editor::ui
