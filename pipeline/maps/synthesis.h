#pragma once

// Wrinkle maps worked out from a direction field: ridges across d, evenly spaced along it, with natural
// branching and no seams, because the pattern lives on the surface and not in UV.

#include <memory>

#include "pipeline/bake/surface.h"
#include "pipeline/maps/image.h"
#include "pipeline/maps/texel_map.h"

namespace furrow::pipeline {

enum class Preset {
  kSkin,          // lines of expression: narrow valleys between wide ridges
  kSkinFine,      // fine lines: shallow, short and wavering
  kCloth,         // folds: round
  kClothPuckers,  // short bulges, as along a seam
};

inline constexpr float kDarkest = 0.5f;  // W of the deepest valley

struct SynthesisSettings {
  Preset preset = Preset::kSkin;
  double spacing = 0.0;  // ridge to ridge, in root-space units, > 0
  double depth = 0.0;    // valley to ridge, in root-space units, > 0
  uint32_t seed = 1;
};

// Maps of one window of UV space, row 0 at its low v; flat outside every chart. Slopes are limited to 1.2,
// where the runtime's fast normalisation still holds.
struct SynthesizedMaps {
  Image normal;   // 2 channels: x, y of the unit normal in the vertices' tangent frames (T, w * cross(N, T)),
                  // [-1, 1]
  Image height;   // 1 channel: height over depth, [-1, 1], mean about 0, so that fading out moves nothing
  Image shading;  // 1 channel: alpha-shading factor W, 0 on ridges, 0.5 in the deepest valleys
};

// A pattern over the whole surface, made once a layer and then drawn into any number of texture sets.
// Deterministic; the same at any texture size and thread count, and but for rounding at any tessellation.
// Lines sway, branch and taper; where `strength` is 0 the surface is flat. `surface` and `field` must outlive
// it. The method: kernels.h.
class Synthesis {
 public:
  // Throws std::length_error where the spacing is too small for the surface, std::invalid_argument where a
  // size or setting is wrong.
  Synthesis(const Surface& surface, const LayerField& field, const SynthesisSettings& settings);
  ~Synthesis();

  // Any number of threads may draw at once. `texels`: of parts with UVs.
  SynthesizedMaps draw(const TexelMap& texels, uint32_t threads) const;

 private:
  struct Pattern;
  const Surface& surface_;
  const LayerField& field_;
  std::unique_ptr<Pattern> pattern_;
};

}  // namespace furrow::pipeline
