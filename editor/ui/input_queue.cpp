#include "editor/ui/input_queue.h"

namespace furrow::editor::ui {
namespace {

constexpr int kLeftShift = 340, kLeftControl = 341, kLeftAlt = 342, kRightShift = 344, kRightControl = 345,
              kRightAlt = 346;  // GLFW's

bool isModifier(int key) {
  return (key >= kLeftShift && key <= kLeftAlt) || (key >= kRightShift && key <= kRightAlt);
}

}  // namespace

void InputQueue::key(int key, bool down) {
  if (key < 0 || key >= kKeys || keys_[key] == down) return;
  keys_[key] = down;
  events_.push_back({.kind = Kind::kKey, .code = key, .down = down});
}

void InputQueue::button(int button, bool down) {
  if (button < 0 || button >= kButtons || buttons_[button] == down) return;
  buttons_[button] = down;
  events_.push_back({.kind = Kind::kButton, .code = button, .down = down});
}

void InputQueue::pointer(ImVec2 at) {
  // Only the last place between two other events counts.
  if (!events_.empty() && events_.back().kind == Kind::kPointer)
    events_.back().value = at;
  else
    events_.push_back({.kind = Kind::kPointer, .value = at});
}

void InputQueue::pointerLeft() {
  if (buttons_.none()) pointer({-FLT_MAX, -FLT_MAX});  // a drag goes on outside
}

void InputQueue::wheel(float x, float y) {
  events_.push_back({.kind = Kind::kWheel, .value = {x, y}});
}

void InputQueue::text(unsigned character) {
  events_.push_back({.kind = Kind::kText, .code = static_cast<int>(character)});
}

void InputQueue::release() {
  for (int k = 0; k < kKeys; ++k) key(k, false);
  for (int b = 0; b < kButtons; ++b) button(b, false);
}

// Whether the event can be part of the frame that has seen `seen`.
bool InputQueue::fits(const Event& event, Frame& seen) {
  const bool changed = seen.keys.any() || seen.buttons.any() || seen.wheeled;
  switch (event.kind) {
    case Kind::kPointer:
      if (changed) return false;  // a click or key is where the pointer was
      return seen.moved = true;
    case Kind::kButton:
      if (seen.keys.any() || seen.wheeled || seen.buttons[event.code]) return false;
      if (seen.moved && !event.down) return false;  // what is dragged has yet to follow
      seen.buttons.set(event.code);
      return true;
    case Kind::kKey:
      if (seen.buttons.any() || seen.wheeled || seen.typed || seen.pressed || seen.keys[event.code])
        return false;
      seen.keys.set(event.code);
      seen.pressed = event.down && !isModifier(event.code);
      return true;
    case Kind::kWheel:
      return seen.wheeled = true;
    case Kind::kText:
      return seen.typed = true;
  }
  return true;
}

void InputQueue::apply(ImGuiIO& io) {
  Frame seen;
  for (; !events_.empty() && fits(events_.front(), seen); events_.pop_front()) {
    const Event& event = events_.front();
    switch (event.kind) {
      case Kind::kPointer:
        pointer_ = event.value;
        break;
      case Kind::kButton:
        held_[event.code] = event.down;
        break;
      case Kind::kKey:
        io.KeysDown[event.code] = event.down;
        break;
      case Kind::kWheel:
        io.MouseWheelH += event.value.x;
        io.MouseWheel += event.value.y;
        break;
      case Kind::kText:
        io.AddInputCharacter(static_cast<unsigned>(event.code));
        break;
    }
  }
  io.MousePos = pointer_;
  for (int b = 0; b < kButtons; ++b) io.MouseDown[b] = held_[b];
  io.KeyCtrl = io.KeysDown[kLeftControl] || io.KeysDown[kRightControl];
  io.KeyShift = io.KeysDown[kLeftShift] || io.KeysDown[kRightShift];
  io.KeyAlt = io.KeysDown[kLeftAlt] || io.KeysDown[kRightAlt];
}

}  // namespace furrow::editor::ui
