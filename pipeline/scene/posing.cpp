#include "pipeline/scene/posing.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>
#include <span>

namespace furrow::pipeline {
namespace {

glm::dmat4 localMatrix(const Node& node) {
  if (node.has_matrix) return node.matrix;
  glm::dmat4 m = glm::mat4_cast(node.rotation);
  m[0] *= node.scale.x;
  m[1] *= node.scale.y;
  m[2] *= node.scale.z;
  m[3] = glm::dvec4(node.translation, 1.0);
  return m;
}

// Where a channel stands at a time: between keys `lower` and `lower + 1`, `u` of the way, `gap` seconds
// apart; u = 0 on a key and outside.
struct Place {
  size_t lower = 0;
  double u = 0.0;
  double gap = 0.0;
};

Place locate(const std::vector<float>& times, double time) {
  const auto next = std::upper_bound(times.begin(), times.end(), time,
                                     [](double t, float key) { return t < static_cast<double>(key); });
  if (next == times.begin()) return {};
  Place place{static_cast<size_t>(next - times.begin()) - 1};
  if (next == times.end()) return place;
  const double begin = times[place.lower];
  place.gap = static_cast<double>(*next) - begin;
  place.u = (time - begin) / place.gap;
  return place;
}

class Sampler {
 public:
  Sampler(const Channel& channel, double time) : channel_(channel), place_(locate(channel.times, time)) {
    const bool cubic = channel.interpolation == Interpolation::kCubicSpline;
    components_ = channel.values.size() / channel.times.size() / (cubic ? 3 : 1);
  }

  size_t components() const { return components_; }

  double component(size_t c) const {
    if (channel_.interpolation == Interpolation::kStep || place_.u == 0.0) return value(place_.lower, c);
    const double a = value(place_.lower, c);
    const double b = value(place_.lower + 1, c);
    const double u = place_.u;
    if (channel_.interpolation == Interpolation::kLinear) return a + u * (b - a);
    const double u2 = u * u;
    const double u3 = u2 * u;
    const double out_tangent = row(place_.lower, 2, c);
    const double in_tangent = row(place_.lower + 1, 0, c);
    return (2 * u3 - 3 * u2 + 1) * a + place_.gap * (u3 - 2 * u2 + u) * out_tangent + (3 * u2 - 2 * u3) * b +
           place_.gap * (u3 - u2) * in_tangent;
  }

  glm::dvec3 vector() const { return {component(0), component(1), component(2)}; }

  glm::dquat rotation() const {
    if (channel_.interpolation == Interpolation::kLinear && place_.u != 0.0)
      return unit(glm::slerp(key(place_.lower), key(place_.lower + 1), place_.u));
    return unit({component(3), component(0), component(1), component(2)});
  }

 private:
  static glm::dquat unit(const glm::dquat& q) {
    const double length = glm::length(q);
    return length > 0.0 ? q / length : glm::dquat(1.0, 0.0, 0.0, 0.0);
  }

  double row(size_t key, size_t part, size_t c) const {
    return channel_.values[(3 * key + part) * components_ + c];
  }
  double value(size_t key, size_t c) const {
    return channel_.interpolation == Interpolation::kCubicSpline ? row(key, 1, c)
                                                                 : channel_.values[key * components_ + c];
  }
  glm::dquat key(size_t k) const { return unit({value(k, 3), value(k, 0), value(k, 1), value(k, 2)}); }

  const Channel& channel_;
  Place place_;
  size_t components_ = 0;
};

}  // namespace

std::vector<glm::dmat4> worldMatrices(const std::vector<Node>& nodes) {
  std::vector<glm::dmat4> world(nodes.size());
  std::vector<bool> done(nodes.size(), false);
  std::vector<uint32_t> chain;
  for (uint32_t i = 0; i < nodes.size(); ++i) {
    for (uint32_t n = i; n != kNoIndex && !done[n]; n = nodes[n].parent) chain.push_back(n);
    while (!chain.empty()) {
      const uint32_t n = chain.back();
      chain.pop_back();
      const glm::dmat4 local = localMatrix(nodes[n]);
      world[n] = nodes[n].parent == kNoIndex ? local : world[nodes[n].parent] * local;
      done[n] = true;
    }
  }
  return world;
}

Pose defaultPose(const Rig& rig) {
  Pose pose{rig.nodes, {}};
  pose.morph_weights.reserve(rig.morphs.size());
  for (const MorphTarget& morph : rig.morphs) pose.morph_weights.push_back(morph.default_weight);
  return pose;
}

void applyClip(const Rig& rig, const Clip& clip, double time, Pose& pose) {
  for (const Channel& channel : clip.channels) {
    const Sampler sampler(channel, time);
    Node& node = pose.nodes[channel.node];
    switch (channel.path) {
      case ChannelPath::kTranslation:
        node.translation = sampler.vector();
        break;
      case ChannelPath::kRotation:
        node.rotation = sampler.rotation();
        break;
      case ChannelPath::kScale:
        node.scale = sampler.vector();
        break;
      case ChannelPath::kWeights:
        for (size_t m = 0; m < rig.morphs.size(); ++m) {
          const MorphTarget& morph = rig.morphs[m];
          if (morph.node == channel.node && morph.index < sampler.components())
            pose.morph_weights[m] = sampler.component(morph.index);
        }
        break;
    }
  }
}

PosedRig evaluate(const Rig& rig, const Pose& pose) {
  const std::vector<glm::dmat4> world = worldMatrices(pose.nodes);
  PosedRig posed{{}, pose.morph_weights};
  posed.palette.reserve(rig.palette.size());
  for (const PaletteEntry& entry : rig.palette)
    posed.palette.push_back(world[entry.node] * entry.inverse_bind);
  return posed;
}

double wholeScale(const Rig& rig, const PosedRig& pose) {
  constexpr double kSame = 1e-4;  // of scales that are written as floats and multiplied along the chain
  const PosedRig still = evaluate(rig, defaultPose(rig));
  double whole = 1.0;  // its square
  for (size_t e = 0; e < still.palette.size(); ++e) {
    const glm::dmat3 linear = glm::dmat3(pose.palette[e]) * glm::inverse(glm::dmat3(still.palette[e]));
    const glm::dmat3 metric = glm::transpose(linear) * linear;
    const double scale = (metric[0][0] + metric[1][1] + metric[2][2]) / 3.0;
    if (e == 0) whole = scale;
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r)
        if (!(std::abs(metric[c][r] - (c == r ? whole : 0.0)) <= kSame * whole)) return 1.0;
  }
  return std::abs(whole - 1.0) > kSame && std::isnormal(whole) ? std::sqrt(whole) : 1.0;
}

std::vector<glm::dvec3> posePart(const SourceScene& scene, const Part& part, const PosedRig& pose) {
  const Primitive& primitive = scene.primitives[part.primitive];
  std::vector<glm::dvec3> points(primitive.positions.begin(), primitive.positions.end());

  for (size_t m = 0; m < primitive.morphs.size(); ++m) {
    const double weight = pose.morph_weights[part.first_morph + m];
    if (weight == 0.0) continue;
    const MorphDelta& delta = primitive.morphs[m];
    for (size_t i = 0; i < delta.vertices.size(); ++i)
      points[delta.vertices[i]] += weight * glm::dvec3(delta.positions[i]);
  }

  const std::span<const glm::dmat4> palette(pose.palette.data() + part.palette_begin, part.palette_count);
  if (!part.skinned) {
    for (glm::dvec3& p : points) p = glm::dvec3(palette[0] * glm::dvec4(p, 1.0));
    return points;
  }
  const size_t influences = primitive.influences;
  for (size_t v = 0; v < points.size(); ++v) {
    glm::dvec3 sum(0.0);
    for (size_t i = v * influences; i < (v + 1) * influences; ++i)
      if (primitive.weights[i] != 0.0f)
        sum += static_cast<double>(primitive.weights[i]) *
               glm::dvec3(palette[primitive.joints[i]] * glm::dvec4(points[v], 1.0));
    points[v] = sum;
  }
  return points;
}

}  // namespace furrow::pipeline
