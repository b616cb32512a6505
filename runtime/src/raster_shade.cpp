#include "src/raster_shade.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "src/block_texel.h"
#include "src/raster_geometry.h"
#include "src/response_math.h"

namespace furrow {

namespace {

float mix(float a, float b, float t) {
  return a * (1.0f - t) + b * t;
}
Float3 mix(Float3 a, Float3 b, float t) {
  return {mix(a.x, b.x, t), mix(a.y, b.y, t), mix(a.z, b.z, t)};
}

// sRGB decoded, within 0.002.
float lightOf(float c) {
  return c * (c * (c * 0.305306011f + 0.682171111f) + 0.012522878f);
}

float rgba8Texel(const std::byte* slice, uint32_t width, uint32_t x, uint32_t y, uint32_t channel) {
  return static_cast<float>(slice[(size_t{y} * width + x) * 4 + channel]) * (1.0f / 255.0f);
}

}  // namespace

void SliceSampler::select(const Texture& texture, const Wrap (&wrap)[2]) {
  texture_ = &texture;
  std::copy_n(wrap, 2, wrap_);
  const std::byte* data = texture.data.data();
  for (uint32_t level = 0; level < texture.levels; ++level) {
    levels_[level] = {data, textureLevelBytes(texture.format, texture.width, texture.height, level),
                      std::max(texture.width >> level, 1u), std::max(texture.height >> level, 1u)};
    data += levels_[level].slice_bytes * texture.slices;
  }
}

template <typename Texel>
auto SliceSampler::filtered(const float uv[2], const float right[2], const float down[2],
                            const Texel& texel) const {
  const auto bilinear = [&](const Level& level) {
    const uint32_t width = level.width, height = level.height;
    const float x = wrapTo(wrap_[0], uv[0]) * static_cast<float>(width) - 0.5f;
    const float y = wrapTo(wrap_[1], uv[1]) * static_cast<float>(height) - 0.5f;
    const float left = floorOf(x), top = floorOf(y);  // from -1 to the last texel
    const auto before = [](Wrap wrap, float at, uint32_t size) {
      if (at < 0.0f) return wrap == Wrap::kRepeat ? size - 1 : 0;
      return std::min(static_cast<uint32_t>(at), size - 1);
    };
    const auto after = [](Wrap wrap, float at, uint32_t size) {
      const auto next = static_cast<uint32_t>(at + 1.0f);
      return next < size ? next : wrap == Wrap::kRepeat ? 0 : size - 1;
    };
    const uint32_t x0 = before(wrap_[0], left, width), x1 = after(wrap_[0], left, width);
    const uint32_t y0 = before(wrap_[1], top, height), y1 = after(wrap_[1], top, height);
    const float fx = x - left, fy = y - top;
    const auto upper = mix(texel(level, x0, y0), texel(level, x1, y0), fx);
    const auto lower = mix(texel(level, x0, y1), texel(level, x1, y1), fx);
    return mix(upper, lower, fy);
  };
  if (!std::isfinite(uv[0] + uv[1])) return decltype(bilinear(levels_[0])){};
  const auto width = static_cast<float>(texture_->width), height = static_cast<float>(texture_->height);
  const auto texels = [&](const float step[2]) {
    return step[0] * width * (step[0] * width) + step[1] * height * (step[1] * height);
  };
  const float reach = std::max(texels(right), texels(down));
  const auto last = static_cast<float>(texture_->levels - 1);
  // Also for a reach that is no number.
  const float level = reach > 1.0f ? std::min(0.5f * fastLog2(std::min(reach, 1e30f)), last) : 0.0f;
  const auto whole = static_cast<uint32_t>(level);
  const auto fine = bilinear(levels_[whole]);
  const float part = level - static_cast<float>(whole);
  return part == 0.0f ? fine : mix(fine, bilinear(levels_[whole + 1]), part);
}

float SliceSampler::at(uint32_t slice, uint32_t channel, const float uv[2], const float right[2],
                       const float down[2]) const {
  const auto dataOf = [&](const Level& level) { return level.data + level.slice_bytes * slice; };
  if (texture_->format == TextureFormat::kBc4)
    return filtered(uv, right, down, [&](const Level& level, uint32_t x, uint32_t y) {
      return bc4Texel(blockAt(dataOf(level), level.width, x, y, 8, 0), x, y);
    });
  return filtered(uv, right, down, [&](const Level& level, uint32_t x, uint32_t y) {
    return rgba8Texel(dataOf(level), level.width, x, y, channel);
  });
}

Float3 SliceSampler::colorAt(const float uv[2], const float right[2], const float down[2]) const {
  const bool with_opacity = texture_->format == TextureFormat::kBc3;
  const size_t bytes = with_opacity ? 16 : 8;
  return filtered(uv, right, down, [&](const Level& level, uint32_t x, uint32_t y) {
    const Float3 c = bc1Texel(blockAt(level.data, level.width, x, y, bytes, bytes - 8), x, y, with_opacity);
    return Float3{lightOf(c.x), lightOf(c.y), lightOf(c.z)};
  });
}

float SliceSampler::opacityAt(const float uv[2], const float right[2], const float down[2]) const {
  if (texture_->format != TextureFormat::kBc3) return 1.0f;
  return filtered(uv, right, down, [&](const Level& level, uint32_t x, uint32_t y) {
    return bc4Texel(blockAt(level.data, level.width, x, y, 16, 0), x, y);
  });
}

namespace {

const Part* partOf(const AssetView& asset, uint32_t triangle) {
  const auto part = std::upper_bound(asset.parts.begin(), asset.parts.end(), triangle,
                                     [](uint32_t t, const Part& p) { return t < p.triangle_end; });
  return part == asset.parts.end() ? nullptr : &*part;
}

// Null: the part has no colour map of its own.
const BaseMaps* baseMapsOf(const AssetView& asset, const Part* part) {
  if (!part || part->base_maps == kAbsent) return nullptr;
  const BaseMaps& maps = asset.base_maps[part->base_maps];
  return maps.color.slices > 0 ? &maps : nullptr;
}

bool seenThrough(const RasterJob& job, const Part& part) {
  const BaseMaps* base = baseMapsOf(*job.asset, &part);
  return !(part.base_color.w >= 1.0f) || (base && base->opaque_from > 0.0f);
}

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
  const bool back = facing > 0.0 && !job.back_colors.empty();
  triangle.colors = back ? job.back_colors.data() : job.colors.data();
  triangle.gloss = job.gloss.empty() ? nullptr : back ? job.back_gloss.data() : job.gloss.data();
}

void findLayers(const RasterJob& job, ShadedTriangle& triangle) {
  triangle.active_count = 0;
  triangle.set = nullptr;
  const AssetView& asset = *job.asset;
  const Part* part = partOf(asset, triangle.id);
  triangle.base = baseMapsOf(asset, part);
  triangle.opacity = part ? part->base_color.w : 1.0f;
  if (job.weights.empty()) return;
  const TextureSet* set =
      !part || part->texture_set == kAbsent ? nullptr : &asset.texture_sets[part->texture_set];
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
  for (const Part& part : job.asset->parts) any_seen_through_ = any_seen_through_ || seenThrough(job, part);
}

const ShadedTriangle& TriangleShader::shaded(uint32_t id) {
  ShadedTriangle& triangle = kept_[id % kKept];
  if (triangle.id != id) {
    triangle.id = id;
    triangle.corners = &job_.asset->indices[size_t{3} * id];
    findPlanes(job_, triangle);
    findLayers(job_, triangle);
  }
  return triangle;
}

TriangleShader::Place TriangleShader::placeOf(const ShadedTriangle& triangle, double x, double y) {
  Place at;
  for (int i = 0; i < 3; ++i) {
    at.edge[i] = triangle.planes[i][0] * x + triangle.planes[i][1] * y + triangle.planes[i][2];
    at.share[i] = std::max(at.edge[i], 0.0);
  }
  const double sum = at.share[0] + at.share[1] + at.share[2], inverse = sum > 0.0 ? 1.0 / sum : 0.0;
  for (double& s : at.share) s = sum > 0.0 ? s * inverse : 1.0 / 3.0;
  return at;
}

TriangleShader::Footprint TriangleShader::footprint(const ShadedTriangle& triangle,
                                                    const Place& place) const {
  const auto& [share, edge] = place;
  // uv is the quotient of two planes; so are its steps.
  const double inverse = 1.0 / (edge[0] + edge[1] + edge[2]);
  double at[2] = {}, steps[2][2] = {};
  for (int i = 0; i < 3; ++i) {
    const Float2 corner = job_.asset->uvs[triangle.corners[i]];
    at[0] += share[i] * corner.x;
    at[1] += share[i] * corner.y;
  }
  for (int i = 0; i < 3; ++i) {
    const Float2 corner = job_.asset->uvs[triangle.corners[i]];
    const double from_here[2] = {corner.x - at[0], corner.y - at[1]};
    for (int axis = 0; axis < 2; ++axis)
      for (int k = 0; k < 2; ++k) steps[axis][k] += triangle.planes[i][k] * from_here[axis];
  }
  Footprint out;
  for (int axis = 0; axis < 2; ++axis) {
    out.uv[axis] = static_cast<float>(at[axis]);
    out.right[axis] = static_cast<float>(steps[axis][0] * inverse);
    out.down[axis] = static_cast<float>(steps[axis][1] * inverse);
  }
  return out;
}

// The map is ready for fetches there.
TriangleShader::Footprint TriangleShader::onBaseMap(const BaseMaps& maps, const Footprint& at) {
  if (painted_ != &maps) {
    colors_.select(maps.color, maps.color_wrap);
    painted_ = &maps;
  }
  const float* m = maps.color_uv;
  const auto turned = [&](const float v[2], float(&out)[2]) {
    for (int axis = 0; axis < 2; ++axis) out[axis] = m[axis] * v[0] + m[2 + axis] * v[1];
  };
  Footprint out;
  turned(at.uv, out.uv);
  turned(at.right, out.right);
  turned(at.down, out.down);
  out.uv[0] += m[4];
  out.uv[1] += m[5];
  return out;
}

float TriangleShader::crease(const ShadedTriangle& triangle, const double* share, const Footprint& at) {
  const AssetView& asset = *job_.asset;
  const TextureSet* set = triangle.set;
  const auto& [uv, right, down] = at;
  if (set && sampled_ != set) {
    constexpr Wrap kTiles[2] = {Wrap::kRepeat, Wrap::kRepeat};
    shading_.select(set->shading, kTiles);
    masks_.select(set->masks, kTiles);
    sampled_ = set;
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
    const float inside[2] = {(from_x - floorOf(from_x)) * window.z, (from_y - floorOf(from_y)) * window.w};
    if (!(std::max(inside[0], inside[1]) <= 1.0f)) continue;
    float intensity = std::abs(w);
    const uint32_t mask = asset.layers[active.layer].mask_slice;
    if (set->masks.slices > 0 && mask != kAbsent) intensity *= masks_.at(mask / 4, mask % 4, uv, right, down);
    if (intensity == 0.0f) continue;
    const float right_in[2] = {right[0] * window.z, right[1] * window.w},
                down_in[2] = {down[0] * window.z, down[1] * window.w};
    left *= 1.0f - intensity * shading_.at(slice, 0, inside, right_in, down_in);
  }
  return left;
}

bool TriangleShader::isSeenThrough(uint32_t id) const {
  if (!any_seen_through_) return false;
  const Part* part = partOf(*job_.asset, id);
  return part && seenThrough(job_, *part);
}

uint32_t TriangleShader::samplesSeenAt(uint32_t id, double x, double y) {
  const ShadedTriangle& triangle = shaded(id);
  if (triangle.base && triangle.base->opaque_from > 0.0f) {
    const Footprint at = onBaseMap(*triangle.base, footprint(triangle, placeOf(triangle, x, y)));
    if (!(triangle.opacity * colors_.opacityAt(at.uv, at.right, at.down) >= triangle.base->opaque_from))
      return 0;
  }
  return samplesSeen(triangle.opacity, job_.samples);
}

Float3 TriangleShader::color(uint32_t id, double x, double y) {
  const ShadedTriangle& triangle = shaded(id);
  const Place place = placeOf(triangle, x, y);
  const BaseMaps* base = triangle.gloss ? triangle.base : nullptr;
  Footprint at = {};
  if (base || (triangle.set && triangle.active_count > 0)) at = footprint(triangle, place);
  const double left = triangle.active_count > 0 ? crease(triangle, place.share, at) : 1.0;
  double color[3] = {};
  const auto addMean = [&](const Float3* values) {
    for (int i = 0; i < 3; ++i) {
      const Float3 c = values[triangle.corners[i]];
      color[0] += place.share[i] * c.x;
      color[1] += place.share[i] * c.y;
      color[2] += place.share[i] * c.z;
    }
  };
  addMean(triangle.colors);
  if (base) {
    const auto [uv, right, down] = onBaseMap(*base, at);
    const Float3 painted = colors_.colorAt(uv, right, down);
    color[0] *= painted.x;
    color[1] *= painted.y;
    color[2] *= painted.z;
  }
  if (triangle.gloss) addMean(triangle.gloss);
  return {static_cast<float>(color[0] * left), static_cast<float>(color[1] * left),
          static_cast<float>(color[2] * left)};
}

}  // namespace furrow
