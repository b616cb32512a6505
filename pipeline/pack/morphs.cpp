#include "pipeline/pack/morphs.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "furrow/jobs.h"

namespace furrow::pipeline {
namespace {

constexpr double kStepsAShortEdge = 64.0;
constexpr double kStepsAcross = 32768.0;  // of the largest side of the parts it moves
constexpr size_t kFew = 128;              // vertices that take about a kilobyte at most
constexpr float kCheap = 4.0f;  // steps that a prediction may miss by before finer ones take more than 4 bits

float quantile(std::vector<float>& values, size_t above, size_t of) {
  if (values.empty()) return 0.0f;
  const auto at = values.begin() + static_cast<ptrdiff_t>(values.size() * above / of);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

float largestSide(const std::vector<glm::vec3>& positions) {
  glm::vec3 low(INFINITY), high(-INFINITY);
  for (const glm::vec3& p : positions) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  return std::max({high.x - low.x, high.y - low.y, high.z - low.z});
}

std::vector<uint32_t> surfaceVertices(const Surface& surface) {
  std::vector<uint32_t> first(surface.point_positions.size(), kNoIndex), out;
  out.reserve(surface.vertex_point.size());
  for (uint32_t v = 0; v < surface.vertex_point.size(); ++v) {
    uint32_t& vertex = first[surface.vertex_point[v]];
    vertex = std::min(vertex, v);
    out.push_back(vertex);
  }
  return out;
}

std::span<const uint32_t> flat(const std::vector<glm::uvec3>& triangles) {
  return {reinterpret_cast<const uint32_t*>(triangles.data()), 3 * triangles.size()};
}

glm::vec3 vec(const std::array<float, 3>& a) {
  return {a[0], a[1], a[2]};
}

std::vector<Int3> quantized(const std::vector<std::array<float, 3>>& field,
                            const std::vector<uint32_t>& vertices, float step, uint32_t bits) {
  const double most = (1 << (bits - 1)) - 1;
  std::vector<Int3> out(vertices.size(), Int3{});
  for (size_t i = 0; step > 0.0f && i < vertices.size(); ++i)
    for (size_t c = 0; c < 3; ++c)
      out[i][c] = static_cast<int32_t>(
          std::lround(std::clamp(double{field[vertices[i]][c]} / double{step}, -most, most)));
  return out;
}

float largest(const std::vector<std::array<float, 3>>& field, const std::vector<uint32_t>& vertices) {
  float most = 0.0f;
  for (uint32_t v : vertices)
    for (float d : field[v]) most = std::max(most, std::abs(d));
  return most;
}

}  // namespace

MorphPacker::MorphPacker(const SourceScene& scene, const Surface& surface,
                         const std::vector<uint32_t>& source_vertex)
    : scene_(scene),
      surface_(surface),
      asset_vertex_(source_vertex.size()),
      rest_(source_vertex.size()),
      predictor_(flat(surface.triangles), surfaceVertices(surface)),
      displacement_(source_vertex.size()),
      bend_(source_vertex.size()),
      field_(source_vertex.size()) {
  for (uint32_t v = 0; v < source_vertex.size(); ++v) asset_vertex_[source_vertex[v]] = v;
  for (const SurfacePart& span : surface.parts) {
    const Primitive& primitive = scene.primitives[scene.parts[span.source_part].primitive];
    for (size_t v = 0; v < primitive.positions.size(); ++v)
      rest_[asset_vertex_[span.vertex_begin + v]] = primitive.positions[v];
  }
}

PackedMorph MorphPacker::pack(uint32_t morph) {
  gather(morph);
  PackedMorph packed;
  packed.position_step = static_cast<float>(positionStep());
  packed.normal_step = largest(bend_, moved_) / 127.0f;
  std::vector<Int3> positions = quantized(displacement_, moved_, packed.position_step, kPositionDeltaBits);
  std::vector<Int3> normals = quantized(bend_, moved_, packed.normal_step, kNormalDeltaBits);
  measureError(packed, positions);

  size_t kept = 0;
  for (size_t i = 0; i < moved_.size(); ++i) {
    displacement_[moved_[i]] = bend_[moved_[i]] = {};
    if (positions[i] == Int3{} && normals[i] == Int3{}) continue;
    positions[kept] = positions[i];
    normals[kept] = normals[i];
    moved_[kept++] = moved_[i];
  }
  positions.resize(kept);
  normals.resize(kept);
  moved_.resize(kept);

  packed.vertices = static_cast<uint32_t>(kept);
  uint32_t end = 0;
  for (uint32_t v : moved_) {
    if (packed.runs.empty() || v != end) packed.runs.insert(packed.runs.end(), {v - end, 0});
    ++packed.runs.back();
    end = v + 1;
  }
  packed.position_stride = encode(positions, kPositionDeltaBits, packed.positions);
  if (packed.normal_step > 0.0f) encode(normals, kNormalDeltaBits, packed.normals);
  return packed;
}

// The morphs of a rig belong to nodes; the parts that show the node's mesh bring the vertices.
void MorphPacker::gather(uint32_t morph) {
  std::vector<bool> moves(displacement_.size());
  across_ = 0.0f;
  for (const SurfacePart& span : surface_.parts) {
    const Part& part = scene_.parts[span.source_part];
    const Primitive& primitive = scene_.primitives[part.primitive];
    if (morph < part.first_morph || morph - part.first_morph >= primitive.morphs.size()) continue;
    const MorphDelta& delta = primitive.morphs[morph - part.first_morph];
    if (!delta.vertices.empty()) across_ = std::max(across_, largestSide(primitive.positions));
    for (size_t i = 0; i < delta.vertices.size(); ++i) {
      const uint32_t v = asset_vertex_[span.vertex_begin + delta.vertices[i]];
      moves[v] = true;
      const glm::vec3 d = delta.positions[i];
      displacement_[v] = {d.x, d.y, d.z};
      if (delta.normals.empty()) continue;
      const glm::vec3 n = delta.normals[i];
      bend_[v] = {n.x, n.y, n.z};
    }
  }
  moved_.clear();
  for (uint32_t v = 0; v < moves.size(); ++v)
    if (moves[v]) moved_.push_back(v);
}

double MorphPacker::positionStep() const {
  std::vector<float> edges, misses;
  for (uint32_t v : moved_) {
    const uint32_t n = predictor_.neighbour(v);
    const glm::vec3 rest = rest_[v] - rest_[n];
    const float length = glm::length(rest);
    const float posed = glm::length(rest + vec(displacement_[v]) - vec(displacement_[n]));
    if (length > 0.0f) edges.push_back(std::clamp(posed, length * std::sqrt(kMinQ), length));
    float miss = 0.0f;
    for (size_t c = 0; c < 3; ++c)
      miss = std::max(miss, std::abs(displacement_[v][c] - 0.5f * predictor_.twice(displacement_, v, c)));
    misses.push_back(miss);
  }
  const double coarsest =
      std::min(double{quantile(edges, 1, 20)} / kStepsAShortEdge, double{across_} / kStepsAcross);
  const double cheapest = moved_.size() <= kFew ? 0.0 : double{quantile(misses, 3, 4)} / double{kCheap};
  const double finest = double{largest(displacement_, moved_)} / ((1 << (kPositionDeltaBits - 1)) - 1);
  return std::max(std::min(coarsest, cheapest), finest);
}

void MorphPacker::measureError(PackedMorph& packed, const std::vector<Int3>& values) const {
  size_t i = 0;
  for (const SurfacePart& span : surface_.parts)
    for (const glm::mat3 linear(span.rest); i < moved_.size() && moved_[i] < span.vertex_end; ++i) {
      const glm::vec3 stored(values[i][0], values[i][1], values[i][2]);
      const glm::vec3 error = linear * (packed.position_step * stored - vec(displacement_[moved_[i]]));
      packed.error = std::max(packed.error, double{glm::length(error)});
    }
}

// Appends what furrow::decodeDeltas reads and gives the stride.
uint32_t MorphPacker::encode(const std::vector<Int3>& values, uint32_t bits, std::vector<uint8_t>& out) {
  std::vector<Int3> differences(values.size());
  int32_t most = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    for (size_t c = 0; c < 3; ++c) {
      differences[i][c] = wrapped(values[i][c] - predictor_.predict(field_, moved_[i], c), bits);
      most = std::max(most, std::abs(differences[i][c]));
    }
    field_[moved_[i]] = values[i];
  }
  for (uint32_t v : moved_) field_[v] = {};

  uint32_t groups = 1;
  for (int32_t reach = 127; groups < bits / 8 && most > reach; reach = 256 * reach + 127) ++groups;
  const size_t stride = 4 * groups;
  out.assign(values.size() * stride, 0);
  for (size_t i = 0; i < values.size(); ++i)
    for (size_t c = 0; c < 3; ++c) {
      int32_t rest = differences[i][c];
      for (size_t g = 0; g < groups; ++g) {
        const auto digit = static_cast<int8_t>(static_cast<uint8_t>(rest & 255));
        rest = (rest - digit) >> 8;
        const size_t at = i * stride + 4 * g + c;
        out[at] = static_cast<uint8_t>((i > 0 ? out[at - stride] : 0) + digit);
      }
    }
  return static_cast<uint32_t>(stride);
}

}  // namespace furrow::pipeline
