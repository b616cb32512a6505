#pragma once

namespace furrow::pipeline {

// Gives memory back; a vector keeps it when it is merely cleared, or given {}.
template <typename... T>
void release(T&... values) {
  ((values = T()), ...);
}

}  // namespace furrow::pipeline
