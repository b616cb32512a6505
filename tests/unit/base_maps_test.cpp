#include "pipeline/cook/base_maps.h"

#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>

#include "pipeline/cook/cook.h"
#include "pipeline/cook/cook_cache.h"
#include "pipeline/cook/cook_memory.h"
#include "pipeline/error.h"
#include "pipeline/import/formats.h"
#include "pipeline/import/import.h"
#include "pipeline/maps/color.h"
#include "pipeline/pack/section_bytes.h"
#include "tests/unit/textured_square.h"

namespace furrow::pipeline {
namespace {

using test::Color;
using test::kQuadrants;
using test::quadrants;
using test::Square;
using test::writeFile;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
namespace fs = std::filesystem;

// A file of the format that the extension names, by OpenImageIO.
std::vector<uint8_t> fileOf(const ByteImage& image, const std::string& extension) {
  const fs::path file = writeFile("written." + extension, "");
  const auto output = OIIO::ImageOutput::create(file.string());
  EXPECT_TRUE(output) << OIIO::geterror();
  OIIO::ImageSpec spec(static_cast<int>(image.width), static_cast<int>(image.height),
                       static_cast<int>(image.channels), OIIO::TypeDesc::UINT8);
  spec.attribute("CompressionQuality", 100);
  spec.attribute("oiio:UnassociatedAlpha", 1);
  EXPECT_TRUE(output->open(file.string(), spec));
  EXPECT_TRUE(output->write_image(OIIO::TypeDesc::UINT8, image.pixels.data()));
  EXPECT_TRUE(output->close());
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string base64(const std::vector<uint8_t>& bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t word = 0;
    for (size_t k = 0; k < 3; ++k) word = word << 8 | (i + k < bytes.size() ? bytes[i + k] : 0u);
    for (size_t k = 0; k < 4; ++k) text += i + k > bytes.size() ? '=' : kDigits[word >> (18 - 6 * k) & 63];
  }
  return text;
}

const std::string kColor = "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}";

struct Result {
  Cooked cooked;
  Asset asset;
};

Result cookFile(const fs::path& file, uint32_t preview_size = 1024) {
  Recipe recipe = defaultRecipe();
  recipe.preview_size = preview_size;
  recipe.map_size = 64;
  Result result{cook(import(file), recipe, {}), {}};
  EXPECT_TRUE(result.asset.load(result.cooked.bytes).ok());
  return result;
}

BaseMaps mapsOf(const Result& result) {
  EXPECT_EQ(result.asset.view().base_maps.size(), 1u);
  return result.asset.view().base_maps.empty() ? BaseMaps() : result.asset.view().base_maps[0];
}

void expectQuadrants(const Asset& asset, double tolerance) {
  ASSERT_EQ(asset.view().base_maps.size(), 1u);
  ASSERT_EQ(asset.view().parts[0].base_maps, 0u);
  const Texture& color = asset.view().base_maps[0].color;
  ASSERT_EQ(color.slices, 1u);
  for (uint32_t q = 0; q < 4; ++q) {
    const Float4 texel =
        texelAt(color, 0, 0, color.width * (1 + 2 * (q % 2)) / 4, color.height * (1 + 2 * (q / 2)) / 4);
    EXPECT_NEAR(texel.x, kQuadrants[q][0] / 255.0, tolerance) << q;
    EXPECT_NEAR(texel.y, kQuadrants[q][1] / 255.0, tolerance) << q;
    EXPECT_NEAR(texel.z, kQuadrants[q][2] / 255.0, tolerance) << q;
  }
}

std::vector<std::string> textureWarnings(const Result& result) {
  std::vector<std::string> found;
  for (const std::string& warning : result.cooked.report.warnings)
    if (warning.find("texture") != std::string::npos) found.push_back(warning);
  return found;
}

Texture viewOf(const EncodedTexture& t) {
  return {t.format, t.width, t.height, t.slices, t.levels, t.data};
}

TEST(BaseMaps, ColoursArriveFromEveryFormat) {
  for (const char* format : {"png", "jpg", "webp"}) {
    Square square;
    const std::string image = square.embedded(fileOf(quadrants(3), format));
    const Result result = cookFile(square.write("embedded.glb", image, "\"source\":0", kColor));
    EXPECT_THAT(textureWarnings(result), IsEmpty()) << format;
    expectQuadrants(result.asset, format == std::string("png") ? 0.012 : 0.03);
    EXPECT_EQ(result.asset.view().base_maps[0].color.format, TextureFormat::kBc1);
  }
}

TEST(BaseMaps, WebpMayBeRequired) {
  Square square;
  const std::string image = square.embedded(fileOf(quadrants(3), "webp"));
  const Result result = cookFile(square.write(
      "required.glb", image, "\"extensions\":{\"EXT_texture_webp\":{\"source\":0}}", kColor,
      ",\"extensionsRequired\":[\"EXT_texture_webp\"],\"extensionsUsed\":[\"EXT_texture_webp\"]"));
  EXPECT_THAT(textureWarnings(result), IsEmpty());
  expectQuadrants(result.asset, 0.03);
}

TEST(BaseMaps, ARealAvatarThatRequiresWebpHasItsColours) {
  const fs::path file = fs::path(FURROW_CORPUS) / "face/valid/Asian_F_1_Casual.glb";
  const fs::path plain = fs::path(FURROW_CORPUS) / "face/valid/Asian_F_1_Casual_decoded.glb";
  if (!fs::exists(file)) GTEST_SKIP() << file << " is not here";
  // The same images as WebP, and as PNG and JPEG.
  EncodedImages known;
  const SceneBaseMaps webp = bakeBaseMaps(import(file), 64, 2, known),
                      other = bakeBaseMaps(import(plain), 64, 2, known);
  EXPECT_THAT(webp.warnings, IsEmpty());
  ASSERT_EQ(webp.maps.size(), 1u);
  ASSERT_EQ(other.maps.size(), 1u);
  double squares = 0.0, spread = 0.0;
  for (uint32_t y = 0; y < 64; ++y)
    for (uint32_t x = 0; x < 64; ++x) {
      const Float4 a = texelAt(viewOf(webp.maps[0].color), 0, 0, x, y),
                   b = texelAt(viewOf(other.maps[0].color), 0, 0, x, y);
      squares += double{(a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y) + (a.z - b.z) * (a.z - b.z)};
      spread += std::abs(double{a.x} - 0.5);
    }
  EXPECT_LT(std::sqrt(squares / (3 * 64 * 64)), 0.02);
  EXPECT_GT(spread / (64 * 64), 0.05);
  EXPECT_EQ(webp.maps[0].normal.format, TextureFormat::kBc5);
  EXPECT_EQ(webp.maps[0].normal.slices, 1u);
}

TEST(BaseMaps, AnImageMayBeADataUriOrAFileBesideTheModel) {
  const std::vector<uint8_t> png = fileOf(quadrants(3), "png");
  const Square square;
  const fs::path inside = square.write("inside.glb", "\"uri\":\"data:image/png;base64," + base64(png) + "\"",
                                       "\"source\":0", kColor);
  const Result from_uri = cookFile(inside);
  expectQuadrants(from_uri.asset, 0.012);
  EXPECT_THAT(from_uri.cooked.dependencies, ElementsAre(inside));

  const fs::path beside = square.write("beside.glb", "\"uri\":\"skin%20color.png\"", "\"source\":0", kColor);
  const fs::path image = writeFile("skin color.png", std::string(png.begin(), png.end()));
  const Result from_file = cookFile(beside);
  expectQuadrants(from_file.asset, 0.012);
  EXPECT_THAT(from_file.cooked.dependencies, ElementsAre(beside, image));
  EXPECT_EQ(from_file.cooked.bytes.size(), from_uri.cooked.bytes.size());
  EXPECT_THAT(importedFiles(beside), ElementsAre(beside, image));

  CookRequest request;
  request.source.base = beside;
  const std::string key = cookKey(request, filesOf(request));
  const std::vector<uint8_t> grey = fileOf(quadrants(1), "png");
  writeFile("skin color.png", std::string(grey.begin(), grey.end()));
  EXPECT_NE(cookKey(request, filesOf(request)), key);

  // Nothing that is left out is an input.
  EXPECT_THAT(cookFile(beside, 0).cooked.dependencies, ElementsAre(beside));
}

TEST(BaseMaps, AnImageIsEncodedOnceUntilItsBytesOrItsUseChange) {
  const Square square;
  const auto writePng = [](int channels) {
    const std::vector<uint8_t> png = fileOf(quadrants(channels), "png");
    writeFile("once.png", std::string(png.begin(), png.end()));
  };
  writePng(3);
  const SourceScene scene = import(square.write("once.glb", "\"uri\":\"once.png\"", "\"source\":0", kColor));
  EncodedImages known;
  const SceneBaseMaps first = bakeBaseMaps(scene, 64, 1, known);
  ASSERT_EQ(known.size(), 1u);
  EXPECT_EQ(known.begin()->second.data, first.maps.at(0).color.data);
  known.begin()->second.rms_error = 7.0;  // a mark
  EXPECT_EQ(bakeBaseMaps(scene, 64, 1, known).maps.at(0).color.rms_error, 7.0);
  EXPECT_THAT(bakeBaseMaps(scene, 64, 1, known).dependencies, testing::SizeIs(1));

  EXPECT_NE(bakeBaseMaps(scene, 4, 1, known).maps.at(0).color.rms_error, 7.0);
  EXPECT_EQ(known.size(), 2u);
  writePng(1);
  EXPECT_NE(bakeBaseMaps(scene, 64, 1, known).maps.at(0).color.rms_error, 7.0);
  EXPECT_EQ(known.size(), 3u);
}

TEST(BaseMaps, AnImageThatCannotBeReadCostsAWarning) {
  Square square;
  const std::vector<uint8_t> png = fileOf(quadrants(3), "png");
  const std::string cut = square.embedded({png.begin(), png.begin() + 60});
  const std::string words = square.embedded({'w', 'o', 'r', 'd', 's'});
  const fs::path missing = square.write("missing.glb", "\"uri\":\"nowhere.png\"", "\"source\":0", kColor);
  const std::vector<std::pair<fs::path, std::string>> files = {
      {missing, "nowhere.png: no such file"},
      {square.write("cut.glb", cut + ",\"name\":\"face\"", "\"source\":0", kColor), "image 0 \"face\": "},
      {square.write("words.glb", words, "\"source\":0", kColor), "neither PNG nor JPEG nor WebP"},
      {square.write("outside.glb", "\"bufferView\":99", "\"source\":0", kColor), "buffer view 99"},
      {square.write("lost.glb", words, "\"source\":7", kColor), "no PNG, JPEG or WebP image"},
      {square.write("basis.glb", words, "\"extensions\":{\"KHR_texture_basisu\":{\"source\":0}}", kColor),
       "no PNG, JPEG or WebP image"},
      {square.write("index.glb", words, "\"source\":0",
                    "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":3}}"),
       "no texture 3"},
      {square.write("uv1.glb", words, "\"source\":0",
                    "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0,\"texCoord\":1}}"),
       "TEXCOORD_1"}};
  for (const auto& [file, fault] : files) {
    const Result result = cookFile(file);
    EXPECT_THAT(textureWarnings(result), ElementsAre(AllOf(HasSubstr("material"), HasSubstr("\"skin\""),
                                                           HasSubstr("base colour"), HasSubstr(fault))))
        << file;
    EXPECT_TRUE(result.asset.view().base_maps.empty()) << file;
    EXPECT_EQ(result.asset.view().parts[0].base_maps, kAbsent) << file;
  }
  EXPECT_THAT(importedFiles(missing), ElementsAre(missing));
}

TEST(BaseMaps, ATransformIsKept) {
  Square square;
  const std::string image = square.embedded(fileOf(quadrants(3), "png"));
  const Result result = cookFile(square.write(
      "transform.glb", image, "\"source\":0",
      "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0,\"extensions\":{\"KHR_texture_transform\":"
      "{"
      "\"offset\":[0.25,0.5],\"rotation\":1.5707963267948966,\"scale\":[2,3]}}}}",
      ",\"extensionsRequired\":[\"KHR_texture_transform\"],\"extensionsUsed\":[\"KHR_texture_transform\"]"));
  EXPECT_THAT(textureWarnings(result), IsEmpty());
  // A quarter turn counter-clockwise as seen, v down: (u, v) -> (v, -u).
  const std::array<float, 6> expected = {0, -2, 3, 0, 0.25f, 0.5f};
  for (size_t i = 0; i < 6; ++i) EXPECT_NEAR(mapsOf(result).color_uv[i], expected[i], 1e-6f) << i;
}

TEST(BaseMaps, WhatIsBeyondTheBordersIsKept) {
  Square square;
  const std::string image = square.embedded(fileOf(quadrants(3), "png"));
  const auto cooked = [&](const std::string& texture, const std::string& samplers) {
    return cookFile(square.write("wrap.glb", image, "\"source\":0" + texture, kColor, samplers));
  };
  const Result each =
      cooked(",\"sampler\":1", ",\"samplers\":[{},{\"wrapS\":33071,\"wrapT\":33648,\"magFilter\":9728}]");
  EXPECT_EQ(mapsOf(each).color_wrap[0], Wrap::kClamp);
  EXPECT_EQ(mapsOf(each).color_wrap[1], Wrap::kMirror);
  EXPECT_EQ(mapsOf(each).normal_wrap[0], Wrap::kRepeat);
  // What is not said, or not one of glTF's ways, repeats.
  for (const auto& [texture, samplers] :
       {std::pair("", ""),
        {",\"sampler\":0", ",\"samplers\":[{}]"},
        {",\"sampler\":7", ",\"samplers\":[{\"wrapS\":33071}]"},
        {",\"sampler\":0", ",\"samplers\":[{\"wrapS\":\"33071\",\"wrapT\":10496}]"}})
    for (const Wrap wrap : mapsOf(cooked(texture, samplers)).color_wrap) EXPECT_EQ(wrap, Wrap::kRepeat);
}

TEST(BaseMaps, TexelsAreFoundBeyondTheBorders) {
  for (const auto& [at, repeated, mirrored, clamped] : {std::array{0.25f, 0.25f, 0.25f, 0.25f},
                                                        {1.25f, 0.25f, 0.75f, 1.0f},
                                                        {2.25f, 0.25f, 0.25f, 1.0f},
                                                        {-0.25f, 0.75f, 0.25f, 0.0f},
                                                        {-1.25f, 0.75f, 0.75f, 0.0f}}) {
    EXPECT_EQ(wrapped(Wrap::kRepeat, at), repeated) << at;
    EXPECT_EQ(wrapped(Wrap::kMirror, at), mirrored) << at;
    EXPECT_EQ(wrapped(Wrap::kClamp, at), clamped) << at;
  }
}

TEST(BaseMaps, OlderMaterialsHaveTheirColoursElsewhere) {
  Square square;
  const std::string image = square.embedded(fileOf(quadrants(3), "png"));
  const Result result = cookFile(square.write(
      "glossy.glb", image, "\"source\":0",
      "\"alphaMode\":\"BLEND\",\"extensions\":{\"KHR_materials_pbrSpecularGlossiness\":{\"diffuseFactor\":[1,"
      "0.5,1,0.25],"
      "\"diffuseTexture\":{\"index\":0,\"extensions\":{\"KHR_texture_transform\":{\"offset\":[0.5,0]}}}}}",
      ",\"extensionsUsed\":[\"KHR_materials_pbrSpecularGlossiness\"]"));
  EXPECT_THAT(textureWarnings(result), IsEmpty());
  expectQuadrants(result.asset, 0.012);
  EXPECT_EQ(mapsOf(result).color_uv[4], 0.5f);
  EXPECT_EQ(result.asset.view().parts[0].base_color.y, 0.5f);
  EXPECT_EQ(result.asset.view().parts[0].base_color.w, 0.25f);
  const Result plain = cookFile(square.write(
      "glossy.glb", image, "\"source\":0",
      "\"extensions\":{\"KHR_materials_pbrSpecularGlossiness\":{\"diffuseTexture\":{\"index\":0}}}"));
  EXPECT_EQ(mapsOf(plain).color_uv[4], 0.0f);
  const Result bare =
      cookFile(square.write("glossy.glb", image, "\"source\":0",
                            "\"extensions\":{\"KHR_materials_pbrSpecularGlossiness\":{\"diffuseTexture\":[],"
                            "\"diffuseFactor\":7}}"));
  EXPECT_TRUE(bare.asset.view().base_maps.empty());
  EXPECT_EQ(bare.asset.view().parts[0].base_color.y, 1.0f);

  const std::vector<uint8_t> png = fileOf(quadrants(3), "png");
  const fs::path beside = writeFile("glossy.png", std::string(png.begin(), png.end()));
  const fs::path file = square.write(
      "glossy.glb", "\"uri\":\"glossy.png\"", "\"source\":0",
      "\"extensions\":{\"KHR_materials_pbrSpecularGlossiness\":{\"diffuseTexture\":{\"index\":0}}}");
  EXPECT_THAT(cookFile(file).cooked.dependencies, ElementsAre(file, beside));
  EXPECT_THAT(importedFiles(file), ElementsAre(file, beside));
}

TEST(BaseMaps, TheirSizeHasALimitAndNoneCanBeKept) {
  Square square;
  const fs::path file =
      square.write("size.glb", square.embedded(fileOf(quadrants(3), "png")), "\"source\":0", kColor);
  const Result small = cookFile(file, 8), none = cookFile(file, 0);
  expectQuadrants(small.asset, 0.012);
  EXPECT_EQ(small.asset.view().base_maps[0].color.width, 8u);
  EXPECT_TRUE(none.asset.view().base_maps.empty());
  EXPECT_LT(none.cooked.bytes.size(), small.cooked.bytes.size());
  EXPECT_THAT(small.cooked.report.textures, Contains(::testing::Field(&TextureReport::own, true)));
  EXPECT_THAT(none.cooked.report.textures, Not(Contains(::testing::Field(&TextureReport::own, true))));
}

TEST(BaseMaps, OpacityCountsWhereTheMaterialSaysSo) {
  std::array<Color, 4> colors = kQuadrants;
  colors[0][3] = 0;
  colors[1][3] = 128;
  Square square;
  const std::string image = square.embedded(fileOf(quadrants(4, colors), "png"));
  const Result masked = cookFile(square.write("mask.glb", image, "\"source\":0",
                                              kColor + ",\"alphaMode\":\"MASK\",\"alphaCutoff\":0.25"));
  const BaseMaps maps = mapsOf(masked);
  EXPECT_EQ(maps.opaque_from, 0.25f);
  ASSERT_EQ(maps.color.format, TextureFormat::kBc3);
  EXPECT_NEAR(texelAt(maps.color, 0, 0, 8, 8).w, 0.0f, 0.01f);
  EXPECT_NEAR(texelAt(maps.color, 0, 0, 24, 8).w, 128 / 255.0f, 0.01f);
  const Result opaque = cookFile(square.write("opaque.glb", image, "\"source\":0", kColor));
  EXPECT_EQ(mapsOf(opaque).color.format, TextureFormat::kBc1);
  EXPECT_EQ(mapsOf(opaque).opaque_from, 0.0f);
}

TEST(BaseMaps, TheFactorsOpacityCountsWhereTheMaterialSaysSo) {
  struct Case {
    const char* mode;
    float opacity, seen, opaque_from;  // of the factor, then of the part and its map
  };
  for (const auto& [mode, factor, seen, opaque_from] :
       {Case{"\"alphaMode\":\"BLEND\"", 0.25f, 0.25f, kBlendCutoff * 0.25f},
        {"\"alphaMode\":\"BLEND\"", 1.0f, 1.0f, kBlendCutoff},
        {"\"alphaMode\":\"BLEND\"", 0.0f, 0.0f, 0.0f},
        {"\"alphaMode\":\"MASK\"", 0.75f, 1.0f, 0.5f / 0.75f},
        {"\"alphaMode\":\"MASK\"", 0.25f, 0.0f, 0.0f},
        {"\"alphaMode\":\"OPAQUE\"", 0.25f, 1.0f, 0.0f}}) {
    for (const bool textured : {false, true}) {
      Square square;
      const std::string image = square.embedded(fileOf(quadrants(4), "png"));
      const Result result = cookFile(
          square.write("factor.glb", image, "\"source\":0",
                       "\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,1," + std::to_string(factor) +
                           "]" + (textured ? ",\"baseColorTexture\":{\"index\":0}" : "") + "}," + mode));
      EXPECT_EQ(result.asset.view().parts[0].base_color.w, seen) << mode << factor;
      if (!textured) continue;
      EXPECT_NEAR(mapsOf(result).opaque_from, opaque_from, 1e-6f) << mode << factor;
    }
  }
}

TEST(BaseMaps, WhatTheRecipeHidesIsNotSeen) {
  Square square;
  const fs::path file =
      square.write("hidden.glb", square.embedded(fileOf(quadrants(4), "png")), "\"source\":0",
                   "\"alphaMode\":\"BLEND\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,1,0.25]}");
  CookMemory memory;
  const auto opacity = [&](const std::vector<std::string>& hidden) {
    Recipe recipe = defaultRecipe();
    recipe.hidden = hidden;
    CookOptions options;
    options.memory = &memory;
    Asset asset;
    EXPECT_TRUE(asset.load(cook(import(file), recipe, options).bytes).ok());
    return asset.view().parts[0].base_color.w;
  };
  EXPECT_EQ(opacity({"mesh 0"}), 0.0f);
  EXPECT_EQ(opacity({"skin"}), 0.0f);
  EXPECT_EQ(opacity({}), 0.25f);
  try {
    opacity({"skim"});
    ADD_FAILURE() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.exit(), Exit::kBadData);
    EXPECT_EQ(error.what(),
              file.string() + ": hidden: there is no mesh or material \"skim\": the file has: mesh 0, skin");
  }
}

// ---- OBJ ----

void writeBytes(const fs::path& file, const std::vector<uint8_t>& bytes) {
  fs::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

// A square of the material "skin", in a folder of its own.
class ObjSquare {
 public:
  ObjSquare() { writeBytes(path("textures/skin color.png"), fileOf(quadrants(3), "png")); }

  fs::path path(const std::string& name) const { return folder_.path() / name; }
  fs::path write(const std::string& libraries = "mtllib square.mtl\n") const {
    return text("square.obj", libraries +
                                  "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
                                  "usemtl skin\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n");
  }
  fs::path text(const std::string& name, const std::string& words) const {
    writeBytes(path(name), {words.begin(), words.end()});
    return path(name);
  }

 private:
  test::ScratchFolder folder_;
};

TEST(ObjMaterials, ImagesAreFoundAsToolsNameThem) {
  const ObjSquare square;
  const fs::path obj = square.write();
  writeBytes(square.path("textures/skin.tga"), fileOf(quadrants(3), "tga"));
  writeBytes(square.path("near.png"), fileOf(quadrants(3), "png"));
  for (const char* name :
       {"textures/skin color.png", "textures\\skin color.png", "\"textures/skin color.png\"",
        "-s 1 1 1 -o 0 0 textures/skin color.png", "-blendu on -mm 0 1 -imfchan m textures/skin color.png",
        "C:\\project\\near.png", "/nowhere/near.png", "textures/skin.tga"}) {
    square.text("square.mtl",
                std::string("# a tool\r\nnewmtl skin\r\nKd 0 0 0\r\n  map_Kd ") + name + "  \r\n");
    const Result result = cookFile(obj);
    EXPECT_THAT(textureWarnings(result), IsEmpty()) << name;
    expectQuadrants(result.asset, 0.012);
    EXPECT_EQ(result.asset.view().parts[0].base_color.x, 1.0f);
    EXPECT_THAT(result.cooked.dependencies, testing::SizeIs(3));
    EXPECT_THAT(importedFiles(obj), testing::UnorderedElementsAreArray(result.cooked.dependencies));
  }
  // The first frame of a sequence shows its materials, too.
  CookRequest request;
  request.source.pattern = square.path("*.obj");
  EXPECT_THAT(filesOf(request),
              ElementsAre(obj, square.path("square.mtl"), square.path("textures/skin.tga")));
}

TEST(ObjMaterials, ColoursNormalsAndPlacementAreKept) {
  const ObjSquare square;
  std::array<Color, 4> tilted;
  tilted.fill({204, 128, 230, 255});
  writeBytes(square.path("bump.png"), fileOf(quadrants(3, tilted), "png"));
  square.text(
      "skin.mtl",
      "newmtl other\nKd 1 0 0\nnewmtl skin\nPr 0.25\nmap_Kd -s 2 3 -o 0.25 0.5 textures/skin color.png\n"
      "map_Bump -bm 0.5 bump.png\n");
  const Result result = cookFile(square.write("mtllib lost.mtl skin.mtl\n"));
  const BaseMaps maps = mapsOf(result);
  EXPECT_EQ(result.asset.view().parts[0].roughness, 0.25f);
  // Theirs puts (u, v) at (2 u + 0.25, 3 v + 0.5), from the bottom.
  const std::array<float, 6> expected = {2, 0, 0, 3, 0.25f, -2.5f};
  for (size_t i = 0; i < 6; ++i) EXPECT_NEAR(maps.color_uv[i], expected[i], 1e-6f) << i;
  EXPECT_NEAR(texelAt(maps.normal, 0, 0, 1, 1).x * 2 - 1, 0.3 / std::sqrt(0.3 * 0.3 + 0.8 * 0.8), 0.01);
  EXPECT_THAT(result.cooked.report.warnings, Contains(HasSubstr("lost.mtl: no such file")));

  square.text("skin.mtl", "newmtl skin\nKd 0.5 0.25 0\nnorm textures/skin color.png\nbump bump.png\n");
  const Result plain = cookFile(square.write("mtllib skin.mtl\n"));
  EXPECT_EQ(plain.asset.view().parts[0].base_color.y, 0.25f);
  EXPECT_EQ(mapsOf(plain).color.slices, 0u);
  EXPECT_LT(texelAt(mapsOf(plain).normal, 0, 0, 1, 17).x, 0.4f);  // "norm" counts where both stand
}

TEST(ObjMaterials, HairIsCutOutWhereItsImageSaysSo) {
  const ObjSquare square;
  std::array<Color, 4> colors = kQuadrants;
  colors[0][3] = 0;
  writeBytes(square.path("hair.png"), fileOf(quadrants(4, colors), "png"));
  for (const char* lines :
       {"map_Kd hair.png\nmap_d -imfchan m hair.png\n", "map_d hair.png\nmap_Kd hair.png\n"}) {
    square.text("square.mtl", std::string("newmtl other\nmap_Kd hair.png\nnewmtl skin\n") + lines);
    const Result result = cookFile(square.write());
    EXPECT_GT(mapsOf(result).opaque_from, 0.0f);
    EXPECT_EQ(mapsOf(result).color.format, TextureFormat::kBc3);
  }
}

TEST(ObjMaterials, OpacityMayBeAnImageOfItsOwn) {
  const ObjSquare square;
  std::array<Color, 4> greys = {
      {{0, 0, 0, 255}, {255, 255, 255, 255}, {128, 128, 128, 255}, {255, 255, 255, 255}}};
  writeBytes(square.path("grey.png"), fileOf(quadrants(1, greys), "png"));
  for (Color& color : greys) color = {9, 9, 9, color[0]};
  writeBytes(square.path("alpha.png"), fileOf(quadrants(4, greys), "png"));
  for (const char* lines :
       {"map_Kd textures/skin color.png\nmap_d grey.png\n",
        "map_d alpha.png\nmap_Kd textures/skin color.png\n", "Kd 0.5 0.25 1\nmap_d grey.png\n"}) {
    const bool colored = std::string(lines).find("map_Kd") != std::string::npos;
    square.text("square.mtl", std::string("newmtl skin\n") + lines);
    const fs::path obj = square.write();
    const Result result = cookFile(obj);
    EXPECT_THAT(textureWarnings(result), IsEmpty()) << lines;
    const BaseMaps maps = mapsOf(result);
    EXPECT_EQ(maps.opaque_from, kBlendCutoff);
    ASSERT_EQ(maps.color.format, TextureFormat::kBc3);
    EXPECT_NEAR(texelAt(maps.color, 0, 0, 8, 8).w, 0.0f, 0.01f);
    EXPECT_NEAR(texelAt(maps.color, 0, 0, 24, 8).w, 1.0f, 0.01f);
    EXPECT_NEAR(texelAt(maps.color, 0, 0, 8, 24).w, 0.5f, 0.02f);
    EXPECT_NEAR(texelAt(maps.color, 0, 0, 24, 8).y, colored ? kQuadrants[1][1] / 255.0 : 1.0, 0.02);
    EXPECT_EQ(result.asset.view().parts[0].base_color.y, colored ? 1.0f : 0.25f);
    EXPECT_THAT(importedFiles(obj), testing::UnorderedElementsAreArray(result.cooked.dependencies));
  }
  for (const auto& [lines, fault] :
       {std::pair("map_Kd -s 2 2 textures/skin color.png\nmap_d grey.png\n", "not placed as its colour"),
        {"map_Kd textures/skin color.png\nmap_d lost.png\n", "lost.png: no such file"}}) {
    square.text("square.mtl", std::string("newmtl skin\n") + lines);
    const Result result = cookFile(square.write());
    EXPECT_THAT(textureWarnings(result),
                ElementsAre(AllOf(HasSubstr("material \"skin\""), HasSubstr("opacity"), HasSubstr(fault))));
    EXPECT_EQ(mapsOf(result).color.format, TextureFormat::kBc1);
  }
}

TEST(ObjMaterials, WhatIsSeenThroughIsInTheMaterialToo) {
  const ObjSquare square;
  for (const auto& [line, opacity] : {std::pair("d 0.25", 0.25f),
                                      {"Tr 0.75", 0.25f},
                                      {"d 1", 1.0f},
                                      {"d 0", 1.0f},
                                      {"Tr 1", 1.0f},
                                      {"d -halo 0.5", 1.0f},
                                      {"d 0.5\nmap_Kd textures/skin color.png", 0.5f}}) {
    square.text("square.mtl", std::string("newmtl other\nd 0.1\nnewmtl skin\n") + line + "\n");
    EXPECT_EQ(cookFile(square.write()).asset.view().parts[0].base_color.w, opacity) << line;
  }
}

TEST(ObjMaterials, ImagesMayEndAtTheirBorders) {
  const ObjSquare square;
  square.text("square.mtl", "newmtl skin\nmap_Kd -clamp on textures/skin color.png\n");
  for (const Wrap wrap : mapsOf(cookFile(square.write())).color_wrap) EXPECT_EQ(wrap, Wrap::kClamp);
  square.text("square.mtl", "newmtl skin\nmap_Kd -clamp off textures/skin color.png\n");
  for (const Wrap wrap : mapsOf(cookFile(square.write())).color_wrap) EXPECT_EQ(wrap, Wrap::kRepeat);
}

TEST(PlyTextures, TheImageOfAScanIsShown) {
  const ObjSquare square;
  const auto write = [&](const std::string& comments) {
    return square.text("scan.ply",
                       "ply\nformat ascii 1.0\ncomment made by a scanner\n" + comments +
                           "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                           "property float s\nproperty float t\nelement face 2\n"
                           "property list uchar int vertex_indices\nend_header\n0 0 0 0 0\n1 0 0 1 0\n"
                           "1 1 0 1 1\n0 1 0 0 1\n3 0 1 2\n3 0 2 3\n");
  };
  const fs::path file = write("comment TextureFile textures/skin color.png \r\n");
  const Result result = cookFile(file);
  EXPECT_THAT(textureWarnings(result), IsEmpty());
  expectQuadrants(result.asset, 0.012);
  EXPECT_THAT(importedFiles(file), testing::UnorderedElementsAreArray(result.cooked.dependencies));
  EXPECT_THAT(textureWarnings(cookFile(write("comment TextureFile lost.png\n"))),
              ElementsAre(HasSubstr("lost.png: no such file")));
  EXPECT_THAT(textureWarnings(cookFile(write("comment TextureFile a.png\ncomment TextureFile b.png\n"))),
              ElementsAre(HasSubstr("2 textures, \"a.png\" and others")));
}

TEST(ObjMaterials, WhatIsMissingOrDamagedCostsAWarning) {
  const ObjSquare square;
  writeBytes(square.path("grey.png"), fileOf(quadrants(3, {Color{9, 9, 9, 255}, {99, 99, 99, 255}}), "png"));
  const std::vector<std::pair<std::string, std::string>> files = {
      {"newmtl skin\nmap_Kd -s 1 nowhere.png\n", "nowhere.png: no such file"},
      {"newmtl skin\nmap_Kd square.mtl\n", "square.mtl: it cannot be read as an image"},
      {"newmtl skin\nmap_Kd textures\n", "textures: is a directory"},
      {"newmtl skin\nbump grey.png\n", "grey.png: it is grey, as height maps are"}};
  for (const auto& [mtl, fault] : files) {
    square.text("square.mtl", mtl);
    const Result result = cookFile(square.write());
    EXPECT_THAT(textureWarnings(result),
                ElementsAre(AllOf(HasSubstr("material \"skin\""), HasSubstr(fault))));
    EXPECT_TRUE(result.asset.view().base_maps.empty());
  }
  for (const char* harmless :
       {"map_Kd a.png\n", "newmtl\nmap_Kd\nnewmtl skin\nmap_Kd\nmap_Kd -s\nKd\nKd nan x 1e99\n",
        "newmtl skin\nmap_Kd -s 1 1 1\nmap_Kd -bm -bm\nmap_Kd -\n", "", "\0\xff\n"}) {
    square.text("square.mtl", harmless);
    const Result result = cookFile(square.write());
    EXPECT_THAT(textureWarnings(result), IsEmpty()) << harmless;
  }
  for (const char* libraries : {"mtllib lost.mtl\n", "mtllib textures\n", "mtllib C:\\lost.mtl\n"})
    EXPECT_THAT(cookFile(square.write(libraries)).cooked.report.warnings,
                Contains(HasSubstr("its materials are shown without colours")))
        << libraries;
  EXPECT_THAT(cookFile(square.write("mtllib\n")).cooked.report.warnings,
              Not(Contains(HasSubstr("materials"))));
}

// OpenImageIO multiplies WebP's colours by their opacity.
TEST(BaseMaps, WebpThatIsSeenThroughKeepsItsColours) {
  // 32 x 32 texels of (40, 160, 60, 127), lossless, by libwebp.
  constexpr uint8_t kFile[] = {0x52, 0x49, 0x46, 0x46, 0x1e, 0x00, 0x00, 0x00, 0x57, 0x45, 0x42, 0x50, 0x56,
                               0x50, 0x38, 0x4c, 0x11, 0x00, 0x00, 0x00, 0x2f, 0x1f, 0xc0, 0x07, 0x10, 0x07,
                               0x50, 0xd0, 0xa2, 0x94, 0xa7, 0x7f, 0x81, 0x88, 0xe8, 0x7f, 0x00, 0x00};
  const ByteImage image = readByteImage(kFile, "image");
  ASSERT_EQ(image.pixels.size(), size_t{32} * 32 * 4);
  for (size_t i = 0; i < image.pixels.size(); i += 4) {
    EXPECT_NEAR(image.pixels[i], 40, 1);
    EXPECT_NEAR(image.pixels[i + 1], 160, 1);
    EXPECT_NEAR(image.pixels[i + 2], 60, 1);
    EXPECT_EQ(image.pixels[i + 3], 127);
  }
}

TEST(BaseMaps, TexturesArePackedInTheFile) {
  Square square;
  const Result result = cookFile(
      square.write("packed.glb", square.embedded(fileOf(quadrants(3), "png")), "\"source\":0", kColor));
  const AssetView& view = result.asset.view();
  const SectionBytes packed = sectionBytes(result.cooked.bytes);
  size_t maps = 0;
  for (const TextureSet& set : view.texture_sets)
    maps += set.normals.data.size() + set.shading.data.size() + set.masks.data.size();
  EXPECT_GT(packed.own_maps, 0u);
  EXPECT_LT(packed.own_maps, view.base_maps[0].color.data.size());
  EXPECT_GT(packed.maps, 0u);
  EXPECT_LT(packed.maps, maps / 2);
  EXPECT_GT(packed.geometry, 0u);
  EXPECT_EQ(packed.morphs, 0u);
  EXPECT_GT(packed.layers, 0u);
  EXPECT_EQ(packed.place_hash, view.place_hash.size());
  EXPECT_EQ(packed.rig, view.rig.size());
  const size_t sum =
      packed.geometry + packed.layers + packed.maps + packed.own_maps + packed.place_hash + packed.rig;
  EXPECT_LT(sum, result.cooked.bytes.size());
  EXPECT_GT(sum + 4000, result.cooked.bytes.size());  // names and numbers
}

TEST(BaseMaps, ANormalMapIsScaledAndStaysUnit) {
  std::array<Color, 4> tilted;
  tilted.fill({204, 128, 230, 255});  // (0.6, 0, 0.8)
  Square square;
  const std::string image = square.embedded(fileOf(quadrants(3, tilted), "png"));
  const Result result = cookFile(
      square.write("normal.glb", image, "\"source\":0", "\"normalTexture\":{\"index\":0,\"scale\":0.5}"));
  const Texture normal = mapsOf(result).normal;
  ASSERT_EQ(normal.format, TextureFormat::kBc5);
  for (const uint32_t level : {0u, 3u}) {
    const Float4 texel = texelAt(normal, level, 0, 1, 1);
    EXPECT_NEAR(texel.x * 2 - 1, 0.3 / std::sqrt(0.3 * 0.3 + 0.8 * 0.8), 0.01) << level;
    EXPECT_NEAR(texel.y * 2 - 1, 0.0, 0.01) << level;
  }
}

TEST(BaseMaps, AScaleBeyondFloatsLeavesNormalsThatAreNumbers) {
  std::array<Color, 4> tilted;
  tilted.fill({204, 128, 230, 255});
  Square square;
  const std::string image = square.embedded(fileOf(quadrants(3, tilted), "png"));
  for (const auto& [scale, x] : {std::pair("1e30", 1.0), {"1e300", 0.6}}) {
    const Result result =
        cookFile(square.write("steep.glb", image, "\"source\":0",
                              std::string("\"normalTexture\":{\"index\":0,\"scale\":") + scale + "}"));
    EXPECT_NEAR(texelAt(mapsOf(result).normal, 0, 0, 1, 1).x * 2 - 1, x, 0.01) << scale;
  }
}

// Every other texel is `a`.
ByteImage board(const Color& a, const Color& b, uint32_t channels) {
  ByteImage image{4, 4, channels, {}};
  for (uint32_t i = 0; i < 16; ++i) {
    const Color& color = (i / 4 + i) % 2 == 0 ? a : b;
    image.pixels.insert(image.pixels.end(), color.begin(), color.begin() + channels);
  }
  return image;
}

TEST(EncodeColor, SmallerLevelsAreMeansOfLight) {
  const EncodedTexture texture = encodeColor(board({255, 255, 255, 255}, {0, 0, 0, 255}, 3), true, 1024);
  EXPECT_EQ(texture.format, TextureFormat::kBc1);
  ASSERT_EQ(texture.levels, 3u);
  EXPECT_NEAR(texture.largest_error, 0.0, 1e-6);
  for (const uint32_t level : {1u, 2u})
    EXPECT_NEAR(texelAt(viewOf(texture), level, 0, 0, 0).y, 188 / 255.0, 0.01) << level;  // half the light
}

TEST(EncodeColor, WhatIsNotSeenHasNoColour) {
  const EncodedTexture texture = encodeColor(board({0, 255, 0, 0}, {200, 0, 0, 255}, 4), true, 1024);
  ASSERT_EQ(texture.format, TextureFormat::kBc3);
  const Float4 mean = texelAt(viewOf(texture), 1, 0, 0, 0);
  EXPECT_NEAR(mean.x, 200 / 255.0, 0.02);
  EXPECT_NEAR(mean.y, 0.0, 0.02);
  EXPECT_NEAR(mean.w, 0.5, 0.01);
}

TEST(EncodeColor, ErrorsAreMeasured) {
  ByteImage noise{64, 64, 3, {}};
  uint32_t state = 1;
  for (size_t i = 0; i < size_t{64} * 64 * 3; ++i)
    noise.pixels.push_back(static_cast<uint8_t>((state = state * 1664525u + 1013904223u) >> 24));
  const EncodedTexture texture = encodeColor(noise, false, 1024);
  double squares = 0.0, most = 0.0;
  for (uint32_t y = 0; y < 64; ++y)
    for (uint32_t x = 0; x < 64; ++x) {
      const Float4 texel = texelAt(viewOf(texture), 0, 0, x, y);
      const std::array<float, 3> found = {texel.x, texel.y, texel.z};
      for (uint32_t c = 0; c < 3; ++c) {
        const double error = std::abs(double{found[c]} - noise.at(x, y)[c] / 255.0);
        squares += error * error;
        most = std::max(most, error);
      }
    }
  EXPECT_GT(most, 0.1);
  EXPECT_NEAR(texture.rms_error, std::sqrt(squares / (64 * 64 * 3)), 1e-6);
  EXPECT_NEAR(texture.largest_error, most, 1e-6);
  // The same bytes from any number of threads.
  EXPECT_EQ(encodeColor(noise, false, 1024, 4).data, texture.data);
}

TEST(EncodeColor, AnySize) {
  for (const auto& [width, height] : {std::pair{1u, 1u}, {3u, 7u}, {17u, 2u}}) {
    const ByteImage image{width, height, 1, std::vector<uint8_t>(size_t{width} * height, 99)};
    const EncodedTexture texture = encodeColor(image, false, 16);
    EXPECT_LE(std::max(texture.width, texture.height), 16u);
    size_t bytes = 0;
    for (uint32_t level = 0; level < texture.levels; ++level)
      bytes += textureLevelBytes(texture.format, texture.width, texture.height, level);
    EXPECT_EQ(texture.data.size(), bytes);
    EXPECT_NEAR(texelAt(viewOf(texture), texture.levels - 1, 0, 0, 0).z, 99 / 255.0, 0.01);
  }
}

}  // namespace
}  // namespace furrow::pipeline
