// What `furrow export` writes is the asset: read again by our own importer, it poses to the same vertices and
// carries the same values.

#include <cmath>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <set>

#include "furrow/asset.h"
#include "furrow/jobs.h"
#include "pipeline/import/import.h"
#include "pipeline/maps/png.h"
#include "pipeline/pack/rig_section.h"
#include "pipeline/scene/posing.h"
#include "tests/cli/tool.h"
#include "tests/unit/texture_decoder.h"
#include "tests/unit/textured_square.h"

namespace furrow::test {
namespace {

using nlohmann::json;
using pipeline::PosedRig;
using pipeline::Rig;
using pipeline::SourceScene;

class Export : public ToolTest {
 protected:
  void exportAsset(const std::filesystem::path& source, const std::vector<std::string>& options = {}) {
    const std::filesystem::path cooked = output() / "a.furrow";
    std::vector<std::string> words = {"cook", source, "-o", cooked, "--quiet"};
    words.insert(words.end(), options.begin(), options.end());
    const Outcome cook = run(words);
    ASSERT_EQ(cook.status, 0) << cook.err;
    exportCooked(cooked);
  }

  void exportCooked(const std::filesystem::path& cooked) {
    const std::filesystem::path exported = output() / "a.glb";
    const Outcome outcome = run({"export", cooked, "-o", exported});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(outcome.out + outcome.err, "");
    const std::string bytes = readText(cooked);
    ASSERT_TRUE(asset_.load(std::as_bytes(std::span(bytes))).ok());
    rig_ = pipeline::readRig(asset_.view());
    scene_ = pipeline::import(exported);
    glb_ = readText(exported);
    uint32_t length = 0;
    std::memcpy(&length, glb_.data() + 12, 4);
    gltf_ = json::parse(glb_.substr(20, length));
    bin_ = 20 + length + 8;
  }

  const AssetView& asset() const { return asset_.view(); }

  std::vector<glm::dvec3> posedAsset(const PosedRig& pose) const {
    std::vector<Affine> palette(pose.palette.size());
    for (size_t i = 0; i < palette.size(); ++i)
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 4; ++c) palette[i].m[4 * r + c] = static_cast<float>(pose.palette[i][c][r]);
    const std::vector<float> weights(pose.morph_weights.begin(), pose.morph_weights.end());
    std::vector<Float3> positions(asset().vertexCount());
    DeformJob{&asset(), palette, weights, positions, {}, {}}.run(0, asset().vertexCount());
    std::vector<glm::dvec3> all;
    for (const Float3& p : positions) all.emplace_back(p.x, p.y, p.z);
    return all;
  }

  std::vector<glm::dvec3> posedExport(const PosedRig& pose) const {
    std::vector<glm::dvec3> all;
    for (const pipeline::Part& part : scene_.parts)
      for (const glm::dvec3& p : pipeline::posePart(scene_, part, pose)) all.push_back(p);
    return all;
  }

  void expectSamePose(const PosedRig& mine, const PosedRig& theirs, const std::string& which) const {
    const std::vector<glm::dvec3> a = posedAsset(mine), b = posedExport(theirs);
    ASSERT_EQ(a.size(), b.size());
    glm::dvec3 low(INFINITY), high(-INFINITY);
    for (const glm::dvec3& p : a) {
      low = glm::min(low, p);
      high = glm::max(high, p);
    }
    double most = 0.0;
    for (size_t v = 0; v < a.size(); ++v) most = std::max(most, glm::distance(a[v], b[v]));
    EXPECT_LE(most, 3e-6 * glm::distance(low, high) + 1e-6 * glm::length(high)) << which;
  }

  void expectSamePoses() const {
    const pipeline::Pose rest = pipeline::defaultPose(rig_),
                         exported_rest = pipeline::defaultPose(scene_.rig);
    expectSamePose(pipeline::evaluate(rig_, rest), pipeline::evaluate(scene_.rig, exported_rest),
                   "default pose");
    ASSERT_EQ(scene_.rig.clips.size(), rig_.clips.size());
    for (size_t c = 0; c < rig_.clips.size(); ++c)
      for (const double part : {0.0, 0.31, 0.77, 1.0}) {
        const double time = part * rig_.clips[c].duration;
        pipeline::Pose pose = rest, exported = exported_rest;
        pipeline::applyClip(rig_, rig_.clips[c], time, pose);
        pipeline::applyClip(scene_.rig, scene_.rig.clips[c], time, exported);
        EXPECT_EQ(scene_.rig.clips[c].name, rig_.clips[c].name);
        expectSamePose(pipeline::evaluate(rig_, pose), pipeline::evaluate(scene_.rig, exported),
                       rig_.clips[c].name + " at " + std::to_string(time));
      }
    std::set<std::string> names;
    for (const pipeline::MorphTarget& morph : rig_.morphs) names.insert(morph.name);
    for (const std::string& name : names) {
      PosedRig mine = pipeline::evaluate(rig_, rest), theirs = pipeline::evaluate(scene_.rig, exported_rest);
      const auto raise = [&](const Rig& rig, PosedRig& pose) {
        for (size_t m = 0; m < rig.morphs.size(); ++m)
          if (rig.morphs[m].name == name) pose.morph_weights[m] = 1.0;
      };
      raise(rig_, mine);
      raise(scene_.rig, theirs);
      EXPECT_NE(mine.morph_weights, std::vector<double>(mine.morph_weights.size(), 0.0));
      expectSamePose(mine, theirs, "morph target " + name);
    }
  }

  // An attribute of every vertex; none if a primitive lacks it.
  std::vector<float> attribute(const std::string& name) const {
    std::vector<float> values;
    for (const pipeline::Part& part : scene_.parts)
      for (const pipeline::Attribute& a : scene_.primitives[part.primitive].attributes)
        if (a.name == name) values.insert(values.end(), a.values.begin(), a.values.end());
    return values;
  }

  pipeline::ByteImage image(const json& texture) const {
    const json& image = gltf_["images"][gltf_["textures"][texture.get<size_t>()]["source"].get<size_t>()];
    EXPECT_EQ(image["mimeType"], "image/png");
    const json& view = gltf_["bufferViews"][image["bufferView"].get<size_t>()];
    return pipeline::readByteImage(write("image.png", glb_.substr(bin_ + view.value("byteOffset", size_t{0}),
                                                                  view["byteLength"].get<size_t>())));
  }

  // The maps of a texture set are those that its material names.
  void expectMaps(const TextureSet& set, const json& material) const {
    const auto owned = [](const Texture& t) {
      return pipeline::EncodedTexture{t.format, t.width,  t.height,
                                      t.slices, t.levels, {t.data.begin(), t.data.end()}};
    };
    const json& layers = material["extras"]["furrow"]["layers"];
    ASSERT_EQ(layers.size(), asset().layerCount());
    for (uint32_t l = 0; l < asset().layerCount(); ++l) {
      EXPECT_EQ(layers[l]["name"], asset().layers[l].name);
      if (set.compress_slice[l] != kAbsent) {
        const uint32_t slice = set.compress_slice[l];
        const pipeline::Image slopes = pipeline::decode(owned(set.normals), 0, slice);
        const pipeline::ByteImage normals = image(layers[l]["compress"]["normal"]);
        ASSERT_EQ(normals.width, slopes.width);
        ASSERT_EQ(normals.channels, 3u);
        for (uint32_t y = 0; y < slopes.height; ++y)
          for (uint32_t x = 0; x < slopes.width; ++x)
            for (uint32_t c = 0; c < 2; ++c)
              ASSERT_NEAR(static_cast<float>(normals.at(x, y)[c]) / 255.0f, slopes.at(x, y)[c],
                          0.5001f / 255.0f);
        EXPECT_EQ(image(layers[l]["compress"]["shading"]).channels, 1u);
        EXPECT_EQ(layers[l]["compress"]["scale"][0].get<float>(), set.windows[slice].z);
      }
      if (set.masks.slices > 0) {
        const json& mask = layers[l]["mask"];
        const pipeline::ByteImage masks = image(mask["texture"]);
        const size_t channel = std::string("rgba").find(mask["channel"].get<std::string>());
        const auto* stored =
            reinterpret_cast<const uint8_t*>(set.masks.data.data()) +
            size_t{4} * set.masks.width * set.masks.height * (asset().layers[l].mask_slice / 4);
        ASSERT_EQ(masks.pixels.size(), size_t{4} * set.masks.width * set.masks.height);
        for (size_t i = channel; i < masks.pixels.size(); i += 4) ASSERT_EQ(masks.pixels[i], stored[i]);
      }
    }
  }

  // The model's own colours and normals are the materials' textures.
  void expectBaseMaps() const {
    ASSERT_EQ(scene_.parts.size(), asset().parts.size());
    for (size_t p = 0; p < scene_.parts.size(); ++p) {
      if (asset().parts[p].base_maps == kAbsent) continue;
      const BaseMaps& maps = asset().base_maps[asset().parts[p].base_maps];
      const pipeline::MaterialMaps& written = scene_.materials.at(scene_.parts[p].material).maps;
      EXPECT_FLOAT_EQ(written.opaque_from, maps.opaque_from);
      const auto expectImage = [&](const Texture& texture, const pipeline::MaterialMap& map,
                                   const float(&uv)[6]) {
        ASSERT_EQ(map.image == pipeline::kNoIndex, texture.slices == 0);
        if (texture.slices == 0) return;
        for (int i = 0; i < 6; ++i) EXPECT_NEAR(map.uv[i / 2][i % 2], uv[i], 1e-5f) << i;
        const pipeline::ByteImage image = pipeline::readByteImage(scene_.images[map.image].bytes, "image");
        ASSERT_EQ(image.width, texture.width);
        ASSERT_EQ(image.channels, texture.format == TextureFormat::kBc3 ? 4u : 3u);
        const bool normals = texture.format == TextureFormat::kBc5;
        for (uint32_t y = 0; y < image.height; y += 3)
          for (uint32_t x = 0; x < image.width; x += 3) {
            const Float4 texel = texelAt(texture, 0, 0, x, y);
            const float stored[] = {texel.x, texel.y, texel.z, texel.w};
            for (uint32_t c = 0; c < (normals ? 2 : image.channels); ++c)
              ASSERT_NEAR(static_cast<float>(image.at(x, y)[c]) / 255.0f, stored[c], 0.5001f / 255.0f);
          }
      };
      expectImage(maps.color, written.color, maps.color_uv);
      expectImage(maps.normal, written.normal, maps.normal_uv);
    }
  }

  void expectValues() const {
    const std::vector<float> points = attribute("_POINT");
    ASSERT_EQ(points.size(), asset().vertexCount());
    for (size_t v = 0; v < points.size(); ++v)
      ASSERT_EQ(points[v], static_cast<float>(asset().vertex_point[v]));
    for (const Layer& layer : asset().layers) {
      std::string name(layer.name);
      std::transform(name.begin(), name.end(), name.begin(),
                     [](char c) { return static_cast<char>(std::toupper(c)); });
      const auto expectStored = [&](const std::string& kind, const auto& stored, float one) {
        const std::vector<float> values = attribute(kind + name);
        ASSERT_EQ(values.size(), stored.empty() ? 0u : asset().vertexCount()) << kind << name;
        for (size_t v = 0; v < values.size(); ++v)
          ASSERT_FLOAT_EQ(values[v], static_cast<float>(stored[v]) / one);
      };
      if (!layer.mask.empty()) expectStored("_MASK_", layer.mask, 255.0f);
      expectStored("_BIAS_", layer.bias, 32767.0f);
      const std::vector<float> weights = attribute("_WEIGHT_" + name);
      ASSERT_EQ(weights.size(), asset().vertexCount());
      ASSERT_GE(layer.response.lambda, 1.0f) << "wrinkles nothing at rest by itself";
      for (size_t v = 0; v < weights.size(); ++v)
        ASSERT_NEAR(weights[v], layer.bias.empty() ? 0.0f : static_cast<float>(layer.bias[v]) / 32767.0f,
                    1e-4f);
      const std::vector<float> directions = attribute("_DIRECTION_" + name),
                               sure = attribute("_CONFIDENCE_" + name);
      ASSERT_EQ(directions.size(), 3 * asset().vertexCount());
      for (size_t v = 0; v < asset().vertexCount(); ++v) {
        const int8_t* d = &layer.directions[size_t{4} * asset().vertex_point[v]];
        const glm::vec3 stored(d[0], d[1], d[2]),
            written(directions[3 * v], directions[3 * v + 1], directions[3 * v + 2]);
        ASSERT_NEAR(glm::length(written), stored == glm::vec3(0.0f) ? 0.0f : 1.0f, 1e-5f);
        ASSERT_NEAR(glm::dot(written, stored), glm::length(stored), 1e-3f);
        ASSERT_FLOAT_EQ(sure[v], static_cast<float>(d[3]) / 127.0f);
      }
    }
  }

  Asset asset_;
  Rig rig_;
  SourceScene scene_;
  std::string glb_;
  json gltf_;
  size_t bin_ = 0;  // where the buffer begins
};

TEST_F(Export, OfTheFaceIsTheFace) {
  const std::filesystem::path content = FURROW_CONTENT;
  exportAsset(content / "face.glb", {"--recipe", content / "face.json"});
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_EQ(scene_.warnings, std::vector<std::string>{});
  EXPECT_GT(rig_.morphs.size(), 10u);
  expectSamePoses();
  expectValues();
  EXPECT_EQ(gltf_["extras"]["furrow"]["layers"][0]["name"], asset().layers[0].name);
  for (const Part& part : asset().parts)
    if (part.texture_set != kAbsent)
      for (const json& material : gltf_["materials"])
        if (material["name"] == part.material) expectMaps(asset().texture_sets[part.texture_set], material);
  EXPECT_FALSE(asset().base_maps.empty());
  expectBaseMaps();
}

// OBJ names may be of any encoding, and the file's too.
TEST_F(Export, OfNamesThatAreNoUtf8) {
  exportAsset(write("M\xfcller.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl H\xe4ut\nf 1 2 3\n"));
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_EQ(gltf_["materials"][0]["name"], "H\uFFFDut");
  EXPECT_EQ(gltf_["meshes"][0]["name"], "M\uFFFDller");
  expectSamePoses();
}

TEST_F(Export, KeepsColoursAndNormalsWhereTheyLie) {
  std::array<Color, 4> colors = kQuadrants;
  colors[1][3] = 0;
  const auto png = [&](uint32_t channels) {
    const std::vector<std::byte> bytes = pipeline::encodePng(quadrants(channels, colors));
    const auto* begin = reinterpret_cast<const uint8_t*>(bytes.data());
    return std::vector<uint8_t>(begin, begin + bytes.size());
  };
  Square square;
  const std::string images = square.embedded(png(4)) + "},{" + square.embedded(png(3));
  exportAsset(square.write(
      "own.glb", images, "\"source\":0},{\"source\":1",
      R"("alphaMode":"MASK","alphaCutoff":0.25,"pbrMetallicRoughness":{"baseColorTexture":{"index":0,"extensions":)"
      R"({"KHR_texture_transform":{"offset":[0.25,0.5],"rotation":2.5,"scale":[2,-3]}}}},)"
      R"("normalTexture":{"index":1,"extensions":{"KHR_texture_transform":{"scale":[-1,0.5]}}})"));
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_EQ(scene_.warnings, std::vector<std::string>{});
  EXPECT_EQ(asset().base_maps[0].opaque_from, 0.25f);
  EXPECT_EQ(asset().base_maps[0].normal.slices, 1u);
  expectBaseMaps();
}

TEST_F(Export, OfTheSleeveBendsAsTheSleeve) {
  exportCooked(FURROW_SLEEVE);  // cooked by the build
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_FALSE(rig_.clips.empty());
  EXPECT_FALSE(gltf_["skins"].empty());
  expectSamePoses();
  expectValues();
}

// Two meshes of several targets each under nodes with scales, one clip that moves both and their nodes.
TEST_F(Export, OfSeveralMorphedMeshesKeepsTheirClips) {
  GltfBuilder builder;
  builder.add(std::vector<float>{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, "VEC3", 3);
  builder.add(std::vector<uint16_t>{0, 1, 2, 0, 2, 3}, "SCALAR", 1);
  builder.add(std::vector<float>{-0.5f, 0, 0, 0, 0, 0, 0, 0, 0, -0.5f, 0, 0}, "VEC3", 3);
  builder.add(std::vector<float>{0, 0.25f, 0, 0, 0.25f, 0, 0, 0, 0, 0, 0, 0}, "VEC3", 3);
  builder.add(std::vector<float>(12, 0.0f), "VEC3", 3);  // a target that moves nothing
  builder.add(std::vector<float>{0, 1, 2}, "SCALAR", 1);
  builder.add(std::vector<float>{0, 0, 0, 1, 0.5f, 0.3f, 0, 1, 0.7f}, "SCALAR", 1);
  builder.add(std::vector<float>{0, 0, 0, 1, 2, 3, 0, 0, 0}, "VEC3", 3);
  const std::string mesh =
      R"({"name":"M","extras":{"targetNames":["one","none","two"]},"weights":[0.25,0,0],"primitives":[)"
      R"({"attributes":{"POSITION":0},"indices":1,"targets":[{"POSITION":2},{"POSITION":4},{"POSITION":3}]}]})";
  const auto source = write(
      "two.glb",
      builder.glb(
          R"("scene":0,"scenes":[{"nodes":[0,1]}],"nodes":[)"
          R"({"mesh":0,"scale":[2,1,-1]},{"children":[2],"matrix":[0,1,0,0,-1,0,0,0,0,0,1,0,5,0,0,1]},{"mesh":1,"translation":[0,0,3]}],)"
          R"("meshes":[)" +
          mesh + ',' + mesh +
          R"(],"animations":[{"name":"both","samplers":[{"input":5,"output":6},{"input":5,"output":6,"interpolation":"STEP"},{"input":5,"output":7}],)"
          R"("channels":[{"sampler":0,"target":{"node":0,"path":"weights"}},{"sampler":1,"target":{"node":2,"path":"weights"}},{"sampler":2,"target":{"node":2,"path":"translation"}}]}])"));
  exportAsset(source,
              {"--recipe", write("plain.json", R"({"layers": [{"name": "the one"}, {"name": "The-One"}]})")});
  ASSERT_FALSE(HasFatalFailure());
  ASSERT_EQ(rig_.morphs.size(), 6u);
  EXPECT_EQ(scene_.rig.morphs.size(), 6u);
  EXPECT_EQ(scene_.rig.morphs[0].default_weight, 0.25);
  expectSamePoses();
  // Two layers whose names come to the same attribute.
  EXPECT_EQ(gltf_["extras"]["furrow"]["layers"][0]["attributes"], "_*_THE_ONE");
  EXPECT_EQ(gltf_["extras"]["furrow"]["layers"][1]["attributes"], "_*_THE_ONE_");
  EXPECT_EQ(attribute("_MASK_THE_ONE_").size(), asset().vertexCount());
}

// COLOR_0 is linear in glTF; an asset keeps square roots.
TEST_F(Export, OfColoursKeepsTheirLight) {
  const std::vector<float> colors = {0.5f, 0.02f, 1,    1, 0.25f, 0,    0.7f,  1,
                                     1,    0.1f,  0.3f, 1, 0.8f,  0.6f, 0.04f, 1};
  GltfBuilder builder;
  builder.add(std::vector<float>{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, "VEC3", 3);
  builder.add(std::vector<uint16_t>{0, 1, 2, 0, 2, 3}, "SCALAR", 1);
  builder.add(colors, "VEC4", 4);
  exportAsset(write(
      "colours.glb",
      builder.glb(R"("scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
                  R"("meshes":[{"primitives":[{"attributes":{"POSITION":0,"COLOR_0":2},"indices":1}]}])")));
  ASSERT_FALSE(HasFatalFailure());
  const std::vector<float> exported = attribute("COLOR_0");
  ASSERT_EQ(exported.size(), colors.size());
  for (size_t i = 0; i < colors.size(); ++i)
    EXPECT_NEAR(std::sqrt(exported[i]), std::sqrt(colors[4 * asset().source_vertex[i / 4] + i % 4]),
                0.51f / 255.0f);
}

TEST_F(Export, OfRealFilesPosesAsTheyDo) {
  size_t count = 0;
  const std::filesystem::path plain =
      write("plain.json", R"({"layers": [{"name": "a", "compress": "none"}]})");
  for (const char* name : {"skinned", "morph"}) {
    const std::filesystem::path corpus = std::filesystem::path(FURROW_CORPUS) / name;
    if (!std::filesystem::exists(corpus)) continue;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(corpus)) {
      const std::string extension = entry.path().extension();
      if ((extension != ".glb" && extension != ".gltf") || entry.file_size() > 600000) continue;
      SCOPED_TRACE(entry.path());
      exportAsset(entry.path(), {"--recipe", plain});
      ASSERT_FALSE(HasFatalFailure());
      expectSamePoses();
      ++count;
    }
  }
  if (count == 0) GTEST_SKIP() << "no corpus";
}

TEST_F(Export, RefusesWhatItCannotDo) {
  const std::filesystem::path source = std::filesystem::path(FURROW_CONTENT) / "sleeve.glb";
  expectRefused(run({"export", source, "-o", output() / "a.gltf"}), 2, "a name that ends in .glb");
  expectRefused(run({"export", source, "-o", source}), 2, "overwrite");
  expectRefused(run({"export", source}), 2, "--output");
  expectRefused(run({"export", folder() / "none.furrow", "-o", output() / "a.glb"}), 1, "none.furrow: ");
  expectRefused(run({"export", source, "-o", folder() / "no/a.glb"}), 3, "no/a.glb: cannot be written");
}

}  // namespace
}  // namespace furrow::test
