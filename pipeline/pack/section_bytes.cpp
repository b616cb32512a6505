#include "pipeline/pack/section_bytes.h"

#include "asset_header.h"
#include "furrow_generated.h"

namespace furrow::pipeline {
namespace {

// Calls visit(entry) for every table of a vector that may be absent.
template <typename Vector, typename Visit>
void each(const Vector* vector, const Visit& visit) {
  for (uint32_t i = 0; vector && i < vector->size(); ++i) visit(*vector->Get(i));
}

size_t sizeOf(const flatbuffers::Vector<uint8_t>* bytes) {
  return bytes ? bytes->size() : 0;
}
size_t sizeOf(const format::Stream* stream) {
  return stream ? sizeOf(stream->data()) : 0;
}
size_t sizeOf(const format::Texture* texture) {
  return texture ? sizeOf(texture->stream()) : 0;
}

}  // namespace

SectionBytes sectionBytes(std::span<const std::byte> file) {
  const format::Asset& asset = *format::GetAsset(file.data() + sizeof(AssetHeader));
  SectionBytes bytes;
  each(asset.parts(), [&](const format::Part& part) {
    bytes.geometry += sizeOf(part.draco()) + sizeOf(part.indices());
    each(part.attributes(), [&](const format::Attribute& a) { bytes.geometry += sizeOf(a.stream()); });
  });
  for (const format::Stream* stream :
       {asset.vertex_point(), asset.rest(), asset.place_points(), asset.colors()})
    bytes.geometry += sizeOf(stream);
  each(asset.morphs(), [&](const format::Morph& morph) {
    bytes.morphs += sizeOf(morph.runs()) + sizeOf(morph.positions()) + sizeOf(morph.normals());
  });
  each(asset.layers(), [&](const format::Layer& layer) {
    bytes.layers += sizeOf(layer.bias()) + sizeOf(layer.mask()) + sizeOf(layer.directions());
  });
  each(asset.texture_sets(), [&](const format::TextureSet& set) {
    bytes.maps += sizeOf(set.normals()) + sizeOf(set.shading()) + sizeOf(set.masks());
  });
  each(asset.base_maps(),
       [&](const format::BaseMaps& maps) { bytes.own_maps += sizeOf(maps.color()) + sizeOf(maps.normal()); });
  bytes.place_hash = sizeOf(asset.place_hash());
  bytes.rig = sizeOf(asset.rig());
  return bytes;
}

}  // namespace furrow::pipeline
