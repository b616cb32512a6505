#pragma once

// A scene as read from a file, whatever its format: geometry in source order, rig, materials. Plain data; the
// importers guarantee that every index is in range, that every number is finite, and that every array of a
// primitive has one entry a vertex or is empty.

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/mat3x2.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <string>
#include <vector>

#include "furrow/asset.h"
#include "pipeline/scene/rig.h"

namespace furrow::pipeline {

// COLOR_n (linear, [0, 1] as the file has it) or a custom attribute _NAME.
struct Attribute {
  std::string name;
  uint32_t components = 1;    // 1 to 4
  std::vector<float> values;  // components a vertex
};

// Displacements of one morph target, only the vertices that move, ascending.
struct MorphDelta {
  std::vector<uint32_t> vertices;
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;  // empty if the target has none
};

// A triangle list. Strips and fans have been turned into lists; points are left out.
struct Primitive {
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;
  std::vector<glm::vec4> tangents;
  std::vector<glm::vec2> uvs;  // TEXCOORD_0; v grows downwards, from the top of an image
  std::vector<Attribute> attributes;
  uint32_t influences = 0;       // joints a vertex: 0 without skin, else a multiple of 4
  std::vector<uint16_t> joints;  // influences a vertex, index into the skin's joints
  std::vector<float> weights;    // influences a vertex, >= 0, adding up to 1
  std::vector<uint32_t> indices;
  std::vector<MorphDelta> morphs;       // one a target of the mesh
  std::vector<uint32_t> file_vertices;  // number of every vertex in the file's own list, which seams split
                                        // and materials divide; empty: source order
};

// A primitive as one node shows it.
struct Part {
  std::string mesh;  // name of the mesh, or of its node, else "mesh" and its number
  uint32_t primitive = 0;
  uint32_t material = kNoIndex;
  uint32_t node = 0;
  bool skinned = false;
  uint32_t palette_begin = 0;  // skinned: joint j is palette[palette_begin + j]; else the node's entry
  uint32_t palette_count = 1;
  uint32_t first_morph = 0;  // the primitive's morph i is rig.morphs[first_morph + i]
};

// Lines as one node shows them: no surface, but guide curves for directions.
struct Lines {
  std::string mesh;
  uint32_t node = 0;
  std::vector<glm::vec3> points;  // two a line, in the node's space
};

// An image file of the scene's, not decoded: embedded, or a file beside it that may be missing.
struct SourceImage {
  std::string name;  // for messages
  std::filesystem::path file;
  std::vector<uint8_t> bytes;  // where `file` is empty
};

// An image as a material uses it.
struct MaterialMap {
  uint32_t image = kNoIndex;  // none
  // From TEXCOORD_0 to the image, its origin in the upper left corner.
  glm::mat3x2 uv{1.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f};
  std::array<Wrap, 2> wrap{};  // across and down the image

  bool operator==(const MaterialMap&) const = default;
};

struct MaterialMaps {
  MaterialMap color;            // sRGB-encoded, times Material::base_color
  uint32_t opacity = kNoIndex;  // an image of its own, which lies as `color` does: its alpha if it has one,
                                // else its first channel
  float opaque_from = 0.0f;  // opacity below which nothing is seen
  MaterialMap normal;        // in tangent space, green up
  float normal_scale = 1.0f;

  bool operator==(const MaterialMaps&) const = default;
};

struct Material {
  std::string name;
  glm::vec4 base_color{1.0f};  // linear; opacity last
  float roughness = 0.5f;      // [0, 1]
  MaterialMaps maps;
};

struct SourceScene {
  std::filesystem::path file;
  std::vector<Primitive> primitives;
  std::vector<Part> parts;  // by mesh in file order, then primitive, then node: this is source vertex order
  std::vector<Lines> lines;
  std::vector<Material> materials;
  std::vector<SourceImage> images;  // that the materials use
  Rig rig;
  bool sequence = false;                            // the morph targets are the frames of the one clip
  uint32_t polygons = 0;                            // faces of more than three corners, cut into triangles
  std::vector<std::string> warnings;                // one line each, without the file's name
  std::vector<std::filesystem::path> dependencies;  // every file read, `file` first
};

}  // namespace furrow::pipeline
