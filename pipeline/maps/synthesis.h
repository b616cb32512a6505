#pragma once

// Wrinkle maps worked out from a direction field: ridges across d, evenly spaced along it, with natural branching and no seams, because the
// pattern lives on the surface and not in UV.

#include <span>
#include <memory>

#include "pipeline/bake/surface.h"
#include "pipeline/maps/image.h"

namespace furrow::pipeline {

enum class Preset { kSkin, kCloth };  // narrow valleys between wide ridges; round folds

struct SynthesisSettings {
  Preset preset = Preset::kSkin;
  double spacing = 0.0;  // ridge to ridge, in root-space units, > 0
  double depth = 0.0;    // valley to ridge, in root-space units, > 0
  uint32_t seed = 1;
};

// Maps of one texture set, row 0 at v = 0. Texels outside every chart are dilated from the nearest chart, then flat.
struct SynthesizedMaps {
  Image normal;   // 2 channels: x, y of the unit normal in the vertices' tangent frames, [-1, 1]
  Image height;   // 1 channel: height over depth, [-1, 1]
  Image shading;  // 1 channel: alpha-shading factor W, 0 on ridges, towards 1 in valleys
};

// A pattern over the whole surface, made once a layer and then drawn into any number of texture sets. Deterministic; the same at any
// texture size, thread count and tessellation.
class Synthesis {
 public:
  Synthesis(const Surface& surface, const LayerField& field, const SynthesisSettings& settings);
  ~Synthesis();

  // Draws the parts (indices into Surface::parts, all with UVs) into maps of size x size texels.
  SynthesizedMaps draw(std::span<const uint32_t> parts, uint32_t size, uint32_t threads) const;

 private:
  struct Pattern;
  const Surface& surface_;
  const LayerField& field_;
  std::unique_ptr<Pattern> pattern_;
};

}  // namespace furrow::pipeline
