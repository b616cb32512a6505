#include <algorithm>

#include "furrow/asset.h"
#include "src/block_texel.h"

namespace furrow {

Float4 texelAt(const Texture& texture, uint32_t level, uint32_t slice, uint32_t x, uint32_t y) {
  const std::byte* data = texture.data.data();
  for (uint32_t l = 0; l < level; ++l)
    data += textureLevelBytes(texture.format, texture.width, texture.height, l) * texture.slices;
  data += textureLevelBytes(texture.format, texture.width, texture.height, level) * slice;
  const uint32_t width = std::max(1u, texture.width >> level);
  const auto block = [&](size_t bytes, size_t offset) { return blockAt(data, width, x, y, bytes, offset); };
  switch (texture.format) {
    case TextureFormat::kBc5:
      return {bc4Texel(block(16, 0), x, y), bc4Texel(block(16, 8), x, y), 0.0f, 1.0f};
    case TextureFormat::kBc4:
      return {bc4Texel(block(8, 0), x, y), 0.0f, 0.0f, 1.0f};
    case TextureFormat::kBc1: {
      const Float3 c = bc1Texel(block(8, 0), x, y, false);
      return {c.x, c.y, c.z, 1.0f};
    }
    case TextureFormat::kBc3: {
      const Float3 c = bc1Texel(block(16, 8), x, y, true);
      return {c.x, c.y, c.z, bc4Texel(block(16, 0), x, y)};
    }
    case TextureFormat::kRgba8:
      break;
  }
  const std::byte* texel = data + (size_t{y} * width + x) * 4;
  const auto unorm = [&](int c) { return static_cast<float>(texel[c]) * (1.0f / 255.0f); };
  return {unorm(0), unorm(1), unorm(2), unorm(3)};
}

float wrapped(Wrap wrap, float at) {
  return wrapTo(wrap, at);
}

}  // namespace furrow
