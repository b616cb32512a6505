// The tool on a machine without any OpenGL library: hide_gl.cpp plays that machine.

#include <gmock/gmock.h>

#include "tests/cli/tool.h"

namespace furrow::test {
namespace {

using testing::HasSubstr;
using testing::Not;

class NoGl : public ToolTest {
 protected:
  void SetUp() override {
    if (kAddressSanitizer) GTEST_SKIP() << "AddressSanitizer's library has to be preloaded first";
    asset_ = folder() / "sleeve.furrow";
    setenv("FURROW_HIDDEN", log().c_str(), 1);
    setenv("LD_PRELOAD", preloaded(FURROW_HIDE_GL).c_str(), 1);
    const Outcome cooked =
        run({"cook", std::string(FURROW_CONTENT) + "/sleeve.glb", "-o", asset_, "--quiet"});
    ASSERT_EQ(cooked.status, 0) << cooked.err;
  }
  void TearDown() override {
    unsetenv("LD_PRELOAD");
    unsetenv("FURROW_HIDDEN");
  }

  std::filesystem::path log() const { return folder() / "hidden.txt"; }
  std::vector<std::string> picture(const std::filesystem::path& file, std::vector<std::string> more) const {
    std::vector<std::string> words = {"render",  asset_,   "-o",   file,     "--size",
                                      "160x160", "--clip", "bend", "--time", "0.62"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }

  std::string asset_;
};

TEST_F(NoGl, TheCpuTierComputesAndDrawsAndAsksForNoLibrary) {
  const std::vector<std::vector<std::string>> commands = {
      {"--version"},
      {"check", asset_},
      {"eval", asset_, "--backend", "cpu", "-o", output() / "w.csv"},
      picture(output() / "alpha.png", {"--backend", "cpu"}),
      picture(output() / "none.png", {"--backend", "cpu", "--shading", "none"}),
      picture(output() / "weight.png", {"--backend", "cpu", "--view", "weight"}),
      picture(output() / "mask.png", {"--backend", "cpu", "--view", "mask"}),
      picture(output() / "bias.png", {"--backend", "cpu", "--view", "bias"}),
      picture(output() / "confidence.png", {"--backend", "cpu", "--view", "confidence"}),
      picture(output() / "morph.png", {"--backend", "cpu", "--view", "morph"}),
      picture(output() / "point.png", {"--backend", "cpu", "--view", "point"})};
  for (const auto& command : commands) {
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.status, 0) << command.front() << ": " << outcome.err;
    EXPECT_EQ(outcome.err, "");
  }
  EXPECT_FALSE(std::filesystem::exists(log())) << readText(log());
  EXPECT_NE(readText(output() / "alpha.png"), readText(output() / "none.png"));
  EXPECT_NE(readText(output() / "weight.png"), readText(output() / "mask.png"));

  // Where there is OpenGL, the cpu tier draws the same bytes.
  unsetenv("LD_PRELOAD");
  EXPECT_EQ(run(picture(output() / "with_gl.png", {"--backend", "cpu"})).status, 0);
  EXPECT_EQ(readText(output() / "alpha.png"), readText(output() / "with_gl.png"));
}

TEST_F(NoGl, AutomaticChoiceFallsToTheCpuTierAndSaysWhy) {
  const Outcome weighed = run({"eval", asset_, "-o", output() / "w.csv"});
  EXPECT_EQ(weighed.status, 0) << weighed.err;
  EXPECT_THAT(weighed.err, HasSubstr("using the tier cpu: OpenGL: no context"));
  const Outcome drawn = run(picture(output() / "auto.png", {}));
  EXPECT_EQ(drawn.status, 0) << drawn.err;
  EXPECT_THAT(drawn.err, HasSubstr("using the tier cpu: OpenGL: no context"));
  EXPECT_TRUE(std::filesystem::exists(log()));  // it did look for one, so the libraries were hidden
  EXPECT_EQ(run(picture(output() / "cpu.png", {"--backend", "cpu"})).status, 0);
  EXPECT_EQ(readText(output() / "auto.png"), readText(output() / "cpu.png"));
}

TEST_F(NoGl, RefusesWhatNeedsOpenGl) {
  expectRefused(run(picture(output() / "a.png", {"--backend", "gpu"})), 3, "gpu");
  expectRefused(run(picture(output() / "a.png", {"--backend", "cpu", "--shading", "interpolated"})), 3,
                "OpenGL");
  expectRefused(run(picture(output() / "a.png", {"--backend", "cpu", "--shading", "blend"})), 3, "OpenGL");
  expectRefused(run(picture(output() / "a.png", {"--backend", "cpu", "--view", "direction"})), 3, "OpenGL");
}

}  // namespace
}  // namespace furrow::test
