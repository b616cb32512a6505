#include "morph_codec.h"

#include <algorithm>

#include "furrow_generated.h"
#include "part_geometry.h"

namespace furrow {
namespace {

constexpr uint32_t kMostTried = 32;  // triangles at an edge's end, so that fans cost no square

Status bad(const char* what) {
  return Status::error(StatusCode::kBadData, "a morph target: %s", what);
}

uint32_t next(const uint32_t* triangle, uint32_t corner, uint32_t steps) {
  const uint32_t at = triangle[0] == corner ? 0 : triangle[1] == corner ? 1 : 2;
  return triangle[(at + steps) % 3];
}

}  // namespace

MorphPredictor::MorphPredictor(std::span<const uint32_t> indices, std::span<const uint32_t> surface_vertex) {
  const size_t vertices = surface_vertex.size();
  std::vector<uint32_t> offsets(vertices + 1, 0), triangles(indices.size());
  for (uint32_t index : indices) ++offsets[index + 1];
  for (size_t v = 0; v < vertices; ++v) offsets[v + 1] += offsets[v];
  std::vector<uint32_t> free(offsets.begin(), offsets.end() - 1);
  for (size_t i = 0; i < indices.size(); ++i) triangles[free[indices[i]]++] = static_cast<uint32_t>(i / 3);

  // The vertex below `limit` across the edge (a, b), or kNone.
  const auto across = [&](uint32_t a, uint32_t b, uint32_t limit) {
    const uint32_t end = std::min(offsets[a + 1], offsets[a] + kMostTried);
    for (uint32_t i = offsets[a]; i < end; ++i) {
      const uint32_t* t = &indices[3 * size_t{triangles[i]}];
      const uint32_t m = next(t, a, 1), n = next(t, a, 2);
      const uint32_t c = m == b ? n : n == b ? m : kNone;
      if (c < limit) return c;
    }
    return kNone;
  };
  parents_.resize(vertices);
  for (uint32_t v = 0; v < vertices; ++v) {
    Parents& parents = parents_[v];
    parents.fill(surface_vertex[v] < v ? surface_vertex[v] : kNone);
    if (parents[0] != kNone) continue;
    size_t found = 0;
    for (uint32_t i = offsets[v]; i < offsets[v + 1] && found < 6; ++i) {
      const uint32_t* t = &indices[3 * size_t{triangles[i]}];
      const uint32_t a = next(t, v, 1), b = next(t, v, 2);
      if (found == 0 && std::min(a, b) < v) {  // the edge's middle, or its known end, unless better is found
        std::fill_n(parents.begin(), 3, a < v ? a : b);
        std::fill_n(parents.begin() + 3, 3, b < v ? b : a);
      }
      const uint32_t c = a < v && b < v && a != b ? across(a, b, v) : kNone;
      if (c == kNone) continue;
      if (found == 0) parents = {a, b, c, a, b, c};
      std::copy_n(std::array{a, b, c}.begin(), 3, parents.begin() + static_cast<ptrdiff_t>(found));
      found += 3;
    }
  }
}

Status decodeRuns(const format::Stream* runs, size_t vertex_count, std::vector<uint32_t>& vertices) {
  const size_t count = streamCount(runs);
  if (count > vertex_count) return bad("it has more runs than the mesh has vertices");
  std::vector<std::array<uint32_t, 2>> words(count);
  if (Status status = decodeStream(runs, 8, count, words.data()); !status.ok()) return status;
  vertices.clear();
  size_t at = 0;
  for (const auto& [skip, take] : words) {
    if (take == 0 || skip > vertex_count - at || take > vertex_count - at - skip)
      return bad("its vertices are out of range");
    at += skip;
    for (const size_t end = at + take; at < end; ++at) vertices.push_back(static_cast<uint32_t>(at));
  }
  return {};
}

Status decodeDeltas(const format::Stream* stream, uint32_t bits, const MorphPredictor& predictor,
                    std::span<const uint32_t> vertices, std::vector<Int3>& field, std::vector<Int3>& out) {
  const size_t groups = stream ? stream->stride() / 4 : 1;
  if (groups < 1 || groups > bits / 8) return bad("its displacements have the wrong number of bytes");
  std::vector<uint8_t> bytes(vertices.size() * 4 * groups);
  if (Status status = decodeStream(stream, static_cast<uint32_t>(4 * groups), vertices.size(), bytes.data());
      !status.ok())
    return status;
  out.resize(vertices.size());
  const std::vector<uint8_t> zero(4 * groups);
  const uint8_t* before = zero.data();
  for (size_t i = 0; i < vertices.size(); ++i) {
    const uint8_t* sums = &bytes[i * 4 * groups];
    for (size_t c = 0; c < 3; ++c) {
      int32_t difference = 0;
      for (size_t g = groups; g-- > 0;)
        difference = difference * 256 + static_cast<int8_t>(sums[4 * g + c] - before[4 * g + c]);
      out[i][c] = wrapped(predictor.predict(field, vertices[i], c) + difference, bits);
    }
    field[vertices[i]] = out[i];
    before = sums;
  }
  for (uint32_t v : vertices) field[v] = {};
  return {};
}

}  // namespace furrow
