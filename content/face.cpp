#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <map>

#include "content/face_parts.h"
#include "content/head.h"
#include "content/models.h"
#include "content/performance.h"
#include "content/skin_maps.h"

// Puts the parts of the face together; centimetres become metres.

namespace furrow::content {
namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double kPi = glm::pi<double>();

// By FaceMaterial.
std::vector<Material> materials() {
  return {{"skin", glm::vec3(1), 0.56f},
          {"ears", glm::vec3(1), 0.55f},
          {"lids", {1.0f, 0.86f, 0.84f}, 0.35f, true},
          {"mouth", {0.30f, 0.10f, 0.09f}, 0.8f, true},
          {"teeth", {1.0f, 0.97f, 0.93f}, 0.35f},
          {"hair", glm::vec3(1), 0.74f, true},
          {"brows", glm::vec3(1), 0.85f, true},
          {"shirt", glm::vec3(1), 0.9f, true},
          {"eye", glm::vec3(1), 0.12f}};
}

void addPainting(Primitive& primitive) {
  std::vector<glm::vec4> mask_a, mask_b;
  std::vector<glm::vec3> eye, nose, mouth, bias;
  for (const glm::vec3& position : primitive.positions) {
    const Painting painting = paintingAt(dvec3(position) * 100.0);
    mask_a.push_back(painting.mask_a);
    mask_b.push_back(painting.mask_b);
    eye.push_back(painting.eye);
    nose.push_back(painting.nose);
    mouth.push_back(painting.mouth);
    bias.emplace_back(painting.bias);
  }
  primitive.vec4_attributes = {{"_MASK_A", std::move(mask_a)}, {"_MASK_B", std::move(mask_b)}};
  primitive.vec3_attributes = {{"_DIR_EYE", std::move(eye)},
                               {"_DIR_NOSE", std::move(nose)},
                               {"_DIR_MOUTH", std::move(mouth)},
                               {"_BIAS", std::move(bias)}};
}

// A part as primitives, one a material, with the first `expressions`.
std::vector<Primitive> primitives(const FacePart& part, size_t expressions) {
  const std::vector<dvec3> normals = pointNormals(part.mesh, part.mesh.points);
  std::vector<Morph> morphs(expressions);
  std::vector<dvec3> posed(part.mesh.points.size());
  for (size_t e = 0; e < expressions; ++e) {
    Morph& morph = morphs[e];
    morph.positions.resize(posed.size());
    morph.normals.resize(posed.size());
    bool still = true;
    for (size_t p = 0; p < posed.size(); ++p) {
      dvec3 moved = displacement(e, part.points[p]);
      if (glm::length(moved) < 2e-4) moved = dvec3(0);
      still &= moved == dvec3(0);
      posed[p] = part.mesh.points[p] + moved;
      morph.positions[p] = glm::vec3(moved * 0.01);
    }
    if (still) continue;
    const std::vector<dvec3> posed_normals = pointNormals(part.mesh, posed);
    for (size_t p = 0; p < posed.size(); ++p) {
      const dvec3 turned = posed_normals[p] - normals[p];
      morph.normals[p] = glm::length(turned) < 1e-4 ? glm::vec3(0) : glm::vec3(turned);
    }
  }

  std::map<uint32_t, Primitive> by_material;
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> index_of;  // material, vertex
  for (size_t t = 0; t < part.mesh.triangles.size(); ++t) {
    const uint32_t material = part.materials[t];
    Primitive& out = by_material[material];
    if (out.indices.empty()) {
      out.material = material;
      out.morphs.resize(expressions);
    }
    for (uint32_t vertex : part.mesh.triangles[t].vertices) {
      const auto [slot, fresh] =
          index_of.try_emplace({material, vertex}, static_cast<uint32_t>(out.positions.size()));
      out.indices.push_back(slot->second);
      if (!fresh) continue;
      const uint32_t point = part.mesh.vertices[vertex].point;
      out.positions.emplace_back(part.mesh.points[point] * 0.01);
      out.normals.emplace_back(normals[point]);
      out.uvs.emplace_back(part.mesh.vertices[vertex].uv.x, 1 - part.mesh.vertices[vertex].uv.y);
      if (!part.colors.empty()) {
        // Lids and mouth go on in the colour that the skin has of its map.
        const bool plain = material == kLid || material == kMouth;
        const dvec3 color = part.colors[point] * (plain ? skinColor(part.mesh.points[point]) : dvec3(1));
        out.colors.emplace_back(glm::vec3(glm::min(color, 1.0)), 1.0f);
      }
      for (size_t e = 0; e < expressions; ++e) {
        out.morphs[e].positions.push_back(morphs[e].positions[point]);
        out.morphs[e].normals.push_back(morphs[e].normals[point]);
      }
    }
  }
  std::vector<Primitive> result;
  for (auto& [material, primitive] : by_material) {
    if (material == kSkin) addPainting(primitive);
    result.push_back(std::move(primitive));
  }
  return result;
}

// Guide curves along the creases of the forehead: dipping between the brows, arching over them, falling off
// to the temples.
Mesh foreheadLines() {
  Mesh mesh;
  mesh.name = "ForeheadLines";
  for (const double height : {2.9, 3.9, 4.9, 5.9}) {
    std::vector<glm::vec3>& line = mesh.lines.emplace_back();
    for (int i = -28; i <= 28; ++i) {
      const double x = 0.2 * i;
      const double arch = 0.5 * std::pow(std::sin(kPi * x / 6.4), 2) - 0.02 * x * x;
      line.emplace_back(0.01 * head::trace({x, height + arch, 8}, {0, 0, -1}));
    }
  }
  return mesh;
}

}  // namespace

Scene buildFace() {
  Scene scene;
  scene.materials = materials();
  Mesh face;
  face.name = "Face";
  for (std::string_view name : expressionNames()) face.morphs.emplace_back(name);
  const FacePart skin = faceSkin();
  SkinMaps maps = skinMaps(skin);
  scene.images = {std::move(maps.color), std::move(maps.normal), eyeColors()};
  scene.materials[kSkin].color_image = 0;
  scene.materials[kSkin].normal_image = 1;
  scene.materials[kEye].color_image = 2;
  for (const FacePart& part : {skin, ears(), teeth(), brows(), lashes()})
    for (Primitive& primitive : primitives(part, expressionNames().size()))
      face.primitives.push_back(std::move(primitive));
  Mesh still;
  still.name = "HairAndShirt";
  for (const FacePart& part : {hair(), shirt()})
    for (Primitive& primitive : primitives(part, 0)) still.primitives.push_back(std::move(primitive));
  scene.meshes = {std::move(face), eyeball(), foreheadLines(), std::move(still)};
  scene.nodes = {{"Head", -1, {}},
                 {"Face", 0, {}, 0},
                 {"EyeLeft", 0, glm::vec3(head::kEye * 0.01), 1},
                 {"EyeRight", 0, glm::vec3(head::kEye * dvec3(-0.01, 0.01, 0.01)), 1},
                 {"ForeheadLines", 0, {}, 2},
                 {"HairAndShirt", 0, {}, 3}};
  scene.clips = {performance(1)};
  return scene;
}

}  // namespace furrow::content
