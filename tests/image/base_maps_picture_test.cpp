// The model's own maps in pictures.

#include <algorithm>
#include <cmath>

#include "editor/preview/camera.h"
#include "editor/preview/posed_frame.h"
#include "editor/preview/renderer.h"
#include "editor/preview/software_picture.h"
#include "pipeline/cook/cook.h"
#include "pipeline/import/import.h"
#include "pipeline/maps/png.h"
#include "pipeline/scene/posing.h"
#include "tests/image/gl_fixture.h"
#include "tests/unit/textured_square.h"

namespace furrow::tests {
namespace {

using pipeline::ByteImage;
using pipeline::Image;
using preview::RenderOptions;
using preview::Shading;
using preview::Tier;
using test::Color;
using test::kQuadrants;
using test::quadrants;
using test::Square;

constexpr uint32_t kSize = 128;
constexpr float kStep = 1.0f / 255.0f;

struct Model {
  Asset asset;
  preview::PosedFrame frame;
};

std::vector<uint8_t> pngOf(const ByteImage& image) {
  const std::vector<std::byte> png = pipeline::encodePng(image);
  const auto* bytes = reinterpret_cast<const uint8_t*>(png.data());
  return {bytes, bytes + png.size()};
}

Model cookedFile(const std::filesystem::path& file) {
  const pipeline::SourceScene scene = pipeline::import(file);
  pipeline::Recipe recipe = pipeline::defaultRecipe();
  recipe.map_size = 64;
  Model model;
  EXPECT_TRUE(model.asset.load(pipeline::cook(scene, recipe, {}).bytes).ok());
  model.frame = preview::poseFrame(model.asset.view(),
                                   pipeline::evaluate(scene.rig, pipeline::defaultPose(scene.rig)), {}, 1.0f);
  return model;
}

Model cooked(const std::string& material, const ByteImage& image) {
  Square square;
  const std::string embedded = square.embedded(pngOf(image));
  return cookedFile(square.write("picture.glb", embedded, "\"source\":0", material));
}

// A grey square, and before it a small one that has nothing in its texture.
Model blind(const std::string& alpha_mode) {
  test::GltfBuilder builder;
  std::string primitives;
  for (const bool small : {false, true}) {
    const float low = small ? 0.35f : 0.0f, high = small ? 0.65f : 1.0f, z = small ? 0.2f : 0.0f;
    const int positions =
        builder.add<float>({low, low, z, high, low, z, high, high, z, low, high, z}, "VEC3", 3);
    const int uvs = builder.add<float>({0, 1, 1, 1, 1, 0, 0, 0}, "VEC2", 2);
    const int indices = builder.add<uint16_t>({0, 1, 2, 0, 2, 3}, "SCALAR", 1);
    primitives += std::string(small ? "," : "") +
                  "{\"attributes\":{\"POSITION\":" + std::to_string(positions) +
                  ",\"TEXCOORD_0\":" + std::to_string(uvs) + "},\"indices\":" + std::to_string(indices) +
                  ",\"material\":" + std::to_string(small) + "}";
  }
  std::array<Color, 4> colors;
  colors.fill({90, 90, 90, 10});
  const int view = builder.addView(pngOf(quadrants(4, colors)));
  return cookedFile(test::writeFile(
      "blind.glb",
      builder.glb("\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[" + primitives +
                  "]}],\"images\":[{\"bufferView\":" + std::to_string(view) +
                  ",\"mimeType\":\"image/png\"}],\"textures\":[{\"source\":0}],\"materials\":[{"
                  "\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.3,0.3,0.3,1]}},{"
                  "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}},\"alphaMode\":\"" +
                  alpha_mode + "\"}]")));
}

Model painted(const ByteImage& image, const std::string& more = "", const std::string& in_texture = "") {
  return cooked("\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0" + in_texture + "}}" + more,
                image);
}

RenderOptions optionsFor(const Model& model, Tier tier, Shading shading) {
  RenderOptions options;
  options.width = options.height = kSize;
  options.tier = tier;
  options.shading = shading;
  const auto about = [&](int axis) { return static_cast<float>(0.5 - model.frame.origin[axis]); };
  options.camera.target = {about(0), about(1), 0.0f};
  options.camera.distance = 3.0f;
  return options;
}

Image picture(const Model& model, Tier tier, Shading shading) {
  preview::Renderer renderer(model.asset.view());
  return renderer.render(model.frame.input, optionsFor(model, tier, shading));
}

Image softwarePicture(const Model& model) {
  return preview::softwarePicture(model.asset.view(), model.frame.input,
                                  optionsFor(model, Tier::kCpu, Shading::kAlpha), 2);
}

// The middle of a quadrant of the square.
const float* quadrant(const Image& image, uint32_t q) {
  const uint32_t aside = kSize / 8;
  return image.at(kSize / 2 + (q % 2 ? aside : -aside), kSize / 2 + (q / 2 ? aside : -aside));
}

// Each quadrant is of its own colour.
void expectQuadrants(const Image& image) {
  for (uint32_t q = 0; q < 3; ++q) {
    const float* p = quadrant(image, q);
    const float others = std::max(p[(q + 1) % 3], p[(q + 2) % 3]);
    EXPECT_GT(p[q], others + 0.1f) << q;
  }
}

void expectNear(const float* a, const float* b, float tolerance) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], tolerance) << c;
}

// The square in that colour, by its material's factor alone.
Model plain(const Color& color) {
  const auto linear = [](uint8_t byte) {
    const double c = byte / 255.0;
    return std::to_string(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
  };
  return cooked("\"pbrMetallicRoughness\":{\"baseColorFactor\":[" + linear(color[0]) + "," +
                    linear(color[1]) + "," + linear(color[2]) + ",1]}",
                quadrants(1));
}

class BaseMapsPicture : public GlTest {
 protected:
  std::vector<Tier> tiers() const {
    std::vector<Tier> found = {Tier::kCpu};
    if (support_.gpu_raster) found.push_back(Tier::kGpuRaster);
    if (support_.gpu) found.push_back(Tier::kGpu);
    return found;
  }

  // Of every tier, and without OpenGL.
  std::vector<Image> pictures(const Model& model) const {
    std::vector<Image> images = {softwarePicture(model)};
    for (const Tier tier : tiers()) images.push_back(picture(model, tier, Shading::kAlpha));
    return images;
  }
};

TEST_F(BaseMapsPicture, ATextureGivesTheColourThatAFactorGives) {
  const Model textured = painted(quadrants(3));
  const auto expectColors = [&](Tier tier, Shading shading) {
    const Image image = picture(textured, tier, shading);
    expectQuadrants(image);
    for (uint32_t q = 0; q < 4; ++q)
      expectNear(quadrant(image, q), quadrant(picture(plain(kQuadrants[q]), tier, shading), q), 3 * kStep);
  };
  for (const Shading shading : {Shading::kBlend, Shading::kAlpha, Shading::kNone})
    expectColors(Tier::kCpu, shading);
  for (const Tier tier : tiers()) expectColors(tier, Shading::kInterpolated);
}

TEST(BaseMapsSoftware, ATextureGivesTheColourThatAFactorGives) {
  const Image image = softwarePicture(painted(quadrants(3)));
  expectQuadrants(image);
  for (uint32_t q = 0; q < 4; ++q)
    expectNear(quadrant(image, q), quadrant(softwarePicture(plain(kQuadrants[q])), q), 3 * kStep);
}

// A file may hold fewer levels than the exposure would like to read.
TEST(BaseMapsSoftware, LevelsThatAreNotThereAreNotRead) {
  ByteImage image{256, 256, 3, {}};
  image.pixels.assign(size_t{256} * 256 * 3, 255);
  const Model model = painted(image);
  BaseMaps maps = model.asset.view().base_maps[0];
  std::vector<std::byte> data(maps.color.data.size());  // black beyond the first level
  const size_t first = textureLevelBytes(maps.color.format, 256, 256, 0);
  std::copy_n(maps.color.data.begin(), first, data.begin());
  const auto drawn = [&](const Texture& color) {
    maps.color = color;
    AssetView view = model.asset.view();
    view.base_maps = {&maps, 1};
    return preview::softwarePicture(view, model.frame.input, optionsFor(model, Tier::kCpu, Shading::kAlpha),
                                    2);
  };
  const Texture whole = maps.color;
  Texture cut = whole;
  cut.levels = 1;
  cut.data = {data.data(), first};
  expectNear(quadrant(drawn(cut), 0), quadrant(drawn(whole), 0), kStep);
}

TEST_F(BaseMapsPicture, BothRenderersMoveTheMapAlike) {
  const Model moved = painted(
      quadrants(3), "", ",\"extensions\":{\"KHR_texture_transform\":{\"offset\":[0.5,0],\"scale\":[1,2]}}");
  const Model still = painted(quadrants(3));
  const Image gl = picture(still, Tier::kCpu, Shading::kAlpha);
  for (const Image& image : {picture(moved, Tier::kCpu, Shading::kAlpha), softwarePicture(moved)}) {
    // The quadrants lie in v from 0.25 to 0.75: twice that, they show what is in the lower, then the upper
    // half.
    const uint32_t shown[] = {3, 2, 1, 0};
    for (uint32_t q = 0; q < 4; ++q)  // lit a little otherwise there
      expectNear(quadrant(image, q), quadrant(gl, shown[q]), 0.06f);
  }
}

TEST_F(BaseMapsPicture, BordersAreDrawnAsTheSamplerSays) {
  // The square shows -1 to 2 of the map, both ways.
  const std::string moved =
      ",\"extensions\":{\"KHR_texture_transform\":{\"offset\":[-1,-1],\"scale\":[3,3]}}";
  const auto shown = [&](int across, int down) {
    Square square;
    const std::string image = square.embedded(pngOf(quadrants(3)));
    return cookedFile(square.write(
        "wrapped.glb", image, "\"source\":0,\"sampler\":0",
        "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0" + moved + "}}",
        ",\"samplers\":[{\"wrapS\":" + std::to_string(across) + ",\"wrapT\":" + std::to_string(down) + "}]"));
  };
  constexpr int kRepeat = 10497, kClamp = 33071, kMirror = 33648;
  // Of the sixths of the square, from its upper left corner: which half of the map is there.
  const auto half = [](int way, uint32_t sixth) {
    constexpr uint32_t kHalves[3][6] = {{0, 1, 0, 1, 0, 1}, {0, 0, 0, 1, 1, 1}, {1, 0, 0, 1, 1, 0}};
    return kHalves[way == kRepeat ? 0 : way == kClamp ? 1 : 2][sixth];
  };
  for (const auto& [across, down] :
       {std::pair(kRepeat, kRepeat), {kClamp, kMirror}, {kMirror, kClamp}, {kRepeat, kClamp}}) {
    const Model model = shown(across, down);
    uint32_t drawer = 0;
    for (const Image& image : pictures(model)) {
      const preview::CameraFrame frame =
          preview::cameraFrame(optionsFor(model, Tier::kCpu, Shading::kAlpha).camera, 1.0f);
      for (uint32_t y = 0; y < 6; ++y)
        for (uint32_t x = 0; x < 6; ++x) {
          const auto middle = [](uint32_t sixth) { return (static_cast<float>(sixth) + 0.5f) / 6.0f; };
          const auto origin = [&](int axis) { return static_cast<float>(model.frame.origin[axis]); };
          const glm::vec4 clip =
              frame.view_projection * glm::vec4(middle(x) - origin(0), middle(5 - y) - origin(1), 0.0f, 1.0f);
          const auto pixel = [](float at) { return static_cast<uint32_t>((at * 0.5f + 0.5f) * kSize); };
          const float* p = image.at(pixel(clip.x / clip.w), pixel(-clip.y / clip.w));
          const uint32_t q = 2 * half(down, y) + half(across, x);  // the last one is grey
          const float lead =
              q == 3 ? 0.06f - std::abs(p[0] - p[1]) : p[q] - std::max(p[(q + 1) % 3], p[(q + 2) % 3]) - 0.1f;
          EXPECT_GT(lead, 0.0f) << drawer << " " << across << " " << down << " at " << x << " " << y;
        }
      ++drawer;
    }
  }
}

TEST_F(BaseMapsPicture, WhatIsMaskedIsNotDrawn) {
  std::array<Color, 4> colors = kQuadrants;
  colors[1][3] = 40;
  const Model masked = painted(quadrants(4, colors), ",\"alphaMode\":\"MASK\"");
  const Image whole = picture(painted(quadrants(3)), Tier::kCpu, Shading::kNone);
  for (const Image& image : pictures(masked)) {
    expectNear(quadrant(image, 1), image.at(kSize / 2 + kSize / 8, 2), 0.05f);  // background
    expectNear(quadrant(image, 0), quadrant(whole, 0), 3 * kStep);
  }
  // The factor's opacity is part of the material's.
  const std::string faint =
      "\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,1,0.45],\"baseColorTexture\":{"
      "\"index\":0}},\"alphaMode\":\"MASK\"";
  for (const Image& image : pictures(cooked(faint, quadrants(4))))
    expectNear(quadrant(image, 0), image.at(kSize / 2 - kSize / 8, 2), 0.05f);
}

TEST_F(BaseMapsPicture, WhatIsMaskedCastsNoShadow) {
  const auto spread = [](const Image& image) {  // below and to the right of the small one, on the other
    float low = 1.0f, high = 0.0f;
    for (uint32_t y = kSize / 2; y < kSize * 3 / 4; ++y)
      for (uint32_t x = kSize * 5 / 8; x < kSize * 25 / 32; ++x) {
        low = std::min(low, image.at(x, y)[1]);
        high = std::max(high, image.at(x, y)[1]);
      }
    return high - low;
  };
  for (const Image& image : pictures(blind("MASK"))) EXPECT_LT(spread(image), 5 * kStep);
  for (const Image& image : pictures(blind("OPAQUE"))) EXPECT_GT(spread(image), 30 * kStep);
}

// A red square before a grey one, in that opacity and without a texture.
TEST_F(BaseMapsPicture, WhatIsBehindShowsThroughAFactorsOpacity) {
  const auto model = [](const std::string& opacity, const std::string& mode) {
    test::GltfBuilder builder;
    std::string primitives;
    for (const float z : {0.2f, 0.0f}) {
      const int positions = builder.add<float>({0, 0, z, 1, 0, z, 1, 1, z, 0, 1, z}, "VEC3", 3);
      const int indices = builder.add<uint16_t>({0, 1, 2, 0, 2, 3}, "SCALAR", 1);
      primitives += std::string(z > 0.0f ? "" : ",") +
                    "{\"attributes\":{\"POSITION\":" + std::to_string(positions) +
                    "},\"indices\":" + std::to_string(indices) + ",\"material\":" + (z > 0.0f ? "0}" : "1}");
    }
    return cookedFile(test::writeFile(
        "glass.glb", builder.glb("\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[" + primitives +
                                 "]}],\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":["
                                 "0.4,0.02,0.02," +
                                 opacity + "]},\"alphaMode\":\"" + mode +
                                 "\"},{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.2,0.2,0.2,1]}}]")));
  };
  const std::vector<Image> clear = pictures(model("0", "BLEND")), half = pictures(model("0.45", "BLEND")),
                           quarter = pictures(model("0.3", "BLEND")), whole = pictures(model("1", "BLEND")),
                           opaque = pictures(model("0.5", "OPAQUE")), cut = pictures(model("0.4", "MASK"));
  const auto linear = [](float c) {
    return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
  };
  for (size_t i = 0; i < clear.size(); ++i) {
    SCOPED_TRACE(i);
    const auto at = [&](const std::vector<Image>& images) {
      return images[i].at(kSize / 2 - 9, kSize / 2 + 5);
    };
    EXPECT_GT(at(whole)[0], at(whole)[1] + 0.2f);
    EXPECT_NEAR(at(clear)[0], at(clear)[1], 0.05f);
    expectNear(at(opaque), at(whole), kStep);
    expectNear(at(cut), at(clear), kStep);
    for (int c = 0; c < 3; ++c) {
      const float front = linear(at(whole)[c]), behind = linear(at(clear)[c]);
      EXPECT_NEAR(linear(at(half)[c]), 0.5f * (front + behind), 0.02f) << c;
      EXPECT_NEAR(linear(at(quarter)[c]), 0.25f * front + 0.75f * behind, 0.02f) << c;
    }
  }
}

TEST_F(BaseMapsPicture, NormalsTiltTowardsTheLight) {
  const auto bumped = [&](const Color& color) {
    std::array<Color, 4> colors;
    colors.fill(color);
    return cooked(
        "\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.2,0.2,0.2,1]},\"normalTexture\":{\"index\":0}",
        quadrants(3, colors));
  };
  const Model none = cooked("\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.2,0.2,0.2,1]}", quadrants(3));
  for (const Shading shading : {Shading::kInterpolated, Shading::kBlend, Shading::kAlpha, Shading::kNone}) {
    const auto at = [&](const Model& model) { return quadrant(picture(model, Tier::kCpu, shading), 0)[1]; };
    EXPECT_NEAR(at(bumped({128, 128, 255, 255})), at(none), 2 * kStep);
    // The key light stands in the upper left.
    EXPECT_GT(at(bumped({52, 128, 230, 255})), at(bumped({204, 128, 230, 255})) + 20 * kStep);
    EXPECT_GT(at(bumped({128, 204, 230, 255})), at(bumped({128, 52, 230, 255})) + 20 * kStep);
  }
}

}  // namespace
}  // namespace furrow::tests
