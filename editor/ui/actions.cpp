#include "editor/ui/actions.h"

#include <imgui.h>
#include <imgui_internal.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "editor/ui/widgets.h"

namespace furrow::editor::ui {
namespace {

constexpr std::pair<int, const char*> kNamed[] = {
    {key::kSpace, "Space"},   {key::kEscape, "Escape"},     {key::kEnter, "Enter"},
    {key::kTab, "Tab"},       {key::kDelete, "Delete"},     {key::kBackspace, "Backspace"},
    {key::kRight, "Right"},   {key::kLeft, "Left"},         {key::kDown, "Down"},
    {key::kUp, "Up"},         {key::kHome, "Home"},         {key::kEnd, "End"},
    {key::kPageUp, "PageUp"}, {key::kPageDown, "PageDown"}, {key::kF1, "F1"}};

std::string tipOf(const Action& action) {
  const std::string on = action.on ? action.on() : std::string();
  return on.empty() ? action.tip : action.tip + (": " + on);
}

}  // namespace

std::string chordText(const Chord& chord) {
  if (chord.key == 0) return {};
  std::string text = chord.ctrl ? "Ctrl+" : "";
  if (chord.shift) text += "Shift+";
  for (const auto& [code, name] : kNamed)
    if (code == chord.key) return text + name;
  return text + static_cast<char>(chord.key);
}

bool parseChord(const std::string& text, Chord& chord) {
  chord = {};
  std::string rest = text;
  const auto strip = [&](const char* prefix) {
    if (!rest.starts_with(prefix)) return false;
    rest.erase(0, std::string(prefix).size());
    return true;
  };
  chord.ctrl = strip("Ctrl+");
  chord.shift = strip("Shift+");
  if (rest.size() == 1) chord.key = std::toupper(static_cast<unsigned char>(rest[0]));
  for (const auto& [code, name] : kNamed)
    if (rest == name) chord.key = code;
  return chord.key != 0;
}

bool pressed(const Chord& chord, bool repeat) {
  const ImGuiIO& io = ImGui::GetIO();
  return chord.key != 0 && io.KeyCtrl == chord.ctrl && io.KeyShift == chord.shift && !io.KeyAlt &&
         ImGui::IsKeyPressed(chord.key, repeat);
}

void drawMenus(const std::vector<Action>& actions) {
  std::vector<std::string> menus;
  for (const Action& action : actions)
    if (*action.menu && std::find(menus.begin(), menus.end(), action.menu) == menus.end())
      menus.emplace_back(action.menu);
  for (const std::string& menu : menus) {
    const bool open = ImGui::BeginMenu(menu.c_str());
    if (!open) mark(("menu." + menu).c_str());
    if (!open) continue;
    bool first = true;
    for (const Action& action : actions) {
      if (menu != action.menu) continue;
      if (action.separated && !first) ImGui::Separator();
      first = false;
      if (action.submenu) {
        const bool opened = ImGui::BeginMenu(action.label, action.enabled());
        if (!opened) {
          mark(action.id);
          tooltip(action.tip);
          continue;
        }
        action.submenu();
        ImGui::EndMenu();
        continue;
      }
      if (ImGui::MenuItem(action.label, chordText(action.chord).c_str(), action.checked && action.checked(),
                          action.enabled()))
        action.run();
      mark(action.id);
      tooltip(tipOf(action).c_str());
    }
    ImGui::EndMenu();
  }
}

void runKeys(const std::vector<Action>& actions, const Action*& waiting) {
  if (ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopupId)) return;
  if (const Action* action = std::exchange(waiting, nullptr)) return action->run();
  const ImGuiIO& io = ImGui::GetIO();
  if (io.WantTextInput) {
    for (const Action& action : actions) {
      const Chord& chord = action.chord;
      if (!chord.ctrl || chord.key >= key::kEscape || std::strchr("ACVXYZ", chord.key) || !pressed(chord) ||
          !action.enabled())
        continue;
      ImGui::ClearActiveID();
      waiting = &action;
      return;
    }
    return;
  }
  // Arrows, Space and Enter belong to the widget that the keyboard is on.
  const bool on_widget = io.NavVisible && (io.ConfigFlags & ImGuiConfigFlags_NavEnableKeyboard) != 0;
  for (const Action& action : actions) {
    const int code = action.chord.key;
    const bool moves =
        code == key::kSpace || code == key::kEnter || (code >= key::kRight && code <= key::kUp);
    if (on_widget && moves && !action.chord.ctrl) continue;
    if (pressed(action.chord, moves) && action.enabled()) return action.run();
  }
}

void actionButton(const std::vector<Action>& actions, const char* id, const char* label) {
  for (const Action& action : actions) {
    if (std::string(action.id) != id) continue;
    std::string tip = tipOf(action);
    if (action.chord.key != 0) tip += "  (" + chordText(action.chord) + ")";
    const std::string name = std::string("tool.") + id;
    if (toggle(name.c_str(), label, action.checked && action.checked(), tip.c_str(), action.enabled()))
      action.run();
  }
}

}  // namespace furrow::editor::ui
