#include "content/surface_texels.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <thread>

namespace furrow::content {
namespace {

using glm::dvec2;
using glm::dvec3;

// On two threads; what a row holds does not depend on it.
template <class Row>
void forRows(uint32_t count, const Row& row) {
  const auto every_other = [&](uint32_t from) {
    for (uint32_t y = from; y < count; y += 2) row(y);
  };
  std::thread odd(every_other, 1);
  every_other(0);
  odd.join();
}

}  // namespace

SurfaceTexels::SurfaceTexels(const SurfaceMesh& mesh, std::span<const uint32_t> materials, uint32_t material,
                             uint32_t size)
    : size_(size), frames_(mesh.triangles.size()), triangle_(size_t{size} * size, kNone) {
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (materials[t] != material) continue;
    std::array<dvec2, 3> at;
    std::array<dvec3, 3> p;
    for (int k = 0; k < 3; ++k) {
      const SurfaceMesh::Vertex& vertex = mesh.vertices[mesh.triangles[t].vertices[k]];
      at[k] = dvec2(vertex.uv.x, 1 - vertex.uv.y) * static_cast<double>(size) - 0.5;
      p[k] = mesh.points[vertex.point];
    }
    const dvec2 a = at[1] - at[0], b = at[2] - at[0];
    const double area = a.x * b.y - a.y * b.x;
    if (std::abs(area) < 1e-12) continue;
    const dvec3 right = ((p[1] - p[0]) * b.y - (p[2] - p[0]) * a.y) / area,
                down = ((p[2] - p[0]) * a.x - (p[1] - p[0]) * b.x) / area;
    frames_[t] = {p[0] - at[0].x * right - at[0].y * down, right, down};
    const auto [left, most_right] = std::minmax({at[0].x, at[1].x, at[2].x});
    const auto [top, bottom] = std::minmax({at[0].y, at[1].y, at[2].y});
    for (double y = std::ceil(top); y <= bottom; ++y)
      for (double x = std::ceil(left); x <= most_right; ++x) {
        const dvec2 q = dvec2(x, y) - at[0];
        const double u = (q.x * b.y - q.y * b.x) / area, v = (a.x * q.y - a.y * q.x) / area;
        if (u >= -1e-9 && v >= -1e-9 && u + v <= 1 + 1e-9)
          triangle_[static_cast<size_t>(y) * size + static_cast<size_t>(x)] = static_cast<uint32_t>(t);
      }
  }
}

dvec3 SurfaceTexels::position(uint32_t x, uint32_t y) const {
  const Frame& frame = frames_[triangle_[size_t{y} * size_ + x]];
  return frame.origin + static_cast<double>(x) * frame.right + static_cast<double>(y) * frame.down;
}

Image SurfaceTexels::colors(const std::function<dvec3(dvec3)>& color) const {
  return filled([&](uint32_t x, uint32_t y) { return srgb(color(position(x, y))); });
}

Image SurfaceTexels::normals(const std::function<double(dvec3)>& height) const {
  std::vector<float> heights(triangle_.size());
  forRows(size_, [&](uint32_t y) {
    for (uint32_t x = 0; x < size_; ++x)
      if (covered(x, y)) heights[size_t{y} * size_ + x] = static_cast<float>(height(position(x, y)));
  });
  // By how much the height rises a texel; one-sided at the edge of a chart.
  const auto rise = [&](uint32_t x, uint32_t y, uint32_t dx, uint32_t dy) {
    const bool before = x >= dx && y >= dy && covered(x - dx, y - dy),
               after = x + dx < size_ && y + dy < size_ && covered(x + dx, y + dy);
    const auto at = [&](uint32_t column, uint32_t row) {
      return double{heights[size_t{row} * size_ + column]};
    };
    const double low = before ? at(x - dx, y - dy) : at(x, y), high = after ? at(x + dx, y + dy) : at(x, y);
    return (high - low) / std::max(1, before + after);
  };
  return filled([&](uint32_t x, uint32_t y) {
    const Frame& frame = frames_[triangle_[size_t{y} * size_ + x]];
    const double right = rise(x, y, 1, 0), down = rise(x, y, 0, 1);
    const double shear = glm::dot(frame.right, frame.down) / glm::dot(frame.right, frame.right);
    const dvec3 normal =
        glm::normalize(dvec3(-right / glm::length(frame.right),
                             (down - shear * right) / glm::length(frame.down - shear * frame.right), 1));
    std::array<uint8_t, 3> bytes;
    for (int c = 0; c < 3; ++c) bytes[c] = static_cast<uint8_t>(std::lround(127.5 * (normal[c] + 1.0)));
    return bytes;
  });
}

Image SurfaceTexels::filled(const std::function<std::array<uint8_t, 3>(uint32_t, uint32_t)>& rgb) const {
  Image image{size_, size_, std::vector<uint8_t>(3 * triangle_.size())};
  forRows(size_, [&](uint32_t y) {
    for (uint32_t x = 0; x < size_; ++x) {
      if (!covered(x, y)) continue;
      std::ranges::copy(rgb(x, y), &image.rgb[3 * (size_t{y} * size_ + x)]);
    }
  });
  // Along rows, then along columns: each texel between charts takes the nearest one's colour.
  const auto carry = [&](std::vector<bool>& known, size_t step, size_t line) {
    for (size_t i = 0; i < size_; ++i) {
      const auto index = [&](size_t k) { return i * line + k * step; };
      size_t last = size_;  // the nearest known texel before, then that after
      std::vector<size_t> source(size_, size_);
      for (size_t k = 0; k < size_; ++k) source[k] = last = known[index(k)] ? k : last;
      last = size_;
      for (size_t k = size_; k-- > 0;) {
        if (known[index(k)]) last = k;
        if (last < size_ && (source[k] == size_ || last - k < k - source[k])) source[k] = last;
      }
      for (size_t k = 0; k < size_; ++k)
        if (source[k] < size_) std::copy_n(&image.rgb[3 * index(source[k])], 3, &image.rgb[3 * index(k)]);
      for (size_t k = 0; k < size_; ++k)
        if (source[k] < size_) known[index(k)] = true;
    }
  };
  std::vector<bool> known(triangle_.size());
  for (size_t i = 0; i < known.size(); ++i) known[i] = triangle_[i] != kNone;
  carry(known, 1, size_);
  carry(known, size_, 1);
  return image;
}

}  // namespace furrow::content
