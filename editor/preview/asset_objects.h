#pragma once

// What OpenGL holds of an asset to draw it: its maps, its surface, its materials.

#include <span>
#include <vector>

#include "editor/preview/gl_objects.h"
#include "furrow/asset.h"
#include "pipeline/maps/image.h"

namespace furrow::preview {

// The first channel of an image becomes a texture's only one.
void fillMask(uint32_t texture, const pipeline::ByteImage& image);

class AssetObjects {
 public:
  // Takes over what is the same in `before`, whose asset must still be there; null: nothing. `asset` must
  // outlive it.
  AssetObjects(const AssetView& asset, AssetObjects* before);

  // Names of textures; 0: there is no such map.
  struct TextureSetNames {
    uint32_t normals, shading, masks;
  };
  struct BaseMapNames {
    uint32_t color, normal;
  };
  std::vector<TextureSetNames> texture_sets;
  std::vector<BaseMapNames> base_maps;

  GlObject indices, uvs, colors;
  GlObject masks;      // of all layers, kMaxLayers bytes a vertex
  GlObject materials;  // blocks Material of the parts, `material_stride` bytes apart
  uint32_t material_stride = 0;

  // From here on `layer` has another mask: 1 on `parts`, for a painted one to be put over it, and 0
  // elsewhere; kAbsent: all have their own.
  void paint(uint32_t layer, std::span<const uint32_t> parts);
  bool painted(size_t part) const { return painted_layer_ != kAbsent && painted_[part]; }

 private:
  struct Map {
    Texture texture;
    GlObject object;
  };

  uint32_t map(const Texture& texture, AssetObjects* before);
  void makeMasks();
  void makeMaterials();

  const AssetView& asset_;
  std::vector<Map> maps_;
  uint32_t painted_layer_ = kAbsent;
  std::vector<bool> painted_;  // a part
};

// A texture array with all its levels.
GlObject makeTexture(const Texture& texture);

}  // namespace furrow::preview
