#include "content/surface_net.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace furrow::content {

using glm::dvec3;

dvec3 slopeOf(const std::function<double(dvec3)>& distance, dvec3 p) {
  constexpr double e = 1e-3;
  dvec3 slope;
  for (int k = 0; k < 3; ++k) {
    dvec3 d(0);
    d[k] = e;
    slope[k] = (distance(p + d) - distance(p - d)) / (2 * e);
  }
  return slope;
}

SurfaceNet surfaceNet(const std::function<double(dvec3)>& distance, dvec3 low, dvec3 high, double step) {
  const glm::ivec3 count = glm::ivec3(glm::round((high - low) / step)) + 1;
  const dvec3 size = (high - low) / dvec3(count - 1);
  const auto index = [&](glm::ivec3 c) { return (static_cast<size_t>(c.z) * count.y + c.y) * count.x + c.x; };
  const auto corner = [&](glm::ivec3 c) { return low + size * dvec3(c); };
  const auto unit = [](int axis) { return glm::ivec3(axis == 0, axis == 1, axis == 2); };
  const auto forEach = [&](int from, int short_of, auto&& visit) {
    for (int z = from; z < count.z - short_of; ++z)
      for (int y = from; y < count.y - short_of; ++y)
        for (int x = from; x < count.x - short_of; ++x) visit(glm::ivec3(x, y, z));
  };
  std::vector<double> value(static_cast<size_t>(count.x) * count.y * count.z);
  forEach(0, 0, [&](glm::ivec3 c) { value[index(c)] = distance(corner(c)); });

  SurfaceNet net;
  std::vector<uint32_t> point_of(value.size(), 0);
  forEach(0, 1, [&](glm::ivec3 c) {
    dvec3 sum(0);
    int crossings = 0;
    for (int a = 0; a < 8; ++a)
      for (int axis = 0; axis < 3; ++axis) {
        if (a >> axis & 1) continue;
        const glm::ivec3 from = c + glm::ivec3(a & 1, a >> 1 & 1, a >> 2 & 1);
        const double f0 = value[index(from)], f1 = value[index(from + unit(axis))];
        if ((f0 < 0) == (f1 < 0)) continue;
        sum += corner(from) + size * dvec3(unit(axis)) * (f0 / (f0 - f1));
        ++crossings;
      }
    if (crossings == 0) return;
    dvec3 p = sum / static_cast<double>(crossings);
    for (int k = 0; k < 2; ++k) {
      const dvec3 slope = slopeOf(distance, p);
      p -= slope * (distance(p) / std::max(glm::dot(slope, slope), 0.2));
    }
    point_of[index(c)] = static_cast<uint32_t>(net.points.size());
    net.points.push_back(p);
  });
  forEach(1, 1, [&](glm::ivec3 c) {
    for (int axis = 0; axis < 3; ++axis) {
      const bool inside = value[index(c)] < 0;
      if (inside == (value[index(c + unit(axis))] < 0)) continue;
      const glm::ivec3 s = unit((axis + 1) % 3), t = unit((axis + 2) % 3);
      std::array<uint32_t, 4> quad{point_of[index(c)], point_of[index(c - s)], point_of[index(c - s - t)],
                                   point_of[index(c - t)]};
      if (!inside) std::swap(quad[1], quad[3]);
      net.quads.push_back(quad);
    }
  });
  return net;
}

}  // namespace furrow::content
