#pragma once

// Where the texels of an image lie on a surface.

#include <array>
#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "content/image.h"
#include "content/surface_mesh.h"

namespace furrow::content {

class SurfaceTexels {
 public:
  // A square image, `size` texels a side, over the mesh's UVs in [0, 1], whose v points up; only triangles of
  // `material` count. Charts must lie apart by some texels.
  SurfaceTexels(const SurfaceMesh& mesh, std::span<const uint32_t> materials, uint32_t material,
                uint32_t size);

  uint32_t size() const { return size_; }
  bool covered(uint32_t x, uint32_t y) const { return triangle_[y * size_ + x] != kNone; }
  glm::dvec3 position(uint32_t x, uint32_t y) const;

  // In sRGB, `color` (linear) at every covered texel; carried on over the edges of charts.
  Image colors(const std::function<glm::dvec3(glm::dvec3)>& color) const;
  // A normal map of the surface raised by `height`, a length; red to the right, green up.
  Image normals(const std::function<double(glm::dvec3)>& height) const;

 private:
  static constexpr uint32_t kNone = ~0u;
  // The position of a triangle's texels: origin + x right + y down.
  struct Frame {
    glm::dvec3 origin, right, down;
  };
  // `rgb` at every covered texel, carried on from there.
  Image filled(const std::function<std::array<uint8_t, 3>(uint32_t x, uint32_t y)>& rgb) const;

  uint32_t size_;
  std::vector<Frame> frames_;
  std::vector<uint32_t> triangle_;  // a texel
};

}  // namespace furrow::content
