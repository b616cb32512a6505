// The tool on a driver that is reset while it works: lose_context.cpp plays that driver.

#include <gmock/gmock.h>

#include "tests/cli/tool.h"

namespace furrow::test {
namespace {

using testing::HasSubstr;

class LostContext : public ToolTest {
 protected:
  void SetUp() override {
    if (kAddressSanitizer) GTEST_SKIP() << "AddressSanitizer's library has to be preloaded first";
    const std::string recipe = write("plain.json", R"({"layers": [{"name": "a", "compress": "none"}]})");
    const Outcome cooked = run(
        {"cook", std::string(FURROW_CONTENT) + "/sleeve.glb", "--recipe", recipe, "-o", asset(), "--quiet"});
    ASSERT_EQ(cooked.status, 0) << cooked.err;
    if (run({"eval", asset(), "--backend", "gpu"}).status == 3) GTEST_SKIP() << "there is no gpu tier";
  }
  void TearDown() override {
    unsetenv("LD_PRELOAD");
    unsetenv("FURROW_LOSSES");
  }

  std::string asset() const { return folder() / "sleeve.furrow"; }

  Outcome losing(const char* losses, const std::vector<std::string>& command) const {
    setenv("FURROW_LOSSES", losses, 1);
    setenv("LD_PRELOAD", preloaded(FURROW_LOSE_CONTEXT).c_str(), 1);
    const Outcome outcome = run(command);
    unsetenv("LD_PRELOAD");
    return outcome;
  }
  std::vector<std::string> command(const char* name, const char* backend, const std::string& file) const {
    std::vector<std::string> words = {name, asset(),  "--backend", backend,  "-o",
                                      file, "--clip", "bend",      "--time", "0.62"};
    if (name == std::string("render")) words.insert(words.end(), {"--size", "160x160"});
    return words;
  }
};

TEST_F(LostContext, EveryLossCostsOneTierAndIsReported) {
  for (const char* name : {"render", "eval"}) {
    SCOPED_TRACE(name);
    for (const auto& [losses, tier, before] :
         {std::tuple("1", "gpu-raster", "gpu"), std::tuple("2", "cpu", "gpu-raster")}) {
      const std::string file = output() / (std::string(tier) + name + ".png"),
                        expected = output() / (std::string("expected.") + name + ".png");
      const Outcome fell = losing(losses, command(name, "auto", file));
      EXPECT_EQ(fell.status, 0) << fell.err;
      EXPECT_EQ(fell.err,
                std::string("furrow: using the tier ") + tier + ": the " + before +
                    " tier ended: the OpenGL context was lost (reset, through no fault of its own)\n");
      EXPECT_EQ(run(command(name, tier, expected)).status, 0);
      EXPECT_EQ(readText(file), readText(expected));
      EXPECT_FALSE(readText(file).empty());
    }
  }
}

TEST_F(LostContext, AForcedTierGivesWayToNoOther) {
  for (const char* name : {"render", "eval"})
    for (const char* tier : {"gpu", "gpu-raster"})
      expectRefused(losing("1", command(name, tier, output() / "out.png")), 3,
                    std::string(tier) + " tier: the OpenGL context was lost");
}

}  // namespace
}  // namespace furrow::test
