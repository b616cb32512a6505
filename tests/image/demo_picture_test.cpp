// The demo characters as the real tool cooks and draws them: what must hold in the pictures, and that they
// are the stored ones in tests/image/demo. FURROW_UPDATE=1 in the environment stores what is drawn now.

#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "editor/preview/headless_context.h"
#include "pipeline/error.h"
#include "pipeline/maps/image.h"
#include "tests/cli/tool.h"
#include "tests/image/picture_difference.h"

namespace furrow::test {
namespace {

using pipeline::Image;

const std::filesystem::path kSource = FURROW_SOURCE_DIR;

// Without wrinkles the pictures are 0.6 and 17 to 25 apart, with creases 0.7 as deep 0.2 and 5 to 7.
constexpr uint32_t kBlock = 8;
constexpr double kMeanTolerance = 0.4, kBlockTolerance = 5.0;
// Of the software rasteriser: of the whole picture, and of the creases' depth.
constexpr double kSoftwareMeanTolerance = 3.0, kSoftwareCreaseTolerance = 0.2;

// A sample's picture is not for measuring: the model may be worked on.
constexpr double kSampleMeanTolerance = 3.0;

struct Window {
  uint32_t x0, y0, x1, y1;
};

// How much the shading varies from pixel to pixel, down the picture or along it: the mean second difference
// of green in steps of 1/255. Smooth shading has next to none.
double fineness(const Image& image, const Window& window, bool down) {
  double sum = 0.0;
  for (uint32_t y = window.y0; y < window.y1; ++y)
    for (uint32_t x = window.x0; x < window.x1; ++x) {
      const float before = down ? image.at(x, y - 1)[1] : image.at(x - 1, y)[1],
                  after = down ? image.at(x, y + 1)[1] : image.at(x + 1, y)[1];
      sum += std::abs(before - 2.0f * image.at(x, y)[1] + after);
    }
  return sum * 255.0 / ((window.x1 - window.x0) * (window.y1 - window.y0));
}

class DemoPicture : public ToolTest {
 protected:
  void SetUp() override {
    try {
      const preview::HeadlessContext probe;
    } catch (const pipeline::Error& error) {
      GTEST_SKIP() << error.what();
    }
  }

  // Cooks the model with its recipe, maps small, and draws it from here on.
  void cook(const std::string& model, std::vector<std::string> camera) {
    nlohmann::json recipe = nlohmann::json::parse(readText(kSource / "content/recipes" / (model + ".json")));
    recipe["mapSize"] = 512;
    asset_ = folder() / (model + ".furrow");
    camera_ = std::move(camera);
    const Outcome outcome = run({"cook", std::filesystem::path(FURROW_CONTENT) / (model + ".glb"), "-o",
                                 asset_, "--recipe", write("recipe.json", recipe.dump()), "--quiet"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
  }

  Image draw(const std::string& shading, const std::vector<std::string>& pose,
             const std::string& backend = "gpu") const {
    const std::filesystem::path file = folder() / "picture.png";
    std::vector<std::string> arguments = {"render",  asset_,      "-o",    file,        "--size",
                                          "256x256", "--shading", shading, "--backend", backend};
    arguments.insert(arguments.end(), camera_.begin(), camera_.end());
    arguments.insert(arguments.end(), pose.begin(), pose.end());
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return pipeline::readImage(file);
  }

  // The software rasteriser beside OpenGL, both with alpha shading. It lights vertices and not pixels, hairs
  // among them, so shadows end more softly and highlights are broader; what the creases take away is nearly
  // the same.
  void expectNearlyTheSameInSoftware(const std::vector<std::string>& pose) {
    const Image software = draw("alpha", pose, "cpu"), opengl = draw("alpha", pose);
    const Image plain = draw("none", pose, "cpu"), opengl_plain = draw("none", pose);
    const Difference whole = difference(software, opengl, kBlock);
    EXPECT_LT(whole.mean, kSoftwareMeanTolerance);
    double creases = 0.0, apart = 0.0;
    for (size_t i = 0; i < plain.pixels.size(); ++i) {
      const double crease = opengl_plain.pixels[i] - opengl.pixels[i];
      creases += std::abs(crease);
      apart += std::abs(plain.pixels[i] - software.pixels[i] - crease);
    }
    EXPECT_LT(apart, kSoftwareCreaseTolerance * creases);
    std::printf("software and OpenGL: mean difference %.2f of 255, creases %.3f of their depth\n", whole.mean,
                apart / creases);
  }

  // The picture of the model on the editor's first screen.
  void expectSample(const std::string& model, const std::vector<std::string>& view) const {
    const std::filesystem::path file = folder() / "sample.png",
                                stored = kSource / "editor/ui/pictures" / (model + ".png");
    std::vector<std::string> arguments = {"render", asset_, "-o", file, "--size", "320x240"};
    arguments.insert(arguments.end(), view.begin(), view.end());
    const Outcome outcome = run(arguments);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    if (std::getenv("FURROW_UPDATE") != nullptr)
      std::filesystem::copy_file(file, stored, std::filesystem::copy_options::overwrite_existing);
    EXPECT_LT(difference(pipeline::readImage(file), pipeline::readImage(stored), kBlock).mean,
              kSampleMeanTolerance)
        << "it no longer looks like " << stored << ": run this test with FURROW_UPDATE=1 and commit it";
  }

  // `plain`: the same without wrinkles, which the tolerances must tell from the stored picture.
  void expectStored(const std::string& name, const Image& picture, const Image& plain) const {
    const std::filesystem::path stored = kSource / "tests/image/demo" / name;
    if (std::getenv("FURROW_UPDATE") != nullptr) pipeline::writeImage(stored, picture);
    const Image expected = pipeline::readImage(stored);
    const Difference now = difference(picture, expected, kBlock),
                     without = difference(plain, expected, kBlock);
    if (now.mean > kMeanTolerance || now.worst_block > kBlockTolerance) {
      const std::filesystem::path drawn = std::filesystem::path(FURROW_PICTURES) / name;
      std::filesystem::create_directories(drawn.parent_path());
      pipeline::writeImage(drawn, picture);
      ADD_FAILURE() << "mean " << now.mean << ", worst block " << now.worst_block << ": compare " << drawn
                    << " with " << stored
                    << "; if the new one is right, run this test with FURROW_UPDATE=1 and commit it";
    }
    EXPECT_GT(without.mean, kMeanTolerance);
    EXPECT_GT(without.worst_block, 3.0 * kBlockTolerance);
  }

 private:
  std::string asset_;
  std::vector<std::string> camera_;
};

TEST_F(DemoPicture, RaisedBrowsCreaseTheForehead) {
  cook("face", {"--yaw", "18", "--zoom", "5.5", "--target", "0.005", "0.045", "0.02"});
  const std::vector<std::string> raise = {"--morph", "browInnerUp=1",       "--morph", "browOuterUpLeft=0.8",
                                          "--morph", "browOuterUpRight=0.8"};
  const Image raised = draw("interpolated", raise), plain = draw("none", raise),
              neutral = draw("interpolated", {});
  const Window forehead = {80, 100, 180, 140};
  EXPECT_GT(fineness(raised, forehead, true), 3.0 * fineness(plain, forehead, true));
  EXPECT_GT(fineness(raised, forehead, true), 3.0 * fineness(neutral, forehead, true));
  EXPECT_GT(fineness(raised, forehead, true), 2.0 * fineness(raised, forehead, false));  // lines lie level
  expectStored("brows_raised.png", raised, plain);
  expectSample(
      "face", {"--yaw", "18", "--pitch", "3", "--zoom", "2", "--target", "0.012", "-0.012", "0.02", "--morph",
               "browInnerUp=1", "--morph", "browOuterUpLeft=0.8", "--morph", "browOuterUpRight=0.8"});
  expectNearlyTheSameInSoftware(raise);
}

TEST_F(DemoPicture, ABentElbowFoldsTheSleeve) {
  cook("sleeve", {"--yaw", "-25", "--pitch", "12", "--zoom", "1.6"});
  const std::vector<std::string> bend = {"--clip", "bend", "--time", "0.62"};
  const Image bent = draw("interpolated", bend), plain = draw("none", bend);
  const Window elbow = {140, 90, 190, 120};
  EXPECT_GT(fineness(bent, elbow, false), 2.0 * fineness(plain, elbow, false));
  expectStored("elbow_bent.png", bent, plain);
  expectNearlyTheSameInSoftware(bend);
}

// The upper arm, which no joint moves, is at the same pixels in all frames of the bend.
TEST_F(DemoPicture, ACameraAtADistanceStandsStill) {
  cook("sleeve", {"--view", "point", "--yaw", "0", "--target", "0.3", "0", "0"});
  const auto differs = [&](const std::vector<std::string>& camera) {
    std::vector<std::string> bend = {"--clip", "bend", "--time", "0.62"};
    bend.insert(bend.end(), camera.begin(), camera.end());
    const Image still = draw("none", camera), bent = draw("none", bend);
    size_t count = 0;
    for (uint32_t y = 0; y < 256; ++y)
      for (uint32_t x = 0; x < 80; ++x) count += still.at(x, y)[0] != bent.at(x, y)[0];
    return count;
  };
  EXPECT_EQ(differs({"--distance", "1.4"}), 0);
  EXPECT_GT(differs({}), 100);
}

TEST_F(DemoPicture, ALeaningJacketFoldsAtTheWaist) {
  cook("jacket", {"--yaw", "24", "--zoom", "2.4", "--target", "0", "-0.18", "0"});
  const std::vector<std::string> lean = {"--clip", "lean", "--time", "1"};
  const Image folded = draw("interpolated", lean), plain = draw("none", lean),
              rest = draw("interpolated", {});
  const Window waist = {115, 110, 175, 190};
  EXPECT_GT(fineness(folded, waist, true), 2.0 * fineness(plain, waist, true));
  EXPECT_GT(fineness(folded, waist, true), 2.0 * fineness(rest, waist, true));
  expectStored("waist_folded.png", folded, plain);
  expectSample("jacket", {"--yaw", "20", "--zoom", "1.1", "--clip", "bend", "--time", "1"});
}

}  // namespace
}  // namespace furrow::test
