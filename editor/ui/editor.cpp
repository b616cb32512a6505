#include "editor/ui/editor.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "editor/ui/layer_panel.h"
#include "editor/ui/play_panel.h"
#include "editor/ui/widgets.h"
#include "pipeline/error.h"

namespace furrow::editor::ui {
namespace {

namespace fs = std::filesystem;

constexpr ImGuiWindowFlags kPanel = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                    ImGuiWindowFlags_NoSavedSettings |
                                    ImGuiWindowFlags_NoBringToFrontOnFocus |
                                    ImGuiWindowFlags_NoFocusOnAppearing;  // what is dragged or typed goes on
constexpr float kGroupWidths[] = {7.4f, 3.6f, 16.2f, 11.0f, 30.0f};  // of the toolbar, em, in the first frame
constexpr float kBesideLooks = 11.0f;   // em of the toolbar that the combos of both sides leave
constexpr float kLeastMessage = 12.0f;  // em in the status line, at the cost of the times
constexpr float kMostOfScreen = 0.32f;  // that a panel takes of the width: the view keeps a third
const std::vector<std::string> kImages = {".png", ".tif", ".tiff", ".exr", ".tga", ".jpg", ".jpeg", ".webp"};
const std::vector<std::string> kSources = {".glb", ".gltf", ".obj", ".ply", ".stl", ".off"};
const std::vector<std::string> kOpened = {".glb", ".gltf", ".obj",  ".ply",
                                          ".stl", ".off",  ".json", ".furrow"};

// A window in a fixed place; end with ImGui::End().
bool beginPanel(const char* name, ImVec2 low, ImVec2 size, ImGuiWindowFlags more = 0) {
  ImGui::SetNextWindowPos(low);
  ImGui::SetNextWindowSize(size);
  return ImGui::Begin(name, nullptr, kPanel | more);
}

// The edge of a panel, to be dragged; `width` in em, growing with `sign` times the pointer's x.
void drawEdge(const char* id, float x, float top, float height, float& width, float sign) {
  const float grip = 0.3f * em();
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0, 0});
  ImGui::PushStyleColor(ImGuiCol_WindowBg, 0u);
  beginPanel(id, {x - grip, top}, {2.0f * grip, height}, ImGuiWindowFlags_NoNav);
  ImGui::PopStyleColor();
  ImGui::PopStyleVar();
  ImGui::InvisibleButton("##edge", {2.0f * grip, height});
  mark(id);
  tooltip("Drag to make the panel wider or narrower  (Ctrl+Shift+Right, Ctrl+Shift+Left)");
  const bool held = ImGui::IsItemActive();
  if (held || ImGui::IsItemHovered()) {
    ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
    ImGui::GetWindowDrawList()->AddLine({x, top}, {x, top + height}, Colors::kAccent, 0.13f * em());
  }
  if (held)
    width = std::clamp(width + sign * ImGui::GetIO().MouseDelta.x / em(), Settings::kLeastPanel,
                       Settings::kMostPanel);
  ImGui::End();
}

}  // namespace

Editor::Editor(Session& session, Settings& settings) : state_(session, settings) {
  for (Look& look : state_.looks) look.tier = settings.tier;
  state_.looks[1].shading = 3;
  makeActions();
}

void Editor::open(const fs::path& file) {
  state_.leaving = [this, file] {
    const uint64_t before = state_.session.told();
    state_.session.open(file);
    if (state_.session.toldErrorSince(before)) return;
    state_.settings.opened(file);
    state_.framed = false;
    state_.split = false;
    state_.tool = Tool::kLook;
    state_.looks[0].view = 0;
    state_.camera = {};
    viewport_.release();
    selected_ = 0;
    keepSelection();
  };
}

void Editor::drop(const fs::path& file) {
  if (file.extension() == ".csv" && state_.session.shown())
    playTake(file);
  else
    open(file);
}

void Editor::playTake(const fs::path& file) {
  try {
    state_.session.player.take = pipeline::readTake(file);
    state_.session.player.take_name = file.filename().string();
  } catch (const pipeline::Error& error) {
    state_.session.tell(Message::Kind::kError, error.what());
  }
}

void Editor::askToQuit() {
  state_.leaving = [this] { state_.quit = true; };
}

bool Editor::busy() const {
  return working() || state_.session.player.playing || state_.scripted;
}

std::string Editor::title() const {
  const Session& session = state_.session;
  if (session.source().empty()) return "furrow";
  return session.source().filename().string() + (session.document.dirty() ? " *" : "") + " - furrow";
}

// The selected layer is one that there is: where it goes by another name after an undo, the one in its place.
void Editor::keepSelection() {
  if (state_.session.editable()) {
    const auto& layers = state_.session.document.recipe().layers;
    if (layers.empty()) return;
    if (state_.documentLayer() == pipeline::kNoIndex)
      state_.layer = layers[std::min(selected_, layers.size() - 1)].name;
    selected_ = state_.documentLayer();
  } else if (state_.session.shown() && state_.assetLayer(*state_.session.shown()) == pipeline::kNoIndex &&
             state_.session.shown()->view().layerCount() > 0) {
    state_.layer = state_.session.shown()->view().layers.front().name;
  }
}

void Editor::takeSample() {
  const std::optional<Samples::Result> result = samples_.take();
  if (!result) return;
  if (result->error.empty())
    open(result->file);
  else
    state_.session.tell(Message::Kind::kError, result->error);
}

void Editor::contextLost(const preview::ContextLost& lost) {
  state_.session.tell(Message::Kind::kWarning, lost.what());
  viewport_.contextLost();
}

void Editor::frame(double seconds) {
  beginFrame();
  // The arrows belong to the brush while the keyboard moves it.
  ImGuiConfigFlags& flags = ImGui::GetIO().ConfigFlags;
  flags = state_.cursor ? flags & ~ImGuiConfigFlags_NavEnableKeyboard
                        : flags | ImGuiConfigFlags_NavEnableKeyboard;
  Session& session = state_.session;
  session.update(seconds);
  takeSample();
  keepSelection();
  frame_.reset();
  if (session.shown()) frame_ = session.player.frame(*session.shown()->loaded);
  if (share_.running()) share_.step(state_, viewport_);
  runKeys(actions_, waiting_);

  const ImVec2 screen = ImGui::GetIO().DisplaySize;
  drawMenuBar();
  const float top = ImGui::GetFrameHeight();
  const float line = ImGui::GetFrameHeight() + 2.0f * ImGui::GetStyle().WindowPadding.y;
  const float tools = line + static_cast<float>(tool_rows_ - 1) * ImGui::GetFrameHeightWithSpacing();
  const float status = ImGui::GetFrameHeight();
  const float problems = state_.problems_shown ? std::min(9.0f * em(), 0.3f * screen.y) : 0.0f;
  const bool panels = !session.source().empty();
  const auto panelWidth = [&](bool shown, float wanted) {
    return panels && shown ? std::floor(std::min(wanted * em(), kMostOfScreen * screen.x)) : 0.0f;
  };
  const float left = panelWidth(state_.settings.show_left, state_.settings.left_width);
  const float right = panelWidth(state_.settings.show_right, state_.settings.right_width);
  const float bottom = panels ? line : 0.0f;
  const float body_top = top + (panels ? tools : 0.0f) + 1.0f;
  const float body = screen.y - body_top - status - bottom - 2.0f;
  if (panels) {
    beginPanel("Tools", {0, top}, {screen.x, tools});
    drawToolbar();
    ImGui::End();
  }
  if (left > 0.0f) {
    beginPanel("Layers", {0, body_top}, {left - 1.0f, body});
    drawLayerPanel(state_, frame_ ? &*frame_ : nullptr);
    ImGui::End();
  }
  if (right > 0.0f) {
    beginPanel("Sliders", {screen.x - right + 1.0f, body_top}, {right - 1.0f, body});
    drawPlayPanel(state_, frame_ ? &*frame_ : nullptr, share_);
    ImGui::End();
  }
  const float middle = screen.x - left - right;
  if (bottom > 0.0f) {
    beginPanel("Timeline", {0, body_top + body + 1.0f}, {screen.x, bottom});
    drawTimeline(state_);
    ImGui::End();
  }
  if (problems > 0.0f) {
    beginPanel("Messages", {left, body_top + body - problems + 1.0f}, {middle, problems - 1.0f});
    drawProblems(state_);
    ImGui::End();
  }
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0, 0});
  // On the first panel the keyboard goes from button to button, over a character it moves the camera.
  if (!panels && !ImGui::IsWindowFocused(ImGuiFocusedFlags_AnyWindow)) ImGui::SetNextWindowFocus();
  beginPanel("View", {left, body_top}, {middle, body - problems},
             ImGuiWindowFlags_NoScrollWithMouse | (panels ? ImGuiWindowFlags_NoNavInputs : 0));
  ImGui::PopStyleVar();
  if (panels)
    viewport_.draw(state_, frame_ ? &*frame_ : nullptr);
  else
    drawFirstStart(state_, samples_, sample_pictures_, [this](const fs::path& file) { open(file); });
  drawBanner(ImGui::GetWindowPos(), middle);
  ImGui::End();
  beginPanel("Status", {0, screen.y - status}, {screen.x, status});
  drawStatus();
  ImGui::End();
  if (left > 0.0f) drawEdge("edge.left", left, body_top, body, state_.settings.left_width, 1.0f);
  if (right > 0.0f)
    drawEdge("edge.right", screen.x - right, body_top, body, state_.settings.right_width, -1.0f);
  drawDialogs();

  // An error opens the list once.
  if (session.toldErrorSince(told_)) state_.problems_shown = true;
  told_ = session.told();
  if (!ImGui::IsAnyItemActive()) session.document.endGesture();
}

void Editor::drawMenuBar() {
  if (!ImGui::BeginMainMenuBar()) return;
  drawMenus(actions_);
  const float room = ImGui::GetWindowWidth() - ImGui::GetCursorPosX() - 2.0f * em();
  const std::string name = fitted(title(), std::max(room, em()));
  const float width = ImGui::CalcTextSize(name.c_str()).x;
  ImGui::SameLine(ImGui::GetWindowWidth() - width - em());
  ImGui::TextDisabled("%s", name.c_str());
  ImGui::EndMainMenuBar();
}

// Groups of buttons side by side, in as many rows as their widths of the last frame need.
void Editor::drawToolbar() {
  const float low = ImGui::GetWindowPos().x, gap = 1.2f * em(),
              right = ImGui::GetWindowWidth() - ImGui::GetStyle().WindowPadding.x;
  tool_rows_ = 1;
  size_t index = 0;
  const auto group = [&](bool to_right, const auto& draw) {
    float& width = group_widths_[index];
    if (width == 0.0f) width = kGroupWidths[index] * em();
    const float from = ImGui::GetItemRectMax().x - low + gap;
    if (index++ > 0) {
      if (from + width > right)
        ++tool_rows_;
      else
        ImGui::SameLine(to_right ? right - width : from);
    }
    ImGui::BeginGroup();
    draw();
    ImGui::EndGroup();
    width = ImGui::GetItemRectSize().x;
  };
  const auto buttons = [&](std::initializer_list<std::pair<const char*, const char*>> all) {
    group(false, [&] {
      for (const auto& [id, label] : all) {
        if (id != all.begin()->first) ImGui::SameLine(0.0f, 3.0f);
        actionButton(actions_, id, label);
      }
    });
  };
  buttons({{"file.save", state_.session.document.dirty() ? "Save *" : "Save"}, {"file.cook", "Cook ..."}});
  buttons({{"edit.undo", "\xe2\x86\xb6"}, {"edit.redo", "\xe2\x86\xb7"}});
  buttons({{"tool.look", "Look"},
           {"tool.bias", "Bias"},
           {"tool.mask", "Mask"},
           {"tool.comb", "Comb"},
           {"tool.guide", "Guide"}});
  group(false, [&] { drawTools(); });
  group(true, [&] { drawLooks(); });
}

// What each side of the picture shows, in combos as wide as their longest text where there is room.
void Editor::drawLooks() {
  constexpr const char* kTiers[] = {"auto", "gpu", "gpu-raster", "cpu"};
  const auto widthOf = [](std::span<const char* const> names) {
    float widest = 0.0f;
    for (const char* text : names) widest = std::max(widest, ImGui::CalcTextSize(text).x);
    return widest + 2.0f * ImGui::GetStyle().FramePadding.x + ImGui::GetFrameHeight();
  };
  const int sides = state_.split ? 2 : 1;
  const float wanted = static_cast<float>(sides) *
                       (widthOf(kViewNames) + widthOf(kShadingNames) + widthOf(kTiers)),
              room = std::min(1.0f, (ImGui::GetWindowWidth() - kBesideLooks * em()) / wanted);
  for (int side = 0; side < sides; ++side) {
    Look& look = state_.looks[side];
    const std::string name = side == 0 ? "look" : "look2";
    if (side == 1) ImGui::SameLine(0.0f, 1.2f * em());
    const auto combo = [&](const char* part, int& value, std::span<const char* const> names,
                           const char* tip) {
      const std::string id = name + "." + part;
      ImGui::SetNextItemWidth(room * widthOf(names));
      if (ImGui::BeginCombo(("##" + id).c_str(), names[static_cast<size_t>(value)])) {
        for (int i = 0; i < static_cast<int>(names.size()); ++i) {
          if (ImGui::Selectable(names[static_cast<size_t>(i)], i == value)) value = i;
          mark((id + "." + names[static_cast<size_t>(i)]).c_str());
        }
        ImGui::EndCombo();
      } else {
        mark(id.c_str());
        tooltip(tip);
      }
    };
    combo("view", look.view, kViewNames, "What the view shows  (1 to 9)");
    ImGui::SameLine(0.0f, 3.0f);
    ImGui::BeginDisabled(look.view != 0);
    combo("shading", look.shading, kShadingNames,
          "How wrinkles are drawn: Larsson's three methods, or not at all");
    ImGui::EndDisabled();
    ImGui::SameLine(0.0f, 3.0f);
    int tier = 0;
    for (int i = 0; i < 4; ++i)
      if (look.tier == kTiers[i]) tier = i;
    combo("tier", tier, kTiers,
          "What computes the weights: compute shaders, geometry shaders, the CPU, or the first of these that "
          "works");
    if (look.tier != kTiers[tier]) {
      look.tier = kTiers[tier];
      if (side == 0) state_.settings.tier = look.tier;
    }
    if (side == 1 && state_.session.comparison()) {
      ImGui::SameLine(0.0f, 3.0f);
      if (toggle("look2.compared", "File", look.compared,
                 "The right side shows the file that is compared with"))
        look.compared = !look.compared;
    }
  }
  ImGui::SameLine(0.0f, 1.2f * em());
  actionButton(actions_, "view.split", "Split");
}

void Editor::drawTools() {
  if (state_.tool == Tool::kLook) {
    actionButton(actions_, "view.all", "Frame all");
    ImGui::SameLine(0.0f, 3.0f);
    actionButton(actions_, "view.selected", "Frame layer");
    return;
  }
  Brush& brush = state_.brush;
  const auto small_slider = [](const char* id, float& value, float low, float high, const char* format,
                               float width, const char* tip, ImGuiSliderFlags flags = 0) {
    ImGui::SetNextItemWidth(width * em());
    bareSlider(id, value, low, high, format, tip, flags);
    ImGui::SameLine(0.0f, 3.0f);
  };
  if (state_.tool != Tool::kGuide) {
    float percent = 100.0f * brush.size;
    small_slider("brush.size", percent, 0.2f, 50.0f, "size %.1f%%", 6.6f,
                 "Radius of the brush in % of the view's height, 0.2 to 50  ([ and ], Ctrl + wheel)",
                 ImGuiSliderFlags_Logarithmic);
    brush.size = 0.01f * percent;
    small_slider("brush.strength", brush.strength, 0.01f, 1.0f, "strength %.2f", 7.2f,
                 "How far one stroke goes towards what it paints, 0.01 to 1");
    small_slider("brush.falloff", brush.falloff, 0.0f, 1.0f, "soft %.2f", 5.6f,
                 "The part of the radius over which the brush fades: 0 a hard edge, 1 soft all over");
  }
  if (state_.tool == Tool::kBias)
    small_slider("brush.bias", brush.bias, -1.0f, 1.0f, "bias %+.2f", 6.4f,
                 "The weight that strokes add at rest: -1 keeps the place smooth, 1 fully creased");
  if (state_.tool != Tool::kGuide) {
    actionButton(actions_, "brush.mirror", "Mirror");
    ImGui::SameLine(0.0f, 3.0f);
  }
  actionButton(actions_, "brush.erase", "Erase");
}

void Editor::drawBanner(ImVec2 low, float width) {
  const std::string& error = state_.session.error();
  if (error.empty()) return;
  ImDrawList* list = ImGui::GetWindowDrawList();
  const float pad = 0.6f * em();
  const std::string text =
      state_.brief(error) + (state_.session.shown() ? "   (what you see is from before)" : "");
  const float wrap = width - 4.0f * pad - 2.0f * em();
  const ImVec2 size = ImGui::GetFont()->CalcTextSizeA(em(), 1e9f, wrap, text.c_str());
  const ImVec2 at = {low.x + 2.0f * pad, low.y + 2.6f * em()};
  list->AddRectFilled({at.x - pad, at.y - 0.5f * pad},
                      {at.x + std::min(size.x, wrap) + pad, at.y + size.y + 0.5f * pad},
                      IM_COL32(92, 26, 22, 235), 4.0f);
  list->AddText(ImGui::GetFont(), em(), at, Colors::kText, text.c_str(), nullptr, wrap);
}

void Editor::drawStatus() {
  Session& session = state_.session;
  ImGui::SetCursorPosY(0.5f * (ImGui::GetWindowHeight() - ImGui::GetTextLineHeight()));
  if (session.source().empty()) {
    ImGui::TextDisabled("No file is open");
    return;
  }
  const std::string stage = session.stage();
  if (session.cooking())
    ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(Colors::kAccent), "Cooking: %s",
                       stage.empty() ? "waiting" : stage.c_str());
  else if (!session.error().empty())
    ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(Colors::kRed), "Not cooked");
  else
    ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(Colors::kGreen), "Up to date");
  if (!session.shown()) return;
  const AssetView& asset = session.shown()->view();
  ImGui::SameLine(0.0f, 1.5f * em());
  ImGui::TextDisabled("%u triangles, %u points, %u layers", asset.triangleCount(), asset.pointCount(),
                      asset.layerCount());
  mark("status.size");
  tooltip("Size of what you see; vertices at one place, on both sides of a seam too, are one point");
  ImGui::SameLine(0.0f, 1.5f * em());
  const Drawn& drawn = state_.drawn[0];
  ImGui::TextDisabled("%s", drawn.tier.c_str());
  mark("status.tier");
  tooltip(drawn.reason.c_str());
  if (drawn.lost) {
    ImGui::SameLine();
    if (ImGui::SmallButton("try again")) viewport_.release();
    mark("status.retry");
    tooltip("Draws on the tier that was lost again: a driver may have come back");
  }
  ImGui::SameLine(0.0f, 1.5f * em());
  std::string times;
  for (const preview::StageTime& part : drawn.times) {
    char text[48];
    std::snprintf(text, sizeof text, "%.*s %.2f  ", static_cast<int>(part.name.size()), part.name.data(),
                  state_.scripted ? 0.0 : part.milliseconds);
    times += text;
  }
  times += "ms";
  // Where there is room for one of them alone, the message is more important.
  const auto width = [](const std::string& text) { return ImGui::CalcTextSize(text.c_str()).x; };
  const float room = ImGui::GetWindowWidth() - ImGui::GetItemRectMax().x - 2.5f * em();
  const std::string message =
      session.messages().empty() ? std::string() : state_.brief(session.messages().back().text);
  const float wanted = std::min(width(message), kLeastMessage * em());
  if (width(times) + wanted + em() < room) {
    ImGui::TextDisabled("%s", times.c_str());
    mark("status.times");
    tooltip("Milliseconds of every stage of the last picture, all layers together, waiting for each to end");
  } else {
    ImGui::Dummy({0.0f, 0.0f});
  }
  if (message.empty()) return;
  const Message& last = session.messages().back();
  const std::string text = fitted(message, ImGui::GetWindowWidth() - ImGui::GetItemRectMax().x - 2.0f * em());
  ImGui::SameLine(std::max(ImGui::GetItemRectMax().x + em(), ImGui::GetWindowWidth() - width(text) - em()));
  ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(last.kind == Message::Kind::kError     ? Colors::kRed
                                                    : last.kind == Message::Kind::kWarning ? Colors::kAccent
                                                                                           : Colors::kDim),
                     "%s", text.c_str());
  if (ImGui::IsItemClicked()) state_.problems_shown = !state_.problems_shown;
  mark("status.message");
  tooltip((last.text + "\n(click: all messages)").c_str());
}

void Editor::openDialog() {
  Session& session = state_.session;
  const fs::path recipe = session.document.file();
  fs::path asset = recipe;
  asset.replace_extension(".furrow");
  const fs::path folder = session.source().empty() ? state_.settings.folder : session.source().parent_path();
  switch (std::exchange(state_.dialog, Dialog::kNone)) {
    case Dialog::kNone:
      break;
    case Dialog::kOpen:
      files_.open("Open", folder, kOpened, false, [this](const fs::path& file) { open(file); });
      break;
    case Dialog::kSaveAs:
      files_.open("Save recipe", recipe, {".json"}, true,
                  [this](const fs::path& file) { state_.session.save(file); });
      break;
    case Dialog::kCookTo:
      files_.open("Cook asset", asset, {".furrow"}, true,
                  [this](const fs::path& file) { state_.session.cookTo(file); });
      break;
    case Dialog::kTake:
      files_.open("Play take", folder, {".csv"}, false, [this](const fs::path& file) { playTake(file); });
      break;
    case Dialog::kCompare:
      files_.open("Compare with", folder, kOpened, false, [this](const fs::path& file) {
        state_.session.compareWith(file);
        state_.split = true;
        state_.looks[1] = state_.looks[0];
        state_.looks[1].compared = true;
      });
      break;
    case Dialog::kTexture:
      files_.open("Choose image", folder, kImages, false, state_.file_chosen);
      break;
    case Dialog::kRestFile:
      files_.open("Choose the relaxed shape", folder, kSources, false, state_.file_chosen);
      break;
    case Dialog::kImage:
      files_.open("Save picture", folder / (session.source().stem().string() + ".png"), {".png"}, true,
                  [this](const fs::path& file) {
                    if (frame_) share_.saveImage(state_, viewport_, *frame_, file);
                  });
      break;
  }
}

void Editor::drawDialogs() {
  openDialog();
  files_.draw();
  drawLeaving(state_);
  drawConflict(state_);
  drawKeys(state_, actions_);
}

}  // namespace furrow::editor::ui
