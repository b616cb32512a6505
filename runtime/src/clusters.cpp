#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <new>
#include <numeric>

#include "src/cluster_kernels.h"
#include "src/deform_kernel.h"

namespace furrow {
namespace {

constexpr double kMostSteps = 1 << 30;  // of a quantised position

float coordinate(Float3 p, int axis) {
  return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
}

class Builder {
 public:
  Builder(const AssetView& asset, const ClusterLimits& limits, Clusters& out)
      : a_(asset),
        limits_(limits),
        out_(out),
        triangle_local_(asset.triangleCount(), kAbsent),
        vertex_slot_(asset.vertexCount(), kAbsent) {}

  uint32_t restWords() const { return rest_words_; }

  Status build() {
    listVertices();
    std::vector<uint32_t> points(a_.pointCount());
    std::iota(points.begin(), points.end(), 0u);
    out_.morph_run_begin.push_back(0);
    return cut(points);
  }

 private:
  // Vertices of each point, ascending, so that the point's own vertex comes first.
  void listVertices() {
    first_vertex_.assign(a_.pointCount() + 1, 0);
    for (uint32_t p : a_.vertex_point) ++first_vertex_[p + 1];
    std::partial_sum(first_vertex_.begin(), first_vertex_.end(), first_vertex_.begin());
    vertices_.resize(a_.vertexCount());
    std::vector<uint32_t> next(first_vertex_.begin(), first_vertex_.end() - 1);
    for (uint32_t v = 0; v < a_.vertexCount(); ++v) vertices_[next[a_.vertex_point[v]]++] = v;
  }

  // Recursive coordinate bisection: halves of whole clusters along the longest side. Depth is at most log2 of
  // the points.
  Status cut(std::span<uint32_t> points) {
    if (points.size() <= limits_.points && add(points)) return {};
    if (points.size() == 1)
      return Status::error(StatusCode::kUnavailable,
                           "a point has too many triangles for the clustered frame (%u)",
                           a_.ring_offsets[points[0] + 1] - a_.ring_offsets[points[0]]);
    Float3 low = position(points[0]), high = low;
    for (uint32_t p : points) {
      const Float3 at = position(p);
      low = {std::min(low.x, at.x), std::min(low.y, at.y), std::min(low.z, at.z)};
      high = {std::max(high.x, at.x), std::max(high.y, at.y), std::max(high.z, at.z)};
    }
    const Float3 side = {high.x - low.x, high.y - low.y, high.z - low.z};
    const int axis = side.x >= side.y && side.x >= side.z ? 0 : side.y >= side.z ? 1 : 2;
    const size_t leaves = std::max<size_t>(2, (points.size() + limits_.points - 1) / limits_.points);
    const size_t left = points.size() * (leaves / 2) / leaves;
    std::nth_element(points.begin(), points.begin() + static_cast<ptrdiff_t>(left), points.end(),
                     [&](uint32_t a, uint32_t b) {
                       const float x = coordinate(position(a), axis), y = coordinate(position(b), axis);
                       return x != y ? x < y : a < b;
                     });
    if (Status status = cut(points.first(left)); !status.ok()) return status;
    return cut(points.subspan(left));
  }

  Float3 position(uint32_t point) const { return a_.positions[a_.point_vertex[point]]; }

  uint32_t degree(uint32_t point) const { return a_.ring_offsets[point + 1] - a_.ring_offsets[point]; }

  // False if the points reach more than a cluster can number.
  bool add(std::span<uint32_t> points) {
    std::sort(points.begin(), points.end(), [&](uint32_t a, uint32_t b) {
      return degree(a) != degree(b) ? degree(a) > degree(b) : a_.point_vertex[a] < a_.point_vertex[b];
    });
    triangles_.clear();
    for (uint32_t p : points)
      for (uint32_t i = a_.ring_offsets[p]; i < a_.ring_offsets[p + 1]; ++i)
        if (triangle_local_[a_.ring_triangles[i]] == kAbsent) {
          triangle_local_[a_.ring_triangles[i]] = 0;
          triangles_.push_back(a_.ring_triangles[i]);
        }
    std::sort(triangles_.begin(), triangles_.end());
    for (uint32_t i = 0; i < triangles_.size(); ++i) triangle_local_[triangles_[i]] = i;

    Cluster c = {};
    c.points = static_cast<uint32_t>(points.size());
    listSlots(points, c);
    const bool fits = c.slots <= limits_.slots && triangles_.size() + kTriangleLanes - 1 <= limits_.triangles;
    if (fits) {
      c.triangles =
          static_cast<uint32_t>((triangles_.size() + kTriangleLanes - 1) / kTriangleLanes * kTriangleLanes);
      addPose(c);
      c.slot_vertex = reserve(c.slots);
      std::copy(slots_.begin(), slots_.end(), &out_.words[c.slot_vertex]);
      c.extra_point = addHalves(extra_, extra_.size());
      halves_.clear();
      for (uint32_t t : triangles_)
        for (int k = 0; k < 3; ++k)
          halves_.push_back(static_cast<uint16_t>(4 * vertex_slot_[a_.surface_indices[3 * size_t{t} + k]]));
      c.corners = addHalves(halves_, 3 * size_t{c.triangles});
      align();
      c.layers = static_cast<uint32_t>(out_.words.size());
      addLayers(points, c);
      align();
      c.rest = rest_words_;
      rest_words_ += static_cast<uint32_t>(out_.words.size()) - c.layers;
      addRings(points, c);
      addMorphs(c);
      c.end = static_cast<uint32_t>(out_.words.size());
      align();
      out_.clusters.push_back(c);
    }
    for (uint32_t v : slots_) vertex_slot_[v] = kAbsent;
    for (uint32_t t : triangles_) triangle_local_[t] = kAbsent;
    return fits;
  }

  void align() { out_.words.resize((out_.words.size() + kLineWords - 1) / kLineWords * kLineWords, 0); }

  uint32_t reserve(size_t words) {
    const auto begin = static_cast<uint32_t>(out_.words.size());
    out_.words.resize(begin + words, 0);
    return begin;
  }

  // As words, padded with zeros to `count` and to whole words.
  uint32_t addHalves(std::span<const uint16_t> halves, size_t count) {
    const uint32_t begin = reserve((count + 1) / 2);
    for (size_t i = 0; i < halves.size(); ++i)
      out_.words[begin + i / 2] |= uint32_t{halves[i]} << (16 * (i % 2));
    return begin;
  }

  void listSlots(std::span<const uint32_t> points, Cluster& c) {
    slots_.clear();
    extra_.clear();
    const auto slot = [&](uint32_t vertex) {
      vertex_slot_[vertex] = static_cast<uint32_t>(slots_.size());
      slots_.push_back(vertex);
    };
    for (uint32_t p : points) slot(a_.point_vertex[p]);
    for (size_t i = 0; i < points.size(); ++i)
      for (uint32_t k = first_vertex_[points[i]] + 1; k < first_vertex_[points[i] + 1]; ++k) {
        slot(vertices_[k]);
        extra_.push_back(static_cast<uint16_t>(i));
      }
    c.vertices = static_cast<uint32_t>(slots_.size());
    for (uint32_t t : triangles_)
      for (int k = 0; k < 3; ++k) {
        const uint32_t v = a_.surface_indices[3 * size_t{t} + k];
        if (vertex_slot_[v] == kAbsent) slot(v);
      }
    std::sort(slots_.begin() + c.vertices, slots_.end());
    for (size_t s = c.vertices; s < slots_.size(); ++s) vertex_slot_[slots_[s]] = static_cast<uint32_t>(s);
    c.slots = static_cast<uint32_t>(slots_.size());
    c.last_slot = std::min(vertex_slot_.back(), c.slots);
  }

  // How the rest positions of the slots can be had back from 16-bit integers, if they are of one part.
  RestHeader restHeader() const {
    RestHeader rest = {};
    const auto part = std::find_if(a_.parts.begin(), a_.parts.end(),
                                   [&](const Part& each) { return slots_[0] < each.vertex_end; });
    if (part == a_.parts.end() || !(part->position_step > 0.0f)) return rest;
    rest.step = part->position_step;
    const Float3 offset = part->position_offset;
    for (int k = 0; k < 3; ++k) {
      rest.offset[k] = coordinate(offset, k);
      int64_t least = INT32_MAX, most = 0;
      for (uint32_t v : slots_) {
        if (v < part->vertex_begin || v >= part->vertex_end) return rest;
        const float x = coordinate(a_.positions[v], k);
        const int64_t n = quantized(x, rest.offset[k], rest.step);
        if (n < 0 || rest.offset[k] + rest.step * static_cast<float>(n) != x) return rest;
        least = std::min(least, n), most = std::max(most, n);
      }
      if (most - least > 65535) return rest;
      rest.first[k] = static_cast<int32_t>(least);
    }
    rest.quantized = 1;
    return rest;
  }

  static int64_t quantized(float x, float offset, float step) {
    const double n = (double{x} - double{offset}) / double{step};
    return std::abs(n) <= kMostSteps ? std::llround(n) : -1;
  }

  void addPose(Cluster& c) {
    const RestHeader rest = restHeader();
    const uint32_t influences = a_.influences, group_words = out_.poseGroupWords(rest.quantized != 0);
    c.pose = reserve(kRestHeaderWords + (c.slots + kPoseLanes - 1) / kPoseLanes * size_t{group_words});
    std::memcpy(&out_.words[c.pose], &rest, sizeof rest);
    for (uint32_t s = 0; s < c.slots; ++s) {
      uint32_t* group = &out_.words[c.pose + kRestHeaderWords + s / kPoseLanes * size_t{group_words}];
      const uint32_t lane = s % kPoseLanes;
      auto* halves = reinterpret_cast<uint16_t*>(group);
      for (uint32_t k = 0; k < 3; ++k) {
        const float x = coordinate(a_.positions[slots_[s]], static_cast<int>(k));
        if (rest.quantized)
          halves[k * kPoseLanes + lane] =
              static_cast<uint16_t>(quantized(x, rest.offset[k], rest.step) - rest.first[k]);
        else
          group[k * kPoseLanes + lane] = std::bit_cast<uint32_t>(x);
      }
      halves += (rest.quantized ? 3 : 6) * kPoseLanes;
      const uint16_t* weights = &a_.weights[size_t{slots_[s]} * influences];
      const uint16_t* joints = &a_.joints[size_t{slots_[s]} * influences];
      for (uint32_t k = 1; k < influences; ++k) halves[(k - 1) * kPoseLanes + lane] = weights[k];
      halves += (influences - 1) * kPoseLanes;
      for (uint32_t k = 0; k < influences; ++k) {
        if (out_.wideJoints())
          halves[lane * influences + k] = joints[k];
        else
          reinterpret_cast<uint8_t*>(halves)[lane * influences + k] = static_cast<uint8_t>(joints[k]);
      }
    }
  }

  void addRings(std::span<const uint32_t> points, Cluster& c) {
    const size_t chunks = (points.size() + kRingLanes - 1) / kRingLanes;
    c.chunks = reserve(chunks + 1);
    align();
    for (size_t i = 0; i < chunks; ++i) {
      const size_t first = i * kRingLanes, length = degree(points[first]);
      halves_.assign(2 * kRingLanes * length, 0);
      for (size_t lane = 0; lane < kRingLanes && first + lane < points.size(); ++lane) {
        const uint32_t ring = a_.ring_offsets[points[first + lane]];
        for (uint32_t k = 0; k < degree(points[first + lane]); ++k) {
          uint16_t* step = &halves_[size_t{2} * kRingLanes * k];
          step[lane] = static_cast<uint16_t>(triangle_local_[a_.ring_triangles[ring + k]]);
          step[kRingLanes + lane] = a_.ring_weights[ring + k];
        }
      }
      const uint32_t begin = addHalves(halves_, halves_.size());
      out_.words[c.chunks + i] = begin;
    }
    out_.words[c.chunks + chunks] = static_cast<uint32_t>(out_.words.size());
  }

  void addLayers(std::span<const uint32_t> points, Cluster& c) {
    const size_t padded = (points.size() + kTriangleLanes - 1) / kTriangleLanes * kTriangleLanes;
    for (uint32_t l = 0; l < a_.layerCount(); ++l) {
      const uint32_t each = coefficientCount(a_.layers[l].measure);
      const std::span<const float> all = a_.layers[l].coefficients;
      const auto measured = [&](uint32_t t) {
        for (uint32_t k = 0; k < each; ++k)
          if (all[size_t{t} * each + k] != 0.0f) return true;
        return false;
      };
      out_.layer_words.push_back(static_cast<uint32_t>(out_.words.size()));
      if (std::none_of(triangles_.begin(), triangles_.end(), measured)) continue;
      c.covered |= 1u << l;
      align();
      out_.layer_words.back() = static_cast<uint32_t>(out_.words.size());
      const uint32_t coefficients = reserve(size_t{c.triangles} * each);
      for (size_t i = 0; i < triangles_.size(); ++i) {
        const size_t group = coefficients + i / kTriangleLanes * kTriangleLanes * each;
        for (uint32_t k = 0; k < each; ++k)
          out_.words[group + k * kTriangleLanes + i % kTriangleLanes] =
              std::bit_cast<uint32_t>(all[size_t{triangles_[i]} * each + k]);
      }
      halves_.clear();
      for (uint32_t p : points) {
        uint32_t total = 0;
        for (uint32_t i = a_.ring_offsets[p]; i < a_.ring_offsets[p + 1]; ++i)
          if (measured(a_.ring_triangles[i])) total += a_.ring_weights[i];
        halves_.push_back(static_cast<uint16_t>(total));
      }
      addHalves(halves_, padded);
    }
  }

  // Morph::vertices ascend, so the slots of a cluster find their deltas by binary search.
  void addMorphs(const Cluster& c) {
    for (uint32_t m = 0; m < a_.morphs.size(); ++m) {
      const std::span<const uint32_t> moved = a_.morphs[m].vertices;
      const auto begin = static_cast<uint32_t>(out_.morph_slots.size());
      for (uint32_t s = 0; s < c.slots; ++s) {
        const auto at = std::lower_bound(moved.begin(), moved.end(), slots_[s]);
        if (at == moved.end() || *at != slots_[s]) continue;
        out_.morph_slots.push_back(static_cast<uint16_t>(s));
        out_.morph_index.push_back(static_cast<uint32_t>(at - moved.begin()));
      }
      const auto end = static_cast<uint32_t>(out_.morph_slots.size());
      if (end > begin) out_.morph_runs.push_back({m, begin, end});
    }
    out_.morph_run_begin.push_back(static_cast<uint32_t>(out_.morph_runs.size()));
  }

  const AssetView& a_;
  const ClusterLimits& limits_;
  Clusters& out_;
  std::vector<uint32_t> first_vertex_, vertices_;  // vertices of each point
  std::vector<uint32_t> triangle_local_, vertex_slot_;
  std::vector<uint32_t> triangles_, slots_;  // of the cluster at hand
  std::vector<uint16_t> extra_, halves_;
  uint32_t rest_words_ = 0;
};

size_t padded(size_t count, size_t to) {
  return (count + to - 1) / to * to;
}

// Layers lie side by side in powers of two.
size_t layerRows(uint32_t layers) {
  return std::bit_ceil(std::min(layers, kMostInPass));
}

size_t pairRows(uint32_t layers) {
  return (std::min(layers, kMostInPass) + 1) / 2;
}

}  // namespace

size_t scratchBytes(const Cluster& c, uint32_t layers) {
  return sizeof(float) * (4 * padded(c.slots, kPoseLanes) + layerRows(layers) * c.triangles +
                          (layerRows(layers) + 1 + pairRows(layers)) * padded(c.vertices, kVertexPad));
}

ClusterScratch scratchOf(const Cluster& c, uint32_t layers, std::byte* memory) {
  ClusterScratch s = {};
  s.padded = padded(c.vertices, kVertexPad);
  s.positions = reinterpret_cast<float*>(memory);
  s.triangle_q = s.positions + 4 * padded(c.slots, kPoseLanes);
  s.q = s.triangle_q + layerRows(layers) * c.triangles;
  s.bias = s.q + layerRows(layers) * s.padded;
  s.pairs = reinterpret_cast<uint32_t*>(s.bias + s.padded);
  return s;
}

uint64_t Clusters::frameBytes(bool posed) const {
  uint64_t words_read = 0, vertices = 0, slots = 0;
  for (const Cluster& c : clusters) {
    words_read += c.end - (posed ? c.slot_vertex : c.pose);
    vertices += c.vertices;
    slots += c.slots;
  }
  return words_read * sizeof(uint32_t) + clusters.size() * sizeof(Cluster) +
         layer_words.size() * sizeof(uint32_t) + (posed ? slots * sizeof(Float3) : 0) +
         vertices * asset->weightStride() * sizeof(int16_t);
}

Clusters::Clusters(std::pmr::memory_resource* memory)
    : clusters(memory),
      words(memory),
      layer_words(memory),
      morph_run_begin(memory),
      morph_runs(memory),
      morph_slots(memory),
      morph_index(memory) {}

Status Clusters::build(const AssetView& source, const ClusterLimits& limits) try {
  std::pmr::memory_resource* memory = words.get_allocator().resource();
  *this = Clusters(memory);
  Clusters built(memory);
  built.asset = &source;
  if (source.influences == 0 || source.influences > kMostInfluences)
    return Status::error(StatusCode::kUnavailable, "%u influences a vertex", source.influences);
  ClusterLimits most = limits;
  if (most.points == 0)
    most.points = std::clamp(source.pointCount() / kThreadClusters, kFineClusterPoints, kClusterPoints);
  Builder builder(source, most, built);
  if (Status status = builder.build(); !status.ok()) return status;
  built.rest_words_ = builder.restWords();
  built.clusters.shrink_to_fit(), built.words.shrink_to_fit(), built.layer_words.shrink_to_fit();
  built.morph_run_begin.shrink_to_fit(), built.morph_runs.shrink_to_fit();
  built.morph_slots.shrink_to_fit(), built.morph_index.shrink_to_fit();
  for (const Cluster& c : built.clusters)
    built.scratch_bytes_ = std::max(built.scratch_bytes_, furrow::scratchBytes(c, source.layerCount()));
  *this = std::move(built);
  return {};
} catch (const std::bad_alloc&) {
  *this = Clusters(words.get_allocator().resource());
  return Status::error(StatusCode::kOutOfMemory, "out of memory");
}

}  // namespace furrow
