#pragma once

// Numbers that the cook works out are kept to what a person would write into a recipe.

#include <charconv>

namespace furrow::pipeline {

// x to four significant digits.
inline double legible(double x) {
  char text[40];
  const auto end = std::to_chars(text, text + sizeof text, x, std::chars_format::scientific, 3).ptr;
  std::from_chars(text, end, x);
  return x;
}

}  // namespace furrow::pipeline
