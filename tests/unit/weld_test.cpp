// Places against all pairs, and points on scenes whose answer is plain.

#include "pipeline/bake/weld.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "furrow/place_hash.h"
#include "pipeline/bake/places.h"
#include "pipeline/error.h"
#include "pipeline/scene/rest.h"
#include "sheets.h"

namespace furrow::tests {
namespace {

using pipeline::findPlaces;
using pipeline::Places;
using pipeline::weld;
using pipeline::Weld;

// The same by all pairs, in double.
std::vector<uint32_t> placesByAllPairs(const std::vector<glm::vec3>& positions, double tolerance) {
  std::vector<uint32_t> parent(positions.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](uint32_t i) {
    while (parent[i] != i) i = parent[i];
    return i;
  };
  for (uint32_t i = 0; i < positions.size(); ++i)
    for (uint32_t j = 0; j < i; ++j) {
      const glm::dvec3 d = glm::dvec3(positions[i]) - glm::dvec3(positions[j]);
      if (glm::dot(d, d) <= tolerance * tolerance) {
        const uint32_t a = root(i), b = root(j);
        parent[std::max(a, b)] = std::min(a, b);
      }
    }
  std::vector<uint32_t> number(positions.size()), place(positions.size());
  uint32_t next = 0;
  for (uint32_t i = 0; i < positions.size(); ++i) {
    if (root(i) == i) number[i] = next++;
    place[i] = number[root(i)];
  }
  return place;
}

std::vector<uint32_t> placesOf(const std::vector<glm::vec3>& positions, float tolerance) {
  const std::optional<Places> places = findPlaces(positions, tolerance);
  EXPECT_TRUE(places.has_value());
  std::vector<uint32_t> out;
  for (uint32_t v = 0; places && v < positions.size(); ++v) {
    EXPECT_EQ(places->positions[places->vertex_position[v]], positions[v]);
    out.push_back(places->position_place[places->vertex_position[v]]);
  }
  EXPECT_EQ(places->count, out.empty() ? 0 : *std::max_element(out.begin(), out.end()) + 1);
  return out;
}

TEST(Places, EqualAllPairsOnRandomHeaps) {
  std::mt19937 random(1);
  for (const double size : {0.02, 0.3, 4.0, 70.0, 3000.0}) {  // edge of the heap, in tolerances
    const float tolerance = 0.01f;
    std::vector<glm::vec3> positions;
    std::uniform_real_distribution<float> at(-0.5f * static_cast<float>(size) * tolerance,
                                             0.5f * static_cast<float>(size) * tolerance);
    for (int i = 0; i < 600; ++i) {
      positions.emplace_back(at(random), at(random), at(random));
      if (i % 5 == 0) positions.push_back(positions[random() % positions.size()]);
    }
    EXPECT_EQ(placesOf(positions, tolerance), placesByAllPairs(positions, tolerance)) << size;
    EXPECT_EQ(placesOf(positions, 0.0f), placesByAllPairs(positions, 0.0)) << size;
  }
}

// Pairs exactly at the tolerance and just beyond it, across the borders of cells of 32 tolerances and around
// 0.
TEST(Places, NoPairWithinTheToleranceIsMissedAcrossCellBorders) {
  constexpr float kTolerance = 0.25f;
  for (const float border : {0.0f, 8.0f, -8.0f, 16.0f, 1024.0f, -4096.0f})
    for (int axes = 1; axes < 8; ++axes)
      for (int step = -16; step <= 16; ++step) {
        glm::vec3 a(3.0f), along(0.0f);
        for (int axis = 0; axis < 3; ++axis)
          if (axes >> axis & 1) {
            a[axis] = border + 0.015625f * static_cast<float>(step);
            along[axis] = 1.0f;
          }
        const int count = (axes & 1) + (axes >> 1 & 1) + (axes >> 2);
        const glm::vec3 in = along * (count == 1 ? kTolerance : 0.140625f),  // 0.140625 sqrt(3) < 0.25
            out = along * (kTolerance + 0.0009765625f);
        EXPECT_EQ(placesOf({a, a + in}, kTolerance), (std::vector<uint32_t>{0, 0}));
        EXPECT_EQ(placesOf({a + in, a}, kTolerance), (std::vector<uint32_t>{0, 0}));
        EXPECT_EQ(placesOf({a, a + out}, kTolerance), (std::vector<uint32_t>{0, 1}));
      }
}

TEST(Places, AreClosedUnderChains) {
  std::vector<glm::vec3> chain;
  for (int i = 0; i < 1000; ++i) chain.emplace_back(0.1f * static_cast<float>(i), 0.0f, 0.0f);
  std::shuffle(chain.begin(), chain.end(), std::mt19937(2));
  EXPECT_EQ(placesOf(chain, 0.101f), std::vector<uint32_t>(1000, 0));
  EXPECT_EQ(findPlaces(chain, 0.09f)->count, 1000u);
}

TEST(Places, MinusZeroIsZero) {
  const std::vector<glm::vec3> positions = {{0.0f, -0.0f, 1.0f}, {-0.0f, 0.0f, 1.0f}};
  EXPECT_EQ(placesOf(positions, 0.0f), (std::vector<uint32_t>{0, 0}));
  EXPECT_EQ(placesOf(positions, 1e-30f), (std::vector<uint32_t>{0, 0}));
}

TEST(Places, TakeExtremeNumbersAndNone) {
  EXPECT_EQ(placesOf({}, 0.0f).size(), 0u);
  EXPECT_EQ(placesOf({}, 1.0f).size(), 0u);
  const std::vector<glm::vec3> far = {{3e38f, -3e38f, 0.0f}, {-3e38f, 1e-45f, 0.0f}, {3e38f, -3e38f, 0.0f}};
  for (const float tolerance : {0.0f, 1e-45f, 1e-6f, 1.0f, 1e30f})
    EXPECT_EQ(placesOf(far, tolerance), (std::vector<uint32_t>{0, 1, 0})) << tolerance;
}

TEST(Places, AToleranceThatWouldTakeForEverIsRefused) {
  std::vector<glm::vec3> heap;
  std::mt19937 random(3);
  for (int i = 0; i < 20000; ++i) heap.emplace_back(random() % 65536, random() % 65536, random() % 65536);
  EXPECT_FALSE(findPlaces(heap, 1e5f).has_value());
  EXPECT_TRUE(findPlaces(heap, 10.0f).has_value());
}

// Two sheets side by side in two primitives of one mesh; the right one's border is off by `gap` from the left
// one's.
SourceScene twoSheets(float gap) {
  SourceScene scene = sceneOf(sheet(6), [](glm::dvec3 p) { return p; });
  Primitive right = sheet(6);
  for (glm::vec3& p : right.positions) p.x += 1.0f + gap;
  right.morphs.emplace_back();
  scene.primitives.push_back(right);
  scene.parts.push_back(scene.parts[0]);
  scene.parts[1].primitive = 1;
  return scene;
}

TEST(Weld, ByDefaultRoundingOpensNoSeamAndNothingElseIsClosed) {
  constexpr uint32_t kVertices = 2 * 49, kBorder = 7;
  EXPECT_EQ(weld(twoSheets(0.0f), {})->points, kVertices - kBorder);
  EXPECT_EQ(weld(twoSheets(2.4e-7f), {})->points, kVertices - kBorder);
  EXPECT_EQ(weld(twoSheets(1e-4f), {})->points, kVertices);
  EXPECT_EQ(weld(twoSheets(2.4e-7f), 0.0)->points, kVertices);  // equal bits alone
  EXPECT_EQ(weld(twoSheets(1e-3f), 0.0011)->points, kVertices - kBorder);
  const float tolerance = weld(twoSheets(0.0f), {})->tolerance;
  EXPECT_NEAR(tolerance, 8.0 * 0x1p-23 * 2.0, 1e-12);
  EXPECT_EQ(weld(twoSheets(1e-3f), 0.0011)->tolerance, 0.0011f);
}

TEST(Weld, FarFromTheOriginNoEdgeIsClosed) {
  SourceScene scene = twoSheets(0.0f);
  for (Primitive& primitive : scene.primitives)
    for (glm::vec3& p : primitive.positions) p += glm::vec3(4e5f, 0.0f, 0.0f);  // a step of floats is 1/32
  const std::optional<Weld> welded = weld(scene, {});
  EXPECT_LT(welded->tolerance, 1.0f / 6.0f / 10.0f);
  EXPECT_EQ(welded->places, 2 * 49u - 7u);
}

TEST(Weld, PositionsThatAreNoNumbersAreRefused) {
  for (const float wrong : {NAN, INFINITY, -2e18f})
    for (int axis = 0; axis < 3; ++axis) {
      glm::vec3 position(0.25f);
      position[axis] = wrong;
      EXPECT_THROW(pipeline::requireInRange({}, {&position, 1}), pipeline::Error) << wrong << ' ' << axis;
    }
}

TEST(Weld, AMeshTooSmallForItsSquaresIsRefused) {
  for (const float size : {0.0f, 1e-17f, 1e-19f, 1e-30f}) {
    const glm::vec3 positions[] = {{0, 0, 0}, {0, size, 0}};
    if (size == 0.0f || size > 1e-18f)
      EXPECT_NO_THROW(pipeline::requireInRange({}, positions)) << size;
    else
      EXPECT_THROW(pipeline::requireInRange({}, positions), pipeline::Error) << size;
  }
}

// Every different source position leads through the hash to its place.
TEST(Weld, JitteredPositionsAreKeysOfOnePlace) {
  const SourceScene scene = twoSheets(2.4e-7f);
  const std::optional<Weld> welded = weld(scene, {});
  EXPECT_EQ(welded->slot_place.size(), 2 * 49u);
  PlaceHash hash;
  ASSERT_TRUE(hash.open(welded->hash).ok());
  const std::vector<glm::vec3> positions = pipeline::sourcePositions(scene);
  for (size_t v = 0; v < positions.size(); ++v) {
    const auto slot = hash.find({positions[v].x, positions[v].y, positions[v].z});
    ASSERT_TRUE(slot.has_value());
    EXPECT_EQ(welded->slot_place[*slot], welded->vertex_place[v]);
  }
}

// Vertices at one place: plain, the joints in another order, an 8-bit rounding of the weights, one that moves
// with another joint, a joint that counts twice, and weights that no rounding makes; then the same on a rigid
// mesh of the first joint's node.
TEST(Weld, JointsAreComparedByNodeWhateverTheirOrder) {
  SourceScene scene;
  scene.rig.nodes.resize(3);
  scene.rig.palette = {{0, glm::dmat4(1.0)}, {1, glm::dmat4(1.0)}, {2, glm::dmat4(1.0)}};
  Primitive skin;
  skin.positions.assign(6, glm::vec3(0.0f));
  skin.influences = 4;
  skin.joints = {0, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0};
  skin.weights = {0.7f, 0.3f, 0, 0, 0.3f, 0.7f, 0,    0, 0.698f, 0.302f, 0, 0,
                  0.7f, 0.3f, 0, 0, 0.5f, 0.2f, 0.3f, 0, 0.695f, 0.305f, 0, 0};
  scene.primitives = {skin};
  scene.parts.resize(1);
  scene.parts[0].skinned = true;
  scene.parts[0].palette_count = 3;
  EXPECT_EQ(weld(scene, {})->vertex_point, (std::vector<uint32_t>{0, 0, 0, 1, 0, 2}));

  Primitive rigid;
  rigid.positions = {{0.0f, 0.0f, 0.0f}};
  scene.primitives.push_back(rigid);
  scene.parts.emplace_back().primitive = 1;
  scene.primitives[0].joints.insert(scene.primitives[0].joints.end(), {0, 0, 0, 0});
  scene.primitives[0].weights.insert(scene.primitives[0].weights.end(), {1, 0, 0, 0});
  scene.primitives[0].positions.emplace_back(0.0f);
  EXPECT_EQ(weld(scene, {})->vertex_point, (std::vector<uint32_t>{0, 0, 0, 1, 0, 2, 3, 3}));
}

TEST(Weld, ARestFromAnotherFilePartsWhatItMovesApart) {
  const SourceScene scene = twoSheets(0.0f);
  std::vector<glm::dvec3> offsets(2 * 49, glm::dvec3(0.0, 0.0, 0.1));
  EXPECT_EQ(weld(scene, {}, offsets)->points, 2 * 49u - 7u);
  for (size_t v = 49; v < offsets.size(); ++v) offsets[v].z = 0.2;
  EXPECT_EQ(weld(scene, {}, offsets)->points, 2 * 49u);
}

// Also where positions must be equal to the bit, as exporters round displacements by themselves.
TEST(Weld, DisplacementsMayDifferByRounding) {
  SourceScene scene = twoSheets(0.0f);
  scene.rig.morphs = {{"up", 0, 0, 0.0}};
  const auto upBy = [&](float left, float right) {
    const auto all = [](float z) {
      MorphDelta delta;
      for (uint32_t v = 0; v < 49; ++v) delta.vertices.push_back(v);
      delta.positions.assign(49, {0.0f, 0.0f, z});
      return delta;
    };
    scene.primitives[0].morphs = {all(left)};
    scene.primitives[1].morphs = {all(right)};
    return weld(scene, 0.0)->points;
  };
  EXPECT_EQ(upBy(0.3f, std::nextafter(0.3f, 1.0f)), 2 * 49u - 7u);
  EXPECT_EQ(upBy(0.3f, 0.301f), 2 * 49u);
}

TEST(Weld, TheAssetIsAtRestWherePositionsWereJittered) {
  const Asset asset = cookAsset(twoSheets(2.4e-7f), recipeOf({axisLayer({1, 0, 0})}));
  EXPECT_EQ(asset.view().pointCount(), 2 * 49u - 7u);
  for (double alpha : evaluate(asset.view(), {0.0f}).alpha)
    EXPECT_NEAR(alpha, 1.0, 8.0 * 0x1p-23 * 2.0 / 0.11);
}

}  // namespace
}  // namespace furrow::tests
