#pragma once

// What the panels share: the session, what is selected, and how it is looked at.

#include <imgui.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "editor/preview/camera.h"
#include "editor/preview/renderer.h"
#include "editor/session/paint.h"
#include "editor/session/session.h"
#include "editor/session/settings.h"

namespace furrow::editor::ui {

enum class Tool : uint8_t { kLook, kBias, kMask, kComb, kGuide };

// One side of the picture.
struct Look {
  int view = 0;     // of preview::View; kUvView behind them
  int shading = 0;  // of preview::Shading
  std::string tier = "auto";
  bool compared = false;  // shows Session::comparison()
};
inline constexpr const char* kViewNames[] = {"Beauty", "Weight",     "Direction", "Points",   "Mask",
                                             "Bias",   "Confidence", "Morphs",    "UV layout"};
inline constexpr int kUvView = 8;
inline constexpr float kLeastDivider = 0.02f;  // of the picture's width, on either side
inline constexpr const char* kShadingNames[] = {"Interpolated bump", "Bump blend", "Alpha shading",
                                                "No wrinkles"};

// What one side of the picture said about itself when it was last drawn.
struct Drawn {
  std::string tier, reason;  // or why nothing is drawn
  bool failed = false;
  bool lost = false;  // the tier that was wanted was, with its context
  preview::StageTimes times;
};

enum class Dialog : uint8_t { kNone, kOpen, kSaveAs, kCookTo, kTake, kCompare, kImage, kTexture, kRestFile };

struct State {
  State(Session& of, Settings& kept) : session(of), settings(kept), scale(kept.scale) {}

  Session& session;
  Settings& settings;
  bool scripted = false;  // nothing that differs from run to run is shown

  std::string layer;  // name of the selected one
  Tool tool = Tool::kLook;
  Brush brush;
  std::optional<ImVec2> cursor;  // of the brush by keyboard, in parts of the picture's sides
  bool cursor_down = false;

  preview::Camera camera;  // target in root space
  bool framed = false;     // the camera was set for what is open
  float light_yaw = 0.0f;  // degrees
  Look looks[2];
  Drawn drawn[2];
  bool split = false;
  float divider = 0.5f;  // of the picture's width
  // Of text and widgets: what is wanted, 0: what the screen asks for, and that.
  float scale, screen_scale = 1.0f;

  bool keys_shown = false, problems_shown = false;
  Dialog dialog = Dialog::kNone;
  std::function<void(const std::filesystem::path&)> file_chosen;  // what kTexture and kRestFile are for
  // What waits until the artist has said what becomes of unsaved work.
  std::function<void()> leaving;
  bool quit = false;

  // Of the selected layer: in the document, or kNoIndex; in the shown asset, or kNoIndex.
  uint32_t documentLayer() const;
  uint32_t assetLayer(const Shown& shown) const;
  // A message with the files beside what is open named without their folder.
  std::string brief(std::string text) const;
  // Edits the selected layer of the document, or what holds for all layers.
  void edit(const std::string& what, const std::function<void(pipeline::LayerRecipe&)>& change);
  void editAll(const std::string& what, const std::function<void(pipeline::Recipe&)>& change);
  void take(Tool to);  // with the view that shows what it changes
};

}  // namespace furrow::editor::ui
