#pragma once

// Painting on the surface: an image in UV space, painted through the places of its texels on the surface.

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <memory>
#include <string>
#include <vector>

#include "editor/document/document.h"
#include "editor/session/posed_surface.h"
#include "pipeline/maps/image.h"
#include "pipeline/maps/texel_map.h"
#include "pipeline/recipe/recipe.h"

namespace furrow::editor {

enum class Painted : uint8_t { kBias, kMask, kDirection };

struct Brush {
  float size = 0.05f;     // radius, of the unit that a stroke is given, [0.002, 0.5]
  float strength = 0.8f;  // (0, 1]: how far a stroke goes towards what it paints
  float falloff = 0.6f;   // [0, 1]: the part of the radius over which it fades; 0 is a hard edge
  float bias = 1.0f;      // [-1, 1]: the weight that a bias stroke adds
  bool mirror = false;    // also on the other side of 0 along `mirror_axis` of the root space
  int mirror_axis = 0;    // x, y or z
  bool erase = false;     // back to neutral, black, or no direction
};

// How much the brush covers at `distance` from its middle, in radii: 1 inside, 0 from 1 on.
float brushCover(const Brush& brush, float distance);

// The texels of one size of image over one asset's surface.
class Canvas {
 public:
  // Over the parts that have UVs and of which a layer measures a triangle: `meshes`, `materials` as
  // LayerRecipe has them. Costs some tens of milliseconds for 1024 texels.
  Canvas(const AssetView& asset, const pipeline::LayerRecipe& layer, uint32_t size);

  uint32_t size() const { return map_.grid.width; }
  bool empty() const { return texels_.empty(); }                 // nothing has UVs
  const std::vector<uint32_t>& parts() const { return parts_; }  // of the asset, that can be painted

  const pipeline::Surface& surface() const { return surface_; }  // at rest in root space, with normals

  // What a layer of the asset has at its vertices, drawn as an image: where painting begins.
  pipeline::ByteImage current(Painted kind, const AssetView& asset, uint32_t asset_layer) const;

  // One texel that lies on the surface.
  struct Texel {
    uint32_t index;  // y * size + x
    uint32_t triangle;
    glm::vec3 rest, normal;  // root space
  };
  const std::vector<Texel>& texels() const { return texels_; }

  // The unit step of the image's x (right) and y (up) that goes along `direction` (root space, tangent) in a
  // texel's triangle; 0 where the triangle has no area in UV.
  glm::vec2 toImage(const Texel& texel, glm::vec3 direction) const;

 private:
  pipeline::Surface surface_;
  std::vector<uint32_t> parts_;
  pipeline::TexelMap map_;
  std::vector<Texel> texels_;
};

// From press to release. How far a texel is covered is the most that any piece of the stroke covers it, so a
// slow stroke paints what a fast one does.
class Stroke {
 public:
  Stroke(std::shared_ptr<const Canvas> canvas, std::shared_ptr<const pipeline::ByteImage> before,
         Painted kind, const Brush& brush, float unit);

  // The brush's middle moved here: root space at rest, and the facet's normal there.
  void moveTo(glm::vec3 rest, glm::vec3 normal);

  bool touched() const { return touched_; }
  pipeline::ByteImage image() const;
  // Of a stroke that combs: what it makes of the directions of a layer of the asset, or of those that are
  // painted `before`, if any; a vertex, as preview::RenderOptions has them.
  std::vector<glm::vec4> vertexDirections(const AssetView& asset, uint32_t asset_layer,
                                          std::span<const glm::vec4> before) const;

 private:
  void cover(glm::vec3 from, glm::vec3 to, glm::vec3 normal);
  void coverVertices(glm::vec3 from, glm::vec3 to, glm::vec3 normal);

  std::shared_ptr<const Canvas> canvas_;
  std::shared_ptr<const pipeline::ByteImage> before_;
  Painted kind_;
  Brush brush_;
  float radius_;
  bool begun_ = false, touched_ = false;
  glm::vec3 last_{0.0f};
  std::vector<float> cover_;      // a texel of the canvas
  std::vector<glm::vec2> along_;  // directions: of the image, a texel of the canvas
  std::vector<float> vertex_cover_;
  std::vector<glm::vec3> vertex_along_;  // root space
};

// What a painted bias is at the vertices, in [-1, 1]; 0 on parts that cannot be painted.
std::vector<float> vertexBias(const pipeline::ByteImage& painted, const Canvas& canvas,
                              const AssetView& asset);

// A channel as an image of its own, at another size.
pipeline::ByteImage planeOf(const pipeline::ByteImage& image, uint32_t channel, uint32_t size);

// Length of the diagonal of the bounding box at rest, root space.
float diagonalOf(const AssetView& asset);

// The image that a layer's recipe names for this kind, and its channel; empty: none.
std::pair<std::filesystem::path, uint32_t> namedImage(const pipeline::LayerRecipe& layer, Painted kind);

// The file that a painted image of a layer is saved in: the one it names, if that was painted here and no
// other layer names it, else one beside `recipe`, by the layer's name, that no other layer names.
std::filesystem::path paintedFile(const Content& content, const std::filesystem::path& recipe, size_t layer,
                                  Painted kind);

}  // namespace furrow::editor
