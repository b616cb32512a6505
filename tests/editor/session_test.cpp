// What the editor does without a screen: edits with undo, the background cook, files that change on disk,
// painting, playing, settings.

#include "editor/session/session.h"

#include <gmock/gmock.h>

#include <chrono>
#include <cmath>
#include <thread>

#include "editor/preview/headless_context.h"
#include "editor/session/paint.h"
#include "editor/session/samples.h"
#include "editor/session/settings.h"
#include "editor/ui/headless_screen.h"
#include "editor/ui/input_queue.h"
#include "editor/ui/script.h"
#include "editor/ui/uv_view.h"
#include "editor/ui/viewport.h"
#include "editor/ui/widgets.h"
#include "furrow/jobs.h"
#include "pipeline/error.h"
#include "tests/editor/editor_models.h"

namespace furrow::test {
namespace {

using namespace furrow::editor;
namespace fs = std::filesystem;

class SessionTest : public testing::Test {
 protected:
  fs::path write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_.path() / name, std::ios::binary) << bytes;
    return folder_.path() / name;
  }
  fs::path folder() const { return folder_.path(); }
  static std::string bytesOf(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  // Until nothing is cooking, files have been looked at again and what they led to is done.
  static void settle(Session& session) {
    for (int round = 0; round < 3; ++round) {
      session.update(1.0);
      while (session.cooking()) {
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        session.update(0.0);
      }
    }
  }

  static bool told(const Session& session, const std::string& part) {
    for (const Message& message : session.messages())
      if (message.text.find(part) != std::string::npos) return true;
    return false;
  }

  static void edit(Session& session, const std::string& what,
                   const std::function<void(pipeline::Recipe&)>& change) {
    Content content = session.document.content();
    change(content.recipe);
    session.document.apply(std::move(content), what);
  }

 private:
  ScratchFolder folder_;
};

TEST(DocumentTest, UndoAndRedoGoThroughEveryEditAndKnowWhatIsSaved) {
  Document document({pipeline::defaultRecipe(), {}}, "/nowhere/r.json", true);
  EXPECT_FALSE(document.dirty());
  const auto setBeta = [&](float beta, const char* what) {
    Content next = document.content();
    next.recipe.layers[0].response.beta = beta;
    document.apply(std::move(next), what);
  };
  const auto beta = [&] { return document.recipe().layers[0].response.beta; };
  setBeta(5.0f, "beta");
  setBeta(6.0f, "beta");  // the same drag
  document.endGesture();
  setBeta(7.0f, "beta");
  document.endGesture();
  setBeta(7.0f, "beta");  // no change, no step
  EXPECT_TRUE(document.dirty());
  EXPECT_EQ(document.undoName(), "beta");
  document.undo();
  EXPECT_EQ(beta(), 6.0f);
  document.undo();
  EXPECT_EQ(beta(), 4.0f);
  EXPECT_FALSE(document.dirty());  // as it was saved
  EXPECT_EQ(document.undoName(), "");
  document.undo();
  EXPECT_EQ(document.redoName(), "beta");
  document.redo();
  EXPECT_EQ(beta(), 6.0f);
  setBeta(9.0f, "other");  // what could be made again is gone
  EXPECT_EQ(document.redoName(), "");
  document.undo();
  EXPECT_EQ(beta(), 6.0f);
}

// 200 strokes on a large image fit in memory.
TEST(DocumentTest, UndoOfPaintingGoesBackToTheVeryPixelsAndKeepsOnlyWhatChanged) {
  constexpr uint32_t kSide = 200, kStrokes = 40;  // not a multiple of the tiles
  const fs::path file = "/nowhere/r_bias.png";
  std::vector<std::vector<uint8_t>> states;
  Document document({pipeline::defaultRecipe(), {}}, "/nowhere/r.json", true);
  auto image = std::make_shared<pipeline::ByteImage>(
      pipeline::ByteImage{kSide, kSide, 2, std::vector<uint8_t>(2 * kSide * kSide, 128)});
  for (uint32_t i = 0; i <= kStrokes; ++i) {
    if (i > 0) {
      image = std::make_shared<pipeline::ByteImage>(*image);
      for (uint32_t y = 0; y < 20; ++y)
        for (uint32_t x = 0; x < 40; ++x)
          image->pixels[2 * ((37 * i + y) % kSide * kSide + (53 * i) % (kSide - 20)) + x] =
              static_cast<uint8_t>(i + x);
    }
    Content next = document.content();
    next.images[file] = image;
    document.apply(std::move(next), "Paint bias");
    document.endGesture();
    states.push_back(image->pixels);
  }
  // A stroke of 20 x 20 texels touches at most 4 tiles of 64 x 64.
  EXPECT_LE(document.historyBytes(), size_t{kStrokes} * 4 * 64 * 64 * 2);
  EXPECT_LT(document.historyBytes(), size_t{kStrokes} * image->pixels.size() / 3);
  const auto pixels = [&] { return document.content().images.at(file)->pixels; };
  for (uint32_t i = kStrokes; i-- > 0;) {
    document.undo();
    ASSERT_EQ(pixels(), states[i]) << i;
  }
  document.undo();
  EXPECT_TRUE(document.content().images.empty());
  EXPECT_FALSE(document.dirty());
  for (uint32_t i = 0; i <= kStrokes; ++i) {
    document.redo();
    ASSERT_EQ(pixels(), states[i]) << i;
  }
  // An image of another size comes back whole.
  Content next = document.content();
  next.images[file] = std::make_shared<pipeline::ByteImage>(pipeline::ByteImage{1, 1, 1, {7}});
  document.apply(std::move(next), "Paint bias");
  document.undo();
  EXPECT_EQ(pixels(), states.back());
  document.redo();
  EXPECT_EQ(pixels(), std::vector<uint8_t>{7});
}

TEST(DocumentTest, TheHistoryHasAnEnd) {
  Document document({pipeline::defaultRecipe(), {}}, "/nowhere/r.json", true);
  const auto steps = [&] {
    size_t count = 0;
    for (; !document.undoName().empty(); ++count) document.undo();
    return count;
  };
  for (int i = 0; i < 500; ++i) {
    Content next = document.content();
    next.recipe.layers[0].response.beta = 1.0f + static_cast<float>(i % 100) / 10.0f;
    if (i % 3 == 0)
      document.reloaded(std::move(next));
    else
      document.apply(std::move(next), "beta");
    document.endGesture();
  }
  EXPECT_LE(steps(), 200u);
}

TEST_F(SessionTest, SavingWritesRecipeAndImagesThatReadBackAsTheSame) {
  Content content{pipeline::defaultRecipe(), {}};
  const fs::path file = folder() / "r.json", image = folder() / "r_wrinkles_bias.png";
  content.images[image] =
      std::make_shared<pipeline::ByteImage>(pipeline::ByteImage{8, 8, 1, std::vector<uint8_t>(64, 200)});
  content.recipe.layers[0].bias = pipeline::Bias{{}, 0, 0.5, image};
  Document document(content, file, false);
  EXPECT_TRUE(document.dirty());
  document.save(file);
  EXPECT_FALSE(document.dirty());
  const pipeline::Recipe read = pipeline::readRecipe(file);
  EXPECT_EQ(pipeline::recipeText(read, file), pipeline::recipeText(document.recipe(), file));
  EXPECT_EQ(pipeline::readByteImage(image).pixels, content.images[image]->pixels);
  EXPECT_NE(pipeline::recipeText(read, file).find("\"r_wrinkles_bias.png\""), std::string::npos);

  // Where the folder is not there nothing is lost.
  document.undo();
  EXPECT_THROW(document.save(folder() / "none" / "r.json"), pipeline::Error);
  EXPECT_EQ(document.file(), file);
}

TEST_F(SessionTest, OpensASourceWithItsRecipeAndCooksInTheBackground) {
  const fs::path source = write("sheet.glb", editorSheet());
  write("sheet.json", kEditorRecipe);
  Session session;
  session.open(source);
  EXPECT_TRUE(session.cooking());
  settle(session);
  ASSERT_TRUE(session.shown()) << session.error();
  EXPECT_EQ(session.shown()->view().layerCount(), 2u);
  EXPECT_EQ(session.shown()->view().layers[0].name, "lines");
  EXPECT_TRUE(session.editable());
  EXPECT_FALSE(session.document.dirty());
  EXPECT_EQ(session.player.clip, "go");
  // The last cook is the whole one: what `furrow cook` would give.
  EXPECT_EQ(session.report().textures.empty(), false);

  Session by_recipe;
  by_recipe.open(folder() / "sheet.json");
  EXPECT_EQ(by_recipe.source(), source);

  const fs::path asset = folder() / "out.furrow";
  session.cookTo(asset);
  settle(session);
  EXPECT_TRUE(told(session, "out.furrow: cooked"));
  Session look;
  look.open(asset);
  settle(look);
  ASSERT_TRUE(look.shown());
  EXPECT_FALSE(look.editable());
  EXPECT_EQ(look.shown()->view().layerCount(), 2u);
}

TEST_F(SessionTest, AFaultIsToldAndLeavesTheLastGoodStateUp) {
  const fs::path source = write("sheet.glb", editorSheet());
  write("sheet.json", kEditorRecipe);
  Session session;
  session.open(folder() / "missing.glb");
  EXPECT_TRUE(told(session, "there is no such file"));
  EXPECT_TRUE(session.source().empty());
  session.open(source);
  settle(session);
  const auto good = session.shown();
  ASSERT_TRUE(good);

  edit(session, "bad", [](pipeline::Recipe& recipe) { recipe.layers[0].meshes = {"Nowhere"}; });
  settle(session);
  EXPECT_NE(session.error().find("Nowhere"), std::string::npos);
  EXPECT_EQ(session.shown(), good);
  session.document.undo();
  settle(session);
  EXPECT_EQ(session.error(), "");
  EXPECT_TRUE(session.shown());
}

TEST_F(SessionTest, WarningsOfACookAreToldOnceAlsoBehindADraft) {
  GltfBuilder still;  // a triangle that nothing moves
  still.add(std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3", 3);
  const fs::path source =
      write("still.glb", still.glb(R"("scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
                                   R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}])"));
  Session session;
  session.open(source);  // with the default recipe, which is drafted
  settle(session);
  const auto warnings = [&] {
    return std::count_if(session.messages().begin(), session.messages().end(),
                         [](const Message& m) { return m.kind == Message::Kind::kWarning; });
  };
  const auto first = warnings();
  EXPECT_GT(first, 0);
  edit(session, "seed", [](pipeline::Recipe& recipe) { recipe.layers[0].measure = Measure::kArea; });
  settle(session);
  EXPECT_EQ(warnings(), first);
}

TEST_F(SessionTest, ErrorsAreSeenHoweverManyMessagesThereWere) {
  Session session;
  for (int i = 0; i < 700; ++i) session.tell(Message::Kind::kNote, "note");
  const uint64_t before = session.told();
  EXPECT_FALSE(session.toldErrorSince(0));
  session.tell(Message::Kind::kError, "error");
  EXPECT_TRUE(session.toldErrorSince(before));
  EXPECT_FALSE(session.toldErrorSince(session.told()));
  session.clearMessages();
  EXPECT_FALSE(session.toldErrorSince(before));
  EXPECT_LE(session.messages().size(), 500u);
}

TEST_F(SessionTest, ACookDoesNotOverwriteWhatItReads) {
  const fs::path source = write("sheet.glb", editorSheet()), mask = folder() / "mask.png";
  pipeline::Image half{8, 8, 1, std::vector<float>(64, 1.0f)};
  half.pixels[0] = 0.0f;
  pipeline::writeImage(mask, half);
  write("sheet.json",
        R"({"mapSize": 64, "layers": [{"name": "lines", "mask": {"texture": "mask.png", "channel": "r"}}]})");
  Session session;
  session.open(source);
  settle(session);
  ASSERT_EQ(session.error(), "");
  fs::create_symlink(mask, folder() / "link.furrow");
  for (const char* name : {"sheet.glb", "sheet.json", "mask.png", "link.furrow"}) {
    session.clearMessages();
    session.cookTo(folder() / name);
    settle(session);
    EXPECT_TRUE(told(session, "would overwrite an input")) << name;
  }
  EXPECT_EQ(pipeline::readByteImage(mask).width, 8u);
}

TEST_F(SessionTest, LambdaAndBetaNeedNoCook) {
  const fs::path source = write("sheet.glb", editorSheet());
  write("sheet.json", kEditorRecipe);
  Session session;
  session.open(source);
  settle(session);
  const auto before = session.shown();
  edit(session, "beta", [](pipeline::Recipe& recipe) { recipe.layers[0].response.beta = 9.0f; });
  settle(session);
  EXPECT_EQ(session.shown(), before);
  EXPECT_EQ(session.responses(*before)[0].beta, 9.0f);
  edit(session, "spacing", [](pipeline::Recipe& recipe) { recipe.map_size = 64; });
  settle(session);
  EXPECT_NE(session.shown(), before);
}

TEST_F(SessionTest, WhatChangesOnDiskIsSeen) {
  const fs::path source = write("sheet.glb", editorSheet());
  const fs::path recipe = write("sheet.json", kEditorRecipe);
  Session session;
  session.open(source);
  settle(session);
  std::string one = kEditorRecipe;
  one = one.substr(0, one.find(",\n    { \"name\": \"other\"")) + "] }";
  write("sheet.json", one);
  settle(session);
  EXPECT_EQ(session.document.recipe().layers.size(), 1u);
  EXPECT_EQ(session.shown()->view().layerCount(), 1u);
  EXPECT_FALSE(session.document.dirty());

  // A recipe that cannot be read is told; what was there stays.
  write("sheet.json", "{ \"layers\": [ ");
  settle(session);
  EXPECT_NE(session.error(), "");
  EXPECT_EQ(session.shown()->view().layerCount(), 1u);
  write("sheet.json", kEditorRecipe);
  settle(session);
  EXPECT_EQ(session.error(), "");
  EXPECT_EQ(session.shown()->view().layerCount(), 2u);

  // With edits that are not saved, it is asked.
  edit(session, "beta", [](pipeline::Recipe& r) { r.layers[0].response.beta = 9.0f; });
  write("sheet.json", one);
  settle(session);
  EXPECT_TRUE(session.conflict());
  EXPECT_EQ(session.document.recipe().layers.size(), 2u);
  session.reload();
  settle(session);
  EXPECT_EQ(session.document.recipe().layers.size(), 1u);
  session.document.undo();
  EXPECT_EQ(session.document.recipe().layers[0].response.beta, 9.0f);

  // The mesh too.
  const auto before = session.shown();
  fs::last_write_time(source, fs::last_write_time(source) + std::chrono::seconds(2));
  settle(session);
  EXPECT_NE(session.shown(), before);
}

// A mesh whose buffer is a file beside it.
TEST_F(SessionTest, WhatChangesWhileItIsCookedIsCookedAgain) {
  const auto buffer = [](float height) {
    GltfBuilder sheet;
    sheet.add(std::vector<float>{0, 0, 0, 1, 0, 0, 0, height, 0}, "VEC3", 3);
    return sheet;
  };
  const fs::path source =
      write("sheet.gltf", buffer(1.0f).json(R"("scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
                                            R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}])",
                                            "sheet.bin"));
  Session session;
  session.open(source);
  settle(session);
  EXPECT_NE(session.error().find("sheet.bin"), std::string::npos) << session.error();
  const auto height = [](const Session& of) {
    float most = 0.0f;
    for (const Float3& p : of.shown()->view().positions) most = std::max(most, p.y);
    return most;
  };
  write("sheet.bin", buffer(1.0f).bin());
  settle(session);
  ASSERT_TRUE(session.shown()) << session.error();
  EXPECT_NEAR(height(session), 1.0f, 1e-3f);
  EXPECT_EQ(session.error(), "");

  Session late;
  late.open(source);
  while (!late.cooked()) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  write("sheet.bin", buffer(2.0f).bin());  // its frames stood still meanwhile
  fs::last_write_time(folder() / "sheet.bin", fs::file_time_type::clock::now() + std::chrono::seconds(5));
  settle(late);
  ASSERT_TRUE(late.shown()) << late.error();
  EXPECT_NEAR(height(late), 2.0f, 1e-3f);
}

TEST_F(SessionTest, ARecipeThatIsMistypedOnDiskStaysAFaultAndIsNotReplacedUnasked) {
  write("sheet.glb", editorSheet());
  const fs::path recipe = write("sheet.json", kEditorRecipe);
  Session session;
  session.open(folder() / "sheet.glb");
  settle(session);
  ASSERT_EQ(session.error(), "");
  write("sheet.json", R"({"layers": [{"nam": "lines"}]})");
  write("sheet.glb", editorSheet() + " ");  // it is cooked again, without a fault of its own
  fs::last_write_time(folder() / "sheet.glb", fs::file_time_type::clock::now() + std::chrono::seconds(5));
  settle(session);
  EXPECT_NE(session.error().find("did you mean"), std::string::npos) << session.error();
  session.save(recipe);
  EXPECT_TRUE(session.conflict());
  EXPECT_NE(bytesOf(recipe).find("\"nam\""), std::string::npos);
  session.keep();
  session.save(recipe);
  EXPECT_FALSE(session.conflict());
  EXPECT_EQ(session.error(), "");
  EXPECT_EQ(pipeline::readRecipe(recipe).layers.size(), 2u);
  write("sheet.json", R"({"layers": [{"nam": "lines"}]})");
  settle(session);
  EXPECT_NE(session.error(), "");
  write("sheet.json", std::string(kEditorRecipe) + "  ");
  settle(session);
  EXPECT_EQ(session.error(), "");
}

TEST_F(SessionTest, APaintedImageThatChangesOnDiskIsAskedAboutWhileThereAreEdits) {
  const fs::path source = write("sheet.glb", editorSheet()), image = folder() / "sheet_lines_bias.png";
  write("sheet.json", kEditorRecipe);
  const auto filled = [](float value) { return pipeline::Image{8, 8, 1, std::vector<float>(64, value)}; };
  Session session;
  session.open(source);
  settle(session);
  edit(session, "Paint bias", [&](pipeline::Recipe& recipe) {
    recipe.layers[0].bias = pipeline::Bias{{}, 0, 0.5, image};
  });
  Content content = session.document.content();
  content.images[image] = std::make_shared<pipeline::ByteImage>(pipeline::toBytes(filled(1.0f)));
  session.document.apply(std::move(content), "Paint bias");
  session.save(session.document.file());
  settle(session);
  const auto others = [&] {
    edit(session, "beta", [](pipeline::Recipe& recipe) { recipe.layers[0].response.beta += 1.0f; });
    pipeline::writeImage(image, filled(0.2f));
    fs::last_write_time(image, fs::file_time_type::clock::now() + std::chrono::seconds(5));
    settle(session);
    EXPECT_TRUE(session.conflict());
  };
  others();
  session.keep();
  session.save(session.document.file());
  EXPECT_EQ(pipeline::readByteImage(image).pixels[0], 255);
  settle(session);
  others();
  session.reload();
  EXPECT_FALSE(session.document.dirty());
  EXPECT_TRUE(session.document.content().images.empty());
  EXPECT_EQ(pipeline::readByteImage(image).pixels[0], 51);
}

// A session with a sheet of which a bias was painted and saved.
class PaintedFile : public SessionTest {
 protected:
  static pipeline::Image filled(float value) { return {8, 8, 1, std::vector<float>(64, value)}; }
  void SetUp() override {
    write("sheet.json", kEditorRecipe);
    image_ = folder() / "sheet_lines_bias.png";
    session_.open(write("sheet.glb", editorSheet()));
    settle(session_);
    Content content = session_.document.content();
    content.recipe.layers[0].bias = pipeline::Bias{{}, 0, 0.5, image_};
    content.images[image_] = std::make_shared<pipeline::ByteImage>(pipeline::toBytes(filled(1.0f)));
    session_.document.apply(std::move(content), "Paint bias");
    session_.save(session_.document.file());
    settle(session_);
  }

  fs::path image_;
  Session session_;
};

TEST_F(PaintedFile, WhatUndoBringsBackAfterAChangeOnDiskIsSaved) {
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  pipeline::writeImage(image_, filled(0.2f));
  settle(session_);
  ASSERT_TRUE(session_.document.content().images.empty());
  session_.document.undo();
  session_.save(session_.document.file());
  EXPECT_EQ(pipeline::readByteImage(image_).pixels[0], 255);
}

TEST_F(PaintedFile, FilesThatAreRemovedAreToldAndWrittenAgainWithTheNextSave) {
  fs::remove(image_);
  fs::remove(session_.document.file());
  settle(session_);
  EXPECT_EQ(session_.error(), "");
  EXPECT_TRUE(told(session_, "sheet_lines_bias.png: it was removed"));
  EXPECT_TRUE(told(session_, "sheet.json: it was removed"));
  session_.save(session_.document.file());
  EXPECT_EQ(pipeline::readByteImage(image_).pixels[0], 255);
  EXPECT_EQ(pipeline::readRecipe(session_.document.file()).layers[0].bias->texture, image_);
}

TEST_F(PaintedFile, ImagesThatNoLayerNamesAreNotWritten) {
  fs::remove(image_);
  settle(session_);
  edit(session_, "Rest bias", [](pipeline::Recipe& recipe) { recipe.layers[0].bias.reset(); });
  session_.save(session_.document.file());
  EXPECT_FALSE(fs::exists(image_));
  session_.document.undo();
  session_.save(session_.document.file());
  EXPECT_TRUE(fs::exists(image_));
}

// Another program writes a file piece by piece.
TEST_F(SessionTest, HalfAFileIsNoFaultWhileMoreOfItComes) {
  const std::string mesh = editorSheet(), recipe = kEditorRecipe;
  Session session;
  write("sheet.json", recipe);
  session.open(write("sheet.glb", mesh));
  settle(session);
  const auto soon = [&] {
    session.update(0.1);
    while (session.cooking()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      session.update(0.0);
    }
  };
  const uint64_t before = session.told();
  for (const std::string name : {"sheet.glb", "sheet.json"}) {
    const std::string& whole = name == "sheet.glb" ? mesh : recipe;
    for (const size_t part : {3, 2}) {
      write(name, whole.substr(0, whole.size() / part));
      soon();
      soon();
    }
    write(name, whole);
    soon();
    soon();
    EXPECT_FALSE(session.toldErrorSince(before)) << session.messages().back().text;
  }
  settle(session);
  EXPECT_EQ(session.error(), "");
  write("sheet.glb", mesh.substr(0, mesh.size() / 2));
  settle(session);
  EXPECT_NE(session.error(), "");
}

TEST_F(SessionTest, OwnSavesAreNoChange) {
  const fs::path source = write("sheet.glb", editorSheet());
  write("sheet.json", kEditorRecipe);
  Session session;
  session.open(source);
  settle(session);
  edit(session, "beta", [](pipeline::Recipe& r) { r.layers[0].response.beta = 9.0f; });
  session.save(session.document.file());
  const auto before = session.shown();
  const uint64_t revision = session.document.revision();
  settle(session);
  EXPECT_EQ(session.shown(), before);
  EXPECT_EQ(session.document.revision(), revision);
  EXPECT_FALSE(session.document.dirty());
  EXPECT_EQ(pipeline::readRecipe(session.document.file()).layers[0].response.beta, 9.0f);
}

// Names that come to the same, a layer that was renamed, one that was copied: no image is painted over
// another's.
TEST(PaintTest, EveryLayerPaintsIntoAFileOfItsOwn) {
  Content content{pipeline::defaultRecipe(), {}};
  auto& layers = content.recipe.layers;
  layers.resize(2, layers[0]);
  layers[0].name = "brow left";
  layers[1].name = "brow_left";
  const auto file = [&](size_t layer) { return paintedFile(content, "/a/r.json", layer, Painted::kMask); };
  const fs::path first = file(0), other = "/a/r_brow_left_mask_2.png";
  EXPECT_EQ(first, "/a/r_brow_left_mask.png");
  EXPECT_EQ(file(1), first);
  layers[0].mask = pipeline::MaskTexture{first, 0};
  content.images[first] = std::make_shared<pipeline::ByteImage>();
  EXPECT_EQ(file(1), other);
  layers[0].name = "renamed";
  EXPECT_EQ(file(0), first);
  layers[1].mask = layers[0].mask;  // a copy
  EXPECT_EQ(file(0), "/a/r_renamed_mask.png");
  EXPECT_EQ(file(1), other);
  // An image of the artist's own is not written to.
  layers[1].mask = pipeline::MaskTexture{"/a/own.png", 0};
  EXPECT_EQ(file(1), other);
}

TEST(PaintTest, TheBrushFadesFromItsEdgeInwards) {
  Brush brush;
  brush.falloff = 0.5f;
  EXPECT_EQ(brushCover(brush, 0.0f), 1.0f);
  EXPECT_EQ(brushCover(brush, 0.5f), 1.0f);
  EXPECT_FLOAT_EQ(brushCover(brush, 0.75f), 0.5f);
  EXPECT_EQ(brushCover(brush, 1.0f), 0.0f);
  brush.falloff = 0.0f;
  EXPECT_EQ(brushCover(brush, 0.999f), 1.0f);
}

class PaintedSheet : public SessionTest {
 protected:
  void SetUp() override {
    write("sheet.json", kEditorRecipe);
    session_.open(write("sheet.glb", editorSheet()));
    settle(session_);
    ASSERT_TRUE(session_.shown()) << session_.error();
    canvas_ = std::make_shared<Canvas>(asset(), session_.document.recipe().layers[0], 64);
    brush_.falloff = 0.0f;
    brush_.strength = 1.0f;
    brush_.size = 0.1f / diagonalOf(asset());  // a radius of 0.1
  }
  const AssetView& asset() const { return session_.shown()->view(); }
  std::shared_ptr<const pipeline::ByteImage> current(Painted kind) const {
    return std::make_shared<pipeline::ByteImage>(canvas_->current(kind, asset(), 0));
  }
  // The texel at a place of the sheet.
  static const uint8_t* at(const pipeline::ByteImage& image, float x, float y) {
    return image.at(static_cast<uint32_t>((x + 0.5f) * 64), static_cast<uint32_t>((0.5f - y) * 64));
  }

  Session session_;
  std::shared_ptr<const Canvas> canvas_;
  Brush brush_;
};

TEST_F(PaintedSheet, AStrokeCoversWhatIsWithinItsRadiusOnceAndOnBothSidesOfTheMirror) {
  brush_.mirror = true;
  brush_.bias = -1.0f;
  brush_.strength = 0.5f;
  Stroke stroke(canvas_, current(Painted::kBias), Painted::kBias, brush_, diagonalOf(asset()));
  for (int turn = 0; turn < 3; ++turn)  // over the same place again and again
    for (float y : {-0.2f, 0.2f}) stroke.moveTo({0.25f, y, 0.0f}, {0, 0, 1});
  ASSERT_TRUE(stroke.touched());
  const pipeline::ByteImage image = stroke.image();
  for (float side : {-1.0f, 1.0f}) {
    EXPECT_NEAR(*at(image, side * 0.25f, 0.0f), 64, 1);   // half way from 128 to 0
    EXPECT_NEAR(*at(image, side * 0.25f, 0.27f), 64, 1);  // round ends
    EXPECT_EQ(*at(image, side * 0.25f, 0.34f), 128);
    EXPECT_EQ(*at(image, side * 0.38f, 0.0f), 128);
  }
  EXPECT_EQ(*at(image, 0.0f, 0.0f), 128);
  const std::vector<float> values = vertexBias(stroke.image(), *canvas_, asset());
  for (uint32_t v = 0; v < asset().vertexCount(); ++v) {
    const Float3 p = asset().positions[v];
    if (std::abs(std::abs(p.x) - 0.25f) < 0.05f && std::abs(p.y) < 0.2f) {
      EXPECT_NEAR(values[v], -0.5f, 0.01f);
    }
    if (std::abs(p.x) < 0.1f) {
      EXPECT_EQ(values[v], 0.0f);
    }
  }
}

TEST_F(PaintedSheet, StrokesAreMirroredAtThePlaneThatIsChosen) {
  brush_.mirror = true;
  brush_.mirror_axis = 1;
  Stroke stroke(canvas_, current(Painted::kBias), Painted::kBias, brush_, diagonalOf(asset()));
  stroke.moveTo({0.25f, 0.3f, 0.0f}, {0, 0, 1});
  const pipeline::ByteImage image = stroke.image();
  EXPECT_GT(*at(image, 0.25f, 0.3f), 200);
  EXPECT_EQ(*at(image, 0.25f, -0.3f), *at(image, 0.25f, 0.3f));
  EXPECT_EQ(*at(image, -0.25f, 0.3f), 128);
  EXPECT_EQ(*at(image, -0.25f, -0.3f), 128);
}

TEST_F(PaintedSheet, TheBrushDoesNotReachTheOtherSide) {
  Stroke stroke(canvas_, current(Painted::kBias), Painted::kBias, brush_, diagonalOf(asset()));
  stroke.moveTo({0.0f, 0.0f, 0.0f}, {0, 0, -1});
  EXPECT_FALSE(stroke.touched());
}

TEST_F(PaintedSheet, CombingAlongACreaseGivesTheDirectionAcrossIt) {
  Stroke stroke(canvas_, current(Painted::kDirection), Painted::kDirection, brush_, diagonalOf(asset()));
  stroke.moveTo({-0.3f, -0.3f, 0.0f}, {0, 0, 1});
  stroke.moveTo({0.3f, 0.3f, 0.0f}, {0, 0, 1});  // creases rise to the right
  const pipeline::ByteImage image = stroke.image();
  const uint8_t* texel = at(image, 0.0f, 0.0f);
  const float x = texel[0] / 127.5f - 1.0f, y = texel[1] / 127.5f - 1.0f;
  EXPECT_NEAR(x * y, -0.5f, 0.05f);  // across: down to the right, or up to the left
  EXPECT_NEAR(std::hypot(x, y), 1.0f, 0.02f);

  // As it is shown until the cook has read it, and then: the same direction on the surface.
  const std::vector<glm::vec4> shown = stroke.vertexDirections(asset(), 0, {});
  const std::vector<Float3> places(asset().positions.begin(), asset().positions.end());
  const auto onTheStroke = [&](const Float3& p) {
    return std::abs(p.x - p.y) < 0.03f && std::abs(p.x) < 0.2f;
  };
  for (size_t v = 0; v < shown.size(); ++v) {
    if (onTheStroke(places[v])) {
      EXPECT_NEAR(shown[v].x * shown[v].y, -0.5f, 0.05f);
      EXPECT_EQ(shown[v].w, 1.0f);
    }
    if (places[v].x - places[v].y > 0.5f) {
      EXPECT_EQ(shown[v].w, 0.0f);
    }
  }
  Content content = session_.document.content();
  const fs::path file =
      paintedFile(session_.document.content(), session_.document.file(), 0, Painted::kDirection);
  content.images[file] = std::make_shared<pipeline::ByteImage>(image);
  content.recipe.layers[0].direction = pipeline::DirectionTexture{file};
  session_.document.apply(std::move(content), "comb");
  settle(session_);
  ASSERT_EQ(session_.error(), "");
  for (uint32_t p = 0; p < asset().pointCount(); ++p) {
    const Float3 at_rest = asset().positions[asset().point_vertex[p]];
    const int8_t* d = &asset().layers[0].directions[4 * size_t{p}];
    if (onTheStroke(at_rest)) {
      EXPECT_NEAR(d[0] * d[1] / (127.0f * 127.0f), -0.5f, 0.06f);
    }
  }
}

TEST_F(PaintedSheet, PaintedBiasIsWhatTheCookReads) {
  Stroke stroke(canvas_, current(Painted::kBias), Painted::kBias, brush_, diagonalOf(asset()));
  stroke.moveTo({0.2f, 0.1f, 0.0f}, {0, 0, 1});
  Content content = session_.document.content();
  const fs::path file = paintedFile(session_.document.content(), session_.document.file(), 0, Painted::kBias);
  content.images[file] = std::make_shared<pipeline::ByteImage>(stroke.image());
  content.recipe.layers[0].bias = pipeline::Bias{{}, 0, 0.5, file};
  session_.document.apply(std::move(content), "paint");
  settle(session_);
  ASSERT_EQ(session_.error(), "");
  const std::vector<float> painted = vertexBias(stroke.image(), *canvas_, asset());
  const std::span<const int16_t> cooked = asset().layers[0].bias;
  ASSERT_EQ(cooked.size(), painted.size());
  float largest = 0.0f;
  for (size_t v = 0; v < painted.size(); ++v) {
    EXPECT_NEAR(static_cast<float>(cooked[v]) / 32767.0f, painted[v], 1e-4f);
    largest = std::max(largest, painted[v]);
  }
  EXPECT_NEAR(largest, 1.0f, 0.01f);

  // Saved, it cooks the same from the files.
  session_.save(session_.document.file());
  Session again;
  again.open(folder() / "sheet.glb");
  settle(again);
  ASSERT_TRUE(again.shown()) << again.error();
  EXPECT_TRUE(std::ranges::equal(again.shown()->view().layers[0].bias, cooked));
}

TEST_F(PaintedSheet, ARecipeSavedUnderAnotherNameTakesItsPaintedImagesWithIt) {
  const auto paint = [&](float x) {
    Content content = session_.document.content();
    const fs::path file = paintedFile(content, session_.document.file(), 0, Painted::kBias);
    Stroke stroke(canvas_, current(Painted::kBias), Painted::kBias, brush_, diagonalOf(asset()));
    stroke.moveTo({x, 0.1f, 0.0f}, {0, 0, 1});
    content.images[file] = std::make_shared<pipeline::ByteImage>(stroke.image());
    content.recipe.layers[0].bias = pipeline::Bias{{}, 0, 0.5, file};
    session_.document.apply(std::move(content), "paint");
    session_.document.endGesture();
  };
  paint(0.2f);
  session_.save(session_.document.file());
  const std::string first = bytesOf(folder() / "sheet_lines_bias.png");
  paint(-0.2f);
  const fs::path other = folder() / "elsewhere" / "coat.json";
  fs::create_directory(other.parent_path());
  session_.save(other);
  EXPECT_FALSE(session_.document.dirty());
  EXPECT_EQ(session_.document.file(), other);
  EXPECT_EQ(bytesOf(folder() / "sheet_lines_bias.png"), first);  // the first recipe is as it was saved
  EXPECT_EQ(pipeline::readRecipe(folder() / "sheet.json").layers[0].bias->texture,
            folder() / "sheet_lines_bias.png");
  EXPECT_EQ(pipeline::readRecipe(other).layers[0].bias->texture, other.parent_path() / "coat_lines_bias.png");
  EXPECT_NE(bytesOf(other.parent_path() / "coat_lines_bias.png"), first);
  settle(session_);
  EXPECT_EQ(session_.error(), "");
  session_.document.undo();  // the name
  session_.document.undo();  // the second stroke
  EXPECT_TRUE(session_.document.content().images.contains(folder() / "sheet_lines_bias.png"));
  session_.document.redo();
  session_.document.redo();
  EXPECT_FALSE(session_.document.dirty());
}

TEST_F(PaintedSheet, TheRayFindsThePlaceUnderIt) {
  const preview::PosedFrame frame = session_.player.frame(*session_.shown()->loaded);
  PosedSurface& surface = session_.shown()->surface;
  surface.pose(frame.input);
  const glm::vec3 origin(frame.origin[0], frame.origin[1], frame.origin[2]);
  const auto hit = surface.hit(glm::vec3(0.21f, -0.13f, 5.0f) - origin, {0, 0, -1});
  ASSERT_TRUE(hit);
  const glm::vec3 rest = surface.restAt(hit->triangle, hit->barycentric);
  EXPECT_NEAR(rest.x, 0.21f, 1e-4f);
  EXPECT_NEAR(rest.y, -0.13f, 1e-4f);
  EXPECT_FALSE(surface.hit(glm::vec3(0.7f, 0.0f, 5.0f) - origin, {0, 0, -1}));
  const SurfaceHit near = surface.nearestAtRest({0.21f, -0.13f, 1.0f});
  EXPECT_NEAR(surface.restAt(near.triangle, near.barycentric).x, 0.21f, 0.05f);
}

TEST_F(PaintedSheet, TheHistogramSeesTheSqueeze) {
  session_.player.morphs["squeeze"] = 1.0f;
  const preview::PosedFrame frame = session_.player.frame(*session_.shown()->loaded);
  session_.shown()->surface.pose(frame.input);
  for (float length : session_.shown()->surface.stretches(0, 1.0f)) EXPECT_NEAR(length, 0.6f, 0.01f);
}

TEST_F(PaintedSheet, BreathingSqueezesByTheSquareOfItsLength) {
  Player& player = session_.player;
  player.clip.clear();
  player.breathing.on = true;
  player.breathing.amplitude = 0.2f;
  player.time = 0.75 * player.breathing.period;  // as small as it gets
  const preview::PosedFrame frame = player.frame(*session_.shown()->loaded);
  session_.shown()->surface.pose(frame.input);
  for (float length : session_.shown()->surface.stretches(0, 1.0f)) EXPECT_NEAR(length, 0.8f, 1e-3f);
  player.breathing.axes[0] = false;
  session_.shown()->surface.pose(player.frame(*session_.shown()->loaded).input);
  for (float length : session_.shown()->surface.stretches(0, 1.0f)) EXPECT_NEAR(length, 1.0f, 1e-3f);
}

TEST_F(PaintedSheet, PlayingLoopsOrStopsAndHeldSlidersWin) {
  Player& player = session_.player;
  const pipeline::Rig& rig = session_.shown()->loaded->rig;
  player.playing = true;
  player.speed = 2.0f;
  player.advance(rig, 0.7);
  EXPECT_NEAR(player.time, 0.4, 1e-9);
  EXPECT_NEAR(player.pose(rig).morph_weights[0], 0.4, 1e-6);
  player.morphs["squeeze"] = 0.9f;
  EXPECT_NEAR(player.pose(rig).morph_weights[0], 0.9, 1e-6);
  player.loop = false;
  player.advance(rig, 5.0);
  EXPECT_EQ(player.time, 1.0);
  EXPECT_FALSE(player.playing);
  player.playOrPause(rig);  // from the end: once more
  player.advance(rig, 0.1);
  EXPECT_TRUE(player.playing);
  EXPECT_NEAR(player.time, 0.2, 1e-9);
  player.playOrPause(rig);
  EXPECT_FALSE(player.playing);
  EXPECT_NEAR(player.time, 0.2, 1e-9);
}

TEST(UvViewTest, TrianglesAtTheBorderOfTheirTileStayWhole) {
  const auto shown = ui::onFirstTile({0.75f, 0.5f}, {1.0f, 0.5f}, {1.0f, 1.0f});
  EXPECT_EQ(shown[0].x, 0.75f);
  EXPECT_EQ(shown[1].x, 1.0f);
  EXPECT_EQ(shown[2].y, 1.0f);
  const auto second = ui::onFirstTile({1.0f, -0.5f}, {1.25f, -1.0f}, {1.0f, -1.0f});
  EXPECT_EQ(second[0].x, 0.0f);
  EXPECT_EQ(second[1].x, 0.25f);
  EXPECT_EQ(second[0].y, 0.5f);
}

TEST(CameraTest, ZoomsOnCharactersOfEverySize) {
  for (const float size : {1e-7f, 1.0f, 1e9f}) {
    preview::Camera camera;
    camera.distance = 3.0f * size;
    ui::zoomCamera(camera, size, 1.0f);
    EXPECT_LT(camera.distance, 2.9f * size);
    EXPECT_GT(camera.distance, 2.0f * size);
    ui::zoomCamera(camera, size, -2.0f);
    EXPECT_GT(camera.distance, 3.1f * size);
    ui::zoomCamera(camera, size, 1000.0f);
    EXPECT_GT(camera.distance, 0.0f);
    EXPECT_LT(camera.distance, 0.01f * size);
  }
}

TEST(CameraTest, StandsUprightWhereZIsUp) {
  const std::vector<Float3> tall = {{0, 0, 0}, {1, 0, 0}, {0, 0, 6}, {1, 0, 6}};
  const auto seen = [&](bool z_up, float yaw, size_t index) {
    const preview::Camera camera = preview::fitCamera(tall, 1.0f, yaw, 0.0f, z_up);
    const Float3 p = tall[index];
    const glm::vec4 clip =
        preview::cameraFrame(camera, 1.0f).view_projection * glm::vec4(p.x, p.y, p.z, 1.0f);
    return glm::vec2(clip) / clip.w;
  };
  for (const float yaw : {0.0f, 40.0f}) {
    EXPECT_GT(seen(true, yaw, 2).y, 0.8f);
    EXPECT_LT(seen(true, yaw, 0).y, -0.8f);
  }
  EXPECT_LT(std::abs(seen(false, 0.0f, 2).y), 0.1f);
  EXPECT_GT(seen(true, 0.0f, 1).x, seen(true, 0.0f, 0).x);  // not mirrored
}

// The whole editor on a small screen, with files that change between two scripts.
class ScreenTest : public SessionTest {
 protected:
  void SetUp() override {
    try {
      context_.emplace();
    } catch (const pipeline::Error& error) {
      GTEST_SKIP() << error.what();
    }
    headless_.emplace(640, 480, 1.0f);
    screen_ = headless_->screen();
    editor_.emplace(session_, settings_);
  }
  void play(const std::string& script) { ui::runScript(script, "script", *editor_, screen_, folder()); }
  static std::string times(int count, const std::string& line) {
    std::string all;
    for (int i = 0; i < count; ++i) all += line + "\n";
    return all;
  }

  std::optional<preview::HeadlessContext> context_;
  std::optional<ui::HeadlessScreen> headless_;
  ui::Screen screen_;
  Settings settings_;
  Session session_;
  std::optional<ui::Editor> editor_;
};

TEST_F(ScreenTest, AMeshThatComesBackInOtherUnitsIsFramedAnew) {
  const float& distance = editor_->state().camera.distance;
  play("open " + write("still.glb", editorStill()).string() + "\nwait\nkey =\n");
  const float metres = distance;
  write("still.glb", editorStill(1.5));
  play("frames 90\nwait\n");
  EXPECT_EQ(distance, metres);  // as the artist had it
  write("still.glb", editorStill(100.0));
  play("frames 90\nwait\n");
  EXPECT_GT(distance, 50.0f * metres);
}

TEST_F(ScreenTest, AStrokeOverAMeshThatIsReplacedByAnotherGoesOn) {
  write("sheet.json", kEditorRecipe);
  play("open " + write("sheet.glb", editorSheet()).string() + "\nwait\nkey B\nkey C\nkey Space\nkey Right\n");
  write("sheet.glb", editorPair());
  play("frames 60\nwait\nkey Right\nkey Right\nkey Space\nwait\nexpect no error\nexpect dirty\n");
  EXPECT_EQ(session_.shown()->view().parts.size(), 2u);
}

// Large maps are cooked small first, which no newer edit ends.
std::string draftedRecipe() {
  std::string recipe = kEditorRecipe;
  return recipe.replace(recipe.find("128"), 3, "512");
}

TEST_F(ScreenTest, AStrokeStaysInSightWhileTheOneBeforeItIsCooked) {
  write("sheet.json", draftedRecipe());
  play("open " + write("sheet.glb", editorSheet()).string() + "\nwait\nkey B\nkey C\n");
  const auto color = [&] {  // of the view's middle, where the second stroke goes
    play("frames 1\n");
    const ui::Rect view = *ui::find("viewport");
    const pipeline::Image picture = screen_.picture();
    const float* pixel = picture.at(static_cast<uint32_t>(0.5f * (view.low.x + view.high.x)),
                                    static_cast<uint32_t>(0.5f * (view.low.y + view.high.y)));
    return std::abs(pixel[0] - pixel[2]);
  };
  play(times(8, "key Up"));
  EXPECT_LT(color(), 0.1f);
  play("key Space\nkey Right\nkey Space\n" + times(8, "key Down") +
       "key Space\nkey Left\nkey Space\nkey C\n");
  do EXPECT_GT(color(), 0.3f);
  while (editor_->working());
  play("key Ctrl+Z\nwait\n");
  EXPECT_LT(color(), 0.1f);
  // Taken back before it is cooked, it goes at once.
  const auto before = session_.shown();
  play("key C\nkey Space\nkey Right\nkey Space\nkey C\nkey Ctrl+Z\n");
  const float after = color();
  if (session_.shown() == before) {
    EXPECT_LT(after, 0.1f);
  }
}

TEST_F(ScreenTest, AGuideGoesOnWhileTheOneBeforeItIsCooked) {
  write("sheet.json", draftedRecipe());
  play("open " + write("sheet.glb", editorSheet()).string() + "\nwait\nkey G\nkey C\n");
  const std::string draw = "key Space\n" + times(10, "key Right"),
                    lift = "key Space\n" + times(10, "key Left");
  play(draw + lift + draw + "wait\n" + times(4, "key Right") + lift + "wait\n");
  const auto* guides =
      std::get_if<pipeline::DirectionGuides>(&session_.document.recipe().layers[0].direction);
  ASSERT_TRUE(guides);
  ASSERT_EQ(guides->curves.size(), 2u);
  EXPECT_NEAR(guides->curves[1].front()[0], guides->curves[0].front()[0], 1e-6);
  EXPECT_GT(guides->curves[1].back()[0], guides->curves[0].back()[0]);
}

TEST_F(SessionTest, WhatAScriptWaitsForTakesNoneOfItsTime) {
  std::optional<preview::HeadlessContext> context;
  try {
    context.emplace();
  } catch (const pipeline::Error& error) {
    GTEST_SKIP() << error.what();
  }
  ui::HeadlessScreen headless(640, 480, 1.0f);
  Session session;
  Settings settings;
  ui::Editor editor(session, settings);
  const ui::Screen screen = headless.screen();
  const auto passed = [&](const std::string& script) {
    const double before = session.player.time;
    ui::runScript(script, "script", editor, screen, folder());
    return session.player.time - before;
  };
  passed("open " + write("sheet.glb", editorSheet()).string() + "\nwait\nkey Space\n");
  const double idle = passed("wait\n");
  EXPECT_GT(idle, 0.0);
  edit(session, "maps", [](pipeline::Recipe& recipe) { recipe.map_size = 512; });
  EXPECT_NEAR(passed("wait\n"), idle, 1e-9);
}

TEST_F(SessionTest, WhatIsComparedWithIsWaitedForToo) {
  Session session;
  session.open(write("sheet.glb", editorSheet()));
  settle(session);
  session.compareWith(write("bare.json", R"({"layers": [{"name": "a", "compress": "none"}]})"));
  EXPECT_TRUE(session.cooking());
  settle(session);
  ASSERT_TRUE(session.comparison());
  EXPECT_EQ(session.comparison()->view().layers[0].name, "a");
}

TEST_F(SessionTest, ClipsAndMorphTargetsWithoutNamesGoByTheirNumber) {
  Session session;
  session.open(write("nameless.glb", editorNameless()));
  settle(session);
  ASSERT_TRUE(session.shown()) << session.error();
  const pipeline::Rig& rig = session.shown()->loaded->rig;
  Player& player = session.player;
  EXPECT_EQ(player.clip, "0");
  EXPECT_EQ(player.duration(rig), 1.0);
  player.time = 0.5;
  EXPECT_NEAR(player.pose(rig).morph_weights[0], 0.5, 1e-6);
  player.morphs["0"] = 0.9f;
  EXPECT_NEAR(player.pose(rig).morph_weights[0], 0.9, 1e-6);
  player.clip.clear();  // none, not the one whose name is empty
  EXPECT_EQ(player.duration(rig), 0.0);
  pipeline::Rig twins = rig;
  twins.clips.front().name = "go";
  twins.clips.push_back(twins.clips.front());
  twins.clips.back().duration = 3.0;
  EXPECT_EQ(clipKey(twins, 0), "go");
  player.clip = clipKey(twins, 1);
  EXPECT_EQ(player.duration(twins), 3.0);
}

TEST_F(SessionTest, SamplesAreMadeInTheBackgroundWholeOrNotAtAll) {
  const fs::path program =
      write("content.sh", "#!/bin/sh\nfor f in face jacket; do echo $f > \"$1/$f.glb\"; done\n");
  fs::permissions(program, fs::perms::owner_all);
  const auto answer = [](Samples& samples) {
    for (;;) {
      if (std::optional<Samples::Result> result = samples.take()) return *result;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  };
  Samples samples(program, folder() / "cache" / "samples");
  EXPECT_FALSE(samples.take());
  samples.ask("face");
  EXPECT_TRUE(samples.making());
  EXPECT_EQ(answer(samples).file, folder() / "cache" / "samples" / "face.glb");
  EXPECT_FALSE(samples.making());
  EXPECT_FALSE(samples.take());
  samples.ask("jacket");  // is there already
  EXPECT_FALSE(samples.making());
  EXPECT_EQ(answer(samples).error, "");

  // A program that fails half-way leaves nothing.
  const fs::path bad = write("bad.sh", "#!/bin/sh\necho half > \"$1/face.glb\"\nexit 1\n");
  fs::permissions(bad, fs::perms::owner_all);
  Samples none(bad, folder() / "none");
  none.ask("face");
  EXPECT_NE(answer(none).error.find("none: the samples cannot be made there"), std::string::npos);
  {
    const fs::path slow = write("slow.sh", "#!/bin/sh\nexec sleep 600\n");
    fs::permissions(slow, fs::perms::owner_all);
    Samples left(slow, folder() / "none");
    left.ask("face");
  }
  for (const fs::directory_entry& entry : fs::directory_iterator(folder()))
    EXPECT_FALSE(entry.path().filename().string().starts_with("none")) << entry.path() << " was left behind";
  Samples missing(folder() / "missing", folder() / "none");
  missing.ask("face");
  EXPECT_NE(answer(missing).error.find("put furrow_content beside the editor"), std::string::npos);
}

TEST_F(SessionTest, SamplesThatWereLostAreMadeAgainAlsoByTwoAtOnce) {
  const fs::path program =
      write("content.sh", "#!/bin/sh\nfor f in face jacket; do echo $f > \"$1/$f.glb\"; done\n");
  fs::permissions(program, fs::perms::owner_all);
  const fs::path made = folder() / "cache" / "samples";
  fs::create_directories(made);
  std::ofstream(made / "jacket.glb") << "jacket";  // the face was cleaned away
  Samples one(program, made), other(program, made);
  for (Samples* samples : {&one, &other}) samples->ask("face");
  for (Samples* samples : {&one, &other}) {
    std::optional<Samples::Result> result;
    while (!(result = samples->take())) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    EXPECT_EQ(result->error, "");
    EXPECT_EQ(bytesOf(result->file), "face\n");
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(made.parent_path()), {}), 1);
}

TEST_F(SessionTest, SettingsComeBackAndDamagedOnesAreTheDefaults) {
  const fs::path file = folder() / "config" / "furrow" / "editor.json";
  Settings settings;
  for (int i = 0; i < 15; ++i) settings.opened("/models/" + std::to_string(i) + ".glb");
  settings.opened("/models/9.glb");
  settings.width = 1200;
  settings.scale = 1.5f;
  settings.tier = "cpu";
  settings.show_right = false;
  writeSettings(file, settings);
  const Settings read = readSettings(file);
  EXPECT_EQ(read.recent.size(), Settings::kMostRecent);
  EXPECT_EQ(read.recent[0], "/models/9.glb");
  EXPECT_EQ(read.recent[1], "/models/14.glb");
  EXPECT_EQ(read.width, 1200);
  EXPECT_EQ(read.scale, 1.5f);
  EXPECT_EQ(read.tier, "cpu");
  EXPECT_FALSE(read.show_right);
  settings.opened("/models/\xfc.glb");  // no UTF-8
  writeSettings(file, settings);
  EXPECT_EQ(readSettings(file).recent[1], "/models/9.glb");
  EXPECT_EQ(readSettings(folder() / "none.json").width, Settings().width);
  EXPECT_EQ(readSettings(write("small.json", R"({"width": 320})")).width, Settings().width);
  EXPECT_EQ(readSettings(write("bad.json", "{ \"width\": ")).width, Settings().width);
  EXPECT_EQ(
      readSettings(write("odd.json", R"({"width": -3, "scale": "big", "recent": 4, "tier": "x"})")).tier,
      "auto");
}

// Between two slow frames a whole click, a key and its text arrive.
TEST(InputQueueTest, WhatGoesDownAndUpBetweenTwoFramesIsDownInOne) {
  ui::InputQueue input;
  ImGuiIO io;
  input.pointer({10, 20});
  input.button(0, true);
  input.button(0, false);
  input.pointer({50, 60});
  input.key(341, true);  // Ctrl
  input.key('S', true);
  input.key('S', false);
  input.key(341, false);
  input.apply(io);
  EXPECT_EQ(io.MousePos.x, 10.0f);
  EXPECT_TRUE(io.MouseDown[0]);
  input.apply(io);
  EXPECT_EQ(io.MousePos.x, 10.0f);  // let go where it was pressed
  EXPECT_FALSE(io.MouseDown[0]);
  input.apply(io);
  EXPECT_EQ(io.MousePos.x, 50.0f);
  EXPECT_TRUE(io.KeysDown[int{'S'}] && io.KeyCtrl);
  input.apply(io);
  EXPECT_FALSE(io.KeysDown[int{'S'}] || io.KeyCtrl);
  EXPECT_TRUE(input.empty());
}

// Fast hands and xdotool let go of Ctrl first.
TEST(InputQueueTest, AModifierLetGoBetweenTwoFramesWasDownForTheKey) {
  ui::InputQueue input;
  ImGuiIO io;
  input.key(341, true);  // Ctrl, a frame before
  input.apply(io);
  input.key('K', true);
  input.key(341, false);
  input.key('K', false);
  input.apply(io);
  EXPECT_TRUE(io.KeysDown[int{'K'}] && io.KeyCtrl);
  input.apply(io);
  EXPECT_FALSE(io.KeysDown[int{'K'}] || io.KeyCtrl);
  input.key('K', true);
  input.key(341, true);  // too late for the key
  input.apply(io);
  EXPECT_TRUE(io.KeysDown[int{'K'}] && !io.KeyCtrl);
  input.apply(io);
  EXPECT_TRUE(io.KeyCtrl);
  input.wheel(0, 1);
  input.key(341, false);
  input.apply(io);
  EXPECT_TRUE(io.MouseWheel == 1.0f && io.KeyCtrl);
  input.apply(io);
  EXPECT_FALSE(io.KeyCtrl);
}

// What is dragged follows the pointer in frames that have the button down.
TEST(InputQueueTest, ADragEndsWhereTheButtonWasLetGo) {
  ui::InputQueue input;
  ImGuiIO io;
  input.pointer({10, 20});
  input.button(0, true);
  input.pointer({30, 20});
  input.pointer({50, 20});
  input.button(0, false);
  input.apply(io);
  EXPECT_TRUE(io.MousePos.x == 10.0f && io.MouseDown[0]);
  input.apply(io);
  EXPECT_TRUE(io.MousePos.x == 50.0f && io.MouseDown[0]);
  input.apply(io);
  EXPECT_TRUE(io.MousePos.x == 50.0f && !io.MouseDown[0]);
  EXPECT_TRUE(input.empty());
}

TEST(InputQueueTest, KeysPressedBetweenTwoFramesHaveAFrameEach) {
  ui::InputQueue input;
  ImGuiIO io;
  for (const int key : {'B', 'X'}) input.key(key, true);
  for (const int key : {'B', 'X'}) input.key(key, false);
  input.apply(io);
  EXPECT_TRUE(io.KeysDown[int{'B'}] && !io.KeysDown[int{'X'}]);
  input.apply(io);
  EXPECT_TRUE(io.KeysDown[int{'X'}]);
  while (!input.empty()) input.apply(io);
  EXPECT_FALSE(io.KeysDown[int{'B'}] || io.KeysDown[int{'X'}]);
}

TEST(InputQueueTest, NothingStaysDownWhenTheWindowIsLeft) {
  ui::InputQueue input;
  ImGuiIO io;
  input.button(1, true);
  input.pointer({5, 5});
  input.pointerLeft();  // a drag goes on outside
  input.apply(io);
  input.apply(io);
  EXPECT_EQ(io.MousePos.x, 5.0f);
  input.key('A', true);
  input.release();
  while (!input.empty()) input.apply(io);
  EXPECT_FALSE(io.MouseDown[1] || io.KeysDown[int{'A'}]);
  input.pointerLeft();
  input.apply(io);
  EXPECT_LT(io.MousePos.x, -1e30f);
  input.key(-1, true);  // a key that GLFW does not know
  EXPECT_TRUE(input.empty());
}

}  // namespace
}  // namespace furrow::test
