// Images of recipes that lie in glTF files: "head.glb#wrinkles".

#include <gmock/gmock.h>

#include <cmath>

#include "pipeline/cook/cook.h"
#include "pipeline/cook/cook_cache.h"
#include "pipeline/error.h"
#include "pipeline/import/import.h"
#include "pipeline/maps/png.h"
#include "tests/unit/textured_square.h"

namespace furrow::pipeline {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

std::vector<uint8_t> pngOf(const ByteImage& image) {
  const std::vector<std::byte> bytes = encodePng(image);
  const auto* begin = reinterpret_cast<const uint8_t*>(bytes.data());
  return {begin, begin + bytes.size()};
}

ByteImage ridges() {
  ByteImage image{32, 32, 3, {}};
  for (uint32_t i = 0; i < 32 * 32; ++i) {
    const double slope = 0.4 * std::sin(i % 32 * 0.785398), length = std::hypot(slope, 1.0);
    for (const double c : {slope / length, 0.0, 1.0 / length})
      image.pixels.push_back(static_cast<uint8_t>(std::lround(127.5 + 127.5 * c)));
  }
  return image;
}

ByteImage halves() {
  ByteImage image{16, 16, 1, {}};
  for (uint32_t i = 0; i < 16 * 16; ++i) image.pixels.push_back(i % 16 < 8 ? 255 : 0);
  return image;
}

// A square whose images are the model's own colours, the ridges, and a mask without a name.
class EmbeddedImage : public testing::Test {
 protected:
  EmbeddedImage() {
    test::Square square;
    const std::string images = square.embedded(pngOf(test::quadrants(3))) + ",\"name\":\"skin\"},{" +
                               square.embedded(pngOf(ridges())) + ",\"name\":\"wrinkle # maps/a\"},{" +
                               square.embedded(pngOf(halves()));
    model = square.write("model.glb", images, "\"source\":0",
                         "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}");
    test::writeFile("ridges.png", text(pngOf(ridges())));
    test::writeFile("halves.png", text(pngOf(halves())));
  }

  static std::string text(const std::vector<uint8_t>& bytes) { return {bytes.begin(), bytes.end()}; }

  Recipe recipe(const std::string& normal, const std::string& mask) const {
    return parseRecipe(
        R"({"mapSize": 32, "layers": [{"name": "a", "direction": "map", "mask": {"texture": ")" + mask +
            R"("}, "compress": {"normal": ")" + normal + R"("}}]})",
        model.parent_path() / "recipe.json");
  }

  std::string refusal(const std::string& image) const {
    try {
      recipe(image, "halves.png");
    } catch (const Error& error) {
      EXPECT_EQ(error.exit(), Exit::kBadData);
      return error.what();
    }
    return "nothing";
  }

  fs::path model;
};

TEST_F(EmbeddedImage, ServesARecipeAsAFileDoes) {
  const Cooked loose = cook(import(model), recipe("ridges.png", "halves.png"), {});
  const Cooked inside = cook(import(model), recipe("model.glb#wrinkle # maps/a", "model.glb#2"), {});
  EXPECT_EQ(inside.bytes, loose.bytes);
  const fs::path folder = model.parent_path();
  EXPECT_THAT(inside.dependencies, ElementsAre(model, folder / "recipe.json"));
  EXPECT_THAT(loose.dependencies,
              testing::UnorderedElementsAre(model, folder / "recipe.json", folder / "ridges.png",
                                            folder / "halves.png"));
  // What --init writes means the same.
  const Recipe again = parseRecipe(recipeText(inside.recipe, folder / "recipe.json"), folder / "recipe.json");
  EXPECT_EQ(cook(import(model), again, {}).bytes, loose.bytes);
  EXPECT_THAT(again.files, Contains(model));
}

TEST_F(EmbeddedImage, IsFoundBesideAGltf) {
  test::GltfBuilder builder;
  builder.addView(std::vector<uint8_t>{1, 2, 3, 4});
  builder.addAccessor(R"("componentType":5126,"count":1,"type":"SCALAR")");
  const fs::path file = test::writeFile(
      "beside.gltf", builder.json(R"("images":[{"name":"mask","uri":"halves.png"}])", "beside.bin"));
  const fs::path bin = test::writeFile("beside.bin", builder.bin());
  const auto found = embeddedImage(file.string() + "#mask");
  ASSERT_TRUE(found);
  EXPECT_THAT(found->files, ElementsAre(file, bin, model.parent_path() / "halves.png"));
  EXPECT_EQ(readByteImage(file.string() + "#mask").pixels, halves().pixels);
  EXPECT_EQ(readImage(file.string() + "#0").pixels, toFloats(halves()).pixels);
  EXPECT_THAT(recipe("ridges.png", "beside.gltf#mask").files, Contains(bin));
}

TEST_F(EmbeddedImage, ThatIsNotThereIsNamed) {
  EXPECT_THAT(refusal("model.glb#creases"),
              HasSubstr("model.glb: it has no image \"creases\": it has: skin, wrinkle # maps/a, 2"));
  for (const char* number : {"3", "-1", "1x", "99999999999999999999", ""})
    EXPECT_THAT(refusal("model.glb#" + std::string(number)), HasSubstr("it has no image")) << number;
  EXPECT_THAT(refusal("other.glb#skin"), HasSubstr("no such file"));
  EXPECT_THAT(refusal("halves.png#skin"), HasSubstr("no such file"));
  test::writeFile("bare.glb", test::GltfBuilder().glb(""));
  EXPECT_THAT(refusal("bare.glb#0"), HasSubstr("give an image file"));
  test::writeFile("words.glb", "words");
  EXPECT_THAT(refusal("words.glb#0"), HasSubstr("words.glb"));
  // A file of the whole name comes first.
  test::writeFile("model.glb#1", text(pngOf(ridges())));
  EXPECT_FALSE(embeddedImage(model.string() + "#1"));
  fs::remove(model.string() + "#1");
}

}  // namespace
}  // namespace furrow::pipeline
