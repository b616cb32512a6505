#include "editor/preview/contact_sheet.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>

namespace furrow::preview {

namespace {

using pipeline::Image;

constexpr uint32_t kFontHeight = 13;  // of the pixel font that imgui carries
constexpr float kPaper = 0.105f, kCaption = 0.82f, kTitle = 0.95f;

void blit(Image& sheet, const Image& picture, uint32_t x0, uint32_t y0) {
  for (uint32_t y = 0; y < picture.height; ++y)
    for (uint32_t x = 0; x < picture.width; ++x)
      for (uint32_t c = 0; c < 3; ++c)
        sheet.at(x0 + x, y0 + y)[c] = picture.at(x, y)[picture.channels < 3 ? 0 : c];
}

}  // namespace

uint32_t drawText(Image& image, uint32_t x, uint32_t y, uint32_t height, const std::string& text,
                  float grey) {
  ImFontAtlas atlas;
  ImFontConfig config;
  config.SizePixels = static_cast<float>(height);
  config.OversampleH = config.OversampleV = 1;
  config.PixelSnapH = true;
  const ImFont* font = atlas.AddFontDefault(&config);
  unsigned char* coverage = nullptr;
  int width = 0, rows = 0;
  atlas.GetTexDataAsAlpha8(&coverage, &width, &rows);

  float pen = static_cast<float>(x);
  for (const char character : text) {
    const ImFontGlyph* glyph = font->FindGlyph(static_cast<ImWchar>(static_cast<unsigned char>(character)));
    const int u0 = static_cast<int>(std::lround(glyph->U0 * static_cast<float>(width)));
    const int v0 = static_cast<int>(std::lround(glyph->V0 * static_cast<float>(rows)));
    const int w = static_cast<int>(std::lround(glyph->X1 - glyph->X0));
    const int h = static_cast<int>(std::lround(glyph->Y1 - glyph->Y0));
    const int left = static_cast<int>(std::lround(pen + glyph->X0));
    const int top = static_cast<int>(std::lround(static_cast<float>(y) + glyph->Y0));
    for (int j = 0; j < h; ++j)
      for (int i = 0; i < w; ++i) {
        const int px = left + i, py = top + j;
        if (px < 0 || py < 0 || px >= static_cast<int>(image.width) || py >= static_cast<int>(image.height))
          continue;
        const float cover = static_cast<float>(coverage[(v0 + j) * width + u0 + i]) / 255.0f;
        float* pixel = image.at(static_cast<uint32_t>(px), static_cast<uint32_t>(py));
        for (uint32_t c = 0; c < std::min(image.channels, 3u); ++c) pixel[c] += cover * (grey - pixel[c]);
      }
    pen += glyph->AdvanceX;
  }
  return static_cast<uint32_t>(std::lround(pen)) - x;
}

Image contactSheet(std::span<const SheetCell> cells, const SheetLayout& layout) {
  if (cells.empty()) return {};
  uint32_t width = 0, height = 0;
  for (const SheetCell& cell : cells) {
    width = std::max(width, cell.picture->width);
    height = std::max(height, cell.picture->height);
  }
  const uint32_t text = layout.text_height ? layout.text_height : std::max(width / 256, 1u) * kFontHeight;
  const uint32_t columns = std::clamp(layout.columns, 1u, static_cast<uint32_t>(cells.size()));
  const uint32_t lines = (static_cast<uint32_t>(cells.size()) + columns - 1) / columns;
  const uint32_t line = text + text / 4;  // descenders reach below the font's height
  const uint32_t gap = layout.gap, pitch = height + line + gap / 2 + gap;
  const uint32_t head = gap + (layout.title.empty() ? 0 : line + gap);

  Image sheet{columns * (width + gap) + gap, head + lines * pitch, 4, {}};
  sheet.pixels.assign(size_t{sheet.width} * sheet.height * 4, kPaper);
  for (size_t i = 3; i < sheet.pixels.size(); i += 4) sheet.pixels[i] = 1.0f;
  if (!layout.title.empty()) drawText(sheet, gap, gap, text, layout.title, kTitle);

  for (uint32_t i = 0; i < cells.size(); ++i) {
    const Image& picture = *cells[i].picture;
    const uint32_t x = gap + i % columns * (width + gap), y = head + i / columns * pitch;
    blit(sheet, picture, x + (width - picture.width) / 2, y + (height - picture.height) / 2);
    // Drawn on a strip of its own, so that a long caption ends at the edge of its cell.
    Image strip{width, line, 3, std::vector<float>(size_t{width} * line * 3, kPaper)};
    drawText(strip, 0, 0, text, cells[i].caption, kCaption);
    blit(sheet, strip, x, y + height + gap / 2);
  }
  return sheet;
}

}  // namespace furrow::preview
