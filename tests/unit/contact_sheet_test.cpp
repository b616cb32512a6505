#include "editor/preview/contact_sheet.h"

#include <gtest/gtest.h>

#include <vector>

namespace furrow::preview {
namespace {

using pipeline::Image;

Image plain(uint32_t width, uint32_t height, uint32_t channels, float value) {
  return {width, height, channels, std::vector<float>(size_t{width} * height * channels, value)};
}

uint32_t brightPixels(const Image& image, uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
  uint32_t count = 0;
  for (uint32_t y = y0; y < y1; ++y)
    for (uint32_t x = x0; x < x1; ++x) count += image.at(x, y)[0] > 0.5f;
  return count;
}

TEST(ContactSheet, PlacesPicturesInARowMajorGrid) {
  const Image red = plain(40, 30, 4, 0.0f), grey = plain(20, 30, 1, 0.4f), white = plain(40, 20, 3, 1.0f);
  const SheetCell cells[] = {{&red, ""}, {&grey, ""}, {&white, ""}};
  const Image sheet = contactSheet(cells, {.columns = 2, .gap = 8, .text_height = 13});
  EXPECT_EQ(sheet.width, 2u * 48 + 8);
  EXPECT_EQ(sheet.channels, 4u);
  EXPECT_EQ(sheet.at(8, 8)[0], 0.0f);
  EXPECT_EQ(sheet.at(8 + 48 + 20, 8 + 15)[2], 0.4f);  // centred, grey spread to all channels
  EXPECT_LT(sheet.at(8 + 48 + 2, 8 + 15)[2], 0.2f);   // beside it: paper
  EXPECT_EQ(sheet.at(8 + 20, sheet.height / 2 + 20)[1], 1.0f);
  for (size_t i = 3; i < sheet.pixels.size(); i += 4) ASSERT_EQ(sheet.pixels[i], 1.0f);
}

TEST(ContactSheet, WritesCaptionsInsideTheirCells) {
  const Image black = plain(60, 20, 4, 0.0f);
  const std::string endless(200, 'W');
  const SheetCell cells[] = {{&black, endless}, {&black, ""}};
  const Image sheet = contactSheet(cells, {.columns = 2, .gap = 8, .text_height = 13, .title = "a title"});
  const uint32_t below = 8 + 16 + 8 + 20;  // gap, title, gap, picture
  EXPECT_GT(brightPixels(sheet, 0, 0, sheet.width, 24), 20u);
  EXPECT_GT(brightPixels(sheet, 8, below, 68, sheet.height), 50u);
  EXPECT_EQ(brightPixels(sheet, 68, below, sheet.width, sheet.height), 0u);
}

TEST(ContactSheet, TextGrowsWithItsHeightAndStaysInTheImage) {
  Image image = plain(300, 60, 4, 0.0f);
  const uint32_t small = drawText(image, 0, 0, 13, "furrow", 1.0f);
  const uint32_t large = drawText(image, 0, 20, 26, "furrow", 1.0f);
  EXPECT_EQ(small, 6u * 7);
  EXPECT_EQ(large, 2 * small);
  EXPECT_EQ(brightPixels(image, large, 20, 300, 60), 0u);
  const uint32_t ink = brightPixels(image, 0, 20, 300, 60);
  EXPECT_NEAR(ink, 4.0 * brightPixels(image, 0, 0, 300, 20), 0.25 * ink);
  drawText(image, 290, 50, 26, "cut", 1.0f);  // runs off both edges
  EXPECT_EQ(contactSheet({}, {}).pixels.size(), 0u);
}

}  // namespace
}  // namespace furrow::preview
