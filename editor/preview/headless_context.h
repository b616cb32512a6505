#pragma once

// An OpenGL core context without a window, for the tools and the tests.

#include <memory>

namespace furrow::preview {

// Made current on the constructing thread, released by the destructor; objects made in it must be gone by
// then. Asks EGL for a surfaceless Mesa display first and for the first EGL device that works next, and for
// OpenGL 4.5, 4.3 and 3.3 in this order.
class HeadlessContext {
 public:
  HeadlessContext();  // throws pipeline::Error (kEnvironment) where no display gives a context
  ~HeadlessContext();
  HeadlessContext(const HeadlessContext&) = delete;
  HeadlessContext& operator=(const HeadlessContext&) = delete;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace furrow::preview
