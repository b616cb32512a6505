// furrow_contact_sheet OUT.png COLUMNS TITLE PICTURE=CAPTION...: pictures side by side, for the demo and the
// docs.

#include "editor/preview/contact_sheet.h"

#include <charconv>
#include <cstdio>
#include <cstring>
#include <vector>

#include "pipeline/error.h"

int main(int argc, char** argv) try {
  uint32_t columns = 0;
  if (argc >= 5) std::from_chars(argv[2], argv[2] + std::strlen(argv[2]), columns);
  if (columns == 0) {
    std::fprintf(stderr, "furrow_contact_sheet: usage: OUT.png COLUMNS TITLE PICTURE=CAPTION...\n");
    return 2;
  }
  std::vector<furrow::pipeline::Image> pictures;
  std::vector<furrow::preview::SheetCell> cells;
  pictures.reserve(static_cast<size_t>(argc));
  for (int i = 4; i < argc; ++i) {
    const std::string argument = argv[i];
    const size_t equals = argument.find('=');
    pictures.push_back(furrow::pipeline::readImage(argument.substr(0, equals)));
    cells.push_back({&pictures.back(), equals == std::string::npos ? "" : argument.substr(equals + 1)});
  }
  furrow::preview::SheetLayout layout;
  layout.columns = columns;
  layout.title = argv[3];
  furrow::pipeline::writeImage(argv[1], furrow::preview::contactSheet(cells, layout));
  return 0;
} catch (const furrow::pipeline::Error& error) {
  std::fprintf(stderr, "furrow_contact_sheet: %s\n", error.what());
  return static_cast<int>(error.exit());
}
