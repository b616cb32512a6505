#include <algorithm>
#include <cmath>

#include "dual_quaternion.h"
#include "furrow/jobs.h"

namespace furrow {
namespace {

constexpr float kUnorm16 = 1.0f / 65535.0f;
static_assert(65535.0f * kUnorm16 == 1.0f, "a single influence must not scale the vertex");

// The expression order here is that of shaders/deform.comp: both tiers must pose a vertex to the same bits.
Affine blend(const AssetView& asset, std::span<const Affine> palette, uint32_t vertex) {
  const size_t first = size_t{vertex} * asset.influences;
  Affine sum;
  for (int i = 0; i < 12; ++i) sum.m[i] = 0.0f;
  for (uint32_t k = 0; k < asset.influences; ++k) {
    if (asset.weights[first + k] == 0) continue;
    const float weight = static_cast<float>(asset.weights[first + k]) * kUnorm16;
    const Affine& joint = palette[asset.joints[first + k]];
    for (int i = 0; i < 12; ++i) sum.m[i] = sum.m[i] + weight * joint.m[i];
  }
  return sum;
}

Float3 transformPoint(const Affine& a, Float3 p) {
  return {((a.m[0] * p.x + a.m[1] * p.y) + a.m[2] * p.z) + a.m[3],
          ((a.m[4] * p.x + a.m[5] * p.y) + a.m[6] * p.z) + a.m[7],
          ((a.m[8] * p.x + a.m[9] * p.y) + a.m[10] * p.z) + a.m[11]};
}

Float3 normalized(Float3 v) {
  const float length = std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
  if (!(length > 0.0f)) return {0.0f, 1.0f, 0.0f};
  return {v.x / length, v.y / length, v.z / length};
}

// Of the linear part: -1 where it mirrors.
float handedness(const Affine& a) {
  const float* m = a.m;
  const float determinant = m[0] * (m[5] * m[10] - m[6] * m[9]) + m[1] * (m[6] * m[8] - m[4] * m[10]) +
                            m[2] * (m[4] * m[9] - m[5] * m[8]);
  return determinant < 0.0f ? -1.0f : 1.0f;
}

// By the cofactor matrix, which is right for unevenly scaled joints too, and outwards still where they
// mirror.
Float3 transformNormal(const Affine& a, Float3 n, float hand) {
  const float* m = a.m;
  const Float3 v = {(m[5] * m[10] - m[6] * m[9]) * n.x + (m[6] * m[8] - m[4] * m[10]) * n.y +
                        (m[4] * m[9] - m[5] * m[8]) * n.z,
                    (m[2] * m[9] - m[1] * m[10]) * n.x + (m[0] * m[10] - m[2] * m[8]) * n.y +
                        (m[1] * m[8] - m[0] * m[9]) * n.z,
                    (m[1] * m[6] - m[2] * m[5]) * n.x + (m[2] * m[4] - m[0] * m[6]) * n.y +
                        (m[0] * m[5] - m[1] * m[4]) * n.z};
  return normalized({hand * v.x, hand * v.y, hand * v.z});
}

Float4 transformTangent(const Affine& a, Float4 t, Float3 n, float hand) {
  const float* m = a.m;
  const Float3 v = {m[0] * t.x + m[1] * t.y + m[2] * t.z, m[4] * t.x + m[5] * t.y + m[6] * t.z,
                    m[8] * t.x + m[9] * t.y + m[10] * t.z};
  const float along = v.x * n.x + v.y * n.y + v.z * n.z;
  const Float3 unit = normalized({v.x - along * n.x, v.y - along * n.y, v.z - along * n.z});
  return {unit.x, unit.y, unit.z, hand * t.w};
}

}  // namespace

Status DeformJob::validate() const {
  if (!asset) return Status::error(StatusCode::kInvalidArgument, "deform: no asset");
  const size_t vertices = asset->vertexCount();
  if (palette.size() != asset->palette.size())
    return Status::error(StatusCode::kInvalidArgument, "deform: %zu palette matrices, the asset has %zu",
                         palette.size(), asset->palette.size());
  if (morph_weights.size() != asset->morphs.size())
    return Status::error(StatusCode::kInvalidArgument, "deform: %zu morph weights, the asset has %zu",
                         morph_weights.size(), asset->morphs.size());
  if (positions.size() < vertices || (!normals.empty() && normals.size() < vertices) ||
      (!tangents.empty() && (tangents.size() < vertices || normals.empty())))
    return Status::error(StatusCode::kInvalidArgument, "deform: an output holds fewer than %zu vertices",
                         vertices);
  if (skinning == Skinning::kDualQuaternion && motions.size() != palette.size())
    return Status::error(StatusCode::kInvalidArgument, "deform: %zu joint motions, the palette has %zu",
                         motions.size(), palette.size());
  return {};
}

void DeformJob::run(uint32_t begin, uint32_t end) const {
  std::copy(asset->positions.begin() + begin, asset->positions.begin() + end, positions.begin() + begin);
  if (!normals.empty())
    std::copy(asset->normals.begin() + begin, asset->normals.begin() + end, normals.begin() + begin);

  for (size_t m = 0; m < morph_weights.size(); ++m) {
    if (morph_weights[m] == 0.0f) continue;
    const Morph& morph = asset->morphs[m];
    const float step = morph_weights[m] * morph.position_step;
    const float normal_step = morph_weights[m] * morph.normal_step;
    const bool with_normals = !normals.empty() && !morph.normal_deltas.empty();
    const auto first = std::lower_bound(morph.vertices.begin(), morph.vertices.end(), begin);
    for (size_t i = static_cast<size_t>(first - morph.vertices.begin());
         i < morph.vertices.size() && morph.vertices[i] < end; ++i) {
      const int32_t* delta = &morph.position_deltas[3 * i];
      Float3& p = positions[morph.vertices[i]];
      p = {p.x + step * static_cast<float>(delta[0]), p.y + step * static_cast<float>(delta[1]),
           p.z + step * static_cast<float>(delta[2])};
      if (!with_normals) continue;
      const int8_t* bend = &morph.normal_deltas[3 * i];
      Float3& n = normals[morph.vertices[i]];
      n = {n.x + normal_step * static_cast<float>(bend[0]), n.y + normal_step * static_cast<float>(bend[1]),
           n.z + normal_step * static_cast<float>(bend[2])};
    }
  }

  for (uint32_t v = begin; v < end; ++v) {
    const Affine matrix =
        skinning == Skinning::kLinear ? blend(*asset, palette, v) : blendMotions(*asset, motions, v);
    positions[v] = transformPoint(matrix, positions[v]);
    if (normals.empty()) continue;
    const float hand = handedness(matrix);
    normals[v] = transformNormal(matrix, normals[v], hand);
    if (!tangents.empty()) tangents[v] = transformTangent(matrix, asset->tangents[v], normals[v], hand);
  }
}

}  // namespace furrow
