#include <cstdio>
#include <exception>

#include "content/models.h"

// furrow_content OUTDIR: writes the demo models and the recipes that cook them.
int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: furrow_content OUTDIR\n");
    return 2;
  }
  try {
    namespace fs = std::filesystem;
    const fs::path out = argv[1];
    fs::create_directories(out);
    furrow::content::writeGlb(furrow::content::buildFace(), out / "face.glb");
    furrow::content::writeGlb(furrow::content::buildJacket(), out / "jacket.glb");
    furrow::content::writeGlb(furrow::content::buildPanel(), out / "panel.glb");
    furrow::content::writeGlb(furrow::content::buildSleeve(), out / "sleeve.glb");
    for (const char* recipe : {"face.json", "jacket.json", "panel.json", "sleeve.json"})
      fs::copy_file(fs::path(FURROW_RECIPES) / recipe, out / recipe, fs::copy_options::overwrite_existing);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "furrow_content: %s\n", error.what());
    return 1;
  }
}
