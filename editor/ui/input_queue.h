#pragma once

// What a window's events do to imgui, in their order: a key or button that goes down and up again between two
// frames is down for a frame of its own, and a key or the wheel has the modifiers that were down with it.
// Slow frames (a software renderer, a big cook beside it) lose nothing.

#include <imgui.h>

#include <bitset>
#include <cfloat>
#include <cstdint>
#include <deque>

namespace furrow::editor::ui {

class InputQueue {
 public:
  void key(int key, bool down);        // at GLFW's index
  void button(int button, bool down);  // 0 left, 1 right, 2 middle
  void pointer(ImVec2 at);             // pixels of the window
  void pointerLeft();
  void wheel(float x, float y);
  void text(unsigned character);
  void release();  // all that is down: the window has lost the keyboard

  bool empty() const { return events_.empty(); }
  // Before every ImGui::NewFrame(): the events up to the first that would undo one of this frame.
  void apply(ImGuiIO& io);

 private:
  enum class Kind : uint8_t { kKey, kButton, kPointer, kWheel, kText };
  struct Event {
    Kind kind;
    int code = 0;
    bool down = false;
    ImVec2 value{};
  };
  static constexpr int kButtons = 3, kKeys = 512;
  struct Frame {
    std::bitset<kKeys> keys;
    std::bitset<kButtons> buttons;
    bool pressed = false;  // a key, with what modifies it
    bool moved = false, wheeled = false, typed = false;
  };
  static bool fits(const Event& event, Frame& seen);

  std::deque<Event> events_;
  std::bitset<kKeys> keys_;  // as the last event leaves it
  std::bitset<kButtons> buttons_;
  ImVec2 pointer_{-FLT_MAX, -FLT_MAX};  // as the last frame had it
  std::bitset<kButtons> held_;
};

}  // namespace furrow::editor::ui
