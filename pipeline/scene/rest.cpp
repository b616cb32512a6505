#include "pipeline/scene/rest.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <iterator>
#include <map>
#include <set>

#include "pipeline/error.h"
#include "pipeline/scene/posing.h"

namespace furrow::pipeline {
namespace {

double uniformScale(const glm::dmat4& m) {
  return std::cbrt(std::abs(glm::determinant(glm::dmat3(m))));
}

size_t depth(const Rig& rig, uint32_t node) {
  size_t steps = 0;
  for (; rig.nodes[node].parent != kNoIndex; node = rig.nodes[node].parent) ++steps;
  return steps;
}

glm::dmat4 bindMatrix(const SourceScene& scene, const Part& part, const std::vector<glm::dmat4>& palette) {
  if (!part.skinned || part.palette_count == 0) return palette[part.palette_begin];
  uint32_t top = part.palette_begin;
  std::vector<double> scales;
  for (uint32_t i = part.palette_begin; i < part.palette_begin + part.palette_count; ++i) {
    scales.push_back(uniformScale(palette[i]));
    if (depth(scene.rig, scene.rig.palette[i].node) < depth(scene.rig, scene.rig.palette[top].node)) top = i;
  }
  std::nth_element(scales.begin(), scales.begin() + scales.size() / 2, scales.end());
  const double median = scales[scales.size() / 2];
  const double own = uniformScale(palette[top]);
  glm::dmat4 bind = palette[top];
  if (!(own > 0.0) || !(median > 0.0)) return glm::dmat4(1.0);
  if (std::abs(median / own - 1.0) > 1e-4)
    for (int c = 0; c < 3; ++c) bind[c] *= median / own;
  return bind;
}

// Of all vertices in source order.
std::vector<uint32_t> fileVertices(const SourceScene& scene) {
  std::vector<uint32_t> out;
  for (const Part& part : scene.parts) {
    const Primitive& primitive = scene.primitives[part.primitive];
    for (size_t v = 0; v < primitive.positions.size(); ++v)
      out.push_back(primitive.file_vertices.empty() ? static_cast<uint32_t>(out.size())
                                                    : primitive.file_vertices[v]);
  }
  return out;
}

// Pairs of file vertices, ascending, each once.
std::vector<std::pair<uint32_t, uint32_t>> edgesOf(const SourceScene& scene,
                                                   const std::vector<uint32_t>& file_vertices) {
  std::vector<std::pair<uint32_t, uint32_t>> edges;
  uint32_t first_vertex = 0;
  for (const Part& part : scene.parts) {
    const Primitive& primitive = scene.primitives[part.primitive];
    for (size_t i = 0; i < primitive.indices.size(); ++i) {
      const size_t next = i % 3 == 2 ? i - 2 : i + 1;
      edges.push_back(std::minmax(file_vertices[first_vertex + primitive.indices[i]],
                                  file_vertices[first_vertex + primitive.indices[next]]));
    }
    first_vertex += static_cast<uint32_t>(primitive.positions.size());
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

}  // namespace

std::vector<glm::dmat4> bindMatrices(const SourceScene& scene) {
  const std::vector<glm::dmat4> palette = evaluate(scene.rig, defaultPose(scene.rig)).palette;
  std::vector<glm::dmat4> out;
  for (const Part& part : scene.parts) out.push_back(bindMatrix(scene, part, palette));
  return out;
}

std::vector<glm::dvec3> restPositions(const SourceScene& scene, const Rest& rest) {
  std::vector<glm::dvec3> out;
  if (const auto* at = std::get_if<RestClip>(&rest)) {
    const Clip* clip = findClip(scene.rig, at->clip);
    if (!clip) {
      std::vector<std::string> names;
      for (const Clip& each : scene.rig.clips) names.push_back(each.name);
      throw Error(Exit::kBadData, scene.file.string(), "it has no clip \"" + at->clip + "\"",
                  "it has: " + joinNames(names));
    }
    Pose pose = defaultPose(scene.rig);
    applyClip(scene.rig, *clip, at->time, pose);
    const PosedRig posed = evaluate(scene.rig, pose);
    for (const Part& part : scene.parts) {
      const std::vector<glm::dvec3> positions = posePart(scene, part, posed);
      out.insert(out.end(), positions.begin(), positions.end());
    }
    return out;
  }
  const auto* morphs = std::get_if<RestMorphs>(&rest);
  for (const auto& [name, weight] : morphs ? morphs->weights : std::map<std::string, double>{}) {
    const auto has_name = [&name = name](const MorphTarget& target) { return target.name == name; };
    if (std::ranges::any_of(scene.rig.morphs, has_name)) continue;
    std::set<std::string> names;
    for (const MorphTarget& target : scene.rig.morphs) names.insert(target.name);
    throw Error(Exit::kBadData, scene.file.string(), "it has no morph target \"" + name + "\"",
                "it has: " + joinNames({names.begin(), names.end()}, 80));
  }
  const std::vector<glm::dmat4> bind = bindMatrices(scene);
  for (size_t i = 0; i < scene.parts.size(); ++i) {
    const Part& part = scene.parts[i];
    const Primitive& primitive = scene.primitives[part.primitive];
    const size_t first = out.size();
    out.insert(out.end(), primitive.positions.begin(), primitive.positions.end());
    for (size_t m = 0; morphs && m < primitive.morphs.size(); ++m) {
      const auto weight = morphs->weights.find(scene.rig.morphs[part.first_morph + m].name);
      if (weight == morphs->weights.end()) continue;
      const MorphDelta& delta = primitive.morphs[m];
      for (size_t k = 0; k < delta.vertices.size(); ++k)
        out[first + delta.vertices[k]] += weight->second * glm::dvec3(delta.positions[k]);
    }
    for (size_t v = first; v < out.size(); ++v) out[v] = glm::dvec3(bind[i] * glm::dvec4(out[v], 1.0));
  }
  return out;
}

std::vector<glm::dvec3> restOffsets(const SourceScene& scene, const SourceScene& file) {
  const auto refuse = [&](const std::string& what, const char* remedy) -> Error {
    return Error(Exit::kBadData, file.file.string(), what, remedy);
  };
  const std::vector<uint32_t> wanted = fileVertices(scene), given = fileVertices(file);
  const size_t count = *std::max_element(wanted.begin(), wanted.end()) + size_t{1};
  const size_t given_count = *std::max_element(given.begin(), given.end()) + size_t{1};
  const std::string source = scene.file.filename().string();
  const char* const same = "export it with the vertices of the source, in their order";
  if (given_count != count)
    throw refuse(
        "it has " + std::to_string(given_count) + " vertices and " + source + " has " + std::to_string(count),
        same);

  constexpr double kNowhere = INFINITY;
  std::vector<glm::dvec3> place(count, glm::dvec3(kNowhere)), bind_place(count);
  const std::vector<glm::dvec3> given_positions = restPositions(file, RestBind{}),
                                bind = restPositions(scene, RestBind{});
  for (size_t v = 0; v < given.size(); ++v) place[given[v]] = given_positions[v];
  std::vector<glm::dvec3> offsets;
  for (size_t v = 0; v < wanted.size(); ++v) {
    if (place[wanted[v]].x == kNowhere)
      throw refuse("no face has vertex " + std::to_string(wanted[v] + 1) + " of " + source, same);
    bind_place[wanted[v]] = bind[v];
    offsets.push_back(place[wanted[v]] - bind[v]);
  }

  // Polygons may have been cut into triangles in another way: then their sides are still the same.
  const auto edges = edgesOf(scene, wanted), given_edges = edgesOf(file, given);
  std::vector<std::pair<uint32_t, uint32_t>> shared;
  std::set_intersection(edges.begin(), edges.end(), given_edges.begin(), given_edges.end(),
                        std::back_inserter(shared));
  if (2 * shared.size() < edges.size())
    throw refuse("its faces join other vertices than those of " + source, same);
  double length = 0.0, given_length = 0.0;
  for (const auto& [a, b] : shared) {
    length += glm::distance(bind_place[a], bind_place[b]);
    given_length += glm::distance(place[a], place[b]);
  }
  constexpr double kOtherUnit = 3.0;
  if (!(given_length < kOtherUnit * length && length < kOtherUnit * given_length))
    throw refuse(
        "its edges are " + std::to_string(given_length / length) + " times as long as those of " + source,
        "export it in the unit of the source");
  return offsets;
}

void requireInRange(const SourceScene& scene, std::span<const glm::vec3> positions) {
  constexpr float kFarthest = 1e18f, kSmallest = 1e-18f;
  glm::vec3 low(kFarthest), high(-kFarthest);
  for (const glm::vec3& p : positions) {
    if (!(std::abs(p.x) < kFarthest && std::abs(p.y) < kFarthest && std::abs(p.z) < kFarthest))  // nor NaN
      throw Error(Exit::kBadData, scene.file.string(), "a vertex lies more than 1e18 units out, or nowhere",
                  "look at its positions, the transforms of its nodes and its inverse bind matrices");
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const float extent = std::max({high.x - low.x, high.y - low.y, high.z - low.z});
  if (extent > 0.0f && extent < kSmallest)
    throw Error(Exit::kBadData, scene.file.string(), "it is smaller than 1e-18 units",
                "look at its positions and the scales of its nodes");
}

const Clip* findClip(const Rig& rig, const std::string& name) {
  for (const Clip& clip : rig.clips)
    if (clip.name == name) return &clip;
  size_t number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  return error == std::errc() && end == name.data() + name.size() && number < rig.clips.size()
             ? &rig.clips[number]
             : nullptr;
}

std::string joinNames(const std::vector<std::string>& names, size_t most) {
  if (names.empty()) return "none";
  std::string text;
  for (size_t i = 0; i < std::min(names.size(), most); ++i)
    text += (i ? ", " : "") + (names[i].empty() ? "(no name)" : names[i]);
  if (names.size() > most) text += " and " + std::to_string(names.size() - most) + " more";
  return text;
}

}  // namespace furrow::pipeline
