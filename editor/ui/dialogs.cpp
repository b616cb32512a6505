#include "editor/ui/dialogs.h"

#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

#include "editor/ui/widgets.h"

namespace furrow::editor::ui {
namespace {

namespace fs = std::filesystem;

void centre(float width, float height) {
  const ImVec2 screen = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5f * screen.x, 0.5f * screen.y}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({std::min(width * em(), screen.x - 2.0f * em()),
                            height > 0.0f ? std::min(height * em(), screen.y - 2.0f * em()) : 0.0f});
}

constexpr ImGuiWindowFlags kModal =
    ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse;

bool beginModal(const char* title, float width, float height) {
  if (!ImGui::IsPopupOpen(title)) ImGui::OpenPopup(title);
  centre(width, height);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {1.1f * em(), 0.9f * em()});
  const bool open = ImGui::BeginPopupModal(title, nullptr, kModal);
  ImGui::PopStyleVar();
  return open;
}

}  // namespace

void FileDialog::open(const std::string& title, const fs::path& start, std::vector<std::string> kinds,
                      bool saving, std::function<void(const fs::path&)> chosen) {
  title_ = title;
  kinds_ = std::move(kinds);
  saving_ = saving;
  chosen_ = std::move(chosen);
  std::error_code ignored;
  const bool is_folder = fs::is_directory(start, ignored);
  folder_ = is_folder ? start : start.parent_path();
  if (folder_.empty() || !fs::is_directory(folder_, ignored)) folder_ = fs::current_path(ignored);
  name_ = is_folder ? std::string() : start.filename().string();
  overwrite_.clear();
  open_ = appearing_ = true;
  list();
}

void FileDialog::list() {
  entries_.clear();
  problem_.clear();
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_, error)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(".")) continue;
    std::error_code ignored;
    const bool folder = entry.is_directory(ignored);
    std::string ending = entry.path().extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); });
    if (folder || std::find(kinds_.begin(), kinds_.end(), ending) != kinds_.end())
      entries_.push_back({name, folder});
  }
  if (error) problem_ = folder_.string() + ": the folder cannot be read (" + error.message() + ")";
  std::sort(entries_.begin(), entries_.end(),
            [](const Entry& a, const Entry& b) { return a.folder != b.folder ? a.folder : a.name < b.name; });
}

void FileDialog::accept(const fs::path& file) {
  std::error_code ignored;
  if (fs::is_directory(file, ignored) && !kinds_.empty()) {
    folder_ = file.lexically_normal();
    name_.clear();
    return list();
  }
  fs::path whole = file;
  if (saving_ && whole.extension().empty() && !kinds_.empty()) whole += kinds_.front();
  // An image in a glTF file is head.glb#name.
  const std::string text = whole.string();
  if (!saving_ && !fs::exists(whole, ignored) && !fs::exists(text.substr(0, text.rfind('#')), ignored)) {
    problem_ = whole.string() + ": there is no such file";
    return;
  }
  if (saving_ && !kinds_.empty() && fs::exists(whole, ignored) && overwrite_ != whole.string()) {
    overwrite_ = whole.string();
    problem_ = whole.filename().string() + " exists: press again to replace it";
    return;
  }
  open_ = false;
  ImGui::CloseCurrentPopup();
  chosen_(whole);
}

void FileDialog::draw() {
  if (!open_ || !beginModal(title_.c_str(), 44.0f, 31.0f)) return;
  if (button("dialog.up", "\xe2\x96\xb2 Up", "The folder above  (Backspace in the list)",
             folder_.has_parent_path())) {
    folder_ = folder_.parent_path();
    list();
  }
  ImGui::SameLine();
  std::string folder = folder_.string();
  ImGui::SetNextItemWidth(-1.0f);
  if (ImGui::InputText("##dialog.folder", &folder, ImGuiInputTextFlags_EnterReturnsTrue)) {
    folder_ = folder;
    list();
  }
  mark("dialog.folder");
  tooltip("The folder that is shown; type another and press Enter");
  ImGui::BeginChild("files", {0.0f, -5.6f * em()}, true, ImGuiWindowFlags_NavFlattened);
  fs::path entered;
  for (const Entry& entry : entries_) {
    const std::string label = (entry.folder ? "\xe2\x96\xb6  " : "     ") + entry.name;
    if (ImGui::Selectable(label.c_str(), name_ == entry.name,
                          ImGuiSelectableFlags_AllowDoubleClick | ImGuiSelectableFlags_DontClosePopups)) {
      if (entry.folder || ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left) || name_ == entry.name)
        entered = folder_ / entry.name;
      else
        name_ = entry.name;
    }
    mark(("dialog.file." + entry.name).c_str());
  }
  if (entries_.empty()) ImGui::TextDisabled("nothing here");
  if (ImGui::IsWindowFocused() && ImGui::IsKeyPressed(key::kBackspace)) entered = folder_.parent_path();
  ImGui::EndChild();
  if (!entered.empty()) accept(entered);
  if (!open_) return ImGui::EndPopup();

  if (problem_.empty())
    ImGui::TextDisabled("%s", kinds_.empty() ? "Choose the folder to write into"
                              : saving_      ? "Type a name and press Enter"
                                             : "Double-click opens; type a name and press Enter");
  else
    ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(Colors::kRed), "%s", problem_.c_str());
  ImGui::SetNextItemWidth(-1.0f);
  if (appearing_) ImGui::SetKeyboardFocusHere();
  appearing_ = false;
  const bool enter = ImGui::InputText("##dialog.name", &name_, ImGuiInputTextFlags_EnterReturnsTrue);
  mark("dialog.name");
  tooltip("Name of the file, in this folder or a whole path; of an image in a glTF file: head.glb#name");
  const bool named = !name_.empty() || kinds_.empty();
  const std::string does = title_.substr(0, title_.find(' '));
  if ((button("dialog.accept", does.c_str(), "Takes this file  (Enter)", named, 7.0f * em()) || enter) &&
      named)
    accept(name_.empty() ? folder_ : folder_ / name_);
  ImGui::SameLine();
  if (open_ && (button("dialog.cancel", "Cancel", "Closes the dialog  (Escape)", true, 7.0f * em()) ||
                ImGui::IsKeyPressed(key::kEscape))) {
    open_ = false;
    ImGui::CloseCurrentPopup();
  }
  ImGui::EndPopup();
}

void drawLeaving(State& state) {
  if (!state.leaving) return;
  if (!state.session.document.dirty()) {
    const std::function<void()> leave = std::exchange(state.leaving, nullptr);
    return leave();
  }
  if (!beginModal("Unsaved work", 30.0f, 0.0f)) return;
  ImGui::TextWrapped("%s has edits that are not saved.",
                     state.session.document.file().filename().string().c_str());
  ImGui::Spacing();
  static std::string problem;
  const auto close = [&] {
    problem.clear();
    ImGui::CloseCurrentPopup();
    return std::exchange(state.leaving, nullptr);
  };
  if (!problem.empty()) {
    ImGui::PushStyleColor(ImGuiCol_Text, Colors::kRed);
    ImGui::TextWrapped("%s", problem.c_str());
    ImGui::PopStyleColor();
    mark("leave.problem");
    ImGui::Spacing();
  }
  if (button("leave.save", "Save", "Saves the recipe and its painted images, then goes on", true,
             8.0f * em())) {
    state.session.save(state.session.document.file());
    if (!state.session.document.dirty())
      close()();
    else
      problem = state.brief(state.session.messages().back().text) +
                ". Or cancel, and save the recipe as another file.";
  }
  ImGui::SameLine();
  if (state.leaving && button("leave.discard", "Discard", "Goes on without them", true, 8.0f * em()))
    close()();
  ImGui::SameLine();
  if (state.leaving && (button("leave.cancel", "Cancel", "Stays here  (Escape)", true, 8.0f * em()) ||
                        ImGui::IsKeyPressed(key::kEscape)))
    close();
  ImGui::EndPopup();
}

void drawConflict(State& state) {
  if (!state.session.conflict() || !beginModal("Changed on disk", 32.0f, 0.0f)) return;
  const std::string& error = state.session.recipeError();
  const std::string name = state.session.document.file().filename().string();
  ImGui::TextWrapped(
      "%s",
      (error.empty() ? name + " or an image painted for it was changed by another program, "
                              "and there are edits here that are not saved."
                     : name + " was changed by another program and cannot be read. " + state.brief(error))
          .c_str());
  ImGui::Spacing();
  if (button("conflict.reload", "Take the files", "Reads the files; the edits can be had back with Undo",
             true, 9.0f * em())) {
    state.session.reload();
    ImGui::CloseCurrentPopup();
  }
  ImGui::SameLine();
  if (button("conflict.keep", "Keep the edits", "The files are replaced when you save", true, 9.0f * em())) {
    state.session.keep();
    ImGui::CloseCurrentPopup();
  }
  ImGui::EndPopup();
}

void drawKeys(State& state, const std::vector<Action>& actions) {
  if (!state.keys_shown || !beginModal("Keys and mouse", 50.0f, 36.0f)) return;
  constexpr const char* kMouse[][2] = {
      {"Left drag", "orbit (with a brush: Alt + left drag)"},
      {"Middle drag, Shift + left drag", "pan"},
      {"Wheel", "zoom"},
      {"Right drag", "turn the lights"},
      {"Ctrl with a brush", "erase; Ctrl + wheel: brush size"},
      {"Ctrl + click on a slider", "type a value"},
      {"Right click on a slider", "let go, or automatic"},
      {"Ctrl + Tab, arrows, Space", "go from panel to panel, from widget to widget, use it"}};
  ImGui::BeginChild("keys", {0.0f, -2.6f * em()});
  ImGui::Columns(2, "keycolumns", false);
  ImGui::SetColumnWidth(0, std::min(17.0f * em(), 0.5f * ImGui::GetWindowWidth()));
  ImGui::PushTextWrapPos();
  for (const auto& [how, what] : kMouse) {
    ImGui::TextUnformatted(how);
    ImGui::NextColumn();
    ImGui::TextDisabled("%s", what);
    ImGui::NextColumn();
  }
  for (const Action& action : actions) {
    if (action.chord.key == 0) continue;
    ImGui::TextUnformatted(chordText(action.chord).c_str());
    ImGui::NextColumn();
    ImGui::TextDisabled("%s", action.tip);
    ImGui::NextColumn();
  }
  ImGui::PopTextWrapPos();
  ImGui::Columns(1);
  ImGui::EndChild();
  if (button("keys.close", "Close", "Closes this list  (Escape)", true, 8.0f * em()) ||
      ImGui::IsKeyPressed(key::kEscape)) {
    state.keys_shown = false;
    ImGui::CloseCurrentPopup();
  }
  ImGui::EndPopup();
}

void drawProblems(State& state) {
  const std::vector<Message>& messages = state.session.messages();
  if (button("problems.clear", "Clear", "Empties the list", !messages.empty()))
    return state.session.clearMessages();
  ImGui::SameLine();
  if (button("problems.copy", "Copy", "Puts all lines on the clipboard", !messages.empty())) {
    std::string all;
    for (const Message& message : messages) all += message.text + "\n";
    ImGui::SetClipboardText(all.c_str());
  }
  ImGui::BeginChild("messages");
  ImGui::PushTextWrapPos();
  for (const Message& message : messages) {
    const ImU32 color = message.kind == Message::Kind::kError     ? Colors::kRed
                        : message.kind == Message::Kind::kWarning ? Colors::kAccent
                                                                  : Colors::kDim;
    ImGui::PushStyleColor(ImGuiCol_Text, color);
    ImGui::TextUnformatted(state.brief(message.text).c_str());
    ImGui::PopStyleColor();
  }
  if (messages.empty()) ImGui::TextDisabled("Nothing to tell");
  ImGui::PopTextWrapPos();
  static uint64_t told = 0;
  if (std::exchange(told, state.session.told()) != state.session.told()) ImGui::SetScrollHereY(1.0f);
  ImGui::EndChild();
}

void drawFirstStart(State& state, Samples& samples, SamplePictures& pictures,
                    const std::function<void(const fs::path&)>& open) {
  const ImVec2 low = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
  // In a low window the pictures leave room for what is below them.
  const float width = std::min({38.0f * em(), size.x - 4.0f * em(), std::max(0.9f * size.y, 16.0f * em())});
  ImGui::SetCursorScreenPos({low.x + 0.5f * (size.x - width), low.y + std::max(0.08f * size.y, em())});
  ImGui::BeginChild("first", {width, size.y * 0.88f}, false, ImGuiWindowFlags_NavFlattened);
  ImGui::PushFont(titleFont());
  ImGui::TextUnformatted("furrow");
  ImGui::PopFont();
  ImGui::PushTextWrapPos(width);
  ImGui::TextDisabled(
      "Wrinkles that follow how the surface is squeezed. Open a character, play it, paint where it wrinkles, "
      "and cook it for your game.");
  ImGui::PopTextWrapPos();
  ImGui::Dummy({0, 0.8f * em()});
  ImGui::TextUnformatted("Begin with a sample");
  struct Sample {
    const char *id, *file, *label, *tip;
    ImTextureID picture;
  };
  const Sample all[] = {
      {"first.face", "face", "Face", "A face with expressions: raise its brows and see the forehead wrinkle",
       pictures.face()},
      {"first.clothing", "jacket", "Jacket", "A jacket on arms that bend: folds at elbow, armpit and waist",
       pictures.jacket()}};
  const float across = 0.5f * (width - ImGui::GetStyle().ItemSpacing.x), edge = 0.25f * em();
  const ImVec2 whole = {across, (across - 2.0f * edge) / kSampleAspect + 1.9f * em()};
  for (const Sample& sample : all) {
    if (&sample != all) ImGui::SameLine();
    ImGui::BeginDisabled(samples.making());
    if (ImGui::Button((std::string("##") + sample.id).c_str(), whole)) samples.ask(sample.file);
    ImGui::EndDisabled();
    mark(sample.id);
    tooltip(sample.tip);
    const ImVec2 from = ImGui::GetItemRectMin(), to = ImGui::GetItemRectMax();
    ImDrawList* list = ImGui::GetWindowDrawList();
    list->AddImageRounded(sample.picture, {from.x + edge, from.y + edge}, {to.x - edge, to.y - 1.65f * em()},
                          {0, 0}, {1, 1}, IM_COL32(255, 255, 255, samples.making() ? 110 : 255), 3.0f);
    const float label = ImGui::CalcTextSize(sample.label).x;
    list->AddText({std::floor(0.5f * (from.x + to.x - label)), to.y - 1.4f * em()}, Colors::kText,
                  sample.label);
  }
  if (samples.making()) {
    const float part = static_cast<float>(samples.made()) / static_cast<float>(Samples::kCount);
    ImGui::ProgressBar(state.scripted ? 0.0f : part, {width, 0.0f},
                       "Making the samples: once, some ten seconds");
    mark("first.progress");
  }
  ImGui::Dummy({0, 0.6f * em()});
  ImGui::TextUnformatted("Or open a file");
  if (button("first.open", "Open ...",
             "A mesh (glTF, OBJ, PLY, STL, OFF), a recipe or a cooked asset  (Ctrl+O); or drop a file on the "
             "window",
             true, width))
    state.dialog = Dialog::kOpen;
  if (!state.settings.recent.empty()) {
    ImGui::Dummy({0, 0.6f * em()});
    ImGui::TextUnformatted("Recent");
    drawRecent(state, "first", open);
  }
  ImGui::EndChild();
}

void drawRecent(State& state, const char* where, const std::function<void(const fs::path&)>& open) {
  const std::vector<fs::path> recent = state.settings.recent;  // opening changes the list
  for (size_t i = 0; i < recent.size(); ++i) {
    std::error_code ignored;
    const bool there = fs::exists(recent[i], ignored);
    const std::string label = recent[i].filename().string() + "##" + std::to_string(i),
                      folder = recent[i].parent_path().string();
    if (ImGui::MenuItem(label.c_str(), folder.c_str(), false, there)) open(recent[i]);
    mark((std::string(where) + ".recent." + std::to_string(i)).c_str());
    tooltip(there ? "Opens it again" : "It is no longer there");
  }
}

}  // namespace furrow::editor::ui
