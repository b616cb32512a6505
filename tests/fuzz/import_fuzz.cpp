#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "pipeline/cook/cook.h"
#include "pipeline/error.h"
#include "pipeline/import/formats.h"
#include "pipeline/import/import.h"
#include "pipeline/import/obj_materials.h"

namespace {

using namespace furrow::pipeline;

constexpr size_t kMostVertices = 400, kMostMorphs = 8, kMostNodes = 64;  // of a scene that is cooked, too

void require(bool sound) {
  if (!sound) std::abort();
}

template <typename T>
bool finite(const std::vector<T>& vectors) {
  const float* values = reinterpret_cast<const float*>(vectors.data());
  for (size_t i = 0; i < vectors.size() * sizeof(T) / sizeof(float); ++i)
    if (!std::isfinite(values[i])) return false;
  return true;
}

// What source_scene.h promises.
void checkPrimitive(const Primitive& primitive) {
  const size_t vertices = primitive.positions.size();
  const auto each = [vertices](size_t entries) { return entries == 0 || entries == vertices; };
  require(primitive.indices.size() % 3 == 0 && !primitive.indices.empty());
  for (const uint32_t index : primitive.indices) require(index < vertices);
  require(each(primitive.normals.size()) && each(primitive.tangents.size()) && each(primitive.uvs.size()) &&
          each(primitive.file_vertices.size()));
  require(finite(primitive.positions) && finite(primitive.normals) && finite(primitive.tangents) &&
          finite(primitive.uvs));
  for (const Attribute& attribute : primitive.attributes)
    require(attribute.components >= 1 && attribute.components <= 4 && finite(attribute.values) &&
            attribute.values.size() == vertices * attribute.components);
  require(primitive.influences % 4 == 0 && primitive.joints.size() == vertices * primitive.influences &&
          primitive.weights.size() == primitive.joints.size());
  for (const MorphDelta& delta : primitive.morphs) {
    require(delta.positions.size() == delta.vertices.size() && finite(delta.positions));
    require(delta.normals.empty() || delta.normals.size() == delta.vertices.size());
    for (const uint32_t v : delta.vertices) require(v < vertices);
  }
}

// The bytes as the material file of an OBJ model: never refused.
void checkMaterials(std::string_view text) {
  ObjMaterials found;
  addMaterials(text, "fuzz.mtl", "fuzz.obj", found);
  const auto share = [](float value) { return value >= 0.0f && value <= 1.0f; };
  for (const auto& [name, material] : found.materials) {
    const MaterialMaps& maps = material.maps;
    for (const uint32_t image : {maps.color.image, maps.opacity, maps.normal.image})
      require(image == kNoIndex || image < found.images.size());
    for (const MaterialMap& map : {maps.color, maps.normal})
      for (int c = 0; c < 3; ++c) require(std::isfinite(map.uv[c].x) && std::isfinite(map.uv[c].y));
    for (int c = 0; c < 4; ++c) require(share(material.base_color[c]));
    require(share(material.roughness) && share(maps.opaque_from) && std::isfinite(maps.normal_scale));
  }
}

bool small(const SourceScene& scene) {
  size_t vertices = 0;
  for (const Part& part : scene.parts) vertices += scene.primitives[part.primitive].positions.size();
  return vertices <= kMostVertices && scene.rig.morphs.size() <= kMostMorphs &&
         scene.rig.nodes.size() <= kMostNodes;
}

}  // namespace

// Any bytes: they are refused with an Error, or make a sound scene; a small one is then cooked without maps,
// or refused in the same way. What looks like materials is read as such, too. As a frame of a sequence they
// are refused, or make sound polygons.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  // OBJ is told by its extension alone, and STL text only where there is no other.
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const bool solid = text.starts_with("solid");
  if (text.find("newmtl") != text.npos) checkMaterials(text);
  try {
    const Polygons polygons =
        polygonsOf(solid ? MeshFormat::kStlText : MeshFormat::kObj, {data, data + size});
    for (const uint32_t corner : polygons.corners) require(corner < polygons.positions.size());
    require(std::ranges::is_sorted(polygons.ends) &&
            (polygons.ends.empty() ? 0 : polygons.ends.back()) == polygons.corners.size());
  } catch (const std::exception&) {
  }
  try {
    SourceScene scene = importBytes(solid ? "fuzz.stl" : "fuzz.obj", {data, data + size});
    for (const Primitive& primitive : scene.primitives) checkPrimitive(primitive);
    for (const Part& part : scene.parts) {
      require(part.primitive < scene.primitives.size() && part.node < scene.rig.nodes.size());
      require(part.palette_begin + part.palette_count <= scene.rig.palette.size());
    }
    if (!small(scene)) return 0;
    Recipe recipe = defaultRecipe();
    recipe.layers.front().compress = MapNone{};
    CookOptions options;
    options.threads = 1;
    options.geometry = size % 2 ? GeometryCodec::kRaw : GeometryCodec::kDraco;
    cook(std::move(scene), recipe, options);
  } catch (const Error&) {
  }
  return 0;
}
