// An engine's own buffers, made of the source in the ways importers change it, against the points that the
// cook gave the source's vertices.

#include "furrow/bind.h"

#include <gtest/gtest.h>

#include <random>

#include "sheets.h"

namespace furrow::tests {
namespace {

struct Mesh {
  std::vector<Float3> positions;
  std::vector<uint32_t> indices;
  std::vector<uint32_t> source;  // vertex of the source
};

Mesh meshOf(const SourceScene& scene) {
  Mesh mesh;
  for (const pipeline::Part& part : scene.parts) {
    const Primitive& primitive = scene.primitives[part.primitive];
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    for (const glm::vec3& p : primitive.positions) {
      mesh.source.push_back(static_cast<uint32_t>(mesh.positions.size()));
      mesh.positions.push_back({p.x, p.y, p.z});
    }
    for (uint32_t index : primitive.indices) mesh.indices.push_back(first + index);
  }
  return mesh;
}

// Every triangle gets vertices of its own, a third of them shared again; vertices and triangles are shuffled.
Mesh reordered(const Mesh& mesh, uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<uint32_t> triangles(mesh.indices.size() / 3), copies, corners(mesh.indices.size());
  for (uint32_t t = 0; t < triangles.size(); ++t) triangles[t] = t;
  std::shuffle(triangles.begin(), triangles.end(), random);
  std::vector<uint32_t> shared(mesh.positions.size(), kAbsent);
  for (size_t i = 0; i < corners.size(); ++i) {
    const uint32_t vertex = mesh.indices[3 * triangles[i / 3] + i % 3];
    uint32_t& copy = shared[vertex];
    if (copy == kAbsent || random() % 3 != 0) {
      copy = static_cast<uint32_t>(copies.size());
      copies.push_back(vertex);
    }
    corners[i] = copy;
  }
  std::vector<uint32_t> at(copies.size());
  for (uint32_t i = 0; i < at.size(); ++i) at[i] = i;
  std::shuffle(at.begin(), at.end(), random);
  Mesh out;
  out.positions.resize(copies.size());
  out.source.resize(copies.size());
  for (size_t i = 0; i < copies.size(); ++i) {
    out.positions[at[i]] = mesh.positions[copies[i]];
    out.source[at[i]] = mesh.source[copies[i]];
  }
  for (uint32_t corner : corners) out.indices.push_back(at[corner]);
  return out;
}

struct Bound {
  BindCounts counts;
  std::vector<uint32_t> points;
};

Bound bind(const AssetView& asset, const Mesh& mesh, float tolerance = 0.0f, const Affine& to_root = {}) {
  Bound bound;
  bound.points.resize(mesh.positions.size());
  BindJob job{&asset, mesh.positions, mesh.indices, to_root, tolerance, {}, bound.points};
  std::vector<uint32_t> scratch(job.scratchSize());
  job.scratch = scratch;
  const Status status = job.validate();
  EXPECT_TRUE(status.ok()) << status.message;
  if (status.ok()) bound.counts = job.run();
  EXPECT_EQ(bound.counts.matched + bound.counts.ambiguous + bound.counts.unmatched, mesh.positions.size());
  return bound;
}

std::vector<uint32_t> sourcePoints(const AssetView& asset) {
  std::vector<uint32_t> points(asset.vertexCount());
  for (uint32_t v = 0; v < asset.vertexCount(); ++v) points[asset.source_vertex[v]] = asset.vertex_point[v];
  return points;
}

void expectTheSourcesPoints(const AssetView& asset, const Mesh& mesh, const Bound& bound) {
  const std::vector<uint32_t> expected = sourcePoints(asset);
  EXPECT_EQ(bound.counts.matched, mesh.positions.size());
  for (size_t v = 0; v < mesh.positions.size(); ++v)
    ASSERT_EQ(bound.points[v], expected[mesh.source[v]]) << "vertex " << v;
}

// A bent sheet with hills, cut along a line by a second primitive that shares its border; its morph squeezes.
SourceScene hills() {
  const auto raise = [](Primitive primitive, float x) {
    for (glm::vec3& p : primitive.positions)
      p = {p.x + x, p.y, 0.2f * std::sin(7.0f * (p.x + x)) * std::cos(5.0f * p.y)};
    return primitive;
  };
  SourceScene scene = sceneOf(raise(sheet(12), 0.0f),
                              [](glm::dvec3 p) { return glm::dvec3(p.x * (0.6 + 0.3 * p.y), p.y, p.z); });
  scene.primitives.push_back(raise(sheet(12), 1.0f));
  scene.primitives[1].morphs.emplace_back();
  scene.parts.push_back(scene.parts[0]);
  scene.parts[1].primitive = 1;
  return scene;
}

// Two sheets that lie upon each other with all their vertices but one row each, the lower one a row longer
// and moved away by the morph: what a sleeve does upon an arm.
SourceScene sleeve() {
  Primitive both = sheet(6), upper = sheet(6);
  for (glm::vec3& p : upper.positions)
    if (p.y == 1.0f) p.z = 0.25f;
  const auto first = static_cast<uint32_t>(both.positions.size());
  both.positions.insert(both.positions.end(), upper.positions.begin(), upper.positions.end());
  both.uvs.insert(both.uvs.end(), upper.uvs.begin(), upper.uvs.end());
  for (uint32_t index : upper.indices) both.indices.push_back(first + index);
  uint32_t vertex = 0;
  return sceneOf(both, [&vertex, first](glm::dvec3 p) {
    return vertex++ < first ? glm::dvec3(p.x, p.y, p.z - 0.5 - 0.1 * p.x * p.x)
                            : glm::dvec3(0.8 * p.x, p.y, p.z);
  });
}

TEST(Bind, AShuffledResplitCopyHasTheSameWeightsPermuted) {
  for (const auto codec : {pipeline::GeometryCodec::kDraco, pipeline::GeometryCodec::kRaw}) {
    const SourceScene scene = hills();
    const Asset asset = cookAsset(scene, recipeOf({axisLayer({1, 0, 0})}), codec);
    const AssetView& view = asset.view();
    const Frame frame = evaluate(view, {1.0f});
    const Mesh mesh = reordered(meshOf(scene), 1);
    const Bound bound = bind(view, mesh);
    ASSERT_EQ(bound.counts.matched, mesh.positions.size());
    for (size_t v = 0; v < mesh.positions.size(); ++v)
      ASSERT_EQ(frame.weights[size_t{view.point_vertex[bound.points[v]]} * view.weightStride()] / 32767.0,
                frame.weight[mesh.source[v]]);
  }
}

TEST(Bind, SurfacesThatTouchAreToldApartByTheirTriangles) {
  const SourceScene scene = sleeve();
  const Asset asset = cookAsset(scene, recipeOf({axisLayer({1, 0, 0})}));
  ASSERT_EQ(asset.view().pointCount(), 2 * 49u);
  ASSERT_EQ(asset.view().place_points.size() / 2, 56u);  // 42 places of two points, 14 of one
  for (uint32_t seed = 1; seed < 6; ++seed) {
    const Mesh mesh = reordered(meshOf(scene), seed);
    expectTheSourcesPoints(asset.view(), meshOf(scene), bind(asset.view(), meshOf(scene)));
    const Bound bound = bind(asset.view(), mesh);
    EXPECT_EQ(bound.counts.unmatched, 0u);
    const std::vector<uint32_t> expected = sourcePoints(asset.view());
    for (size_t v = 0; v < mesh.positions.size(); ++v)
      if (bound.points[v] != kAmbiguous) {
        ASSERT_EQ(bound.points[v], expected[mesh.source[v]]) << v;
      }
  }
}

TEST(Bind, WithoutTrianglesWhatTouchesIsAmbiguous) {
  const SourceScene scene = sleeve();
  const Asset asset = cookAsset(scene, recipeOf({axisLayer({1, 0, 0})}));
  Mesh mesh = meshOf(scene);
  mesh.indices.clear();
  const Bound bound = bind(asset.view(), mesh);
  EXPECT_EQ(bound.counts.ambiguous, 84u);
  EXPECT_EQ(bound.counts.matched, 14u);
}

// A vertex that an importer merged from both surfaces belongs to neither.
TEST(Bind, AVertexOfTwoPointsIsAmbiguous) {
  Primitive lips;
  lips.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {1, 0, 0}, {0, -1, 0}};
  lips.indices = {0, 1, 2, 3, 5, 4};
  uint32_t vertex = 0;
  const SourceScene scene =
      sceneOf(lips, [&vertex](glm::dvec3 p) { return vertex++ < 3 ? p : p - glm::dvec3(0, 0.3, 0); });
  const Asset asset = cookAsset(scene, recipeOf({axisLayer({1, 0, 0})}));
  expectTheSourcesPoints(asset.view(), meshOf(scene), bind(asset.view(), meshOf(scene)));
  Mesh merged = meshOf(scene);
  merged.indices = {0, 1, 2, 0, 5, 4};
  const Bound bound = bind(asset.view(), merged);
  EXPECT_EQ(bound.points[0], kAmbiguous);
  EXPECT_EQ(bound.points[3], kAmbiguous);  // in no triangle
  EXPECT_EQ(bound.counts.ambiguous, 2u);
}

// Another unit, another upward axis, a rotation: the positions are rounded, so a tolerance finds them and the
// hash alone does not.
TEST(Bind, OtherUnitsAndAxesNeedASimilarityAndATolerance) {
  for (const SourceScene& scene : {hills(), sleeve()}) {
    const Asset asset = cookAsset(scene, recipeOf({axisLayer({1, 0, 0})}));
    Mesh mesh = reordered(meshOf(scene), 4);
    const float c = std::cos(0.7f), s = std::sin(0.7f);
    for (Float3& p : mesh.positions) {  // centimetres, z up, turned about it, moved
      const Float3 q = {100.0f * p.x, -100.0f * p.z, 100.0f * p.y};
      p = {c * q.x - s * q.y + 37.0f, s * q.x + c * q.y - 11.0f, q.z + 5.0f};
    }
    // q = R^-1 (p - t), then (x, z, -y) / 100.
    const float tx = -(c * 37.0f + s * -11.0f), ty = -(-s * 37.0f + c * -11.0f), k = 0.01f;
    const Affine back = {{k * c, k * s, 0, k * tx, 0, 0, k, k * -5.0f, k * s, k * -c, 0, k * -ty}};
    EXPECT_GT(bind(asset.view(), mesh, 0.0f, back).counts.unmatched, 0u);
    const Bound bound = bind(asset.view(), mesh, 1e-5f, back);
    EXPECT_EQ(bound.counts.unmatched, 0u);
    const std::vector<uint32_t> expected = sourcePoints(asset.view());
    size_t same = 0;
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
      same += bound.points[v] == expected[mesh.source[v]];
      if (bound.points[v] != kAmbiguous) {
        ASSERT_EQ(bound.points[v], expected[mesh.source[v]]) << v;
      }
    }
    EXPECT_EQ(same, bound.counts.matched);
    EXPECT_EQ(bind(asset.view(), mesh, 1e-5f).counts.matched, 0u);  // without the similarity
  }
}

TEST(Bind, BetweenTwoPlacesWhatRoundingWouldDecideIsAmbiguous) {
  const Asset asset = cookAsset(hills(), recipeOf({axisLayer({1, 0, 0})}));
  const AssetView& view = asset.view();
  ASSERT_GT(view.position_error, 0.0f);
  // A neighbour of the first point, and places between the two.
  const Float3 a = view.positions[0], b = view.positions[view.indices[view.indices[0] == 0 ? 1 : 0]];
  const float length = std::hypot(b.x - a.x, b.y - a.y, b.z - a.z);
  for (const auto& [off, ambiguous] : {std::pair{0.5f, 1u}, {4.0f, 0u}}) {
    const float t = 0.5f + off * view.position_error / length;
    Mesh mesh;
    mesh.positions = {{a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.z + t * (b.z - a.z)}};
    EXPECT_EQ(bind(view, mesh, 0.51f * length).counts.ambiguous, ambiguous) << off;
  }
}

TEST(Bind, AStrangerIsRefused) {
  const Asset asset = cookAsset(hills(), recipeOf({axisLayer({1, 0, 0})}));
  Mesh stranger = meshOf(hills());
  for (Float3& p : stranger.positions) p.z += 0.03f;
  EXPECT_EQ(bind(asset.view(), stranger).counts.unmatched, stranger.positions.size());
  EXPECT_EQ(bind(asset.view(), stranger, 1e-3f).counts.matched, 0u);
  Mesh moved = meshOf(hills());
  moved.positions[17].y = std::nextafter(moved.positions[17].y, 2.0f);
  EXPECT_EQ(bind(asset.view(), moved).points[17], kUnmatched);
  EXPECT_EQ(bind(asset.view(), moved).counts.unmatched, 1u);
}

// The check value alone would let 2 to 30 of these pass.
TEST(Bind, OfAMillionStrangersNoneIsTakenForAPlace) {
  const Asset asset = cookAsset(hills(), recipeOf({axisLayer({1, 0, 0})}));
  std::mt19937 random(7);
  const auto unit = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
  Mesh strangers;
  for (int i = 0; i < 1000000; ++i)
    strangers.positions.push_back({2.0f * unit(), unit(), 0.4f * unit() - 0.2f});
  EXPECT_EQ(bind(asset.view(), strangers).counts.unmatched, strangers.positions.size());
}

TEST(Bind, APlacedMeshIsFoundFromItsOwnSpaceThroughThePartsRest) {
  SourceScene scene = hills();
  scene.rig.nodes[0].scale = glm::dvec3(0.3);
  scene.rig.nodes[0].translation = {0.1, -0.7, 5.0};
  scene.rig.nodes[0].rotation = glm::angleAxis(0.4, glm::normalize(glm::dvec3(1, 2, 3)));
  const Asset asset = cookAsset(scene, recipeOf({axisLayer({1, 0, 0})}));
  expectTheSourcesPoints(asset.view(), meshOf(scene),
                         bind(asset.view(), meshOf(scene), 0.0f, asset.view().parts[0].rest));
}

TEST(Bind, PositionsThatAreNotNumbersAreUnmatched) {
  const Asset asset = cookAsset(hills(), recipeOf({axisLayer({1, 0, 0})}));
  Mesh mesh;
  mesh.positions = {{NAN, 0, 0}, {INFINITY, -INFINITY, 0}, {3e38f, 3e38f, 3e38f}};
  for (const float tolerance : {0.0f, 0.01f, 1e30f})
    EXPECT_EQ(bind(asset.view(), mesh, tolerance).counts.matched, 0u);
}

TEST(Bind, RefusesSizesAndIndicesThatDoNotFit) {
  const Asset asset = cookAsset(hills(), recipeOf({axisLayer({1, 0, 0})}));
  Mesh mesh = meshOf(hills());
  std::vector<uint32_t> points(mesh.positions.size()), scratch(asset.view().pointCount());
  const BindJob good{&asset.view(), mesh.positions, mesh.indices, {}, 0.0f, scratch, points};
  ASSERT_TRUE(good.validate().ok());
  const auto refused = [&](auto change) {
    BindJob job = good;
    change(job);
    return job.validate().code == StatusCode::kInvalidArgument;
  };
  EXPECT_TRUE(refused([](BindJob& job) { job.asset = nullptr; }));
  EXPECT_TRUE(refused([](BindJob& job) { job.points = job.points.first(3); }));
  EXPECT_TRUE(refused([](BindJob& job) { job.scratch = job.scratch.first(3); }));
  EXPECT_TRUE(refused([](BindJob& job) { job.tolerance = 0.1f; }));  // needs more scratch
  EXPECT_TRUE(refused([](BindJob& job) { job.tolerance = -0.1f; }));
  EXPECT_TRUE(refused([](BindJob& job) { job.tolerance = NAN; }));
  EXPECT_TRUE(refused([](BindJob& job) { job.to_root.m[3] = INFINITY; }));
  EXPECT_TRUE(refused([](BindJob& job) { job.indices = job.indices.first(4); }));
  mesh.indices[5] = static_cast<uint32_t>(mesh.positions.size());
  EXPECT_FALSE(good.validate().ok());
}

}  // namespace
}  // namespace furrow::tests
