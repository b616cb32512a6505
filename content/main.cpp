#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <utility>

#include "content/models.h"
#include "recipes.h"

// furrow_content OUTDIR: writes the demo models and the recipes that cook them.
int main(int argc, char** argv) {
  if (argc != 2 || argv[1][0] == '-') {
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
    namespace recipes = furrow::content::recipes;
    constexpr std::pair<const char*, const char*> kRecipes[] = {{"face.json", recipes::kFace},
                                                                {"jacket.json", recipes::kJacket},
                                                                {"panel.json", recipes::kPanel},
                                                                {"sleeve.json", recipes::kSleeve}};
    for (const auto& [name, text] : kRecipes) {
      std::ofstream file(out / name, std::ios::binary);
      if (!(file << text) || !file.flush())
        throw std::runtime_error((out / name).string() + ": cannot be written");
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "furrow_content: %s\n", error.what());
    return 1;
  }
}
