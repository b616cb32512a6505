#include "content/surface_net.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numeric>
#include <set>
#include <utility>

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

namespace {

// The cell's edge along `axis` from its corner `i` steps along the next axis and `j` along the one after.
uint32_t edgeOf(int axis, int i, int j) {
  return static_cast<uint32_t>(4 * axis + 2 * i + j);
}

}  // namespace

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

  // The lines that the surface draws on a face of a cell, each from edge to edge. Where all four edges are
  // crossed, either the corners inside are kept apart or, on the faces `outer_apart`, those outside.
  std::set<std::pair<size_t, int>> outer_apart;  // lower corner, axis
  using Lines = std::vector<std::array<uint32_t, 2>>;
  const auto linesOn = [&](glm::ivec3 c, int n, int side) {
    const int u = (n + 1) % 3, v = (n + 2) % 3;
    const glm::ivec3 from = c + side * unit(n);
    const auto inside = [&](int i, int j) { return value[index(from + i * unit(u) + j * unit(v))] < 0; };
    const std::array<uint32_t, 2> along_u{edgeOf(u, 0, side), edgeOf(u, 1, side)},
        along_v{edgeOf(v, side, 0), edgeOf(v, side, 1)};
    Lines lines;
    if (inside(0, 0) == inside(1, 1) && inside(1, 0) == inside(0, 1) && inside(0, 0) != inside(1, 0)) {
      const bool straight = inside(0, 0) != outer_apart.contains({index(from), n});
      for (int i = 0; i < 2; ++i) lines.push_back({along_u[i], along_v[straight ? i : 1 - i]});
      return lines;
    }
    std::array<uint32_t, 2> line{};
    int crossed = 0;
    for (int i = 0; i < 2; ++i) {
      if (inside(0, i) != inside(1, i)) line[crossed++] = along_u[i];
      if (inside(i, 0) != inside(i, 1)) line[crossed++] = along_v[i];
    }
    if (crossed == 2) lines.push_back(line);
    return lines;
  };
  // Of each edge: the lowest that the same sheet of the surface crosses.
  const auto sheetsOf = [&](glm::ivec3 c) {
    std::array<uint32_t, 12> sheet{};
    std::iota(sheet.begin(), sheet.end(), 0u);
    for (int n = 0; n < 3; ++n)
      for (int side = 0; side < 2; ++side)
        for (const auto& [a, b] : linesOn(c, n, side)) {
          const auto [kept, joined] = std::minmax({sheet[a], sheet[b]});
          std::ranges::replace(sheet, joined, kept);
        }
    return sheet;
  };
  // A sheet must not pass twice through a face on both of its sides [Wenger 2013, Isosurfaces, 3.3].
  forEach(0, 1, [&](glm::ivec3 c) {
    for (int n = 0; n < 3; ++n) {
      const Lines here = linesOn(c, n, 0);
      if (here.size() < 2 || c[n] == 0) continue;
      const glm::ivec3 before = c - unit(n);
      const Lines there = linesOn(before, n, 1);
      const auto one = [](const Lines& lines, const std::array<uint32_t, 12>& sheet) {
        return sheet[lines[0][0]] == sheet[lines[1][0]];
      };
      if (one(here, sheetsOf(c)) && one(there, sheetsOf(before))) outer_apart.emplace(index(c), n);
    }
  });

  SurfaceNet net;
  std::vector<std::array<uint32_t, 12>> points_of(value.size());  // a cell, then its edges
  forEach(0, 1, [&](glm::ivec3 c) {
    const std::array<uint32_t, 12> sheet = sheetsOf(c);
    std::array<dvec3, 12> sum{};
    std::array<int, 12> crossings{};
    for (int axis = 0; axis < 3; ++axis)
      for (int i = 0; i < 2; ++i)
        for (int j = 0; j < 2; ++j) {
          const glm::ivec3 from = c + i * unit((axis + 1) % 3) + j * unit((axis + 2) % 3);
          const double f0 = value[index(from)], f1 = value[index(from + unit(axis))];
          if ((f0 < 0) == (f1 < 0)) continue;
          const uint32_t s = sheet[edgeOf(axis, i, j)];
          sum[s] += corner(from) + size * dvec3(unit(axis)) * (f0 / (f0 - f1));
          ++crossings[s];
        }
    for (uint32_t s = 0; s < 12; ++s) {
      if (crossings[s] == 0) continue;
      dvec3 p = sum[s] / static_cast<double>(crossings[s]);
      for (int k = 0; k < 2; ++k) {
        const dvec3 slope = slopeOf(distance, p);
        p -= slope * (distance(p) / std::max(glm::dot(slope, slope), 0.2));
      }
      for (uint32_t e = s; e < 12; ++e)
        if (sheet[e] == s) points_of[index(c)][e] = static_cast<uint32_t>(net.points.size());
      net.points.push_back(p);
    }
  });
  forEach(1, 1, [&](glm::ivec3 c) {
    for (int axis = 0; axis < 3; ++axis) {
      const bool inside = value[index(c)] < 0;
      if (inside == (value[index(c + unit(axis))] < 0)) continue;
      const glm::ivec3 s = unit((axis + 1) % 3), t = unit((axis + 2) % 3);
      const auto pointOf = [&](int i, int j) {
        return points_of[index(c - i * s - j * t)][edgeOf(axis, i, j)];
      };
      std::array<uint32_t, 4> quad{pointOf(0, 0), pointOf(1, 0), pointOf(1, 1), pointOf(0, 1)};
      if (!inside) std::swap(quad[1], quad[3]);
      net.quads.push_back(quad);
    }
  });
  return net;
}

}  // namespace furrow::content
