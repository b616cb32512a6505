// Answers that can be worked out by hand, through the whole cook and the cpu tier.

#include <gtest/gtest.h>

#include <filesystem>
#include <glm/gtc/quaternion.hpp>
#include <limits>

#include "furrow/place_hash.h"
#include "pipeline/bake/response_fit.h"
#include "pipeline/bake/weld.h"
#include "pipeline/error.h"
#include "pipeline/import/import.h"
#include "pipeline/pack/rig_section.h"
#include "pipeline/scene/posing.h"
#include "runtime/src/response_math.h"
#include "sheets.h"

namespace furrow::tests {
namespace {

constexpr double kUnit = 1.0 / 8388608.0;  // 2^-23

class Squeezed : public testing::TestWithParam<double> {};

Affine scaled(double x, double y) {
  Affine pose;
  pose.m[0] = static_cast<float>(x);
  pose.m[5] = static_cast<float>(y);
  return pose;
}

Asset restingSheet() {
  return cookAsset(sceneOf(sheet(8), [](glm::dvec3 p) { return p; }), recipeOf({axisLayer({1, 0, 0})}));
}

TEST_P(Squeezed, AlongTheDirectionAlphaIsOneOverSSquared) {
  const double s = GetParam();
  const Frame frame = evaluate(restingSheet().view(), {0.0f}, scaled(s, 1.0));
  const double expected = 1.0 / (s * s);
  for (double alpha : frame.alpha) EXPECT_NEAR(alpha / expected, 1.0, 1e-5);
  for (double w : frame.weight)
    EXPECT_NEAR(w, std::tanh(2.0 * std::log(expected)), 1e-4);  // lambda 1, beta 4: tanh(beta/2 ln alpha)
}

TEST_P(Squeezed, AcrossTheDirectionAlphaIsOne) {
  for (double alpha : evaluate(restingSheet().view(), {0.0f}, scaled(1.0, GetParam())).alpha)
    EXPECT_NEAR(alpha, 1.0, 1e-5);
}

TEST_P(Squeezed, AMorphTargetGivesTheSame) {
  const double s = GetParam();
  const auto deform = [s](glm::dvec3 p) { return glm::dvec3(s * p.x, p.y, p.z); };
  // The displacements have 24 bits here; the resting edges have 16, which is what is left of the error.
  const Asset small = cookAsset(sceneOf(sheet(8), deform), recipeOf({axisLayer({1, 0, 0})}));
  for (double alpha : evaluate(small.view(), {1.0f}).alpha) EXPECT_NEAR(alpha * s * s, 1.0, 5e-4);

  // Too many vertices to keep them all to 24 bits.
  const Asset large = cookAsset(sceneOf(sheet(50), deform), recipeOf({axisLayer({1, 0, 0})}));
  const double step = double{large.view().morphs[0].position_step}, edge = s / 50.0;
  EXPECT_LE(step, std::min(edge, 0.02) / 64.0 * 1.001);
  // Both ends of an edge are off by half a step at most, and alpha goes with the square of its length.
  for (double alpha : evaluate(large.view(), {1.0f}).alpha)
    EXPECT_NEAR(std::sqrt(1.0 / alpha) / s, 1.0, 1e-5 + step / edge);
}

INSTANTIATE_TEST_SUITE_P(Ratios, Squeezed, testing::Values(0.125, 0.25, 0.5, 0.7, 0.9, 1.0, 1.43, 2.0));

TEST(KnownAnswers, ShearFollowsFd) {
  const double k = 0.6, angle = 0.4;
  const glm::dvec3 d(std::cos(angle), std::sin(angle), 0.0);
  const Asset asset =
      cookAsset(sceneOf(sheet(8), [k](glm::dvec3 p) { return glm::dvec3(p.x + k * p.y, p.y, p.z); }),
                recipeOf({axisLayer({d.x, d.y, 0})}));
  const double q = (d.x + k * d.y) * (d.x + k * d.y) + d.y * d.y;
  for (double alpha : evaluate(asset.view(), {1.0f}).alpha) EXPECT_NEAR(alpha, 1.0 / q, 3e-4);
}

// A displacement without any order, which nothing foretells, of a sheet whose edges are 1/24 long.
TEST(KnownAnswers, MorphTargetsKeepTheirErrorAndReportIt) {
  const Primitive source = sheet(24);
  uint32_t state = 1;
  const auto random = [&state] {
    state = state * 1664525u + 1013904223u;
    return static_cast<double>(state >> 8) / (1 << 24);
  };
  const SourceScene scene = sceneOf(source, [&](glm::dvec3 p) {
    const double x = random(), y = random();
    return p + 0.5 * glm::dvec3(x, y, random());
  });
  for (const auto codec : {pipeline::GeometryCodec::kDraco, pipeline::GeometryCodec::kRaw}) {
    const Asset asset = cookAsset(scene, recipeOf({axisLayer({1, 0, 0})}), codec);
    const AssetView& view = asset.view();
    const Morph& morph = view.morphs[0];
    ASSERT_EQ(morph.vertices.size(), view.vertexCount());
    double worst = 0.0;
    for (size_t i = 0; i < morph.vertices.size(); ++i) {
      const glm::vec3 moved = scene.primitives[0].morphs[0].positions[view.source_vertex[morph.vertices[i]]];
      const glm::vec3 stored(morph.position_deltas[3 * i], morph.position_deltas[3 * i + 1],
                             morph.position_deltas[3 * i + 2]);
      worst = std::max(worst, double{glm::distance(moved, morph.position_step * stored)});
    }
    EXPECT_LE(morph.position_step, 1.0f / 24.0f / 64.0f);
    EXPECT_GT(worst, 0.0);
    EXPECT_LE(worst, 0.5 * std::sqrt(3.0) * double{morph.position_step} * 1.001);
    EXPECT_NEAR(double{view.morph_error}, worst, 1e-3 * worst);
  }
}

TEST(KnownAnswers, MorphTargetsKeepTheirNormalsToHalfAStep) {
  SourceScene scene = sceneOf(sheet(6), [](glm::dvec3 p) { return p + glm::dvec3(0.0, 0.0, 0.1); });
  Primitive& primitive = scene.primitives[0];
  primitive.normals.assign(primitive.positions.size(), glm::vec3(0, 0, 1));
  std::vector<glm::vec3>& bend = primitive.morphs[0].normals;
  for (size_t v = 0; v < primitive.positions.size(); ++v) {
    const auto angle = static_cast<float>(v);
    bend.push_back({0.6f * std::sin(angle), 0.3f * std::cos(3.0f * angle), -0.1f});
  }
  const Asset asset = cookAsset(scene, recipeOf({axisLayer({1, 0, 0})}));
  const Morph& morph = asset.view().morphs[0];
  ASSERT_EQ(morph.normal_deltas.size(), 3 * bend.size());
  for (size_t i = 0; i < bend.size(); ++i)
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(morph.normal_step * static_cast<float>(morph.normal_deltas[3 * i + static_cast<size_t>(c)]),
                  bend[asset.view().source_vertex[morph.vertices[i]]][c], 0.51 * 0.6 / 127.0);
}

TEST(KnownAnswers, AreaMeasureIsOatsWeight) {
  pipeline::LayerRecipe layer = axisLayer({1, 0, 0});
  layer.measure = Measure::kArea;
  layer.response.curve = Curve::kOat;
  const Asset asset =
      cookAsset(sceneOf(sheet(4), [](glm::dvec3 p) { return glm::dvec3(0.8 * p.x, 0.5 * p.y, p.z); }),
                recipeOf({layer}));
  const Frame frame = evaluate(asset.view(), {1.0f});
  for (double alpha : frame.alpha) EXPECT_NEAR(alpha, 2.5, 1e-3);
  for (double w : frame.weight) EXPECT_NEAR(w, 0.6, 1e-3);  // (A0 - A) / A0
}

TEST(KnownAnswers, DirectionalSeesWhatAreaDoesNot) {
  pipeline::LayerRecipe area = axisLayer({1, 0, 0});
  area.measure = Measure::kArea;
  pipeline::LayerRecipe principal = axisLayer({1, 0, 0});
  principal.measure = Measure::kPrincipal;
  pipeline::LayerRecipe directional = axisLayer({1, 0, 0});
  area.name = "area";
  principal.name = "principal";
  const Asset asset =
      cookAsset(sceneOf(sheet(4), [](glm::dvec3 p) { return glm::dvec3(0.7 * p.x, p.y / 0.7, p.z); }),
                recipeOf({directional, area, principal}));
  const Frame frame = evaluate(asset.view(), {1.0f});
  for (float q : frame.q[0]) EXPECT_NEAR(q, 0.49, 1e-3);
  for (float q : frame.q[1]) EXPECT_NEAR(q, 1.0, 1e-3);
  for (float q : frame.q[2]) EXPECT_NEAR(q, 0.49, 1e-3);
}

// Onto a line that is no axis: q is the rounding of nothing, of either sign.
TEST(KnownAnswers, ASheetSqueezedToALineIsSqueezedByEveryMeasure) {
  const glm::dvec3 line = glm::normalize(glm::dvec3(0.3, 0.7, 0.2));
  std::vector<pipeline::LayerRecipe> layers(3, axisLayer({0.7, -0.3, 0}));  // across the line
  for (const Measure measure : {Measure::kDirectional, Measure::kArea, Measure::kPrincipal}) {
    layers[static_cast<size_t>(measure)].measure = measure;
    layers[static_cast<size_t>(measure)].name = std::to_string(static_cast<int>(measure));
  }
  const Asset asset = cookAsset(sceneOf(sheet(8), [](glm::dvec3 p) { return p; }), recipeOf(layers));
  Affine pose;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c)
      pose.m[4 * r + c] = static_cast<float>(line[r] * (c == 2 ? 0.0 : line[c] / std::hypot(line.x, line.y)));
  const Frame frame = evaluate(asset.view(), {0.0f}, pose);
  for (const std::vector<float>& q : frame.q)
    for (float each : q) EXPECT_NEAR(each, 0.0f, 1e-3f);
}

TEST(KnownAnswers, RigidMotionAndInstanceScaleLeaveBiasAndRegion) {
  Primitive primitive = sheet(8);
  pipeline::Attribute color{"COLOR_0", 4, {}};
  for (size_t v = 0; v < primitive.positions.size(); ++v)
    color.values.insert(color.values.end(), {0.6f, 0.0f, 0.0f, 1.0f});
  primitive.attributes.push_back(color);
  pipeline::LayerRecipe layer = axisLayer({1, 0, 0});
  layer.bias = pipeline::Bias{"COLOR_0", 0, 0.5};
  const auto same = [](glm::dvec3 p) { return p; };
  const float c = std::cos(1.1f), s = std::sin(1.1f);
  for (const auto codec : {pipeline::GeometryCodec::kDraco, pipeline::GeometryCodec::kRaw}) {
    const Asset asset = cookAsset(sceneOf(primitive, same), recipeOf({layer}), codec);
    for (const float scale : {1.0f, 3.0f}) {
      Affine pose;
      const float m[12] = {scale * c, -scale * s, 0, 5, scale * s, scale * c, 0, -2, 0, 0, scale, 1};
      std::copy(std::begin(m), std::end(m), pose.m);
      const Frame frame = evaluate(asset.view(), {0.0f}, pose, scale, 0.25f);
      const double bound =
          8.0 * kUnit * (8.0 * scale) / (scale * 0.088);  // largest coordinate over smallest altitude
      for (double alpha : frame.alpha) EXPECT_NEAR(alpha, 1.0, bound);
      for (double w : frame.weight) EXPECT_NEAR(w, 0.2 + 0.25, 2.5 * bound + 1e-4);  // I(1) = 0 at lambda 1
    }
  }
}

TEST(KnownAnswers, VertexColorsFollowTheirVerticesUnlessALayerReadsThem) {
  Primitive primitive = sheet(8);
  pipeline::Attribute color{"COLOR_0", 3, {}};
  const auto at = [](size_t v, int c) { return static_cast<float>((3 * v + c) % 256) / 255.0f; };
  for (size_t v = 0; v < primitive.positions.size(); ++v)
    color.values.insert(color.values.end(), {at(v, 0), at(v, 1), at(v, 2)});
  primitive.attributes.push_back(color);
  const auto same = [](glm::dvec3 p) { return p; };
  for (const auto codec : {pipeline::GeometryCodec::kDraco, pipeline::GeometryCodec::kRaw}) {
    const Asset asset = cookAsset(sceneOf(primitive, same), recipeOf({axisLayer({1, 0, 0})}), codec);
    const AssetView& view = asset.view();
    ASSERT_EQ(view.colors.size(), 4 * view.vertexCount());
    for (uint32_t v = 0; v < view.vertexCount(); ++v) {
      for (int c = 0; c < 3; ++c) {
        const float root = static_cast<float>(view.colors[4 * v + c]) / 255.0f;
        ASSERT_NEAR(root * root, at(view.source_vertex[v], c), 1.0f / 255.0f);
      }
      ASSERT_EQ(view.colors[4 * v + 3], 255);
    }
  }
  pipeline::LayerRecipe layer = axisLayer({1, 0, 0});
  layer.bias = pipeline::Bias{"COLOR_0", 0, 0.5};
  EXPECT_TRUE(cookAsset(sceneOf(primitive, same), recipeOf({layer})).view().colors.empty());
  primitive.attributes.clear();
  EXPECT_TRUE(cookAsset(sceneOf(primitive, same), recipeOf({axisLayer({1, 0, 0})})).view().colors.empty());
}

TEST(KnownAnswers, ABiasImageIsReadAtTheVertices) {
  // 4 x 4 texels, the left half neutral but for half a step of 8 bits, the right half at 0.9 in green.
  const auto image =
      std::make_shared<pipeline::ByteImage>(pipeline::ByteImage{4, 4, 2, std::vector<uint8_t>(32)});
  for (size_t texel = 0; texel < 16; ++texel) image->pixels[2 * texel + 1] = texel % 4 < 2 ? 128 : 230;
  pipeline::LayerRecipe layer = axisLayer({1, 0, 0});
  layer.bias = pipeline::Bias{{}, 1, 0.5, "/nowhere/bias.png"};
  pipeline::CookOptions options;
  options.images["/nowhere/bias.png"] = image;
  SourceScene scene = sceneOf(sheet(8), [](glm::dvec3 p) { return p; });
  Asset asset;
  ASSERT_TRUE(asset.load(pipeline::cook(scene, recipeOf({layer}), options).bytes).ok());
  const Frame frame = evaluate(asset.view(), {0.0f});
  for (size_t v = 0; v < frame.weight.size(); ++v) {
    const double x = double{scene.primitives[0].positions[v].x};
    const double expected = x == 0.5 ? (230.0 + 128.0) / 255.0 - 1.0 : 2.0 * (230.0 / 255.0 - 0.5);
    if (x > 0.2 && x < 0.3) {
      EXPECT_EQ(frame.weight[v], 0.0);
    } else if (x == 0.5 || (x > 0.6 && x < 0.9)) {
      EXPECT_NEAR(frame.weight[v], expected, 1e-4);
    }
  }
  layer.bias->channel = 2;
  EXPECT_THROW(pipeline::cook(scene, recipeOf({layer}), options), pipeline::Error);
  layer.bias->channel = 1;
  scene.primitives[0].uvs.clear();
  EXPECT_THROW(pipeline::cook(scene, recipeOf({layer}), options), pipeline::Error);
}

TEST(KnownAnswers, SplittingATriangleOfAFanChangesNothing) {
  Primitive fan;
  fan.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
  fan.indices = {0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 1};
  Primitive split = fan;
  split.positions.push_back({0.5f, 0.5f, 0.0f});
  split.indices = {0, 1, 5, 0, 5, 2, 0, 2, 3, 0, 3, 4, 0, 4, 1};
  // Each quadrant is squeezed differently, linearly inside, so that both halves of the split one have its F.
  const auto deform = [](glm::dvec3 p) { return glm::dvec3((p.x > 0.0 ? 0.6 : 0.9) * p.x, p.y, p.z); };
  const double whole =
      evaluate(cookAsset(sceneOf(fan, deform), recipeOf({axisLayer({1, 0, 0})})).view(), {1.0f}).alpha[0];
  const double halves =
      evaluate(cookAsset(sceneOf(split, deform), recipeOf({axisLayer({1, 0, 0})})).view(), {1.0f}).alpha[0];
  EXPECT_NEAR(whole, 1.0 / (0.5 * 0.36 + 0.5 * 0.81), 1e-3);
  EXPECT_NEAR(whole, halves, 1e-4);
}

Primitive cylinder(bool cut) {
  constexpr uint32_t kAround = 24, kUp = 10;
  Primitive p;
  const uint32_t columns = cut ? kAround + 1 : kAround;
  for (uint32_t y = 0; y <= kUp; ++y)
    for (uint32_t x = 0; x < columns; ++x) {
      const double angle = 2.0 * std::numbers::pi * (x % kAround) / kAround;
      p.positions.push_back({static_cast<float>(std::cos(angle)), static_cast<float>(y) * 0.2f,
                             static_cast<float>(std::sin(angle))});
      p.uvs.push_back({static_cast<float>(x) / kAround, static_cast<float>(y) / kUp});
    }
  for (uint32_t y = 0; y < kUp; ++y)
    for (uint32_t x = 0; x < kAround; ++x) {
      const uint32_t right = (x + 1) % columns;
      const uint32_t a = y * columns + x, b = y * columns + right, c = a + columns, d = b + columns;
      p.indices.insert(p.indices.end(), {a, c, b, b, c, d});
    }
  return p;
}

TEST(KnownAnswers, BothSidesOfASeamAreBitIdenticalAndEqualTheUncutCylinder) {
  const auto bend = [](glm::dvec3 p) { return glm::dvec3(p.x, p.y * (0.7 + 0.2 * p.x), p.z); };
  const Asset cut = cookAsset(sceneOf(cylinder(true), bend), recipeOf({axisLayer({0, 1, 0})}),
                              pipeline::GeometryCodec::kRaw);
  const Asset whole = cookAsset(sceneOf(cylinder(false), bend), recipeOf({axisLayer({0, 1, 0})}),
                                pipeline::GeometryCodec::kRaw);
  EXPECT_EQ(cut.view().pointCount(), whole.view().pointCount());
  const Frame a = evaluate(cut.view(), {1.0f}), b = evaluate(whole.view(), {1.0f});
  for (uint32_t y = 0; y <= 10; ++y) {
    EXPECT_EQ(a.alpha[y * 25], a.alpha[y * 25 + 24]);
    EXPECT_EQ(a.weight[y * 25], a.weight[y * 25 + 24]);
    for (uint32_t x = 0; x < 24; ++x) EXPECT_NEAR(a.alpha[y * 25 + x], b.alpha[y * 24 + x], 1e-5);
  }
}

TEST(KnownAnswers, VerticesThatTouchButMoveApartAreTwoPoints) {
  Primitive lips;
  lips.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {1, 0, 0}, {0, -1, 0}};
  lips.indices = {0, 1, 2, 3, 5, 4};
  uint32_t vertex = 0;
  const auto open = [&vertex](glm::dvec3 p) { return vertex++ < 3 ? p : p - glm::dvec3(0, 0.3, 0); };
  EXPECT_EQ(cookAsset(sceneOf(lips, open), recipeOf({axisLayer({1, 0, 0})})).view().pointCount(), 6u);
  EXPECT_EQ(cookAsset(sceneOf(lips, [](glm::dvec3 p) { return 0.5 * p; }), recipeOf({axisLayer({1, 0, 0})}))
                .view()
                .pointCount(),
            4u);
}

TEST(KnownAnswers, NothingDependsOnHowTheRangesAreSplit) {
  const Asset asset =
      cookAsset(sceneOf(sheet(13), [](glm::dvec3 p) { return glm::dvec3(p.x * p.x, p.y, 0.2 * p.x); }),
                recipeOf({axisLayer({1, 0, 0})}));
  EXPECT_EQ(evaluate(asset.view(), {1.0f}).weights,
            evaluate(asset.view(), {1.0f}, {}, 1.0f, 0.0f, 7).weights);
}

TEST(KnownAnswers, LogarithmAndPowerAreWithinTheirBounds) {
  for (float x = 0x1p-40f; x < 0x1p40f; x *= 1.0007f) {
    const double exact = std::log2(double{x});
    EXPECT_NEAR(fastLog2(x), exact, 4e-7 * std::abs(exact)) << x;
  }
  for (float y = 0.0f; y <= 126.0f; y += 0.0013f) {
    const double exact = std::exp2(double{y});
    EXPECT_NEAR(fastExp2(y), exact, 4e-7 * exact) << y;
  }
  EXPECT_EQ(fastLog2(1.0f), 0.0f);
  EXPECT_EQ(fastExp2(0.0f), 1.0f);
}

TEST(KnownAnswers, CollapsedAndNonFiniteInputGivesFiniteWeights) {
  const Asset asset = cookAsset(sceneOf(sheet(4), [](glm::dvec3) { return glm::dvec3(0.0); }),
                                recipeOf({axisLayer({1, 0, 0})}));
  for (double w : evaluate(asset.view(), {1.0f}).weight) EXPECT_NEAR(w, 1.0, 1e-3);
  Affine broken;
  for (float wrong : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    broken.m[0] = wrong;
    for (double alpha : evaluate(asset.view(), {0.0f}, broken).alpha) EXPECT_EQ(alpha, 1.0) << wrong;
  }
}

TEST(KnownAnswers, AMirroredPoseKeepsNormalsOutwardsAndBitangentsInPlace) {
  const Asset asset =
      cookAsset(sceneOf(cylinder(true), [](glm::dvec3 p) { return p; }), recipeOf({axisLayer({0, 1, 0})}));
  const AssetView& view = asset.view();
  Affine mirror;
  mirror.m[0] = -1.0f;
  const std::vector<Affine> palette(view.palette.size(), mirror);
  const std::vector<float> morphs(view.morphs.size());
  std::vector<Float3> positions(view.vertexCount()), normals(view.vertexCount());
  std::vector<Float4> tangents(view.vertexCount());
  DeformJob{&view, palette, morphs, positions, normals, tangents}.run(0, view.vertexCount());
  for (uint32_t v = 0; v < view.vertexCount(); ++v) {
    const Float3 n = view.normals[v];
    EXPECT_NEAR(normals[v].x, -n.x, 1e-5);
    EXPECT_NEAR(normals[v].z, n.z, 1e-5);
    EXPECT_EQ(tangents[v].w, -view.tangents[v].w);
  }
}

TEST(KnownAnswers, TheHashBindsEverySourcePositionToItsPoint) {
  const Primitive primitive = cylinder(true);
  const Asset asset =
      cookAsset(sceneOf(primitive, [](glm::dvec3 p) { return p; }), recipeOf({axisLayer({0, 1, 0})}));
  const AssetView& view = asset.view();
  PlaceHash hash;
  ASSERT_TRUE(hash.open(view.place_hash).ok());
  std::vector<uint32_t> point_of_source(view.vertexCount());
  for (uint32_t v = 0; v < view.vertexCount(); ++v)
    point_of_source[view.source_vertex[v]] = view.vertex_point[v];
  for (uint32_t v = 0; v < primitive.positions.size(); ++v) {
    const glm::vec3 p = primitive.positions[v];
    const auto place = hash.find({p.x, p.y, p.z});
    ASSERT_TRUE(place.has_value());
    EXPECT_EQ(view.place_points[2 * *place], point_of_source[v]);
    EXPECT_EQ(view.place_points[2 * *place + 1], 1u);
  }
  EXPECT_FALSE(hash.find({0.123f, 9.0f, 4.0f}).has_value());
}

TEST(Asset, RefusesEveryTruncationAndEveryChangedByte) {
  const std::vector<std::byte> bytes = pipeline::cook(sceneOf(sheet(3), [](glm::dvec3 p) { return p * 0.9; }),
                                                      recipeOf({axisLayer({1, 0, 0})}), {})
                                           .bytes;
  Asset asset;
  ASSERT_TRUE(asset.load(bytes).ok());
  for (size_t length = 0; length < bytes.size(); ++length)
    ASSERT_FALSE(asset.load({bytes.data(), length}).ok()) << length;
  std::vector<std::byte> changed = bytes;
  for (size_t i = 0; i < bytes.size(); ++i) {
    changed[i] ^= std::byte{0x10};
    ASSERT_FALSE(asset.load(changed).ok()) << i;
    changed[i] = bytes[i];
  }
  changed.push_back(std::byte{0});
  EXPECT_FALSE(asset.load(changed).ok());
}

TEST(Cook, GivesTheSameBytesAgain) {
  const auto make = [](uint32_t threads) {
    pipeline::CookOptions options;
    options.threads = threads;
    return pipeline::cook(
               sceneOf(sheet(12), [](glm::dvec3 p) { return glm::dvec3(p.x * (0.5 + 0.5 * p.x), p.y, 0.0); }),
               pipeline::defaultRecipe(), options)
        .bytes;
  };
  EXPECT_EQ(make(1), make(1));
  EXPECT_EQ(make(1), make(3));
}

TEST(Cook, AnimationDirectionsFollowTheSqueeze) {
  const double angle = 0.5;
  const glm::dvec3 d(std::cos(angle), std::sin(angle), 0.0);
  pipeline::Recipe recipe = pipeline::defaultRecipe();
  recipe.layers[0].compress = pipeline::MapNone{};
  const Asset asset =
      cookAsset(sceneOf(sheet(10), [d](glm::dvec3 p) { return p - 0.4 * glm::dot(p, d) * d; }), recipe);
  const Layer& layer = asset.view().layers[0];
  for (uint32_t p = 0; p < asset.view().pointCount(); ++p) {
    const glm::dvec3 baked(layer.directions[4 * p], layer.directions[4 * p + 1], layer.directions[4 * p + 2]);
    const double cosine = glm::dot(glm::normalize(baked), d);
    EXPECT_GT(std::abs(cosine), std::cos(2.0 * std::numbers::pi / 180.0));
  }
  for (double alpha : evaluate(asset.view(), {1.0f}).alpha) EXPECT_NEAR(alpha, 1.0 / 0.36, 5e-3);
}

TEST(Cook, AMaskCoversWhatAnyPoseSqueezes) {
  pipeline::Recipe recipe = pipeline::defaultRecipe();
  recipe.layers[0].compress = pipeline::MapNone{};
  SourceScene scene = sceneOf(sheet(10), [](glm::dvec3 p) { return p * glm::dvec3(0.6, 1.0, 1.0); });
  MorphDelta slight = scene.primitives[0].morphs[0];
  for (glm::vec3& d : slight.positions) d *= 0.05f;  // of itself it would wrinkle nothing
  scene.rig.morphs.push_back({"slight", 0, 1, 0.0});
  scene.primitives[0].morphs.push_back(slight);
  for (int order = 0; order < 2; ++order) {
    const Asset asset = cookAsset(scene, recipe);
    const std::span<const uint8_t> mask = asset.view().layers[0].mask;
    EXPECT_TRUE(std::ranges::all_of(mask, [](uint8_t m) { return m == 255; })) << order;
    std::swap(scene.primitives[0].morphs[0], scene.primitives[0].morphs[1]);
  }
}

TEST(Cook, DirectionsOfAnAttributeTurnWithTheirMesh) {
  SourceScene scene = sceneOf(sheet(4), [](glm::dvec3 p) { return p; });
  pipeline::Attribute direction{"_DIR", 3, {}};
  for (size_t v = 0; v < scene.primitives[0].positions.size(); ++v)
    direction.values.insert(direction.values.end(), {v % 2 ? -2.0f : 0.5f, 0.0f, 0.0f});
  scene.primitives[0].attributes.push_back(direction);
  scene.rig.nodes[0].rotation = glm::angleAxis(std::numbers::pi / 3.0, glm::dvec3(0, 0, 1));
  pipeline::LayerRecipe layer = axisLayer({1, 0, 0});
  layer.direction = pipeline::DirectionAttribute{"_DIR"};
  const Asset asset = cookAsset(scene, recipeOf({layer}));
  for (uint32_t p = 0; p < asset.view().pointCount(); ++p) {
    const int8_t* d = &asset.view().layers[0].directions[4 * p];
    EXPECT_NEAR(std::abs(d[0] * std::cos(std::numbers::pi / 3.0) + d[1] * std::sin(std::numbers::pi / 3.0)),
                127.0, 2.0);
  }
}

// Where a file's inverse bind matrices carry its unit, at most joints but the top one.
TEST(Cook, RestIsTakenAfterTheScaleOfTheInverseBindMatrices) {
  SourceScene scene = sceneOf(sheet(2), [](glm::dvec3 p) { return p; });
  Primitive& primitive = scene.primitives[0];
  primitive.influences = 1;
  primitive.joints.assign(primitive.positions.size(), 1);
  primitive.weights.assign(primitive.positions.size(), 1.0f);
  scene.rig.nodes.resize(3);
  scene.rig.nodes[1].parent = scene.rig.nodes[2].parent = 0;
  const glm::dmat4 hundred(glm::dmat3(100.0));
  scene.rig.palette = {{0, glm::dmat4(1.0)}, {1, hundred}, {2, hundred}};
  scene.parts[0].skinned = true;
  scene.parts[0].palette_count = 3;
  const std::vector<glm::vec3> placed = pipeline::sourcePositions(scene);
  for (size_t v = 0; v < placed.size(); ++v)
    EXPECT_LT(glm::distance(placed[v], 100.0f * primitive.positions[v]), 1e-4f) << v;
}

TEST(Cook, TheMaskRisesFromThreeToFifteenPercentOfSqueeze) {
  pipeline::Recipe recipe = pipeline::defaultRecipe();
  recipe.layers[0].compress = pipeline::MapNone{};
  const auto maskOf = [&](double squeeze) {
    const Asset asset = cookAsset(
        sceneOf(sheet(6), [&](glm::dvec3 p) { return p * glm::dvec3(1.0 - squeeze, 1.0, 1.0); }), recipe);
    const std::span<const uint8_t> mask = asset.view().layers[0].mask;  // empty: everywhere
    for (const uint8_t m : mask) EXPECT_EQ(m, mask[0]) << squeeze;
    return mask.empty() ? 255 : int{mask[0]};
  };
  EXPECT_EQ(maskOf(0.008), 255);  // no squeeze at all: the layer is everywhere
  EXPECT_EQ(maskOf(0.012), 0);
  EXPECT_NEAR(maskOf(0.06), 255 * 5.0 / 32.0, 1.0);  // a smooth step at 1/4
  EXPECT_NEAR(maskOf(0.09), 255 / 2.0, 1.0);
  EXPECT_EQ(maskOf(0.151), 255);
}

TEST(Cook, MakesNormalsThatPointOutOfAMirroredMeshToo) {
  for (const double x : {1.0, -1.0}) {
    SourceScene scene = sceneOf(sheet(4), [](glm::dvec3 p) { return p; });
    scene.primitives[0].normals.clear();
    scene.rig.nodes[0].scale.x = x;
    const Asset asset = cookAsset(scene, recipeOf({axisLayer({1, 0, 0})}));
    for (const Float3& n : asset.view().normals) EXPECT_NEAR(n.z, 1.0f, 1e-6f) << x;
  }
}

TEST(Cook, ADriverSharesItsGainAmongTheSidesOfItsShape) {
  SourceScene scene = sceneOf(sheet(4), [](glm::dvec3 p) { return p * 0.9; });
  scene.rig.morphs.assign(3, scene.rig.morphs[0]);
  scene.primitives[0].morphs.assign(3, scene.primitives[0].morphs[0]);
  const char* const names[] = {"browDown_L", "browDown_R", "jawOpen"};
  for (size_t m = 0; m < 3; ++m) scene.rig.morphs[m].name = names[m];
  pipeline::LayerRecipe layer = axisLayer({1, 0, 0});
  layer.drivers = {{"browDown", 0.8, {}}};
  const Asset asset = cookAsset(scene, recipeOf({layer}));
  ASSERT_EQ(asset.view().drivers.size(), 2u);
  for (uint32_t m = 0; m < 2; ++m) {
    EXPECT_EQ(asset.view().drivers[m].morph, m);
    EXPECT_EQ(asset.view().drivers[m].gain, 0.4f);
  }
}

TEST(Cook, TargetsOfOneNameDriveOnce) {
  SourceScene scene = sceneOf(sheet(4), [](glm::dvec3 p) { return p * 0.9; });
  scene.rig.morphs.push_back(scene.rig.morphs[0]);
  scene.primitives[0].morphs.push_back(scene.primitives[0].morphs[0]);
  pipeline::LayerRecipe layer = axisLayer({1, 0, 0});
  layer.drivers = {{"deform", 0.8, {}}};
  const Asset asset = cookAsset(scene, recipeOf({layer}));
  ASSERT_EQ(asset.view().drivers.size(), 1u);
  EXPECT_EQ(asset.view().drivers[0].morph, 0u);
  EXPECT_EQ(asset.view().drivers[0].gain, 0.8f);
}

// A crease along one side of a square: z falls from 1 as cosh((1 - y) / R) / cosh(1 / R) with R = 1/4, and
// below a quarter it is called a guess, which is from y = 0.348 on.
TEST(Cook, TellsHowMuchOfADirectionIsAGuess) {
  pipeline::LayerRecipe layer = axisLayer({1, 0, 0});
  layer.direction = pipeline::DirectionGuides{{{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}}}, {}};
  const SourceScene scene = sceneOf(sheet(40), [](glm::dvec3 p) { return p; });
  const auto warned = [](const pipeline::CookReport& report) {
    return std::ranges::any_of(report.warnings, [](const std::string& warning) {
      return warning.find("its direction is little more than a guess on 6") != std::string::npos;
    });
  };
  const pipeline::CookReport side = pipeline::cook(scene, recipeOf({layer}), {}).report;
  EXPECT_NEAR(side.layers[0].low_confidence, 0.652, 0.03);
  EXPECT_TRUE(warned(side));
  layer.direction = pipeline::DirectionGuides{{{{0.0, 0.5, 0.0}, {1.0, 0.5, 0.0}}}, {}};
  const pipeline::CookReport middle = pipeline::cook(scene, recipeOf({layer}), {}).report;
  EXPECT_LT(middle.layers[0].low_confidence, 0.1);  // 1 / cosh(2) is more than a quarter
  EXPECT_FALSE(warned(middle));
}

// The deform job against the importer's reference in double, on real files.
class Posed : public testing::TestWithParam<const char*> {};

TEST_P(Posed, EqualsTheReferenceWithinAHundredThousandthOfTheDiagonal) {
  const std::filesystem::path file = std::filesystem::path(FURROW_CORPUS) / GetParam();
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no corpus";
  const SourceScene scene = pipeline::import(file);
  pipeline::Recipe recipe = pipeline::defaultRecipe();
  recipe.layers[0].compress = pipeline::MapNone{};
  const Asset asset = cookAsset(scene, recipe);
  const AssetView& view = asset.view();
  const pipeline::Rig rig = pipeline::readRig(view);
  pipeline::Pose pose = pipeline::defaultPose(rig);
  if (!rig.clips.empty()) pipeline::applyClip(rig, rig.clips[0], 0.4 * rig.clips[0].duration, pose);
  const pipeline::PosedRig posed = pipeline::evaluate(rig, pose);
  std::vector<Affine> palette;
  for (const glm::dmat4& m : posed.palette) {
    Affine& affine = palette.emplace_back();
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column)
        affine.m[4 * row + column] = static_cast<float>(m[column][row]);
  }
  const std::vector<float> morphs(posed.morph_weights.begin(), posed.morph_weights.end());
  std::vector<Float3> positions(view.vertexCount());
  const DeformJob deform{&view, palette, morphs, positions, {}, {}};
  ASSERT_TRUE(deform.validate().ok());
  deform.run(0, view.vertexCount());

  std::vector<glm::dvec3> reference;
  for (const pipeline::Part& part : scene.parts)
    for (const glm::dvec3& p : pipeline::posePart(scene, part, posed)) reference.push_back(p);
  glm::dvec3 lowest(INFINITY), highest(-INFINITY);
  for (const glm::dvec3& p : reference) {
    lowest = glm::min(lowest, p);
    highest = glm::max(highest, p);
  }
  const double diagonal = glm::distance(lowest, highest);
  double worst = 0.0;
  for (uint32_t v = 0; v < view.vertexCount(); ++v)
    worst = std::max(worst, glm::distance(reference[view.source_vertex[v]],
                                          glm::dvec3(positions[v].x, positions[v].y, positions[v].z)));
  RecordProperty("worst_of_diagonal", std::to_string(worst / diagonal));
  EXPECT_LE(worst, 2e-5 * diagonal);
}

INSTANTIATE_TEST_SUITE_P(Corpus, Posed,
                         testing::Values("skinned/CesiumMan.glb", "skinned/simple_skin/simple_skin.gltf",
                                         "morph/SimpleMorph/SimpleMorph.gltf",
                                         "morph/MorphStressTest/MorphStressTest.gltf",
                                         "face/ict_facekit_generic_55targets.glb",
                                         "face/makehuman_body_34targets_skinned.glb",
                                         "face/valid/Asian_F_1_Casual.glb"));

// ---- fitted responses ----

pipeline::LayerReport fitted(double squeeze, double target, std::vector<std::string>& warnings) {
  pipeline::LayerRecipe layer = axisLayer({1, 0, 0});
  layer.fit = target;
  const pipeline::Cooked cooked = pipeline::cook(
      sceneOf(sheet(8), [squeeze](glm::dvec3 p) { return glm::dvec3(squeeze * p.x, p.y, p.z); }),
      recipeOf({layer}), {});
  warnings = cooked.report.warnings;
  return cooked.report.layers.at(0);
}

TEST(ResponseFit, ASqueezedSheetSolvesTheTanh) {
  std::vector<std::string> warnings;
  for (const double s : {0.85, 0.7, 0.5})
    for (const double target : {0.3, 0.6, 0.9}) {
      const pipeline::LayerReport layer = fitted(s, target, warnings);
      const double alpha = 1.0 / (s * s), beta = 2.0 * std::atanh(target) / std::log(alpha);
      if (beta < 1.0 || beta > 16.0) continue;
      EXPECT_NEAR(layer.fit->alpha, alpha, 1e-3 * alpha);
      EXPECT_EQ(layer.response.lambda, 1.0f);
      EXPECT_NEAR(layer.response.beta, beta, 5e-3 * beta);
      EXPECT_NEAR(layer.fit->weight, target, 2e-3);
      EXPECT_EQ(layer.response.stretch_beta, layer.response.beta);
      EXPECT_TRUE(warnings.empty());
    }
}

TEST(ResponseFit, LambdaRisesOnlyWhereBetaWouldFallBelowOne) {
  std::vector<std::string> warnings;
  const pipeline::LayerReport layer = fitted(0.125, 0.9, warnings);  // alpha 64: ln 19 / ln 64 < 1
  EXPECT_EQ(layer.response.beta, 1.0f);
  EXPECT_NEAR(layer.response.lambda, 64.0 / 19.0, 2e-3);
  EXPECT_NEAR(layer.fit->weight, 0.9, 1e-3);
}

TEST(ResponseFit, AWeightOutOfReachIsTold) {
  std::vector<std::string> warnings;
  const pipeline::LayerReport layer = fitted(0.98, 0.9, warnings);
  EXPECT_EQ(layer.response.beta, 16.0f);
  EXPECT_NEAR(layer.fit->weight, std::tanh(-16.0 * std::log(0.98)), 1e-3);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0],
            "layer \"layer\" is squeezed to alpha 1.04 only: its weight reaches 0.31 instead of 0.9");
}

TEST(ResponseFit, WhatNothingSqueezesIsNotFitted) {
  std::vector<std::string> warnings;
  const pipeline::LayerReport layer = fitted(1.2, 0.9, warnings);
  EXPECT_FALSE(layer.fit);
  EXPECT_EQ(layer.response.beta, 4.0f);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0], "layer \"layer\": no pose squeezes it, so that its response is not fitted");
}

TEST(ResponseFit, ThePercentileIsOfTheMaskedArea) {
  // 100 triangles of one area, each with points of its own, squeezed to alpha 1, 2, ... 100.
  pipeline::Surface surface;
  std::vector<float> alpha, strength(300, 1.0f);
  std::vector<bool> covered(100, true);
  for (uint32_t t = 0; t < 100; ++t) {
    const float x = static_cast<float>(t);
    for (const glm::vec3 p : {glm::vec3(x, 0, 0), glm::vec3(x + 1, 0, 0), glm::vec3(x, 1, 0)}) {
      surface.vertex_point.push_back(static_cast<uint32_t>(surface.point_positions.size()));
      surface.point_positions.push_back(p);
      alpha.push_back(x + 1.0f);
    }
    surface.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  EXPECT_EQ(pipeline::percentile95(surface, covered, strength, alpha), 95.0);
  surface.point_positions[3 * 99 + 1].x += 9.0f;  // the last one ten times as large: 10 of 109
  EXPECT_EQ(pipeline::percentile95(surface, covered, strength, alpha), 100.0);
  for (int c = 0; c < 3; ++c) strength[3 * 99 + c] = 0.09f;  // a mask makes it 0.9 of 99.9
  EXPECT_EQ(pipeline::percentile95(surface, covered, strength, alpha), 95.0);
  for (size_t t = 50; t < 100; ++t) covered[t] = false;  // 48 of 50 is above 95%
  EXPECT_EQ(pipeline::percentile95(surface, covered, strength, alpha), 48.0);
  EXPECT_EQ(pipeline::percentile95(surface, std::vector<bool>(100), strength, alpha), 1.0);
}

// Two materials of one mesh meet, one finely cut and one coarsely: a vertex of either side lies where the
// other's does, to the bit, so that nothing shows through between them.
TEST(KnownAnswers, NoCrackBetweenTheMaterialsOfAMesh) {
  for (const pipeline::GeometryCodec codec :
       {pipeline::GeometryCodec::kDraco, pipeline::GeometryCodec::kRaw}) {
    Primitive fine = sheet(24), coarse = sheet(24);
    for (glm::vec3& p : fine.positions) p = {0.37f * p.x - 0.21f, 0.61f * p.y + 0.013f, 0.1f * p.x * p.y};
    for (glm::vec3& p : coarse.positions)
      p = {0.37f * 1.0f - 0.21f + 9.0f * p.x, 0.61f * p.y + 0.013f, 0.1f * p.y + 3.0f * p.x};
    // Where an exporter has jittered the border by rounding, too.
    coarse.positions[0].y = std::nextafter(coarse.positions[0].y, 1.0f);
    SourceScene scene = twoParts(fine, coarse);
    const Asset asset = cookAsset(std::move(scene), recipeOf({axisLayer({1, 0, 0})}), codec);
    const AssetView& view = asset.view();
    EXPECT_EQ(view.pointCount(), 25u * 25u * 2u - 25u);
    for (uint32_t v = 0; v < view.vertexCount(); ++v) {
      const Float3 p = view.positions[v], stands = view.positions[view.point_vertex[view.vertex_point[v]]];
      ASSERT_EQ(p.x, stands.x) << v;
      ASSERT_EQ(p.y, stands.y) << v;
      ASSERT_EQ(p.z, stands.z) << v;
    }
  }
}

// A roof of two materials without normals: they are smooth over its ridge, as within a material.
TEST(KnownAnswers, NormalsThatAreMissingAreSmoothOverMaterials) {
  Primitive left = sheet(4), right = sheet(4);
  for (glm::vec3& p : left.positions) p = {p.x - 1.0f, p.y, 0.5f * (p.x - 1.0f)};
  for (glm::vec3& p : right.positions) p.z = -0.5f * p.x;
  SourceScene scene = twoParts(left, right);
  const Asset asset = cookAsset(std::move(scene), recipeOf({axisLayer({1, 0, 0})}));
  const AssetView& view = asset.view();
  ASSERT_EQ(view.pointCount(), 45u);
  for (uint32_t v = 0; v < view.vertexCount(); ++v) {
    const float x = view.positions[v].x;
    const glm::vec3 wanted =
        std::abs(x) < 1e-4f ? glm::vec3(0, 0, 1) : glm::normalize(glm::vec3(x < 0.0f ? -0.5f : 0.5f, 0, 1));
    EXPECT_NEAR(view.normals[v].x, wanted.x, 2e-3f) << x;
    EXPECT_NEAR(view.normals[v].z, wanted.z, 2e-3f) << x;
  }
}

// Two meshes that meet list their targets in other orders, and two targets of each have one name.
TEST(KnownAnswers, TargetsOfOneNameDoNotOpenASeam) {
  constexpr uint32_t kTargets = 40;
  Primitive left = sheet(1), right = sheet(1);
  for (glm::vec3& p : right.positions) p.x += 1.0f;
  SourceScene scene = twoParts(left, right);
  scene.parts[1].first_morph = kTargets;
  for (uint32_t part = 0; part < 2; ++part)
    for (uint32_t m = 0; m < kTargets; ++m) {
      const uint32_t kind = part == 0 ? m : (m + 20) % kTargets;
      const float far = 0.1f * static_cast<float>(1 + kind);
      scene.primitives[part].morphs.push_back({{0, 1, 2, 3}, std::vector<glm::vec3>(4, {0, 0, far}), {}});
      scene.rig.morphs.push_back({kind < 20 ? "same" : "target" + std::to_string(kind), 0, m, 0.0});
    }
  EXPECT_EQ(cookAsset(std::move(scene), recipeOf({axisLayer({1, 0, 0})})).view().pointCount(), 6u);
}

// What a layer is painted with counts on its own parts, and up to their border.
TEST(KnownAnswers, MasksAndBiasesReachTheBorderOfTheirMaterial) {
  SourceScene scene = sceneOf(sheet(8), [](glm::dvec3 p) { return p; });
  pipeline::Attribute paint{"_PAINT", 2, {}};
  for (const glm::vec3& p : scene.primitives[0].positions)
    paint.values.insert(paint.values.end(), {0.2f + 0.6f * p.y, 0.9f});
  scene.primitives[0].attributes.push_back(paint);
  scene.primitives.push_back(scene.primitives[0]);
  for (glm::vec3& p : scene.primitives[1].positions) p.x += 1.0f;
  scene.parts.push_back(scene.parts[0]);
  scene.parts[1].primitive = 1;
  scene.materials.resize(2);
  scene.materials[0].name = "skin";
  scene.materials[1].name = "lips";
  scene.parts[0].material = 0;
  scene.parts[1].material = 1;
  pipeline::LayerRecipe layer = axisLayer({1, 0, 0});
  layer.materials = {"skin"};
  layer.mask = pipeline::MaskAttribute{"_PAINT", 0};
  layer.bias = pipeline::Bias{"_PAINT", 1, 0.5};
  const Asset asset = cookAsset(scene, recipeOf({layer}));
  const AssetView& view = asset.view();
  ASSERT_EQ(view.pointCount(), 9u * 17u);
  for (uint32_t v = 0; v < view.vertexCount(); ++v) {
    const Float3 p = view.positions[v];
    const bool within = p.x < 1.01f;
    EXPECT_NEAR(view.layers[0].mask[v] / 255.0f, within ? 0.2f + 0.6f * p.y : 0.0f, 0.003f) << p.x;
    EXPECT_NEAR(view.layers[0].bias[v] / 32767.0f, within ? 0.8f : 0.0f, 1e-4f) << p.x;
  }
}

}  // namespace
}  // namespace furrow::tests
