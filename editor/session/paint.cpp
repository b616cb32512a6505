#include "editor/session/paint.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <glm/geometric.hpp>

#include "pipeline/scene/rig.h"

namespace furrow::editor {
namespace {

using pipeline::ByteImage;

constexpr uint32_t kMargin = 4;  // texels around the charts that are painted too, for filters
// The brush does not reach through the surface to a side that faces away.
constexpr float kLeastFacing = 0.0f;

glm::vec3 toVec(Float3 p) {
  return {p.x, p.y, p.z};
}

uint8_t toByte(float value) {
  return static_cast<uint8_t>(std::lround(std::clamp(value, 0.0f, 1.0f) * 255.0f));
}

float distanceToSegment(glm::vec3 p, glm::vec3 a, glm::vec3 b) {
  const glm::vec3 along = b - a;
  const float length2 = glm::dot(along, along);
  const float t = length2 > 0.0f ? std::clamp(glm::dot(p - a, along) / length2, 0.0f, 1.0f) : 0.0f;
  return glm::distance(p, a + t * along);
}

// Lines in the plane of `normal`: d and -d are one, and those across each other shorten each other.
glm::vec3 mixedLines(glm::vec3 a, glm::vec3 b, float amount, glm::vec3 normal) {
  if (!(glm::dot(normal, normal) > 0.0f)) return b;
  const glm::vec3 n = glm::normalize(normal);
  const glm::vec3 x =
      glm::normalize(glm::cross(std::abs(n.x) < 0.9f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0), n));
  const glm::vec3 y = glm::cross(n, x);
  const auto doubled = [&](glm::vec3 d) {
    const std::complex<float> z(glm::dot(d, x), glm::dot(d, y));
    return std::abs(z) > 0.0f ? z * z / std::abs(z) : z;
  };
  const std::complex<float> mixed = (1.0f - amount) * doubled(a) + amount * doubled(b);
  const std::complex<float> line = std::polar(std::abs(mixed), 0.5f * std::arg(mixed));
  return line.real() * x + line.imag() * y;
}

bool named(const std::vector<std::string>& list, std::string_view name) {
  return list.empty() || std::find(list.begin(), list.end(), name) != list.end();
}

// What the map code needs of a surface, at rest in root space.
pipeline::Surface surfaceOf(const AssetView& asset) {
  pipeline::Surface surface;
  for (const Part& part : asset.parts) {
    pipeline::SurfacePart span;
    span.vertex_begin = part.vertex_begin;
    span.vertex_end = part.vertex_end;
    span.triangle_begin = part.triangle_begin;
    span.triangle_end = part.triangle_end;
    span.has_uvs = part.has_uvs;
    surface.parts.push_back(span);
    for (uint32_t v = part.vertex_begin; v < part.vertex_end; ++v)
      surface.positions.push_back(toVec(transformed(part.rest, asset.positions[v])));
  }
  for (const Float2& uv : asset.uvs) surface.uvs.push_back({uv.x, uv.y});
  for (size_t i = 0; i + 2 < asset.indices.size(); i += 3)
    surface.triangles.push_back({asset.indices[i], asset.indices[i + 1], asset.indices[i + 2]});
  surface.normals.resize(surface.positions.size(), glm::vec3(0.0f));
  for (const glm::uvec3& t : surface.triangles)
    for (int c = 0; c < 3; ++c)
      surface.normals[t[c]] += glm::cross(surface.positions[t.y] - surface.positions[t.x],
                                          surface.positions[t.z] - surface.positions[t.x]);
  return surface;
}

}  // namespace

float brushCover(const Brush& brush, float distance) {
  if (distance >= 1.0f) return 0.0f;
  const float begin = 1.0f - brush.falloff;
  if (distance <= begin) return 1.0f;
  const float t = (1.0f - distance) / std::max(brush.falloff, 1e-6f);
  return t * t * (3.0f - 2.0f * t);
}

Canvas::Canvas(const AssetView& asset, const pipeline::LayerRecipe& layer, uint32_t size)
    : surface_(surfaceOf(asset)) {
  for (uint32_t p = 0; p < asset.parts.size(); ++p)
    if (asset.parts[p].has_uvs && named(layer.meshes, asset.parts[p].mesh) &&
        named(layer.materials, asset.parts[p].material))
      parts_.push_back(p);
  map_ = pipeline::mapTexels(surface_, pipeline::chartsOf(surface_, parts_), {size, size}, kMargin);
  for (uint32_t i = 0; i < map_.triangle.size(); ++i) {
    const uint32_t t = map_.triangle[i];
    if (t == pipeline::kNoIndex) continue;
    const glm::uvec3 v = surface_.triangles[t];
    const glm::vec2 b = map_.barycentric[i];
    const glm::vec3 a = surface_.positions[v.x], e1 = surface_.positions[v.y] - a,
                    e2 = surface_.positions[v.z] - a;
    const glm::vec3 n = glm::cross(e1, e2);
    const float length = glm::length(n);
    texels_.push_back({i, t, a + b.x * e1 + b.y * e2, length > 0.0f ? n / length : glm::vec3(0.0f)});
  }
}

glm::vec2 Canvas::toImage(const Texel& texel, glm::vec3 direction) const {
  const glm::uvec3 v = surface_.triangles[texel.triangle];
  const glm::vec3 e1 = surface_.positions[v.y] - surface_.positions[v.x],
                  e2 = surface_.positions[v.z] - surface_.positions[v.x];
  const glm::vec2 u1 = surface_.uvs[v.y] - surface_.uvs[v.x], u2 = surface_.uvs[v.z] - surface_.uvs[v.x];
  // direction = s e1 + t e2 in the least-squares sense, and the image moves by s u1 + t u2; its y is up.
  const float a = glm::dot(e1, e1), b = glm::dot(e1, e2), c = glm::dot(e2, e2);
  const float determinant = a * c - b * b;
  if (!(determinant > 0.0f)) return glm::vec2(0.0f);
  const float d1 = glm::dot(direction, e1), d2 = glm::dot(direction, e2);
  const float s = (c * d1 - b * d2) / determinant, t = (a * d2 - b * d1) / determinant;
  const glm::vec2 step(s * u1.x + t * u2.x, -(s * u1.y + t * u2.y));
  const float length = glm::length(step);
  return length > 0.0f && std::isfinite(length) ? step / length : glm::vec2(0.0f);
}

ByteImage Canvas::current(Painted kind, const AssetView& asset, uint32_t asset_layer) const {
  const uint32_t channels = kind == Painted::kDirection ? 3u : 1u;
  const uint8_t empty = kind == Painted::kMask ? 0 : 128;
  ByteImage image{size(), size(), channels, std::vector<uint8_t>(size_t{size()} * size() * channels, empty)};
  if (asset_layer >= asset.layerCount()) return image;
  const Layer& layer = asset.layers[asset_layer];
  for (const Texel& texel : texels_) {
    const glm::vec2 b = map_.barycentric[texel.index];
    const float weights[3] = {1.0f - b.x - b.y, b.x, b.y};
    uint8_t* pixel = &image.pixels[size_t{texel.index} * channels];
    const glm::uvec3 v = surface_.triangles[texel.triangle];
    if (kind == Painted::kDirection) {
      // Lines, not arrows: the tensor's larger axis would be the mean; corners flipped to agree come close.
      glm::vec3 sum(0.0f);
      float confidence = 0.0f;
      for (int c = 0; c < 3 && !layer.directions.empty(); ++c) {
        const int8_t* d = &layer.directions[size_t{4} * asset.vertex_point[v[c]]];
        glm::vec3 direction = glm::vec3(d[0], d[1], d[2]) / 127.0f;
        if (glm::dot(direction, sum) < 0.0f) direction = -direction;
        sum += weights[c] * direction;
        confidence += weights[c] * static_cast<float>(d[3]) / 127.0f;
      }
      const glm::vec2 step = confidence * toImage(texel, sum);
      pixel[0] = toByte(0.5f + 0.5f * step.x);
      pixel[1] = toByte(0.5f + 0.5f * step.y);
      pixel[2] = 0;
      continue;
    }
    float value = 0.0f;
    for (int c = 0; c < 3; ++c) {
      if (kind == Painted::kMask)
        value += weights[c] * (layer.mask.empty() ? 1.0f : static_cast<float>(layer.mask[v[c]]) / 255.0f);
      else if (!layer.bias.empty())
        value += weights[c] * static_cast<float>(layer.bias[v[c]]) / 32767.0f;
    }
    pixel[0] = kind == Painted::kMask            ? toByte(value)
               : std::abs(value) < 0.5f / 255.0f ? uint8_t{128}
                                                 : toByte(0.5f + 0.5f * value);
  }
  return image;
}

Stroke::Stroke(std::shared_ptr<const Canvas> canvas, std::shared_ptr<const ByteImage> before, Painted kind,
               const Brush& brush, float unit)
    : canvas_(std::move(canvas)),
      before_(std::move(before)),
      kind_(kind),
      brush_(brush),
      radius_(brush.size * unit),
      cover_(canvas_->texels().size(), 0.0f) {
  if (kind != Painted::kDirection) return;
  along_.assign(cover_.size(), glm::vec2(0.0f));
  vertex_cover_.assign(canvas_->surface().positions.size(), 0.0f);
  vertex_along_.assign(vertex_cover_.size(), glm::vec3(0.0f));
}

void Stroke::moveTo(glm::vec3 rest, glm::vec3 normal) {
  const glm::vec3 from = begun_ ? last_ : rest;
  if (begun_ && rest == last_) return;
  cover(from, rest, normal);
  if (brush_.mirror) {
    glm::vec3 flip(1.0f);
    flip[brush_.mirror_axis] = -1.0f;
    cover(from * flip, rest * flip, normal * flip);
  }
  begun_ = true;
  last_ = rest;
}

void Stroke::cover(glm::vec3 from, glm::vec3 to, glm::vec3 normal) {
  const glm::vec3 low = glm::min(from, to) - radius_, high = glm::max(from, to) + radius_;
  const bool comb = kind_ == Painted::kDirection && !brush_.erase;
  if (comb && from == to) return;  // a press has no direction yet
  if (kind_ == Painted::kDirection) coverVertices(from, to, normal);
  const std::vector<Canvas::Texel>& texels = canvas_->texels();
  for (size_t i = 0; i < texels.size(); ++i) {
    const Canvas::Texel& texel = texels[i];
    const glm::vec3 p = texel.rest;
    if (p.x < low.x || p.y < low.y || p.z < low.z || p.x > high.x || p.y > high.y || p.z > high.z) continue;
    if (glm::dot(texel.normal, normal) < kLeastFacing) continue;
    const float covered = brushCover(brush_, distanceToSegment(p, from, to) / radius_);
    if (covered <= cover_[i]) continue;
    cover_[i] = covered;
    touched_ = true;
    // The stroke runs along the crease; the image holds the direction across it.
    if (comb) along_[i] = canvas_->toImage(texel, glm::cross(texel.normal, to - from));
  }
}

void Stroke::coverVertices(glm::vec3 from, glm::vec3 to, glm::vec3 normal) {
  const pipeline::Surface& surface = canvas_->surface();
  for (const uint32_t part : canvas_->parts())
    for (uint32_t v = surface.parts[part].vertex_begin; v < surface.parts[part].vertex_end; ++v) {
      if (glm::dot(surface.normals[v], normal) < kLeastFacing) continue;
      const float covered = brushCover(brush_, distanceToSegment(surface.positions[v], from, to) / radius_);
      if (covered <= vertex_cover_[v]) continue;
      vertex_cover_[v] = covered;
      const glm::vec3 across = glm::cross(surface.normals[v], to - from);
      vertex_along_[v] = glm::length(across) > 0.0f ? glm::normalize(across) : glm::vec3(0.0f);
    }
}

std::vector<glm::vec4> Stroke::vertexDirections(const AssetView& asset, uint32_t asset_layer,
                                                std::span<const glm::vec4> before) const {
  std::vector<glm::vec4> directions(before.begin(), before.end());
  directions.resize(vertex_cover_.size(), glm::vec4(0.0f));
  const bool known = asset_layer < asset.layerCount() && !asset.layers[asset_layer].directions.empty();
  for (size_t v = 0; v < directions.size(); ++v) {
    const float amount = vertex_cover_[v] * brush_.strength;
    if (amount <= 0.0f) continue;
    glm::vec3 old(directions[v]);
    if (directions[v].w == 0.0f && known) {
      const int8_t* d = &asset.layers[asset_layer].directions[size_t{4} * asset.vertex_point[v]];
      old = glm::vec3(d[0], d[1], d[2]) / 127.0f * (static_cast<float>(d[3]) / 127.0f);
    }
    const glm::vec3 step = brush_.erase ? glm::vec3(0.0f) : vertex_along_[v];
    directions[v] = glm::vec4(mixedLines(old, step, amount, canvas_->surface().normals[v]), 1.0f);
  }
  return directions;
}

ByteImage Stroke::image() const {
  ByteImage image = *before_;
  const std::vector<Canvas::Texel>& texels = canvas_->texels();
  const float wanted = kind_ == Painted::kMask ? (brush_.erase ? 0.0f : 1.0f)
                       : brush_.erase          ? 128.0f / 255.0f
                                               : 0.5f + 0.5f * brush_.bias;
  for (size_t i = 0; i < texels.size(); ++i) {
    const float amount = cover_[i] * brush_.strength;
    if (amount <= 0.0f) continue;
    uint8_t* pixel = &image.pixels[size_t{texels[i].index} * image.channels];
    const auto towards = [&](uint8_t& value, float target) {
      value =
          toByte(static_cast<float>(value) / 255.0f + amount * (target - static_cast<float>(value) / 255.0f));
    };
    if (kind_ != Painted::kDirection) {
      towards(pixel[0], wanted);
      continue;
    }
    // d and -d are the same: what is there is turned to agree before it is mixed.
    glm::vec2 step = brush_.erase ? glm::vec2(0.0f) : along_[i];
    const glm::vec2 old = glm::vec2(pixel[0], pixel[1]) / 255.0f * 2.0f - 1.0f;
    if (glm::dot(step, old) < 0.0f) step = -step;
    towards(pixel[0], 0.5f + 0.5f * step.x);
    towards(pixel[1], 0.5f + 0.5f * step.y);
  }
  return image;
}

std::vector<float> vertexBias(const ByteImage& painted, const Canvas& canvas, const AssetView& asset) {
  std::vector<float> values(asset.vertexCount(), 0.0f);
  for (uint32_t p : canvas.parts())
    for (uint32_t v = asset.parts[p].vertex_begin; v < asset.parts[p].vertex_end; ++v) {
      const float c = pipeline::sampleAt(painted, {asset.uvs[v].x, asset.uvs[v].y}, 0);
      values[v] = std::abs(c - 0.5f) <= 1.0f / 255.0f ? 0.0f : 2.0f * (c - 0.5f);
    }
  return values;
}

ByteImage planeOf(const ByteImage& image, uint32_t channel, uint32_t size) {
  ByteImage plane{image.width, image.height, 1, {}};
  for (size_t i = channel; i < image.pixels.size(); i += image.channels)
    plane.pixels.push_back(image.pixels[i]);
  return pipeline::toBytes(pipeline::resize(pipeline::toFloats(plane), size, size));
}

float diagonalOf(const AssetView& asset) {
  glm::vec3 low(INFINITY), high(-INFINITY);
  for (const Part& part : asset.parts)
    for (uint32_t v = part.vertex_begin; v < part.vertex_end; ++v) {
      const glm::vec3 p = toVec(transformed(part.rest, asset.positions[v]));
      low = glm::min(low, p);
      high = glm::max(high, p);
    }
  return glm::distance(low, high);
}

std::pair<std::filesystem::path, uint32_t> namedImage(const pipeline::LayerRecipe& layer, Painted kind) {
  if (kind == Painted::kMask) {
    if (const auto* mask = std::get_if<pipeline::MaskTexture>(&layer.mask))
      return {mask->texture, mask->channel};
  } else if (kind == Painted::kBias) {
    if (layer.bias) return {layer.bias->texture, layer.bias->channel};
  } else if (const auto* flow = std::get_if<pipeline::DirectionTexture>(&layer.direction)) {
    return {flow->texture, 0};
  }
  return {};
}

std::filesystem::path paintedFile(const Content& content, const std::filesystem::path& recipe, size_t layer,
                                  Painted kind) {
  constexpr const char* kKinds[] = {"bias", "mask", "direction"};
  const std::vector<pipeline::LayerRecipe>& layers = content.recipe.layers;
  const auto taken = [&](const std::filesystem::path& file) {
    for (size_t l = 0; l < layers.size(); ++l)
      for (const Painted each : {Painted::kBias, Painted::kMask, Painted::kDirection})
        if (l != layer && namedImage(layers[l], each).first == file) return true;
    return false;
  };
  const std::filesystem::path own = namedImage(layers[layer], kind).first;
  if (content.images.contains(own) && !taken(own)) return own;
  std::string name = layers[layer].name;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && static_cast<unsigned char>(c) < 0x80) c = '_';
  const std::string stem = recipe.stem().string() + '_' + name + '_' + kKinds[static_cast<size_t>(kind)];
  std::filesystem::path file = recipe.parent_path() / (stem + ".png");
  for (int number = 2; taken(file); ++number)
    file = recipe.parent_path() / (stem + '_' + std::to_string(number) + ".png");
  return file;
}

}  // namespace furrow::editor
