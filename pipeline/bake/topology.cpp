#include "pipeline/bake/topology.h"

#include <algorithm>
#include <array>
#include <vector>

#include "pipeline/bake/rest_view.h"

namespace furrow::pipeline {

Topology inspect(std::span<const glm::vec3> positions, std::span<const uint32_t> vertex_point,
                 std::span<const glm::uvec3> triangles) {
  Topology found;
  const std::span<const Float3> rest = asFloat3(positions);
  std::vector<bool> used(positions.size());
  std::vector<std::array<uint32_t, 3>> corners;
  for (const glm::uvec3& t : triangles) {
    for (int c = 0; c < 3; ++c) used[t[c]] = true;
    std::array<uint32_t, 3> points = {vertex_point[t.x], vertex_point[t.y], vertex_point[t.z]};
    std::sort(points.begin(), points.end());
    if (std::adjacent_find(points.begin(), points.end()) != points.end() ||
        isNeedle(rest[t.x], rest[t.y], rest[t.z]))
      ++found.degenerate_triangles;
    else
      corners.push_back(points);
  }
  found.isolated_vertices = static_cast<uint32_t>(std::count(used.begin(), used.end(), false));

  std::sort(corners.begin(), corners.end());
  const auto distinct = std::unique(corners.begin(), corners.end());
  found.duplicate_triangles = static_cast<uint32_t>(corners.end() - distinct);
  std::vector<std::pair<uint32_t, uint32_t>> edges;
  for (auto p = corners.begin(); p != distinct; ++p)
    edges.insert(edges.end(), {{(*p)[0], (*p)[1]}, {(*p)[1], (*p)[2]}, {(*p)[0], (*p)[2]}});
  std::sort(edges.begin(), edges.end());
  for (auto edge = edges.begin(); edge != edges.end();) {
    const auto next = std::find_if(edge, edges.end(), [&](const auto& other) { return other != *edge; });
    found.border_edges += next - edge == 1;
    found.non_manifold_edges += next - edge > 2;
    edge = next;
  }
  return found;
}

}  // namespace furrow::pipeline
