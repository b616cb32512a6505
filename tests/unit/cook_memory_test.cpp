#include "pipeline/cook/cook_memory.h"

#include <gtest/gtest.h>

#include <string>

#include "pipeline/cook/cook.h"
#include "pipeline/import/import.h"

namespace furrow::pipeline {
namespace {

constexpr const char* kPainted = "/painted/image.png";

std::shared_ptr<const ByteImage> stripes(uint32_t width) {
  ByteImage image{64, 64, 4, {}};
  for (uint32_t i = 0; i < 64 * 64; ++i) {
    const uint8_t value = i % 64 / width % 2 == 0 ? 230 : 60;
    image.pixels.insert(image.pixels.end(), {value, 128, 200, 255});
  }
  return std::make_shared<const ByteImage>(std::move(image));
}

// Cooks the panel again and again, with a memory and without.
class CookMemoryTest : public testing::Test {
 protected:
  CookMemoryTest() {
    recipe_ = parseRecipe(R"({ "mapSize": 64, "layers": [
      { "name": "pinch", "direction": { "attribute": "_DIR_PINCH" }, "response": { "fit": 0.9 },
        "mask": { "attribute": "_MASK_A", "channel": "r" } },
      { "name": "all", "response": { "fit": 0.8 } } ] })",
                          "/panel.json");
    options_.geometry = GeometryCodec::kRaw;
  }

  // What the cook did, of welding and of baking layers.
  void cookBoth(const char* change, bool welds) {
    SCOPED_TRACE(change);
    const Cooked cold = cook(scene_, recipe_, options_);
    CookOptions options = options_;
    options.memory = &memory_;
    bool welded = false;
    options.progress = [&](const char* stage) { welded |= std::string(stage) == "welding"; };
    const Cooked warm = cook(scene_, recipe_, options);
    EXPECT_EQ(welded, welds);
    EXPECT_TRUE(warm.bytes == cold.bytes);
    EXPECT_EQ(recipeText(warm.recipe, recipe_.file), recipeText(cold.recipe, recipe_.file));
    EXPECT_EQ(warm.report.warnings, cold.report.warnings);
    EXPECT_EQ(warm.report.layers[0].fit->alpha, cold.report.layers[0].fit->alpha);
    EXPECT_EQ(warm.report.topology.isolated_vertices, cold.report.topology.isolated_vertices);
    EXPECT_EQ(warm.dependencies, cold.dependencies);
    EXPECT_TRUE(last_.empty() || cold.bytes != last_ || !changes_) << "the change changes nothing";
    last_ = cold.bytes;
  }

  LayerRecipe& layer(size_t l) { return recipe_.layers[l]; }

  SourceScene scene_ = import(std::filesystem::path(FURROW_CONTENT) / "panel.glb");
  Recipe recipe_;
  CookOptions options_;
  CookMemory memory_;
  std::vector<std::byte> last_;
  bool changes_ = true;
};

TEST_F(CookMemoryTest, EveryChangeCooksToTheSameBytesAsWithoutIt) {
  cookBoth("first", true);
  changes_ = false;
  cookBoth("again", false);
  changes_ = true;
  recipe_.map_size = 128;
  cookBoth("larger maps", false);
  std::get<MapSynthesized>(layer(0).compress).seed = 7;
  cookBoth("seed", false);
  layer(0).fit = 0.7;
  cookBoth("response", false);
  layer(1).measure = Measure::kArea;
  cookBoth("measure", false);
  layer(0).mask = MaskTexture{kPainted, 0};
  options_.images[kPainted] = stripes(16);
  cookBoth("painted mask", false);
  options_.images[kPainted] = stripes(8);
  cookBoth("more of it", false);
  layer(0).bias = Bias{"", 0, 0.5, kPainted};
  cookBoth("painted bias", false);
  layer(1).direction = DirectionTexture{kPainted};
  cookBoth("combed", false);
  options_.images[kPainted] = stripes(4);
  cookBoth("combed again", false);
  recipe_.weld_tolerance = 0.0;
  changes_ = false;
  cookBoth("weld", true);
  changes_ = true;
  options_.geometry = GeometryCodec::kDraco;
  cookBoth("Draco", true);
  std::swap(layer(0), layer(1));
  layer(0).fit = 0.6;
  cookBoth("order", false);
  recipe_.layers.pop_back();
  cookBoth("a layer less", false);
}

TEST_F(CookMemoryTest, ACookThatEndsEarlyLeavesNothingWrongBehind) {
  cookBoth("first", true);
  for (const char* at : {"reading the model's maps", "welding", "packing geometry", "measuring the animation",
                         "baking layers", "making maps", "packing", "loading it again"}) {
    SCOPED_TRACE(at);
    CookOptions options = options_;
    options.memory = &memory_;
    options.progress = [&](const char* stage) {
      if (std::string(stage) == at) throw std::runtime_error("enough");
    };
    Recipe other = recipe_;
    other.weld_tolerance = 0.01;
    other.layers[0].direction = DirectionAxis{{1.0, 0.0, 0.0}};
    EXPECT_THROW(cook(scene_, other, options), std::runtime_error);
    changes_ = false;
    cookBoth("as before", std::string(at) != "reading the model's maps");
  }
}

TEST_F(CookMemoryTest, AnotherSceneIsCookedOnceTheLastIsForgotten) {
  cookBoth("first", true);
  for (glm::vec3& p : scene_.primitives[0].positions) p.z += 0.1f * p.x;
  memory_.forgetScene();
  cookBoth("moved", true);
}

}  // namespace
}  // namespace furrow::pipeline
