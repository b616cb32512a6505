// The key light's shadows, on a ball that stands in the light or wholly in the shade of a plate; on every
// tier, and without OpenGL.

#include <cmath>
#include <numbers>
#include <sstream>

#include "editor/preview/posed_frame.h"
#include "editor/preview/renderer.h"
#include "editor/preview/shaders/lighting.h"
#include "editor/preview/software_picture.h"
#include "pipeline/cook/cook.h"
#include "pipeline/import/import.h"
#include "pipeline/scene/posing.h"
#include "tests/image/gl_fixture.h"
#include "tests/unit/gltf_builder.h"

namespace furrow::tests {
namespace {

using pipeline::Image;
using preview::Tier;

constexpr uint32_t kSize = 320;
constexpr float kStep = 1.0f / 255.0f;

// A ball of radius 1 with smooth normals, of `columns` times half as many quads; `shaded`: with a plate
// between it and the key light, which stands at the upper left.
std::string ball(int columns, bool shaded) {
  std::ostringstream obj;
  const int rows = columns / 2;
  for (int row = 0; row <= rows; ++row)
    for (int column = 0; column <= columns; ++column) {
      const double latitude = std::numbers::pi * (0.5 - static_cast<double>(row) / rows),
                   longitude = 2.0 * std::numbers::pi * (column % columns) / columns;
      const double p[] = {std::sin(longitude) * std::cos(latitude), std::sin(latitude),
                          std::cos(longitude) * std::cos(latitude)};
      obj << "v " << p[0] << " " << p[1] << " " << p[2] << "\nvn " << p[0] << " " << p[1] << " " << p[2]
          << "\n";
    }
  const auto corner = [&](int row, int column) {
    const std::string i = std::to_string(row * (columns + 1) + column + 1);
    return " " + i + "//" + i;
  };
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const std::string a = corner(row, column), b = corner(row + 1, column), c = corner(row + 1, column + 1),
                        d = corner(row, column + 1);
      if (row > 0) obj << "f" << a << b << d << "\n";
      if (row + 1 < rows) obj << "f" << b << c << d << "\n";
    }
  if (shaded) {
    const double towards[] = {-1.7, 1.55, 1.05}, across[] = {1.07, 1.18, 0.0}, along[] = {0.5, -0.45, 1.46};
    for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
      obj << "v";
      for (int i = 0; i < 3; ++i) obj << " " << towards[i] + x * across[i] + y * along[i];
      obj << "\n";
    }
    obj << "f -4 -3 -2 -1\n";
  }
  return obj.str();
}

class ShadowPicture : public GlTest {
 protected:
  std::vector<Image> pictures(int columns, bool shaded) {
    const pipeline::SourceScene scene = pipeline::import(test::writeFile("ball.obj", ball(columns, shaded)));
    pipeline::Recipe recipe = pipeline::defaultRecipe();
    recipe.map_size = 64;
    Asset asset;
    EXPECT_TRUE(asset.load(pipeline::cook(scene, recipe, {}).bytes).ok());
    const preview::PosedFrame frame = preview::poseFrame(
        asset.view(), pipeline::evaluate(scene.rig, pipeline::defaultPose(scene.rig)), {}, 1.0f);
    preview::RenderOptions options;
    options.width = options.height = kSize;
    options.shading = preview::Shading::kNone;
    options.camera.distance = 5.0f;
    options.camera.target = {static_cast<float>(-frame.origin[0]), static_cast<float>(-frame.origin[1]),
                             static_cast<float>(-frame.origin[2])};
    options.tier = Tier::kCpu;
    std::vector<Image> images = {preview::softwarePicture(asset.view(), frame.input, options, 2)};
    for (const Tier tier : {Tier::kCpu, Tier::kGpuRaster, Tier::kGpu}) {
      if ((tier == Tier::kGpuRaster && !support_.gpu_raster) || (tier == Tier::kGpu && !support_.gpu))
        continue;
      options.tier = tier;
      images.push_back(preview::Renderer(asset.view()).render(frame.input, options));
    }
    return images;
  }

  // Along the line through the ball's middle that leads away from the light, from where it still shines.
  static std::vector<float> awayFromLight(const Image& image) {
    std::vector<float> reds;  // the colour of light that goes farthest round the form
    for (float t = -0.1f; t < 0.34f; t += 1.0f / kSize)
      reds.push_back(image.at(static_cast<uint32_t>((0.5f + 0.74f * t) * kSize),
                              static_cast<uint32_t>((0.5f + 0.67f * t) * kSize))[0]);
    return reds;
  }
};

TEST_F(ShadowPicture, InTheShadeNoLightShowsWhereTheFormTurnsAway) {
  for (const Image& image : pictures(96, true)) {
    const std::vector<float> line = awayFromLight(image);
    for (size_t i = 16; i + 16 < line.size(); ++i)
      EXPECT_LT(line[i], std::max(line[i - 16], line[i + 16]) + 2 * kStep) << i;
  }
}

TEST_F(ShadowPicture, FacetsCastNoneOnAFormThatIsSmooth) {
  const std::vector<Image> coarse = pictures(24, false), fine = pictures(192, false);
  for (size_t k = 0; k < coarse.size(); ++k) {
    const std::vector<float> a = awayFromLight(coarse[k]), b = awayFromLight(fine[k]);
    for (size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 8 * kStep) << k << " " << i;
  }
}

// What tone mapping takes from all channels alike does not make dark cloth gaudy.
TEST(ToneMap, DarkColoursKeepTheirTint) {
  const auto contrast = [](const glm::vec3& c) { return c.g / c.b; };
  for (const float light : {0.05f, 0.25f, 1.0f, 4.0f}) {
    const glm::vec3 olive = light * glm::vec3(0.03f, 0.035f, 0.02f);
    EXPECT_LT(contrast(preview::gpu::toneMap(olive)), 1.6f * contrast(olive)) << light;
  }
}

}  // namespace
}  // namespace furrow::tests
