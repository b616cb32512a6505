#include "pipeline/pack/texture_bytes.h"

#include "asset_header.h"
#include "furrow_generated.h"

namespace furrow::pipeline {

TextureBytes textureBytes(std::span<const std::byte> file) {
  const format::Asset& asset = *format::GetAsset(file.data() + sizeof(AssetHeader));
  const auto sizeOf = [](const format::Texture* texture) -> size_t {
    return texture && texture->stream() ? texture->stream()->data()->size() : 0;
  };
  TextureBytes bytes;
  for (uint32_t i = 0; asset.texture_sets() && i < asset.texture_sets()->size(); ++i) {
    const format::TextureSet& set = *asset.texture_sets()->Get(i);
    bytes.maps += sizeOf(set.normals()) + sizeOf(set.shading()) + sizeOf(set.masks());
  }
  for (uint32_t i = 0; asset.base_maps() && i < asset.base_maps()->size(); ++i) {
    const format::BaseMaps& maps = *asset.base_maps()->Get(i);
    bytes.own += sizeOf(maps.color()) + sizeOf(maps.normal());
  }
  return bytes;
}

}  // namespace furrow::pipeline
