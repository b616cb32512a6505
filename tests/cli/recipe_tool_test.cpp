// What `furrow cook` writes beside the asset: the recipe it worked out, the report and the depfile.

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/cli/tool.h"

namespace furrow::test {
namespace {

using nlohmann::json;

// A unit sheet of 8 x 8 quads, flat or bent to half a cylinder, whose morph target "squeeze" halves it along
// x.
std::string sheet(bool bent = false) {
  std::vector<float> positions, uvs, deltas;
  std::vector<uint16_t> indices;
  for (uint16_t y = 0; y <= 8; ++y)
    for (uint16_t x = 0; x <= 8; ++x) {
      const float u = x / 8.0f;
      positions.insert(positions.end(), {u, y / 8.0f, bent ? std::sqrt(u * (1.0f - u)) : 0.0f});
      uvs.insert(uvs.end(), {x / 8.0f, y / 8.0f});
      deltas.insert(deltas.end(), {x / -16.0f, 0.0f, 0.0f});
      const auto a = static_cast<uint16_t>(y * 9 + x), b = static_cast<uint16_t>(a + 1),
                 c = static_cast<uint16_t>(a + 9), d = static_cast<uint16_t>(a + 10);
      if (x < 8 && y < 8) indices.insert(indices.end(), {a, b, d, a, d, c});
    }
  GltfBuilder builder;
  builder.add(positions, "VEC3", 3);
  builder.add(indices, "SCALAR", 1);
  builder.add(uvs, "VEC2", 2);
  builder.add(deltas, "VEC3", 3);
  return builder.glb(
      R"("scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"materials":[{"name":"cloth"}],)"
      R"("meshes":[{"name":"Sheet","extras":{"targetNames":["squeeze"]},"primitives":[{"material":0,)"
      R"("attributes":{"POSITION":0,"TEXCOORD_0":2},"indices":1,"targets":[{"POSITION":3}]}]}])");
}

class RecipeTool : public ToolTest {
 protected:
  std::filesystem::path source = write("sheet.glb", sheet());
  std::filesystem::path asset = output() / "out.furrow", init = output() / "init.json";

  Outcome cook(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {"cook", source, "-o", asset};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }
};

TEST_F(RecipeTool, TheDocsNameEveryKeyOfTheReport) {
  const std::string recipe = write("recipe.json", R"({"layers":[{"name":"a","response":{"fit":0.9}}]})");
  const std::filesystem::path file = output() / "report.json";
  ASSERT_EQ(cook({"--recipe", recipe, "--report", file}).status, 0);
  const std::string docs = readText(FURROW_SOURCE_DIR "/docs/build_step.md");
  std::set<std::string> keys;
  const std::function<void(const json&)> collect = [&](const json& value) {
    for (const auto& [key, item] : value.items()) {
      if (value.is_object()) keys.insert(key);
      if (item.is_structured()) collect(item);
    }
  };
  collect(json::parse(readText(file)));
  for (const char* key : {"weldTolerance", "lowConfidence", "alpha", "rmsError", "stages"})
    EXPECT_TRUE(keys.contains(key)) << key;
  for (const std::string& key : keys) EXPECT_NE(docs.find('`' + key + '`'), docs.npos) << key;
}

TEST_F(RecipeTool, TheRecipeItWritesCooksTheSameAsset) {
  const std::string recipes[] = {"", R"({"layers":[{"name":"a","response":{"fit":0.9},"mask":"none"},
                        {"name":"b","direction":{"axis":[1,2,0]},"response":{"lambda":1.1,"beta":3.3},
                         "compress":"none","stretch":{"synthesize":{"preset":"cloth"}}}]})"};
  for (const std::string& recipe : recipes) {
    std::vector<std::string> options = {"--init", init, "--force"};
    if (!recipe.empty()) options.insert(options.end(), {"--recipe", write("recipe.json", recipe)});
    ASSERT_EQ(cook(options).status, 0);
    const std::string first = readText(asset), written = readText(init);
    const Outcome again = cook({"--recipe", init, "--init", output() / "again.json", "--force"});
    ASSERT_EQ(again.status, 0) << again.err;
    EXPECT_EQ(readText(asset), first);
    EXPECT_EQ(readText(output() / "again.json"), written);
    EXPECT_EQ(written.find("\"fit\""), std::string::npos) << "the fitted numbers stand there instead";
  }
}

TEST_F(RecipeTool, TheRecipeItWritesSaysWhatWasWorkedOut) {
  ASSERT_EQ(cook({"--init", init}).status, 0);
  const json layer = json::parse(readText(init)).at("layers").at(0);
  EXPECT_EQ(layer.at("name"), "wrinkles");
  EXPECT_EQ(layer.at("meshes"), json({"Sheet"}));
  EXPECT_EQ(layer.at("materials"), json({"cloth"}));
  EXPECT_EQ(layer.at("direction"), "animation");
  EXPECT_EQ(layer.at("mask"), "auto");
  const json& map = layer.at("compress").at("synthesize");
  EXPECT_EQ(map.at("preset"), "cloth");  // flat, whatever squeezes it
  EXPECT_NEAR(map.at("spacing"), std::sqrt(2.0) / 36.0, 1e-5);

  write("sheet.glb", sheet(true));
  ASSERT_EQ(cook({"--init", init, "--force"}).status, 0);
  const json bent = json::parse(readText(init)).at("layers").at(0).at("compress").at("synthesize");
  EXPECT_EQ(bent.at("preset"), "skin");  // a morph target squeezes it
}

// Whether morph targets squeeze the layer is asked for a height's depth alone, too.
TEST_F(RecipeTool, AHeightsDepthIsThatOfAFaceWhateverElseIsAsked) {
  write("sheet.glb", sheet(true));
  write("height.pgm", "P5 2 2 255\n\x10\x80\xc0\xf0");
  const auto depth = [&](const std::string& direction) {
    const std::string recipe =
        write("recipe.json",
              R"({"layers":[{"name":"a","mask":"none","compress":{"height":"height.pgm"},"direction":)" +
                  direction + "}]}");
    EXPECT_EQ(cook({"--recipe", recipe, "--init", init, "--force", "--quiet"}).status, 0);
    return json::parse(readText(init)).at("layers").at(0).at("compress").at("depth").get<double>();
  };
  const double asked = depth("\"animation\"");
  EXPECT_EQ(depth(R"({"axis":[1,0,0]})"), asked);
}

TEST_F(RecipeTool, AFittedResponseIsToldAndWritten) {
  const std::string recipe = write("recipe.json", R"({"layers":[{"name":"a","direction":{"axis":[1,0,0]},
    "mask":"none","response":{"fit":0.9}}]})");
  const Outcome outcome = cook({"--recipe", recipe, "--init", init, "--report", output() / "report.json"});
  ASSERT_EQ(outcome.status, 0);
  // alpha 4: beta = ln(1.9 / 0.1) / ln 4
  EXPECT_NE(outcome.err.find("layer \"a\": fitted lambda 1, beta 2.124: weight 0.9 at alpha 4"),
            std::string::npos)
      << outcome.err;
  EXPECT_EQ(json::parse(readText(init)).at("layers").at(0).at("response"),
            json({{"lambda", 1.0}, {"beta", 2.124}}));
  const json report = json::parse(readText(output() / "report.json"));
  EXPECT_NEAR(report.at("layers").at(0).at("fit").at("alpha"), 4.0, 1e-3);
  EXPECT_EQ(report.at("bytes"), std::filesystem::file_size(asset));
  double seconds = 0.0;
  for (const json& stage : report.at("stages")) seconds += stage.at("seconds").get<double>();
  EXPECT_NEAR(report.at("seconds"), seconds, 1e-9);
}

TEST_F(RecipeTool, ASourceInPlaceOfAnAssetIsCookedWithARecipe) {
  const std::filesystem::path recipe = write(
      "recipe.json", R"({"layers": [{"name": "a", "direction": {"axis": [1, 2, 0]}, "mask": "none"}]})");
  ASSERT_EQ(cook({"--recipe", recipe, "--quiet"}).status, 0);
  const auto eval = [&](const std::vector<std::string>& what) {
    std::vector<std::string> arguments = {"eval", "--backend", "cpu", "--morph", "squeeze=1"};
    arguments.insert(arguments.end(), what.begin(), what.end());
    return run(arguments).out;
  };
  const std::string weights = eval({source, "--recipe", recipe});
  EXPECT_NE(weights.find("weight_a"), std::string::npos);
  EXPECT_EQ(weights, eval({asset}));
}

TEST_F(RecipeTool, ALayerThatShowsNowhereIsSaid) {
  const auto errorsOf = [&](const char* axis) {
    const std::string layer = std::string(R"({"layers":[{"name":"a","direction":{"axis":)") + axis + "}}]}";
    return cook({"--recipe", write("recipe.json", layer)}).err;
  };
  EXPECT_NE(errorsOf("[0,0,1]").find("layer \"a\" shows nowhere"), std::string::npos);  // along the normal
  EXPECT_EQ(errorsOf("[1,0,0]").find("nowhere"), std::string::npos);
}

TEST_F(RecipeTool, ARestThatTheFileLacksIsSaid) {
  const auto cookRest = [&](const std::string& rest) {
    return cook({"--recipe", write("rest.json", R"({"rest":)" + rest + R"(,"layers":[{"name":"a"}]})")});
  };
  const Outcome typo = cookRest(R"({"morphs":{"squeze":1}})");
  EXPECT_EQ(typo.status, 1);
  EXPECT_EQ(typo.err,
            "furrow: " + source.string() + ": it has no morph target \"squeze\": it has: squeeze\n");
  GltfBuilder builder;
  builder.add<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3", 3);
  builder.add<float>({0, 2}, "SCALAR", 1);
  builder.add<float>({0, 0, 0, 1, 0, 0}, "VEC3", 3);
  source = write(
      "moving.glb",
      builder.glb(R"("scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"animations":[{"name":"go",)"
                  R"("samplers":[{"input":1,"output":2}],"channels":[{"sampler":0,"target":{"node":0,)"
                  R"("path":"translation"}}]}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}])"));
  EXPECT_EQ(cookRest(R"({"clip":"go","time":2})").err.find("is over"), std::string::npos);
  const Outcome late = cookRest(R"({"clip":"go","time":3.5})");
  EXPECT_EQ(late.status, 0);
  EXPECT_NE(late.err.find("warning: rest: clip \"go\" ends at 2 s, before 3.5 s: its last pose is taken\n"),
            std::string::npos)
      << late.err;
}

TEST_F(RecipeTool, AnotherRecipeIsNotReplacedUnasked) {
  const std::string mine = write("mine.json", "mine");
  expectRefused(cook({"--init", mine}), 2, mine + ": it exists already");
  EXPECT_EQ(readText(mine), "mine");
  EXPECT_EQ(cook({"--init", mine, "--force"}).status, 0);
  EXPECT_NE(readText(mine), "mine");
  EXPECT_EQ(cook({"--force"}).status, 2) << "--force is about --init";
}

TEST_F(RecipeTool, ARecipeThatCannotBeWrittenIsTheEnvironments) {
  const std::string nowhere = folder() / "no" / "init.json";
  EXPECT_EQ(cook({"--init", nowhere}).status, 3);
}

TEST_F(RecipeTool, TheRecipeItWritesIsValidByTheSchema) {
  if (!knowsSchemas()) GTEST_SKIP() << "python3-jsonschema is not installed";
  const std::filesystem::path schema = FURROW_SOURCE_DIR "/docs/recipe.schema.json";
  ASSERT_EQ(cook({"--init", init}).status, 0);
  EXPECT_TRUE(validBySchema(schema, init));
  const std::string wrong = write("wrong.json", R"({"layers":[{"nam":"a"}]})");
  EXPECT_FALSE(validBySchema(schema, wrong));
}

TEST_F(RecipeTool, ATakePlaysTheMorphTargetsItHasShapesFor) {
  const std::string take = write("take.csv",
                                 "Timecode,BlendshapeCount,SQUEEZE,HeadYaw\n00:00:00:00,2,0,9\n"
                                 "00:00:00:30,2,1,9\n00:00:01:00,2,0,9\n");
  ASSERT_EQ(cook({"--quiet"}).status, 0);
  const auto eval = [&](std::vector<std::string> pose) {
    pose.insert(pose.begin(), {"eval", asset, "--backend", "cpu"});
    return run(pose);
  };
  const Outcome played = eval({"--take", take, "--time", "0.15625"});
  EXPECT_EQ(played.status, 0);
  EXPECT_EQ(played.err, "furrow: " + take + ": warning: the asset has no morph target for HeadYaw\n");
  EXPECT_EQ(played.out, eval({"--morph", "squeeze=0.25"}).out);  // frame 30 of 48 is at 0.625 s
  EXPECT_EQ(eval({"--take", take}).out, eval({}).out);
  EXPECT_EQ(eval({"--take", take, "--time", "0.1", "--morph", "squeeze=1"}).out,
            eval({"--morph", "squeeze=1"}).out);
  expectOneLine(eval({"--time", "1"}), 2, "--time");
  expectOneLine(eval({"--take", write("bad.csv", "Timecode,a\n00:00:00:00,x\n")}), 1, "bad.csv: line 2: ");
  expectOneLine(eval({"--take", folder() / "gone.csv"}), 1, "gone.csv");
}

// DESIGN: the scale of a whole instance is no squeeze.
TEST_F(RecipeTool, AClipThatScalesTheWholeModelWrinklesNothing) {
  GltfBuilder builder;
  builder.add<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, "VEC3", 3);
  builder.add<uint16_t>({0, 1, 2, 0, 2, 3}, "SCALAR", 1);
  builder.add<float>({0, 1}, "SCALAR", 1);
  builder.add<float>({1, 1, 1, 0.5f, 0.5f, 0.5f}, "VEC3", 3);
  const std::filesystem::path shrinking = write(
      "shrinking.glb",
      builder.glb(
          R"("scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"children":[1]},{"mesh":0}],"animations":[{"name":"shrink",)"
          R"("samplers":[{"input":2,"output":3}],"channels":[{"sampler":0,"target":{"node":0,"path":"scale"}}]}],)"
          R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}])"));
  const Outcome cooked = run({"cook", shrinking, "-o", asset});
  ASSERT_EQ(cooked.status, 0);
  EXPECT_NE(cooked.err.find("no clip and no morph target squeezes it"), std::string::npos) << cooked.err;
  const auto weights = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"eval",   asset,    "--backend", "cpu",
                                          "--clip", "shrink", "--time",    "1"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const std::string csv = run(arguments).out;
    std::vector<double> found;
    for (size_t line = csv.find('\n'); line + 1 < csv.size(); line = csv.find('\n', line + 1)) {
      const size_t end = csv.find('\n', line + 1);
      found.push_back(std::atof(csv.substr(csv.rfind(',', end) + 1).c_str()));
    }
    EXPECT_EQ(found.size(), 4u) << csv;
    return found;
  };
  for (const double weight : weights({})) EXPECT_NEAR(weight, 0.0, 1e-4);
  for (const double weight : weights({"--scale", "1"})) EXPECT_GT(weight, 0.5);
}

TEST_F(RecipeTool, TheDepfileNamesWhatWasRead) {
  const std::string recipe = write("my recipe.json", R"({"layers":[{"name":"a"}]})");
  ASSERT_EQ(cook({"--recipe", recipe, "--depfile", output() / "out.d"}).status, 0);
  EXPECT_EQ(readText(output() / "out.d"), asset.string() + ": \\\n  " + source.string() + " \\\n  " +
                                              (folder() / "my\\ recipe.json").string() + "\n");
}

}  // namespace
}  // namespace furrow::test
