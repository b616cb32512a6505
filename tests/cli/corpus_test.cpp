// The tool on real files that nobody here wrote: each cooks, checks and gives the same finite weights on
// every tier, or is refused with one line.

#include <charconv>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>

#include "tests/cli/tool.h"

namespace furrow::test {
namespace {

constexpr double kTierTolerance = 1e-4;
constexpr double kNeutralWeight = 0.01;

const std::filesystem::path kCorpus = FURROW_CORPUS;

bool isGltf(const std::filesystem::path& file) {
  return file.extension() == ".gltf" || file.extension() == ".glb";
}

// Names below the corpus, sorted; `invalid`: those in its folder of broken files, else all others.
std::vector<std::string> corpusFiles(bool invalid) {
  std::vector<std::string> names;
  if (!std::filesystem::is_directory(kCorpus)) return names;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(kCorpus)) {
    const std::filesystem::path name = entry.path().lexically_relative(kCorpus);
    if (entry.is_regular_file() && isGltf(name) && (*name.begin() == "invalid") == invalid)
      names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

// Every number of the columns whose heading begins with "weight_".
std::vector<double> weightsOf(std::string_view csv) {
  std::vector<bool> wanted;
  std::vector<double> weights;
  for (bool heading = true; !csv.empty(); heading = false) {
    const size_t line_end = std::min(csv.find('\n'), csv.size());
    std::string_view line = csv.substr(0, line_end);
    csv.remove_prefix(std::min(line_end + 1, csv.size()));
    for (size_t column = 0; !line.empty(); ++column) {
      const size_t end = std::min(line.find(','), line.size());
      const std::string_view cell = line.substr(0, end);
      line.remove_prefix(std::min(end + 1, line.size()));
      if (heading) {
        wanted.push_back(cell.starts_with("weight_"));
      } else if (column < wanted.size() && wanted[column]) {
        double value = std::nan("");
        std::from_chars(cell.data(), cell.data() + cell.size(), value);
        weights.push_back(value);
      }
    }
  }
  return weights;
}

class Corpus : public ToolTest {
 protected:
  void SetUp() override {
    if (!std::filesystem::is_directory(kCorpus)) GTEST_SKIP() << "there is no " << kCorpus;
  }

  std::string asset() const { return output() / "out.furrow"; }

  Outcome cook(const std::string& name, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"cook", kCorpus / name, "-o", asset(), "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }

  // The middle of a movement of the cooked asset, as options of eval; nothing for one that never moves.
  std::vector<std::string> midPose() const {
    const nlohmann::json info = nlohmann::json::parse(run({"info", asset(), "--json"}).out);
    if (!info.at("clips").empty()) return {"--clip", "0", "--time", "0.5"};
    if (!info.at("morphTargets").empty()) return {"--morph", "0=1"};
    return {};
  }

  Outcome eval(const std::string& backend, const std::vector<std::string>& pose) const {
    std::vector<std::string> arguments = {"eval", asset(), "--backend", backend};
    arguments.insert(arguments.end(), pose.begin(), pose.end());
    return run(arguments);
  }
};

std::string testName(const ::testing::TestParamInfo<std::string>& file) {
  std::string name = file.param;
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return !std::isalnum(c); }, '_');
  return name;
}

class ValidFile : public Corpus, public ::testing::WithParamInterface<std::string> {};
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(ValidFile);
INSTANTIATE_TEST_SUITE_P(Corpus, ValidFile, ::testing::ValuesIn(corpusFiles(false)), testName);

TEST_P(ValidFile, CooksAndEveryTierAgrees) {
  const Outcome cooked = cook(GetParam());
  if (cooked.status != 0) {
    expectRefused(cooked, 1, GetParam());
    return;
  }
  EXPECT_EQ(cooked.err, "");
  const Outcome checked = run({"check", asset()});
  EXPECT_EQ(checked.status, 0) << checked.err;
  const std::vector<std::string> pose = midPose();
  const Outcome cpu = eval("cpu", pose);
  ASSERT_EQ(cpu.status, 0) << cpu.err;
  EXPECT_EQ(cpu.err, "");
  const std::vector<double> weights = weightsOf(cpu.out);
  ASSERT_FALSE(weights.empty());
  for (double weight : weights) ASSERT_LE(std::abs(weight), 1.0);  // no NaN either

  const Outcome gpu = eval("gpu", pose);
  if (gpu.status == 3) GTEST_SKIP() << gpu.err;
  ASSERT_EQ(gpu.status, 0) << gpu.err;
  const std::vector<double> gpu_weights = weightsOf(gpu.out);
  ASSERT_EQ(gpu_weights.size(), weights.size());
  for (size_t i = 0; i < weights.size(); ++i)
    ASSERT_LE(std::abs(gpu_weights[i] - weights[i]), kTierTolerance) << "weight " << i;
}

TEST_F(Corpus, BrokenFilesCookOrAreRefusedWithOneLine) {
  size_t refused = 0;
  const std::vector<std::string> names = corpusFiles(true);
  for (const std::string& name : names) {
    SCOPED_TRACE(name);
    const Outcome cooked = cook(name);
    if (cooked.status == 0) {
      EXPECT_EQ(cooked.err, "");
      EXPECT_EQ(run({"check", asset()}).status, 0);
      std::filesystem::remove(asset());
    } else {
      ++refused;
      expectRefused(cooked, 1, name);
    }
  }
  EXPECT_GT(refused, names.size() / 4);
}

TEST_F(Corpus, FacesAtRestAreNeutral) {
  for (const char* name :
       {"face/ict_facekit_generic_55targets.glb", "face/leeperrysmith/LeePerrySmith.glb",
        "face/makehuman_body_34targets_skinned.glb", "face/valid/Asian_F_1_Casual_decoded.glb"}) {
    SCOPED_TRACE(name);
    ASSERT_EQ(cook(name).status, 0);
    const Outcome rest = eval("cpu", {});
    ASSERT_EQ(rest.status, 0) << rest.err;
    const std::vector<double> weights = weightsOf(rest.out);
    ASSERT_FALSE(weights.empty());
    size_t beyond = 0;
    double worst = 0.0;
    for (double weight : weights) {
      if (!(std::abs(weight) <= kNeutralWeight)) ++beyond;
      worst = std::max(worst, std::abs(weight));
    }
    EXPECT_EQ(beyond, 0u) << "of " << weights.size() << ", the worst " << worst;
  }
}

TEST_F(Corpus, CooksToTheSameBytes) {
  const std::string name = "skinned/CesiumMan.glb";
  ASSERT_EQ(cook(name).status, 0);
  const std::string first = readText(asset());
  ASSERT_FALSE(first.empty());
  for (const auto& more : std::vector<std::vector<std::string>>{{}, {"--threads", "1"}, {"--threads", "3"}}) {
    ASSERT_EQ(cook(name, more).status, 0);
    EXPECT_TRUE(readText(asset()) == first) << (more.empty() ? "cooked again" : more.back() + " threads");
  }
}

TEST_F(Corpus, DepfileListsEveryFileRead) {
  const std::filesystem::path depfile = output() / "out.d";
  const std::string name = "morph/AnimatedMorphCube/AnimatedMorphCube.gltf";
  ASSERT_EQ(cook(name, {"--depfile", depfile}).status, 0);
  const std::string text = readText(depfile);
  EXPECT_TRUE(text.starts_with(asset() + ":")) << text;
  EXPECT_NE(text.find((kCorpus / name).string()), std::string::npos) << text;
  EXPECT_NE(text.find("AnimatedMorphCube.bin"), std::string::npos) << text;
}

}  // namespace
}  // namespace furrow::test
