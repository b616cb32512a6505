#pragma once

// Short names for the bindings of a frame plan's items.

#include <bit>

#include "furrow/frame_plan.h"

namespace furrow {

inline constexpr Binding kFrameBinding = {0, Buffer::kFrame, Access::kUniform, "frame_block"};

constexpr Binding storage(uint32_t slot, Buffer buffer, const char* name) {
  return {slot, buffer, Access::kStorage, name};
}
constexpr Binding floats(uint32_t slot, Buffer buffer, const char* name) {
  return {slot, buffer, Access::kFloats, name};
}
constexpr Binding words(uint32_t slot, Buffer buffer, const char* name) {
  return {slot, buffer, Access::kWords, name};
}
constexpr Binding capture(uint32_t slot, Buffer buffer) {
  return {slot, buffer, Access::kCapture, nullptr};
}

inline uint32_t wordOf(float value) {
  return std::bit_cast<uint32_t>(value);
}

}  // namespace furrow
