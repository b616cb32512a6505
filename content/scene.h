#pragma once

// A small scene as the demo content builds it, and its way into a .glb file. Units: metres, +Y up,
// right-handed.

#include <cstdint>
#include <filesystem>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <string>
#include <utility>
#include <vector>

#include "content/image.h"

namespace furrow::content {

struct Material {
  std::string name;
  glm::vec3 base_color{1.0f};  // linear
  float roughness = 0.6f;
  bool double_sided = false;
  int color_image = -1, normal_image = -1;  // sRGB; green up; -1: none
};

// Displacements of one morph target, one a vertex. Vertices that stay are not written.
struct Morph {
  std::vector<glm::vec3> positions, normals;
};

// A triangle list; every array has one entry a vertex or is empty.
struct Primitive {
  uint32_t material = 0;
  std::vector<glm::vec3> positions, normals;
  std::vector<glm::vec2> uvs;
  std::vector<glm::vec4> colors;                                                // COLOR_0, linear
  std::vector<std::pair<std::string, std::vector<glm::vec3>>> vec3_attributes;  // name with its underscore
  std::vector<std::pair<std::string, std::vector<glm::vec4>>> vec4_attributes;
  std::vector<glm::u8vec4> joints;
  std::vector<glm::vec4> weights;
  std::vector<uint32_t> indices;
  std::vector<Morph> morphs;  // one a name of Mesh::morphs
};

struct Mesh {
  std::string name;
  std::vector<std::string> morphs;
  std::vector<Primitive> primitives;
  std::vector<std::vector<glm::vec3>> lines;  // line strips
};

struct Node {
  std::string name;
  int parent = -1;  // an earlier node, or -1
  glm::vec3 translation{0.0f};
  int mesh = -1;
  bool skinned = false;  // by Scene::joints
};

struct WeightKeys {
  uint32_t node = 0;
  std::vector<std::vector<float>> weights;  // a key, then a morph
};
struct RotationKeys {
  uint32_t node = 0;
  std::vector<glm::quat> rotations;  // a key
};
struct Clip {
  std::string name;
  std::vector<float> times;  // seconds, ascending
  std::vector<WeightKeys> weights;
  std::vector<RotationKeys> rotations;
};

struct Scene {
  std::vector<Image> images;
  std::vector<Material> materials;
  std::vector<Mesh> meshes;
  std::vector<Node> nodes;
  std::vector<uint32_t> joints;  // nodes of the one skin; bound where the nodes stand
  std::vector<Clip> clips;
};

// Writes a binary glTF 2.0 file; morph targets become sparse accessors. Throws std::runtime_error if the file
// cannot be written.
void writeGlb(const Scene& scene, const std::filesystem::path& file);

}  // namespace furrow::content
