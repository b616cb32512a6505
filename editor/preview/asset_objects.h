#pragma once

// What OpenGL holds of an asset to draw it: its maps, its surface, its materials.

#include <vector>

#include "editor/preview/gl_objects.h"
#include "furrow/asset.h"

namespace furrow::preview {

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

  // From here on masks and materials leave the mask of `layer` out; kAbsent: of none.
  void unmask(uint32_t layer);
  uint32_t unmasked() const { return unmasked_; }

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
  uint32_t unmasked_ = kAbsent;
};

// A texture array with all its levels.
GlObject makeTexture(const Texture& texture);

}  // namespace furrow::preview
