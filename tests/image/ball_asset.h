#pragma once

// A small asset made by hand: a ball with a UV seam at its back and its poles split into many vertices, cut
// from the usual grid.
//   palette: 0 holds the lower half, 1 the upper half; moving 1 down squeezes the middle vertically
//   morph 0: draws the front together sideways
//   layer 0 "lines": d vertical, horizontal lines on the front; a stretch map of its own
//   layer 1 "frown": d horizontal, vertical lines on the front; biased by a step on the left side
// The ball has a radius of 1, faces +Z and has +Y up.

#include <memory>

#include "furrow/asset.h"

namespace furrow::tests {

struct BallOptions {
  bool maps = true;   // false: no texture set, as for a mesh without UVs
  bool masks = true;  // false: the masks are those of the vertices
};

class BallAsset {
 public:
  explicit BallAsset(const BallOptions& options = {});
  ~BallAsset();
  BallAsset(const BallAsset&) = delete;
  BallAsset& operator=(const BallAsset&) = delete;

  const AssetView& view() const { return view_; }

 private:
  struct Arrays;
  std::unique_ptr<Arrays> arrays_;
  AssetView view_;
};

}  // namespace furrow::tests
