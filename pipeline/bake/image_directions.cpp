#include "pipeline/bake/image_directions.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat2x2.hpp>
#include <glm/matrix.hpp>

namespace furrow::pipeline {
namespace {

constexpr double kMostCells = 256;  // along an edge of a triangle
constexpr double kMostUv = 1e6;     // further out floats tell no texels apart

uint32_t wrap(int64_t i, uint32_t size) {
  if (i >= 0 && i < int64_t{size}) return static_cast<uint32_t>(i);
  const int64_t rest = i % static_cast<int64_t>(size);
  return static_cast<uint32_t>(rest < 0 ? rest + size : rest);
}

// The image's vector at a texel, x right and y up: the flow itself, or the slope of the relief.
glm::dvec2 vectorAt(const Image& image, ImageKind kind, uint32_t x, uint32_t y) {
  const float* texel = image.at(x, y);
  if (kind == ImageKind::kFlow) return glm::dvec2(texel[0], texel[1]) * 2.0 - 1.0;
  if (kind == ImageKind::kSlopes) return {texel[0], texel[1]};
  // A central difference of fourth order: of second, it would turn the gradient of a fine relief.
  const auto height = [&](int64_t dx, int64_t dy) {
    return double{image.at(wrap(x + dx, image.width), wrap(y + dy, image.height))[0]};
  };
  const double right = (8.0 * (height(1, 0) - height(-1, 0)) - (height(2, 0) - height(-2, 0))) / 12.0;
  const double down = (8.0 * (height(0, 1) - height(0, -1)) - (height(0, 2) - height(0, -2))) / 12.0;
  return {right * image.width, -down * image.height};
}

}  // namespace

uint32_t leastChannels(ImageKind kind) {
  return kind == ImageKind::kHeight ? 1 : 2;
}

LineTensors tensorsOfImage(const Surface& surface, const std::vector<bool>& covered, const Image& image,
                           ImageKind kind) {
  LineTensors tensors(surface.triangles.size(), glm::vec3(0.0f));
  const glm::dvec2 size(image.width, image.height);
  for (const SurfacePart& part : surface.parts) {
    for (size_t t = part.triangle_begin; part.has_uvs && t < part.triangle_end; ++t) {
      if (!covered[t]) continue;
      const glm::uvec3 v = surface.triangles[t];
      const TriangleFrame frame =
          triangleFrame(surface.positions[v.x], surface.positions[v.y], surface.positions[v.z]);
      const glm::dvec2 uv = surface.uvs[v.x], e = glm::dvec2(surface.uvs[v.y]) - uv,
                       f = glm::dvec2(surface.uvs[v.z]) - uv;
      const double uv_area = e.x * f.y - e.y * f.x;
      if (!(frame.e1x * frame.e2y > 0.0) || !(std::abs(uv_area) > 0.0)) continue;
      if (!(glm::length(uv) + glm::length(e) + glm::length(f) < kMostUv)) continue;

      // Mean of x x^T over the texels below, at the centres of a subdivision about as fine as they are.
      const double longest =
          std::max({glm::length(e * size), glm::length(f * size), glm::length((f - e) * size)});
      const double cells = std::clamp(std::ceil(longest), 1.0, kMostCells);
      glm::dmat2 sum(0.0);
      for (double i = 0.0; i < cells; ++i)
        for (double j = 0.0; i + j < cells; ++j)
          for (const double third : {1.0 / 3.0, 2.0 / 3.0}) {
            if (third > 0.5 && i + j + 1.0 >= cells) continue;
            const glm::dvec2 at = (uv + e * ((i + third) / cells) + f * ((j + third) / cells)) * size;
            const glm::dvec2 x =
                vectorAt(image, kind, wrap(static_cast<int64_t>(std::floor(at.x)), image.width),
                         wrap(static_cast<int64_t>(std::floor(at.y)), image.height));
            sum += glm::outerProduct(x, x);
          }
      sum /= cells * cells;

      // From the image, x right and y up, to the triangle's plane.
      const glm::dvec2 e1(frame.e1x, 0.0), e2(frame.e2x, frame.e2y);
      const glm::dvec2 right = (e1 * f.y - e2 * e.y) / uv_area, up = (e1 * f.x - e2 * e.x) / uv_area;
      glm::dmat2 map(right, up);
      if (kind == ImageKind::kHeight) {
        map = glm::transpose(glm::inverse(map));
      } else if (kind == ImageKind::kSlopes) {
        map[0] = glm::normalize(right);
        map[1] = glm::normalize(up - glm::dot(up, map[0]) * map[0]);
      }
      glm::dmat2 tensor = map * sum * glm::transpose(map);
      const double trace = tensor[0][0] + tensor[1][1];
      if (!(trace > 0.0) || !std::isfinite(trace)) continue;
      if (kind == ImageKind::kFlow) tensor *= (sum[0][0] + sum[1][1]) / trace;
      tensors[t] = glm::vec3(tensor[0][0], tensor[0][1], tensor[1][1]);
    }
  }
  return tensors;
}

}  // namespace furrow::pipeline
