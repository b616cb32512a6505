#include "furrow/pose.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace furrow {
namespace {

size_t elementBytes(VertexFormat format) {
  return format == VertexFormat::kFloat3 ? sizeof(Float3) : 3 * sizeof(uint16_t);
}

float widened(uint16_t half) {
  const uint32_t sign = (half & 0x8000u) << 16, rest = half & 0x7fffu;
  if (rest >= 0x7c00u) return std::bit_cast<float>(sign | 0x7f800000u | (rest & 0x3ffu) << 13);
  if (rest >= 0x400u) return std::bit_cast<float>(sign | ((rest << 13) + (112u << 23)));
  const float value = static_cast<float>(rest) * (1.0f / 16777216.0f);  // subnormal
  return sign ? -value : value;
}

Float3 element(const VertexStream& stream, size_t i) {
  const std::byte* at = stream.bytes.data() + stream.offset + i * stream.stride;
  Float3 out;
  if (stream.format == VertexFormat::kFloat3) {
    std::memcpy(&out, at, sizeof out);
    return out;
  }
  uint16_t halves[3];
  std::memcpy(halves, at, sizeof halves);
  return {widened(halves[0]), widened(halves[1]), widened(halves[2])};
}

Float3 unitOf(Float3 v) {
  const float length = std::sqrt((v.x * v.x + v.y * v.y) + v.z * v.z);
  if (!(length > 0.0f)) return {0.0f, 1.0f, 0.0f};
  return {v.x / length, v.y / length, v.z / length};
}

}  // namespace

uint64_t VertexStream::count() const {
  const size_t each = elementBytes(format);
  if (offset > bytes.size() || bytes.size() - offset < each) return 0;
  return stride == 0 ? 1 : (bytes.size() - offset - each) / stride + 1;
}

Status PoseJob::validate() const {
  const auto invalid = [](const char* what) {
    return Status::error(StatusCode::kInvalidArgument, "pose: %s", what);
  };
  const bool pair = !to.bytes.empty();
  for (const VertexStream* stream : {&from, &to}) {
    if (stream == &to && !pair) continue;
    if (stream->stride < elementBytes(stream->format))
      return invalid("the stride is shorter than an element");
  }
  const uint64_t elements = pair ? std::min(from.count(), to.count()) : from.count();
  if (element.empty() ? elements < out.size() : element.size() < out.size())
    return Status::error(StatusCode::kInvalidArgument, "pose: %llu elements, %zu are wanted",
                         static_cast<unsigned long long>(element.empty() ? elements : element.size()),
                         out.size());
  for (uint32_t e : element)
    if (e != kAbsent && e >= elements) return invalid("an element is out of range");
  if (!std::isfinite(time)) return invalid("the time is not finite");
  return {};
}

void PoseJob::run(uint32_t begin, uint32_t end) const {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const float b = curve == KeyCurve::kQuadratic ? time * time : time, a = 1.0f - b;
  const bool pair = !to.bytes.empty();
  for (uint32_t i = begin; i < end; ++i) {
    const uint32_t e = element.empty() ? i : element[i];
    if (e == kAbsent && patch) continue;
    Float3 p = {kNan, kNan, kNan};
    if (e != kAbsent) {
      p = furrow::element(from, e);
      if (pair) {
        const Float3 q = furrow::element(to, e);
        p = {a * p.x + b * q.x, a * p.y + b * q.y, a * p.z + b * q.z};
      }
    }
    out[i] = unit ? unitOf(p) : p;
  }
}

Status OcclusionJob::validate() const {
  if (!asset) return Status::error(StatusCode::kInvalidArgument, "occlusion: no asset");
  if (morph_weights.size() != asset->morphs.size() || deltas.size() != asset->morphs.size() ||
      rest.size() < asset->vertexCount() || out.size() < asset->vertexCount())
    return Status::error(StatusCode::kInvalidArgument, "occlusion: a span does not fit the asset");
  for (size_t m = 0; m < deltas.size(); ++m)
    if (!deltas[m].empty() && deltas[m].size() < asset->morphs[m].vertices.size())
      return Status::error(StatusCode::kInvalidArgument, "occlusion: target %zu has %zu deltas, it moves %zu",
                           m, deltas[m].size(), asset->morphs[m].vertices.size());
  return {};
}

void OcclusionJob::run(uint32_t begin, uint32_t end) const {
  std::copy(rest.begin() + begin, rest.begin() + end, out.begin() + begin);
  for (size_t m = 0; m < morph_weights.size(); ++m) {
    if (morph_weights[m] == 0.0f || deltas[m].empty()) continue;
    const std::span<const uint32_t> vertices = asset->morphs[m].vertices;
    const auto first = std::lower_bound(vertices.begin(), vertices.end(), begin);
    for (size_t i = static_cast<size_t>(first - vertices.begin()); i < vertices.size() && vertices[i] < end;
         ++i)
      out[vertices[i]] += morph_weights[m] * deltas[m][i];
  }
  for (uint32_t v = begin; v < end; ++v) out[v] = std::min(std::max(out[v], 0.0f), 1.0f);
}

}  // namespace furrow
