#include "pipeline/cook/map_bake.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "pipeline/bake/tangents.h"
#include "tests/unit/texture_decoder.h"

namespace furrow::pipeline {
namespace {

constexpr uint32_t kCells = 64;

// A unit sheet in z = 0 whose UVs fill the unit square, shifted by `shift`; every layer's d is +x.
struct Sheet {
  SourceScene scene;
  Surface surface;
  std::vector<uint32_t> source_vertex;
  Squeeze squeeze;
  MaskImages masks;
  Recipe recipe;
  std::vector<BakedLayer> layers;
  std::vector<std::filesystem::path> dependencies;
  std::vector<std::string> warnings;
  Patterns known;

  explicit Sheet(float shift = 0.0f) {
    scene.parts.resize(1);
    for (uint32_t i = 0; i <= kCells * (kCells + 2); ++i) {
      const uint32_t row = i / (kCells + 1), column = i % (kCells + 1);
      if (row > kCells) break;
      const float u = static_cast<float>(column) / kCells, v = static_cast<float>(row) / kCells;
      surface.positions.emplace_back(u, 1.0f - v, 0.0f);
      surface.normals.emplace_back(0, 0, 1);
      surface.uvs.emplace_back(u + shift, v);
      surface.vertex_point.push_back(i);
      if (row < kCells && column < kCells) {
        const uint32_t below = i + kCells + 1;
        surface.triangles.emplace_back(i, below, i + 1);
        surface.triangles.emplace_back(i + 1, below, below + 1);
      }
    }
    surface.point_positions = surface.positions;
    surface.point_normals = surface.normals;
    surface.tangents = tangents(surface.positions, surface.normals, surface.uvs, surface.triangles);
    SurfacePart part;
    part.vertex_end = static_cast<uint32_t>(surface.positions.size());
    part.triangle_end = static_cast<uint32_t>(surface.triangles.size());
    part.has_uvs = true;
    surface.parts = {part};
    squeeze.peak.assign(surface.triangles.size(), 0.0f);
    squeeze.by_morph.assign(surface.triangles.size(), 0);
  }

  // A synthesised layer that reaches the points where `reaches(x, y)`.
  template <class Reaches>
  void add(const Reaches& reaches, double spacing) {
    LayerRecipe layer;
    layer.name = "layer " + std::to_string(layers.size());
    MapSynthesized map;
    map.preset = Preset::kSkin;
    map.spacing = spacing;
    map.depth = spacing / 8.0;
    layer.compress = map;
    recipe.layers.push_back(layer);
    BakedLayer baked;
    baked.covered.assign(surface.triangles.size(), true);
    for (const glm::vec3& p : surface.point_positions) {
      baked.field.direction.emplace_back(1, 0, 0);
      baked.field.confidence.push_back(1.0f);
      baked.field.strength.push_back(reaches(p.x, p.y) ? 1.0f : 0.0f);
    }
    layers.push_back(std::move(baked));
  }

  std::vector<BakedTextureSet> bakeAll(uint32_t threads = 2) {
    return bakeMaps({scene, surface, source_vertex, squeeze, masks, {}, "recipe.json"}, recipe, layers,
                    threads, dependencies, warnings, known);
  }
  BakedTextureSet bake(uint32_t threads = 2) {
    auto sets = bakeAll(threads);
    EXPECT_EQ(sets.size(), 1u);
    return std::move(sets.at(0));
  }
};

const auto kEverywhere = [](float, float) { return true; };

// The texel of a slice that shows a place of UV space, as shaders find it; none beside the window.
const float* texelAt(const BakedTextureSet& set, const Image& image, uint32_t slice, glm::vec2 uv) {
  const glm::vec4 window = set.windows.at(slice);
  const glm::vec2 at = glm::vec2(glm::fract(uv - glm::vec2(window))) * glm::vec2(window.z, window.w);
  if (std::max(at.x, at.y) >= 1.0f) return nullptr;
  return image.at(static_cast<uint32_t>(at.x * static_cast<float>(image.width)),
                  static_cast<uint32_t>(at.y * static_cast<float>(image.height)));
}

TEST(MapBake, ALayerThatReachesEverythingHasTheWholeOfUvSpace) {
  Sheet sheet;
  sheet.add(kEverywhere, 0.1);
  const BakedTextureSet set = sheet.bake();
  EXPECT_EQ(set.windows.at(0), glm::vec4(0, 0, 1, 1));
  EXPECT_EQ(set.normals.width, 128u);  // 12 texels a spacing, in steps of 64
  EXPECT_EQ(set.normals.height, 128u);
  EXPECT_EQ(set.masks.width, 512u);
}

// Drawing charts that nothing shows on was most of the time of a head with hair and a shirt.
TEST(MapBake, OverlappingUvsAreSaid) {
  Sheet sheet;
  sheet.add(kEverywhere, 0.1);
  sheet.bake();
  EXPECT_TRUE(sheet.warnings.empty());
  // Folded in the middle: the second half lies on the first; of the texels at the fold each has a part.
  for (glm::vec2& uv : sheet.surface.uvs) uv.x = std::min(uv.x, 1.0f - uv.x);
  sheet.bake();
  ASSERT_EQ(sheet.warnings.size(), 1u);
  EXPECT_NE(sheet.warnings[0].find("overlap: 49%"), std::string::npos) << sheet.warnings[0];
}

TEST(MapBake, UvsThatLieInOnePointAreSaid) {
  Sheet sheet;
  sheet.add(kEverywhere, 0.1);
  sheet.surface.uvs.assign(sheet.surface.uvs.size(), glm::vec2(0.5f));
  EXPECT_EQ(sheet.bake().normals.slices, 0u);
  ASSERT_EQ(sheet.warnings.size(), 1u);
  EXPECT_NE(sheet.warnings[0].find("have no area"), std::string::npos) << sheet.warnings[0];
}

// Charts of very different scales, as an automatic unwrap leaves them: what is drawn from a few texels are
// shards.
TEST(MapBake, UvsThatLeaveMuchOfALayerWithoutTexelsGetNoMap) {
  // A band of the sheet has all of the UVs but for a hundredth.
  const auto bake = [](float band) {
    Sheet sheet;
    sheet.add(kEverywhere, 0.1);
    sheet.add([](float x, float) { return x < 0.2f; }, 0.1);
    for (glm::vec2& uv : sheet.surface.uvs)
      uv = uv.x < band ? glm::vec2(uv.x * 0.99f / band, uv.y)
                       : glm::vec2(0.99f + 0.01f * (uv.x - band) / (1.0f - band), uv.y);
    BakedTextureSet set = sheet.bake();
    return std::pair(std::move(set), sheet.warnings);
  };
  const auto [uneven, warnings] = bake(0.5f);
  EXPECT_EQ(uneven.compress_slice[0], kAbsent);
  EXPECT_NE(uneven.compress_slice[1], kAbsent);  // lies on the band alone
  EXPECT_EQ(uneven.normals.slices, 1u);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("too uneven for layer \"layer 0\": 50%"), std::string::npos) << warnings[0];

  const auto [even, none] = bake(0.75f);
  EXPECT_NE(even.compress_slice[0], kAbsent);
  EXPECT_TRUE(none.empty());
}

TEST(MapBake, AMaterialThatNoLayerShowsOnHasNoSet) {
  Sheet sheet;
  sheet.add([](float x, float) { return x < 0.5f; }, 0.1);
  const uint32_t half = sheet.surface.parts[0].triangle_end / 2;  // the lower half of the sheet
  SurfacePart lower = sheet.surface.parts[0];
  sheet.surface.parts[0].triangle_end = lower.triangle_begin = half;
  lower.source_part = 1;
  sheet.surface.parts.push_back(lower);
  sheet.scene.parts.resize(2);
  sheet.scene.parts[0].material = 0;
  sheet.scene.parts[1].material = 1;
  EXPECT_EQ(sheet.bakeAll().size(), 2u);
  for (uint32_t t = half; t < lower.triangle_end; ++t) sheet.layers[0].covered[t] = false;
  EXPECT_EQ(sheet.bake().parts, std::vector<uint32_t>{0});
}

// A patch on the border of the unit square: its map is smaller than the whole, goes over the border, has
// every texel that the mask lets through, and shows the same wrinkles there.
TEST(MapBake, AWindowHoldsAllThatItsMaskLetsThrough) {
  for (const float shift : {0.0f, 0.8f}) {
    const auto patch = [](float x, float y) { return std::hypot(x - 0.25f, y - 0.5f) < 0.15f; };
    Sheet small(shift), whole(shift);
    small.add(patch, 0.02);
    whole.add(kEverywhere, 0.02);
    const BakedTextureSet a = small.bake(), b = whole.bake();
    EXPECT_LT(a.normals.width * a.normals.height, b.normals.width * b.normals.height / 4);
    EXPECT_LT(a.normals.data.size() * 3, b.normals.data.size());
    const Image mask = decode(a.masks, 0, 0), normals = decode(a.normals, 0, 0),
                shading = decode(a.shading, 0, 0);
    double relief = 0.0;
    for (uint32_t y = 0; y < mask.height; ++y)
      for (uint32_t x = 0; x < mask.width; ++x) {
        if (mask.at(x, y)[0] == 0.0f) continue;
        const glm::vec2 uv = (glm::vec2(x, y) + 0.5f) / 512.0f;
        const float* texel = texelAt(a, normals, 0, uv);
        ASSERT_TRUE(texel) << uv.x << ' ' << uv.y;
        relief += std::abs(texel[0] - 0.5f);
      }
    EXPECT_GT(relief, 100.0);
  }
}

TEST(MapBake, LayersOfOneSetHaveWindowsOfTheirOwn) {
  Sheet sheet;
  sheet.add([](float x, float) { return x < 0.2f; }, 0.02);
  sheet.add([](float, float y) { return y < 0.2f; }, 0.02);
  sheet.add([](float x, float y) { return std::max(x, y) < 0.0f; }, 0.02);  // nowhere
  const BakedTextureSet set = sheet.bake();
  ASSERT_EQ(set.normals.slices, 2u);
  EXPECT_EQ(set.compress_slice, (std::vector<uint32_t>{0, 1, kAbsent}));
  EXPECT_GT(set.windows[0].z, 3.0f);
  EXPECT_EQ(set.windows[0].w, 1.0f);
  EXPECT_EQ(set.windows[1].z, 1.0f);
  EXPECT_GT(set.windows[1].w, 3.0f);
}

TEST(MapBake, TheSameBytesOnAnyNumberOfThreads) {
  Sheet sheet;
  sheet.add([](float x, float y) { return x * y < 0.2f; }, 0.03);
  const BakedTextureSet one = sheet.bake(1), three = sheet.bake(3);
  EXPECT_EQ(one.normals.data, three.normals.data);
  EXPECT_EQ(one.shading.data, three.shading.data);
  EXPECT_EQ(one.masks.data, three.masks.data);
}

TEST(MapBake, WrinklesAreDeepestWhereTheClipsSqueezeMost) {
  Sheet sheet;
  sheet.add(kEverywhere, 0.05);
  for (size_t t = 0; t < sheet.surface.triangles.size(); ++t)
    sheet.squeeze.peak[t] = sheet.surface.positions[sheet.surface.triangles[t].x].x < 0.5f ? 0.4f : 0.04f;
  sheet.squeeze.any = true;
  const BakedTextureSet set = sheet.bake();
  const Image normals = decode(set.normals, 0, 0);
  double left = 0.0, right = 0.0;
  for (uint32_t y = 0; y < normals.height; ++y)
    for (uint32_t x = 0; x < normals.width; ++x)
      (x < normals.width / 2 ? left : right) += std::abs(normals.at(x, y)[0] - 0.5f);
  EXPECT_GT(left, 3.0 * right);
  EXPECT_GT(right, 0.2 * left);
}

// A body that clips squeeze, with a face: lines of the face's size on both. Without it, folds of the body's.
TEST(MapBake, AFaceSetsTheSpacing) {
  Sheet sheet;
  sheet.add(kEverywhere, 0.0);
  auto& map = std::get<MapSynthesized>(sheet.recipe.layers[0].compress);
  map = {};
  const LayerInput input{sheet.scene, sheet.surface, sheet.source_vertex, sheet.squeeze, sheet.masks,
                         {},          "recipe.json"};
  LayerRecipe body = sheet.recipe.layers[0], whole = body;
  resolveMaps(input, sheet.layers[0], body);
  EXPECT_EQ(std::get<MapSynthesized>(body.compress).preset, Preset::kCloth);
  EXPECT_NEAR(std::get<MapSynthesized>(body.compress).spacing, std::sqrt(2.0) / 36.0, 1e-3);
  for (glm::vec3& p : sheet.surface.point_positions) p.z = std::sqrt(p.x * (1.0f - p.x));
  for (size_t t = 0; t < sheet.surface.triangles.size(); ++t) {
    const glm::vec3 p = sheet.surface.positions[sheet.surface.triangles[t].x];
    sheet.squeeze.by_morph[t] = p.x < 0.1f && p.y > 0.9f;
  }
  resolveMaps(input, sheet.layers[0], whole);
  EXPECT_EQ(std::get<MapSynthesized>(whole.compress).preset, Preset::kSkin);
  EXPECT_LT(std::get<MapSynthesized>(whole.compress).spacing, 0.4 * std::sqrt(2.0) / 36.0);
}

// Nor do morph targets make a face of a flat sheet, such as a flag or a panel of cloth.
TEST(MapBake, AFlatSheetIsClothWhateverMovesIt) {
  Sheet sheet;
  sheet.add([](float x, float) { return x < 0.3f; }, 0.0);
  auto& map = std::get<MapSynthesized>(sheet.recipe.layers[0].compress);
  map = {};
  std::ranges::fill(sheet.squeeze.by_morph, uint8_t{1});
  const LayerInput input{sheet.scene, sheet.surface, sheet.source_vertex, sheet.squeeze, sheet.masks,
                         {},          "recipe.json"};
  LayerRecipe flat = sheet.recipe.layers[0], part = flat;
  resolveMaps(input, sheet.layers[0], flat);
  EXPECT_EQ(std::get<MapSynthesized>(flat.compress).preset, Preset::kCloth);
  // A layer on a flat part of what is not flat, such as a forehead.
  for (glm::vec3& p : sheet.surface.point_positions) {
    if (p.x <= 0.3f) continue;
    const float turn = (p.x - 0.3f) / 0.7f * std::numbers::pi_v<float>;
    p.x = 0.3f + 0.35f * std::sin(turn), p.z = 0.35f * (1.0f - std::cos(turn));
  }
  resolveMaps(input, sheet.layers[0], part);
  EXPECT_EQ(std::get<MapSynthesized>(part.compress).preset, Preset::kSkin);
}

TEST(MapBake, OverlappingUvsAreNotSpokenOfWithoutMaps) {
  Sheet sheet;
  sheet.add(kEverywhere, 0.1);
  for (glm::vec2& uv : sheet.surface.uvs) uv.x = std::abs(uv.x - 0.5f);
  EXPECT_EQ(sheet.bakeAll().size(), 1u);
  EXPECT_EQ(sheet.warnings.size(), 1u);
  sheet.warnings.clear();
  sheet.recipe.layers[0].compress = MapNone{};
  EXPECT_TRUE(sheet.bakeAll().empty());
  EXPECT_TRUE(sheet.warnings.empty());
}

TEST(MapBake, PaintedMasksArriveToTheBitAtTheirSize) {
  Sheet sheet;
  sheet.add(kEverywhere, 0.1);
  sheet.add(kEverywhere, 0.1);
  ByteImage painted{640, 600, 3, {}};
  std::mt19937 random(1);
  for (size_t i = 0; i < size_t{640} * 600 * 3; ++i) painted.pixels.push_back(static_cast<uint8_t>(random()));
  sheet.masks["painted.png"] = painted;
  sheet.recipe.layers[1].mask = MaskTexture{"painted.png", 2};
  const BakedTextureSet set = sheet.bake();
  ASSERT_EQ(set.masks.width, 640u);
  ASSERT_EQ(set.masks.height, 600u);
  for (size_t i = 0; i < size_t{640} * 600; ++i) {
    ASSERT_EQ(static_cast<uint8_t>(set.masks.data[4 * i]), 255);
    ASSERT_EQ(static_cast<uint8_t>(set.masks.data[4 * i + 1]), painted.pixels[3 * i + 2]);
    ASSERT_EQ(static_cast<uint8_t>(set.masks.data[4 * i + 2]), 0);
  }
}

}  // namespace
}  // namespace furrow::pipeline
