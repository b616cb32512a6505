#pragma once

// What moves a surface: nodes, skins, morph targets and clips, and the pose they come to. Made by the
// importers, stored in the asset for the tools, and posed by posing.h.

#include <cstdint>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace furrow::pipeline {

inline constexpr uint32_t kNoIndex = 0xffffffffu;

// A node's local transform: translation, rotation, scale, or a matrix that no clip may animate.
struct Node {
  std::string name;
  uint32_t parent = kNoIndex;
  bool has_matrix = false;
  glm::dmat4 matrix{1.0};
  glm::dvec3 translation{0.0};
  glm::dquat rotation{1.0, 0.0, 0.0, 0.0};
  glm::dvec3 scale{1.0};
};

// palette[i] = world(node) * inverse_bind. An entry for every (node, inverse bind matrix) that a skin uses,
// and one (identity) for every node whose mesh has no skin.
struct PaletteEntry {
  uint32_t node = 0;
  glm::dmat4 inverse_bind{1.0};
};

// One morph target of one mesh node. Targets of several nodes may share a name.
struct MorphTarget {
  std::string name;
  uint32_t node = 0;
  uint32_t index = 0;  // among the targets of the node's mesh
  double default_weight = 0.0;
};

enum class Interpolation : uint8_t { kStep, kLinear, kCubicSpline };
enum class ChannelPath : uint8_t { kTranslation, kRotation, kScale, kWeights };

struct Channel {
  uint32_t node = 0;
  ChannelPath path = ChannelPath::kTranslation;
  Interpolation interpolation = Interpolation::kLinear;
  std::vector<float> times;   // seconds, strictly increasing, at least one
  std::vector<float> values;  // components a key (3, 4 as x y z w, or the node's morph targets); three times
                              // as many for kCubicSpline: in-tangent, value, out-tangent
};

struct Clip {
  std::string name;
  double duration = 0.0;  // seconds, the last key's time
  std::vector<Channel> channels;
};

struct Rig {
  std::vector<Node> nodes;  // in file order; parents may come after their children, but never form a cycle
  std::vector<PaletteEntry> palette;
  std::vector<MorphTarget> morphs;
  std::vector<Clip> clips;
};

// Local transforms of every node and weights of every morph target.
struct Pose {
  std::vector<Node> nodes;
  std::vector<double> morph_weights;
};

// A pose as the surface sees it: root-space palette matrices and morph weights.
struct PosedRig {
  std::vector<glm::dmat4> palette;
  std::vector<double> morph_weights;
};

}  // namespace furrow::pipeline
