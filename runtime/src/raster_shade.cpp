#include "src/raster_shade.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "src/raster_geometry.h"
#include "src/response_math.h"

namespace furrow {

namespace {

// std::floor is a call where the baseline has no instruction for it.
float floorOf(float x) {
  if (!(std::abs(x) < 8388608.0f)) return x;
  const auto whole = static_cast<float>(static_cast<int32_t>(x));
  return whole > x ? whole - 1.0f : whole;
}

// A texel of a slice whose rows are `width` long; BC4 has two ends, then three bits a texel.
float bc4Texel(const std::byte* slice, uint32_t width, uint32_t x, uint32_t y) {
  uint64_t block;
  std::memcpy(&block, slice + (size_t{y / 4} * ((width + 3) / 4) + x / 4) * 8, sizeof block);
  const auto end0 = static_cast<int32_t>(block & 255), end1 = static_cast<int32_t>(block >> 8 & 255);
  const auto code = static_cast<int32_t>(block >> (16 + 3 * (4 * (y % 4) + x % 4)) & 7);
  if (code < 2) return static_cast<float>(code == 0 ? end0 : end1) * (1.0f / 255.0f);
  if (end0 > end1)
    return static_cast<float>((8 - code) * end0 + (code - 1) * end1) * (1.0f / (7.0f * 255.0f));
  if (code >= 6) return code == 6 ? 0.0f : 1.0f;
  return static_cast<float>((6 - code) * end0 + (code - 1) * end1) * (1.0f / (5.0f * 255.0f));
}
float rgba8Texel(const std::byte* slice, uint32_t width, uint32_t x, uint32_t y, uint32_t channel) {
  return static_cast<float>(slice[(size_t{y} * width + x) * 4 + channel]) * (1.0f / 255.0f);
}

}  // namespace

void SliceSampler::select(const Texture& texture) {
  texture_ = &texture;
  const std::byte* data = texture.data.data();
  for (uint32_t level = 0; level < texture.levels; ++level) {
    levels_[level] = {data, textureLevelBytes(texture.format, texture.width, texture.height, level),
                      std::max(texture.width >> level, 1u), std::max(texture.height >> level, 1u)};
    data += levels_[level].slice_bytes * texture.slices;
  }
}

float SliceSampler::bilinear(const Level& level, uint32_t slice, uint32_t channel, const float uv[2]) const {
  const std::byte* data = level.data + level.slice_bytes * slice;
  const uint32_t width = level.width, height = level.height;
  const float x = (uv[0] - floorOf(uv[0])) * static_cast<float>(width) - 0.5f;
  const float y = (uv[1] - floorOf(uv[1])) * static_cast<float>(height) - 0.5f;
  const float left = floorOf(x), top = floorOf(y);
  // From -1 to the last texel.
  const uint32_t x0 = left < 0.0f ? width - 1 : std::min(static_cast<uint32_t>(left), width - 1);
  const uint32_t y0 = top < 0.0f ? height - 1 : std::min(static_cast<uint32_t>(top), height - 1);
  const uint32_t x1 = x0 + 1 == width ? 0 : x0 + 1, y1 = y0 + 1 == height ? 0 : y0 + 1;
  const float fx = x - left, fy = y - top;
  const auto mix = [&](const auto& texel) {
    const float upper = texel(x0, y0) * (1.0f - fx) + texel(x1, y0) * fx;
    const float lower = texel(x0, y1) * (1.0f - fx) + texel(x1, y1) * fx;
    return upper * (1.0f - fy) + lower * fy;
  };
  if (texture_->format == TextureFormat::kBc4)
    return mix([&](uint32_t column, uint32_t line) { return bc4Texel(data, width, column, line); });
  return mix([&](uint32_t column, uint32_t line) { return rgba8Texel(data, width, column, line, channel); });
}

float SliceSampler::at(uint32_t slice, uint32_t channel, const float uv[2], const float right[2],
                       const float down[2]) const {
  if (!std::isfinite(uv[0] + uv[1])) return 0.0f;
  const auto width = static_cast<float>(texture_->width), height = static_cast<float>(texture_->height);
  const auto texels = [&](const float step[2]) {
    return step[0] * width * (step[0] * width) + step[1] * height * (step[1] * height);
  };
  const float reach = std::max(texels(right), texels(down));
  const auto last = static_cast<float>(texture_->levels - 1);
  // Also for a reach that is no number.
  const float level = reach > 1.0f ? std::min(0.5f * fastLog2(std::min(reach, 1e30f)), last) : 0.0f;
  const auto whole = static_cast<uint32_t>(level);
  const float fine = bilinear(levels_[whole], slice, channel, uv), part = level - static_cast<float>(whole);
  if (part == 0.0f) return fine;
  return fine * (1.0f - part) + bilinear(levels_[whole + 1], slice, channel, uv) * part;
}

namespace {

void findPlanes(const RasterJob& job, ShadedTriangle& triangle) {
  // Homogeneous corners in pixels; those of triangles that are drawn whole are snapped, so that shares and
  // coverage agree.
  double x[3], y[3], w[3];
  bool whole = true;
  for (int i = 0; i < 3; ++i) whole = whole && job.vertices[triangle.corners[i]].x != kClippedVertex;
  for (int i = 0; i < 3; ++i) {
    if (whole) {
      const RasterVertex& v = job.vertices[triangle.corners[i]];
      w[i] = v.w;
      x[i] = v.x * (1.0 / kSubpixels) * w[i];
      y[i] = v.y * (1.0 / kSubpixels) * w[i];
    } else {
      const ClipPoint p = clipPoint(job, job.positions[triangle.corners[i]]);
      w[i] = p.w;
      x[i] = (0.5 * p.w + 0.5 * p.x) * job.width;
      y[i] = (0.5 * p.w - 0.5 * p.y) * job.height;
    }
  }
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    triangle.planes[i][0] = y[j] * w[k] - y[k] * w[j];
    triangle.planes[i][1] = x[k] * w[j] - x[j] * w[k];
    triangle.planes[i][2] = x[j] * y[k] - x[k] * y[j];
  }
  const double* first = triangle.planes[0];
  const double facing = x[0] * first[0] + y[0] * first[1] + w[0] * first[2];
  if (facing < 0.0)
    for (auto& plane : triangle.planes)
      for (double& a : plane) a = -a;
  // Rows go down: seen counter-clockwise, the sign is negative.
  triangle.colors = facing > 0.0 && !job.back_colors.empty() ? job.back_colors.data() : job.colors.data();
}

void findLayers(const RasterJob& job, ShadedTriangle& triangle) {
  triangle.active_count = 0;
  triangle.set = nullptr;
  if (job.weights.empty()) return;
  const AssetView& asset = *job.asset;
  const auto part = std::upper_bound(asset.parts.begin(), asset.parts.end(), triangle.id,
                                     [](uint32_t t, const Part& p) { return t < p.triangle_end; });
  const TextureSet* set = part == asset.parts.end() || part->texture_set == kAbsent
                              ? nullptr
                              : &asset.texture_sets[part->texture_set];
  if (set && set->shading.slices > 0) triangle.set = set;
  const bool masks_by_vertex = !set || set->masks.slices == 0;
  for (uint32_t l = 0; l < asset.layerCount(); ++l) {
    ShadedTriangle::ActiveLayer& active = triangle.active[triangle.active_count];
    active.layer = l;
    bool any = false;
    for (int i = 0; i < 3; ++i) {
      const uint32_t corner = triangle.corners[i];
      const int16_t weight = job.weights[size_t{corner} * asset.weightStride() + l];
      active.weights[i] = std::max(static_cast<float>(weight) * (1.0f / 32767.0f), -1.0f);
      if (masks_by_vertex && !asset.layers[l].mask.empty())
        active.weights[i] *= static_cast<float>(asset.layers[l].mask[corner]) * (1.0f / 255.0f);
      any = any || active.weights[i] != 0.0f;
    }
    if (any) ++triangle.active_count;
  }
}

}  // namespace

TriangleShader::TriangleShader(const RasterJob& job, ShadedTriangle* kept) : job_(job), kept_(kept) {
  for (uint32_t i = 0; i < kKept; ++i) kept_[i].id = kAbsent;
}

float TriangleShader::crease(const ShadedTriangle& triangle, const double* share, const double* edge) {
  const AssetView& asset = *job_.asset;
  const TextureSet* set = triangle.set;
  float uv[2] = {}, right[2] = {}, down[2] = {};
  if (set) {
    if (sampled_ != set) {
      shading_.select(set->shading);
      masks_.select(set->masks);
      sampled_ = set;
    }
    // uv is the quotient of two planes; so are its steps.
    const double inverse = 1.0 / (edge[0] + edge[1] + edge[2]);
    double at[2] = {}, steps[2][2] = {};
    for (int i = 0; i < 3; ++i) {
      const Float2 corner = asset.uvs[triangle.corners[i]];
      at[0] += share[i] * corner.x;
      at[1] += share[i] * corner.y;
    }
    for (int i = 0; i < 3; ++i) {
      const Float2 corner = asset.uvs[triangle.corners[i]];
      const double from_here[2] = {corner.x - at[0], corner.y - at[1]};
      for (int axis = 0; axis < 2; ++axis)
        for (int k = 0; k < 2; ++k) steps[axis][k] += triangle.planes[i][k] * from_here[axis];
    }
    for (int axis = 0; axis < 2; ++axis) {
      uv[axis] = static_cast<float>(at[axis]);
      right[axis] = static_cast<float>(steps[axis][0] * inverse);
      down[axis] = static_cast<float>(steps[axis][1] * inverse);
    }
  }
  float left = 1.0f;
  for (uint32_t i = 0; i < triangle.active_count; ++i) {
    const ShadedTriangle::ActiveLayer& active = triangle.active[i];
    const auto w = static_cast<float>(share[0] * active.weights[0] + share[1] * active.weights[1] +
                                      share[2] * active.weights[2]);
    if (!set) {
      left *= 1.0f - std::max(w, 0.0f) * job_.vertex_shade;
      continue;
    }
    const uint32_t slice = w > 0.0f ? set->compress_slice[active.layer] : set->stretch_slice[active.layer];
    if (w == 0.0f || slice == kAbsent) continue;
    const Float4 window = set->windows[slice];
    const float from_x = uv[0] - window.x, from_y = uv[1] - window.y;
    const float at[2] = {(from_x - floorOf(from_x)) * window.z, (from_y - floorOf(from_y)) * window.w};
    if (!(std::max(at[0], at[1]) <= 1.0f)) continue;
    float intensity = std::abs(w);
    const uint32_t mask = asset.layers[active.layer].mask_slice;
    if (set->masks.slices > 0 && mask != kAbsent) intensity *= masks_.at(mask / 4, mask % 4, uv, right, down);
    if (intensity == 0.0f) continue;
    const float right_in[2] = {right[0] * window.z, right[1] * window.w},
                down_in[2] = {down[0] * window.z, down[1] * window.w};
    left *= 1.0f - intensity * shading_.at(slice, 0, at, right_in, down_in);
  }
  return left;
}

Float3 TriangleShader::color(uint32_t id, double x, double y) {
  ShadedTriangle& triangle = kept_[id % kKept];
  if (triangle.id != id) {
    triangle.id = id;
    triangle.corners = &job_.asset->indices[size_t{3} * id];
    findPlanes(job_, triangle);
    findLayers(job_, triangle);
  }
  double edge[3], share[3];
  for (int i = 0; i < 3; ++i) {
    edge[i] = triangle.planes[i][0] * x + triangle.planes[i][1] * y + triangle.planes[i][2];
    share[i] = std::max(edge[i], 0.0);
  }
  const double sum = share[0] + share[1] + share[2], inverse = sum > 0.0 ? 1.0 / sum : 0.0;
  for (double& s : share) s = sum > 0.0 ? s * inverse : 1.0 / 3.0;
  const double left = triangle.active_count > 0 ? crease(triangle, share, edge) : 1.0;
  double color[3] = {};
  for (int i = 0; i < 3; ++i) {
    const Float3 c = triangle.colors[triangle.corners[i]];
    color[0] += share[i] * c.x;
    color[1] += share[i] * c.y;
    color[2] += share[i] * c.z;
  }
  return {static_cast<float>(color[0] * left), static_cast<float>(color[1] * left),
          static_cast<float>(color[2] * left)};
}

}  // namespace furrow
