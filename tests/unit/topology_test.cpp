// Surfaces that are no manifolds: each cooks, with both geometry codecs, is counted, and has finite weights.

#include <gtest/gtest.h>

#include "gltf_builder.h"
#include "pipeline/import/import.h"
#include "sheets.h"

namespace furrow::tests {
namespace {

using pipeline::CookReport;

CookReport cooked(SourceScene scene) {
  CookReport report;
  for (const auto codec : {pipeline::GeometryCodec::kDraco, pipeline::GeometryCodec::kRaw}) {
    pipeline::CookOptions options;
    options.geometry = codec;
    const pipeline::Cooked made = pipeline::cook(scene, recipeOf({axisLayer({1, 0, 0})}), options);
    report = made.report;
    Asset asset;
    const Status status = asset.load(made.bytes);
    EXPECT_TRUE(status.ok()) << status.message;
    for (const float squeeze : {0.0f, 1.0f}) {
      const Frame frame = evaluate(asset.view(), std::vector<float>(asset.view().morphs.size(), squeeze));
      for (const double alpha : frame.alpha) EXPECT_TRUE(std::isfinite(alpha));
      for (const double weight : frame.weight) EXPECT_LE(std::abs(weight), 1.0);
    }
  }
  return report;
}

SourceScene squeezed(Primitive primitive) {
  return sceneOf(std::move(primitive), [](glm::dvec3 p) { return glm::dvec3(0.7 * p.x, p.y, p.z); });
}

TEST(Topology, ASheetHasItsBorderAndNothingElse) {
  const CookReport report = cooked(squeezed(sheet(4)));
  EXPECT_EQ(report.topology.border_edges, 16u);
  EXPECT_EQ(report.topology.non_manifold_edges, 0u);
  EXPECT_EQ(report.topology.degenerate_triangles, 0u);
  EXPECT_EQ(report.topology.duplicate_triangles, 0u);
  EXPECT_EQ(report.topology.isolated_vertices, 0u);
}

TEST(Topology, NonManifoldEdgesAreCounted) {
  Primitive book = sheet(4);  // a third page upon the edge from (0, 0) to (0.25, 0), which was a border
  book.positions.insert(book.positions.end(), {{0.1f, 0.0f, 0.3f}, {0.1f, -0.1f, 0.3f}});
  book.uvs.resize(book.positions.size());
  book.indices.insert(book.indices.end(), {0, 1, 25, 1, 0, 26});
  const CookReport report = cooked(squeezed(book));
  EXPECT_EQ(report.topology.non_manifold_edges, 1u);
  EXPECT_EQ(report.topology.border_edges, 15u + 4u);
}

// Seams close what the vertex buffer leaves open.
TEST(Topology, EdgesAreThoseOfPoints) {
  Primitive soup = sheet(4), whole = soup;
  soup.positions.clear();
  soup.uvs.clear();
  soup.indices.clear();
  for (uint32_t index : whole.indices) {
    soup.indices.push_back(static_cast<uint32_t>(soup.positions.size()));
    soup.positions.push_back(whole.positions[index]);
    soup.uvs.push_back(whole.uvs[index]);
  }
  EXPECT_EQ(cooked(squeezed(soup)).topology.border_edges, 16u);
}

TEST(Topology, DegenerateAndDuplicateTrianglesAreCounted) {
  Primitive primitive = sheet(4);
  primitive.indices.insert(primitive.indices.end(), {0, 0, 1, 0, 1, 2, 5, 5, 5});  // 0 1 2 lie on a line
  const std::vector<uint32_t> first(primitive.indices.begin(), primitive.indices.begin() + 3);
  primitive.indices.insert(primitive.indices.end(), {first[1], first[2], first[0]});
  primitive.indices.insert(primitive.indices.end(), {first[1], first[0], first[2]});
  const CookReport report = cooked(squeezed(primitive));
  EXPECT_EQ(report.topology.degenerate_triangles, 3u);
  EXPECT_EQ(report.topology.duplicate_triangles, 2u);
  EXPECT_EQ(report.topology.non_manifold_edges, 0u);
  EXPECT_EQ(report.topology.border_edges, 16u);
}

TEST(Topology, IsolatedVerticesAreCountedAndKept) {
  Primitive primitive = sheet(4);
  primitive.positions.insert(primitive.positions.begin() + 3, {{5.0f, 5.0f, 5.0f}, {6.0f, 5.0f, 5.0f}});
  primitive.uvs.resize(primitive.positions.size());
  for (uint32_t& index : primitive.indices) index += index >= 3 ? 2 : 0;
  const CookReport report = cooked(squeezed(primitive));
  EXPECT_EQ(report.topology.isolated_vertices, 2u);
  EXPECT_EQ(report.vertices, 27u);
}

TEST(Topology, NothingButDegenerateTrianglesCooks) {
  Primitive primitive = sheet(1);
  primitive.indices = {0, 1, 1, 2, 2, 2};
  EXPECT_EQ(cooked(squeezed(primitive)).topology.degenerate_triangles, 2u);
}

TEST(Topology, PolygonsAreCutAndCounted) {
  const auto file = test::writeFile("polygons.obj",
                                    "v 0 0 0\nv 1 0 0\nv 1.5 1 0\nv 0.5 2 0\nv -0.5 1 0\nv 2 0 0\nv 2 1 0\n"
                                    "f 1 2 3 4 5\nf 2 6 7 3\nf 3 7 4\n");
  const CookReport report = cooked(pipeline::import(file));
  EXPECT_EQ(report.polygons, 2u);
  EXPECT_EQ(report.triangles, 3u + 2u + 1u);
  EXPECT_EQ(report.topology.border_edges, 6u);
  EXPECT_EQ(report.topology.non_manifold_edges, 0u);
}

}  // namespace
}  // namespace furrow::tests
