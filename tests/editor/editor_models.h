#pragma once

// A small character for the editor's tests: a sheet of 24 x 24 quads, 1 unit wide, that faces +Z and is
// middle at x = 0; morph target "squeeze" draws it together sideways to 60%, clip "go" does so in `seconds`.

#include <filesystem>
#include <vector>

#include "tests/unit/gltf_builder.h"

namespace furrow::test {

inline GltfBuilder editorSheetBuilder(float seconds = 1.0f) {
  constexpr uint32_t n = 24;
  std::vector<float> positions, uvs, deltas;
  std::vector<uint32_t> indices;
  for (uint32_t y = 0; y <= n; ++y)
    for (uint32_t x = 0; x <= n; ++x) {
      const float u = static_cast<float>(x) / n, v = static_cast<float>(y) / n;
      positions.insert(positions.end(), {u - 0.5f, v - 0.5f, 0.05f * u * v});
      uvs.insert(uvs.end(), {u, 1.0f - v});
      deltas.insert(deltas.end(), {-0.4f * (u - 0.5f), 0.0f, 0.0f});
      if (x == n || y == n) continue;
      const uint32_t a = y * (n + 1) + x, b = a + n + 1;
      indices.insert(indices.end(), {a, a + 1, b + 1, a, b + 1, b});
    }
  GltfBuilder builder;
  builder.add(positions, "VEC3", 3);
  builder.add(indices, "SCALAR", 1);
  builder.add(uvs, "VEC2", 2);
  builder.add(deltas, "VEC3", 3);
  builder.add(std::vector<float>{0.0f, seconds}, "SCALAR", 1);
  builder.add(std::vector<float>{0.0f, 1.0f}, "SCALAR", 1);
  return builder;
}

inline constexpr const char* kEditorClip =
    R"("animations":[{"name":"go","samplers":[{"input":4,"output":5}],)"
    R"("channels":[{"sampler":0,"target":{"node":0,"path":"weights"}}]}],)";

inline std::string editorSheet(float seconds = 1.0f) {
  return editorSheetBuilder(seconds).glb(
      R"("scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"materials":[{"name":"cloth"}],)" +
      std::string(kEditorClip) +
      R"("meshes":[{"name":"Sheet","extras":{"targetNames":["squeeze"]},"primitives":[{"material":0,)"
      R"("attributes":{"POSITION":0,"TEXCOORD_0":2},"indices":1,"targets":[{"POSITION":3}]}]}])");
}

// With nothing that moves it, of another size.
inline std::string editorStill(double scale = 1.0) {
  const std::string s = std::to_string(scale);
  return editorSheetBuilder().glb(
      R"("scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"scale":[)" + s + "," + s + "," + s +
      R"(]}],"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":2},"indices":1}]}])");
}

// Without any name, of mesh, material, clip or morph target.
inline std::string editorNameless() {
  return editorSheetBuilder().glb(
      R"("scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"animations":[{"samplers":[{"input":4,"output":5}],)"
      R"("channels":[{"sampler":0,"target":{"node":0,"path":"weights"}}]}],"meshes":[{"primitives":[)"
      R"({"attributes":{"POSITION":0,"TEXCOORD_0":2},"indices":1,"targets":[{"POSITION":3}]}]}])");
}

// Two of them side by side: mesh "Face" of material "skin" and mesh "Coat" of material "cloth", or nameless.
inline std::string editorPair(bool with_names = true) {
  const auto name = [with_names](const char* text) {
    return std::string(R"("name":")") + (with_names ? text : "") + "\"";
  };
  const auto mesh = [&name](const char* text, int material) {
    return std::string("{") + name(text) +
           R"(,"extras":{"targetNames":["squeeze"]},"primitives":[{"material":)" + std::to_string(material) +
           R"(,"attributes":{"POSITION":0,"TEXCOORD_0":2},"indices":1,"targets":[{"POSITION":3}]}]})";
  };
  return editorSheetBuilder().glb(
      R"("scene":0,"scenes":[{"nodes":[0,1]}],"nodes":[{"mesh":0},{"mesh":1,"translation":[1.2,0,0]}],)"
      R"("materials":[{)" +
      name("skin") + "},{" + name("cloth") + "}]," + std::string(kEditorClip) + "\"meshes\":[" +
      mesh("Face", 0) + "," + mesh("Coat", 1) + "]");
}

// Small maps cook fast.
inline constexpr const char* kEditorRecipe = R"({
  "mapSize": 128,
  "layers": [
    { "name": "lines", "direction": { "axis": [1, 0, 0] }, "mask": "none", "response": { "lambda": 1, "beta": 4 },
      "compress": { "synthesize": { "preset": "skin" } } },
    { "name": "other", "direction": { "axis": [0, 1, 0] }, "compress": "none" } ] })";

}  // namespace furrow::test
