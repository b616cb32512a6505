#pragma once

// Pictures side by side with captions, for the demo and for reports.

#include <span>
#include <string>

#include "pipeline/maps/image.h"

namespace furrow::preview {

struct SheetCell {
  const pipeline::Image* picture;  // 1, 3 or 4 channels
  std::string caption;             // one line of ASCII below the picture; what does not fit is cut off
};

struct SheetLayout {
  uint32_t columns = 1;  // >= 1
  uint32_t gap = 12;     // pixels round every cell
  // Of captions and title in pixels; a multiple of 13 is sharpest. 0: from the width of the cells.
  uint32_t text_height = 0;
  std::string title = {};  // above the grid; may be empty
};  // above the grid; may be empty
};

// Row-major grid of cells as large as the largest picture, pictures centred in them; 4 channels. Empty for no
// cells.
pipeline::Image contactSheet(std::span<const SheetCell> cells, const SheetLayout& layout);

// Draws ASCII text with its top left corner at x, y; what leaves the image is cut off. Returns the width in
// pixels.
uint32_t drawText(pipeline::Image& image, uint32_t x, uint32_t y, uint32_t height, const std::string& text,
                  float grey);

}  // namespace furrow::preview
