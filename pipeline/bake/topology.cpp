#include "pipeline/bake/topology.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "pipeline/bake/bucket_sort.h"
#include "pipeline/bake/rest_view.h"

namespace furrow::pipeline {

Topology inspect(std::span<const glm::vec3> positions, std::span<const uint32_t> vertex_point,
                 std::span<const glm::uvec3> triangles) {
  Topology found;
  const std::span<const Float3> rest = asFloat3(positions);
  std::vector<bool> used(positions.size());
  std::vector<std::array<uint32_t, 3>> corners;
  corners.reserve(triangles.size());
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

  const uint32_t points = vertex_point.empty() ? 0 : 1 + std::ranges::max(vertex_point);
  std::vector<uint32_t> order = bucketSorted(
      static_cast<uint32_t>(corners.size()), points, [&](uint32_t t) { return corners[t][0]; },
      [&](uint32_t a, uint32_t b) { return corners[a] < corners[b]; });
  const auto distinct = std::unique(order.begin(), order.end(),
                                    [&](uint32_t a, uint32_t b) { return corners[a] == corners[b]; });
  found.duplicate_triangles = static_cast<uint32_t>(order.end() - distinct);
  order.erase(distinct, order.end());

  const auto ends = [&](uint32_t side) {
    const auto& [a, b, c] = corners[order[side / 3]];
    return side % 3 == 0 ? std::pair(a, b) : side % 3 == 1 ? std::pair(b, c) : std::pair(a, c);
  };
  const std::vector<uint32_t> sides = sidesByEnds(static_cast<uint32_t>(3 * order.size()), points, ends);
  for (auto side = sides.begin(); side != sides.end();) {
    const auto next =
        std::find_if(side, sides.end(), [&](uint32_t other) { return ends(other) != ends(*side); });
    found.border_edges += next - side == 1;
    found.non_manifold_edges += next - side > 2;
    side = next;
  }
  return found;
}

}  // namespace furrow::pipeline
