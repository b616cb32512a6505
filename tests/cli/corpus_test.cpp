// The tool on real files that nobody here wrote: each cooks, checks, is neutral at rest and gives the same
// finite weights on every tier, or is refused with one line.

#include <gmock/gmock.h>

#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string_view>

#include "tests/cli/tool.h"

namespace furrow::test {
namespace {

constexpr double kTierTolerance = 1e-4;
constexpr double kNeutralWeight = 0.01;

const std::filesystem::path kCorpus = FURROW_CORPUS;

bool isMesh(const std::filesystem::path& file) {
  static const std::set<std::string> extensions = {".gltf", ".glb", ".obj", ".ply", ".stl", ".off"};
  return extensions.contains(file.extension());
}

enum class Kind { kValid, kInvalid, kOther };  // meshes, those in the folder of broken files, what is none

// Names below the corpus, sorted.
std::vector<std::string> corpusFiles(Kind kind) {
  std::vector<std::string> names;
  if (!std::filesystem::is_directory(kCorpus)) return names;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(kCorpus)) {
    const std::filesystem::path name = entry.path().lexically_relative(kCorpus);
    const Kind found = !isMesh(name)                ? Kind::kOther
                       : *name.begin() == "invalid" ? Kind::kInvalid
                                                    : Kind::kValid;
    if (entry.is_regular_file() && found == kind) names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

// A row of eval's CSV, by the heading of its columns.
using Row = std::map<std::string, double, std::less<>>;

std::vector<Row> rowsOf(std::string_view csv) {
  std::vector<std::string> headings;
  std::vector<Row> rows;
  for (bool heading = true; !csv.empty(); heading = false) {
    const size_t line_end = std::min(csv.find('\n'), csv.size());
    std::string_view line = csv.substr(0, line_end);
    csv.remove_prefix(std::min(line_end + 1, csv.size()));
    if (!heading) rows.emplace_back();
    for (size_t column = 0; !line.empty(); ++column) {
      const size_t end = std::min(line.find(','), line.size());
      const std::string_view cell = line.substr(0, end);
      line.remove_prefix(std::min(end + 1, line.size()));
      if (heading) {
        headings.emplace_back(cell);
      } else {
        double value = std::nan("");
        std::from_chars(cell.data(), cell.data() + cell.size(), value);
        rows.back()[headings.at(column)] = value;
      }
    }
  }
  return rows;
}

// With no recipe there is one layer, "wrinkles".
const char* const kWeight = "weight_wrinkles";

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
  std::vector<std::string> midPose(const std::filesystem::path& report) const {
    const nlohmann::json did = nlohmann::json::parse(readText(report));
    if (did.at("clips") > 0) return {"--clip", "0", "--time", "0.5"};
    if (did.at("morphTargets") > 0) return {"--morph", "0=1"};
    return {};
  }

  Outcome eval(const std::string& backend, const std::vector<std::string>& pose) const {
    std::vector<std::string> arguments = {"eval", asset(), "--backend", backend};
    arguments.insert(arguments.end(), pose.begin(), pose.end());
    return run(arguments);
  }
};

// Files whose default node transforms are a pose, away from the bind pose.
const std::set<std::string> kPosed = {"skinned/03_skinned_cylinder/03_skinned_cylinder.gltf"};

const char* const kNeedsBasisu = "odd/basisu_plane/basisu_plane.gltf";

// Files of the corpus without a triangle that could wrinkle.
const std::set<std::string> kWithoutTriangles = {
    "odd/00_empty_scene.gltf",
    "odd/Mesh_PrimitiveMode/Mesh_PrimitiveMode_00.gltf",
    "odd/Mesh_PrimitiveMode/Mesh_PrimitiveMode_02.gltf",
    "odd/Mesh_PrimitiveMode/Mesh_PrimitiveMode_08.gltf",
    "odd/Mesh_PrimitiveMode/Mesh_PrimitiveMode_10.gltf",
    "odd/gltf_validator_ok/base/data/accessor/valid.gltf",
    "odd/gltf_validator_ok/base/data/accessor_data/get_elements.gltf",
    "odd/gltf_validator_ok/base/data/accessor_data/get_elements_matrix.gltf",
    "odd/gltf_validator_ok/base/data/asset/custom_property.gltf",
    "odd/gltf_validator_ok/base/data/asset/valid.gltf",
    "odd/gltf_validator_ok/base/data/buffer/custom_property.gltf",
    "odd/gltf_validator_ok/base/data/buffer_view/valid.gltf",
    "odd/gltf_validator_ok/base/data/glb/two_images.glb",
    "odd/gltf_validator_ok/base/data/glb/valid.glb",
    "odd/gltf_validator_ok/base/data/glb/valid_buffer.glb",
    "odd/gltf_validator_ok/base/data/image/custom_property.gltf",
    "odd/gltf_validator_ok/base/data/image/data_uri.glb",
    "odd/gltf_validator_ok/base/data/image/unrecognized_format.gltf",
    "odd/gltf_validator_ok/base/data/image/valid.gltf",
    "odd/gltf_validator_ok/base/data/material/custom_property.gltf",
    "odd/gltf_validator_ok/base/data/node/custom_property.gltf",
    "odd/gltf_validator_ok/base/data/node/node_empty.gltf",
    "odd/gltf_validator_ok/base/data/root/custom_property_escaped_name.gltf",
    "odd/gltf_validator_ok/base/data/root/invalid_extension_name.gltf",
    "odd/gltf_validator_ok/base/data/root/valid.gltf",
    "odd/gltf_validator_ok/base/data/sampler/empty_object.gltf",
    "odd/gltf_validator_ok/base/data/scene/custom_property.gltf",
    "odd/gltf_validator_ok/base/data/scene/valid.gltf",
    "odd/gltf_validator_ok/base/data/skin/custom_property.gltf",
    "odd/gltf_validator_ok/base/data/texture/custom_property.gltf",
    "odd/gltf_validator_ok/base/data/texture/valid.gltf",
    "odd/gltf_validator_ok/ext/EXT_texture_webp/data/image/valid.gltf",
    "odd/gltf_validator_ok/ext/EXT_texture_webp/data/texture/empty_object.gltf",
    "odd/gltf_validator_ok/ext/KHR_animation_pointer/data/animation/channel/target/valid.gltf",
    "odd/gltf_validator_ok/ext/KHR_texture_transform/data/textureInfo/valid.gltf",
};

std::string testName(const ::testing::TestParamInfo<std::string>& file) {
  std::string name = file.param;
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return !std::isalnum(c); }, '_');
  return name;
}

class ValidFile : public Corpus, public ::testing::WithParamInterface<std::string> {};
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(ValidFile);
INSTANTIATE_TEST_SUITE_P(Corpus, ValidFile, ::testing::ValuesIn(corpusFiles(Kind::kValid)), testName);

TEST_P(ValidFile, CooksRestsAndEveryTierAgrees) {
  const std::filesystem::path report = folder() / "report.json";
  const Outcome cooked = cook(GetParam(), {"--report", report});
  if (GetParam() == kNeedsBasisu || kWithoutTriangles.contains(GetParam())) {
    expectRefused(cooked, 1, GetParam());
    EXPECT_THAT(cooked.err, testing::HasSubstr(GetParam() == kNeedsBasisu ? "KHR_texture_basisu"
                                                                          : "it has no triangles"));
    return;
  }
  ASSERT_EQ(cooked.status, 0) << cooked.err;
  EXPECT_EQ(cooked.err, "");
  const std::vector<std::string> pose = midPose(report);
  // Where nothing moves, the tiers have nothing to differ in.
  Outcome outcomes[5];
  forEachInParallel(pose.empty() ? 2 : 5, [&](size_t i) {
    outcomes[i] = i == 0   ? run({"check", asset()})
                  : i == 1 ? eval("cpu", {})
                  : i == 2 ? eval("cpu", pose)
                  : i == 3 ? eval("gpu", pose)
                           : eval("gpu-raster", pose);
  });
  const auto& [checked, rest, cpu, gpu, raster] = outcomes;
  EXPECT_EQ(checked.status, 0) << checked.err;
  ASSERT_EQ(rest.status, 0) << rest.err;
  EXPECT_EQ(rest.err, "");
  double largest = 0.0;
  const std::vector<Row> rest_rows = rowsOf(rest.out);
  ASSERT_FALSE(rest_rows.empty());
  for (const Row& row : rest_rows) {
    for (const auto& [heading, value] : row) ASSERT_TRUE(std::isfinite(value)) << heading;
    largest = std::max(largest, std::abs(row.at(kWeight)));
  }
  if (kPosed.contains(GetParam()))
    EXPECT_GT(largest, kNeutralWeight);
  else
    EXPECT_LE(largest, kNeutralWeight);
  if (pose.empty()) return;

  ASSERT_EQ(cpu.status, 0) << cpu.err;
  const std::vector<Row> rows = rowsOf(cpu.out);
  for (const Row& row : rows)
    for (const auto& [heading, value] : row) ASSERT_TRUE(std::isfinite(value)) << heading;
  for (const Row& row : rows) ASSERT_LE(std::abs(row.at(kWeight)), 1.0);
  for (const Outcome& tier : {gpu, raster}) {
    if (tier.status == 3) GTEST_SKIP() << tier.err;
    ASSERT_EQ(tier.status, 0) << tier.err;
    const std::vector<Row> tier_rows = rowsOf(tier.out);
    ASSERT_EQ(tier_rows.size(), rows.size());
    for (size_t i = 0; i < rows.size(); ++i)
      ASSERT_LE(std::abs(tier_rows[i].at(kWeight) - rows[i].at(kWeight)), kTierTolerance) << "vertex " << i;
  }
}

TEST_F(Corpus, BrokenFilesCookOrAreRefusedWithOneLine) {
  const std::vector<std::string> names = corpusFiles(Kind::kInvalid);
  std::atomic<size_t> refused = 0;
  forEachInParallel(names.size(), [&](size_t i) {
    SCOPED_TRACE(names[i]);
    const std::filesystem::path target = output() / (std::to_string(i) + ".furrow");
    const Outcome cooked = run({"cook", kCorpus / names[i], "-o", target, "--quiet"});
    if (cooked.status == 0) {
      EXPECT_EQ(cooked.err, "");
      std::filesystem::remove(target);
    } else {
      ++refused;
      expectOneLine(cooked, 1, names[i]);
    }
  });
  expectNothingLeft();
  EXPECT_GT(refused, names.size() / 4);
}

TEST_F(Corpus, FilesThatAreNoMeshAreRefusedWithOneLine) {
  const std::vector<std::string> names = corpusFiles(Kind::kOther);
  forEachInParallel(names.size(), [&](size_t i) {
    SCOPED_TRACE(names[i]);
    expectOneLine(
        run({"cook", kCorpus / names[i], "-o", output() / (std::to_string(i) + ".furrow"), "--quiet"}), 1,
        names[i]);
  });
  expectNothingLeft();
}

// Every frame of a simulation is met at its time, and between two frames their mean.
TEST_F(Corpus, SequencePlays) {
  const std::filesystem::path folder = kCorpus / "garment/diffcloth_tshirt";
  const Outcome cooked = run({"cook", "--sequence", folder / "frame_*.obj", "--fps", "10", "-o", asset()});
  ASSERT_EQ(cooked.status, 0) << cooked.err;
  const auto positionsAt = [&](const char* time) {
    const Outcome posed = eval("cpu", {"--clip", "sequence", "--time", time});
    EXPECT_EQ(posed.status, 0) << posed.err;
    std::vector<std::array<double, 3>> positions;
    for (const Row& row : rowsOf(posed.out)) positions.push_back({row.at("x"), row.at("y"), row.at("z")});
    return positions;
  };
  const auto frame = [&](const char* name) {
    std::vector<std::array<double, 3>> positions;
    std::istringstream text(readText(folder / name));
    for (std::string line, word; std::getline(text, line);) {
      std::istringstream words(line);
      std::array<double, 3> p{};
      if (words >> word && word == "v" && words >> p[0] >> p[1] >> p[2]) positions.push_back(p);
    }
    return positions;
  };
  const auto first = frame("frame_000.obj"), sixth = frame("frame_120.obj"), seventh = frame("frame_140.obj");
  const auto at_rest = positionsAt("0"), at_sixth = positionsAt("0.6"), between = positionsAt("0.65");
  ASSERT_EQ(first.size(), 1426u);
  ASSERT_EQ(at_rest.size(), first.size());
  for (size_t v = 0; v < first.size(); ++v)
    for (size_t c = 0; c < 3; ++c) {
      ASSERT_NEAR(at_rest[v][c], first[v][c], 3e-4);
      ASSERT_NEAR(at_sixth[v][c], sixth[v][c], 3e-4);
      ASSERT_NEAR(between[v][c], 0.5 * (sixth[v][c] + seventh[v][c]), 3e-4);
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
