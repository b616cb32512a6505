#include "pipeline/scene/rest.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <glm/matrix.hpp>

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

}  // namespace

glm::dmat4 bindMatrix(const SourceScene& scene, const Part& part) {
  const std::vector<glm::dmat4> palette = evaluate(scene.rig, defaultPose(scene.rig)).palette;
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

std::vector<glm::dvec3> restPositions(const SourceScene& scene, const Part& part, const Rest& rest) {
  const Primitive& primitive = scene.primitives[part.primitive];
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
    return posePart(scene, part, evaluate(scene.rig, pose));
  }
  std::vector<glm::dvec3> positions(primitive.positions.begin(), primitive.positions.end());
  if (const auto* morphs = std::get_if<RestMorphs>(&rest)) {
    for (const auto& [name, weight] : morphs->weights) {
      const auto has_name = [&name = name](const MorphTarget& target) { return target.name == name; };
      if (std::none_of(scene.rig.morphs.begin(), scene.rig.morphs.end(), has_name))
        throw Error(Exit::kBadData, scene.file.string(), "it has no morph target \"" + name + "\"",
                    "correct \"rest\" in the recipe");
      for (size_t m = 0; m < primitive.morphs.size(); ++m) {
        if (scene.rig.morphs[part.first_morph + m].name != name) continue;
        const MorphDelta& delta = primitive.morphs[m];
        for (size_t i = 0; i < delta.vertices.size(); ++i)
          positions[delta.vertices[i]] += weight * glm::dvec3(delta.positions[i]);
      }
    }
  }
  const glm::dmat4 bind = bindMatrix(scene, part);
  for (glm::dvec3& p : positions) p = glm::dvec3(bind * glm::dvec4(p, 1.0));
  return positions;
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
  for (size_t i = 0; i < std::min(names.size(), most); ++i) text += (i ? ", " : "") + names[i];
  if (names.size() > most) text += " and " + std::to_string(names.size() - most) + " more";
  return text;
}

}  // namespace furrow::pipeline
