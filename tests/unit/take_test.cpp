// Performance takes, the spellings of face shapes, and the drivers that go from them to region weights.

#include "pipeline/import/take.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "furrow/drivers.h"
#include "gltf_builder.h"
#include "pipeline/error.h"
#include "pipeline/recipe/arkit.h"
#include "sheets.h"

namespace furrow::tests {
namespace {

using pipeline::matchShape;
using pipeline::Take;
using testing::ElementsAre;

Take take(const std::string& text) {
  return pipeline::readTake(test::writeFile("take.csv", text));
}

std::string errorOf(const std::string& text) {
  try {
    take(text);
  } catch (const pipeline::Error& error) {
    EXPECT_EQ(error.exit(), pipeline::Exit::kBadData);
    const std::string what = error.what();
    return what.substr(what.find("take.csv: ") + 10);
  }
  return "no error";
}

const std::string kHead = "Timecode,BlendshapeCount,JawOpen,BrowInnerUp\n";

TEST(Take, ReadsFramesAndGoesStraightBetweenThem) {
  const Take t =
      take(kHead + "01:02:03:58.500,2,0,0.25\n01:02:03:59.500,2,0.5,0.25\n01:02:04:00.500,2,1,0.75\n");
  EXPECT_THAT(t.shapes, ElementsAre("JawOpen", "BrowInnerUp"));
  ASSERT_EQ(t.times.size(), 3u);  // 60 frames a second
  EXPECT_DOUBLE_EQ(t.times[1], 1.0 / 60.0);
  EXPECT_NEAR(t.times[2], 2.0 / 60.0, 1e-12);
  EXPECT_THAT(t.at(-1.0), ElementsAre(0.0f, 0.25f));
  EXPECT_THAT(t.at(9.0), ElementsAre(1.0f, 0.75f));
  const std::vector<float> between = t.at(1.5 / 60.0);
  EXPECT_NEAR(between[0], 0.75, 1e-6);
  EXPECT_NEAR(between[1], 0.5, 1e-6);
}

TEST(Take, TheRateFollowsFromTheTimecode) {
  const auto second = [](const char* last) {
    return take("Timecode,A\n00:00:00:00,0\n00:00:00:" + std::string(last) + ",1\n00:00:01:00,0\n").times[1];
  };
  EXPECT_DOUBLE_EQ(second("23"), 23.0 / 24.0);
  EXPECT_DOUBLE_EQ(second("24"), 24.0 / 25.0);
  EXPECT_DOUBLE_EQ(second("29"), 29.0 / 30.0);
  EXPECT_DOUBLE_EQ(second("59"), 59.0 / 60.0);
  EXPECT_DOUBLE_EQ(second("119"), 119.0 / 120.0);
  // No second ends within the take.
  EXPECT_DOUBLE_EQ(take("Timecode,A\n00:00:00:00,0\n00:00:00:20,1\n").times[1], 20.0 / 60.0);
}

TEST(Take, BytesThatToolsAdd) {
  const Take plain = take(kHead + "00:00:00:00,2,0.5,1e-1\n");
  for (const std::string& text :
       {"\xef\xbb\xbf" + kHead + "00:00:00:00,2,0.5,1e-1",
        std::string("Timecode,BlendshapeCount,JawOpen,BrowInnerUp\r\n00:00:00:00,2,0.5,1e-1\r\n\r\n"),
        std::string("\"Timecode\",\"BlendshapeCount\",\"JawOpen\",\"BrowInnerUp\"\n"
                    "\"00:00:00:00\",\"2\",\" 0.5 \",\"1e-1\"\n"),
        // As spreadsheets write it, in other languages too.
        std::string("Timecode;BlendshapeCount;JawOpen;BrowInnerUp\n00:00:00:00;2;0,5;1e-1\n"),
        std::string("\r\nsep=;\r\nTimecode;BlendshapeCount;JawOpen;BrowInnerUp\r\n00:00:00:00;2;0.5;0,1\r\n"),
        std::string("Timecode\tBlendshapeCount\tJawOpen\tBrowInnerUp\n00:00:00:00\t2\t0.5\t0.1\n"),
        std::string("Timecode,BlendshapeCount,JawOpen,BrowInnerUp\r00:00:00:00,2,\"0,5\",0.1\r")}) {
    const Take t = take(text);
    EXPECT_EQ(t.shapes, plain.shapes) << text;
    EXPECT_EQ(t.weights, plain.weights) << text;
  }
  EXPECT_THAT(take("Timecode,\"a \"\"b\"\", c\"\n00:00:00:00,1\n").shapes, ElementsAre("a \"b\", c"));
}

TEST(Take, RunsOverMidnight) {
  const Take t = take("Timecode,A\n23:59:59:59,0\n00:00:00:00,1\n00:00:01:00,2\n");
  ASSERT_EQ(t.times.size(), 3u);
  EXPECT_DOUBLE_EQ(t.times[1], 1.0 - 59.0 / 60.0);
  EXPECT_DOUBLE_EQ(t.times[2] - t.times[1], 1.0);
  const Take days = take("Timecode,A\n20:00:00:00,0\n04:00:00:00,0\n20:00:00:00,0\n04:00:00:00,0\n");
  EXPECT_THAT(days.times, ElementsAre(0.0, 8 * 3600.0, 24 * 3600.0, 32 * 3600.0));
}

TEST(Take, OfTwoFramesWithOneTimecodeTheLaterCounts) {
  const Take t = take("Timecode,A\n00:00:00:00,0\n00:00:00:01,1\n00:00:00:01,2\n");
  EXPECT_EQ(t.times.size(), 2u);
  EXPECT_THAT(t.weights, ElementsAre(0.0f, 2.0f));
}

TEST(Take, FaultsAreNamedByTheirLine) {
  EXPECT_EQ(errorOf("\xff\xfeT"), "line 1: it is UTF-16: save it as UTF-8");
  EXPECT_EQ(errorOf("\n\nsep=;\nTimecode;A\n00:00:00:00;1;2\n").substr(0, 24), "line 5: it has 3 fields,");
  EXPECT_EQ(errorOf("\n"), "line 2: it is empty: give a CSV file with a Timecode column");
  EXPECT_EQ(errorOf(""), "line 1: it is empty: give a CSV file with a Timecode column");
  EXPECT_EQ(errorOf("A,B\n1,2\n"),
            "line 1: it has no column \"Timecode\": export it from Live Link Face as CSV");
  EXPECT_EQ(errorOf("Timecode,BlendshapeCount\n"),
            "line 1: it has no column of a shape: export it with its blend shapes");
  EXPECT_EQ(errorOf(kHead), "line 2: it has no frames: record a take");
  const std::string good = "00:00:00:00,2,0,0\n";
  EXPECT_EQ(errorOf(kHead + good + "00:00:00:01,2,0\n"),
            "line 3: it has 3 fields, the first line has 4: a line may be cut off: remove it");
  for (const char* bad : {"", "x", "nan", "inf", "1e9", "0x1", "1 2"})
    EXPECT_EQ(errorOf(kHead + good + "00:00:00:01,2,0," + bad + "\n"),
              "line 3: \"" + std::string(bad) + "\" is not a number: correct or remove the line");
  for (const char* bad : {"00:00:00", "00:60:00:00", "-1:00:00:00", "0.5:00:00:00", "00:00:00:120"})
    EXPECT_EQ(errorOf(kHead + std::string(bad) + ",2,0,0\n"),
              "line 2: \"" + std::string(bad) + "\" is no timecode: write HH:MM:SS:FF");
  EXPECT_EQ(errorOf(kHead + "00:00:01:00,2,0,0\n" + good),
            "line 3: its timecode lies before that of the frame above: sort the frames, or split the take");
  EXPECT_EQ(errorOf(kHead + "\n00:00:01:00,2,0,0\n\n" + good),
            "line 5: its timecode lies before that of the frame above: sort the frames, or split the take");
  EXPECT_EQ(errorOf(kHead + "\"00:00:00:00,2,0,0\n"), "line 2: a quote is not closed: close it");
}

TEST(Take, EveryTruncationIsReadOrRefused) {
  const std::string text = kHead + "00:00:00:58,2,0,0.25\r\n\"00:00:01:00\",2,1,0.75\r\n";
  for (size_t size = 0; size <= text.size(); ++size) errorOf(text.substr(0, size));
}

TEST(Shapes, ExactThenSpellingsThenSides) {
  const std::vector<std::string> vendor = {"head.browDown_L", "browDown_R",    "jawOpen",         "JawOpen",
                                           "browInnerUp_L",   "BrowInnerUp.R", "mouth_smile_left"};
  EXPECT_THAT(matchShape(vendor, "browDownLeft"), ElementsAre(0));
  EXPECT_THAT(matchShape(vendor, "BrowDownRight"), ElementsAre(1));
  EXPECT_THAT(matchShape(vendor, "JawOpen"), ElementsAre(3));
  EXPECT_THAT(matchShape(vendor, "jaw-open"), ElementsAre(2, 3));
  EXPECT_THAT(matchShape(vendor, "browInnerUp"), ElementsAre(4, 5));
  EXPECT_THAT(matchShape(vendor, "mouthSmileLeft"), ElementsAre(6));
  EXPECT_THAT(matchShape(vendor, "mouthSmileRight"), ElementsAre());
  EXPECT_THAT(matchShape(vendor, "browDown"), ElementsAre(0, 1));
  EXPECT_THAT(matchShape({"", "mouthRollLower"}, "mouthFunnel"), ElementsAre());
}

TEST(Shapes, EveryTableHasShapesOfItsSideAndReachesFullWeight) {
  for (const std::string& table : pipeline::driverTables()) {
    double sum = 0.0;
    for (const auto& [shape, gain] : pipeline::driverTable(table)) {
      sum += gain;
      EXPECT_FALSE(table.ends_with("Left") && shape.ends_with("Right")) << table << ' ' << shape;
      EXPECT_FALSE(table.ends_with("Right") && shape.ends_with("Left")) << table << ' ' << shape;
    }
    EXPECT_GE(sum, 0.999) << table;
  }
  EXPECT_THAT(pipeline::driverTable("arkit:glabella"),
              ElementsAre(testing::Pair("browDownLeft", 0.5), testing::Pair("browDownRight", 0.5)));
  EXPECT_TRUE(pipeline::driverTable("").empty());
}

pipeline::SourceScene drivenScene(const std::vector<std::string>& morphs) {
  SourceScene scene = sceneOf(sheet(2), [](glm::dvec3 p) { return p + glm::dvec3(0, 0, 0.1); });
  scene.rig.morphs.clear();
  scene.primitives[0].morphs.resize(morphs.size(), scene.primitives[0].morphs[0]);
  for (uint32_t m = 0; m < morphs.size(); ++m) scene.rig.morphs.push_back({morphs[m], 0, m, 0.0});
  return scene;
}

float regionOf(const AssetView& asset, std::vector<float> morph_weights, float scripted = 0.0f) {
  std::vector<float> regions(asset.layerCount(), scripted);
  driveRegions(asset, morph_weights, regions, regions);
  return regions[0];
}

TEST(Drivers, FollowTheirCurve) {
  pipeline::LayerRecipe layer = axisLayer({1, 0, 0});
  layer.drivers = {{"a", 0.5, {{0.2, 0.0}, {0.6, 1.0}, {1.0, 0.5}}}, {"b", -2.0}};
  const Asset asset = cookAsset(drivenScene({"a", "b"}), recipeOf({layer}));
  const AssetView& view = asset.view();
  EXPECT_EQ(regionOf(view, {0.0f, 0.0f}), 0.0f);
  EXPECT_EQ(regionOf(view, {0.2f, 0.0f}), 0.0f);
  EXPECT_NEAR(regionOf(view, {0.4f, 0.0f}), 0.25, 1e-6);
  EXPECT_NEAR(regionOf(view, {0.6f, 0.0f}), 0.5, 1e-6);
  EXPECT_NEAR(regionOf(view, {0.8f, 0.0f}), 0.375, 1e-6);
  EXPECT_NEAR(regionOf(view, {7.0f, 0.0f}), 0.25, 1e-6);
  EXPECT_NEAR(regionOf(view, {0.6f, 0.2f}), 0.1, 1e-6);
  EXPECT_NEAR(regionOf(view, {0.6f, 0.2f}, 0.3f), 0.4, 1e-6);
  EXPECT_EQ(regionOf(view, {0.0f, 5.0f}), -1.0f);
}

TEST(Drivers, ATableFindsTheShapesUnderOtherSpellings) {
  pipeline::LayerRecipe layer = axisLayer({1, 0, 0});
  layer.driver_table = "arkit:forehead";
  const pipeline::Cooked cooked = pipeline::cook(
      drivenScene({"browInnerUp_L", "browInnerUp_R", "BrowOuterUpLeft", "browOuterUp_R", "jawOpen"}),
      recipeOf({layer}), {});
  Asset asset;
  ASSERT_TRUE(asset.load(cooked.bytes).ok());
  EXPECT_NEAR(regionOf(asset.view(), {1, 1, 1, 1, 0}), 1.0, 1e-6);
  EXPECT_NEAR(regionOf(asset.view(), {1, 0, 0, 0, 0}), 0.3, 1e-6);
  EXPECT_EQ(regionOf(asset.view(), {0, 0, 0, 0, 1}), 0.0f);
  ASSERT_EQ(cooked.recipe.layers[0].drivers.size(), 4u);
  EXPECT_EQ(cooked.recipe.layers[0].drivers[0].morph, "browInnerUp_L");
  EXPECT_TRUE(cooked.recipe.layers[0].driver_table.empty());
}

TEST(Drivers, ATableWithoutItsShapesIsTold) {
  pipeline::LayerRecipe layer = axisLayer({1, 0, 0});
  layer.driver_table = "arkit:bunny";
  EXPECT_THAT(pipeline::cook(drivenScene({"squeeze"}), recipeOf({layer}), {}).report.warnings,
              testing::Contains("layer \"layer\": no morph target is one of arkit:bunny"));
}

}  // namespace
}  // namespace furrow::tests
