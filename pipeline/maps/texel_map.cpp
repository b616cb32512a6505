#include "pipeline/maps/texel_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "pipeline/scene/rig.h"

namespace furrow::pipeline {
namespace {

constexpr double kHalfDiagonal = 0.70711;
constexpr double kInsideSlack =
    1e-9;  // of barycentric coordinates, so that centres on a shared edge fall into no gap

using Corners = std::array<glm::dvec2, 3>;  // in texels, centres at integers

double cross(const glm::dvec2& a, const glm::dvec2& b) {
  return a.x * b.y - a.y * b.x;
}

// An edge by its vertices, and which side of it its triangle's third corner is on in UV.
struct Edge {
  uint32_t low = 0, high = 0;
  uint32_t triangle = 0, corner = 0;  // from `corner` to the next one
  int side = 0;
};

class Mapper {
 public:
  Mapper(const Surface& surface, uint32_t size) : surface_(surface), size_(size), distance2_(texels(), kFar) {
    map_.size = size;
    map_.triangle.assign(texels(), kNoIndex);
    map_.barycentric.assign(texels(), glm::vec2(0.0f));
  }

  void fill(uint32_t triangle) {
    Corners c;
    if (!corners(triangle, c)) {
      return;
    }
    const double area = cross(c[1] - c[0], c[2] - c[0]);
    if (area == 0.0) {
      return;
    }
    visit(c, 0.0, [&](int64_t x, int64_t y) {
      const glm::dvec2 p(static_cast<double>(x), static_cast<double>(y));
      const double b1 = cross(p - c[0], c[2] - c[0]) / area;
      const double b2 = cross(c[1] - c[0], p - c[0]) / area;
      if (b1 >= -kInsideSlack && b2 >= -kInsideSlack && b1 + b2 <= 1.0 + kInsideSlack) {
        offer(x, y, 0.0, triangle, b1, b2);
      }
    });
  }

  void dilate(const Edge& edge, double margin) {
    Corners c;
    if (!corners(edge.triangle, c)) {
      return;
    }
    const uint32_t next = (edge.corner + 1) % 3;
    const glm::dvec2 from = c[edge.corner], along = c[next] - from;
    const double length2 = glm::dot(along, along);
    visit({from, c[next], from}, margin, [&](int64_t x, int64_t y) {
      const glm::dvec2 p = glm::dvec2(static_cast<double>(x), static_cast<double>(y)) - from;
      const double t = length2 > 0.0 ? std::clamp(glm::dot(p, along) / length2, 0.0, 1.0) : 0.0;
      const glm::dvec2 gap = p - along * t;
      const double distance2 = glm::dot(gap, gap);
      if (distance2 <= margin * margin) {
        std::array<double, 3> b{};
        b[edge.corner] = 1.0 - t;
        b[next] = t;
        offer(x, y, distance2, edge.triangle, b[1], b[2]);
      }
    });
  }

  TexelMap take() { return std::move(map_); }

 private:
  static constexpr double kFar = 1e300;

  size_t texels() const { return static_cast<size_t>(size_) * size_; }

  // Moved by whole periods so that the smallest coordinates are in [0, 1).
  bool corners(uint32_t triangle, Corners& c) const {
    glm::dvec2 low(kFar);
    for (int i = 0; i < 3; ++i) {
      c[i] = surface_.uvs[surface_.triangles[triangle][i]];
      if (!std::isfinite(c[i].x) || !std::isfinite(c[i].y)) {
        return false;
      }
      low = {std::min(low.x, c[i].x), std::min(low.y, c[i].y)};
    }
    for (glm::dvec2& corner : c) {
      corner = (corner - glm::dvec2(std::floor(low.x), std::floor(low.y))) * static_cast<double>(size_) - 0.5;
    }
    return true;
  }

  template <class Do>
  void visit(const Corners& c, double margin, Do&& visit_texel) const {
    const auto range = [&](double a, double b, double d) {
      const auto first =
          static_cast<int64_t>(std::ceil(std::max(std::min({a, b, d}) - margin, -2.0 * size_)));
      const auto last = static_cast<int64_t>(std::floor(std::min(std::max({a, b, d}) + margin, 4.0 * size_)));
      return std::array<int64_t, 2>{first, std::min<int64_t>(last, first + size_ - 1)};
    };
    const auto [x0, x1] = range(c[0].x, c[1].x, c[2].x);
    const auto [y0, y1] = range(c[0].y, c[1].y, c[2].y);
    for (int64_t y = y0; y <= y1; ++y) {
      for (int64_t x = x0; x <= x1; ++x) {
        visit_texel(x, y);
      }
    }
  }

  void offer(int64_t x, int64_t y, double distance2, uint32_t triangle, double b1, double b2) {
    const auto wrap = [&](int64_t i) { return static_cast<size_t>((i % size_ + size_) % size_); };
    const size_t texel = wrap(y) * size_ + wrap(x);
    if (distance2 < distance2_[texel] ||
        (distance2 == distance2_[texel] && triangle < map_.triangle[texel])) {
      distance2_[texel] = distance2;
      map_.triangle[texel] = triangle;
      map_.barycentric[texel] = glm::vec2(static_cast<float>(b1), static_cast<float>(b2));
    }
  }

  const Surface& surface_;
  uint32_t size_;
  std::vector<double> distance2_;
  TexelMap map_;
};

std::vector<Edge> sortedEdges(const Surface& surface, const SurfacePart& part) {
  std::vector<Edge> edges;
  edges.reserve(3 * static_cast<size_t>(part.triangle_end - part.triangle_begin));
  for (uint32_t t = part.triangle_begin; t < part.triangle_end; ++t) {
    const glm::uvec3 v = surface.triangles[t];
    const glm::dvec2 a = surface.uvs[v[0]], b = surface.uvs[v[1]], c = surface.uvs[v[2]];
    const double area = cross(b - a, c - a);
    for (uint32_t i = 0; i < 3; ++i) {
      const uint32_t from = v[i], to = v[(i + 1) % 3];
      const int turn = area > 0.0 ? 1 : area < 0.0 ? -1 : 0;
      edges.push_back({std::min(from, to), std::max(from, to), t, i, from < to ? turn : -turn});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    return a.low != b.low ? a.low < b.low : a.high != b.high ? a.high < b.high : a.triangle < b.triangle;
  });
  return edges;
}

}  // namespace

TexelMap mapTexels(const Surface& surface, std::span<const uint32_t> parts, uint32_t size, uint32_t margin) {
  Mapper mapper(surface, size);
  const double reach = std::max(static_cast<double>(margin), kHalfDiagonal);
  for (const uint32_t index : parts) {
    const SurfacePart& part = surface.parts[index];
    for (uint32_t t = part.triangle_begin; t < part.triangle_end; ++t) {
      mapper.fill(t);
    }
    // A chart ends at an edge that does not have exactly one triangle on either side.
    const std::vector<Edge> edges = sortedEdges(surface, part);
    for (size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
      while (end < edges.size() && edges[end].low == edges[begin].low &&
             edges[end].high == edges[begin].high) {
        ++end;
      }
      const bool inside = end - begin == 2 && edges[begin].side * edges[begin + 1].side == -1;
      for (size_t i = begin; i < end && !inside; ++i) {
        mapper.dilate(edges[i], reach);
      }
    }
  }
  return mapper.take();
}

}  // namespace furrow::pipeline
