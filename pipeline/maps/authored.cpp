#include "pipeline/maps/authored.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>

#include "pipeline/error.h"
#include "pipeline/maps/synthesis.h"
#include "pipeline/scene/rig.h"

namespace furrow::pipeline {
namespace {

constexpr float kSteepest = 16.0f;      // slope that is kept of an authored normal
constexpr float kFlat = 0.02f;          // slope below which a texel counts as upright: three steps of 8 bits
constexpr float kLeastRise = 0.5f;      // sine of the lowest light
constexpr double kDeepest = 0.99;       // part of the texels below which W is not yet at its darkest
constexpr uint32_t kSurroundings = 32;  // texels over which a texel is compared with its surroundings

constexpr const char* kNoMap = "name another image, or \"none\" for no map";

size_t wrapped(int64_t i, uint32_t size) {
  const int64_t n = size;
  return static_cast<size_t>((i % n + n) % n);
}

// Differences of channel `channel` to the next texel along x or y, per texel.
float slopeAt(const Image& image, uint32_t x, uint32_t y, uint32_t channel, bool along_x) {
  const auto at = [&](int64_t step) {
    return image.pixels[((along_x ? y : wrapped(y + step, image.height)) * image.width +
                         (along_x ? wrapped(x + step, image.width) : x)) *
                            image.channels +
                        channel];
  };
  return 0.5f * (at(1) - at(-1));
}

// Hollows, positive where the surface is hollow, to W.
Image darkened(Image hollows) {
  std::vector<float> sorted;
  for (float& h : hollows.pixels) {
    h = std::max(h, 0.0f);
    if (h > 0.0f) {
      sorted.push_back(h);
    }
  }
  if (sorted.empty()) {
    return hollows;
  }
  const auto deepest =
      sorted.begin() + static_cast<std::ptrdiff_t>(kDeepest * static_cast<double>(sorted.size() - 1));
  std::nth_element(sorted.begin(), deepest, sorted.end());
  const float scale = kDarkest / *deepest;
  for (float& h : hollows.pixels) {
    h = std::min(h * scale, kDarkest);
  }
  return hollows;
}

Image normalsOf(Image slopes) {
  for (size_t i = 0; i < slopes.pixels.size(); i += 2) {
    float &x = slopes.pixels[i], &y = slopes.pixels[i + 1];
    const float length = std::sqrt(x * x + y * y + 1.0f);
    x /= length;
    y /= length;
  }
  return slopes;
}

}  // namespace

Image readNormals(const std::filesystem::path& file, Green green) {
  const Image image = readImage(file);
  if (image.channels < 2) {
    throw Error(Exit::kBadData, file.string(), "a normal map needs red and green, and it has one channel",
                "name it as \"height\" if it holds heights");
  }
  Image slopes{image.width, image.height, 2, {}};
  slopes.pixels.reserve(size_t{image.width} * image.height * 2);
  size_t wrong = 0;
  float steepest = 0.0f;
  for (size_t i = 0; i < image.pixels.size(); i += image.channels) {
    const float x = image.pixels[i] * 2.0f - 1.0f, y = image.pixels[i + 1] * 2.0f - 1.0f;
    const float z = image.channels > 2 ? image.pixels[i + 2] * 2.0f - 1.0f
                                       : std::sqrt(std::max(1.0f - x * x - y * y, 0.0f));
    const float length = std::sqrt(x * x + y * y + z * z);
    wrong += !(length > 0.6f && length < 1.4f && z > 0.0f);
    const float slope = std::sqrt(x * x + y * y), steepness = std::min(slope / std::max(z, 1e-6f), kSteepest);
    const float scale = slope > 0.0f ? steepness / slope : 0.0f;
    steepest = std::max(steepest, steepness);
    slopes.pixels.push_back(x * scale);
    slopes.pixels.push_back(green == Green::kDirectX ? -y * scale : y * scale);
  }
  const size_t texels = size_t{image.width} * image.height;
  if (wrong > texels / 20) {
    throw Error(
        Exit::kBadData, file.string(),
        std::to_string(100 * wrong / texels) + "% of its texels are no normals of a tangent-space map",
        "name it as \"height\" if it holds heights, else export a tangent-space map without colour "
        "management");
  }
  if (steepest < kFlat)
    throw Error(Exit::kBadData, file.string(), "its normals are all upright: no wrinkle is in it", kNoMap);
  return slopes;
}

Image readHeights(const std::filesystem::path& file) {
  Image image = readImage(file);
  float lowest = image.pixels.front(), highest = lowest;
  for (size_t i = 0; i < image.pixels.size(); i += image.channels) {
    lowest = std::min(lowest, image.pixels[i]);
    highest = std::max(highest, image.pixels[i]);
  }
  if (lowest == highest)
    throw Error(Exit::kBadData, file.string(), "it has one height everywhere: no wrinkle is in it", kNoMap);
  if (lowest < 0.0f || highest > 1.0f) {
    char range[80];
    std::snprintf(range, sizeof range, "its heights go from %.4g to %.4g", double{lowest}, double{highest});
    throw Error(Exit::kBadData, file.string(), range,
                "scale them to 0 (black) to 1 (white), and give what lies between as \"depth\"");
  }
  return image;
}

WrinkleMaps mapsFromSlopes(const Image& slopes, const TexelGrid& grid) {
  const Image window = resize(slopes, grid.width, grid.height, grid.low, grid.extent);
  Image hollows{window.width, window.height, 1, {}};
  for (uint32_t y = 0; y < window.height; ++y) {
    for (uint32_t x = 0; x < window.width; ++x) {
      // Minus the divergence of -grad h, whose second component points up in the image.
      hollows.pixels.push_back(slopeAt(window, x, y, 1, false) - slopeAt(window, x, y, 0, true));
    }
  }
  return {normalsOf(window), darkened(std::move(hollows))};
}

WrinkleMaps mapsFromHeights(const Image& heights, const Surface& surface, const TexelMap& texels,
                            double depth) {
  Image plane{heights.width, heights.height, 1, {}}, rises{heights.width, heights.height, 2, {}};
  for (uint32_t y = 0; y < heights.height; ++y) {
    for (uint32_t x = 0; x < heights.width; ++x) {
      plane.pixels.push_back(heights.at(x, y)[0]);
    }
  }
  for (uint32_t y = 0; y < heights.height; ++y) {  // for a unit of u and of v
    for (uint32_t x = 0; x < heights.width; ++x) {
      rises.pixels.push_back(slopeAt(plane, x, y, 0, true) * static_cast<float>(heights.width));
      rises.pixels.push_back(slopeAt(plane, x, y, 0, false) * static_cast<float>(heights.height));
    }
  }
  const TexelGrid& grid = texels.grid;
  const Image rise = resize(rises, grid.width, grid.height, grid.low, grid.extent);
  WrinkleMaps maps{{grid.width, grid.height, 2, std::vector<float>(2 * texels.triangle.size(), 0.0f)}, {}};
  for (size_t i = 0; i < texels.triangle.size(); ++i) {
    const uint32_t t = texels.triangle[i];
    const auto frame = t == kNoIndex ? std::nullopt : frameAt(surface, t, texels.barycentric[i]);
    if (!frame) {
      continue;
    }
    // Gradients of u and v over the triangle.
    const glm::uvec3 v = surface.triangles[t];
    const glm::vec3 e1 = surface.positions[v.y] - surface.positions[v.x],
                    e2 = surface.positions[v.z] - surface.positions[v.x], n = glm::cross(e1, e2);
    const glm::vec2 s1 = surface.uvs[v.y] - surface.uvs[v.x], s2 = surface.uvs[v.z] - surface.uvs[v.x];
    const float area2 = glm::dot(n, n);
    const glm::vec2 h(rise.pixels[2 * i], rise.pixels[2 * i + 1]);
    const glm::vec3 gradient = (glm::cross(e2, n) * glm::dot(h, s1) + glm::cross(n, e1) * glm::dot(h, s2)) *
                               (static_cast<float>(depth) / area2);
    const glm::vec2 slope(-glm::dot(gradient, frame->tangent), -glm::dot(gradient, frame->bitangent));
    if (std::isfinite(slope.x) && std::isfinite(slope.y)) {
      maps.normal.pixels[2 * i] = slope.x;
      maps.normal.pixels[2 * i + 1] = slope.y;
    }
  }
  maps.normal = normalsOf(std::move(maps.normal));

  Image hollows = resize(plane, grid.width, grid.height, grid.low, grid.extent);
  const auto coarse = [](uint32_t size) { return std::max(size / kSurroundings, 1u); };
  const Image mean =
      resize(resize(hollows, coarse(grid.width), coarse(grid.height)), grid.width, grid.height);
  for (size_t i = 0; i < hollows.pixels.size(); ++i) {
    hollows.pixels[i] = mean.pixels[i] - hollows.pixels[i];
  }
  maps.shading = darkened(std::move(hollows));
  return maps;
}

void limitNormals(Image& normal, float limit) {
  for (size_t i = 0; i < normal.pixels.size(); i += 2) {
    const float length2 = normal.pixels[i] * normal.pixels[i] + normal.pixels[i + 1] * normal.pixels[i + 1];
    if (length2 > limit) {
      const float scale = std::sqrt(limit / length2);
      normal.pixels[i] *= scale;
      normal.pixels[i + 1] *= scale;
    }
  }
}

Image litShading(const Image& normal, const Surface& surface, const TexelMap& texels,
                 const std::array<double, 3>& light) {
  const glm::vec3 towards = glm::normalize(glm::dvec3(light[0], light[1], light[2]));
  Image shading{normal.width, normal.height, 1, std::vector<float>(texels.triangle.size(), 0.0f)};
  for (size_t i = 0; i < texels.triangle.size(); ++i) {
    const uint32_t t = texels.triangle[i];
    const auto frame = t == kNoIndex ? std::nullopt : frameAt(surface, t, texels.barycentric[i]);
    if (!frame) {
      continue;
    }
    glm::vec2 side(glm::dot(towards, frame->tangent), glm::dot(towards, frame->bitangent));
    const float length = glm::length(side),
                rise = std::clamp(glm::dot(towards, frame->normal), kLeastRise, 1.0f);
    side *= length > 0.0f ? std::sqrt(1.0f - rise * rise) / length : 0.0f;
    const glm::vec2 n(normal.pixels[2 * i], normal.pixels[2 * i + 1]);
    const float lit = glm::dot(n, side) + std::sqrt(std::max(1.0f - glm::dot(n, n), 0.0f)) * rise;
    shading.pixels[i] = std::clamp(1.0f - lit / rise, 0.0f, 1.0f);
  }
  return shading;
}

}  // namespace furrow::pipeline
