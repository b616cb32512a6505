#include "rest_surface.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace furrow {
namespace {

constexpr double kThinnest = 1.0 / 2000.0;  // height of a triangle over its longest edge
constexpr double kLeastAgreement = 1e-3;    // of a triangle's three directions, which can sum up to 3

struct Double3 {
  double x, y, z;
};
Double3 operator-(Float3 a, Float3 b) {
  return {double{a.x} - double{b.x}, double{a.y} - double{b.y}, double{a.z} - double{b.z}};
}
double dot(Double3 a, Double3 b) {
  return (a.x * b.x + a.y * b.y) + a.z * b.z;
}
Double3 cross(Double3 a, Double3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
double length(Double3 a) {
  return std::sqrt(dot(a, a));
}

// The angle whose sine and cosine are as y > 0 to x, within 2e-8: C libraries differ in atan2's last bits.
// Arctangent by Abramowitz and Stegun 4.4.49.
double angleOf(double y, double x) {
  const double wide = std::abs(x);
  const double r = std::min(y, wide) / std::max(y, wide), s = r * r;
  double p = 0.0028662257;
  for (const double each : {-0.0161657367, 0.0429096138, -0.0752896400, 0.1065626393, -0.1420889944,
                            0.1999355085, -0.3333314528, 1.0})
    p = p * s + each;
  p *= r;
  if (y > wide) p = std::numbers::pi / 2.0 - p;
  return x < 0.0 ? std::numbers::pi - p : p;
}

// The cosine and sine of half the angle of (c, s), which is not zero; one of the two that differ in sign.
std::pair<double, double> halfAngle(double c, double s) {
  const double l = std::sqrt(c * c + s * s);
  const double larger = std::sqrt(0.5 * (1.0 + std::abs(c) / l)), smaller = 0.5 * s / (l * larger);
  return c >= 0.0 ? std::pair(larger, smaller) : std::pair(smaller, larger);
}

}  // namespace

bool isNeedle(Float3 a, Float3 b, Float3 c) {
  const Double3 ab = b - a, bc = c - b, ca = a - c;
  const double longest = std::max({dot(ab, ab), dot(bc, bc), dot(ca, ca)});
  return !(length(cross(ab, ca)) > kThinnest * longest);
}

bool isDegenerate(const RestSurface& surface, size_t triangle) {
  const uint32_t a = surface.corner(triangle, 0), b = surface.corner(triangle, 1),
                 c = surface.corner(triangle, 2);
  return a == b || b == c || c == a || isNeedle(surface.points[a], surface.points[b], surface.points[c]);
}

Rings makeRings(const RestSurface& surface) {
  Rings rings;
  rings.offsets.assign(surface.points.size() + 1, 0);
  std::vector<bool> skip(surface.triangleCount());
  for (size_t t = 0; t < skip.size(); ++t) {
    skip[t] = isDegenerate(surface, t);
    for (size_t c = 0; !skip[t] && c < 3; ++c) ++rings.offsets[surface.corner(t, c) + 1];
  }
  std::partial_sum(rings.offsets.begin(), rings.offsets.end(), rings.offsets.begin());
  rings.triangles.resize(rings.offsets.back());
  rings.weights.resize(rings.offsets.back());
  std::vector<float> angles(rings.offsets.back());
  std::vector<uint32_t> next(rings.offsets.begin(), rings.offsets.end() - 1);
  for (size_t t = 0; t < skip.size(); ++t) {
    if (skip[t]) continue;
    const uint32_t p[3] = {surface.corner(t, 0), surface.corner(t, 1), surface.corner(t, 2)};
    const Double3 edges[3] = {surface.points[p[1]] - surface.points[p[0]],
                              surface.points[p[2]] - surface.points[p[1]],
                              surface.points[p[0]] - surface.points[p[2]]};
    const double area = length(cross(edges[0], edges[2]));
    for (size_t c = 0; c < 3; ++c) {
      const uint32_t entry = next[p[c]]++;
      rings.triangles[entry] = static_cast<uint32_t>(t);
      angles[entry] = static_cast<float>(angleOf(area, -dot(edges[c], edges[(c + 2) % 3])));
    }
  }
  UnitShares shares;
  for (size_t p = 0; p < surface.points.size(); ++p) {
    const uint32_t begin = rings.offsets[p], count = rings.offsets[p + 1] - begin;
    shares({angles.data() + begin, count}, {rings.weights.data() + begin, count});
  }
  return rings;
}

std::vector<Float3> pointNormals(const RestSurface& surface) {
  std::vector<Double3> sums(surface.points.size(), {0.0, 0.0, 0.0});
  for (size_t t = 0; t < surface.triangleCount(); ++t) {
    const Float3 a = surface.points[surface.corner(t, 0)];
    const Double3 n =
        cross(surface.points[surface.corner(t, 1)] - a, surface.points[surface.corner(t, 2)] - a);
    for (size_t c = 0; c < 3; ++c) {
      Double3& sum = sums[surface.corner(t, c)];
      sum = {sum.x + n.x, sum.y + n.y, sum.z + n.z};
    }
  }
  std::vector<Float3> normals(sums.size());
  for (size_t p = 0; p < sums.size(); ++p) {
    const double l = length(sums[p]);
    normals[p] = l > 0.0 ? Float3{static_cast<float>(sums[p].x / l), static_cast<float>(sums[p].y / l),
                                  static_cast<float>(sums[p].z / l)}
                         : Float3{0.0f, 1.0f, 0.0f};
  }
  return normals;
}

void makeCoefficients(const RestSurface& surface, Measure measure, std::span<const Float3> directions,
                      size_t begin, size_t end, std::span<float> out) {
  const size_t each = coefficientCount(measure);
  for (size_t t = begin; each > 0 && t < end; ++t) {
    float* numbers = &out[t * each];
    std::fill_n(numbers, each, 0.0f);
    if (isDegenerate(surface, t)) continue;
    const Float3 origin = surface.points[surface.corner(t, 0)];
    const Double3 e1 = surface.points[surface.corner(t, 1)] - origin,
                  e2 = surface.points[surface.corner(t, 2)] - origin;
    const double a = length(e1);
    const Double3 x = {e1.x / a, e1.y / a, e1.z / a};
    const double b = dot(e2, x);
    const Double3 up = {e2.x - b * x.x, e2.y - b * x.y, e2.z - b * x.z};
    const double c = length(up);
    if (!(a > 0.0) || !(c > 0.0)) continue;
    double values[3] = {0.0, 0.0, 0.0};
    if (measure == Measure::kArea) {
      values[0] = 1.0 / (a * c);
    } else if (measure == Measure::kPrincipal) {
      values[0] = 1.0 / a;
      values[1] = -b / (a * c);
      values[2] = 1.0 / c;
    } else {
      double cos2 = 0.0, sin2 = 0.0;
      for (size_t k = 0; k < 3; ++k) {
        const Float3 d = directions[surface.corner(t, k)];
        const Double3 wide = {double{d.x}, double{d.y}, double{d.z}};
        const double dx = dot(wide, x), dy = dot(wide, up) / c;
        cos2 += dx * dx - dy * dy;
        sin2 += 2.0 * dx * dy;
      }
      if (!(cos2 * cos2 + sin2 * sin2 >= kLeastAgreement * kLeastAgreement)) continue;
      const auto [cosine, sine] = halfAngle(cos2, sin2);
      values[1] = sine / c;
      values[0] = (cosine - values[1] * b) / a;
    }
    if (std::all_of(values, values + 3, [](double v) { return std::abs(v) <= 3e38; }))
      std::copy_n(values, each, numbers);
  }
}

void UnitShares::operator()(std::span<const float> values, std::span<uint16_t> out) {
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  remainders_.clear();
  uint32_t left = 65535;
  for (size_t i = 0; i < values.size(); ++i) {
    const double share =
        65535.0 * (sum > 0.0 ? double{values[i]} / sum : 1.0 / static_cast<double>(values.size()));
    out[i] = static_cast<uint16_t>(std::min(share, static_cast<double>(left)));
    left -= out[i];
    remainders_.push_back({static_cast<double>(out[i]) - share, i});
  }
  std::sort(remainders_.begin(), remainders_.end());
  for (size_t i = 0; left > 0 && !remainders_.empty(); i = (i + 1) % remainders_.size(), --left)
    ++out[remainders_[i].second];
}

}  // namespace furrow
