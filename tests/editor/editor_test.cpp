// The real editor, driven by scripts as a person would: without a screen, and once in a real window. The
// pictures in tests/editor/pictures are compared with what it draws; FURROW_UPDATE=1 in the environment
// stores what is drawn now, and the guide's screenshots in docs/images.

#include <cmath>
#include <cstdlib>

#include "editor/preview/headless_context.h"
#include "pipeline/error.h"
#include "pipeline/maps/image.h"
#include "pipeline/recipe/recipe.h"
#include "tests/cli/tool.h"
#include "tests/editor/editor_models.h"
#include "tests/image/picture_difference.h"

namespace furrow::test {
namespace {

namespace fs = std::filesystem;
using pipeline::Image;

const fs::path kSource = FURROW_SOURCE_DIR;
const bool kUpdate = std::getenv("FURROW_UPDATE") != nullptr;

// Fonts differ in nothing as long as it is the same one.
constexpr uint32_t kBlock = 16;
constexpr double kMeanTolerance = 0.6, kBlockTolerance = 12.0;

class EditorTest : public ToolTest {
 protected:
  void SetUp() override {
    try {
      const preview::HeadlessContext probe;
    } catch (const pipeline::Error& error) {
      GTEST_SKIP() << error.what();
    }
    write("sheet.glb", editorSheet());
    write("sheet.json", kEditorRecipe);
  }

  Outcome play(const std::string& script, const std::string& tier = "cpu") const {
    return run({"--script", write("script.txt", script), "--frames", output(), "--size", "1024x640",
                "--backend", tier},
               FURROW_EDITOR);
  }
  // `environment`: assignments in front of the editor.
  Outcome playInWindow(const std::string& script, const std::string& environment = "") const {
    return run({"-c", "exec xvfb-run -a -s '-screen 0 1280x1024x24' env " + environment + " '" +
                          std::string(FURROW_EDITOR) + "' --script '" + write("script.txt", script).string() +
                          "' --frames '" + output().string() + "' --size 1024x640 --backend cpu --window"},
               "/bin/sh");
  }
  void expectPlays(const std::string& script) const {
    const Outcome outcome = play(script);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
  }
  Image picture(const std::string& name) const { return pipeline::readImage(output() / (name + ".png")); }
  // What the renderer draws, below the labels.
  Image view(const std::string& name) const {
    const Image whole = picture(name);
    Image part{320, 400, 4, {}};
    for (uint32_t y = 0; y < part.height; ++y)
      part.pixels.insert(part.pixels.end(), whole.at(352, 130 + y), whole.at(352 + part.width, 130 + y));
    return part;
  }
  // "@/" stands for the folder of the files.
  void expectPlaysInFolder(std::string script) const {
    for (size_t at = script.find("@/"); at != std::string::npos; at = script.find("@/", at))
      script.replace(at, 1, folder().string());
    expectPlays(script);
  }
  std::string sheet() const { return "open " + (folder() / "sheet.glb").string() + "\nwait\n"; }

  void expectStored(const std::string& name, const char* in = "tests/editor/pictures") const {
    const fs::path stored = kSource / in / (name + ".png");
    const Image drawn = picture(name);
    if (kUpdate) {
      fs::create_directories(stored.parent_path());
      pipeline::writeImage(stored, drawn);
    }
    const Difference now = difference(drawn, pipeline::readImage(stored), kBlock);
    if (now.mean <= kMeanTolerance && now.worst_block <= kBlockTolerance) return;
    const fs::path kept = fs::path(FURROW_PICTURES) / (name + ".png");
    fs::create_directories(kept.parent_path());
    pipeline::writeImage(kept, drawn);
    ADD_FAILURE() << "mean " << now.mean << ", worst block " << now.worst_block << ": compare " << kept
                  << " with " << stored
                  << "; if the new one is right, run this test with FURROW_UPDATE=1 and commit it";
  }
};

// Without the last message, which is another after a loss.
constexpr const char* kLooks = R"(
key Ctrl+J
click problems.clear
key Ctrl+J
drag morph.squeeze 0.05 0.5 0.9 0.5
picture squeezed
key 2
key W
picture split
)";

TEST_F(EditorTest, ShowsASqueezedSheetWithItsWrinklesAndWeights) {
  expectPlays(sheet() + kLooks);
  expectStored("squeezed");
  expectStored("split");
  // The pictures can tell whether there are wrinkles.
  EXPECT_GT(difference(picture("squeezed"), picture("split"), kBlock).worst_block, 3.0 * kBlockTolerance);
}

// Before the panels have their sizes.
TEST_F(EditorTest, AFileThatIsThereInTheFirstFrameIsFramedAsAnyOther) {
  expectPlays("open " + (folder() / "sheet.glb").string() + " stalled\nwait\n" + kLooks);
  expectStored("squeezed");
  expectStored("split");
}

bool canOpenWindows() {
  return std::system("command -v xvfb-run >/dev/null && command -v xauth >/dev/null") == 0;
}

TEST_F(EditorTest, ARealWindowShowsTheSame) {
  if (!canOpenWindows()) GTEST_SKIP() << "there is no xvfb-run or xauth to open a window with";
  // GLX's driver leaks when it is unloaded.
  const Outcome outcome =
      playInWindow(sheet() + kLooks, kAddressSanitizer ? "ASAN_OPTIONS=detect_leaks=0" : "");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  expectStored("squeezed");
  expectStored("split");
}

#ifdef FURROW_LOSE_CONTEXT
// A driver that is reset under the first picture, and again under the first after that.
TEST_F(EditorTest, ALostContextIsReplacedAndTheSessionGoesOn) {
  if (kAddressSanitizer) GTEST_SKIP() << "AddressSanitizer's library has to be preloaded first";
  const std::string script = sheet() + "expect message \"the OpenGL context was lost\"\n" + kLooks;
  const std::string losing = "FURROW_LOSSES=2 LD_PRELOAD='" + preloaded(FURROW_LOSE_CONTEXT) + "'";
  const auto expectTheSession = [&](const Outcome& outcome) {
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    expectStored("squeezed");
    expectStored("split");
  };
  expectTheSession(run({"-c", "exec env " + losing + " '" + FURROW_EDITOR + "' --script '" +
                                  write("script.txt", script).string() + "' --frames '" + output().string() +
                                  "' --size 1024x640 --backend cpu"},
                       "/bin/sh"));
  if (canOpenWindows()) expectTheSession(playInWindow(script, losing));
}

TEST_F(EditorTest, ATierThatWasLostCanBeTriedAgain) {
  if (kAddressSanitizer) GTEST_SKIP() << "AddressSanitizer's library has to be preloaded first";
  const auto playLosing = [&](const std::string& script) {
    return run({"-c", "exec env FURROW_LOSSES=1 LD_PRELOAD='" + preloaded(FURROW_LOSE_CONTEXT) +
                          "' '" FURROW_EDITOR "' --script '" + write("script.txt", script).string() +
                          "' --frames '" + output().string() + "' --size 1024x640 --backend gpu-raster"},
               "/bin/sh");
  };
  const std::string again = sheet() + "expect widget status.retry\nclick status.retry\nexpect no error\n";
  Outcome outcome = playLosing(again);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  outcome = playLosing(again + "expect widget status.retry\n");
  EXPECT_NE(outcome.status, 0);
  EXPECT_NE(outcome.err.find("expected widget status.retry"), std::string::npos) << outcome.err;
}
#endif

TEST_F(EditorTest, AStrangerPaintsABiasChangesAResponseSavesCooksAndRenders) {
  const fs::path hero = write("hero.glb", editorSheet());  // no recipe beside it
  const fs::path recipe = folder() / "hero.json", asset = folder() / "hero.furrow";
  expectPlays("open " + hero.string() + R"(
wait
click tool.tool.bias
drag viewport 0.42 0.6 0.6 0.6
wait
drag layer.beta 0.4 0.5 0.7 0.5
picture painted
key Ctrl+S
expect saved
key Ctrl+K
key Enter
wait
expect message "hero.furrow: cooked"
expect no error
)");
  expectStored("painted");
  ASSERT_TRUE(fs::exists(recipe));
  ASSERT_TRUE(fs::exists(asset));
  EXPECT_TRUE(fs::exists(folder() / "hero_wrinkles_bias.png"));
  EXPECT_NE(readText(recipe).find("hero_wrinkles_bias.png"), std::string::npos);

  // What the editor cooked is what the tool cooks from what it saved.
  const fs::path again = output() / "again.furrow";
  Outcome outcome = run({"cook", hero, "--recipe", recipe, "-o", again, "--quiet"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(readText(asset), readText(again));

  // And it is seen.
  const auto render = [&](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"render", asset,     "-o",        output() / (name + ".png"),
                                          "--size", "128x128", "--backend", "cpu"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome drawn = run(arguments);
    EXPECT_EQ(drawn.status, 0) << drawn.err;
    return picture(name);
  };
  const Image bias = render("bias", {"--view", "bias"});
  const float* inside = bias.at(64, 76);
  const float* outside = bias.at(64, 24);
  EXPECT_GT(inside[0], inside[2] + 0.3f);      // red: creased at rest
  EXPECT_NEAR(outside[0], outside[2], 0.03f);  // grey: as it is
  const Image creased = render("creased", {"--shading", "interpolated"}),
              plain = render("plain", {"--shading", "none"});
  EXPECT_GT(difference(creased, plain, kBlock).worst_block, 1.0);
}

TEST_F(EditorTest, UndoSavingAndLeavingAskBeforeWorkIsLost) {
  const fs::path recipe = folder() / "sheet.json";
  expectPlays(sheet() + R"(
drag layer.beta 0.4 0.5 0.7 0.5
expect dirty
key Ctrl+Z
expect saved
key Ctrl+Shift+Z
expect dirty
open sheet.glb
expect widget leave.save
click leave.cancel
expect dirty
click layer.add
wait
expect widget "layer.select.wrinkles"
click layer.up
click layer.remove
click layer.select.lines
click layer.name 0.9 0.5
key Ctrl+A
type brows
key Enter
expect widget layer.select.brows
key Ctrl+S
expect saved
expect no error
)");
  const std::string text = readText(recipe);
  EXPECT_NE(text.find("\"brows\""), std::string::npos) << text;
  EXPECT_EQ(text.find("\"wrinkles\""), std::string::npos) << text;
  EXPECT_EQ(text.find("\"beta\": 4.0 }, \"mask\": \"none\""), std::string::npos) << text;
}

TEST_F(EditorTest, WorkThatCannotBeSavedIsNotLost) {
  fs::create_directory(folder() / "hero.json");  // where the recipe should go
  write("hero.glb", editorSheet());
  expectPlaysInFolder(R"(
open @/hero.glb
wait
drag layer.beta 0.4 0.5 0.7 0.5
open @/sheet.glb
click leave.save
expect widget leave.problem
expect message "hero.json"
expect dirty
click leave.cancel
expect layers wrinkles
key Ctrl+Shift+S
key Ctrl+A
type saved.json
key Enter
expect saved
)");
  EXPECT_NE(readText(folder() / "hero.json" / "saved.json").find("\"beta\""), std::string::npos);
}

TEST_F(EditorTest, ASmallWindowHidesNoTool) {
  const std::string script = sheet() + R"(
click tool.tool.bias
frames 2
expect widget brush.size
expect widget brush.bias
expect widget tool.brush.erase
expect widget look.tier
expect widget status.message
click tool.view.split
frames 2
expect widget look2.tier
expect widget tool.view.split
picture narrow
)";
  const Outcome outcome = run({"--script", write("script.txt", script), "--frames", output(), "--size",
                               "800x600", "--backend", "cpu"},
                              FURROW_EDITOR);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  expectStored("narrow");
  const Outcome smaller = run({"--script", write("small.txt", sheet() + "expect widget layer.down\n"),
                               "--frames", output(), "--size", "640x480", "--backend", "cpu"},
                              FURROW_EDITOR);
  EXPECT_EQ(smaller.status, 0) << smaller.err;
}

TEST_F(EditorTest, AFaultShowsInTheListAndTheLastGoodStateStays) {
  expectPlays(sheet() + R"(
click section.response
click layer.mask
click layer.mask.Attribute
wait
expect message "no vertex attribute"
picture fault
key Ctrl+Z
wait
expect saved
)");
  expectStored("fault");
}

TEST_F(EditorTest, GuidesCombAndMaskReachTheRecipe) {
  expectPlays(sheet() + R"(
key G
drag viewport 0.4 0.4 0.6 0.6
wait
key D
drag viewport 0.4 0.6 0.6 0.6
wait
key M
drag viewport 0.45 0.45 0.55 0.45
wait
key Ctrl+S
expect saved
expect no error
)");
  const std::string text = readText(folder() / "sheet.json");
  EXPECT_NE(text.find("sheet_lines_direction.png"), std::string::npos) << text;
  EXPECT_NE(text.find("sheet_lines_mask.png"), std::string::npos) << text;
  const Image mask = pipeline::readImage(folder() / "sheet_lines_mask.png");
  EXPECT_EQ(mask.channels, 1u);
  // Opened again it is still painted, not an image of the artist's.
  const std::string again = sheet() + "click layer.select.lines\nclick section.response\nexpect widget ";
  EXPECT_EQ(play(again + "layer.mask\n").status, 0);
  EXPECT_EQ(play(again + "layer.mask_image\n").status, 2);
}

TEST_F(EditorTest, StrokesAreMirroredAtThePlaneThatIsChosen) {
  expectPlays(sheet() + R"(
key B
key X
click menu.Edit
click brush.mirror_axis
click brush.mirror_axis.1
drag viewport 0.45 0.35 0.55 0.35
key Ctrl+S
expect saved
)");
  const Image bias = pipeline::readImage(folder() / "sheet_lines_bias.png");
  const uint32_t middle = bias.width / 2, quarter = bias.height / 4;
  float up = 0.0f, down = 0.0f;
  for (uint32_t y = 0; y < 2 * quarter; ++y) {
    up = std::max(up, bias.at(middle, y)[0]);
    down = std::max(down, bias.at(middle, y + 2 * quarter)[0]);
  }
  EXPECT_GT(up, 0.7f);
  EXPECT_NEAR(down, up, 0.02f);
}

TEST_F(EditorTest, StrokesThatComeFromBesideTheSurfaceBeginWhereTheyMeetIt) {
  expectPlays(sheet() + R"(
key B
drag viewport 0.02 0.05 0.5 0.5
expect dirty
key Ctrl+Z
expect saved
key G
drag viewport 0.02 0.05 0.5 0.5
expect dirty
)");
}

TEST_F(EditorTest, AFastHandLeavesNothingOut) {
  expectPlays(sheet() + R"(
key G
drag viewport 0.4 0.4 0.6 0.6 left 1
key Ctrl+S
expect saved
)");
  const pipeline::LayerRecipe layer = pipeline::readRecipe(folder() / "sheet.json").layers[0];
  const auto* guides = std::get_if<pipeline::DirectionGuides>(&layer.direction);
  ASSERT_TRUE(guides && guides->curves.size() == 1);
  EXPECT_GE(guides->curves[0].size(), 5u);
}

TEST_F(EditorTest, AMaskPaintedWhereAllWasWhiteBeginsBlack) {
  const fs::path still = write("still.glb", editorStill());  // nothing squeezes it: its mask is white
  expectPlays("open " + still.string() + R"(
wait
key M
drag viewport 0.42 0.6 0.6 0.6
wait
key Ctrl+S
expect saved
key B
drag viewport 0.42 0.3 0.6 0.3
expect message "does not reach what was painted"
)");
  const Image mask = pipeline::readImage(folder() / "still_wrinkles_mask.png");
  const auto [least, most] = std::minmax_element(mask.pixels.begin(), mask.pixels.end());
  EXPECT_EQ(*least, 0.0f);
  EXPECT_GT(*most, 0.7f);
}

// Largest difference of a block in what the renderer draws.
#define VIEWS_DIFFER(a, b) difference(view(a), view(b), kBlock).worst_block

TEST_F(EditorTest, TheCameraOrbitsPansZoomsAndFrames) {
  expectPlays(sheet() + R"(
hold Ctrl
release
picture start
drag viewport 0.5 0.5 0.6 0.45
picture orbited
drag viewport 0.6 0.45 0.5 0.5
picture orbited_back
drag viewport 0.5 0.5 0.6 0.45
key T
picture front
hold Shift
drag viewport 0.4 0.4 0.4 0.5
release
picture panned
drag viewport 0.4 0.5 0.4 0.4 middle
picture panned_back
key Shift+Left
key Shift+Right
picture panned_by_keys
wheel viewport 3
picture near
key -
key -
picture farther
key A
picture framed
key Left
key Right
key Up
key Down
picture keys_back
drag viewport 0.5 0.5 0.7 0.5 right
picture lights
key Shift+L
picture lights_back
click tool.tool.mask
drag viewport 0.3 0.3 0.35 0.3
wait
key Q
key F
picture framed_layer
)");
  constexpr double kSame = 1.0, kOther = 8.0;
  EXPECT_GT(VIEWS_DIFFER("start", "orbited"), kOther);
  EXPECT_LT(VIEWS_DIFFER("start", "orbited_back"), kSame);
  EXPECT_LT(VIEWS_DIFFER("start", "front"), kSame);
  EXPECT_LT(VIEWS_DIFFER("start", "panned_back"), kSame);
  EXPECT_LT(VIEWS_DIFFER("start", "panned_by_keys"), kSame);
  EXPECT_GT(VIEWS_DIFFER("start", "near"), kOther);
  EXPECT_LT(VIEWS_DIFFER("start", "framed"), kSame);
  EXPECT_LT(VIEWS_DIFFER("start", "keys_back"), kSame);
  EXPECT_GT(VIEWS_DIFFER("start", "lights"), 2.0);
  EXPECT_LT(VIEWS_DIFFER("start", "lights_back"), kSame);
  EXPECT_GT(VIEWS_DIFFER("start", "framed_layer"), kOther);
  // The surface goes where the pointer goes: the sheet's upper edge by a tenth of the view's height.
  const auto upperEdge = [&](const char* name) {
    const Image shown = view(name);
    uint32_t y = 0;
    while (y < shown.height && shown.at(150, y)[0] < 0.4f) ++y;
    return static_cast<double>(y);
  };
  const double height = 484.0;  // of the view in a window of 1024 x 640
  EXPECT_NEAR(upperEdge("panned") - upperEdge("start"), 0.1 * height, 6.0);
}

TEST_F(EditorTest, TheSplitScreenComparesMethodsTiersRecipesAndFiles) {
  const fs::path bare =
      write("bare.json", R"({"mapSize": 128, "layers": [{"name": "lines", "compress": "none"}]})");
  const Outcome cooked =
      run({"cook", folder() / "sheet.glb", "--recipe", bare, "-o", folder() / "bare.furrow", "--quiet"});
  ASSERT_EQ(cooked.status, 0) << cooked.err;
  const auto compare = [](const std::string& file) {
    return "click menu.View\nclick view.compare\nkey Ctrl+A\ntype " + file + "\nkey Enter\nwait\n";
  };
  expectPlays(sheet() + R"(
drag morph.squeeze 0.05 0.5 0.95 0.5
picture wrinkled
key W
drag divider 0.5 0.5 -30 0.5
picture plain
click look2.shading
click "look2.shading.Interpolated bump"
picture same_method
click look2.tier
click look2.tier.gpu
picture other_tier
key Ctrl+Right
picture moved
)" + compare("bare.json") +
              "picture recipe\n" + compare("bare.furrow") + R"(picture asset
click look2.compared
expect no error
)");
  EXPECT_LT(VIEWS_DIFFER("wrinkled", "same_method"), 6.0);  // but for the divider
  EXPECT_LT(VIEWS_DIFFER("same_method", "other_tier"), 1.0);
  const auto wrinkles = [&](const char* name) {
    // Away from labels and divider.
    const Image shown = view(name);
    double sum = 0.0;
    for (uint32_t y = 150; y < 300; ++y)
      for (uint32_t x = 120; x < 220; ++x) sum += std::abs(shown.at(x, y)[0] - shown.at(x + 1, y)[0]);
    return sum;
  };
  EXPECT_GT(wrinkles("wrinkled"), 3.0 * wrinkles("plain"));
  EXPECT_GT(wrinkles("same_method"), 3.0 * wrinkles("plain"));
  EXPECT_LT(wrinkles("recipe"), 1.5 * wrinkles("plain"));
  EXPECT_LT(wrinkles("asset"), 1.5 * wrinkles("plain"));
}

TEST_F(EditorTest, FilesAreDroppedTakesPlayedAndRecentOnesOpenedAgain) {
  write("other.glb", editorSheet());
  write("take.csv", "Timecode,BlendshapeCount,Squeeze\n00:00:00:00,1,0\n00:00:00:29,1,1\n00:00:01:00,1,1\n");
  expectPlaysInFolder(sheet() + R"~(
drop @/other.glb
wait
drop @/sheet.glb
wait
expect layers lines other
click timeline.clip
click "timeline.clip.(no clip)"
picture rest
drop @/take.csv
drag timeline.time 0.01 0.5 0.999 0.5
picture taken
drag morph.squeeze 0.05 0.5 1.2 0.5
picture held
click timeline.take
expect no error
drop @/other.glb
wait
expect layers wrinkles
drag layer.beta 0.4 0.5 0.7 0.5
drop @/sheet.glb
expect widget leave.save
click leave.cancel
key Ctrl+Z
click menu.File
click file.recent
click file.recent.1
wait
expect layers lines other
drop @/nothing.glb
expect message "nothing.glb: there is no such file"
)~");
  EXPECT_GT(VIEWS_DIFFER("rest", "taken"), 8.0);
  EXPECT_LT(VIEWS_DIFFER("held", "taken"), 2.0);
}

TEST_F(EditorTest, TheFirstStartOpensASample) {
  const fs::path cache = folder() / "cache", samples = cache / "furrow" / "samples-" FURROW_VERSION;
  fs::create_directories(samples);
  fs::copy_file(folder() / "sheet.glb", samples / "face.glb");
  ASSERT_EQ(setenv("XDG_CACHE_HOME", cache.c_str(), 1), 0);
  expectPlays("frames 2\npicture first_start\nclick first.face\nwait\nexpect layers wrinkles\n");
  unsetenv("XDG_CACHE_HOME");
  expectStored("first_start");
}

TEST_F(EditorTest, LayersAreDraggedIntoAnotherOrder) {
  expectPlays(sheet() + R"(
click layer.add
expect layers lines other wrinkles
drag layer.select.lines 0.5 0.5 0.5 2.5
expect layers other wrinkles lines
key Ctrl+Z
expect layers lines other wrinkles
drag layer.select.wrinkles 0.5 0.5 0.5 -0.6
expect layers lines wrinkles other
wait
expect no error
)");
}

TEST_F(EditorTest, UndoOfANameKeepsTheLayerSelected) {
  expectPlays(sheet() + R"(
click layer.select.other
click layer.name
key Ctrl+A
type brow
key Enter
expect layers lines brow
key Ctrl+Z
expect layers lines other
click layer.remove
expect layers lines
)");
}

TEST_F(EditorTest, NothingIsPaintedThroughTheUvLayout) {
  expectPlays(sheet() + R"(
key B
key 9
drag viewport 0.4 0.5 0.6 0.5
expect saved
key W
drag viewport 0.1 0.5 0.3 0.5
expect saved
drag viewport 0.55 0.5 0.65 0.5
expect dirty
)");
}

TEST_F(EditorTest, ImagesAreChosenForMapsMasksAndBias) {
  Image normals{64, 64, 3, {}}, heights{64, 64, 1, {}};
  for (uint32_t y = 0; y < 64; ++y)
    for (uint32_t x = 0; x < 64; ++x) {
      const float slope = 0.5f * std::sin(static_cast<float>(x) * 0.8f);
      normals.pixels.insert(normals.pixels.end(), {0.5f + 0.5f * slope, 0.5f, 0.95f});
      heights.pixels.push_back(0.5f + 0.5f * std::cos(static_cast<float>(x) * 0.8f));
    }
  pipeline::writeImage(folder() / "normals.png", normals);
  pipeline::writeImage(folder() / "heights.png", heights);
  expectPlays(sheet() + R"~(
click section.response
click section.direction
click layer.bias
click layer.bias.Image
type heights.png
key Enter
expect widget layer.bias_image
click layer.bias
click layer.bias.None
click layer.mask
click layer.mask.Image
type sheet.glb#creases
key Enter
wait
expect message "creases"
click layer.mask_image
type heights.png
key Enter
wait
click problems.clear
click section.reach
click compress.kind
click "compress.kind.Normal map"
type normals.png
key Enter
wait
click compress.green
click "compress.green.Down (DirectX)"
click compress.shading
type heights.png
key Enter
wait
expect no error
click section.compress
click section.stretch
click stretch.kind
click "stretch.kind.Height map"
type heights.png
key Enter
wait
drag morph.squeeze 0.05 0.5 0.95 0.5
picture authored
key Ctrl+S
expect saved
expect no error
)~");
  const std::string text = readText(folder() / "sheet.json");
  for (const char* part :
       {"\"normals.png\"", "\"mask\": { \"texture\": \"heights.png\"", "\"green\"", "\"height\""})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
  EXPECT_EQ(text.find("\"bias\""), std::string::npos) << text;
}

TEST_F(EditorTest, ADriversCurveIsDrawnByPoints) {
  const auto written = [&] {
    const std::string text = readText(folder() / "sheet.json");
    const size_t at = text.find("\"curve\"");
    return at == std::string::npos ? std::string() : text.substr(at, text.find('}', at) - at);
  };
  const auto playOn = [&](const std::string& script) {
    expectPlays(
        sheet() +
        "click section.response\nclick section.reach\nclick section.direction\nclick section.compress\n"
        "click section.stretch\nclick section.drivers\nwheel section.drivers -40\n" +
        script + "key Ctrl+S\nexpect saved\nexpect no error\n");
  };
  playOn(R"(
click drivers.add
click drivers.add.squeeze
click drivers.squeeze.bent
wheel section.drivers -40
click drivers.squeeze.curve 0.5 0.2
drag drivers.squeeze.curve 0.5 0.2 0.75 0.4
picture curve
)");
  const std::string three = written();
  EXPECT_NE(three.find("[[0.0, 0.0], [0.78, 0.0"), std::string::npos) << three;
  EXPECT_NE(three.find("], [1.0, 1.0]]"), std::string::npos) << three;
  playOn("key Ctrl+Z\n");  // nothing to undo: the same
  EXPECT_EQ(written(), three);
  playOn("drag drivers.squeeze.curve.1.out 0.5 0.5 0.75 0.5\n");
  EXPECT_NE(written().find("[[0.0, 0.5"), std::string::npos) << written();
  playOn("rightclick drivers.squeeze.curve 0.75 0.4\nkey Ctrl+Z\n");
  EXPECT_NE(written().find("[0.78, 0.0"), std::string::npos) << written();
  playOn("rightclick drivers.squeeze.curve 0.75 0.4\n");
  EXPECT_EQ(written().find("0.78"), std::string::npos) << written();
  playOn("click drivers.squeeze.bent\n");
  EXPECT_EQ(written(), "");
}

// Every key of a recipe can be edited.
TEST_F(EditorTest, ALayersMeshesAndMaterialsAreChosen) {
  write("pair.glb", editorPair());
  write("pair.json", kEditorRecipe);
  expectPlaysInFolder(R"(
open @/pair.glb
wait
click section.response
click layer.meshes
click layer.meshes.Coat
click layer.meshes.Face
click layer.meshes.Face
key Escape
click layer.materials
click layer.materials.cloth
key Escape
wait
key 5
click look.view
click look.view.Weight
key Ctrl+S
expect saved
expect no error
)");
  std::string text = readText(folder() / "pair.json");
  EXPECT_NE(text.find("\"meshes\": [\"Coat\"]"), std::string::npos) << text;
  EXPECT_NE(text.find("\"materials\": [\"cloth\"]"), std::string::npos) << text;
  expectPlaysInFolder(R"~(
open @/pair.glb
wait
click section.response
click layer.meshes
click "layer.meshes.(all)"
key Escape
key Ctrl+S
expect saved
expect no error
)~");
  text = readText(folder() / "pair.json");
  EXPECT_EQ(text.find("\"meshes\""), std::string::npos) << text;
}

TEST_F(EditorTest, MeshesAndMaterialsWithoutANameAreChosenByNumber) {
  write("pair.glb", editorPair(false));
  write("pair.json", kEditorRecipe);
  expectPlaysInFolder(R"(
open @/pair.glb
wait
click section.response
click layer.meshes
click "layer.meshes.mesh 1"
key Escape
click layer.materials
click "layer.materials.material 1"
key Escape
wait
key Ctrl+S
expect saved
expect no error
)");
  const std::string text = readText(folder() / "pair.json");
  EXPECT_NE(text.find("\"meshes\": [\"mesh 1\"]"), std::string::npos) << text;
  EXPECT_NE(text.find("\"materials\": [\"material 1\"]"), std::string::npos) << text;
}

TEST_F(EditorTest, RestPoseWeldAndSizesOfMapsAreChosen) {
  write("relaxed.obj", "v 0 0 0\n");
  expectPlaysInFolder(sheet() + R"(
click section.response
click section.reach
click section.direction
click section.compress
click section.stretch
click section.character
wheel layer.name -40
click rest
click "rest.Clip, as shown"
drag rest.time 0.05 0.5 0.5 0.5
wait
drag morph.squeeze 0.05 0.5 0.5 0.5
click rest
click "rest.Morph targets, as shown"
wait
drag weld 0.05 0.5 0.5 0.5
click map_size
click map_size.256
wheel map_size -40
click preview_size
click "preview_size.Left out"
wheel preview_size -40
click hidden
click hidden.Sheet
key Escape
wait
key Ctrl+S
expect saved
expect no error
click rest
click "rest.File ..."
type relaxed.obj
key Enter
wait
expect message "relaxed.obj"
)");
  const std::string text = readText(folder() / "sheet.json");
  for (const char* part : {"\"morphs\": { \"squeeze\": 0.", "\"tolerance\": 0.0", "\"mapSize\": 256",
                           "\"previewSize\": 0", "\"hidden\": [\"Sheet\"]"})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
}

TEST_F(EditorTest, AttributesLinesLightAndLimitReachTheRecipe) {
  expectPlays(sheet() + R"(
click section.response
click layer.bias
click layer.bias.Attribute
drag layer.bias_neutral 0.5 0.5 0.25 0.5
click layer.direction
click "layer.direction.Lines in the file"
click section.reach
click section.direction
wheel compress.preset -20
click compress.lit
drag compress.limit 0.95 0.5 0.5 0.5
key Ctrl+S
expect saved
)");
  const std::string text = readText(folder() / "sheet.json");
  for (const char* part : {"\"attribute\": \"COLOR_0\"", "\"neutral\": 0.2", "\"lines\": \"guides\"",
                           "\"light\": [", "\"limit\": 0.5"})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
}

TEST_F(EditorTest, TheBrushCanBeMovedByKeysAndTheLitSurfaceFollowsIt) {
  std::string right;
  for (int i = 0; i < 12; ++i) right += "key Right\n";
  expectPlays(sheet() + "click tool.tool.bias\nkey 1\npicture before\nkey C\nkey Up\nkey Space\n" + right +
              "picture during\nkey Space\nexpect dirty\nwait\nkey C\npicture after\n"
              "key Ctrl+S\nexpect saved\nexpect no error\n");
  EXPECT_TRUE(fs::exists(folder() / "sheet_lines_bias.png"));
  EXPECT_GT(VIEWS_DIFFER("before", "during"), 4.0);
  EXPECT_GT(VIEWS_DIFFER("before", "after"), 4.0);
}

TEST_F(EditorTest, WhatIsPaintedIsShownAsItWillBeCooked) {
  std::string there, back;
  for (int i = 0; i < 12; ++i) {
    there += "key Right\n";
    back += "key Left\n";
  }
  for (const std::string tool : {"mask", "comb"}) {
    expectPlays(sheet() + "click tool.tool." + tool + "\nkey C\nkey Up\n" + there +
                "picture before\nkey Space\n" + back + there +
                "picture during\nkey Space\nwait\npicture after\nexpect no error\n");
    const double painted = VIEWS_DIFFER("before", "during");
    EXPECT_GT(painted, tool == "mask" ? 15.0 : 4.0) << tool;
    EXPECT_LT(VIEWS_DIFFER("during", "after"), (tool == "mask" ? 0.3 : 0.9) * painted) << tool;
  }
}

TEST_F(EditorTest, AStrokeStaysOnItsLayerWhateverIsSelectedWhenItEnds) {
  expectPlays(sheet() + R"(
key B
key C
key Space
key Right
click layer.select.other
key Space
key Ctrl+S
expect saved
click layer.select.other
key Space
key Right
click layer.remove
key Space
expect layers lines
key G
key Space
key Right
key Right
key Right
click layer.add
key Space
expect no error
)");
  EXPECT_TRUE(fs::exists(folder() / "sheet_lines_bias.png"));
  EXPECT_FALSE(fs::exists(folder() / "sheet_other_bias.png"));
}

TEST_F(EditorTest, EveryScaleOfTheScreenWorks) {
  for (const char* scale : {"0.5", "2.5"}) {
    const Outcome outcome =
        run({folder() / "sheet.glb", "--script", write("script.txt", "wait\nclick tool.view.split\n"),
             "--size", "900x700", "--scale", scale, "--backend", "cpu"},
            FURROW_EDITOR);
    EXPECT_EQ(outcome.status, 0) << scale << ": " << outcome.err;
  }
}

TEST_F(EditorTest, EveryTierDrawsTheSame) {
  for (const char* tier : {"cpu", "gpu-raster", "gpu"}) {
    const std::string name = std::string("tier_") + tier;
    const Outcome outcome =
        play(sheet() + "drag morph.squeeze 0.05 0.5 0.9 0.5\nkey 2\npicture " + name + "\n", tier);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_LT(difference(view(name), view("tier_cpu"), kBlock).worst_block, 2.0);
  }
}

TEST_F(EditorTest, SavesATurntable) {
  const fs::path frames = output() / "turn";
  fs::create_directories(frames);
  expectPlays(sheet() + R"(
click section.pictures
click share.frames 0.3 0.5
key Ctrl+A
type 4
key Enter
click share.width 0.3 0.5
key Ctrl+A
type 64
key Enter
click menu.File
click file.turntable
click dialog.name 0.9 0.5
type )" + frames.string() +
              R"(
key Enter
wait
expect message "4 frames written"
)");
  EXPECT_TRUE(fs::exists(frames / "frame_0000.png"));
  EXPECT_TRUE(fs::exists(frames / "frame_0003.png"));
  EXPECT_FALSE(fs::exists(frames / "frame_0004.png"));
  const Image first = pipeline::readImage(frames / "frame_0000.png"),
              quarter = pipeline::readImage(frames / "frame_0001.png");
  EXPECT_EQ(first.width, 64u);
  EXPECT_GT(difference(first, quarter, kBlock).mean, 2.0);
}

// The clip draws the sheet together to 60% in 0.7 seconds, which no float is.
TEST_F(EditorTest, SavesTheFramesOfAClip) {
  const fs::path frames = output() / "clip";
  write("sheet.glb", editorSheet(0.7f));
  expectPlays(sheet() + R"(
drag timeline.time 0.01 0.5 0.3 0.5
picture before
click section.pictures
click share.fps 0.3 0.5
key Ctrl+A
type 10
key Enter
click share.width 0.3 0.5
key Ctrl+A
type 320
key Enter
click share.height 0.3 0.5
key Ctrl+A
type 240
key Enter
click menu.File
click file.clip
click dialog.name 0.9 0.5
key Ctrl+A
type )" + frames.string() +
              R"(
key Enter
wait
expect message "8 frames written"
picture after
)");
  EXPECT_FALSE(fs::exists(frames / "frame_0008.png"));
  const auto width = [&](const char* name) {
    const Image shown = pipeline::readImage(frames / name);
    EXPECT_EQ(shown.width, 320u);
    EXPECT_EQ(shown.height, 240u);
    uint32_t count = 0;
    for (uint32_t x = 0; x < shown.width; ++x) count += shown.at(x, 120)[0] > 0.25f;
    return static_cast<double>(count);
  };
  const double rest = width("frame_0000.png");
  EXPECT_GT(rest, 100.0);
  EXPECT_NEAR(width("frame_0003.png") / rest, 1.0 - 0.4 * 3.0 / 7.0, 0.02);
  EXPECT_NEAR(width("frame_0007.png") / rest, 0.6, 0.02);
  EXPECT_LT(VIEWS_DIFFER("before", "after"), 1.0);  // the clip stands where it stood
}

TEST_F(EditorTest, EscapeEmptiesTheSearchOfSliders) {
  const std::string searched = sheet() + R"(
key Ctrl+F
type other
key Enter
frames 2
expect widget region.other
)";
  EXPECT_EQ(play(searched + "expect widget morph.squeeze\n").status, 2);
  expectPlays(searched + "key Ctrl+F\nkey Escape\nframes 2\nexpect widget morph.squeeze\n");
}

TEST_F(EditorTest, TheKeyboardReachesTheFirstPanelAndTheListOfFiles) {
  expectPlays(R"(
key Down
key Down
key Down
key Space
expect widget dialog.name
)");
  write("another.glb", editorSheet());
  expectPlays(sheet() + R"(
key Ctrl+O
key Enter
key Up
key Up
key Up
key Space
key Space
wait
expect layers wrinkles
)");
}

TEST_F(EditorTest, WhatIsTypedIsTakenOverWhereAKeySaves) {
  expectPlays(sheet() + R"(
doubleclick layer.name 0.9 0.5
key Ctrl+A
type pleats
key Ctrl+S
expect layers pleats other
expect saved
doubleclick layer.name 0.9 0.5
key Ctrl+A
type folds
key Escape
expect layers pleats other
)");
  EXPECT_NE(readText(folder() / "sheet.json").find("\"pleats\""), std::string::npos);
}

TEST_F(EditorTest, ASavedPictureShowsBothSidesOfASplitView) {
  expectPlaysInFolder(sheet() + R"(
drag morph.squeeze 0.05 0.5 0.9 0.5
key Ctrl+P
click dialog.name 0.9 0.5
key Ctrl+A
type @/whole.png
key Enter
key W
key Ctrl+P
click dialog.name 0.9 0.5
key Ctrl+A
type @/split.png
key Enter
expect message "split.png: written"
key 9
key Ctrl+P
key Enter
expect no error
)");
  const Image whole = pipeline::readImage(folder() / "whole.png"),
              split = pipeline::readImage(folder() / "split.png");
  ASSERT_EQ(split.width, whole.width);
  // Left with wrinkles as before, right without.
  double left = 0.0, right = 0.0;
  for (uint32_t y = 0; y < whole.height; ++y)
    for (uint32_t x = 0; x < whole.width; ++x)
      (x < whole.width / 2 ? left : right) +=
          double{std::abs(whole.at(x, y)[0] - split.at(x, y)[0])} / (whole.width * whole.height);
  EXPECT_LT(left, 1e-6);
  EXPECT_GT(right, 1e-3);
  EXPECT_FALSE(fs::exists(folder() / "sheet.png"));  // what the UV layout would have written
}

TEST_F(EditorTest, RefusesWhatItCannotDoInOneLine) {
  const auto refused = [&](const Outcome& outcome, int status, const std::string& named) {
    EXPECT_EQ(outcome.status, status) << outcome.err;
    EXPECT_TRUE(outcome.err.starts_with("furrow-editor: ")) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_NE(outcome.err.find(named), std::string::npos) << outcome.err;
  };
  refused(run({"missing.glb"}, FURROW_EDITOR), 1, "missing.glb: there is no such file");
  refused(run({"--nonsense"}, FURROW_EDITOR), 2, "--help");
  refused(run({"--script", write("script.txt", "frames 1\n"), "--size", "320x240"}, FURROW_EDITOR), 2,
          "--size 320x240: is not WIDTHxHEIGHT from 640x480");
  refused(play("click nowhere\n"), 2, "line 1: there is no widget \"nowhere\"");
  refused(play("jump\n"), 2, "there is no command \"jump\"");
  refused(play(sheet() + "expect dirty\n"), 2, "expected dirty");
  refused(play("open none.glb\nexpect no error\n"), 2, "none.glb: there is no such file");
  EXPECT_EQ(run({"--version"}, FURROW_EDITOR).status, 0);
  EXPECT_EQ(run({"--help"}, FURROW_EDITOR).status, 0);
}

// The session of docs/editor_guide.md on the demo face, also a stop of `make demo`.
TEST_F(EditorTest, TheGuidesPicturesAreWhatTheEditorShows) {
  const fs::path face = folder() / "face.glb";
  fs::copy_file(fs::path(FURROW_CONTENT) / "face.glb", face);
  std::string recipe = readText(fs::path(FURROW_CONTENT) / "face.json");
  recipe.insert(recipe.find('{') + 1, "\"mapSize\": 512,");
  write("face.json", recipe);
  const Outcome outcome = run({face, "--script", kSource / "content/editor_session.txt", "--frames", output(),
                               "--size", "1200x752", "--backend", "cpu"},
                              FURROW_EDITOR);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  for (const char* name : {"editor_open", "editor_play", "editor_paint", "editor_split", "editor_uv"})
    expectStored(name, "docs/images");
}

}  // namespace
}  // namespace furrow::test
