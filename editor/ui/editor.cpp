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
                                    ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoBringToFrontOnFocus;
constexpr const char* kEllipsis = "\xe2\x80\xa6";
constexpr float kCursorStep = 0.01f;   // of the picture's sides
constexpr float kPanStep = 0.05f;      // of the picture's height
constexpr float kMostOfScreen = 0.4f;  // that a panel takes of the width
const std::vector<std::string> kImages = {".png", ".tif", ".tiff", ".exr", ".tga", ".jpg", ".jpeg", ".webp"};
const std::vector<std::string> kMeshes = {".glb", ".gltf", ".obj",  ".ply",
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

void Editor::makeActions() {
  State& s = state_;
  const auto is_open = [&s] { return s.session.shown() != nullptr; };
  const auto editable = [&s] { return s.session.editable(); };
  const auto view = [&s](int index) { return [&s, index] { s.looks[0].view = index; }; };
  const auto viewed = [&s](int index) { return [&s, index] { return s.looks[0].view == index; }; };
  const auto tool = [&s](Tool to) {
    return [&s, to] {
      s.tool = to;
      if (to == Tool::kLook) s.cursor.reset();
      if (to == Tool::kBias) s.looks[0].view = static_cast<int>(preview::View::kBias);
      if (to == Tool::kMask) s.looks[0].view = static_cast<int>(preview::View::kMask);
      if (to == Tool::kComb || to == Tool::kGuide)
        s.looks[0].view = static_cast<int>(preview::View::kDirection);
      if (to == Tool::kLook) s.looks[0].view = 0;
    };
  };
  const auto uses = [&s](Tool of) { return [&s, of] { return s.tool == of; }; };
  const auto turned = [&s](float yaw, float pitch) {
    return [&s, yaw, pitch] {
      s.camera.yaw = yaw;
      s.camera.pitch = pitch;
    };
  };
  const auto orbit = [&s](float yaw, float pitch) {
    return [&s, yaw, pitch] {
      s.camera.yaw = std::remainder(s.camera.yaw + yaw, 360.0f);
      s.camera.pitch = std::clamp(s.camera.pitch + pitch, -89.0f, 89.0f);
    };
  };
  const auto zoom = [&s](float by) { return [&s, by] { s.camera.distance *= by; }; };
  const auto pan = [&s](float right, float up) {
    return [&s, right, up] { panCamera(s.camera, kPanStep * right, kPanStep * up); };
  };
  const auto divide = [&s](float by) {
    return [&s, by] { s.divider = std::clamp(s.divider + by, kLeastDivider, 1.0f - kLeastDivider); };
  };
  const auto widen = [&s](float by) {
    return [&s, by] {
      for (float* width : {&s.settings.left_width, &s.settings.right_width})
        *width = std::clamp(*width + by, Settings::kLeastPanel, Settings::kMostPanel);
    };
  };
  const auto scale = [&s](float by) {
    return [&s, by] {
      s.scale = std::clamp((s.scale > 0.0f ? s.scale : s.screen_scale) * by, 0.5f, 4.0f);
      s.settings.scale = s.scale;
    };
  };
  const auto cursor = [&s] { return s.cursor.has_value(); };
  const auto nudge = [&s](float x, float y) {
    return [&s, x, y] {
      s.cursor->x = std::clamp(s.cursor->x + kCursorStep * x, 0.0f, 1.0f);
      s.cursor->y = std::clamp(s.cursor->y + kCursorStep * y, 0.0f, 1.0f);
    };
  };
  const auto split = [&s] { return s.session.shown() && s.split; };
  actions_ = {
      {"file.open",
       "File",
       "Open ...",
       {'O', true, false},
       "Open a mesh, a recipe or a cooked asset",
       [&s] { s.dialog = Dialog::kOpen; }},
      {"file.recent",
       "File",
       "Open recent",
       {},
       "The files that were opened last",
       {},
       [&s] { return !s.settings.recent.empty(); },
       {},
       false,
       [this, &s] { drawRecent(s, "file", [this](const fs::path& file) { open(file); }); }},
      {"file.save",
       "File",
       "Save recipe",
       {'S', true, false},
       "Write the recipe and its painted images",
       [&s] { s.session.save(s.session.document.file()); },
       editable,
       {},
       true},
      {"file.save_as",
       "File",
       "Save recipe as ...",
       {'S', true, true},
       "Write the recipe under another name",
       [&s] { s.dialog = Dialog::kSaveAs; },
       editable},
      {"file.cook",
       "File",
       "Cook asset ...",
       {'K', true, false},
       "Cook the .furrow asset as 'furrow cook' does, in the background",
       [&s] { s.dialog = Dialog::kCookTo; },
       editable},
      {"file.image",
       "File",
       "Save picture ...",
       {'P', true, false},
       "Write what the view shows as a PNG file",
       [&s] { s.dialog = Dialog::kImage; },
       is_open,
       {},
       true},
      {"file.turntable",
       "File",
       "Turntable frames ...",
       {},
       "Write a whole turn of the character as numbered PNG files",
       [this, &s] {
         files_.open("Turntable frames into folder", s.settings.folder, {}, true,
                     [this](const fs::path& folder) { share_.startTurntable(folder); });
       },
       is_open},
      {"file.clip",
       "File",
       "Clip frames ...",
       {},
       "Write what plays as numbered PNG files",
       [this, &s] {
         files_.open("Clip frames into folder", s.settings.folder, {}, true,
                     [this, &s](const fs::path& folder) { share_.startClip(s, folder); });
       },
       [&s] { return s.session.shown() && s.session.player.duration(s.session.shown()->loaded->rig) > 0.0; }},
      {"file.quit",
       "File",
       "Quit",
       {'Q', true, false},
       "Leave; unsaved work is asked about",
       [this] { askToQuit(); },
       [] { return true; },
       {},
       true},

      {"edit.undo",
       "Edit",
       "Undo",
       {'Z', true, false},
       "Take the last edit back",
       [&s] { s.session.document.undo(); },
       [&s] { return !s.session.document.undoName().empty(); }},
      {"edit.redo",
       "Edit",
       "Redo",
       {'Z', true, true},
       "Make the edit again that was taken back",
       [&s] { s.session.document.redo(); },
       [&s] { return !s.session.document.redoName().empty(); }},
      {"tool.look",
       "Edit",
       "Look",
       {'Q', false, false},
       "Left drag orbits",
       tool(Tool::kLook),
       [] { return true; },
       uses(Tool::kLook),
       true},
      {"tool.bias",
       "Edit",
       "Paint rest bias",
       {'B', false, false},
       "Paint where wrinkles are there at rest, or never",
       tool(Tool::kBias),
       editable,
       uses(Tool::kBias)},
      {"tool.mask",
       "Edit",
       "Paint mask",
       {'M', false, false},
       "Paint how far the selected layer reaches",
       tool(Tool::kMask),
       editable,
       uses(Tool::kMask)},
      {"tool.comb",
       "Edit",
       "Comb directions",
       {'D', false, false},
       "Stroke along the creases you want",
       tool(Tool::kComb),
       editable,
       uses(Tool::kComb)},
      {"tool.guide",
       "Edit",
       "Draw guides",
       {'G', false, false},
       "Draw curves along the creases; the direction follows them",
       tool(Tool::kGuide),
       editable,
       uses(Tool::kGuide)},
      {"brush.mirror",
       "Edit",
       "Mirror strokes",
       {'X', false, false},
       "Paint on the other side (-x) too",
       [&s] { s.brush.mirror = !s.brush.mirror; },
       editable,
       [&s] { return s.brush.mirror; }},
      {"brush.erase",
       "Edit",
       "Erase",
       {'E', false, false},
       "Strokes take away; or hold Ctrl",
       [&s] { s.brush.erase = !s.brush.erase; },
       editable,
       [&s] { return s.brush.erase; }},
      {"brush.keyboard",
       "Edit",
       "Brush by keyboard",
       {'C', false, false},
       "Move the brush with the arrows, in place of the mouse; Space puts it down and lifts it",
       [&s] {
         s.cursor = s.cursor ? std::nullopt : std::optional(ImVec2(0.5f, 0.5f));
         s.cursor_down = false;
       },
       [&s] { return s.session.shown() && s.session.editable() && s.tool != Tool::kLook; },
       [&s] { return s.cursor.has_value(); }},
      {"brush.down",
       "",
       "",
       {key::kSpace, false, false},
       "With the brush by keyboard: put it down, lift it",
       [&s] { s.cursor_down = !s.cursor_down; },
       cursor},
      {"brush.smaller",
       "",
       "",
       {'[', false, false},
       "Smaller brush",
       [&s] { s.brush.size = std::max(0.002f, s.brush.size / 1.2f); }},
      {"brush.larger",
       "",
       "",
       {']', false, false},
       "Larger brush",
       [&s] { s.brush.size = std::min(0.5f, s.brush.size * 1.2f); }},

      {"view.beauty",
       "View",
       "Beauty",
       {'1', false, false},
       "The lit surface with its wrinkles",
       view(0),
       is_open,
       viewed(0)},
      {"view.weight",
       "View",
       "Weight",
       {'2', false, false},
       "Weight of the selected layer: red squeezed, blue stretched",
       view(1),
       is_open,
       viewed(1)},
      {"view.direction",
       "View",
       "Direction",
       {'3', false, false},
       "Strokes across the creases of the selected layer",
       view(2),
       is_open,
       viewed(2)},
      {"view.point",
       "View",
       "Points",
       {'4', false, false},
       "A colour a point: seams that are not welded light up",
       view(3),
       is_open,
       viewed(3)},
      {"view.mask",
       "View",
       "Mask",
       {'5', false, false},
       "How far the selected layer reaches",
       view(4),
       is_open,
       viewed(4)},
      {"view.bias",
       "View",
       "Bias",
       {'6', false, false},
       "Rest bias of the selected layer",
       view(5),
       is_open,
       viewed(5)},
      {"view.confidence",
       "View",
       "Confidence",
       {'7', false, false},
       "How sure the direction is",
       view(6),
       is_open,
       viewed(6)},
      {"view.morph",
       "View",
       "Morphs",
       {'8', false, false},
       "How far morph targets move each place",
       view(7),
       is_open,
       viewed(7)},
      {"view.uv",
       "View",
       "UV layout",
       {'9', false, false},
       "The charts in UV space; those of the selected layer are bright",
       view(8),
       is_open,
       viewed(8)},
      {"view.split",
       "View",
       "Split screen",
       {'W', false, false},
       "Two settings side by side with a divider to drag",
       [&s] { s.split = !s.split; },
       is_open,
       [&s] { return s.split; },
       true},
      {"view.compare",
       "View",
       "Compare with file ...",
       {},
       "Another asset, or another recipe for this mesh, on the right side",
       [&s] { s.dialog = Dialog::kCompare; },
       is_open},
      {"view.all",
       "View",
       "Frame all",
       {'A', false, false},
       "Move the camera so that everything is seen",
       [this] {
         if (frame_) viewport_.frameAll(state_, *frame_);
       },
       is_open,
       {},
       true},
      {"view.selected",
       "View",
       "Frame layer",
       {'F', false, false},
       "Move the camera to where the selected layer reaches",
       [this] {
         if (frame_) viewport_.frameLayer(state_, *frame_);
       },
       is_open},
      {"view.front",
       "View",
       "From the front",
       {'T', false, false},
       "Camera at the front",
       turned(0, 0),
       is_open},
      {"view.side",
       "View",
       "From the side",
       {'R', false, false},
       "Camera at the character's left",
       turned(90, 0),
       is_open},
      {"view.lights",
       "View",
       "Turn lights",
       {'L', false, false},
       "Turn the lights by 15 degrees; right drag in the view turns them freely",
       [&s] { s.light_yaw = std::remainder(s.light_yaw + 15.0f, 360.0f); },
       is_open},
      {"view.lights_back",
       "View",
       "Lights back",
       {'L', false, true},
       "Lights as at the start",
       [&s] { s.light_yaw = 0.0f; },
       is_open},
      {"view.left",
       "View",
       "Layer panel",
       {},
       "Show or hide the panel on the left",
       [&s] { s.settings.show_left = !s.settings.show_left; },
       [] { return true; },
       [&s] { return s.settings.show_left; },
       true},
      {"view.right",
       "View",
       "Slider panel",
       {},
       "Show or hide the panel on the right",
       [&s] { s.settings.show_right = !s.settings.show_right; },
       [] { return true; },
       [&s] { return s.settings.show_right; }},
      {"view.larger",
       "View",
       "Larger text",
       {'=', true, false},
       "Larger text and widgets, up to 4 times the usual size",
       scale(1.1f),
       [] { return true; },
       {},
       true},
      {"view.smaller",
       "View",
       "Smaller text",
       {'-', true, false},
       "Smaller text and widgets, down to half the usual size",
       scale(1.0f / 1.1f)},
      {"view.problems",
       "View",
       "Messages",
       {'J', true, false},
       "Show or hide what went wrong and what there is to know",
       [&s] { s.problems_shown = !s.problems_shown; },
       [] { return true; },
       [&s] { return s.problems_shown; }},

      {"play.play",
       "Play",
       "Play / pause",
       {key::kSpace, false, false},
       "Play or pause the clip",
       [&s] { s.session.player.playing = !s.session.player.playing; },
       is_open},
      {"play.start",
       "Play",
       "To the start",
       {key::kHome, false, false},
       "Back to 0 s",
       [&s] { s.session.player.time = 0.0; },
       is_open},
      {"play.loop",
       "Play",
       "Loop",
       {},
       "Begin again at the end",
       [&s] { s.session.player.loop = !s.session.player.loop; },
       is_open,
       [&s] { return s.session.player.loop; }},
      {"play.back",
       "Play",
       "Step back",
       {',', false, false},
       "A frame of 1/30 s back",
       [&s] { s.session.player.time = std::max(0.0, s.session.player.time - 1.0 / 30.0); },
       is_open},
      {"play.forth",
       "Play",
       "Step forward",
       {'.', false, false},
       "A frame of 1/30 s on",
       [&s] {
         Player& player = s.session.player;
         player.time = std::min(player.duration(s.session.shown()->loaded->rig), player.time + 1.0 / 30.0);
       },
       is_open},

      {"help.keys",
       "Help",
       "Keys and mouse",
       {key::kF1, false, false},
       "Every key and what the mouse does",
       [&s] { s.keys_shown = true; }},

      {"help.face",
       "Help",
       "Sample: face",
       {},
       "Open the demo face, to try things on",
       [this] { samples_.ask("face"); },
       [this] { return !samples_.making(); },
       {},
       true},
      {"help.jacket",
       "Help",
       "Sample: jacket",
       {},
       "Open the demo jacket, to try things on",
       [this] { samples_.ask("jacket"); },
       [this] { return !samples_.making(); }},

      {"cursor.left", "", "", {key::kLeft, false, false}, "Keyboard brush to the left", nudge(-1, 0), cursor},
      {"cursor.right",
       "",
       "",
       {key::kRight, false, false},
       "Keyboard brush to the right",
       nudge(1, 0),
       cursor},
      {"cursor.up", "", "", {key::kUp, false, false}, "Keyboard brush upwards", nudge(0, -1), cursor},
      {"cursor.down", "", "", {key::kDown, false, false}, "Keyboard brush downwards", nudge(0, 1), cursor},
      {"camera.left", "", "", {key::kLeft, false, false}, "Orbit to the left", orbit(-5, 0), is_open},
      {"camera.right", "", "", {key::kRight, false, false}, "Orbit to the right", orbit(5, 0), is_open},
      {"camera.up", "", "", {key::kUp, false, false}, "Orbit upwards", orbit(0, 5), is_open},
      {"camera.down", "", "", {key::kDown, false, false}, "Orbit downwards", orbit(0, -5), is_open},
      {"camera.pan_left",
       "",
       "",
       {key::kLeft, false, true},
       "Move the view to the left",
       pan(-1, 0),
       is_open},
      {"camera.pan_right",
       "",
       "",
       {key::kRight, false, true},
       "Move the view to the right",
       pan(1, 0),
       is_open},
      {"camera.pan_up", "", "", {key::kUp, false, true}, "Move the view upwards", pan(0, 1), is_open},
      {"camera.pan_down", "", "", {key::kDown, false, true}, "Move the view downwards", pan(0, -1), is_open},
      {"divider.left",
       "",
       "",
       {key::kLeft, true, false},
       "Divider of the split screen to the left",
       divide(-0.02f),
       split},
      {"divider.right",
       "",
       "",
       {key::kRight, true, false},
       "Divider of the split screen to the right",
       divide(0.02f),
       split},
      {"panels.narrower", "", "", {key::kLeft, true, true}, "Narrower panels", widen(-1.5f)},
      {"panels.wider", "", "", {key::kRight, true, true}, "Wider panels", widen(1.5f)},
      {"camera.in", "", "", {'=', false, false}, "Zoom in", zoom(1.0f / 1.15f), is_open},
      {"camera.out", "", "", {'-', false, false}, "Zoom out", zoom(1.15f), is_open},
  };
}

void Editor::open(const fs::path& file) {
  state_.leaving = [this, file] {
    const size_t before = state_.session.messages().size();
    state_.session.open(file);
    const std::vector<Message>& messages = state_.session.messages();
    const bool failed =
        std::any_of(messages.begin() + static_cast<std::ptrdiff_t>(std::min(before, messages.size())),
                    messages.end(), [](const Message& m) { return m.kind == Message::Kind::kError; });
    if (failed) return;
    state_.settings.opened(file);
    state_.framed = false;
    state_.split = false;
    state_.tool = Tool::kLook;
    state_.looks[0].view = 0;
    state_.camera = {};
    viewport_.release();
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

// The selected layer is one that there is.
void Editor::keepSelection() {
  if (state_.session.editable()) {
    const auto& layers = state_.session.document.recipe().layers;
    if (state_.documentLayer() == pipeline::kNoIndex && !layers.empty()) state_.layer = layers.front().name;
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

void Editor::frame(double seconds) {
  beginFrame();
  Session& session = state_.session;
  session.update(seconds);
  takeSample();
  keepSelection();
  frame_.reset();
  if (session.shown()) frame_ = session.player.frame(*session.shown()->loaded);
  if (share_.running()) share_.step(state_, viewport_);
  runKeys(actions_);

  const ImVec2 screen = ImGui::GetIO().DisplaySize;
  drawMenuBar();
  const float top = ImGui::GetFrameHeight();
  const float line = ImGui::GetFrameHeight() + 2.0f * ImGui::GetStyle().WindowPadding.y;
  const float tools = two_rows_ ? line + ImGui::GetFrameHeightWithSpacing() : line;
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
  beginPanel("View", {left, body_top}, {middle, body - problems},
             ImGuiWindowFlags_NoScrollWithMouse | ImGuiWindowFlags_NoNavInputs);
  ImGui::PopStyleVar();
  if (panels)
    viewport_.draw(state_, frame_ ? &*frame_ : nullptr);
  else
    drawFirstStart(state_, samples_, [this](const fs::path& file) { open(file); });
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
  const std::vector<Message>& messages = session.messages();
  for (; told_ < messages.size(); ++told_)
    if (messages[told_].kind == Message::Kind::kError) state_.problems_shown = true;
  told_ = messages.size();
  if (!ImGui::IsAnyItemActive()) session.document.endGesture();
}

void Editor::drawMenuBar() {
  if (!ImGui::BeginMainMenuBar()) return;
  drawMenus(actions_);
  const std::string name = title();
  const float width = ImGui::CalcTextSize(name.c_str()).x;
  ImGui::SameLine(ImGui::GetWindowWidth() - width - em());
  ImGui::TextDisabled("%s", name.c_str());
  ImGui::EndMainMenuBar();
}

void Editor::drawToolbar() {
  const auto group = [&](std::initializer_list<std::pair<const char*, const char*>> buttons) {
    for (const auto& [id, label] : buttons) {
      actionButton(actions_, id, label);
      ImGui::SameLine(0.0f, 3.0f);
    }
    ImGui::SameLine(0.0f, 1.2f * em());
  };
  group({{"file.save", state_.session.document.dirty() ? "Save *" : "Save"}, {"file.cook", "Cook ..."}});
  group({{"edit.undo", "\xe2\x86\xb6"}, {"edit.redo", "\xe2\x86\xb7"}});
  group({{"tool.look", "Look"},
         {"tool.bias", "Bias"},
         {"tool.mask", "Mask"},
         {"tool.comb", "Comb"},
         {"tool.guide", "Guide"}});
  drawTools();
  // From here on aligned to the right, or in a row of its own.
  const float wide = (state_.split ? 47.5f : 25.5f) * em();
  const float used = ImGui::GetItemRectMax().x + em();
  two_rows_ = used + wide > ImGui::GetWindowWidth();
  if (!two_rows_) ImGui::SameLine(ImGui::GetWindowWidth() - wide);
  for (int side = 0; side < (state_.split ? 2 : 1); ++side) {
    Look& look = state_.looks[side];
    const std::string name = side == 0 ? "look" : "look2";
    if (side == 1) ImGui::SameLine(0.0f, 1.2f * em());
    const auto combo = [&](const char* part, int& value, std::span<const char* const> names, float width,
                           const char* tip) {
      const std::string id = name + "." + part;
      ImGui::SetNextItemWidth(width * em());
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
    combo("view", look.view, kViewNames, 6.6f, "What the view shows  (1 to 9)");
    ImGui::SameLine(0.0f, 3.0f);
    ImGui::BeginDisabled(look.view != 0);
    combo("shading", look.shading, kShadingNames, 7.6f,
          "How wrinkles are drawn: Larsson's three methods, or not at all");
    ImGui::EndDisabled();
    ImGui::SameLine(0.0f, 3.0f);
    constexpr const char* kTiers[] = {"auto", "gpu", "gpu-raster", "cpu"};
    int tier = 0;
    for (int i = 0; i < 4; ++i)
      if (look.tier == kTiers[i]) tier = i;
    combo("tier", tier, kTiers, 5.6f,
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
                 "Radius of the brush in % of the character's size, 0.2 to 50  ([ and ], Ctrl + wheel)",
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
  actionButton(actions_, "brush.mirror", "Mirror");
  ImGui::SameLine(0.0f, 3.0f);
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
  ImGui::SameLine(0.0f, 1.5f * em());
  const Drawn& drawn = state_.drawn[0];
  ImGui::TextDisabled("%s", drawn.tier.c_str());
  mark("status.tier");
  tooltip(drawn.reason.c_str());
  ImGui::SameLine(0.0f, 1.5f * em());
  std::string times;
  for (const preview::StageTime& part : drawn.times) {
    char text[48];
    std::snprintf(text, sizeof text, "%.*s %.2f  ", static_cast<int>(part.name.size()), part.name.data(),
                  state_.scripted ? 0.0 : part.milliseconds);
    times += text;
  }
  ImGui::TextDisabled("%sms", times.c_str());
  mark("status.times");
  tooltip("Milliseconds of every stage of the last picture, all layers together, waiting for each to end");
  if (!session.messages().empty()) {
    const Message& last = session.messages().back();
    std::string text = state_.brief(last.text);
    const float room = ImGui::GetWindowWidth() - ImGui::GetItemRectMax().x - 2.0f * em();
    if (room < 6.0f * em()) return;
    if (ImGui::CalcTextSize(text.c_str()).x > room) {
      while (!text.empty() && ImGui::CalcTextSize((text + kEllipsis).c_str()).x > room) text.pop_back();
      text += kEllipsis;
    }
    const float width = ImGui::CalcTextSize(text.c_str()).x + em();
    ImGui::SameLine(std::max(ImGui::GetItemRectMax().x + em(), ImGui::GetWindowWidth() - width));
    ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(last.kind == Message::Kind::kError     ? Colors::kRed
                                                      : last.kind == Message::Kind::kWarning ? Colors::kAccent
                                                                                             : Colors::kDim),
                       "%s", text.c_str());
    if (ImGui::IsItemClicked()) state_.problems_shown = !state_.problems_shown;
    mark("status.message");
    tooltip((last.text + "\n(click: all messages)").c_str());
  }
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
      files_.open("Open", folder, kMeshes, false, [this](const fs::path& file) { open(file); });
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
      files_.open("Compare with", folder, kMeshes, false, [this](const fs::path& file) {
        state_.session.compareWith(file);
        state_.split = true;
        state_.looks[1] = state_.looks[0];
        state_.looks[1].compared = true;
      });
      break;
    case Dialog::kTexture:
      files_.open("Choose image", folder, kImages, false, state_.texture_chosen);
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
