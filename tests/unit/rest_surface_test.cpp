// What the loader works out of the surface at rest, and the directions it does so from.

#include "rest_surface.h"

#include <gtest/gtest.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <numbers>
#include <string_view>

#include "asset_header.h"
#include "direction_codec.h"
#include "furrow_generated.h"
#include "sheets.h"

namespace furrow::tests {
namespace {

struct Triangles {
  std::vector<Float3> points;
  std::vector<uint32_t> indices, vertex_point;

  explicit Triangles(std::vector<Float3> at, std::vector<uint32_t> corners)
      : points(std::move(at)), indices(std::move(corners)) {
    for (uint32_t p = 0; p < points.size(); ++p) vertex_point.push_back(p);
  }
  RestSurface view() const { return {points, indices, vertex_point}; }
};

// A fan about point 0 with spokes at these angles, of these lengths.
Triangles fan(const std::vector<double>& angles, float length = 1.0f) {
  std::vector<Float3> points = {{0, 0, 0}};
  std::vector<uint32_t> indices;
  for (size_t i = 0; i < angles.size(); ++i) {
    const double r = double{length} * (1.0 + 0.3 * static_cast<double>(i % 3));
    points.push_back(
        {static_cast<float>(r * std::cos(angles[i])), static_cast<float>(r * std::sin(angles[i])), 0.0f});
    if (i > 0) indices.insert(indices.end(), {0u, static_cast<uint32_t>(i), static_cast<uint32_t>(i + 1)});
  }
  return Triangles(points, indices);
}

TEST(Rings, WeighByTheAngle) {
  const std::vector<double> angles = {0.0, 0.004, 0.5, 1.3, 2.5, 4.6, 6.1};  // slivers and an obtuse corner
  const Triangles surface = fan(angles);
  const Rings rings = makeRings(surface.view());
  ASSERT_EQ(rings.offsets[1], angles.size() - 1);
  uint32_t sum = 0;
  for (uint32_t i = 0; i < rings.offsets[1]; ++i) {
    EXPECT_EQ(rings.triangles[i], i);
    EXPECT_NEAR(rings.weights[i], 65535.0 * (angles[i + 1] - angles[i]) / angles.back(), 1.0) << i;
    sum += rings.weights[i];
  }
  EXPECT_EQ(sum, 65535u);
}

TEST(Rings, NeedlesAndRepeatedCornersAreInNone) {
  const Triangles surface({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.5f, 1e-4f, 0}}, {0, 1, 2, 0, 1, 3, 1, 1, 2});
  const Rings rings = makeRings(surface.view());
  EXPECT_EQ(rings.offsets, (std::vector<uint32_t>{0, 1, 2, 3, 3}));
  EXPECT_EQ(rings.triangles, (std::vector<uint32_t>{0, 0, 0}));
}

// Positions of a hostile file: everything a float can hold.
TEST(Rings, ExtremePositionsGiveFiniteNumbers) {
  const float huge = std::numeric_limits<float>::max(), tiny = std::numeric_limits<float>::denorm_min();
  for (const float size : {huge, 1e30f, 1e-30f, tiny}) {
    const Triangles surface({{-size, 0, 0}, {size, 0, 0}, {0, size, -size}, {0, size, size}},
                            {0, 1, 2, 1, 0, 3, 0, 0, 1, 2, 3, 0});
    const Rings rings = makeRings(surface.view());
    for (size_t p = 0; p < 4; ++p) {
      uint32_t sum = 0;
      for (uint32_t i = rings.offsets[p]; i < rings.offsets[p + 1]; ++i) sum += rings.weights[i];
      EXPECT_TRUE(sum == 65535 || rings.offsets[p] == rings.offsets[p + 1]);
    }
    const std::vector<Float3> normals = pointNormals(surface.view());
    for (const Float3& n : normals) EXPECT_NEAR(std::hypot(n.x, n.y, n.z), 1.0, 1e-6);
    for (const Measure measure : {Measure::kDirectional, Measure::kArea, Measure::kPrincipal}) {
      std::vector<float> out(4 * coefficientCount(measure), NAN);
      makeCoefficients(surface.view(), measure, normals, 0, 4, out);
      for (float value : out) EXPECT_TRUE(std::isfinite(value)) << size;
    }
  }
}

TEST(Coefficients, TakeTheDirectionToOne) {
  const Triangles surface({{1, 2, 3}, {2.5f, 2.25f, 3.5f}, {0.5f, 4, 2}}, {0, 1, 2});
  const Float3 a = surface.points[0], b = surface.points[1], c = surface.points[2];
  const std::vector<Float3> normals = pointNormals(surface.view());
  for (uint32_t code = 0; code < 65536; code += 97) {
    const Float3 d = decodeLine(normals[0], static_cast<uint16_t>(code)), minus = {-d.x, -d.y, -d.z};
    float k[2];
    makeCoefficients(surface.view(), Measure::kDirectional, std::vector<Float3>{d, minus, d}, 0, 1, k);
    const double u[3] = {double{k[0]} * (b.x - a.x) + double{k[1]} * (c.x - a.x),
                         double{k[0]} * (b.y - a.y) + double{k[1]} * (c.y - a.y),
                         double{k[0]} * (b.z - a.z) + double{k[1]} * (c.z - a.z)};
    EXPECT_NEAR(u[0] * u[0] + u[1] * u[1] + u[2] * u[2], 1.0, 1e-6);
    EXPECT_NEAR(std::abs(u[0] * d.x + u[1] * d.y + u[2] * d.z), 1.0, 1e-6);
  }
}

TEST(Coefficients, AreZeroWhereDirectionsCancelOut) {
  const Triangles surface({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 2});
  const float s = std::numbers::sqrt3_v<float> / 2;
  float k[2] = {1, 1};
  makeCoefficients(surface.view(), Measure::kDirectional,
                   std::vector<Float3>{{1, 0, 0}, {0.5f, s, 0}, {-0.5f, s, 0}}, 0, 1, k);
  EXPECT_EQ(k[0], 0.0f);
  EXPECT_EQ(k[1], 0.0f);
}

TEST(DirectionCodec, KeepsEveryLine) {
  double worst = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const double z = -1.0 + i / 999.5, around = 2.4 * i, r = std::sqrt(std::max(0.0, 1.0 - z * z));
    const glm::dvec3 n(r * std::cos(around), r * std::sin(around), z);
    const glm::dvec3 x =
        glm::normalize(glm::cross(n, std::abs(n.x) < 0.9 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
    const glm::dvec3 d = std::cos(0.7 * i) * x + std::sin(0.7 * i) * glm::cross(n, x);
    const Float3 normal = {static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)};
    const Float3 line = {static_cast<float>(d.x), static_cast<float>(d.y), static_cast<float>(d.z)};
    const uint16_t code = encodeLine(normal, line);
    EXPECT_EQ(encodeLine(normal, {-line.x, -line.y, -line.z}), code);
    const Float3 back = decodeLine(normal, code);
    worst = std::max(worst, glm::length(glm::cross(d, glm::dvec3(back.x, back.y, back.z))));
  }
  EXPECT_LT(worst, 3.2e-5);  // half a step where it is widest, 1 / 32768
}

// The cook fits responses with the coefficients that the loader will work out.
TEST(Loader, CoversThePartsOfALayer) {
  SourceScene scene = sceneOf(sheet(4), [](glm::dvec3 p) { return p; });
  scene.primitives.push_back(scene.primitives[0]);
  for (glm::vec3& p : scene.primitives[1].positions) p.z += 1.0f;
  scene.parts.push_back(scene.parts[0]);
  scene.parts[1].primitive = 1;
  scene.parts[1].mesh = "other";
  pipeline::LayerRecipe all = axisLayer({1, 0, 0}), one = axisLayer({1, 0, 0});
  one.name = "one";
  one.meshes = {"other"};
  const Asset asset = cookAsset(scene, recipeOf({all, one}));
  const auto layers = asset.view().layers;
  ASSERT_EQ(layers[0].coefficients.size(), 2 * 64u);
  for (size_t i = 0; i < 128; i += 2) {
    const bool zero = layers[1].coefficients[i] == 0.0f && layers[1].coefficients[i + 1] == 0.0f;
    EXPECT_EQ(zero, i < 64);
    EXPECT_EQ(layers[1].coefficients[i], zero ? 0.0f : layers[0].coefficients[i]);
  }
}

TEST(Loader, ARestThatIsNotTheBindPoseIsStored) {
  pipeline::Recipe recipe = recipeOf({axisLayer({1, 0, 0})});
  recipe.rest = pipeline::RestMorphs{{{"deform", 1.0}}};
  const Asset asset = cookAsset(
      sceneOf(sheet(6), [](glm::dvec3 p) { return glm::dvec3(0.5 * p.x, p.y, 0.1 * p.x); }), recipe);
  for (double alpha : evaluate(asset.view(), {1.0f}).alpha) EXPECT_NEAR(alpha, 1.0, 1e-3);
  for (double alpha : evaluate(asset.view(), {0.0f}).alpha) EXPECT_NEAR(alpha, 0.26, 1e-3);
}

// A cooked sheet with something wrong in it under a checksum that is right.
Status loadChanged(const std::function<void(format::Asset&)>& change,
                   pipeline::LayerRecipe layer = axisLayer({1, 0, 0}),
                   pipeline::GeometryCodec codec = pipeline::GeometryCodec::kDraco) {
  SourceScene scene = sceneOf(sheet(3), [](glm::dvec3 p) { return p * 0.9; });
  scene.primitives.push_back(scene.primitives[0]);
  scene.parts.push_back(scene.parts[0]);
  scene.parts[1].primitive = 1;
  scene.parts[1].mesh = "other";
  layer.meshes = {"other"};
  pipeline::CookOptions options;
  options.geometry = codec;
  std::vector<std::byte> file = pipeline::cook(scene, recipeOf({layer}), options).bytes;
  change(*flatbuffers::GetMutableRoot<format::Asset>(file.data() + sizeof(AssetHeader)));
  AssetHeader header;
  std::memcpy(&header, file.data(), sizeof header);
  header.payload_hash =
      XXH3_64bits_withSeed(file.data() + sizeof header, file.size() - sizeof header, header.version);
  std::memcpy(file.data(), &header, sizeof header);
  return Asset().load(file);
}

template <typename T>
T* changeable(const flatbuffers::Vector<T>* vector) {
  return const_cast<T*>(vector->data());
}

// Of a field that the table has; the generated code has no way to its bytes.
template <typename Table>
void setField(const Table* table, flatbuffers::voffset_t field, uint32_t value) {
  const auto* bytes = reinterpret_cast<const uint8_t*>(table);
  const uint8_t* fields = bytes - flatbuffers::ReadScalar<flatbuffers::soffset_t>(bytes);
  const auto at = flatbuffers::ReadScalar<flatbuffers::voffset_t>(fields + field);
  ASSERT_NE(at, 0);
  flatbuffers::WriteScalar(const_cast<uint8_t*>(bytes + at), value);
}

TEST(Loader, RefusesWhatNothingFollowsFrom) {
  EXPECT_TRUE(loadChanged([](format::Asset&) {}).ok());
  for (const uint32_t part : {2u, kAbsent})
    EXPECT_EQ(
        loadChanged([part](format::Asset& a) { changeable(a.layers()->Get(0)->parts())[0] = part; }).code,
        StatusCode::kBadData);
  EXPECT_EQ(loadChanged([](format::Asset& a) {
              for (int i = 0; i < 12; ++i) changeable(a.parts()->Get(0)->rest())[i] = 3e38f;
            }).code,
            StatusCode::kBadData);
  for (const float size : {0.0f, NAN, INFINITY})
    EXPECT_EQ(loadChanged([size](format::Asset& a) {
                std::fill_n(changeable(a.layers()->Get(0)->axis()), 3, size);
              }).code,
              StatusCode::kBadData);
  pipeline::LayerRecipe solved = axisLayer({1, 0, 0});
  solved.direction = pipeline::DirectionAnimation{};
  EXPECT_TRUE(loadChanged([](format::Asset&) {}, solved).ok());
  for (const uint8_t byte : {uint8_t{0}, uint8_t{0xff}})
    EXPECT_EQ(loadChanged(
                  [byte](format::Asset& a) {
                    const auto* bytes = a.layers()->Get(0)->directions()->data();
                    std::fill_n(changeable(bytes), bytes->size(), byte);
                  },
                  solved)
                  .code,
              StatusCode::kBadData);
}

// The first element of a stream, which those after it are told by, is off by some bits.
void shift(const format::Stream* stream) {
  const size_t bytes = stream->data()->size();
  const size_t at = stream->codec() == format::Codec::MeshoptVertex     ? bytes - stream->stride()
                    : stream->codec() == format::Codec::MeshoptSequence ? 1
                                                                        : 0;
  changeable(stream->data())[at] ^= 0x54;
}

const format::Attribute* attributeOf(const format::Asset& asset, format::Semantic semantic) {
  for (const format::Attribute* each : *asset.parts()->Get(0)->attributes())
    if (each->semantic() == semantic) return each;
  return nullptr;
}

TEST(Loader, SaysWhichNumberIsOutOfRange) {
  using format::Semantic;
  constexpr uint32_t kNan = 0x7fc00000u, kZero = 0;
  pipeline::LayerRecipe layer = axisLayer({1, 0, 0});
  layer.compress = pipeline::LayerRecipe().compress;
  layer.drivers = {{"deform", 0.5, {{0.0, 0.0}, {0.5, 0.2}, {1.0, 1.0}}}};
  const struct {
    const char* reason;
    std::function<void(format::Asset&)> change;
  } cases[] = {
      {"a part's palette is out of range",
       [](auto& a) { setField(a.parts()->Get(0), format::Part::VT_PALETTE_COUNT, 1000); }},
      {"a joint or weight is out of range",
       [](auto& a) { setField(a.parts()->Get(0), format::Part::VT_PALETTE_COUNT, 0); }},
      {"weights do not sum to one", [](auto& a) { shift(attributeOf(a, Semantic::Weights)->stream()); }},
      {"source vertices are no permutation",
       [](auto& a) { shift(attributeOf(a, Semantic::Source)->stream()); }},
      {"an index is out of range", [](auto& a) { shift(a.parts()->Get(0)->indices()); }},
      {"a number is not finite",
       [](auto& a) { changeable(attributeOf(a, Semantic::Position)->offset())[1] = NAN; }},
      {"an attribute without offset or step",
       [](auto& a) { setField(attributeOf(a, Semantic::Position), format::Attribute::VT_STEP, kNan); }},
      {"a part's rest matrix is not sound", [](auto& a) { changeable(a.parts()->Get(1)->rest())[3] = NAN; }},
      {"an inverse bind matrix is not sound",
       [](auto& a) { changeable(a.palette()->Get(0)->inverse_bind())[0] = INFINITY; }},
      {"its number of points is out of range", [](auto& a) { setField(&a, format::Asset::VT_POINTS, 1000); }},
      {"a point is out of range", [](auto& a) { setField(&a, format::Asset::VT_POINTS, 3); }},
      {"a point has no vertex", [](auto& a) { setField(&a, format::Asset::VT_POINTS, a.points() + 1); }},
      {"a morph target's numbers are not finite",
       [](auto& a) { setField(a.morphs()->Get(0), format::Morph::VT_POSITION_STEP, kNan); }},
      {"a texture's size or format is out of range",
       [](auto& a) { setField(a.texture_sets()->Get(0)->normals(), format::Texture::VT_WIDTH, 20000); }},
      {"a texture's size or format is out of range",
       [](auto& a) { setField(a.texture_sets()->Get(0)->normals(), format::Texture::VT_LEVELS, 30); }},
      {"a layer's map is out of range",
       [](auto& a) { changeable(a.texture_sets()->Get(0)->compress_slice())[0] = 7; }},
      {"a map's window is out of range",
       [](auto& a) { changeable(a.texture_sets()->Get(0)->windows())[2] = 0.5f; }},
      {"a part's texture set is out of range",
       [](auto& a) { setField(a.parts()->Get(1), format::Part::VT_TEXTURE_SET, 1); }},
      {"a layer's response is out of range",
       [](auto& a) { setField(a.layers()->Get(0), format::Layer::VT_BETA, kZero); }},
      {"a driver is out of range",
       [](auto& a) { setField(a.layers()->Get(0)->drivers()->Get(0), format::Driver::VT_GAIN, kNan); }},
      {"a driver's curve is not sound",
       [](auto& a) { changeable(a.layers()->Get(0)->drivers()->Get(0)->curve())[2] = 0.0f; }},
  };
  for (const auto& each : cases) {
    const Status status = loadChanged(each.change, layer, pipeline::GeometryCodec::kRaw);
    EXPECT_EQ(status.code, StatusCode::kBadData) << each.reason;
    EXPECT_NE(std::string_view(status.message).find(each.reason), std::string_view::npos)
        << status.message << ", expected: " << each.reason;
  }
}

// On a ball, where the normal is the position; the file holds three numbers instead of a stream.
TEST(Loader, ProjectsTheAxisOfALayer) {
  Primitive ball = sheet(40);
  for (glm::vec3& p : ball.positions) {
    const float around = 6.0f * p.x, up = 2.8f * (p.y - 0.5f);
    p = {std::sin(around) * std::cos(up), std::sin(up), std::cos(around) * std::cos(up)};
  }
  const std::vector<std::byte> file =
      pipeline::cook(sceneOf(ball, [](glm::dvec3 p) { return p; }), recipeOf({axisLayer({2, 1, -2})}), {})
          .bytes;
  const format::Layer& stored =
      *flatbuffers::GetRoot<format::Asset>(file.data() + sizeof(AssetHeader))->layers()->Get(0);
  EXPECT_EQ(stored.directions(), nullptr);
  ASSERT_NE(stored.axis(), nullptr);
  Asset asset;
  ASSERT_TRUE(asset.load(file).ok());
  const AssetView& view = asset.view();
  ASSERT_EQ(view.layers[0].directions.size(), 4 * size_t{view.pointCount()});
  const glm::dvec3 axis(2.0 / 3.0, 1.0 / 3.0, -2.0 / 3.0);
  for (uint32_t p = 0; p < view.pointCount(); ++p) {
    const Float3 at = view.positions[view.point_vertex[p]];
    const glm::dvec3 n = glm::normalize(glm::dvec3(at.x, at.y, at.z)), left = axis - glm::dot(axis, n) * n;
    const int8_t* d = &view.layers[0].directions[4 * size_t{p}];
    EXPECT_NEAR(d[3] / 127.0, glm::length(left), 0.08) << p;  // the triangles' normals are not the ball's
    if (glm::length(left) < 0.5) continue;
    EXPECT_GT(std::abs(glm::dot(glm::normalize(glm::dvec3(d[0], d[1], d[2])), glm::normalize(left))), 0.98)
        << p;
  }
}

// One layer has four channels of a texture.
TEST(Loader, RefusesAMaskThatNoTextureHolds) {
  pipeline::LayerRecipe layer = axisLayer({1, 0, 0});
  layer.compress = pipeline::LayerRecipe().compress;
  const auto load = [&](uint32_t slice) {
    return loadChanged(
        [slice](format::Asset& a) { setField(a.layers()->Get(0), format::Layer::VT_MASK_SLICE, slice); },
        layer);
  };
  EXPECT_TRUE(load(3).ok());
  EXPECT_EQ(load(4).code, StatusCode::kBadData);
}

// Of a stream that promises 32 GB, not kOutOfMemory.
TEST(Loader, NoMemoryIsTakenForWhatTheBytesCannotHold) {
  const Status status = loadChanged(
      [](format::Asset& a) { setField(a.place_points(), format::Stream::VT_COUNT, 0xffffffffu); });
  EXPECT_EQ(status.code, StatusCode::kBadData) << status.message;
}

}  // namespace
}  // namespace furrow::tests
