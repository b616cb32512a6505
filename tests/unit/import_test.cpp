#include "pipeline/import/import.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <sstream>

#include "pipeline/error.h"
#include "pipeline/scene/posing.h"
#include "tests/unit/gltf_builder.h"

namespace furrow::pipeline {
namespace {

using test::GltfBuilder;
using test::writeFile;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
namespace fs = std::filesystem;

fs::path corpus(const std::string& file) {
  return fs::path(FURROW_CORPUS) / file;
}

#define SKIP_WITHOUT(file) \
  if (!fs::exists(corpus(file))) GTEST_SKIP() << corpus(file) << " is not here"

SourceScene importText(const std::string& name, const std::string& bytes) {
  return import(writeFile(name, bytes));
}

// The message with which a file is refused, which must name it.
std::string refusal(const fs::path& file) {
  try {
    import(file);
  } catch (const Error& e) {
    EXPECT_EQ(e.exit(), Exit::kBadData) << e.what();
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
    EXPECT_THAT(e.what(), ::testing::StartsWith(file.string() + ": "));
    return e.what();
  }
  ADD_FAILURE() << file << " was imported";
  return {};
}
std::string refusalOf(const std::string& name, const std::string& bytes) {
  return refusal(writeFile(name, bytes));
}

struct Counts {
  size_t vertices = 0, triangles = 0, primitives = 0, morphs = 0, joints = 0, clips = 0;
  bool operator==(const Counts&) const = default;
};
void PrintTo(const Counts& c, std::ostream* out) {
  *out << c.vertices << " v, " << c.triangles << " tri, " << c.primitives << " prim, " << c.morphs
       << " morphs, " << c.joints << " joints, " << c.clips << " clips";
}
Counts count(const SourceScene& scene) {
  Counts counts;
  counts.primitives = scene.primitives.size();
  for (const Primitive& primitive : scene.primitives) {
    counts.vertices += primitive.positions.size();
    counts.triangles += primitive.indices.size() / 3;
  }
  counts.morphs = scene.rig.morphs.size();
  for (const Part& part : scene.parts)
    if (part.skinned) counts.joints = std::max<size_t>(counts.joints, part.palette_count);
  counts.clips = scene.rig.clips.size();
  return counts;
}

bool finite(float value) {
  return std::isfinite(value);
}

// What source_scene.h and rig.h promise of every scene.
void expectSound(const SourceScene& scene) {
  ASSERT_FALSE(scene.parts.empty());
  ASSERT_FALSE(scene.dependencies.empty());
  EXPECT_EQ(scene.dependencies[0], scene.file);
  const Rig& rig = scene.rig;
  for (const Node& node : rig.nodes) ASSERT_TRUE(node.parent == kNoIndex || node.parent < rig.nodes.size());
  for (const PaletteEntry& entry : rig.palette) ASSERT_LT(entry.node, rig.nodes.size());
  for (const Primitive& primitive : scene.primitives) {
    const size_t n = primitive.positions.size();
    ASSERT_FALSE(primitive.indices.empty());
    ASSERT_EQ(primitive.indices.size() % 3, 0u);
    for (const uint32_t index : primitive.indices) ASSERT_LT(index, n);
    for (const glm::vec3& p : primitive.positions) ASSERT_TRUE(finite(p.x) && finite(p.y) && finite(p.z));
    ASSERT_TRUE(primitive.normals.empty() || primitive.normals.size() == n);
    ASSERT_TRUE(primitive.tangents.empty() || primitive.tangents.size() == n);
    ASSERT_TRUE(primitive.uvs.empty() || primitive.uvs.size() == n);
    for (const Attribute& attribute : primitive.attributes) {
      ASSERT_EQ(attribute.values.size(), n * attribute.components);
      ASSERT_TRUE(std::all_of(attribute.values.begin(), attribute.values.end(), finite));
    }
    ASSERT_EQ(primitive.joints.size(), n * primitive.influences);
    ASSERT_EQ(primitive.weights.size(), n * primitive.influences);
    for (size_t v = 0; v < n && primitive.influences > 0; ++v) {
      double sum = 0.0;
      for (size_t i = v * primitive.influences; i < (v + 1) * primitive.influences; ++i) {
        ASSERT_GE(primitive.weights[i], 0.0f);
        sum += static_cast<double>(primitive.weights[i]);
      }
      ASSERT_NEAR(sum, 1.0, 2e-6);
    }
    for (const MorphDelta& morph : primitive.morphs) {
      ASSERT_EQ(morph.positions.size(), morph.vertices.size());
      ASSERT_TRUE(morph.normals.empty() || morph.normals.size() == morph.vertices.size());
      for (size_t i = 0; i < morph.vertices.size(); ++i) {
        ASSERT_LT(morph.vertices[i], n);
        if (i > 0) {
          ASSERT_LT(morph.vertices[i - 1], morph.vertices[i]);
        }
      }
    }
  }
  for (const Part& part : scene.parts) {
    ASSERT_LT(part.primitive, scene.primitives.size());
    ASSERT_LT(part.node, rig.nodes.size());
    ASSERT_TRUE(part.material == kNoIndex || part.material < scene.materials.size());
    ASSERT_LE(size_t{part.palette_begin} + part.palette_count, rig.palette.size());
    const Primitive& primitive = scene.primitives[part.primitive];
    ASSERT_LE(part.first_morph + primitive.morphs.size(), rig.morphs.size());
    for (size_t m = 0; m < primitive.morphs.size(); ++m) {
      ASSERT_EQ(rig.morphs[part.first_morph + m].node, part.node);
      ASSERT_EQ(rig.morphs[part.first_morph + m].index, m);
    }
    if (part.skinned) {
      for (const uint16_t joint : primitive.joints) ASSERT_LT(joint, part.palette_count);
    }
  }
  for (const Clip& clip : rig.clips) {
    for (const Channel& channel : clip.channels) {
      ASSERT_LT(channel.node, rig.nodes.size());
      ASSERT_FALSE(channel.times.empty());
      for (size_t k = 1; k < channel.times.size(); ++k) ASSERT_LT(channel.times[k - 1], channel.times[k]);
      ASSERT_EQ(channel.values.size() % channel.times.size(), 0u);
      ASSERT_LE(static_cast<double>(channel.times.back()), clip.duration);
    }
    Pose pose = defaultPose(rig);
    applyClip(rig, clip, 0.4 * clip.duration, pose);
    const PosedRig posed = evaluate(rig, pose);
    for (const Part& part : scene.parts)
      ASSERT_EQ(posePart(scene, part, posed).size(), scene.primitives[part.primitive].positions.size());
  }
}

// One triangle at (0, 0, 0), (1, 0, 0), (0, 1, 0) as accessor 0.
GltfBuilder triangleFile() {
  GltfBuilder file;
  file.add<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3", 3);
  return file;
}
std::string shown(const std::string& primitive, const std::string& more = "") {
  return R"("nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"scene":0,"meshes":[{"primitives":[)" + primitive +
         "]}]" + (more.empty() ? "" : "," + more);
}
const char* const kTriangle = R"({"attributes":{"POSITION":0}})";

// A file with everything that a reader has to follow: indices, skin, sparse morph target, clip, colours.
GltfBuilder fullFile() {
  GltfBuilder file;
  file.add<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, "VEC3", 3);                        // 0
  file.add<uint16_t>({0, 1, 2, 2, 1, 3}, "SCALAR", 1);                                     // 1
  file.add<uint8_t>({0, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0}, "VEC4", 4);          // 2
  file.add<float>({.5f, .5f, 0, 0, 1, 0, 0, 0, .25f, .75f, 0, 0, 1, 0, 0, 0}, "VEC4", 4);  // 3
  file.add<float>(
      {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1},
      "MAT4", 16);  // 4
  const int index_view = file.addView<uint16_t>({1, 3});
  const int value_view = file.addView<float>({0, 0, 1, 0, 0, 2});
  file.addAccessor(
      R"("componentType":5126,"count":4,"type":"VEC3","sparse":{"count":2,"indices":{"bufferView":)" +
      std::to_string(index_view) + R"(,"componentType":5123},"values":{"bufferView":)" +
      std::to_string(value_view) + "}}");                            // 5
  file.add<float>({0, 1, 2}, "SCALAR", 1);                           // 6
  file.add<float>({0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 1}, "VEC4", 4);  // 7
  file.add<float>({0, 1, 0}, "SCALAR", 1);                           // 8
  file.add<uint8_t>({255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 0, 0, 0, 0}, "VEC4", 4,
                    R"(,"normalized":true)");
  return file;
}
const char* const kFull =
    R"("nodes":[{"mesh":0,"skin":0,"name":"body"},{"children":[2]},{"translation":[0,1,0]}],
  "scenes":[{"nodes":[0,1]}],"scene":0,"materials":[{"name":"skin","pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0.25,1]}}],
  "meshes":[{"name":"Body","extras":{"targetNames":["blink"]},"weights":[0.5],"primitives":[{"material":0,"indices":1,
    "attributes":{"POSITION":0,"JOINTS_0":2,"WEIGHTS_0":3,"COLOR_0":9},"targets":[{"POSITION":5}]}]}],
  "skins":[{"joints":[1,2],"inverseBindMatrices":4}],
  "animations":[{"name":"nod","channels":[{"sampler":0,"target":{"node":2,"path":"rotation"}},
    {"sampler":1,"target":{"node":0,"path":"weights"}}],
    "samplers":[{"input":6,"output":7},{"input":6,"output":8,"interpolation":"STEP"}]}])";

TEST(Import, ReadsAWholeFile) {
  const SourceScene scene = importText("full.glb", fullFile().glb(kFull));
  expectSound(scene);
  EXPECT_THAT(scene.warnings, IsEmpty());
  EXPECT_EQ(count(scene), (Counts{4, 2, 1, 1, 2, 1}));
  const Primitive& primitive = scene.primitives[0];
  EXPECT_THAT(primitive.indices, ElementsAre(0, 1, 2, 2, 1, 3));
  EXPECT_THAT(primitive.morphs[0].vertices, ElementsAre(1, 3));
  EXPECT_EQ(primitive.morphs[0].positions[1], glm::vec3(0, 0, 2));
  ASSERT_EQ(primitive.attributes.size(), 1u);
  EXPECT_EQ(primitive.attributes[0].name, "COLOR_0");
  EXPECT_EQ(primitive.attributes[0].values[0], 1.0f);
  EXPECT_EQ(scene.rig.morphs[0].name, "blink");
  EXPECT_EQ(scene.rig.morphs[0].default_weight, 0.5);
  EXPECT_EQ(scene.materials[0].base_color, glm::vec4(1, 0.5, 0.25, 1));
  EXPECT_EQ(scene.parts[0].mesh, "Body");
  EXPECT_EQ(scene.rig.clips[0].duration, 2.0);
}

TEST(Import, GltfWithFilesAndDataUris) {
  const GltfBuilder file = fullFile();
  writeFile("full buffer.bin", file.bin());
  const SourceScene scene = importText("external.gltf", file.json(kFull, "full%20buffer.bin"));
  expectSound(scene);
  ASSERT_EQ(scene.dependencies.size(), 2u);
  EXPECT_EQ(scene.dependencies[1].filename(), "full buffer.bin");
  EXPECT_TRUE(
      fs::equivalent(importText("slashes.gltf", file.json(kFull, ".\\\\full buffer.bin")).dependencies[1],
                     scene.dependencies[1]));
  // A buffer of that name in another folder is another one.
  EXPECT_THAT(refusalOf("elsewhere.gltf", file.json(kFull, "elsewhere/full%20buffer.bin")),
              HasSubstr("which is not there"));
  EXPECT_THAT(refusalOf("missing.gltf", file.json(kFull, "nowhere.bin")), HasSubstr("nowhere.bin"));

  // (0, 0, 0), (1, 0, 0), (0, 1, 0) in base64.
  const char* uri = "data:application/gltf-buffer;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
  EXPECT_EQ(importText("data.gltf", triangleFile().json(shown(kTriangle), uri)).primitives[0].positions[2],
            glm::vec3(0, 1, 0));
  EXPECT_THAT(refusalOf("short.gltf", fullFile().json(kFull, uri)), HasSubstr("cut off"));
}

TEST(Import, ImagesNeedNotExist) {
  const SourceScene scene = importText(
      "images.glb", triangleFile().glb(shown(kTriangle, R"("images":[{"uri":"gone.png"},{"bufferView":7}],
        "textures":[{"source":0}],"materials":[{"normalTexture":{"index":0}}])")));
  EXPECT_EQ(scene.materials.size(), 1u);
}

TEST(Import, StripsAndFansBecomeLists) {
  GltfBuilder file;
  file.add<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0}, "VEC3", 3);
  const auto indices = [&](int mode) {
    return importText("mode.glb",
                      file.glb(shown(R"({"attributes":{"POSITION":0},"mode":)" + std::to_string(mode) + "}")))
        .primitives[0]
        .indices;
  };
  EXPECT_THAT(indices(4), ElementsAre(0, 1, 2));
  EXPECT_THAT(indices(5), ElementsAre(0, 1, 2, 1, 3, 2, 2, 3, 4));
  EXPECT_THAT(indices(6), ElementsAre(1, 2, 0, 2, 3, 0, 3, 4, 0));
  EXPECT_THAT(refusalOf("lines.glb", file.glb(shown(R"({"attributes":{"POSITION":0},"mode":1})"))),
              HasSubstr("no triangles"));
}

TEST(Import, LinesBecomeGuidesBesideTheSurface) {
  GltfBuilder file;
  file.add<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3", 3);
  file.add<float>({0, 0, 1, 1, 0, 1, 2, 0, 1, 3, 0, 1}, "VEC3", 3);
  const auto lines = [&](int mode) {
    const SourceScene scene = importText(
        "lines.glb",
        file.glb(
            R"("scene":0,"scenes":[{"nodes":[0,1]}],"nodes":[{"mesh":0},{"mesh":1,"name":"curve","translation":[5,0,0]}],
          "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]},
            {"name":"Creases","primitives":[{"attributes":{"POSITION":1},"mode":)" +
            std::to_string(mode) + "}]}]"));
    EXPECT_THAT(scene.warnings, IsEmpty());
    EXPECT_EQ(scene.parts.size(), 1u);
    EXPECT_EQ(scene.lines.at(0).mesh, "Creases");
    EXPECT_EQ(scene.lines.at(0).node, 1u);
    std::vector<float> x;
    for (const glm::vec3& p : scene.lines.at(0).points) x.push_back(p.x);
    return x;
  };
  EXPECT_THAT(lines(1), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(lines(2), ElementsAre(0, 1, 1, 2, 2, 3, 3, 0));
  EXPECT_THAT(lines(3), ElementsAre(0, 1, 1, 2, 2, 3));
}

TEST(Import, LinesThatAreNotFiniteAreRefused) {
  GltfBuilder file;
  file.add<float>({0, 0, 0, 1, 0, std::numeric_limits<float>::quiet_NaN()}, "VEC3", 3);
  EXPECT_THAT(refusalOf("nan.glb", file.glb(shown(R"({"attributes":{"POSITION":0},"mode":3})"))),
              HasSubstr("a position that is not finite"));
  EXPECT_THAT(refusalOf("far.glb", file.glb(shown(R"({"attributes":{"POSITION":7},"mode":3})"))),
              HasSubstr("7"));
}

TEST(Import, OneMeshShownTwiceIsOnePrimitive) {
  const SourceScene scene = importText(
      "twice.glb",
      triangleFile().glb(
          R"("nodes":[{"mesh":0},{"mesh":0,"translation":[1,0,0]}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}])"));
  EXPECT_EQ(scene.primitives.size(), 1u);
  ASSERT_EQ(scene.parts.size(), 2u);
  EXPECT_NE(scene.parts[0].palette_begin, scene.parts[1].palette_begin);
}

TEST(Import, OnlyTheDefaultSceneIsShown) {
  const SourceScene scene = importText(
      "scene.glb",
      triangleFile().glb(
          R"("nodes":[{"mesh":0},{"children":[2]},{"mesh":0}],"scenes":[{"nodes":[0]},{"nodes":[1]}],"scene":1,
         "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}])"));
  ASSERT_EQ(scene.parts.size(), 1u);
  EXPECT_EQ(scene.parts[0].node, 2u);
}

TEST(Import, WithoutADefaultSceneTheFirstIsShown) {
  const SourceScene scene = importText(
      "scenes.glb",
      triangleFile().glb(
          R"("nodes":[{"mesh":0,"name":"a"},{"mesh":0,"name":"b"}],"scenes":[{"nodes":[1]},{"nodes":[0]}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}])"));
  ASSERT_EQ(scene.parts.size(), 1u);
  EXPECT_EQ(scene.rig.nodes[scene.parts[0].node].name, "b");
}

TEST(Import, TargetNamesMayStandInThePrimitive) {
  const SourceScene scene = importText(
      "names.glb",
      triangleFile().glb(shown(
          R"({"attributes":{"POSITION":0},"targets":[{"POSITION":0}],"extras":{"targetNames":["Joy"]}})")));
  EXPECT_EQ(scene.rig.morphs.at(0).name, "Joy");
}

TEST(Import, WeightsOfTargetsAreFloats) {
  const auto weighted = [](const char* weight) {
    return triangleFile().glb(
        R"("nodes":[{"mesh":0,"weights":[)" + std::string(weight) +
        R"(]}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"targets":[{"POSITION":0}]}]}])");
  };
  EXPECT_EQ(importText("weight.glb", weighted("0.25")).rig.morphs.at(0).default_weight, 0.25);
  EXPECT_THAT(refusalOf("weight.glb", weighted("1e300")), HasSubstr("a weight that is no float"));
}

TEST(Import, JsonMayBePaddedWithZeros) {
  std::string glb = triangleFile().glb(shown(kTriangle) + R"(,"extras":{"pad":"12345"}  )");
  const size_t end = 20 + *reinterpret_cast<const uint32_t*>(glb.data() + 12);
  for (size_t i = end; glb[i - 1] == ' '; --i) glb[i - 1] = '\0';
  EXPECT_EQ(count(importText("padded.glb", glb)).triangles, 1u);
}

// Images, materials, lights, cameras and extensions of avatars, broken or not.
TEST(Import, WhatFurrowDoesNotUseDoesNoHarm) {
  GltfBuilder file = triangleFile();
  file.add<uint16_t>({0, 0, 0, 0, 65535, 0, 0, 0, 0, 0, 0, 0}, "VEC4", 4, R"(,"normalized":true)");
  file.add<uint32_t>({7, 8, 9}, "SCALAR", 1);
  const SourceScene scene =
      importText("avatar.glb", file.glb(R"("scene":0,"scenes":[{"nodes":[0,1,2],"name":""}],
    "nodes":[{"mesh":0,"name":"\u00e9t\u00e9","scale":[-1,1,1],"extensions":{"KHR_lights_punctual":{"light":3},"MSFT_lod":{"ids":[9]},
      "EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":99}}}},{"camera":4,"name":"x"},{"name":"x"}],
    "meshes":[{"name":"","primitives":[{"attributes":{"POSITION":0,"COLOR_0":1,"__LAYER":2,"FEATURE_ID_0":2},"material":0,
      "extensions":{"KHR_materials_variants":{"mappings":[{"material":7}]}}}]}],
    "materials":[{"name":"Haut \u00fc","pbrMetallicRoughness":{"baseColorTexture":{"index":7}},"extensions":{"VRMC_materials_mtoon":{}}}],
    "images":[{"bufferView":99,"mimeType":"image/ktx2"},{"uri":"nowhere.png"}],"textures":[{"source":5}],"cameras":[{}],
    "animations":[{"channels":[{"sampler":0,"target":{"path":"pointer","extensions":{"KHR_animation_pointer":{"pointer":"/x"}}}}],
      "samplers":[{"input":0,"output":0}]}],
    "extensionsUsed":["VRM","MSFT_lod","EXT_mesh_gpu_instancing","KHR_lights_punctual"],
    "extensions":{"VRM":{"blendShapeMaster":{"blendShapeGroups":[]}},"KHR_lights_punctual":{"lights":[]}})"));
  expectSound(scene);
  EXPECT_EQ(count(scene), (Counts{3, 1, 1, 0, 0, 0}));
  EXPECT_EQ(scene.parts[0].mesh, "\u00e9t\u00e9");
  ASSERT_EQ(scene.primitives[0].attributes.size(), 2u);
  EXPECT_EQ(scene.primitives[0].attributes[0].values[4], 1.0f);
  EXPECT_EQ(scene.primitives[0].attributes[1].values[2], 9.0f);
  EXPECT_THAT(
      scene.warnings,
      ElementsAre(HasSubstr("1 animation channels are left out"), HasSubstr("EXT_mesh_gpu_instancing"),
                  HasSubstr("there is no texture 7"), HasSubstr("animation 0 is left out")));
}

TEST(Import, RequiredExtensionsAreKnownOrNamed) {
  const auto requiring = [](const std::string& name) {
    return triangleFile().glb(shown(kTriangle, R"("extensionsRequired":[")" + name + "\"]"));
  };
  for (const char* name : {"KHR_texture_basisu", "EXT_texture_avif", "EXT_mesh_gpu_instancing", "VENDOR_new"})
    EXPECT_THAT(refusalOf("required.glb", requiring(name)), HasSubstr(name));
  for (const char* name : {"EXT_texture_webp", "KHR_texture_transform"})
    EXPECT_THAT(importText("read.glb", requiring(name)).warnings, IsEmpty());
  for (const char* name :
       {"KHR_materials_unlit", "KHR_lights_punctual", "KHR_node_visibility", "VRMC_vrm", "FB_ngon_encoding"})
    EXPECT_THAT(importText("harmless.glb", requiring(name)).warnings, ElementsAre(HasSubstr(name)));
}

TEST(Import, NamesAreOnOneLine) {
  const SourceScene scene = importText(
      "names.glb",
      triangleFile().glb(
          R"("nodes":[{"mesh":0,"name":"a\tb"}],"scenes":[{"nodes":[0]}],"scene":0,)"
          R"("meshes":[{"name":"new\nline","primitives":[{"attributes":{"POSITION":0},"material":0}]}],)"
          R"("materials":[{"name":"\u001b[1m \u00fc"}])"));
  EXPECT_EQ(scene.parts[0].mesh, "new line");
  EXPECT_EQ(scene.materials[0].name, " [1m \u00fc");
  EXPECT_EQ(scene.rig.nodes[0].name, "a b");
}

TEST(Import, MeshesThatNoNodeShowsGetNodes) {
  const SourceScene scene = importText(
      "nodeless.glb",
      triangleFile().glb(R"("meshes":[{"name":"M","primitives":[{"attributes":{"POSITION":0}}]}])"));
  expectSound(scene);
  EXPECT_EQ(scene.rig.nodes.at(scene.parts[0].node).name, "M");
}

TEST(Import, SparseReplacesWithAndWithoutBase) {
  GltfBuilder file = triangleFile();
  const int indices = file.addView<uint8_t>({1, 2});
  const int values = file.addView<float>({5, 0, 0, 0, 6, 0});
  const std::string sparse =
      R"("componentType":5126,"count":3,"type":"VEC3","sparse":{"count":2,"indices":{"bufferView":)" +
      std::to_string(indices) + R"(,"componentType":5121},"values":{"bufferView":)" + std::to_string(values) +
      "}}";
  file.addAccessor(R"("bufferView":0,)" + sparse);
  file.addAccessor(sparse);
  const SourceScene scene =
      importText("sparse.glb", file.glb(shown(R"({"attributes":{"POSITION":1,"NORMAL":2}})")));
  const Primitive& primitive = scene.primitives[0];
  EXPECT_EQ(primitive.positions[0], glm::vec3(0, 0, 0));
  EXPECT_EQ(primitive.positions[1], glm::vec3(5, 0, 0));
  EXPECT_EQ(primitive.normals[0], glm::vec3(0, 0, 0));
  EXPECT_EQ(primitive.normals[2], glm::vec3(0, 6, 0));
}

TEST(Import, QuantisedAndNormalisedNumbers) {
  GltfBuilder file;
  file.add<int16_t>({0, 0, 0, 0, 32767, 0, 0, 0, 0, -32768, 0, 0}, "VEC3", 4, R"(,"normalized":true)");
  file.add<uint8_t>({0, 255, 51, 0, 0, 0}, "VEC2", 2, R"(,"normalized":true)");
  file.add<int8_t>({127, -128, -127, 0, 1, 2, 3, 4, 5, 6, 7, 8}, "VEC4", 4);
  std::string text = file.glb(
      shown(R"({"attributes":{"POSITION":0,"TEXCOORD_0":1,"_RAW":2}})",
            R"("extensionsUsed":["KHR_mesh_quantization"],"extensionsRequired":["KHR_mesh_quantization"])"));
  // Four shorts an element, of which three count.
  const std::string from = R"({"buffer":0,"byteOffset":0,"byteLength":24})";
  std::string to = R"({"buffer":0,"byteStride":8,"byteLength":24})";
  text.replace(text.find(from), from.size(), to.append(from.size() - to.size(), ' '));
  const Primitive primitive = importText("quantised.glb", text).primitives.at(0);
  EXPECT_EQ(primitive.positions[1], glm::vec3(1, 0, 0));
  EXPECT_EQ(primitive.positions[2], glm::vec3(0, -1, 0));
  EXPECT_EQ(primitive.uvs[0], glm::vec2(0, 1));
  EXPECT_FLOAT_EQ(primitive.uvs[1].x, 0.2f);
  EXPECT_EQ(primitive.attributes.at(0).values[1], -128.0f);
}

TEST(Import, AnyNumberOfInfluencesAndOddWeights) {
  GltfBuilder file = triangleFile();
  file.add<uint8_t>({0, 1, 2, 0, 1, 0, 0, 0, 2, 0, 0, 0}, "VEC4", 4);
  file.add<float>({.25f, .25f, .25f, 0, 0, 0, 0, 0, 2, 0, 0, 0}, "VEC4", 4);
  file.add<uint16_t>({1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC4", 4);
  file.add<float>({.25f, 0, 0, 0, 0, 0, 0, 0, -1, 0, 0, 0}, "VEC4", 4);
  const SourceScene scene = importText(
      "influences.glb",
      file.glb(
          R"("nodes":[{"mesh":0,"skin":0},{},{},{}],"skins":[{"joints":[1,2,3]}],"meshes":[{"primitives":[
        {"attributes":{"POSITION":0,"JOINTS_0":1,"WEIGHTS_0":2,"JOINTS_1":3,"WEIGHTS_1":4}}]}])"));
  expectSound(scene);
  const Primitive& primitive = scene.primitives[0];
  ASSERT_EQ(primitive.influences, 8u);
  EXPECT_EQ(primitive.joints[4], 1u);
  EXPECT_EQ(primitive.weights[4], 0.25f);
  // No weight at all: the first joint. Too much weight: scaled.
  EXPECT_EQ(primitive.joints[8], 1u);
  EXPECT_EQ(primitive.weights[8], 1.0f);
  EXPECT_EQ(primitive.weights[16], 1.0f);
  EXPECT_EQ(scene.warnings.size(), 2u);
}

TEST(Import, BrokenClipsAreLeftOutAndRepeatedKeysMerged) {
  GltfBuilder file = triangleFile();
  file.add<float>({0, 1, 1, 2}, "SCALAR", 1);
  file.add<float>({0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0}, "VEC3", 3);
  file.add<float>({0, 2, 1, 3}, "SCALAR", 1);
  const SourceScene scene = importText("clips.glb", file.glb(shown(kTriangle,
                                                                   R"("animations":[
        {"name":"good","channels":[{"sampler":0,"target":{"node":0,"path":"translation"}}],"samplers":[{"input":1,"output":2}]},
        {"name":"back","channels":[{"sampler":0,"target":{"node":0,"path":"translation"}}],"samplers":[{"input":3,"output":2}]},
        {"name":"pointer","channels":[{"sampler":0,"target":{"path":"pointer"}}],"samplers":[{"input":1,"output":2}]},
        {"name":"nothing","channels":[{"sampler":0,"target":{"node":0,"path":"weights"}}],"samplers":[{"input":1,"output":1}]}])")));
  expectSound(scene);
  ASSERT_EQ(scene.rig.clips.size(), 1u);
  const Channel& channel = scene.rig.clips[0].channels[0];
  EXPECT_THAT(channel.times, ElementsAre(0, 1, 2));
  EXPECT_THAT(channel.values, ElementsAre(0, 0, 0, 2, 0, 0, 3, 0, 0));
  EXPECT_THAT(scene.warnings, ::testing::Contains(HasSubstr("backwards")));
  EXPECT_THAT(scene.warnings, ::testing::Contains(HasSubstr("\"pointer\"")));
}

TEST(Import, RefusesWhatIsNoModel) {
  EXPECT_THAT(refusal("/no/such/file.glb"), HasSubstr("no such file"));
  EXPECT_THAT(refusal(fs::path(::testing::TempDir())), HasSubstr("directory"));
  EXPECT_THAT(refusalOf("empty.glb", ""), HasSubstr("empty"));
  EXPECT_THAT(refusalOf("text.glb", "hello, this is no model"), HasSubstr("not glTF"));
  EXPECT_THAT(refusalOf("picture.png", "\x89PNG"), HasSubstr("not a format"));
  EXPECT_THAT(refusalOf("other.gltf", R"({"hello":1})"), HasSubstr("asset"));
  EXPECT_THAT(refusalOf("one.gltf", R"({"asset":{"version":"1.0"}})"), HasSubstr("1.0"));
  EXPECT_THAT(refusalOf("void.gltf", R"({"asset":{"version":"2.0"}})"), HasSubstr("no triangles"));
  EXPECT_THAT(refusalOf("open.gltf", R"({"asset":{"version":"2.0"})"), HasSubstr("JSON"));
  EXPECT_THAT(refusalOf("deep.gltf", R"({"asset":{"version":"2.0"},"extras":)" + std::string(100000, '[')),
              HasSubstr("nested"));
  EXPECT_THAT(refusalOf("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"), HasSubstr("no faces"));
}

TEST(Import, RefusesASmallFileThatUnfoldsIntoAHugeOne) {
  GltfBuilder file;
  file.add<float>(std::vector<float>(30000), "VEC3", 3);
  std::string primitives = kTriangle;
  for (int i = 0; i < 20000; ++i) primitives += std::string(",") + kTriangle;
  EXPECT_THAT(refusalOf("bomb.glb", file.glb(shown(primitives))), HasSubstr("over and over"));
}

TEST(Import, RefusesMoreVerticesThanNumbers) {
  GltfBuilder file;
  file.add<float>(std::vector<float>(3 * 20000), "VEC3", 3);
  std::string nodes = R"({"mesh":0})";
  for (int i = 1; i < 60000; ++i) nodes += R"(,{"mesh":0})";
  EXPECT_THAT(
      refusalOf("crowd.glb", file.glb(R"("nodes":[)" + nodes +
                                      R"(],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}])")),
      HasSubstr("its nodes show 1200000000 vertices"));
}

TEST(Import, RefusesBrokenGltf) {
  const auto refuse = [](const GltfBuilder& file, const std::string& primitive,
                         const std::string& more = "") {
    return refusalOf("broken.glb", file.glb(shown(primitive, more)));
  };
  GltfBuilder file = triangleFile();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const int far_index = file.add<uint32_t>({0, 1, 3}, "SCALAR", 1);
  const int not_finite = file.add<float>({0, 0, 0, 1, 0, nan, 0, 1, 0}, "VEC3", 3);
  const int shorts = file.add<int16_t>({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3", 3);
  const int two = file.add<float>({0, 0, 0, 1}, "VEC2", 2);
  const int joints = file.add<uint8_t>({0, 0, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0}, "VEC4", 4);
  const int weights = file.add<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4", 4);
  const int too_long = file.addAccessor(R"("bufferView":0,"componentType":5126,"count":4,"type":"VEC3")");
  const int behind =
      file.addAccessor(R"("bufferView":0,"byteOffset":4,"componentType":5126,"count":3,"type":"VEC3")");
  const int huge = file.addAccessor(R"("componentType":5126,"count":4000000000,"type":"VEC3")");
  const int sparse_far = file.addAccessor(
      R"("componentType":5126,"count":3,"type":"VEC3","sparse":{"count":1,"indices":{"bufferView":1,"byteOffset":8,"componentType":5125},"values":{"bufferView":0}})");
  const int sparse_huge = file.addAccessor(
      R"("componentType":5126,"count":3,"type":"VEC3","sparse":{"count":2000000000,"indices":{"bufferView":1,"componentType":5125},"values":{"bufferView":0}})");
  const int no_view = file.addAccessor(R"("bufferView":99,"componentType":5126,"count":3,"type":"VEC3")");
  const int bad_type = file.addAccessor(R"("bufferView":0,"componentType":5127,"count":3,"type":"VEC3")");

  const auto at = [](int accessor) {
    return R"({"attributes":{"POSITION":)" + std::to_string(accessor) + "}}";
  };
  EXPECT_THAT(refuse(file, R"({"attributes":{"POSITION":0},"indices":)" + std::to_string(far_index) + "}"),
              HasSubstr("index 3 of 3"));
  EXPECT_THAT(refuse(file, at(not_finite)), HasSubstr("not finite"));
  EXPECT_THAT(refuse(file, at(shorts)), HasSubstr("KHR_mesh_quantization"));
  EXPECT_THAT(refuse(file, at(two)), HasSubstr("2 components"));
  EXPECT_THAT(refuse(file, at(too_long)), HasSubstr("behind the end"));
  EXPECT_THAT(refuse(file, at(behind)), HasSubstr("behind the end"));
  EXPECT_THAT(refuse(file, at(huge)), HasSubstr("more elements than the file has bytes"));
  EXPECT_THAT(refuse(file, at(sparse_far)), HasSubstr("sparse"));
  EXPECT_THAT(refuse(file, at(sparse_huge)), HasSubstr("sparse"));
  EXPECT_THAT(refuse(file, at(no_view)), HasSubstr("buffer view 99 does not exist"));
  EXPECT_THAT(refuse(file, at(bad_type)), HasSubstr("component type"));
  EXPECT_THAT(refuse(file, at(-1)), HasSubstr("accessor -1 does not exist"));
  EXPECT_THAT(refuse(file, R"({"attributes":{"POSITION":4294967296}})"), HasSubstr("number of an accessor"));
  EXPECT_THAT(refuse(file, R"({"attributes":{"POSITION":0,"NORMAL":)" + std::to_string(two) + "}}"),
              HasSubstr("NORMAL"));
  EXPECT_THAT(refuse(file, R"({"attributes":{"POSITION":0},"material":0})"), HasSubstr("material"));
  EXPECT_THAT(refuse(file, R"({"attributes":{"POSITION":0},"mode":7})"), HasSubstr("mode 7"));
  EXPECT_THAT(refuse(file, R"({"attributes":{"POSITION":0},"targets":[{"POSITION":50}]})"),
              HasSubstr("accessor 50 does not exist"));
  EXPECT_THAT(
      refuse(
          file,
          R"({"attributes":{"POSITION":0},"extensions":{"KHR_draco_mesh_compression":{"bufferView":0,"attributes":{"POSITION":0}}}})"),
      HasSubstr("Draco"));
  EXPECT_THAT(
      refuse(
          file,
          R"({"attributes":{"POSITION":0},"extensions":{"KHR_draco_mesh_compression":{"bufferView":77,"attributes":{}}}})"),
      HasSubstr("77"));
  EXPECT_THAT(refuse(file, kTriangle, R"("extensionsRequired":["EXT_mesh_gpu_instancing"])"),
              HasSubstr("EXT_mesh_gpu_instancing"));

  const std::string skinned =
      R"("skins":[{"joints":[1]}],"meshes":[{"primitives":[{"attributes":{"POSITION":0,"JOINTS_0":)" +
      std::to_string(joints) + R"(,"WEIGHTS_0":)" + std::to_string(weights) + "}}]}]";
  EXPECT_THAT(refusalOf("joints.glb", file.glb(R"("nodes":[{"mesh":0,"skin":0},{}],)" + skinned)),
              HasSubstr("joint 9"));
  EXPECT_THAT(refusalOf("skin.glb", file.glb(R"("nodes":[{"mesh":0,"skin":5},{}],)" + skinned)),
              HasSubstr("skin"));
  const std::string mesh = R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}])";
  for (const auto& [node, fault] :
       {std::pair(R"("matrix":[1,0,0,0,1,0,0,0,1])", "a matrix of 9 numbers"),
        std::pair(R"("translation":[1,2])", "a translation of 2 numbers"),
        std::pair(R"("scale":[1,1e300,1])", "a scale that is no float"),
        std::pair(R"("skin":4294967296)", R"("skin" is 4294967296.0 and no whole number)"),
        std::pair(R"("children":[0.5])", R"("children" is 0.5 and no whole number)"),
        std::pair(R"("mesh":"0")", R"("mesh" is "0" and no whole number)")})
    EXPECT_THAT(refusalOf("node.glb", file.glb(R"("nodes":[{"mesh":0},{)" + std::string(node) + "}]" + mesh)),
                HasSubstr(fault));
  // Offsets beyond 32 bits must not become 0.
  GltfBuilder far = file;
  far.addAccessor(
      R"("bufferView":0,"byteOffset":1099511627776,"componentType":5126,"count":3,"type":"VEC3")");
  EXPECT_THAT(refusalOf("offset.glb", far.glb(R"("nodes":[{"mesh":0}])" + mesh)), HasSubstr("byteOffset"));
  EXPECT_THAT(
      refusalOf("cycle.glb", file.glb(R"("nodes":[{"mesh":0,"children":[1]},{"children":[0]}])" + mesh)),
      HasSubstr("ancestor"));
  EXPECT_THAT(
      refusalOf("parents.glb", file.glb(R"("nodes":[{"mesh":0},{"children":[0]},{"children":[0]}])" + mesh)),
      HasSubstr("two parents"));
  EXPECT_THAT(refusalOf("child.glb", file.glb(R"("nodes":[{"mesh":0,"children":[8]}])" + mesh)),
              HasSubstr("child"));
  EXPECT_THAT(refusalOf("mesh.glb", file.glb(R"("nodes":[{"mesh":3}])" + mesh)), HasSubstr("mesh"));
}

double area(const SourceScene& scene) {
  double sum = 0.0;
  for (const Primitive& p : scene.primitives)
    for (size_t i = 0; i < p.indices.size(); i += 3) {
      const glm::dvec3 a(p.positions[p.indices[i]]), b(p.positions[p.indices[i + 1]]),
          c(p.positions[p.indices[i + 2]]);
      sum += 0.5 * glm::length(glm::cross(b - a, c - a));
    }
  return sum;
}

TEST(Import, ObjSplitsVerticesAtSeamsAndKeepsMaterials) {
  const SourceScene scene =
      importText("seam.obj",
                 "mtllib nowhere.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 9 9 9\n"
                 "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 0.5 0.5\nvn 0 0 1\n"
                 "usemtl skin\nf 1/1/1 2/2/1 3/3/1 4/4/1\n"
                 "usemtl lips\nf -5/5/1 -2/1/1 -4/3/1\nusemtl skin\nf 2/5/1 \\\n 5/1/1 3/3/1\n");
  expectSound(scene);
  ASSERT_EQ(scene.materials.size(), 2u);
  EXPECT_EQ(scene.materials[0].name, "skin");
  EXPECT_EQ(scene.materials[1].name, "lips");
  const Primitive& skin = scene.primitives[0];
  // The second vertex comes twice, with the file's UVs (1, 0) and (0.5, 0.5).
  ASSERT_EQ(skin.positions.size(), 6u);
  EXPECT_EQ(skin.positions[1], skin.positions[2]);
  // V grows upwards in OBJ, downwards in glTF.
  EXPECT_EQ(skin.uvs[1], glm::vec2(1, 1));
  EXPECT_EQ(skin.uvs[2], glm::vec2(0.5, 0.5));
  EXPECT_EQ(skin.normals[0], glm::vec3(0, 0, 1));
  EXPECT_EQ(skin.indices.size(), 9u);
  EXPECT_EQ(scene.primitives[1].positions.size(), 3u);
  EXPECT_THAT(scene.warnings,
              ElementsAre(HasSubstr("nowhere.mtl: no such file"), HasSubstr("1 vertices belong to no face")));
}

TEST(Import, PolygonsAreTriangulatedInside) {
  // An arrowhead whose fan from the first corner would leave it.
  EXPECT_NEAR(area(importText("arrow.obj", "v 0 0 0\nv 2 2 0\nv 0 1 0\nv -2 2 0\nf 2 3 4 1\n")), 2.0, 1e-9);
  // A comb of five teeth, 1 high and 1 wide at its foot, on a bar of height 1.
  std::string comb = "v 0 0 0\nv 10 0 0\n";
  for (int tooth = 4; tooth >= 0; --tooth)
    for (const auto& [x, y] : {std::pair{2, 1}, std::pair{1, 2}, std::pair{0, 1}})
      if (x != 2 || tooth == 4)
        comb += "v " + std::to_string(2 * tooth + x) + " " + std::to_string(y) + " 0\n";
  comb += "f 1 2 3 4 5 6 7 8 9 10 11 12 13\n";
  EXPECT_NEAR(area(importText("comb.obj", comb)), 10.0 + 5.0, 1e-9);
}

TEST(Import, LongPolygonsAreTriangulatedInside) {
  // A star whose every other corner lies further in: 1000 triangles about its centre.
  std::ostringstream star;
  for (int i = 0; i < 1000; ++i) {
    const double angle = i * std::numbers::pi / 500, radius = i % 2 ? 0.7 : 1.0;
    star << "v " << radius * std::cos(angle) << " " << radius * std::sin(angle) << " 0\n";
  }
  star << "f";
  for (int i = 1; i <= 1000; ++i) star << " " << i;
  EXPECT_NEAR(area(importText("star.obj", star.str())), 500 * 0.7 * std::sin(std::numbers::pi / 500), 1e-4);
}

TEST(Import, ObjAsToolsWriteIt) {
  const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  const auto ended = [](std::string text, const std::string& end) {
    for (size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += end.size())
      text.replace(at, 1, end);
    return text;
  };
  const std::string two = square + "f 1 2 3 # half\n  f 1 3 4   \n";
  const std::pair<const char*, std::string> files[] = {
      {"comment.obj", two},
      {"crlf.obj", ended(two, "\r\n")},
      {"cr.obj", ended(square + "f 1 2 3\nf 1 3 4\n", "\r")},
      {"bom.obj", "\xEF\xBB\xBF" + two},
      {"other.obj", "mtllib a b.mtl\no x\n" + square + "vp 0 1\ng a b c\ns off\nl 1 2 3\np 1\nf 1 2 3 4\n"},
      {"objects.obj",
       "o A\nv 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\no B\nv 0 0 0\nv 1 1 0\nv 0 1 0\nf -3 -2 -1\n"},
      {"weights.obj", ended(square, " 1.0\n") + "f 1 2 3 4\n"},
      {"colors.obj", ended(square, " 1 0 0.5\n") + "f 1 2 3 4\n"},
      {"depths.obj", square + "vt 0 0 0\nvt 1 0 0\nvt 1 1 0\nvt 0 1 0\nf 1/1 2/2 3/3 4/4\n"},
      {"lines.obj", square + "vt 0\nvt 1 # end\r\nvt 1\nvt 0.5\nusemtl a\nf 1/1 2/2 3/3 4/4\n"},
      {"no_uvs.obj", square + "f 1/1/1 2/2/2 3/3/3 4/4/4\n"}};
  for (const auto& [name, text] : files) {
    SCOPED_TRACE(name);
    const SourceScene scene = importText(name, text);
    expectSound(scene);
    EXPECT_EQ(count(scene).triangles, 2u);
    EXPECT_NEAR(area(scene), 1.0, 1e-9);
  }
  const SourceScene lines = importText("lines.obj", files[9].second);
  EXPECT_EQ(lines.primitives[0].uvs[1], glm::vec2(1, 1));
  EXPECT_EQ(lines.materials.at(0).name, "a");
  EXPECT_EQ(importText("spaced.obj", square + "usemtl my skin\nf 1 2 3 4\n").materials[0].name, "my skin");
  const SourceScene late = importText("late.obj", square + "f 1 2 3\nusemtl skin\nf 1 3 4\n");
  ASSERT_EQ(late.materials.size(), 2u);
  EXPECT_EQ(late.materials[0].name, "material 0");
  EXPECT_EQ(late.materials[1].name, "skin");
}

TEST(Import, NonManifoldFacesStay) {
  // Three faces on one edge, and one of them twice.
  const SourceScene scene = importText(
      "fin.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 2 5\nf 1 2 5\n");
  EXPECT_EQ(count(scene).triangles, 4u);
  EXPECT_EQ(count(scene).vertices, 5u);
}

TEST(Import, ObjIsRefusedWhereItLies) {
  EXPECT_THAT(refusalOf("wide.obj", std::string("\xFF\xFEv\0 \0", 6)), HasSubstr("UTF-16"));
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  EXPECT_THAT(refusalOf("far.obj", vertices + "f 1 2 4\n"), HasSubstr("vertex 3 of 3"));
  EXPECT_THAT(refusalOf("zero.obj", vertices + "f 0 1 2\n"), HasSubstr("does not exist"));
  EXPECT_THAT(refusalOf("slash.obj", vertices + "vn 0 0 1\nf //1 //1 //1\n"), HasSubstr("without a vertex"));
  EXPECT_THAT(refusalOf("nan.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 2 3 4\n"),
              HasSubstr("three numbers"));
}

const std::string kPlyHeader =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n";
const std::string kPlyList = "property list uchar int vertex_indices\nend_header\n";

TEST(Import, Ply) {
  const std::string body = "0 0 0 255 0 0\n1 0 0 0 255 0\n0 1 0 0 0 51\n3 0 1 2\n";
  const SourceScene ply = importText("colors.ply", kPlyHeader + kPlyList + body);
  expectSound(ply);
  EXPECT_FLOAT_EQ(ply.primitives[0].attributes.at(0).values[10], 0.2f);
  // What furrow does not use: lists, before and behind the corners, other elements, flags, comments.
  const SourceScene mixed = importText(
      "mixed.ply",
      "ply\nformat ascii 1.0\ncomment by hand\nelement material 1\nproperty list uint8 char name\n"
      "element vertex 3\nproperty double x\nproperty float64 y\nproperty float32 z\nproperty int flags\n"
      "property list uint uint near\nproperty uint8 red\nproperty uint8 green\nproperty uint8 blue\n"
      "element face 1\nproperty list uchar float texcoord\nproperty list ushort uint32 vertex_index\n"
      "property uchar flag\nelement edge 1\nproperty int vertex1\nend_header\n2 65 66\n0 0 0 7 1 5 255 0 0\n"
      "1 0 0 7 0 0 255 0\n0 1 0 7 2 5 6 0 0 51\n6 0 0 1 0 0 1 3 0 1 2 9\n0\n");
  expectSound(mixed);
  EXPECT_EQ(count(mixed), (Counts{3, 1, 1, 0, 0, 0}));
  EXPECT_EQ(mixed.primitives[0].positions[2], glm::vec3(0, 1, 0));
  EXPECT_FLOAT_EQ(mixed.primitives[0].attributes.at(0).values[10], 0.2f);
  EXPECT_THAT(refusalOf("cloud.ply", kPlyHeader.substr(0, kPlyHeader.find("element face")) + "end_header\n" +
                                         body.substr(0, body.find("3 0 1 2"))),
              HasSubstr("cloud of points"));
  EXPECT_THAT(refusalOf("endless.ply",
                        "ply\nformat ascii 1.0\nelement vertex 18446744073709551615\n"
                        "element face 1\n" +
                            kPlyList + "3 0 1 2\n"),
              HasSubstr("without properties"));
  EXPECT_THAT(refusalOf("cut.ply", kPlyHeader + kPlyList + body.substr(0, 30)), HasSubstr("cut off"));
  EXPECT_THAT(refusalOf("header.ply", kPlyHeader), HasSubstr("header"));
  std::string many = kPlyHeader + kPlyList + body;
  many.replace(many.find("vertex 3"), 8, "vertex 4000000000");
  EXPECT_THAT(refusalOf("many.ply", many), HasSubstr("cut off"));
}

TEST(Import, PlyAsOtherToolsWriteIt) {
  // UVs by corner, as MeshLab writes them: a vertex of two faces that differ there comes twice.
  const std::string quad =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string places = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
  const SourceScene wedges = importText(
      "wedges.ply", quad +
                        "element face 3\nproperty list uchar int vertex_indices\n"
                        "property list uchar float texcoord\nend_header\n" +
                        places + "3 0 1 2 0\n3 0 1 2 6 0 0 1 0 1 0.25\n3 0 2 3 6 0 0 1 0.25 0 0.5\n");
  expectSound(wedges);
  EXPECT_EQ(count(wedges).vertices, 6u);
  ASSERT_EQ(wedges.primitives[0].uvs.size(), 6u);
  EXPECT_EQ(wedges.primitives[0].uvs[wedges.primitives[0].indices[8]].x, 0.0f);
  EXPECT_EQ(wedges.primitives[0].uvs[wedges.primitives[0].indices[4]].x, 1.0f);
  std::string named =
      quad + "property float texture_u\nproperty float texture_v\nelement face 1\n" + kPlyList;
  named += "0 0 0 0 1\n1 0 0 0.25 1\n1 1 0 1 1\n0 1 0 1 1\n3 0 1 2\n";
  EXPECT_EQ(importText("named.ply", named).primitives[0].uvs[1].x, 0.25f);
  // Faces first; strips, parted by -1.
  const SourceScene turned = importText(
      "turned.ply", "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\n" +
                        quad.substr(quad.find("element")) + "end_header\n4 0 1 2 3\n" + places);
  EXPECT_NEAR(area(turned), 1.0, 1e-9);
  const SourceScene strips = importText(
      "strips.ply", quad + "element tristrips 1\nproperty list int int vertex_indices\nend_header\n" +
                        places + "8 0 1 3 2 -1 2 3 1\n");
  EXPECT_THAT(strips.primitives[0].indices, ElementsAre(0, 1, 3, 3, 1, 2, 2, 3, 1));
  EXPECT_THAT(
      refusalOf("flat.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nelement face 1\n" +
                                kPlyList + "0\n3 0 0 0\n"),
      HasSubstr("x, y and z"));
}

TEST(Import, BinaryPly) {
  std::string big =
      "ply\nformat binary_big_endian 1.0\nobj_info element end_header\nelement vertex 3\nproperty float x\n"
      "property double y\nproperty float z\nproperty float s\nproperty float t\nelement face 1\n" +
      kPlyList;
  const auto append = [&big](auto value) {
    const char* bytes = reinterpret_cast<const char*>(&value);
    for (size_t i = sizeof value; i-- > 0;) big.push_back(bytes[i]);
  };
  for (int v = 0; v < 3; ++v) {
    append(static_cast<float>(v));
    append(static_cast<double>(v * v));
    append(3.0f);
    append(0.25f);
    append(0.5f * static_cast<float>(v));
  }
  append(uint8_t{3});
  for (const int32_t i : {2, 1, 0}) append(i);
  const SourceScene big_endian = importText("big.ply", big);
  EXPECT_THAT(big_endian.primitives[0].indices, ElementsAre(2, 1, 0));
  EXPECT_EQ(big_endian.primitives[0].positions[2], glm::vec3(2, 4, 3));
  EXPECT_EQ(big_endian.primitives[0].uvs[2], glm::vec2(0.25, 0));

  // Integer positions, of every width, and in text.
  std::string whole =
      big.substr(0, big.find("element vertex")) +
      "element vertex 3\nproperty uchar x\nproperty short y\nproperty int z\nelement face 1\n" + kPlyList;
  std::swap(whole, big);
  for (const int v : {200, 100, 0}) {
    append(static_cast<uint8_t>(v));
    append(static_cast<int16_t>(-v));
    append(int32_t{70000} * (v == 100));
  }
  append(uint8_t{3});
  for (const int32_t i : {2, 1, 0}) append(i);
  EXPECT_EQ(importText("whole.ply", big).primitives[0].positions[0], glm::vec3(200, -200, 0));
  EXPECT_EQ(importText("whole.ply", big).primitives[0].positions[1], glm::vec3(100, -100, 70000));
  EXPECT_EQ(importText("text.ply",
                       "ply\nformat ascii 1.0\nelement vertex 3\nproperty int x\nproperty uchar y\n"
                       "property char z\nelement face 1\n" +
                           kPlyList + "0 0 0\n-70000 255 -1\n0 1 0\n3 0 1 2\n")
                .primitives[0]
                .positions[1],
            glm::vec3(-70000, 255, -1));
}

TEST(Import, Off) {
  const std::string off = "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3";
  EXPECT_EQ(count(importText("square.off", off + "\n")), (Counts{4, 2, 1, 0, 0, 0}));
  EXPECT_EQ(count(importText("unended.off", off)), (Counts{4, 2, 1, 0, 0, 0}));
  EXPECT_THAT(refusalOf("cut.off", off.substr(0, 40)), HasSubstr("cut off"));
  EXPECT_THAT(refusalOf("binary.off", "OFF BINARY\n"), HasSubstr("binary OFF"));
  EXPECT_THAT(refusalOf("any.off", "nOFF\n3\n" + off.substr(4)), HasSubstr("nOFF"));
  const std::pair<const char*, std::string> variants[] = {
      {"line.off", "OFF 4 2 0\n" + off.substr(10)},
      {"comments.off", "OFF # a square\n# by hand\n\n4 2 0 # counts\n" + off.substr(10)},
      {"comment_first.off", "# a square\n\n" + off},
      {"nameless.off", "# a square\n" + off.substr(4)},
      {"no_edges.off", "OFF\n4 2\n" + off.substr(10)},
      {"count_lines.off", "OFF\n4 # vertices\n2\n\n0\n" + off.substr(10)},
      {"two_lines.off", "OFF\n4\n2 0\n" + off.substr(10)},
      {"two_counts.off", "OFF\r\n4\r\n2\r\n" + off.substr(10, 24) + "3 0 1 2 255 0 0\n3 0 2 3 0 0 255\n"},
      {"face_colors.off", off.substr(0, off.find("3 0 1 2")) + "3 0 1 2 255 0 0\n3 0 2 3 0.1 0.2 0.3 1\n"},
      {"colors.off",
       "COFF\n4 2 0\n0 0 0 255 0 0 255\n1 0 0 255 0 0 255\n1 1 0 255 0 0 255\n"
       "0 1 0 0 0 51 255\n3 0 1 2\n3 0 2 3\n"},
      {"normals.off", "NOFF\n4 2 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n1 1 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n3 0 2 3\n"},
      {"crlf.off", "OFF\r\n4 2 0\r\n0 0 0\r\n1 0 0\r\n1 1 0\r\n0 1 0\r\n3 0 1 2\r\n3 0 2 3\r\n"}};
  for (const auto& [name, text] : variants) {
    SCOPED_TRACE(name);
    const SourceScene square = importText(name, text);
    EXPECT_EQ(count(square), (Counts{4, 2, 1, 0, 0, 0}));
    EXPECT_NEAR(area(square), 1.0, 1e-9);
  }
}

TEST(Import, Stl) {
  const std::string stl =
      "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
      "endfacet\nendsolid s\n";
  EXPECT_EQ(count(importText("text.stl", stl)), (Counts{3, 1, 1, 0, 0, 0}));
  for (const auto& [from, to, fault] : {std::tuple{"endfacet\nendsolid s\n", "", "endsolid"},
                                        {"endsolid s\n", "", "endsolid"},
                                        {"vertex 1 0 0\n", "", "2 vertices"},
                                        {"vertex 1 0 0\n", "vertex nan 0 0\n", "three numbers"},
                                        {"vertex 1 0 0\n", "vertex 1 0\n", "three numbers"}}) {
    std::string broken = stl;
    broken.replace(broken.find(from), std::strlen(from), to);
    EXPECT_THAT(refusalOf("broken.stl", broken), HasSubstr(fault));
  }
  std::string returns = stl;
  std::replace(returns.begin(), returns.end(), '\n', '\r');
  EXPECT_EQ(count(importText("returns.stl", returns)), (Counts{3, 1, 1, 0, 0, 0}));
  std::string binary(80, ' ');
  binary.append("\x01\0\0\0", 4);
  const float corners[12] = {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0};
  binary.append(reinterpret_cast<const char*>(corners), sizeof corners).append(2, '\0');
  EXPECT_EQ(count(importText("binary.stl", binary)), (Counts{3, 1, 1, 0, 0, 0}));
  EXPECT_EQ(count(importText("grown.stl", binary + "xx")), (Counts{3, 1, 1, 0, 0, 0}));
  binary.replace(0, 12, "solid binary");
  EXPECT_EQ(count(importText("solid.stl", binary)), (Counts{3, 1, 1, 0, 0, 0}));
  EXPECT_EQ(count(importText("solid_grown.stl", binary + "xx")), (Counts{3, 1, 1, 0, 0, 0}));
  EXPECT_THAT(refusalOf("cut.stl", binary.substr(0, 120)), HasSubstr("cut off"));
}

TEST(ImportCorpus, KnownCounts) {
  SKIP_WITHOUT("MANIFEST.md");
  const std::pair<const char*, Counts> known[] = {
      {"face/ict_facekit_generic_55targets.glb", {28911, 52220, 12, 55, 0, 1}},
      {"face/makehuman_body_34targets_skinned.glb", {14517, 26756, 1, 34, 53, 0}},
      {"face/leeperrysmith/LeePerrySmith.glb", {9223, 17684, 1, 0, 0, 0}},
      {"face/valid/Asian_F_1_Casual_decoded.glb", {31836, 58724, 7, 96, 114, 0}},
      {"face/valid/Asian_F_1_Casual.glb", {31836, 58724, 7, 96, 114, 0}},
      {"skinned/CesiumMan.glb", {3273, 4672, 1, 0, 19, 1}},
      {"skinned/simple_skin/simple_skin.gltf", {10, 8, 1, 0, 2, 1}},
      {"skinned/03_all_animations/03_all_animations.gltf", {518, 976, 3, 0, 0, 3}},
      {"skinned/03_skinned_cylinder/03_skinned_cylinder.gltf", {750, 316, 1, 0, 4, 1}},
      {"morph/SimpleMorph/SimpleMorph.gltf", {3, 1, 1, 2, 0, 1}},
      {"morph/MorphStressTest/MorphStressTest.gltf", {1528, 2412, 2, 8, 0, 3}},
      {"morph/AnimatedMorphCube/AnimatedMorphCube.gltf", {24, 12, 1, 2, 0, 1}},
      {"garment/SheenCloth.glb", {58081, 115200, 1, 0, 0, 0}},
      {"garment/codimipc/skirt4K.obj", {4004, 7496, 1, 0, 0, 0}},
      {"odd/SimpleSparseAccessor/SimpleSparseAccessor.gltf", {14, 12, 1, 0, 0, 0}},
      {"odd/mesh_formats/assimp/cube_binary.ply", {8, 12, 1, 0, 0, 0}},
      {"odd/mesh_formats/draco/non_manifold_wrap.obj", {10, 12, 1, 0, 0, 0}},
  };
  for (const auto& [file, counts] : known) EXPECT_EQ(count(import(corpus(file))), counts) << file;
  EXPECT_EQ(import(corpus("face/ict_facekit/generic_neutral_mesh.obj")).materials.size(), 12u);
}

TEST(ImportCorpus, EveryFileIsReadOrRefused) {
  SKIP_WITHOUT("MANIFEST.md");
  size_t read = 0, refused = 0;
  for (const auto& entry : fs::recursive_directory_iterator(corpus(""))) {
    if (!entry.is_regular_file()) continue;
    const std::string folder = fs::relative(entry.path(), corpus("")).begin()->string();
    const std::string extension = entry.path().extension().string();
    const bool model =
        std::string(" .gltf .glb .obj .ply .stl .off ").find(" " + extension + " ") != std::string::npos;
    const bool must =
        model && (folder == "face" || folder == "morph" || folder == "skinned" || folder == "garment");
    try {
      const SourceScene scene = import(entry.path());
      SCOPED_TRACE(entry.path());
      expectSound(scene);
      ++read;
    } catch (const Error& e) {
      EXPECT_FALSE(must) << e.what();
      ++refused;
    }
  }
  EXPECT_GT(read, 60u);
  EXPECT_GT(refused, 60u);
}

struct Box {
  glm::dvec3 low{1e30}, high{-1e30};
};
Box posedBox(const SourceScene& scene) {
  Box box;
  const PosedRig rest = evaluate(scene.rig, defaultPose(scene.rig));
  for (const Part& part : scene.parts)
    for (const glm::dvec3& p : posePart(scene, part, rest)) {
      box.low = glm::min(box.low, p);
      box.high = glm::max(box.high, p);
    }
  return box;
}

TEST(ImportCorpus, DracoHoldsTheSameSurface) {
  SKIP_WITHOUT("face/leeperrysmith/LeePerrySmith.glb");
  const SourceScene packed = import(corpus("face/leeperrysmith/LeePerrySmith.glb"));
  const SourceScene plain = import(corpus("face/leeperrysmith/LeePerrySmith_decoded.glb"));
  const Box a = posedBox(packed), b = posedBox(plain);
  const double diagonal = glm::length(b.high - b.low);
  EXPECT_LT(glm::length(a.low - b.low), 1e-6 * diagonal);
  EXPECT_LT(glm::length(a.high - b.high), 1e-6 * diagonal);
  EXPECT_NEAR(area(packed), area(plain), 1e-6 * area(plain));
  EXPECT_EQ(packed.primitives[0].uvs.size(), plain.primitives[0].uvs.size());
}

TEST(ImportCorpus, MeshoptHoldsTheSameSurface) {
  SKIP_WITHOUT("face/valid/Asian_F_1_Casual.glb");
  const SourceScene packed = import(corpus("face/valid/Asian_F_1_Casual.glb"));
  const SourceScene plain = import(corpus("face/valid/Asian_F_1_Casual_decoded.glb"));
  const Box a = posedBox(packed), b = posedBox(plain);
  const double diagonal = glm::length(b.high - b.low);
  EXPECT_LT(glm::length(a.low - b.low), 1e-5 * diagonal);
  EXPECT_LT(glm::length(a.high - b.high), 1e-5 * diagonal);
  ASSERT_EQ(packed.parts.size(), plain.parts.size());
  const PosedRig packed_rest = evaluate(packed.rig, defaultPose(packed.rig));
  const PosedRig plain_rest = evaluate(plain.rig, defaultPose(plain.rig));
  for (size_t i = 0; i < plain.parts.size(); ++i) {
    EXPECT_EQ(packed.primitives[i].indices, plain.primitives[i].indices);
    const auto p = posePart(packed, packed.parts[i], packed_rest);
    const auto q = posePart(plain, plain.parts[i], plain_rest);
    ASSERT_EQ(p.size(), q.size());
    for (size_t v = 0; v < p.size(); ++v) ASSERT_LT(glm::length(p[v] - q[v]), 1e-5 * diagonal);
  }
}

}  // namespace
}  // namespace furrow::pipeline
