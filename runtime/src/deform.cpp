#include <algorithm>

#include "furrow/jobs.h"
#include "src/deform_kernel.h"

namespace furrow {
namespace {

// A block of vertices is morphed, then skinned while it is in the cache.
constexpr uint32_t kBlock = 2048;

// Rest vertices [begin, end) with the active targets added, into the outputs.
void morph(const DeformJob& job, uint32_t begin, uint32_t end) {
  const AssetView& asset = *job.asset;
  std::copy(asset.positions.begin() + begin, asset.positions.begin() + end, job.positions.begin() + begin);
  if (!job.normals.empty())
    std::copy(asset.normals.begin() + begin, asset.normals.begin() + end, job.normals.begin() + begin);
  for (size_t m = 0; m < asset.morphs.size(); ++m) {
    if (job.morph_weights[m] == 0.0f) continue;
    const Morph& morph = asset.morphs[m];
    const float step = job.morph_weights[m] * morph.position_step;
    const float normal_step = job.morph_weights[m] * morph.normal_step;
    const bool with_normals = !job.normals.empty() && !morph.normal_deltas.empty();
    const auto first = std::lower_bound(morph.vertices.begin(), morph.vertices.end(), begin);
    for (size_t i = static_cast<size_t>(first - morph.vertices.begin());
         i < morph.vertices.size() && morph.vertices[i] < end; ++i) {
      const int32_t* delta = &morph.position_deltas[3 * i];
      Float3& p = job.positions[morph.vertices[i]];
      p = {p.x + step * static_cast<float>(delta[0]), p.y + step * static_cast<float>(delta[1]),
           p.z + step * static_cast<float>(delta[2])};
      if (!with_normals) continue;
      const int8_t* bend = &morph.normal_deltas[3 * i];
      Float3& n = job.normals[morph.vertices[i]];
      n = {n.x + normal_step * static_cast<float>(bend[0]), n.y + normal_step * static_cast<float>(bend[1]),
           n.z + normal_step * static_cast<float>(bend[2])};
    }
  }
}

}  // namespace

Status DeformJob::validate() const {
  if (!asset) return Status::error(StatusCode::kInvalidArgument, "deform: no asset");
  if (asset->influences == 0 || asset->influences > kMostInfluences)
    return Status::error(StatusCode::kInvalidArgument, "deform: %u influences a vertex", asset->influences);
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
  if (!simdAvailable(simd))
    return Status::error(StatusCode::kUnavailable, "deform: this CPU or build has no %s", simdName(simd));
  return {};
}

void DeformJob::run(uint32_t begin, uint32_t end) const {
  const DeformRun skin = deformRun(simd);
  const bool morphed =
      std::any_of(morph_weights.begin(), morph_weights.end(), [](float w) { return w != 0.0f; });
  const Float3* rest_positions = morphed ? positions.data() : asset->positions.data();
  const Float3* rest_normals = normals.empty() ? nullptr : morphed ? normals.data() : asset->normals.data();
  for (uint32_t first = begin; first < end; first += kBlock) {
    const uint32_t last = std::min(end, first + kBlock);
    if (morphed) morph(*this, first, last);
    skin(*this, rest_positions, rest_normals, first, last);
  }
}

}  // namespace furrow
