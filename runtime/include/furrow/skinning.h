#pragma once

// How joints move vertices, and how many of them do.

#include <span>

#include "furrow/asset.h"

namespace furrow {

enum class Skinning : uint8_t {
  kLinear = 0,      // the matrices are blended: cheap, exact for any matrix, loses volume where joints twist
  kDualQuaternion,  // rotations and translations are blended as dual quaternions, which keep volume
                    // [Kavan et al. 2008, Geometric Skinning with Approximate Dual Quaternion Blending]
};

// A palette matrix M taken apart for dual quaternion skinning: M p = R (K p) + t. R is the rotation nearest
// to M (polar decomposition), K = R^T M what is left: the identity where M is rigid, else scale and shear,
// negative where M mirrors. K is blended linearly and applied before the rigid motion, as Kavan et al. do for
// scaled joints. So a vertex of one joint is where M puts it whatever M is, and blends of joints are right
// where each is rigid times a scale; where neighbouring joints shear differently, the blend is a
// compromise, as linear blending is. A matrix that flattens (determinant 0) has no nearest rotation: R is
// then the identity.
struct JointMotion {
  Float4 rotation;   // unit quaternion, w real
  Float4 dual;       // t rotation / 2
  float stretch[9];  // K, row-major
};

// out[i] from palette[i]; `out` is at least as long. Once a frame and instance; neither allocates nor throws.
void splitPalette(std::span<const Affine> palette, std::span<JointMotion> out);

// The `keep` strongest joints of each vertex, strongest first (of equal ones the earlier), their weights
// rescaled to sum to exactly 65535. Items: vertices. What comes out replaces what the asset has:
//
//   furrow::AssetView light = asset.view();
//   light.influences = keep, light.joints = joints, light.weights = weights;
//
// and `light` poses with less work wherever an asset is asked for, the clustered frame included. Weights move
// as the positions do: judge by the character how many joints can go.
struct InfluencesJob {
  const AssetView* asset = nullptr;
  uint32_t keep = 4;            // 1 to asset->influences
  std::span<uint16_t> joints;   // out, `keep` a vertex
  std::span<uint16_t> weights;  // out, `keep` a vertex

  Status validate() const;
  void run(uint32_t begin, uint32_t end) const;
};

}  // namespace furrow
