// The same input gives the same bytes: in any folder, with any number of threads, at any level of the C
// library's instruction sets.

#include <cstdlib>
#include <string>

#include "tests/cli/sheet.h"
#include "tests/cli/tool.h"

namespace furrow::test {
namespace {

class SameBytes : public ToolTest {
 protected:
  void expectSame(const std::filesystem::path& source, const std::string& recipe) {
    const std::filesystem::path elsewhere = folder() / "else where";
    std::filesystem::create_directory(elsewhere);
    std::filesystem::copy_file(source, elsewhere / source.filename());
    const std::string copied = write("else where/recipe.json", recipe).string();
    const std::string first = cook(source, write("recipe.json", recipe).string(), "1");
    ASSERT_FALSE(first.empty());
    EXPECT_TRUE(cook(source, copied, "1") == first);
    EXPECT_TRUE(cook(elsewhere / source.filename(), copied, "4") == first);
    const std::filesystem::path here = std::filesystem::current_path();
    std::filesystem::current_path(elsewhere);
    EXPECT_TRUE(cook(source.filename(), "recipe.json", "3") == first);
    std::filesystem::current_path(here);
    ::setenv("GLIBC_TUNABLES", "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F", 1);
    EXPECT_TRUE(cook(source, copied, "2") == first);
    ::unsetenv("GLIBC_TUNABLES");
  }

 private:
  std::string cook(const std::filesystem::path& source, const std::string& recipe,
                   const std::string& threads) {
    const std::filesystem::path out = output() / (std::to_string(cooked_++) + ".furrow");
    const Outcome outcome =
        run({"cook", source, "-o", out, "--recipe", recipe, "--threads", threads, "--quiet"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return readText(out);
  }

  int cooked_ = 0;
};

TEST_F(SameBytes, OfASheetWithMaps) {
  expectSame(write("sheet.obj", foldedSheet()),
             R"({"mapSize": 128, "layers": [{"name": "a", "direction": {"axis": [1, 0.3, 0]}}]})");
}

TEST_F(SameBytes, OfASleeveFromItsRecipe) {
  const std::filesystem::path content = FURROW_CONTENT;
  expectSame(content / "sleeve.glb", readText(content / "sleeve.json"));
}

TEST_F(SameBytes, OfAFaceFromItsAnimation) {
  const std::filesystem::path file =
      std::filesystem::path(FURROW_CORPUS) / "face/ict_facekit_generic_55targets.glb";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no corpus";
  expectSame(file, R"({"layers": [{"name": "a", "compress": "none"}]})");
}

}  // namespace
}  // namespace furrow::test
