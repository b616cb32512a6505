#include "pipeline/maps/texel_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "pipeline/bake/bucket_sort.h"
#include "pipeline/parallel.h"
#include "pipeline/scene/rig.h"

namespace furrow::pipeline {
namespace {

constexpr double kHalfDiagonal = 0.70711;
constexpr double kInsideSlack = 1e-9;  // of barycentrics: centres on a shared edge fall into no gap
constexpr double kBandSlack = 1e-3;    // texels that are looked at beyond those that can pass

using Corners = std::array<glm::dvec2, 3>;  // in texels, centres at integers

double cross(const glm::dvec2& a, const glm::dvec2& b) {
  return a.x * b.y - a.y * b.x;
}

using Edge = Charts::Edge;

struct Rows {
  uint32_t begin = 0, end = 0;
};

class Mapper {
 public:
  Mapper(const Surface& surface, const TexelGrid& grid)
      : surface_(surface),
        grid_(grid),
        period_(grid.width / grid.extent.x, grid.height / grid.extent.y),
        distance2_(texels(), kFar),
        next_open_(size_t{grid.height} * (grid.width + size_t{1})) {
    map_.grid = grid;
    map_.triangle.assign(texels(), kNoIndex);
    map_.barycentric.assign(texels(), glm::vec2(0.0f));
    for (size_t i = 0; i < next_open_.size(); ++i)
      next_open_[i] = static_cast<uint32_t>(i % (grid.width + size_t{1}));
  }

  // Both touch the texels of `rows` alone.
  void fill(uint32_t triangle, const Rows& rows) {
    Corners c;
    if (!corners(triangle, c)) {
      return;
    }
    const double area = cross(c[1] - c[0], c[2] - c[0]);
    if (area == 0.0) {
      return;
    }
    const double slack = kBandSlack + kInsideSlack * (std::abs(c[1].x - c[0].x) + std::abs(c[2].x - c[0].x) +
                                                      std::abs(c[1].y - c[0].y) + std::abs(c[2].y - c[0].y));
    visit({Segment{c[0], c[1]}, Segment{c[1], c[2]}, Segment{c[2], c[0]}}, slack, rows,
          [&](size_t texel, const glm::dvec2& p) {
            const double b1 = cross(p - c[0], c[2] - c[0]) / area;
            const double b2 = cross(c[1] - c[0], p - c[0]) / area;
            if (b1 >= -kInsideSlack && b2 >= -kInsideSlack && b1 + b2 <= 1.0 + kInsideSlack) {
              offer(texel, 0.0, triangle, b1, b2);
              ++next_open_[texel + texel / grid_.width];
            }
          });
  }

  void dilate(const Edge& edge, double margin, const Rows& rows) {
    Corners c;
    if (!corners(edge.triangle, c)) {
      return;
    }
    const uint32_t next = (edge.corner + 1) % 3;
    const glm::dvec2 from = c[edge.corner], along = c[next] - from;
    const double length2 = glm::dot(along, along);
    visit({Segment{from, c[next]}}, margin + kBandSlack, rows, [&](size_t texel, const glm::dvec2& at) {
      const glm::dvec2 p = at - from;
      const double t = length2 > 0.0 ? std::clamp(glm::dot(p, along) / length2, 0.0, 1.0) : 0.0;
      const glm::dvec2 gap = p - along * t;
      const double distance2 = glm::dot(gap, gap);
      if (distance2 <= margin * margin) {
        std::array<double, 3> b{};
        b[edge.corner] = 1.0 - t;
        b[next] = t;
        offer(texel, distance2, edge.triangle, b[1], b[2]);
      }
    });
  }

  TexelMap take() { return std::move(map_); }

 private:
  static constexpr double kFar = 1e300;

  size_t texels() const { return size_t{grid_.width} * grid_.height; }

  // In texels of the window, moved by whole periods so that the smallest coordinates are in the first one.
  bool corners(uint32_t triangle, Corners& c) const {
    glm::dvec2 low(kFar);
    for (int i = 0; i < 3; ++i) {
      const glm::vec2 uv = surface_.uvs[surface_.triangles[triangle][i]];
      if (!std::isfinite(uv.x) || !std::isfinite(uv.y)) {
        return false;
      }
      c[i] = glm::dvec2(uv) - grid_.low;
      low = {std::min(low.x, c[i].x), std::min(low.y, c[i].y)};
    }
    for (glm::dvec2& corner : c) {
      corner = (corner - glm::dvec2(std::floor(low.x), std::floor(low.y))) * period_ - 0.5;
    }
    return true;
  }

  using Segment = std::array<glm::dvec2, 2>;

  // The texels of `rows` within no triangle yet whose centres, moved by a period or not, are within `margin`
  // of the segments or between them in their row. UVs that thousands of triangles share stay cheap so.
  template <size_t kSegments, class Do>
  void visit(const Segment (&segments)[kSegments], double margin, const Rows& rows, Do&& visit_texel) {
    double low_y = kFar, high_y = -kFar;
    for (const Segment& s : segments) {
      low_y = std::min({low_y, s[0].y, s[1].y});
      high_y = std::max({high_y, s[0].y, s[1].y});
    }
    const auto range = [](double low, double high, double begin, double end) {
      return std::array<int64_t, 2>{
          static_cast<int64_t>(std::ceil(std::clamp(low, begin, end))),
          static_cast<int64_t>(std::floor(std::clamp(high, begin - 1.0, end - 1.0)))};
    };
    for (const double down : {0.0, 1.0, -1.0}) {
      const double moved_y = down * period_.y;
      const auto [y0, y1] = range(low_y - margin - moved_y, high_y + margin - moved_y, rows.begin, rows.end);
      for (int64_t y = y0; y <= y1; ++y) {
        const auto row = static_cast<size_t>(y);
        if (open(row, 0) == grid_.width) continue;
        const double at_y = moved_y + static_cast<double>(y);
        double low_x = kFar, high_x = -kFar;
        for (const Segment& s : segments) {
          const glm::dvec2 along = s[1] - s[0];
          double t0 = 0.0, t1 = std::abs(s[0].y - at_y) <= margin ? 1.0 : -1.0;
          if (along.y != 0.0) {
            const double a = (at_y - margin - s[0].y) / along.y, b = (at_y + margin - s[0].y) / along.y;
            t0 = std::max(std::min(a, b), 0.0);
            t1 = std::min(std::max(a, b), 1.0);
          }
          if (t0 > t1) continue;
          const double x0 = s[0].x + t0 * along.x, x1 = s[0].x + t1 * along.x;
          low_x = std::min({low_x, x0, x1});
          high_x = std::max({high_x, x0, x1});
        }
        for (const double right : {0.0, 1.0, -1.0}) {
          const double moved_x = right * period_.x;
          const auto [x0, x1] = range(low_x - margin - moved_x, high_x + margin - moved_x, 0, grid_.width);
          for (int64_t x = x0; x <= x1; ++x) {
            x = static_cast<int64_t>(open(row, static_cast<size_t>(x)));
            if (x > x1) break;
            visit_texel(row * grid_.width + static_cast<size_t>(x),
                        glm::dvec2(moved_x + static_cast<double>(x), at_y));
          }
        }
      }
    }
  }

  // The first texel of the row, from x on, that is in no triangle yet; the width if all are.
  size_t open(size_t row, size_t x) {
    uint32_t* next = next_open_.data() + row * (grid_.width + size_t{1});
    while (next[x] != x) {
      next[x] = next[next[x]];
      x = next[x];
    }
    return x;
  }

  void offer(size_t texel, double distance2, uint32_t triangle, double b1, double b2) {
    if (distance2 < distance2_[texel] ||
        (distance2 == distance2_[texel] && triangle < map_.triangle[texel])) {
      distance2_[texel] = distance2;
      map_.triangle[texel] = triangle;
      map_.barycentric[texel] = glm::vec2(static_cast<float>(b1), static_cast<float>(b2));
    }
  }

  const Surface& surface_;
  const TexelGrid grid_;
  const glm::dvec2 period_;  // of UVs, in texels
  std::vector<double> distance2_;
  // width + 1 a row: itself, or a texel behind it that may be in no triangle.
  std::vector<uint32_t> next_open_;
  TexelMap map_;
};

// Whether the triangles of two edges with the same ends lie on either side of them in UV.
bool lieApart(const Surface& surface, const Edge& a, const Edge& b) {
  const auto side = [&](const Edge& edge) {
    const glm::uvec3 v = surface.triangles[edge.triangle];
    const glm::dvec2 p = surface.uvs[v[0]];
    const double area = cross(glm::dvec2(surface.uvs[v[1]]) - p, glm::dvec2(surface.uvs[v[2]]) - p);
    return v[edge.corner] < v[(edge.corner + 1) % 3] ? area : -area;
  };
  const double one = side(a), other = side(b);
  return (one > 0.0 && other < 0.0) || (one < 0.0 && other > 0.0);
}

}  // namespace

Charts chartsOf(const Surface& surface, std::span<const uint32_t> parts) {
  std::vector<uint32_t> ordered(parts.begin(), parts.end());
  std::sort(ordered.begin(), ordered.end());
  Charts charts;
  for (const uint32_t index : ordered) {
    const SurfacePart& part = surface.parts[index];
    Charts::OfPart& out = charts.parts.emplace_back();
    out.triangle_begin = part.triangle_begin;
    out.triangle_end = part.triangle_end;
    // A chart ends at an edge that does not have exactly one triangle on either side.
    const auto edgeOf = [&](uint32_t number) { return Edge{part.triangle_begin + number / 3, number % 3}; };
    const auto ends = [&](uint32_t number) {
      const auto [triangle, corner] = edgeOf(number);
      const glm::uvec3 v = surface.triangles[triangle] - part.vertex_begin;
      return std::minmax({v[corner], v[(corner + 1) % 3]});
    };
    const std::vector<uint32_t> edges =
        sidesByEnds(3 * (part.triangle_end - part.triangle_begin), part.vertex_end - part.vertex_begin, ends);
    for (auto edge = edges.begin(), end = edge; edge != edges.end(); edge = end) {
      while (end != edges.end() && ends(*end) == ends(*edge)) {
        ++end;
      }
      const bool inside = end - edge == 2 && lieApart(surface, edgeOf(edge[0]), edgeOf(edge[1]));
      for (; edge != end && !inside; ++edge) {
        out.borders.push_back(edgeOf(*edge));
      }
    }
  }
  return charts;
}

TexelMap mapTexels(const Surface& surface, const Charts& charts, const TexelGrid& grid, uint32_t margin,
                   uint32_t threads) {
  Mapper mapper(surface, grid);
  const double reach = std::max(static_cast<double>(margin), kHalfDiagonal);
  parallelFor(threads, threads, [&](uint32_t i) {
    const auto at = [&](uint32_t band) {
      return static_cast<uint32_t>(uint64_t{grid.height} * band / threads);
    };
    const Rows rows{at(i), at(i + 1)};
    // In the order of the triangles: the first one that has a texel keeps it.
    for (const Charts::OfPart& part : charts.parts) {
      for (uint32_t t = part.triangle_begin; t < part.triangle_end; ++t) {
        mapper.fill(t, rows);
      }
      for (const Edge& edge : part.borders) {
        mapper.dilate(edge, reach, rows);
      }
    }
  });
  return mapper.take();
}

std::optional<TangentFrame> frameAt(const Surface& surface, uint32_t triangle, glm::vec2 barycentric) {
  const glm::vec3 w(1.0f - barycentric.x - barycentric.y, barycentric.x, barycentric.y);
  const glm::uvec3 v = surface.triangles[triangle];
  const auto at = [&](const auto& values) {
    return glm::vec3(values[v.x]) * w.x + glm::vec3(values[v.y]) * w.y + glm::vec3(values[v.z]) * w.z;
  };
  const glm::vec3 sum = at(surface.normals);
  TangentFrame frame;
  frame.normal = glm::dot(sum, sum) > 0.0f ? glm::normalize(sum) : surface.normals[v.x];
  const glm::vec3 along = at(surface.tangents);
  frame.tangent = along - frame.normal * glm::dot(frame.normal, along);
  if (!(glm::dot(frame.tangent, frame.tangent) > 0.0f)) {
    return std::nullopt;
  }
  frame.tangent = glm::normalize(frame.tangent);
  frame.bitangent = glm::cross(frame.normal, frame.tangent) * surface.tangents[v.x].w;
  return frame;
}

}  // namespace furrow::pipeline
