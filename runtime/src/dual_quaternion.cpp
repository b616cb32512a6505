#include "dual_quaternion.h"

#include <algorithm>
#include <cmath>

namespace furrow {
namespace {

struct Matrix3 {
  double m[9];
};

Matrix3 linearPart(const Affine& a) {
  Matrix3 out;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) out.m[3 * r + c] = a.m[4 * r + c];
  return out;
}

// det(a) times the inverse transpose of a.
Matrix3 cofactors(const Matrix3& a) {
  const double* m = a.m;
  return {{m[4] * m[8] - m[5] * m[7], m[5] * m[6] - m[3] * m[8], m[3] * m[7] - m[4] * m[6],
           m[2] * m[7] - m[1] * m[8], m[0] * m[8] - m[2] * m[6], m[1] * m[6] - m[0] * m[7],
           m[1] * m[5] - m[2] * m[4], m[2] * m[3] - m[0] * m[5], m[0] * m[4] - m[1] * m[3]}};
}

double inner(const Matrix3& a, const Matrix3& b) {
  double sum = 0.0;
  for (int i = 0; i < 9; ++i) sum += a.m[i] * b.m[i];
  return sum;
}

// Newton's iteration with scaling (Higham 1986, Computing the polar decomposition); the identity where the
// matrix is flat or not finite.
Matrix3 nearestRotation(const Matrix3& a) {
  constexpr int kSteps = 20;  // doubles converge in six to nine
  Matrix3 q = a;
  for (int step = 0; step < kSteps; ++step) {
    const Matrix3 c = cofactors(q);
    const double determinant = (q.m[0] * c.m[0] + q.m[1] * c.m[1]) + q.m[2] * c.m[2];
    const double size2 = inner(q, q);
    if (!(std::abs(determinant) > 1e-9 * size2 * std::sqrt(size2)) || !std::isfinite(size2))
      return {{1, 0, 0, 0, 1, 0, 0, 0, 1}};
    const double scale = std::sqrt(std::sqrt(inner(c, c) / size2) / std::abs(determinant));
    Matrix3 next;
    double moved = 0.0;
    for (int i = 0; i < 9; ++i) {
      next.m[i] = 0.5 * (scale * q.m[i] + c.m[i] / (scale * determinant));
      moved = std::max(moved, std::abs(next.m[i] - q.m[i]));
    }
    q = next;
    if (moved < 1e-14) break;
  }
  const Matrix3 c = cofactors(q);
  if ((q.m[0] * c.m[0] + q.m[1] * c.m[1]) + q.m[2] * c.m[2] < 0.0)
    for (double& value : q.m) value = -value;
  return q;
}

// Shepperd 1978: from the largest of the four squares.
void quaternionOf(const Matrix3& r, double q[4]) {
  const double* m = r.m;
  const double squares[4] = {1.0 + m[0] - m[4] - m[8], 1.0 - m[0] + m[4] - m[8], 1.0 - m[0] - m[4] + m[8],
                             1.0 + m[0] + m[4] + m[8]};
  const auto largest = std::max_element(squares, squares + 4) - squares;
  switch (largest) {
    case 0:
      q[0] = squares[0], q[1] = m[1] + m[3], q[2] = m[2] + m[6], q[3] = m[7] - m[5];
      break;
    case 1:
      q[0] = m[1] + m[3], q[1] = squares[1], q[2] = m[5] + m[7], q[3] = m[2] - m[6];
      break;
    case 2:
      q[0] = m[2] + m[6], q[1] = m[5] + m[7], q[2] = squares[2], q[3] = m[3] - m[1];
      break;
    default:
      q[0] = m[7] - m[5], q[1] = m[2] - m[6], q[2] = m[3] - m[1], q[3] = squares[3];
  }
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (int i = 0; i < 4; ++i) q[i] /= length;
}

JointMotion split(const Affine& matrix) {
  const Matrix3 linear = linearPart(matrix), rotation = nearestRotation(linear);
  double q[4];
  quaternionOf(rotation, q);
  const double x = matrix.m[3], y = matrix.m[7], z = matrix.m[11];
  JointMotion out;
  out.rotation = {static_cast<float>(q[0]), static_cast<float>(q[1]), static_cast<float>(q[2]),
                  static_cast<float>(q[3])};
  out.dual = {static_cast<float>(0.5 * (x * q[3] + y * q[2] - z * q[1])),
              static_cast<float>(0.5 * (y * q[3] + z * q[0] - x * q[2])),
              static_cast<float>(0.5 * (z * q[3] + x * q[1] - y * q[0])),
              static_cast<float>(-0.5 * (x * q[0] + y * q[1] + z * q[2]))};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) {
      double sum = 0.0;
      for (int k = 0; k < 3; ++k) sum += rotation.m[3 * k + r] * linear.m[3 * k + c];
      out.stretch[3 * r + c] = static_cast<float>(sum);
    }
  return out;
}

}  // namespace

void splitPalette(std::span<const Affine> palette, std::span<JointMotion> out) {
  std::transform(palette.begin(), palette.end(), out.begin(), split);
}

Affine blendMotions(const AssetView& asset, std::span<const JointMotion> motions, uint32_t vertex) {
  constexpr float kUnorm16 = 1.0f / 65535.0f;
  const size_t first = size_t{vertex} * asset.influences;
  Float4 q = {0, 0, 0, 0}, d = {0, 0, 0, 0}, pivot = {0, 0, 0, 0};
  float k[9] = {};
  for (uint32_t i = 0; i < asset.influences; ++i) {
    if (asset.weights[first + i] == 0) continue;
    const JointMotion& joint = motions[asset.joints[first + i]];
    const Float4 r = joint.rotation;
    const float weight = static_cast<float>(asset.weights[first + i]) * kUnorm16;
    for (int e = 0; e < 9; ++e) k[e] += weight * joint.stretch[e];
    if (pivot.x == 0.0f && pivot.y == 0.0f && pivot.z == 0.0f && pivot.w == 0.0f) pivot = r;
    const float along = (pivot.x * r.x + pivot.y * r.y) + (pivot.z * r.z + pivot.w * r.w);
    const float w = along < 0.0f ? -weight : weight;
    q = {q.x + w * r.x, q.y + w * r.y, q.z + w * r.z, q.w + w * r.w};
    d = {d.x + w * joint.dual.x, d.y + w * joint.dual.y, d.z + w * joint.dual.z, d.w + w * joint.dual.w};
  }
  const float inverse = 1.0f / ((q.x * q.x + q.y * q.y) + (q.z * q.z + q.w * q.w));
  const float s = 2.0f * inverse;
  const float r[9] = {1.0f - s * (q.y * q.y + q.z * q.z), s * (q.x * q.y - q.w * q.z),
                      s * (q.x * q.z + q.w * q.y),        s * (q.x * q.y + q.w * q.z),
                      1.0f - s * (q.x * q.x + q.z * q.z), s * (q.y * q.z - q.w * q.x),
                      s * (q.x * q.z - q.w * q.y),        s * (q.y * q.z + q.w * q.x),
                      1.0f - s * (q.x * q.x + q.y * q.y)};
  const float t[3] = {s * ((q.w * d.x - d.w * q.x) + (q.y * d.z - q.z * d.y)),
                      s * ((q.w * d.y - d.w * q.y) + (q.z * d.x - q.x * d.z)),
                      s * ((q.w * d.z - d.w * q.z) + (q.x * d.y - q.y * d.x))};
  Affine out;
  for (int row = 0; row < 3; ++row) {
    for (int c = 0; c < 3; ++c)
      out.m[4 * row + c] = (r[3 * row] * k[c] + r[3 * row + 1] * k[3 + c]) + r[3 * row + 2] * k[6 + c];
    out.m[4 * row + 3] = t[row];
  }
  return out;
}

}  // namespace furrow
