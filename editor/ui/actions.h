#pragma once

// Everything that menus, buttons of the toolbar and keys do, in one table.

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace furrow::editor::ui {

// Indices of ImGuiIO::KeysDown; those of GLFW, letters and digits by their capital ASCII code.
namespace key {
inline constexpr int kSpace = 32, kEscape = 256, kEnter = 257, kTab = 258, kBackspace = 259, kInsert = 260,
                     kDelete = 261, kRight = 262, kLeft = 263, kDown = 264, kUp = 265, kPageUp = 266,
                     kPageDown = 267, kHome = 268, kEnd = 269, kF1 = 290;
}

struct Chord {
  int key = 0;  // 0: none
  bool ctrl = false, shift = false;
};
std::string chordText(const Chord& chord);               // "Ctrl+Shift+S"
bool parseChord(const std::string& text, Chord& chord);  // what chordText() writes
bool pressed(const Chord& chord, bool repeat = false);   // in this frame, with exactly these modifiers

struct Action {
  const char* id = "";    // "file.save"
  const char* menu = "";  // "File"; empty: keys only
  const char* label = "";
  Chord chord = {};
  const char* tip = "";
  std::function<void()> run = {};
  std::function<bool()> enabled = [] { return true; };
  std::function<bool()> checked = {};    // of a switch
  bool separated = false;                // a line above it in the menu
  std::function<std::string()> on = {};  // what it would act on now, for the tooltip
  std::function<void()> submenu = {};    // draws the items of a menu of its own; `run` is not used
};

// Menus of the main bar, in order, and what the keys ask for. While text is typed, letters and the keys that
// edit text are the text's; what another one with Ctrl asks for is left in `waiting` until the next call,
// when what was typed has been taken over.
void drawMenus(const std::vector<Action>& actions);
void runKeys(const std::vector<Action>& actions, const Action*& waiting);
// A button of the toolbar for an action, or nothing where `id` is none.
void actionButton(const std::vector<Action>& actions, const char* id, const char* label);

}  // namespace furrow::editor::ui
