// What is done beside and after the four stages, by known answers: Laplacian steps, attack and release, fade,
// rest recapture.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "furrow/recapture.h"
#include "sheets.h"

namespace {

using namespace furrow;

Asset sheetAsset(uint32_t n, const std::function<glm::dvec3(glm::dvec3)>& deform,
                 std::vector<pipeline::LayerRecipe> layers) {
  return tests::cookAsset(tests::sceneOf(tests::sheet(n), deform), tests::recipeOf(std::move(layers)));
}

glm::dvec3 squeeze(glm::dvec3 p) {
  return {0.7 * p.x, p.y, 0.0};
}

struct Field {
  const AssetView& view;
  std::vector<float> triangle_q, q, out;
  explicit Field(const AssetView& v)
      : view(v), triangle_q(v.triangleCount(), 1.0f), q(v.pointCount(), 1.0f), out(v.pointCount()) {}
  void step(float rate) {
    const LaplaceJob job{&view, triangle_q, q, rate, out};
    ASSERT_TRUE(job.validate().ok());
    job.run(0, 7);
    job.run(7, view.pointCount());
    std::swap(q, out);
  }
  Float3 at(uint32_t point) const { return view.positions[view.point_vertex[point]]; }
};

TEST(Laplace, ConstantAndLinearFieldsStay) {
  const Asset asset = sheetAsset(12, squeeze, {tests::axisLayer({1, 0, 0})});
  Field field(asset.view());
  field.q.assign(field.q.size(), 0.625f);
  for (int i = 0; i < 5; ++i) field.step(1.0f);
  for (float q : field.q) EXPECT_FLOAT_EQ(q, 0.625f);
  // Rings of the sheet's inner points are symmetric, so a linear field has no Laplacian there.
  for (uint32_t p = 0; p < field.q.size(); ++p) field.q[p] = 1.0f + 0.5f * field.at(p).x;
  const std::vector<float> before = field.q;
  field.step(0.5f);
  for (uint32_t p = 0; p < field.q.size(); ++p) {
    const Float3 at = field.at(p);
    if (at.x > 0.01f && at.x < 0.99f && at.y > 0.01f && at.y < 0.99f) {
      EXPECT_NEAR(field.q[p], before[p], 1e-4) << at.x << " " << at.y;  // quantised positions and angles
    }
  }
}

// One triangle fan whose rim is at 2: the hub goes `rate` of the way.
TEST(Laplace, AStepGoesTheRateOfTheWay) {
  const Asset asset = sheetAsset(2, squeeze, {tests::axisLayer({1, 0, 0})});
  Field field(asset.view());
  uint32_t hub = 0;
  for (uint32_t p = 0; p < field.q.size(); ++p) {
    const Float3 at = field.at(p);
    if (std::abs(at.x - 0.5f) + std::abs(at.y - 0.5f) < 0.01f) hub = p;
    field.q[p] = 2.0f;
  }
  field.q[hub] = 1.0f;
  field.step(0.25f);
  EXPECT_NEAR(field.q[hub], 1.25f, 1e-6);
}

TEST(Laplace, TrianglesOutsideTheLayerSayNothing) {
  const Asset asset = sheetAsset(6, squeeze, {tests::axisLayer({1, 0, 0})});
  Field field(asset.view());
  for (uint32_t t = 0; t < field.triangle_q.size(); ++t) field.triangle_q[t] = -1.0f;
  for (uint32_t p = 0; p < field.q.size(); ++p) field.q[p] = field.at(p).x;
  const std::vector<float> before = field.q;
  field.step(1.0f);
  EXPECT_EQ(field.q, before);
  LaplaceJob job{&asset.view(), field.triangle_q, field.q, 0.5f, field.q};
  EXPECT_FALSE(job.validate().ok());  // in place
  job.out = field.out, job.rate = 1.5f;
  EXPECT_FALSE(job.validate().ok());
}

struct Eased {
  AssetView view;
  std::vector<Layer> layers;
  std::vector<Float3> positions = std::vector<Float3>(1);
  std::vector<float> state;
  std::vector<Ease> eases;
  explicit Eased(Ease ease) : layers(1), state(2, 0.0f), eases{ease} {
    view.layers = layers;
    view.positions = positions;
  }
  double step(double target, float seconds, bool reset = false, float fade = 1.0f) {
    std::vector<int16_t> weights = {static_cast<int16_t>(std::lround(target * 32767)), 0};
    const EaseJob job{&view, eases, seconds, reset, fade, state, weights};
    const Status status = job.validate();
    EXPECT_TRUE(status.ok()) << status.message;
    job.run(0, 1);
    return weights[0] / 32767.0;
  }
};

constexpr double kStep = 1.0 / 32767.0;

TEST(Ease, AttackAndReleaseFollowTheirRates) {
  Eased eased({4.0f, 1.0f});
  EXPECT_NEAR(eased.step(0.8, 0.25f), 0.8 * (1 - std::exp(-1.0)), kStep);
  EXPECT_NEAR(eased.step(0.8, 10.0f), 0.8, kStep);
  EXPECT_NEAR(eased.step(0.0, 1.0f), 0.8 * std::exp(-1.0), 1.1 * kStep);
  Eased stretch({4.0f, 1.0f});  // away from zero is attack on the stretch side too
  EXPECT_NEAR(stretch.step(-0.8, 0.25f), -0.8 * (1 - std::exp(-1.0)), kStep);
}

TEST(Ease, TwoHalfStepsAreOneStep) {
  for (const Ease ease : {Ease{7.0f, 2.0f}, Ease{0.3f, 30.0f}})
    for (double from : {0.0, 0.9, 0.4})
      for (double target : {1.0, 0.25, -0.0}) {
        Eased once(ease), twice(ease), often(ease);
        for (Eased* each : {&once, &twice, &often}) each->step(from, 0.0f, true);
        const double whole = once.step(target, 0.1f);
        twice.step(target, 0.05f);
        EXPECT_NEAR(twice.step(target, 0.05f), whole, kStep);
        double last = 0.0;
        for (int i = 0; i < 100; ++i) last = often.step(target, 0.001f);
        EXPECT_NEAR(last, whole, kStep);
      }
}

TEST(Ease, AtOnceByResetOrWithoutARate) {
  Eased eased({2.0f, 2.0f});
  EXPECT_NEAR(eased.step(0.7, 0.0f, true), 0.7, kStep);
  EXPECT_NEAR(eased.step(-0.3, 0.0f), 0.7, kStep);  // no time, no change
  for (float rate :
       {0.0f, -1.0f, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()}) {
    Eased now({rate, rate});
    EXPECT_NEAR(now.step(0.6, 0.001f), 0.6, kStep);
  }
}

TEST(Ease, FadeIsNotPartOfTheState) {
  Eased eased({4.0f, 1.0f});
  EXPECT_NEAR(eased.step(0.8, 0.25f, false, 0.25f), 0.2 * (1 - std::exp(-1.0)), kStep);
  EXPECT_NEAR(eased.step(0.8, 0.25f, false, 1.0f), 0.8 * (1 - std::exp(-2.0)), kStep);
  EXPECT_EQ(eased.step(0.8, 0.1f, false, 0.0f), 0.0);
  std::vector<int16_t> weights = {16384, 77};
  EaseJob job{&eased.view, {}, 0.0f, false, 0.5f, {}, weights};
  ASSERT_TRUE(job.validate().ok());
  job.run(0, 1);
  EXPECT_EQ(weights, (std::vector<int16_t>{8192, 77}));
  job.fade = 1.1f;
  EXPECT_FALSE(job.validate().ok());
  job.fade = 1.0f, job.seconds = -1.0f;
  EXPECT_FALSE(job.validate().ok());
  job.seconds = 0.0f, job.eases = eased.eases;
  EXPECT_FALSE(job.validate().ok());  // no state
}

pipeline::LayerRecipe measured(Measure measure) {
  pipeline::LayerRecipe layer = tests::axisLayer({1, 0, 0});
  layer.measure = measure;
  return layer;
}

// The view of an instance that was recaptured in a pose.
struct Own {
  std::vector<Layer> layers;
  std::vector<std::vector<float>> coefficients;
  AssetView view;
  Own(const AssetView& asset, const std::vector<Float3>& positions, float scale)
      : layers(asset.layers.begin(), asset.layers.end()), coefficients(layers.size()), view(asset) {
    for (uint32_t l = 0; l < layers.size(); ++l) {
      coefficients[l].resize(layers[l].coefficients.size());
      const RecaptureJob job{&asset, l, positions, scale, coefficients[l]};
      const Status status = job.validate();
      EXPECT_TRUE(status.ok()) << status.message;
      job.run(0, 5);
      job.run(5, asset.triangleCount());
      layers[l].coefficients = coefficients[l];
    }
    view.layers = layers;
  }
};

TEST(Recapture, ThePoseIsTheRest) {
  const Asset asset = sheetAsset(
      10, [](glm::dvec3 p) { return glm::dvec3(0.6 * p.x + 0.1 * p.y, 1.3 * p.y, 0.2 * p.x * p.x); },
      {measured(Measure::kDirectional), measured(Measure::kArea), measured(Measure::kPrincipal)});
  const tests::Frame posed = tests::evaluate(asset.view(), {1.0f});
  const Own own(asset.view(), posed.positions, 1.0f);
  const tests::Frame again = tests::evaluate(own.view, {1.0f});
  for (const auto& q : again.q)
    for (float each : q) EXPECT_NEAR(each, 1.0f, 2e-5);
  for (int16_t w : again.weights) EXPECT_LE(std::abs(w), 2);
  EXPECT_GT(std::abs(posed.weights[0]), 1000);  // it was no rest before
}

// Squeezed from 1 to 0.7 of its length, then measured from 0.7: back at 1 it is stretched by 1 / 0.7.
TEST(Recapture, TheOldRestIsStretched) {
  const Asset asset = sheetAsset(8, squeeze, {measured(Measure::kDirectional), measured(Measure::kArea)});
  const tests::Frame posed = tests::evaluate(asset.view(), {1.0f}, {}, 1.0f);
  const Own own(asset.view(), posed.positions, 1.0f);
  const tests::Frame rest = tests::evaluate(own.view, {0.0f});
  for (float q : rest.q[0]) EXPECT_NEAR(q, 1.0 / 0.49, 2e-3);
  for (float q : rest.q[1]) EXPECT_NEAR(q, 1.0 / 0.7, 1e-3);
}

// The direction is carried along: a sheet turned by a quarter is measured along what was x.
TEST(Recapture, TheDirectionTurnsWithTheSurface) {
  const Asset asset = sheetAsset(8, squeeze, {measured(Measure::kDirectional)});
  Affine quarter;
  quarter.m[0] = 0, quarter.m[1] = -2, quarter.m[4] = 2, quarter.m[5] = 0, quarter.m[10] = 2;  // and scale 2
  const tests::Frame turned = tests::evaluate(asset.view(), {0.0f}, quarter, 2.0f);
  const Own own(asset.view(), turned.positions, 2.0f);
  const tests::Frame frame = tests::evaluate(own.view, {1.0f}, quarter, 2.0f);
  for (float q : frame.q[0]) EXPECT_NEAR(q, 0.49, 1e-3);
}

TEST(Recapture, CollapsedTrianglesAreLeftOut) {
  const Asset asset =
      sheetAsset(4, squeeze, {measured(Measure::kDirectional), measured(Measure::kPrincipal)});
  std::vector<Float3> flat(asset.view().vertexCount(), Float3{1, 2, 3});
  flat[0].x = std::numeric_limits<float>::quiet_NaN();
  const Own own(asset.view(), flat, 1.0f);
  const tests::Frame frame = tests::evaluate(own.view, {1.0f});
  for (const auto& q : frame.q)
    for (float each : q) EXPECT_EQ(each, 1.0f);
  EXPECT_FALSE((RecaptureJob{&asset.view(), 0, flat, 0.0f, {}}).validate().ok());
}

}  // namespace
