// The key of a cook is that of everything its bytes depend on, and of nothing else.

#include "pipeline/cook/cook_cache.h"

#include <gmock/gmock.h>

#include <functional>

#include "pipeline/cook/cook.h"
#include "pipeline/import/import.h"
#include "tests/unit/gltf_builder.h"

namespace furrow::pipeline {
namespace {

class CookKey : public ::testing::Test {
 protected:
  CookKey() {
    std::filesystem::create_directories(folder());
    test::GltfBuilder sheet;
    sheet.add(std::vector<float>{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, "VEC3", 3);
    sheet.add(std::vector<uint16_t>{0, 1, 2, 0, 2, 3}, "SCALAR", 1);
    sheet.add(std::vector<float>{0, 0, 1, 0, 1, 1, 0, 1}, "VEC2", 2);
    const auto scene = [&](const char* buffer) {
      return sheet.json(R"("scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":)"
                        R"([{"attributes":{"POSITION":0,"TEXCOORD_0":2},"indices":1}]}])",
                        buffer);
    };
    write("sheet.gltf", scene("a%20b.bin"));
    write("a b.bin", sheet.bin());
    write("rest.gltf", scene("rest.bin"));
    write("rest.bin", sheet.bin());
    for (const char* image : {"flow.pgm", "mask.pgm", "lines.pgm", "shade.pgm", "stretch.pgm"})
      write(image, "P2\n4 4\n255\n9 90 99 9 9 90 99 9 9 90 99 9 9 90 99 9\n");
    write("flow.pgm", "P3\n2 2\n255\n255 90 0 255 90 0 255 90 0 255 90 0\n");
    write("recipe.json", R"({"rest": {"file": "rest.gltf"}, "mapSize": 16, "layers": [
      {"name": "a", "direction": {"texture": "flow.pgm"}, "mask": {"texture": "mask.pgm"},
       "compress": {"height": "lines.pgm", "shading": "shade.pgm"}, "stretch": {"height": "stretch.pgm"}}]})");
    request.source.base = folder() / "sheet.gltf";
    request.recipe = folder() / "recipe.json";
  }

  std::filesystem::path folder() const { return scratch_.path() / "one"; }
  void write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder() / name, std::ios::binary) << bytes;
  }
  std::string key() const { return cookKey(request, filesOf(request)); }

  CookRequest request;

 private:
  test::ScratchFolder scratch_;
};

TEST_F(CookKey, CoversEveryFileThatTheCookReads) {
  const std::vector<std::filesystem::path> files = filesOf(request);
  CookOptions options;
  const Cooked cooked = cook(import(request.source.base), readRecipe(request.recipe), options);
  EXPECT_EQ(cooked.dependencies.size(), 10u);
  for (const std::filesystem::path& read : cooked.dependencies)
    EXPECT_THAT(files, testing::Contains(read)) << "is read, and not a part of the key";
}

TEST_F(CookKey, ChangesWithEveryInput) {
  const std::string first = key();
  EXPECT_EQ(first.size(), 32u);
  EXPECT_EQ(key(), first);
  for (const std::filesystem::path& file : filesOf(request)) {
    const std::vector<char> old = [&] {
      std::ifstream in(file, std::ios::binary);
      return std::vector<char>(std::istreambuf_iterator<char>(in), {});
    }();
    std::ofstream(file, std::ios::binary | std::ios::app) << '\n';
    EXPECT_NE(key(), first) << file;
    std::ofstream(file, std::ios::binary).write(old.data(), static_cast<std::streamsize>(old.size()));
    EXPECT_EQ(key(), first) << file;
  }
  const std::vector<std::function<void()>> changes = {
      [&] { request.geometry = GeometryCodec::kRaw; }, [&] { request.source.fps = 25.0; },
      [&] { request.recipe.clear(); },
      [&] {
        std::filesystem::copy(request.source.base, folder() / "other.gltf");
        request.source.base = folder() / "other.gltf";  // the asset holds the name
      },
      [&] { request.source.pattern = folder() / "frame_*.obj"; }};
  const CookRequest same = request;
  for (size_t i = 0; i < changes.size(); ++i) {
    changes[i]();
    EXPECT_NE(key(), first) << i;
    request = same;
  }
}

TEST_F(CookKey, IsThatOfTheBytesWhereverTheyLie) {
  const std::string first = key();
  const std::filesystem::path moved = folder().parent_path() / "another";
  std::filesystem::rename(folder(), moved);
  request.source.base = moved / "sheet.gltf";
  request.recipe = moved / "recipe.json";
  EXPECT_EQ(key(), first);
}

}  // namespace
}  // namespace furrow::pipeline
