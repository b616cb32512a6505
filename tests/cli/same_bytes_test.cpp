// The same input gives the same bytes: in any folder, with any number of threads, at any level of the C
// library's instruction sets.

#include <cmath>
#include <cstdlib>
#include <string>

#include "tests/cli/tool.h"

namespace furrow::test {
namespace {

// A folded sheet with UVs, about 900 triangles.
std::string foldedSheet() {
  constexpr int kQuads = 21;
  std::string vertices, uvs, faces;
  for (int y = 0; y <= kQuads; ++y)
    for (int x = 0; x <= kQuads; ++x) {
      const double u = static_cast<double>(x) / kQuads, v = static_cast<double>(y) / kQuads;
      vertices += "v " + std::to_string(u) + ' ' + std::to_string(v) + ' ' +
                  std::to_string(0.1 * std::sin(9.0 * u) * std::cos(5.0 * v)) + '\n';
      uvs += "vt " + std::to_string(u) + ' ' + std::to_string(v) + '\n';
    }
  const auto corner = [](int i) { return ' ' + std::to_string(i) + '/' + std::to_string(i); };
  for (int y = 0; y < kQuads; ++y)
    for (int x = 0; x < kQuads; ++x) {
      const int a = y * (kQuads + 1) + x + 1, c = a + kQuads + 1;
      faces += 'f' + corner(a) + corner(a + 1) + corner(c + 1) + "\nf" + corner(a) + corner(c + 1) +
               corner(c) + '\n';
    }
  return vertices + uvs + faces;
}

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

TEST_F(SameBytes, OfAFaceFromItsAnimation) {
  const std::filesystem::path file =
      std::filesystem::path(FURROW_CORPUS) / "face/ict_facekit_generic_55targets.glb";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no corpus";
  expectSame(file, R"({"layers": [{"name": "a", "compress": "none"}]})");
}

}  // namespace
}  // namespace furrow::test
