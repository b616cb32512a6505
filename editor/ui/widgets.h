#pragma once

// The widgets of the editor's panels. Every one has an id ("layer.beta"), by which scripted sessions find it
// on the screen, and a tooltip that says what it does, in which unit and range.

#include <imgui.h>

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace furrow::editor::ui {

float em();  // the font's height in pixels: the unit of every size

struct Colors {
  static constexpr ImU32 kAccent = IM_COL32(236, 160, 72, 255), kText = IM_COL32(222, 222, 224, 255),
                         kDim = IM_COL32(148, 150, 156, 255), kGrid = IM_COL32(255, 255, 255, 22),
                         kRed = IM_COL32(240, 98, 84, 255), kGreen = IM_COL32(120, 190, 120, 255);
};

// Fonts, colours and spacing for a screen with `scale` times the usual number of pixels. Call before the
// first frame, and again when the scale changes. Returns false where no font file was found and the one that
// imgui carries is used.
bool applyTheme(float scale);
ImFont* titleFont();

// ---- where things are ----

void beginFrame();          // forgets where things were
void mark(const char* id);  // the last item; what is scrolled out of sight is nowhere
void mark(const char* id, ImVec2 low, ImVec2 high);
struct Rect {
  ImVec2 low, high;
};
std::optional<Rect> find(const std::string& id);  // in this frame or, before it is drawn, the last one

// Shows it while the pointer rests on the last item, or while the keyboard is on it.
void tooltip(const char* text);

// As much of the text as fits, with dots for what does not: its beginning, or its end.
std::string fitted(std::string text, float width, bool keep_end = false);

// ---- widgets; true when used or changed ----

bool button(const char* id, const char* label, const char* tip, bool enabled = true, float width = 0.0f);
// A button that stays down while `on`.
bool toggle(const char* id, const char* label, bool on, const char* tip, bool enabled = true);

// Filled from its lower end, or from 0, up to its value; no label.
bool bareSlider(const char* id, float& value, float low, float high, const char* format, const char* tip,
                ImGuiSliderFlags flags = 0);

// A label in the left column of the panel, a widget in the right one.
bool checkbox(const char* id, const char* label, bool& value, const char* tip);
bool slider(const char* id, const char* label, float& value, float low, float high, const char* format,
            const char* tip, ImGuiSliderFlags flags = 0);
bool integer(const char* id, const char* label, int& value, int low, int high, const char* tip);
bool choice(const char* id, const char* label, int& index, std::span<const char* const> names,
            const char* tip);
bool choice(const char* id, const char* label, std::string& value, std::span<const std::string> names,
            const char* tip);
// Which of some names; none is what `empty` says. A click on a name chooses it alone, adds it or takes it
// away.
bool choices(const char* id, const char* label, std::vector<std::string>& chosen,
             std::span<const std::string> names, const char* tip, const char* empty = "All");
// Adds a name that is not empty and not there yet.
void addName(std::vector<std::string>& names, std::string_view name);
bool direction(const char* id, const char* label, std::array<double, 3>& value, const char* tip);  // never 0
bool field(const char* id, const char* label, std::string& value, const char* tip);  // on Enter or leaving
// Of names that are too long the end shows: those of morph targets differ there.
void row(const char* label);  // the label alone; the next item fills the right column

// A heading inside a panel; true while it is open.
bool section(const char* id, const char* label, const char* tip, bool open = true);

}  // namespace furrow::editor::ui
