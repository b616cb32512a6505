// What the editor can be asked for. Keys ask for the first that is enabled: those of the brush by keyboard
// come before those of the camera and the clip.

#include <algorithm>
#include <cmath>
#include <iterator>

#include "editor/ui/editor.h"
#include "editor/ui/widgets.h"

namespace furrow::editor::ui {
namespace {

namespace fs = std::filesystem;

constexpr float kCursorStep = 0.01f;  // of the picture's sides
constexpr float kPanStep = 0.05f;     // of the picture's height

}  // namespace

void Editor::makeActions() {
  for (const auto make : {&Editor::fileActions, &Editor::editActions, &Editor::brushKeys,
                          &Editor::viewActions, &Editor::cameraActions, &Editor::screenActions,
                          &Editor::playActions, &Editor::helpActions, &Editor::viewKeys}) {
    std::vector<Action> some = (this->*make)();
    std::move(some.begin(), some.end(), std::back_inserter(actions_));
  }
}

std::vector<Action> Editor::fileActions() {
  State& s = state_;
  const auto has_picture = [&s] {
    return s.session.shown() && s.looks[0].view != kUvView && (!s.split || s.looks[1].view != kUvView);
  };
  const auto editable = [&s] { return s.session.editable(); };
  return {{.id = "file.open",
           .menu = "File",
           .label = "Open ...",
           .chord = {.key = 'O', .ctrl = true},
           .tip = "Open a mesh, a recipe or a cooked asset",
           .run = [&s] { s.dialog = Dialog::kOpen; }},
          {.id = "file.recent",
           .menu = "File",
           .label = "Open recent",
           .tip = "The files that were opened last",
           .enabled = [&s] { return !s.settings.recent.empty(); },
           .submenu = [this, &s] { drawRecent(s, "file", [this](const fs::path& file) { open(file); }); }},
          {.id = "file.save",
           .menu = "File",
           .label = "Save recipe",
           .chord = {.key = 'S', .ctrl = true},
           .tip = "Write the recipe and its painted images",
           .run = [&s] { s.session.save(s.session.document.file()); },
           .enabled = editable,
           .separated = true},
          {.id = "file.save_as",
           .menu = "File",
           .label = "Save recipe as ...",
           .chord = {.key = 'S', .ctrl = true, .shift = true},
           .tip = "Write the recipe under another name",
           .run = [&s] { s.dialog = Dialog::kSaveAs; },
           .enabled = editable},
          {.id = "file.cook",
           .menu = "File",
           .label = "Cook asset ...",
           .chord = {.key = 'K', .ctrl = true},
           .tip = "Cook the .furrow asset as 'furrow cook' does, in the background",
           .run = [&s] { s.dialog = Dialog::kCookTo; },
           .enabled = editable},
          {.id = "file.image",
           .menu = "File",
           .label = "Save picture ...",
           .chord = {.key = 'P', .ctrl = true},
           .tip = "Write what the view shows, both sides of a split one, as a PNG file; not the UV layout",
           .run = [&s] { s.dialog = Dialog::kImage; },
           .enabled = has_picture,
           .separated = true},
          {.id = "file.turntable",
           .menu = "File",
           .label = "Turntable frames ...",
           .tip = "Write a whole turn of the character as numbered PNG files",
           .run =
               [this, &s] {
                 files_.open("Write turntable frames into a folder", s.settings.folder, {}, true,
                             [this](const fs::path& folder) { share_.startTurntable(folder); });
               },
           .enabled = [this, has_picture] { return has_picture() && !share_.running(); }},
          {.id = "file.clip",
           .menu = "File",
           .label = "Clip frames ...",
           .tip = "Write what plays as numbered PNG files",
           .run =
               [this, &s] {
                 files_.open("Write clip frames into a folder", s.settings.folder, {}, true,
                             [this, &s](const fs::path& folder) { share_.startClip(s, folder); });
               },
           .enabled =
               [this, &s, has_picture] {
                 return has_picture() && !share_.running() &&
                        s.session.player.duration(s.session.shown()->loaded->rig) > 0.0;
               }},
          {.id = "file.quit",
           .menu = "File",
           .label = "Quit",
           .chord = {.key = 'Q', .ctrl = true},
           .tip = "Leave; unsaved work is asked about",
           .run = [this] { askToQuit(); },
           .separated = true}};
}

std::vector<Action> Editor::editActions() {
  State& s = state_;
  const auto editable = [&s] { return s.session.editable(); };
  const auto tool = [&s](Tool to) { return [&s, to] { s.take(to); }; };
  const auto uses = [&s](Tool of) { return [&s, of] { return s.tool == of; }; };
  return {{.id = "edit.undo",
           .menu = "Edit",
           .label = "Undo",
           .chord = {.key = 'Z', .ctrl = true},
           .tip = "Take the last edit back",
           .run = [&s] { s.session.document.undo(); },
           .enabled = [&s] { return !s.session.document.undoName().empty(); },
           .on = [&s] { return s.session.document.undoName(); }},
          {.id = "edit.redo",
           .menu = "Edit",
           .label = "Redo",
           .chord = {.key = 'Z', .ctrl = true, .shift = true},
           .tip = "Make the edit again that was taken back",
           .run = [&s] { s.session.document.redo(); },
           .enabled = [&s] { return !s.session.document.redoName().empty(); },
           .on = [&s] { return s.session.document.redoName(); }},
          {.id = "tool.look",
           .menu = "Edit",
           .label = "Look",
           .chord = {.key = 'Q'},
           .tip = "Left drag orbits",
           .run = tool(Tool::kLook),
           .checked = uses(Tool::kLook),
           .separated = true},
          {.id = "tool.bias",
           .menu = "Edit",
           .label = "Paint rest bias",
           .chord = {.key = 'B'},
           .tip = "Paint where wrinkles are there at rest, or never",
           .run = tool(Tool::kBias),
           .enabled = editable,
           .checked = uses(Tool::kBias)},
          {.id = "tool.mask",
           .menu = "Edit",
           .label = "Paint mask",
           .chord = {.key = 'M'},
           .tip = "Paint how far the selected layer reaches",
           .run = tool(Tool::kMask),
           .enabled = editable,
           .checked = uses(Tool::kMask)},
          {.id = "tool.comb",
           .menu = "Edit",
           .label = "Comb directions",
           .chord = {.key = 'D'},
           .tip = "Stroke along the creases you want",
           .run = tool(Tool::kComb),
           .enabled = editable,
           .checked = uses(Tool::kComb)},
          {.id = "tool.guide",
           .menu = "Edit",
           .label = "Draw guides",
           .chord = {.key = 'G'},
           .tip = "Draw curves along the creases; the direction follows them",
           .run = tool(Tool::kGuide),
           .enabled = editable,
           .checked = uses(Tool::kGuide)},
          {.id = "brush.mirror",
           .menu = "Edit",
           .label = "Mirror strokes",
           .chord = {.key = 'X'},
           .tip = "Paint on the other side too",
           .run = [&s] { s.brush.mirror = !s.brush.mirror; },
           .enabled = editable,
           .checked = [&s] { return s.brush.mirror; }},
          {.id = "brush.mirror_axis",
           .menu = "Edit",
           .label = "Mirror at",
           .tip = "The plane of the scene that strokes are mirrored at",
           .enabled = editable,
           .submenu =
               [&s] {
                 constexpr const char* kPlanes[] = {"x = 0", "y = 0", "z = 0"};
                 for (int axis = 0; axis < 3; ++axis) {
                   if (ImGui::MenuItem(kPlanes[axis], nullptr, s.brush.mirror_axis == axis))
                     s.brush.mirror_axis = axis;
                   mark(("brush.mirror_axis." + std::to_string(axis)).c_str());
                 }
               }},
          {.id = "brush.erase",
           .menu = "Edit",
           .label = "Erase",
           .chord = {.key = 'E'},
           .tip = "Strokes take away; or hold Ctrl",
           .run = [&s] { s.brush.erase = !s.brush.erase; },
           .enabled = editable,
           .checked = [&s] { return s.brush.erase; }},
          {.id = "brush.keyboard",
           .menu = "Edit",
           .label = "Brush by keyboard",
           .chord = {.key = 'C'},
           .tip = "Move the brush with the arrows, in place of the mouse; Space puts it down and lifts it",
           .run =
               [&s] {
                 s.cursor = s.cursor ? std::nullopt : std::optional(ImVec2(0.5f, 0.5f));
                 s.cursor_down = false;
               },
           .enabled = [&s] { return s.session.shown() && s.session.editable() && s.tool != Tool::kLook; },
           .checked = [&s] { return s.cursor.has_value(); }}};
}

std::vector<Action> Editor::brushKeys() {
  State& s = state_;
  const auto cursor = [&s] { return s.cursor.has_value(); };
  const auto nudge = [&s](float x, float y) {
    return [&s, x, y] {
      s.cursor->x = std::clamp(s.cursor->x + kCursorStep * x, 0.0f, 1.0f);
      s.cursor->y = std::clamp(s.cursor->y + kCursorStep * y, 0.0f, 1.0f);
    };
  };
  return {{.id = "brush.down",
           .chord = {.key = key::kSpace},
           .tip = "With the brush by keyboard: put it down, lift it",
           .run = [&s] { s.cursor_down = !s.cursor_down; },
           .enabled = cursor},
          {.id = "brush.smaller",
           .chord = {.key = '['},
           .tip = "Smaller brush",
           .run = [&s] { s.brush.size = std::max(0.002f, s.brush.size / 1.2f); }},
          {.id = "brush.larger",
           .chord = {.key = ']'},
           .tip = "Larger brush",
           .run = [&s] { s.brush.size = std::min(0.5f, s.brush.size * 1.2f); }},
          {.id = "cursor.left",
           .chord = {.key = key::kLeft},
           .tip = "Keyboard brush to the left",
           .run = nudge(-1, 0),
           .enabled = cursor},
          {.id = "cursor.right",
           .chord = {.key = key::kRight},
           .tip = "Keyboard brush to the right",
           .run = nudge(1, 0),
           .enabled = cursor},
          {.id = "cursor.up",
           .chord = {.key = key::kUp},
           .tip = "Keyboard brush upwards",
           .run = nudge(0, -1),
           .enabled = cursor},
          {.id = "cursor.down",
           .chord = {.key = key::kDown},
           .tip = "Keyboard brush downwards",
           .run = nudge(0, 1),
           .enabled = cursor}};
}

std::vector<Action> Editor::viewActions() {
  State& s = state_;
  const auto is_open = [&s] { return s.session.shown() != nullptr; };
  struct View {
    const char *id, *tip;
  };
  constexpr View kViews[] = {
      {"view.beauty", "The lit surface with its wrinkles"},
      {"view.weight", "Weight of the selected layer: red squeezed, blue stretched"},
      {"view.direction", "Strokes across the creases of the selected layer"},
      {"view.point", "A colour a point: seams that are not welded light up"},
      {"view.mask", "How far the selected layer reaches"},
      {"view.bias", "Rest bias of the selected layer"},
      {"view.confidence", "How sure the direction is"},
      {"view.morph", "How far morph targets move each place"},
      {"view.uv", "The charts in UV space; those of the selected layer are bright"},
  };
  static_assert(std::size(kViews) == std::size(kViewNames));
  std::vector<Action> actions;
  for (int i = 0; i < static_cast<int>(std::size(kViews)); ++i)
    actions.push_back({.id = kViews[i].id,
                       .menu = "View",
                       .label = kViewNames[i],
                       .chord = {.key = '1' + i},
                       .tip = kViews[i].tip,
                       .run = [&s, i] { s.looks[0].view = i; },
                       .enabled = is_open,
                       .checked = [&s, i] { return s.looks[0].view == i; }});
  actions.push_back({.id = "view.split",
                     .menu = "View",
                     .label = "Split screen",
                     .chord = {.key = 'W'},
                     .tip = "Two settings side by side with a divider to drag",
                     .run = [&s] { s.split = !s.split; },
                     .enabled = is_open,
                     .checked = [&s] { return s.split; },
                     .separated = true});
  actions.push_back({.id = "view.compare",
                     .menu = "View",
                     .label = "Compare with file ...",
                     .tip = "Another asset, or another recipe for this mesh, on the right side",
                     .run = [&s] { s.dialog = Dialog::kCompare; },
                     .enabled = is_open});
  return actions;
}

std::vector<Action> Editor::cameraActions() {
  State& s = state_;
  const auto is_open = [&s] { return s.session.shown() != nullptr; };
  const auto turned = [&s](float yaw, float pitch) {
    return [&s, yaw, pitch] {
      s.camera.yaw = yaw;
      s.camera.pitch = pitch;
    };
  };
  return {
      {.id = "view.all",
       .menu = "View",
       .label = "Frame all",
       .chord = {.key = 'A'},
       .tip = "Move the camera so that everything is seen",
       .run =
           [this] {
             if (frame_) viewport_.frameAll(state_, *frame_);
           },
       .enabled = is_open,
       .separated = true},
      {.id = "view.selected",
       .menu = "View",
       .label = "Frame layer",
       .chord = {.key = 'F'},
       .tip = "Move the camera to where the selected layer reaches",
       .run =
           [this] {
             if (frame_) viewport_.frameLayer(state_, *frame_);
           },
       .enabled = is_open},
      {.id = "view.front",
       .menu = "View",
       .label = "From the front",
       .chord = {.key = 'T'},
       .tip = "Camera at the front",
       .run = turned(0, 0),
       .enabled = is_open},
      {.id = "view.side",
       .menu = "View",
       .label = "From the side",
       .chord = {.key = 'R'},
       .tip = "Camera at the character's left",
       .run = turned(90, 0),
       .enabled = is_open},
      {.id = "view.z_up",
       .menu = "View",
       .label = "Z is up",
       .chord = {.key = 'U'},
       .tip = "Stand a character upright whose file has Z up, and orbit round that; as meshes of some tools",
       .run =
           [this] {
             state_.camera = {.z_up = !state_.camera.z_up};
             if (frame_) viewport_.frameAll(state_, *frame_);
           },
       .enabled = is_open,
       .checked = [&s] { return s.camera.z_up; }},
      {.id = "view.lights",
       .menu = "View",
       .label = "Turn lights",
       .chord = {.key = 'L'},
       .tip = "Turn the lights by 15 degrees; right drag in the view turns them freely",
       .run = [&s] { s.light_yaw = std::remainder(s.light_yaw + 15.0f, 360.0f); },
       .enabled = is_open},
      {.id = "view.lights_back",
       .menu = "View",
       .label = "Lights back",
       .chord = {.key = 'L', .shift = true},
       .tip = "Lights as at the start",
       .run = [&s] { s.light_yaw = 0.0f; },
       .enabled = is_open}};
}

std::vector<Action> Editor::screenActions() {
  State& s = state_;
  const auto scale = [&s](float by) {
    return [&s, by] {
      s.scale = std::clamp((s.scale > 0.0f ? s.scale : s.screen_scale) * by, 0.5f, 4.0f);
      s.settings.scale = s.scale;
    };
  };
  return {{.id = "view.left",
           .menu = "View",
           .label = "Layer panel",
           .tip = "Show or hide the panel on the left",
           .run = [&s] { s.settings.show_left = !s.settings.show_left; },
           .checked = [&s] { return s.settings.show_left; },
           .separated = true},
          {.id = "view.right",
           .menu = "View",
           .label = "Slider panel",
           .tip = "Show or hide the panel on the right",
           .run = [&s] { s.settings.show_right = !s.settings.show_right; },
           .checked = [&s] { return s.settings.show_right; }},
          {.id = "view.larger",
           .menu = "View",
           .label = "Larger text",
           .chord = {.key = '=', .ctrl = true},
           .tip = "Larger text and widgets, up to 4 times the usual size",
           .run = scale(1.1f),
           .separated = true},
          {.id = "view.smaller",
           .menu = "View",
           .label = "Smaller text",
           .chord = {.key = '-', .ctrl = true},
           .tip = "Smaller text and widgets, down to half the usual size",
           .run = scale(1.0f / 1.1f)},
          {.id = "view.problems",
           .menu = "View",
           .label = "Messages",
           .chord = {.key = 'J', .ctrl = true},
           .tip = "Show or hide what went wrong and what there is to know",
           .run = [&s] { s.problems_shown = !s.problems_shown; },
           .checked = [&s] { return s.problems_shown; }}};
}

std::vector<Action> Editor::playActions() {
  State& s = state_;
  const auto is_open = [&s] { return s.session.shown() != nullptr; };
  const auto plays = [&s] {
    return s.session.shown() && s.session.player.duration(s.session.shown()->loaded->rig) > 0.0;
  };
  return {{.id = "play.play",
           .menu = "Play",
           .label = "Play / pause",
           .chord = {.key = key::kSpace},
           .tip = "Play or pause the clip",
           .run = [&s] { s.session.player.playOrPause(s.session.shown()->loaded->rig); },
           .enabled = plays},
          {.id = "play.start",
           .menu = "Play",
           .label = "To the start",
           .chord = {.key = key::kHome},
           .tip = "Back to 0 s",
           .run = [&s] { s.session.player.time = 0.0; },
           .enabled = is_open},
          {.id = "play.loop",
           .menu = "Play",
           .label = "Loop",
           .tip = "Begin again at the end",
           .run = [&s] { s.session.player.loop = !s.session.player.loop; },
           .enabled = is_open,
           .checked = [&s] { return s.session.player.loop; }},
          {.id = "play.back",
           .menu = "Play",
           .label = "Step back",
           .chord = {.key = ','},
           .tip = "A frame of 1/30 s back",
           .run = [&s] { s.session.player.time = std::max(0.0, s.session.player.time - 1.0 / 30.0); },
           .enabled = is_open},
          {.id = "play.forth",
           .menu = "Play",
           .label = "Step forward",
           .chord = {.key = '.'},
           .tip = "A frame of 1/30 s on",
           .run =
               [&s] {
                 Player& player = s.session.player;
                 player.time =
                     std::min(player.duration(s.session.shown()->loaded->rig), player.time + 1.0 / 30.0);
               },
           .enabled = is_open}};
}

std::vector<Action> Editor::helpActions() {
  State& s = state_;
  return {{.id = "help.keys",
           .menu = "Help",
           .label = "Keys and mouse",
           .chord = {.key = key::kF1},
           .tip = "Every key and what the mouse does",
           .run = [&s] { s.keys_shown = true; }},
          {.id = "help.face",
           .menu = "Help",
           .label = "Sample: face",
           .tip = "Open the demo face, to try things on",
           .run = [this] { samples_.ask("face"); },
           .enabled = [this] { return !samples_.making(); },
           .separated = true},
          {.id = "help.jacket",
           .menu = "Help",
           .label = "Sample: jacket",
           .tip = "Open the demo jacket, to try things on",
           .run = [this] { samples_.ask("jacket"); },
           .enabled = [this] { return !samples_.making(); }}};
}

std::vector<Action> Editor::viewKeys() {
  State& s = state_;
  const auto is_open = [&s] { return s.session.shown() != nullptr; };
  const auto orbit = [&s](float yaw, float pitch) {
    return [&s, yaw, pitch] {
      s.camera.yaw = std::remainder(s.camera.yaw + yaw, 360.0f);
      s.camera.pitch = std::clamp(s.camera.pitch + pitch, -89.0f, 89.0f);
    };
  };
  const auto zoom = [&s](float steps) {
    return [&s, steps] { zoomCamera(s.camera, diagonalOf(s.session.shown()->view()), steps); };
  };
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
  const auto split = [&s] { return s.session.shown() && s.split; };
  return {
      {.id = "camera.left",
       .chord = {.key = key::kLeft},
       .tip = "Orbit to the left",
       .run = orbit(-5, 0),
       .enabled = is_open},
      {.id = "camera.right",
       .chord = {.key = key::kRight},
       .tip = "Orbit to the right",
       .run = orbit(5, 0),
       .enabled = is_open},
      {.id = "camera.up",
       .chord = {.key = key::kUp},
       .tip = "Orbit upwards",
       .run = orbit(0, 5),
       .enabled = is_open},
      {.id = "camera.down",
       .chord = {.key = key::kDown},
       .tip = "Orbit downwards",
       .run = orbit(0, -5),
       .enabled = is_open},
      {.id = "camera.pan_left",
       .chord = {.key = key::kLeft, .shift = true},
       .tip = "Move the view to the left",
       .run = pan(-1, 0),
       .enabled = is_open},
      {.id = "camera.pan_right",
       .chord = {.key = key::kRight, .shift = true},
       .tip = "Move the view to the right",
       .run = pan(1, 0),
       .enabled = is_open},
      {.id = "camera.pan_up",
       .chord = {.key = key::kUp, .shift = true},
       .tip = "Move the view upwards",
       .run = pan(0, 1),
       .enabled = is_open},
      {.id = "camera.pan_down",
       .chord = {.key = key::kDown, .shift = true},
       .tip = "Move the view downwards",
       .run = pan(0, -1),
       .enabled = is_open},
      {.id = "divider.left",
       .chord = {.key = key::kLeft, .ctrl = true},
       .tip = "Divider of the split screen to the left",
       .run = divide(-0.02f),
       .enabled = split},
      {.id = "divider.right",
       .chord = {.key = key::kRight, .ctrl = true},
       .tip = "Divider of the split screen to the right",
       .run = divide(0.02f),
       .enabled = split},
      {.id = "panels.narrower",
       .chord = {.key = key::kLeft, .ctrl = true, .shift = true},
       .tip = "Narrower panels",
       .run = widen(-1.5f)},
      {.id = "panels.wider",
       .chord = {.key = key::kRight, .ctrl = true, .shift = true},
       .tip = "Wider panels",
       .run = widen(1.5f)},
      {.id = "camera.in", .chord = {.key = '='}, .tip = "Zoom in", .run = zoom(1), .enabled = is_open},
      {.id = "camera.out", .chord = {.key = '-'}, .tip = "Zoom out", .run = zoom(-1), .enabled = is_open}};
}

}  // namespace furrow::editor::ui
