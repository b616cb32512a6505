#pragma once

// Scripted sessions: the pointer, the keys and the clock come from a text, so that tests and the demo use the
// editor as a person would. One command a line, words apart by spaces, text with spaces in quotes, '#' begins
// a remark:
//
//   open FILE [stalled]               as the dialog would; stalled: no frame is drawn until it is cooked
//   drop FILE                         as if dropped on the window
//   wait                              until nothing is cooking
//   frames N                          lets N frames of 1/30 s pass
//   move ID [X Y]                     the pointer to a widget; X Y in parts of its size, default 0.5 0.5
//   click ID [X Y]   rightclick ID [X Y]   doubleclick ID [X Y]
//   drag ID X Y X Y [BUTTON [FRAMES]] BUTTON left (default), middle or right; FRAMES on the way, default 6
//   wheel ID TURNS
//   key CHORD                         "Ctrl+S", "Space", "F1"
//   hold CHORD   release              modifiers for what follows: "Ctrl", "Shift", "Alt"
//   type TEXT
//   picture NAME                      the whole window as NAME.png in the folder of frames
//   expect WORD ...                   fails unless: "expect message TEXT", "expect no error", "expect dirty",
//                                     "expect saved", "expect widget ID", "expect layers NAME ..."

#include <filesystem>
#include <functional>
#include <string>

#include "editor/ui/editor.h"
#include "pipeline/maps/image.h"

namespace furrow::editor::ui {

// A screen that a script can drive: begins and ends a frame of imgui and reads the picture of the last one.
struct Screen {
  std::function<void()> begin;               // events and ImGui::NewFrame(), but no pointer and no keys
  std::function<void()> end;                 // ImGui::Render() and drawing
  std::function<pipeline::Image()> picture;  // of the last frame, 4 channels, row 0 on top
  // The OpenGL context was lost before end(): another one, and imgui in it.
  std::function<void(const preview::ContextLost&)> remake;
};

// Throws pipeline::Error: kBadUsage naming script and line where a command is none, a widget is not on the
// screen, or an expectation fails; kEnvironment where a picture cannot be written. Keys are at GLFW's
// indices.
void runScript(const std::string& text, const std::string& name, Editor& editor, const Screen& screen,
               const std::filesystem::path& frames);

}  // namespace furrow::editor::ui
