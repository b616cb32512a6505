#include "pipeline/bake/intrinsic_delaunay.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pipeline/bake/bucket_sort.h"

namespace furrow::pipeline {
namespace {

using Side = uint32_t;

constexpr double kAlmost = 1e-9;   // of a cotangent: the halves of a rectangle are not flipped to and fro
constexpr size_t kMostFlips = 32;  // a side; surfaces take about one

Side next(Side side) {
  return side % 3 == 2 ? side - 2 : side + 1;
}

// Twice the area, by Heron's formula.
double doubleArea(const std::array<double, 3>& lengths) {
  const auto [a, b, c] = lengths;
  return 0.5 * std::sqrt(std::max(0.0, (a + b + c) * (b + c - a) * (c + a - b) * (a + b - c)));
}

class Flipper {
 public:
  explicit Flipper(std::vector<IntrinsicTriangle>& triangles)
      : triangles_(triangles), twin_(3 * triangles.size(), kNoSide), waits_(twin_.size(), false) {
    pairSides();
  }

  std::vector<Side> run() {
    size_t flips = 0;
    for (Side first = 0; first < twin_.size(); ++first) {
      wait(first);
      while (!queue_.empty() && flips < kMostFlips * twin_.size()) {
        const Side side = queue_.back();
        queue_.pop_back();
        waits_[side] = false;
        if (isDelaunay(side)) continue;
        flip(side);
        ++flips;
      }
    }
    return std::move(twin_);
  }

 private:
  uint32_t facedBy(Side side) const { return triangles_[side / 3].corners[side % 3]; }
  double length(Side side) const { return triangles_[side / 3].lengths[side % 3]; }
  double cotangent(Side side) const { return triangles_[side / 3].cotangent(static_cast<int>(side % 3)); }

  void pairSides() {
    const auto ends = [&](Side side) {
      return std::minmax({facedBy(next(side)), facedBy(next(next(side)))});
    };
    uint32_t points = 0;
    for (const IntrinsicTriangle& triangle : triangles_)
      points = std::max(points, 1 + std::ranges::max(triangle.corners));
    const std::vector<Side> sides = sidesByEnds(static_cast<uint32_t>(twin_.size()), points, ends);
    for (auto side = sides.begin(), end = side; side != sides.end(); side = end) {
      while (end != sides.end() && ends(*end) == ends(*side)) ++end;
      if (end - side == 2 && facedBy(next(side[0])) == facedBy(next(next(side[1])))) pair(side[0], side[1]);
    }
  }

  bool isDelaunay(Side side) const {
    const Side twin = twin_[side];
    return twin == kNoSide || twin / 3 == side / 3 || !(cotangent(side) + cotangent(twin) < -kAlmost);
  }

  // Of triangles abc and bad with the common side ab, makes adc and bcd.
  void flip(Side ab) {
    const Side ba = twin_[ab];
    const std::array<Side, 4> old = {next(ab), next(next(ab)), next(ba), next(next(ba))};  // bc ca ad db
    const std::array<Side, 4> twins = {twin_[old[0]], twin_[old[1]], twin_[old[2]], twin_[old[3]]};
    const uint32_t a = facedBy(old[0]), b = facedBy(old[1]), c = facedBy(ab), d = facedBy(ba);
    const double l = length(ab), bc = length(old[0]), ca = length(old[1]), ad = length(old[2]),
                 db = length(old[3]);
    // Laid out in the plane: ab on the x axis, c above it and d below.
    const double across = (ca * ca - bc * bc - ad * ad + db * db) / (2.0 * l);
    const double up = (doubleArea(triangles_[ab / 3].lengths) + doubleArea(triangles_[ba / 3].lengths)) / l;
    const double cd = std::hypot(across, up);
    const Side s = ab - ab % 3, t = ba - ba % 3;
    triangles_[s / 3] = {{a, d, c}, {cd, ca, ad}};
    triangles_[t / 3] = {{b, c, d}, {cd, db, bc}};
    pair(s, t);
    const std::array<Side, 4> now = {t + 2, s + 1, s + 2, t + 1};
    for (int i = 0; i < 4; ++i) {
      const auto moved = std::ranges::find(old, twins[i]) - old.begin();  // the four may be each other's
      pair(now[i], moved < 4 ? now[moved] : twins[i]);
      wait(now[i]);
    }
  }

  void pair(Side side, Side other) {
    twin_[side] = other;
    if (other != kNoSide) twin_[other] = side;
  }

  void wait(Side side) {
    if (!waits_[side]) queue_.push_back(side);
    waits_[side] = true;
  }

  std::vector<IntrinsicTriangle>& triangles_;
  std::vector<Side> twin_;  // the other triangle's
  std::vector<bool> waits_;
  std::vector<Side> queue_;
};

}  // namespace

double IntrinsicTriangle::cotangent(int corner) const {
  const double a = lengths[corner], b = lengths[(corner + 1) % 3], c = lengths[(corner + 2) % 3];
  return (b * b + c * c - a * a) / (2.0 * doubleArea(lengths));
}

std::vector<uint32_t> makeDelaunay(std::vector<IntrinsicTriangle>& triangles) {
  return Flipper(triangles).run();
}

}  // namespace furrow::pipeline
