#pragma once

#include <algorithm>
#include <string>

namespace furrow::pipeline {

// The text with a space for every control character, so that it stays one line of a message, a table or a
// CSV.
inline std::string oneLine(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return (c >= 0 && c < ' ') || c == '\x7f'; }, ' ');
  return text;
}

}  // namespace furrow::pipeline
