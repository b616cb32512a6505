#include "editor/ui/widgets.h"

#include <imgui_internal.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <string_view>
#include <system_error>
#include <vector>

#include "editor/ui/actions.h"

namespace furrow::editor::ui {
namespace {

constexpr float kFontPixels = 15.0f, kTitleScale = 2.0f;
constexpr float kTooltipDelay = 0.45f;
constexpr float kLabelShare = 0.42f;  // of a panel's width
constexpr std::array kFonts = {"/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
                               "/usr/share/fonts/TTF/DejaVuSans.ttf",
                               "/usr/share/fonts/dejavu/DejaVuSans.ttf"};

struct Marks {
  std::map<std::string, Rect> now, before;
};
Marks& marks() {
  static Marks all;
  return all;
}

ImVec4 grey(float value, float alpha = 1.0f) {
  return {value, value * 1.005f, value * 1.03f, alpha};
}

// After an item: where it is, and what it does.
bool done(const char* id, const char* tip, bool used) {
  mark(id);
  tooltip(tip);
  return used;
}

std::string hidden(const char* id) {
  return std::string("##") + id;
}

}  // namespace

float em() {
  return ImGui::GetFontSize();
}

bool applyTheme(float scale) {
  ImGuiIO& io = ImGui::GetIO();
  io.Fonts->Clear();
  const float pixels = std::round(kFontPixels * scale);
  bool found = false;
  for (const char* file : kFonts) {
    std::error_code ignored;
    if (found || !std::filesystem::exists(file, ignored)) continue;
    static const ImWchar ranges[] = {0x20,   0xff,   0x3b1,  0x3bb,  0x2013, 0x2026, 0x2190,
                                     0x2193, 0x21b6, 0x21b7, 0x25a0, 0x25ff, 0};
    ImFontConfig config;
    config.OversampleH = 2;
    found = io.Fonts->AddFontFromFileTTF(file, pixels, &config, ranges) != nullptr;
    if (found) io.Fonts->AddFontFromFileTTF(file, std::round(kTitleScale * pixels), &config, ranges);
  }
  if (!found) {
    ImFontConfig config;
    config.SizePixels = std::round(13.0f * scale);
    io.Fonts->AddFontDefault(&config);
  }

  ImGuiStyle style;
  style.WindowPadding = {10, 8};
  style.FramePadding = {7, 4};
  style.ItemSpacing = {8, 6};
  style.ItemInnerSpacing = {6, 4};
  style.IndentSpacing = 14;
  style.ScrollbarSize = 11;
  style.GrabMinSize = 9;
  style.WindowRounding = 0;
  style.ChildRounding = 4;
  style.FrameRounding = 3;
  style.PopupRounding = 4;
  style.GrabRounding = 3;
  style.ScrollbarRounding = 6;
  style.TabRounding = 3;
  style.WindowBorderSize = 0;
  style.PopupBorderSize = 1;
  style.FrameBorderSize = 0;
  style.ScaleAllSizes(scale);
  style.WindowMinSize = {1, 1};  // imgui takes no less
  ImVec4* c = style.Colors;
  ImGui::StyleColorsDark(&style);
  const ImVec4 accent = ImGui::ColorConvertU32ToFloat4(Colors::kAccent);
  const auto tint = [&](float alpha) { return ImVec4(accent.x, accent.y, accent.z, alpha); };
  c[ImGuiCol_Text] = ImGui::ColorConvertU32ToFloat4(Colors::kText);
  c[ImGuiCol_TextDisabled] = grey(0.45f);
  c[ImGuiCol_WindowBg] = grey(0.135f);
  c[ImGuiCol_ChildBg] = grey(0.115f, 0.0f);
  c[ImGuiCol_PopupBg] = grey(0.155f, 0.99f);
  c[ImGuiCol_Border] = grey(0.27f);
  c[ImGuiCol_FrameBg] = grey(0.20f);
  c[ImGuiCol_FrameBgHovered] = grey(0.245f);
  c[ImGuiCol_FrameBgActive] = grey(0.27f);
  c[ImGuiCol_TitleBg] = c[ImGuiCol_TitleBgActive] = c[ImGuiCol_TitleBgCollapsed] = grey(0.18f);
  c[ImGuiCol_MenuBarBg] = grey(0.165f);
  c[ImGuiCol_ScrollbarBg] = grey(0.115f, 0.0f);
  c[ImGuiCol_ScrollbarGrab] = grey(0.28f);
  c[ImGuiCol_ScrollbarGrabHovered] = grey(0.36f);
  c[ImGuiCol_ScrollbarGrabActive] = grey(0.42f);
  c[ImGuiCol_CheckMark] = accent;
  c[ImGuiCol_SliderGrab] = tint(0.85f);
  c[ImGuiCol_SliderGrabActive] = accent;
  c[ImGuiCol_Button] = grey(0.225f);
  c[ImGuiCol_ButtonHovered] = grey(0.29f);
  c[ImGuiCol_ButtonActive] = grey(0.34f);
  c[ImGuiCol_Header] = tint(0.22f);
  c[ImGuiCol_HeaderHovered] = tint(0.32f);
  c[ImGuiCol_HeaderActive] = tint(0.42f);
  c[ImGuiCol_Separator] = grey(0.22f);
  c[ImGuiCol_SeparatorHovered] = c[ImGuiCol_SeparatorActive] = accent;
  c[ImGuiCol_Tab] = c[ImGuiCol_TabUnfocused] = grey(0.165f);
  c[ImGuiCol_TabHovered] = grey(0.29f);
  c[ImGuiCol_TabActive] = c[ImGuiCol_TabUnfocusedActive] = grey(0.25f);
  c[ImGuiCol_PlotHistogram] = accent;
  c[ImGuiCol_TextSelectedBg] = tint(0.35f);
  c[ImGuiCol_NavHighlight] = accent;
  c[ImGuiCol_ModalWindowDimBg] = ImVec4(0.02f, 0.02f, 0.02f, 0.55f);
  ImGui::GetStyle() = style;
  return found;
}

ImFont* titleFont() {
  return ImGui::GetIO().Fonts->Fonts.back();
}

void beginFrame() {
  marks().before = std::move(marks().now);
  marks().now.clear();
}

void mark(const char* id) {
  mark(id, ImGui::GetItemRectMin(), ImGui::GetItemRectMax());
}
void mark(const char* id, ImVec2 low, ImVec2 high) {
  if (ImGui::IsRectVisible(low, high)) marks().now[id] = {low, high};
}

std::optional<Rect> find(const std::string& id) {
  for (const auto* all : {&marks().now, &marks().before})
    if (const auto found = all->find(id); found != all->end()) return found->second;
  return std::nullopt;
}

void tooltip(const char* text) {
  const ImGuiContext& context = *ImGui::GetCurrentContext();
  const bool rests = ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled) && !ImGui::IsItemActive() &&
                     (context.HoveredIdTimer > kTooltipDelay || context.HoveredId == 0);
  const bool focused = ImGui::IsItemFocused() && ImGui::GetIO().NavVisible && !context.NavDisableHighlight &&
                       context.NavDisableMouseHover;
  if (!rests && !focused) return;
  if (focused) ImGui::SetNextWindowPos({ImGui::GetItemRectMin().x, ImGui::GetItemRectMax().y + 4.0f});
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(em() * 24.0f);
  ImGui::TextUnformatted(text);
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

bool button(const char* id, const char* label, const char* tip, bool enabled, float width) {
  ImGui::BeginDisabled(!enabled);
  const bool used = ImGui::Button((std::string(label) + "##" + id).c_str(), {width, 0.0f});
  ImGui::EndDisabled();
  return done(id, tip, used);
}

bool toggle(const char* id, const char* label, bool on, const char* tip, bool enabled) {
  if (on) {
    ImGui::PushStyleColor(ImGuiCol_Button, Colors::kAccent);
    ImGui::PushStyleColor(ImGuiCol_ButtonHovered, Colors::kAccent);
    ImGui::PushStyleColor(ImGuiCol_Text, IM_COL32(24, 20, 14, 255));
  }
  ImGui::BeginDisabled(!enabled);
  const bool used = ImGui::Button((std::string(label) + "##" + id).c_str());
  ImGui::EndDisabled();
  if (on) ImGui::PopStyleColor(3);
  return done(id, tip, used);
}

std::string fitted(std::string text, float width, bool keep_end) {
  if (ImGui::CalcTextSize(text.c_str()).x <= width) return text;
  const std::string dots = "\xe2\x80\xa6";
  const auto whole = [&] { return keep_end ? dots + text : text + dots; };
  const auto within = [](char c) { return (static_cast<unsigned char>(c) & 0xc0) == 0x80; };  // a character
  while (!text.empty() && ImGui::CalcTextSize(whole().c_str()).x > width) {
    if (keep_end) {
      do text.erase(0, 1);
      while (!text.empty() && within(text.front()));
    } else {
      while (within(text.back()) && text.size() > 1) text.pop_back();
      text.pop_back();
    }
  }
  return whole();
}

void row(const char* label) {
  const float left = ImGui::GetCursorPosX(), width = ImGui::GetContentRegionAvail().x;
  ImGui::AlignTextToFramePadding();
  const bool is_name = std::string_view(label).find(' ') == std::string_view::npos;
  ImGui::TextUnformatted(fitted(label, width * kLabelShare - 4.0f, is_name).c_str());
  ImGui::SameLine(left + width * kLabelShare);
  ImGui::SetNextItemWidth(width * (1.0f - kLabelShare));
}

bool checkbox(const char* id, const char* label, bool& value, const char* tip) {
  row(label);
  return done(id, tip, ImGui::Checkbox(hidden(id).c_str(), &value));
}

bool bareSlider(const char* id, float& value, float low, float high, const char* format, const char* tip,
                ImGuiSliderFlags flags) {
  const bool logarithmic = (flags & ImGuiSliderFlags_Logarithmic) != 0;
  const auto part = [&](float at) {
    at = std::clamp(at, low, high);
    return logarithmic ? std::log(at / low) / std::log(high / low) : (at - low) / (high - low);
  };
  const ImVec2 at = ImGui::GetCursorScreenPos(), size = {ImGui::CalcItemWidth(), ImGui::GetFrameHeight()};
  const ImVec2 end = {at.x + size.x, at.y + size.y};
  const float zero = low < 0.0f && high > 0.0f ? part(0.0f) : 0.0f, now = part(value);
  const float from = at.x + size.x * std::min(zero, now), to = at.x + size.x * std::max(zero, now);
  const float rounding = ImGui::GetStyle().FrameRounding;
  const bool near = ImGui::IsWindowHovered(ImGuiHoveredFlags_AllowWhenBlockedByActiveItem) &&
                    ImGui::IsMouseHoveringRect(at, end);
  ImDrawList* list = ImGui::GetWindowDrawList();
  list->AddRectFilled(at, end, ImGui::GetColorU32(near ? ImGuiCol_FrameBgHovered : ImGuiCol_FrameBg),
                      rounding);
  list->AddRectFilled({from, at.y}, {to, end.y}, ImGui::GetColorU32(ImGuiCol_SliderGrab, 0.36f), rounding);
  const float handle = std::clamp(at.x + size.x * now, at.x + 1.0f, end.x - 1.0f);
  list->AddLine({handle, at.y + 1.0f}, {handle, end.y - 1.0f},
                ImGui::GetColorU32(ImGuiCol_SliderGrabActive, near ? 1.0f : 0.75f), 0.1f * em());
  for (const ImGuiCol color : {ImGuiCol_FrameBg, ImGuiCol_FrameBgHovered, ImGuiCol_FrameBgActive,
                               ImGuiCol_SliderGrab, ImGuiCol_SliderGrabActive})
    ImGui::PushStyleColor(color, 0u);
  const bool used =
      ImGui::SliderFloat(hidden(id).c_str(), &value, low, high, format, flags | ImGuiSliderFlags_AlwaysClamp);
  ImGui::PopStyleColor(5);
  return done(id, tip, used);
}

bool slider(const char* id, const char* label, float& value, float low, float high, const char* format,
            const char* tip, ImGuiSliderFlags flags) {
  row(label);
  return bareSlider(id, value, low, high, format, tip, flags);
}

bool integer(const char* id, const char* label, int& value, int low, int high, const char* tip) {
  row(label);
  const bool used = ImGui::InputInt(hidden(id).c_str(), &value);
  value = std::clamp(value, low, high);
  return done(id, tip, used);
}

bool choice(const char* id, const char* label, int& index, std::span<const char* const> names,
            const char* tip) {
  row(label);
  bool used = false;
  const bool known = index >= 0 && index < static_cast<int>(names.size());
  const bool open = ImGui::BeginCombo(hidden(id).c_str(), known ? names[static_cast<size_t>(index)] : "");
  // An open combo's own rectangle is that of its list.
  if (!open) done(id, tip, false);
  if (!open) return false;
  for (int i = 0; i < static_cast<int>(names.size()); ++i) {
    const char* name = names[static_cast<size_t>(i)];
    if (ImGui::Selectable(name, i == index)) {
      index = i;
      used = true;
    }
    mark((std::string(id) + "." + name).c_str());
    if (i == index) ImGui::SetItemDefaultFocus();
  }
  ImGui::EndCombo();
  return used;
}

bool choice(const char* id, const char* label, std::string& value, std::span<const std::string> names,
            const char* tip) {
  std::vector<const char*> texts;
  int index = -1;
  for (const std::string& name : names) {
    if (name == value) index = static_cast<int>(texts.size());
    texts.push_back(name.c_str());
  }
  if (!choice(id, label, index, texts, tip)) return false;
  value = names[static_cast<size_t>(index)];
  return true;
}

bool choices(const char* id, const char* label, std::vector<std::string>& chosen,
             std::span<const std::string> names, const char* tip, const char* empty) {
  row(label);
  const std::string text = chosen.empty()       ? empty
                           : chosen.size() == 1 ? chosen.front()
                                                : std::to_string(chosen.size()) + " chosen";
  const bool open = ImGui::BeginCombo(hidden(id).c_str(), text.c_str());
  if (!open) return done(id, tip, false);
  bool used = false;
  const auto item = [&](const std::string& name, const std::string& part, bool on) {
    const bool clicked = ImGui::MenuItem(name.c_str(), nullptr, on);
    mark((std::string(id) + "." + part).c_str());
    used |= clicked;
    return clicked;
  };
  ImGui::PushItemFlag(ImGuiItemFlags_SelectableDontClosePopup, true);
  if (item(std::string(empty) + "##all", "(all)", chosen.empty())) chosen.clear();
  ImGui::Separator();
  for (const std::string& name : names) {
    const auto found = std::find(chosen.begin(), chosen.end(), name);
    if (!item(name, name, found != chosen.end())) continue;
    if (found == chosen.end())
      chosen.push_back(name);
    else
      chosen.erase(found);
  }
  ImGui::PopItemFlag();
  ImGui::EndCombo();
  return used;
}

void addName(std::vector<std::string>& names, std::string_view name) {
  if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end()) names.emplace_back(name);
}

bool direction(const char* id, const char* label, std::array<double, 3>& value, const char* tip) {
  row(label);
  std::array<double, 3> next = value;
  const bool used =
      ImGui::InputScalarN(hidden(id).c_str(), ImGuiDataType_Double, next.data(), 3, nullptr, nullptr, "%.2f");
  if (!done(id, tip, used) || !(std::hypot(next[0], next[1], next[2]) > 1e-6)) return false;
  value = next;
  return true;
}

bool field(const char* id, const char* label, std::string& value, const char* tip) {
  row(label);
  static std::string typed;  // of the one that has the keyboard
  std::string text = value;
  ImGui::InputText(hidden(id).c_str(), &text, ImGuiInputTextFlags_EnterReturnsTrue);
  const bool left = ImGui::IsItemDeactivatedAfterEdit();
  if (ImGui::IsItemActive())
    typed = text;
  else if (left && text == value && !ImGui::IsKeyPressed(key::kEscape))
    text = typed;  // the keyboard was taken from it
  if (!left || text == value) return done(id, tip, false);
  value = text;
  return done(id, tip, true);
}

bool section(const char* id, const char* label, const char* tip, bool open) {
  ImGui::Spacing();
  ImGui::PushStyleColor(ImGuiCol_Header, ImVec4(1, 1, 1, 0.06f));
  const bool is_open = ImGui::CollapsingHeader((std::string(label) + "##" + id).c_str(),
                                               open ? ImGuiTreeNodeFlags_DefaultOpen : 0);
  ImGui::PopStyleColor();
  done(id, tip, false);
  return is_open;
}

}  // namespace furrow::editor::ui
