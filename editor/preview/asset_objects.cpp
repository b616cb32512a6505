#include "editor/preview/asset_objects.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "editor/preview/gpu_times.h"
#include "editor/preview/scene_setup.h"

namespace furrow::preview {
namespace {

constexpr float kAnisotropy = 4.0f;

bool same(const Texture& a, const Texture& b) {
  return a.format == b.format && a.width == b.width && a.height == b.height && a.slices == b.slices &&
         a.levels == b.levels && std::ranges::equal(a.data, b.data);
}

// All slices of a level as RGBA8.
std::vector<uint8_t> decoded(const Texture& texture, uint32_t level) {
  std::vector<uint8_t> bytes;
  for (uint32_t slice = 0; slice < texture.slices; ++slice)
    for (uint32_t y = 0; y < std::max(texture.height >> level, 1u); ++y)
      for (uint32_t x = 0; x < std::max(texture.width >> level, 1u); ++x) {
        const Float4 c = texelAt(texture, level, slice, x, y);
        for (const float value : {c.x, c.y, c.z, c.w})
          bytes.push_back(static_cast<uint8_t>(std::lround(value * 255.0f)));
      }
  return bytes;
}

void setWrap(uint32_t texture, const Wrap (&wrap)[2]) {
  constexpr GLint kWays[] = {GL_REPEAT, GL_CLAMP_TO_EDGE, GL_MIRRORED_REPEAT};
  if (texture == 0) return;
  glBindTexture(GL_TEXTURE_2D_ARRAY, texture);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_S, kWays[static_cast<size_t>(wrap[0])]);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_T, kWays[static_cast<size_t>(wrap[1])]);
}

}  // namespace

GlObject makeTexture(const Texture& texture) {
  constexpr GLenum kFormats[] = {GL_COMPRESSED_RG_RGTC2, GL_COMPRESSED_RED_RGTC1, GL_RGBA8,
                                 GL_COMPRESSED_SRGB_S3TC_DXT1_EXT, GL_COMPRESSED_SRGB_ALPHA_S3TC_DXT5_EXT};
  const GLenum format = kFormats[static_cast<size_t>(texture.format)];
  // All of OpenGL 3.3 has the formats of the other textures.
  const bool decode = (texture.format == TextureFormat::kBc1 || texture.format == TextureFormat::kBc3) &&
                      !epoxy_has_gl_extension("GL_EXT_texture_compression_s3tc");
  GlObject object(GlKind::kTexture);
  glBindTexture(GL_TEXTURE_2D_ARRAY, object);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  size_t offset = 0;
  for (uint32_t level = 0; level < texture.levels; ++level) {
    const size_t bytes =
        textureLevelBytes(texture.format, texture.width, texture.height, level) * texture.slices;
    const auto width = static_cast<GLsizei>(std::max(texture.width >> level, 1u));
    const auto height = static_cast<GLsizei>(std::max(texture.height >> level, 1u));
    const auto slices = static_cast<GLsizei>(texture.slices);
    const std::byte* data = texture.data.subspan(offset, bytes).data();
    if (decode)
      glTexImage3D(GL_TEXTURE_2D_ARRAY, static_cast<GLint>(level), GL_SRGB8_ALPHA8, width, height, slices, 0,
                   GL_RGBA, GL_UNSIGNED_BYTE, decoded(texture, level).data());
    else if (texture.format == TextureFormat::kRgba8)
      glTexImage3D(GL_TEXTURE_2D_ARRAY, static_cast<GLint>(level), GL_RGBA8, width, height, slices, 0,
                   GL_RGBA, GL_UNSIGNED_BYTE, data);
    else
      glCompressedTexImage3D(GL_TEXTURE_2D_ARRAY, static_cast<GLint>(level), format, width, height, slices, 0,
                             static_cast<GLsizei>(bytes), data);
    offset += bytes;
  }
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAX_LEVEL, static_cast<GLint>(texture.levels) - 1);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  // It more than doubles the time of a picture there.
  if (epoxy_has_gl_extension("GL_EXT_texture_filter_anisotropic") && !isSoftwareGl())
    glTexParameterf(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAX_ANISOTROPY_EXT, kAnisotropy);
  return object;
}

void fillMask(uint32_t texture, const pipeline::ByteImage& image) {
  std::vector<uint8_t> plane;
  for (size_t i = 0; i < image.pixels.size(); i += image.channels) plane.push_back(image.pixels[i]);
  glBindTexture(GL_TEXTURE_2D, texture);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_R8, static_cast<GLsizei>(image.width), static_cast<GLsizei>(image.height),
               0, GL_RED, GL_UNSIGNED_BYTE, plane.data());
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
}

AssetObjects::AssetObjects(const AssetView& asset, AssetObjects* before) : asset_(asset) {
  for (const TextureSet& set : asset.texture_sets)
    texture_sets.push_back({map(set.normals, before), map(set.shading, before), map(set.masks, before)});
  for (const BaseMaps& own : asset.base_maps) {
    base_maps.push_back({map(own.color, before), map(own.normal, before)});
    setWrap(base_maps.back().color, own.color_wrap);
    setWrap(base_maps.back().normal, own.normal_wrap);
  }
  indices = makeBuffer(std::as_bytes(asset.indices));
  uvs = makeBuffer(std::as_bytes(asset.uvs));
  colors = makeBuffer(std::as_bytes(asset.colors));
  makeMasks();
  makeMaterials();
}

uint32_t AssetObjects::map(const Texture& texture, AssetObjects* before) {
  if (texture.slices == 0) return 0;
  Map& made = maps_.emplace_back(Map{texture, {}});
  if (before)
    for (Map& old : before->maps_)
      if (old.object && same(old.texture, texture)) {
        made.object = std::move(old.object);
        return made.object;
      }
  made.object = makeTexture(texture);
  return made.object;
}

void AssetObjects::makeMaterials() {
  GLint alignment = 1;
  glGetIntegerv(GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT, &alignment);
  const auto step = static_cast<uint32_t>(alignment);
  material_stride = (uint32_t{sizeof(gpu::Material)} + step - 1) / step * step;
  std::vector<std::byte> bytes(size_t{material_stride} * asset_.parts.size());
  for (size_t p = 0; p < asset_.parts.size(); ++p) {
    const Part& part = asset_.parts[p];
    gpu::Material material{};
    material.base_color = shownColor(asset_, part);
    material.roughness = part.roughness;
    if (part.base_maps != kAbsent) {
      const BaseMaps& maps = asset_.base_maps[part.base_maps];
      const float *color = maps.color_uv, *normal = maps.normal_uv;
      material.color_uv = {color[0], color[1], color[2], color[3]};
      material.normal_uv = {normal[0], normal[1], normal[2], normal[3]};
      material.color_at_normal_at = {color[4], color[5], normal[4], normal[5]};
      material.opaque_from = maps.opaque_from;
    }
    for (glm::uvec4& slices : material.slices) slices = glm::uvec4(kAbsent);
    if (part.texture_set != kAbsent) {
      const TextureSet& set = asset_.texture_sets[part.texture_set];
      material.with_masks = set.masks.slices > 0;
      static_assert(sizeof set.windows == sizeof material.windows);
      std::memcpy(material.windows, set.windows, sizeof material.windows);
      for (uint32_t l = 0; l < asset_.layerCount(); ++l)
        material.slices[l] = {set.compress_slice[l], set.stretch_slice[l],
                              material.with_masks && !(l == painted_layer_ && painted_[p])
                                  ? asset_.layers[l].mask_slice
                                  : kAbsent,
                              0};
    }
    std::memcpy(&bytes[p * material_stride], &material, sizeof material);
  }
  materials = makeBuffer(std::as_bytes(std::span(bytes)));
}

void AssetObjects::makeMasks() {
  std::vector<uint8_t> bytes(size_t{asset_.vertexCount()} * kMaxLayers, 255);
  for (size_t l = 0; l < asset_.layers.size(); ++l)
    for (size_t v = 0; v < asset_.layers[l].mask.size() && l != painted_layer_; ++v)
      bytes[v * kMaxLayers + l] = asset_.layers[l].mask[v];
  for (size_t p = 0; p < asset_.parts.size() && painted_layer_ != kAbsent; ++p)
    for (uint32_t v = asset_.parts[p].vertex_begin; v < asset_.parts[p].vertex_end && !painted_[p]; ++v)
      bytes[size_t{v} * kMaxLayers + painted_layer_] = 0;
  masks = makeBuffer(std::as_bytes(std::span(bytes)));
}

void AssetObjects::paint(uint32_t layer, std::span<const uint32_t> parts) {
  std::vector<bool> painted(asset_.parts.size());
  for (const uint32_t part : parts) painted[part] = true;
  if (layer == painted_layer_ && (layer == kAbsent || painted == painted_)) return;
  painted_layer_ = layer;
  painted_ = std::move(painted);
  makeMasks();
  makeMaterials();
}

}  // namespace furrow::preview
