#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <iterator>
#include <map>
#include <set>

#include "content/head.h"
#include "content/models.h"
#include "content/noise.h"
#include "content/surface_net.h"
#include "content/surface_texels.h"

namespace furrow::content {
namespace {

using Pose = std::vector<std::vector<glm::vec3>>;  // a primitive, a vertex

const Scene& face() {
  static const Scene scene = buildFace();
  return scene;
}

const Scene& sleeve() {
  static const Scene scene = buildSleeve();
  return scene;
}

const Scene& jacket() {
  static const Scene scene = buildJacket();
  return scene;
}

const Scene& panel() {
  static const Scene scene = buildPanel();
  return scene;
}

const Primitive& part(const Scene& scene, const std::string& material) {
  for (const Mesh& mesh : scene.meshes)
    for (const Primitive& primitive : mesh.primitives)
      if (scene.materials[primitive.material].name == material) return primitive;
  throw std::runtime_error("no part of material " + material);
}

uint32_t morphIndex(const std::string& name) {
  const std::vector<std::string>& names = face().meshes[0].morphs;
  return static_cast<uint32_t>(std::ranges::find(names, name) - names.begin());
}

std::vector<glm::vec3> morphed(const Primitive& primitive, const std::vector<std::string>& morphs) {
  std::vector<glm::vec3> result = primitive.positions;
  for (const std::string& name : morphs)
    for (size_t v = 0; v < result.size(); ++v) result[v] += primitive.morphs[morphIndex(name)].positions[v];
  return result;
}

using Key = std::array<float, 3>;
Key keyOf(glm::vec3 p) {
  return {p.x, p.y, p.z};
}

size_t triangleCount(const Mesh& mesh) {
  size_t count = 0;
  for (const Primitive& primitive : mesh.primitives) count += primitive.indices.size() / 3;
  return count;
}

// Mean of posed over rest length along unit `d`, by area, over the triangles that `inside` picks by their
// centre: F d from the edges.
double lengthRatio(const Primitive& primitive, const std::vector<glm::vec3>& posed, glm::dvec3 d,
                   const std::function<bool(glm::vec3)>& inside) {
  double sum = 0, area_sum = 0;
  for (size_t t = 0; t < primitive.indices.size(); t += 3) {
    const uint32_t* i = &primitive.indices[t];
    const glm::dvec3 a = primitive.positions[i[0]], b = primitive.positions[i[1]],
                     c = primitive.positions[i[2]];
    if (!inside(glm::vec3((a + b + c) / 3.0))) continue;
    const glm::dvec3 e1 = b - a, e2 = c - a, n = glm::cross(e1, e2);
    const double area = glm::length(n);
    if (area < 1e-14) continue;
    glm::dvec3 u = d - n * (glm::dot(n, d) / (area * area));
    if (glm::length(u) < 0.2) continue;
    u = glm::normalize(u);
    const double c1 = glm::dot(glm::cross(u, e2), n) / (area * area),
                 c2 = glm::dot(glm::cross(e1, u), n) / (area * area);
    const glm::dvec3 p = posed[i[0]], q = posed[i[1]], r = posed[i[2]];
    sum += area * glm::length(c1 * (q - p) + c2 * (r - p));
    area_sum += area;
  }
  EXPECT_GT(area_sum, 0.0);
  return sum / area_sum;
}

std::vector<glm::vec3> skinned(const Scene& scene, const Primitive& primitive, const std::string& clip_name,
                               size_t key) {
  const auto clip = std::ranges::find(scene.clips, clip_name, &Clip::name);
  std::vector<glm::mat4> world(scene.nodes.size()), bind(scene.nodes.size());
  for (size_t n = 0; n < scene.nodes.size(); ++n) {
    const Node& node = scene.nodes[n];
    const glm::mat4 still = glm::translate(glm::mat4(1.0f), node.translation);
    glm::mat4 local = still;
    for (const RotationKeys& keys : clip->rotations)
      if (keys.node == n) local *= glm::mat4_cast(keys.rotations[key]);
    world[n] = node.parent < 0 ? local : world[node.parent] * local;
    bind[n] = node.parent < 0 ? still : bind[node.parent] * still;
  }
  std::vector<glm::vec3> result;
  for (size_t v = 0; v < primitive.positions.size(); ++v) {
    glm::vec4 p(0.0f);
    for (int k = 0; k < 4; ++k) {
      const uint32_t joint = scene.joints[primitive.joints[v][k]];
      p += primitive.weights[v][k] *
           (world[joint] * glm::inverse(bind[joint]) * glm::vec4(primitive.positions[v], 1.0f));
    }
    result.emplace_back(p);
  }
  return result;
}

// A name that no other run has.
std::filesystem::path temporary(const std::string& name) {
  static const std::string run = std::to_string(std::chrono::steady_clock::now().time_since_epoch().count());
  return std::filesystem::path(testing::TempDir()) / ("content_" + run + "_" + name);
}

std::string bytesOf(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// How often an edge between two of the net's points is walked along, by the points it leads from and to.
std::map<std::pair<uint32_t, uint32_t>, int> directedEdges(const SurfaceNet& net) {
  std::map<std::pair<uint32_t, uint32_t>, int> edges;
  for (const auto& quad : net.quads)
    for (int k = 0; k < 4; ++k) ++edges[{quad[k], quad[(k + 1) % 4]}];
  return edges;
}

// A ball: every point on it, closed, its area, its quads facing out.
TEST(SurfaceNet, MeshesABall) {
  const auto ball = [](glm::dvec3 p) { return glm::length(p - glm::dvec3(0.1, -0.2, 0.3)) - 1.0; };
  const SurfaceNet net = surfaceNet(ball, glm::dvec3(-1.5), glm::dvec3(1.5), 0.1);
  for (glm::dvec3 p : net.points) ASSERT_NEAR(ball(p), 0.0, 1e-6);
  double area = 0;
  for (const auto& quad : net.quads) {
    const glm::dvec3 a = net.points[quad[0]], b = net.points[quad[1]], c = net.points[quad[2]],
                     d = net.points[quad[3]];
    const glm::dvec3 normal = 0.5 * glm::cross(c - a, d - b);
    area += glm::length(normal);
    EXPECT_GT(glm::dot(normal, slopeOf(ball, a)), 0.0);
  }
  EXPECT_NEAR(area, 4 * 3.14159265, 0.05);
  const auto edges = directedEdges(net);
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1);
    EXPECT_TRUE(edges.contains({edge.second, edge.first}));
  }
  EXPECT_EQ(net.points.size() + net.quads.size() - edges.size() / 2, 2u);
}

// Two sheets a third of a cell apart, aslant to the grid: cells that hold both have a point of each, so that
// no edge joins more than two quads.
TEST(SurfaceNet, KeepsSheetsApart) {
  const auto slab = [](glm::dvec3 p) {
    const double ball = glm::length(p) - 1.0;
    return std::max(ball, std::abs(glm::dot(p, glm::normalize(glm::dvec3(1, 2, 3)))) - 0.06);
  };
  const SurfaceNet net = surfaceNet(slab, glm::dvec3(-1.5), glm::dvec3(1.5), 0.1);
  const auto edges = directedEdges(net);
  EXPECT_GT(net.quads.size(), 300u);
  for (const auto& [edge, count] : edges) EXPECT_LE(count, 1) << edge.first << " " << edge.second;
}

// Distances change by no more than the way that is gone; up to 1, beyond which a point may be missed. One
// point a unit cell.
TEST(Noise, CellsAreDistances) {
  Random random(1);
  const auto anywhere = [&](double reach) {
    return glm::dvec3(random.between(-reach, reach), random.between(-reach, reach),
                      random.between(-reach, reach));
  };
  double within = 0;
  constexpr int kTries = 20000;
  for (int i = 0; i < kTries; ++i) {
    const glm::dvec3 p = anywhere(50), q = p + anywhere(0.2);
    const Cells a = cells(p), b = cells(q);
    ASSERT_LE(a.nearest, a.second);
    ASSERT_LE(std::abs(std::min(a.nearest, 1.0) - std::min(b.nearest, 1.0)), glm::distance(p, q) + 1e-12);
    ASSERT_LE(std::abs(std::min(a.second, 1.0) - std::min(b.second, 1.0)), glm::distance(p, q) + 1e-12);
    within += a.nearest < 0.3;
  }
  EXPECT_NEAR(within / kTries, 4.0 / 3.0 * 3.14159265 * 0.027, 0.01);
}

// A square of 2 by 1 in the plane z = 3, on the left half of the image; `mirrored` turns it about.
SurfaceMesh sheet(bool mirrored) {
  SurfaceMesh mesh;
  const double sign = mirrored ? -1.0 : 1.0;
  for (const glm::dvec2 at : {glm::dvec2(0, 0), glm::dvec2(1, 0), glm::dvec2(1, 1), glm::dvec2(0, 1)}) {
    mesh.points.emplace_back(sign * 2.0 * at.x, at.y, 3.0);
    mesh.addVertex(static_cast<uint32_t>(mesh.points.size() - 1), {0.5 * at.x, at.y});
  }
  mesh.addTriangle(0, 1, 2);
  mesh.addTriangle(0, 2, 3);
  return mesh;
}

TEST(SurfaceTexels, LieOnTheSurfaceAndKnowItsSlopes) {
  const std::vector<uint32_t> materials(2, 7);
  for (const bool mirrored : {false, true}) {
    const SurfaceTexels texels(sheet(mirrored), materials, 7, 16);
    const double sign = mirrored ? -1.0 : 1.0;
    for (uint32_t y = 0; y < 16; ++y)
      for (uint32_t x = 0; x < 16; ++x) {
        ASSERT_EQ(texels.covered(x, y), x < 8) << x << " " << y;
        if (x >= 8) continue;
        const glm::dvec3 p(sign * (x + 0.5) / 4, 1 - (y + 0.5) / 16, 3);
        EXPECT_LT(glm::distance(texels.position(x, y), p), 1e-12);
      }
    // Rises by 1/2 to the image's right and by 1/4 to its top.
    const Image normals = texels.normals([&](glm::dvec3 p) { return 0.5 * sign * p.x + 0.25 * p.y; });
    const glm::dvec3 normal = glm::normalize(glm::dvec3(-0.5, -0.25, 1.0));
    for (size_t i = 0; i < 16 * 16; ++i)
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(normals.rgb[3 * i + c], 127.5 * (normal[c] + 1), 0.51);
  }
}

TEST(SurfaceTexels, CarryColoursOverTheEdges) {
  const std::vector<uint32_t> materials(2, 7);
  const SurfaceTexels texels(sheet(false), materials, 7, 16);
  const Image colors = texels.colors([](glm::dvec3 p) { return glm::dvec3(p.x > 1 ? 1.0 : 0.0, 0.5, 0.0); });
  for (size_t i = 0; i < 16 * 16; ++i) {
    EXPECT_EQ(colors.rgb[3 * i], i % 16 < 4 ? 0 : 255);
    EXPECT_EQ(colors.rgb[3 * i + 1], 188);  // of linear 0.5
  }
  EXPECT_FALSE(SurfaceTexels(sheet(false), materials, 1, 16).covered(3, 3));
}

TEST(Content, FaceIsFineEnoughAndOfHumanSize) {
  EXPECT_GE(part(face(), "skin").indices.size() / 3, 15000u);
  size_t triangles = 0;
  for (const Node& node : face().nodes)
    if (node.mesh >= 0) triangles += triangleCount(face().meshes[node.mesh]);
  EXPECT_LE(triangles, 80000u);
  // From the chin to the crown, and across the temples.
  float crown = -1, chin = 1, widest = 0;
  for (glm::vec3 p : part(face(), "skin").positions) {
    crown = std::max(crown, p.y);
    if (p.z > 0.0f && p.y > -0.13f) chin = std::min(chin, p.y);
    if (p.y > 0.02f && p.y < 0.05f) widest = std::max(widest, p.x);
  }
  EXPECT_NEAR(crown - chin, 0.23, 0.015);
  EXPECT_NEAR(2 * widest, 0.158, 0.008);
}

TEST(Content, FaceHasTheArkitExpressions) {
  EXPECT_THAT(
      face().meshes[0].morphs,
      testing::IsSupersetOf({"browInnerUp",      "browDownLeft",   "browDownRight",     "browOuterUpLeft",
                             "browOuterUpRight", "eyeBlinkLeft",   "eyeBlinkRight",     "eyeSquintLeft",
                             "eyeSquintRight",   "mouthSmileLeft", "mouthSmileRight",   "noseSneerLeft",
                             "noseSneerRight",   "jawOpen",        "eyeWideLeft",       "mouthFrownLeft",
                             "mouthPucker",      "mouthFunnel",    "mouthUpperUpRight", "cheekPuff"}));
  EXPECT_GE(face().meshes[0].morphs.size(), 20u);
  // Every one moves something, and its mirror image as far.
  const Primitive& skin = part(face(), "skin");
  std::map<std::string, double> reach;
  for (size_t m = 0; m < skin.morphs.size(); ++m)
    for (glm::vec3 d : skin.morphs[m].positions) {
      double& farthest = reach[face().meshes[0].morphs[m]];
      farthest = std::max(farthest, double{glm::length(d)});
    }
  for (const auto& [name, farthest] : reach) {
    EXPECT_GT(farthest, 0.001) << name;
    if (name.ends_with("Left")) {
      EXPECT_NEAR(farthest, reach.at(name.substr(0, name.size() - 4) + "Right"), 1e-6) << name;
    }
  }
}

TEST(Content, PerformanceLastsTenSecondsAndUsesMostExpressions) {
  const Clip& clip = face().clips.at(0);
  EXPECT_EQ(clip.name, "performance");
  EXPECT_FLOAT_EQ(clip.times.back(), 10.0f);
  std::set<size_t> used;
  for (const auto& key : clip.weights[0].weights)
    for (size_t m = 0; m < key.size(); ++m)
      if (key[m] > 0.3f) used.insert(m);
  EXPECT_GE(used.size(), 20u);
}

// Lips are redder than the cheek beside them, the scalp is dark; pores stand in the skin and not under the
// hair.
TEST(Content, SkinHasColourAndPores) {
  const Scene& scene = face();
  const Material& material = scene.materials[part(scene, "skin").material];
  ASSERT_GE(material.color_image, 0);
  ASSERT_GE(material.normal_image, 0);
  const Image &color = scene.images[material.color_image], &normal = scene.images[material.normal_image];
  const Primitive& skin = part(scene, "skin");
  struct Sums {
    glm::dvec3 color{0};
    double slope = 0;
    int count = 0;
  } lips, cheek, scalp;
  for (size_t v = 0; v < skin.positions.size(); ++v) {
    const glm::vec3 p = skin.positions[v];
    Sums* sums = nullptr;
    if (std::abs(p.x) < 0.012f && p.y < -0.0712f && p.y > -0.0755f && p.z > 0.0f) sums = &lips;
    if (std::abs(std::abs(p.x) - 0.035f) < 0.008f && std::abs(p.y + 0.04f) < 0.01f && p.z > 0.0f)
      sums = &cheek;
    if (p.y > 0.09f) sums = &scalp;
    if (sums == nullptr) continue;
    const auto texel = [&](const Image& image) {
      const auto x = static_cast<size_t>(skin.uvs[v].x * static_cast<float>(image.width)),
                 y = static_cast<size_t>(skin.uvs[v].y * static_cast<float>(image.height));
      const uint8_t* c = &image.rgb[3 * (y * image.width + x)];
      return glm::dvec3(c[0], c[1], c[2]);
    };
    sums->color += texel(color);
    sums->slope += glm::length(glm::dvec2(texel(normal)) - 127.5);
    ++sums->count;
  }
  for (Sums* sums : {&lips, &cheek, &scalp}) {
    ASSERT_GT(sums->count, 20);
    sums->color /= sums->count;
    sums->slope /= sums->count;
  }
  EXPECT_GT(lips.color.r / lips.color.g, 1.15 * cheek.color.r / cheek.color.g);
  EXPECT_LT(scalp.color.r, 0.4 * cheek.color.r);
  EXPECT_GT(cheek.slope, 3.0);
  EXPECT_LT(scalp.slope, 1.0);
}

// The shoulders meet in it: a light from the side showed a line from the collar down.
TEST(Content, NoRidgeRunsDownTheBreast) {
  for (const double height : {-20.0, -21.0, -22.0}) {
    const glm::dvec3 aside = head::trace({0.5, height, 10.0}, {0.0, 0.0, -1.0});
    EXPECT_LT(std::abs(head::normal(aside).x), 0.05) << height;
  }
}

TEST(Content, EarsStandOutOfTheHead) {
  const Primitive& ears = part(face(), "ears");
  float low = 1, high = -1, out = 0;
  for (uint32_t i : ears.indices) {
    const glm::vec3 p = ears.positions[i];
    low = std::min(low, p.y);
    high = std::max(high, p.y);
    out = std::max(out, p.x);
  }
  EXPECT_NEAR(high - low, 0.062, 0.012);
  EXPECT_GT(out, 0.085f);
  EXPECT_LT(out, 0.10f);
}

TEST(Content, ArraysMatchAndIndicesAreInRange) {
  for (const Scene* scene : {&face(), &jacket(), &panel(), &sleeve()}) {
    for (const Mesh& mesh : scene->meshes) {
      for (const Primitive& primitive : mesh.primitives) {
        const size_t count = primitive.positions.size();
        EXPECT_EQ(primitive.normals.size(), count);
        EXPECT_EQ(primitive.uvs.size(), count);
        EXPECT_EQ(primitive.morphs.size(), mesh.morphs.size());
        for (const Morph& morph : primitive.morphs) EXPECT_EQ(morph.positions.size(), count);
        for (const auto& [name, values] : primitive.vec3_attributes) EXPECT_EQ(values.size(), count) << name;
        for (const auto& [name, values] : primitive.vec4_attributes) EXPECT_EQ(values.size(), count) << name;
        for (glm::vec3 n : primitive.normals) ASSERT_NEAR(glm::length(n), 1.0f, 1e-5f);
        EXPECT_EQ(primitive.colors.size() % std::max<size_t>(count, 1), 0u);
        for (glm::vec2 uv : primitive.uvs) ASSERT_TRUE(uv.x >= 0 && uv.x <= 1 && uv.y >= 0 && uv.y <= 1);
        for (uint32_t i : primitive.indices) ASSERT_LT(i, count);
      }
    }
  }
}

// As the cook warns of them: no edge with more than two triangles, no vertex without one.
TEST(Content, SurfacesAreCleanMeshes) {
  for (const Scene* scene : {&face(), &jacket(), &panel(), &sleeve()})
    for (const Mesh& mesh : scene->meshes)
      for (const Primitive& primitive : mesh.primitives) {
        std::vector<bool> used(primitive.positions.size());
        std::map<std::pair<Key, Key>, int> edges;
        for (size_t t = 0; t < primitive.indices.size(); t += 3)
          for (size_t k = 0; k < 3; ++k) {
            used[primitive.indices[t + k]] = true;
            ++edges[std::minmax(keyOf(primitive.positions[primitive.indices[t + k]]),
                                keyOf(primitive.positions[primitive.indices[t + (k + 1) % 3]]))];
          }
        const std::string name = mesh.name + ", " + scene->materials[primitive.material].name;
        EXPECT_TRUE(std::ranges::all_of(used, std::identity())) << name;
        for (const auto& [edge, count] : edges)
          EXPECT_LE(count, 2) << name << ": " << edge.first[0] << " " << edge.first[1] << " "
                              << edge.first[2];
      }
}

TEST(Content, SurfacesFaceOutwards) {
  const auto outwards = [](const Primitive& primitive, glm::vec3 axis_point, glm::vec3 axis) {
    double with = 0, against = 0;
    for (size_t t = 0; t < primitive.indices.size(); t += 3) {
      const glm::vec3 a = primitive.positions[primitive.indices[t]],
                      b = primitive.positions[primitive.indices[t + 1]],
                      c = primitive.positions[primitive.indices[t + 2]];
      const glm::vec3 n = glm::cross(b - a, c - a),
                      away = a - axis_point - axis * glm::dot(a - axis_point, axis);
      const glm::vec3 shading = primitive.normals[primitive.indices[t]];
      EXPECT_GE(glm::dot(n, shading), -0.5f * glm::length(n));
      (glm::dot(n, away) > 0 ? with : against) += glm::length(n);
    }
    return with / (with + against);
  };
  EXPECT_GT(outwards(part(sleeve(), "cloth"), {}, {1, 0, 0}), 0.9);
  EXPECT_GT(outwards(part(jacket(), "cloth"), {0, -0.1f, 0}, {}), 0.75);  // the sleeves' undersides face in
  EXPECT_GT(outwards(part(sleeve(), "skin"), {}, {1, 0, 0}), 0.9);
  EXPECT_GT(outwards(part(face(), "skin"), {0, -0.03f, -0.06f}, {}), 0.95);
  EXPECT_GT(outwards(part(face(), "shirt"), {0, -0.20f, -0.08f}, {}), 0.9);
  EXPECT_EQ(outwards(part(face(), "eye"), {}, {}), 1.0);
}

// Coarser rows and columns meet finer ones without a crack: the skin ends at the collar, at the crown, and
// where the lids and the mouth's pocket do.
TEST(Content, SkinHasNoCracks) {
  std::map<std::pair<Key, Key>, int> edges;
  for (const char* material : {"skin", "lids", "mouth"}) {
    const Primitive& primitive = part(face(), material);
    for (size_t t = 0; t < primitive.indices.size(); t += 3)
      for (size_t k = 0; k < 3; ++k) {
        const Key a = keyOf(primitive.positions[primitive.indices[t + k]]),
                  b = keyOf(primitive.positions[primitive.indices[t + (k + 1) % 3]]);
        ++edges[std::minmax(a, b)];
      }
  }
  std::set<Key> skin;
  for (glm::vec3 p : part(face(), "skin").positions) skin.insert(keyOf(p));
  for (const auto& [edge, triangles] : edges)
    for (const Key& p : {edge.first, edge.second}) {
      if (triangles > 1 || !skin.contains(p)) continue;
      const bool collar = p[1]<-0.14f, crown = p[1]> 0.1f && std::abs(p[0]) < 0.003f;
      EXPECT_TRUE(collar || crown) << p[0] << " " << p[1] << " " << p[2];
    }
}

TEST(Content, FaceIsMirrored) {
  const Primitive& skin = part(face(), "skin");
  std::set<Key> places;
  for (glm::vec3 p : skin.positions) places.insert(keyOf(p));
  for (glm::vec3 p : skin.positions) ASSERT_TRUE(places.contains({-p.x, p.y, p.z}));
}

// Vertices that a UV seam or a material tells apart stay together in every expression. The lips alone may
// part, and jawOpen parts them.
TEST(Content, SeamsStayClosedUnderEveryExpression) {
  const Mesh& mesh = face().meshes[0];
  struct Seen {
    const Primitive* primitive;
    size_t vertex;
  };
  std::map<Key, std::vector<Seen>> places;
  for (const Primitive& primitive : mesh.primitives)
    for (size_t v = 0; v < primitive.positions.size(); ++v)
      places[keyOf(primitive.positions[v])].push_back({&primitive, v});
  size_t on_seams = 0, parted_lips = 0;
  for (const auto& [place, seen] : places) {
    if (seen.size() < 2) continue;
    std::set<Key> uvs;
    for (const Seen& s : seen) uvs.insert({s.primitive->uvs[s.vertex].x, s.primitive->uvs[s.vertex].y, 0});
    on_seams += uvs.size() > 1;
    for (size_t morph = 0; morph < mesh.morphs.size(); ++morph) {
      const glm::vec3 first = seen[0].primitive->morphs[morph].positions[seen[0].vertex];
      for (const Seen& s : seen) {
        if (s.primitive->morphs[morph].positions[s.vertex] == first) continue;
        ++parted_lips;
        ASSERT_LT(std::abs(place[0]), 0.0256f) << mesh.morphs[morph];
        ASSERT_NEAR(place[1], -0.07f, 0.002f) << mesh.morphs[morph];
      }
    }
  }
  EXPECT_GT(on_seams, 200u);
  EXPECT_GT(parted_lips, 20u);
}

TEST(Content, NoExpressionTurnsSkinInsideOut) {
  const Primitive& skin = part(face(), "skin");
  for (const std::string& name : face().meshes[0].morphs) {
    const std::vector<glm::vec3> posed = morphed(skin, {name});
    double area = 0, flipped = 0;
    for (size_t t = 0; t < skin.indices.size(); t += 3) {
      const uint32_t* i = &skin.indices[t];
      const auto cross = [&](const std::vector<glm::vec3>& p) {
        return glm::cross(p[i[1]] - p[i[0]], p[i[2]] - p[i[0]]);
      };
      const glm::vec3 before = cross(skin.positions), after = cross(posed);
      area += glm::length(before);
      if (glm::dot(before, after) < 0) flipped += glm::length(before);
    }
    EXPECT_LT(flipped / area, 0.002) << name;
  }
}

TEST(Content, BrowInnerUpSqueezesTheForehead) {
  const Primitive& skin = part(face(), "skin");
  const auto posed = morphed(skin, {"browInnerUp"});
  const auto forehead = [](glm::vec3 p) {
    return std::abs(p.x) < 0.02f && p.y > 0.028f && p.y < 0.055f && p.z > 0.0f;
  };
  const double ratio = lengthRatio(skin, posed, {0, 1, 0}, forehead);
  RecordProperty("ratio", std::to_string(ratio));
  EXPECT_GT(ratio, 0.60);
  EXPECT_LT(ratio, 0.80);
  // The hairline stays.
  for (size_t v = 0; v < posed.size(); ++v) {
    if (skin.positions[v].y > 0.066f) {
      ASSERT_LT(glm::distance(posed[v], skin.positions[v]), 1e-3f);
    }
  }
}

TEST(Content, BrowDownSqueezesTheGlabellaAcross) {
  const Primitive& skin = part(face(), "skin");
  const auto posed = morphed(skin, {"browDownLeft", "browDownRight"});
  const double ratio = lengthRatio(skin, posed, {1, 0, 0}, [](glm::vec3 p) {
    return std::abs(p.x) < 0.012f && p.y > 0.012f && p.y < 0.026f && p.z > 0.0f;
  });
  RecordProperty("ratio", std::to_string(ratio));
  EXPECT_LT(ratio, 0.80);
  EXPECT_GT(ratio, 0.40);
}

TEST(Content, SquintSqueezesTheSkinBesideTheEye) {
  const Primitive& skin = part(face(), "skin");
  const auto posed = morphed(skin, {"eyeSquintLeft", "cheekSquintLeft"});
  const double ratio = lengthRatio(skin, posed, {0, 1, 0}, [](glm::vec3 p) {
    return p.x > 0.046f && p.x < 0.058f && std::abs(p.y) < 0.008f;
  });
  RecordProperty("ratio", std::to_string(ratio));
  EXPECT_LT(ratio, 0.92);
}

TEST(Content, SmileSqueezesTheCheekAcrossTheFoldAndJawOpenStretchesIt) {
  const Primitive& skin = part(face(), "skin");
  const glm::dvec3 across = glm::normalize(glm::dvec3(1.0, 0.45, 0.0));
  const auto cheek = [](glm::vec3 p) {
    return p.x > 0.027f && p.x < 0.040f && p.y > -0.066f && p.y < -0.050f;
  };
  const double ratio = lengthRatio(skin, morphed(skin, {"mouthSmileLeft"}), across, cheek);
  RecordProperty("ratio", std::to_string(ratio));
  EXPECT_LT(ratio, 0.90);
  const auto beside_mouth = [](glm::vec3 p) {
    return p.x > 0.024f && p.x < 0.040f && std::abs(p.y + 0.07f) < 0.010f;
  };
  EXPECT_GT(lengthRatio(skin, morphed(skin, {"jawOpen"}), {0, 1, 0}, beside_mouth), 1.15);
}

TEST(Content, JawOpenSqueezesTheThroatAndDrawsTheMouthIn) {
  const Primitive& skin = part(face(), "skin");
  const auto posed = morphed(skin, {"jawOpen"});
  EXPECT_LT(lengthRatio(skin, posed, {0, 1, 0}, [](glm::vec3 p) { return p.y < -0.12f && p.z > -0.05f; }),
            0.95);
  size_t corners = 0;
  for (size_t v = 0; v < posed.size(); ++v) {
    const glm::vec3 p = skin.positions[v];
    if (glm::distance(glm::vec2(std::abs(p.x), p.y), glm::vec2(0.0255f, -0.07f)) > 0.001f) continue;
    EXPECT_LT(std::abs(posed[v].x), 0.95f * std::abs(p.x));
    ++corners;
  }
  EXPECT_GT(corners, 1u);
}

TEST(Content, ClosedLidsCoverTheEyeball) {
  const auto posed = morphed(part(face(), "skin"), {"eyeBlinkLeft"});
  const glm::vec3 eye = face().nodes[2].translation;
  float radius = 0;
  for (glm::vec3 p : part(face(), "eye").positions) radius = std::max(radius, glm::length(p));
  for (glm::vec3 p : posed) ASSERT_GT(glm::distance(p, eye), radius);
}

// The margins are where the skin meets the insides of the lids. Blinking closes them without one passing the
// other.
TEST(Content, BlinkingLidsMeet) {
  std::set<Key> inside;
  for (glm::vec3 p : part(face(), "lids").positions) inside.insert(keyOf(p));
  const Primitive& skin = part(face(), "skin");
  const auto posed = morphed(skin, {"eyeBlinkLeft"});
  std::vector<glm::vec3> upper, lower;
  float open = 0;
  for (size_t v = 0; v < posed.size(); ++v) {
    const glm::vec3 p = skin.positions[v];
    if (p.x < 0.0168f || p.x > 0.0466f || std::abs(p.y) > 0.01f || !inside.contains(keyOf(p))) continue;
    const float middle = glm::mix(-0.0016f, 0.0006f, (p.x - 0.0166f) / (0.0466f - 0.0166f));
    (p.y > middle ? upper : lower).push_back(posed[v]);
    open = std::max(open, std::abs(p.y - middle));
  }
  ASSERT_GT(upper.size(), 10u);
  ASSERT_GT(lower.size(), 10u);
  EXPECT_GT(open, 0.0035f);
  for (glm::vec3 p : upper) {
    const auto nearer = [&](glm::vec3 a, glm::vec3 b) { return std::abs(a.x - p.x) < std::abs(b.x - p.x); };
    const glm::vec3 below = *std::ranges::min_element(lower, nearer);
    EXPECT_GT(p.y - below.y, -0.0003f) << p.x;
    EXPECT_LT(p.y - below.y, 0.001f) << p.x;
  }
}

TEST(Content, SleeveIsSkinnedSmoothlyAndClosedAtItsSeam) {
  const Primitive& cloth = part(sleeve(), "cloth");
  EXPECT_GE(cloth.indices.size() / 3, 8000u);
  size_t blended = 0, on_seam = 0;
  std::map<Key, size_t> places;
  for (size_t v = 0; v < cloth.positions.size(); ++v) {
    ASSERT_NEAR(cloth.weights[v].x + cloth.weights[v].y + cloth.weights[v].z + cloth.weights[v].w, 1.0f,
                1e-5f);
    blended +=
        std::max({cloth.weights[v].x, cloth.weights[v].y, cloth.weights[v].z, cloth.weights[v].w}) < 0.95f;
    const auto [place, fresh] = places.emplace(keyOf(cloth.positions[v]), v);
    if (fresh) continue;
    ++on_seam;
    EXPECT_EQ(cloth.weights[v], cloth.weights[place->second]);
    EXPECT_NE(cloth.uvs[v], cloth.uvs[place->second]);
  }
  EXPECT_GT(blended, cloth.positions.size() / 4);
  EXPECT_GT(on_seam, 100u);
}

TEST(Content, BendSqueezesTheInnerElbow) {
  const Primitive& cloth = part(sleeve(), "cloth");
  const auto inner = [](glm::vec3 p) { return std::abs(p.x - 0.28f) < 0.03f && p.z > 0.05f; };
  const auto outer = [](glm::vec3 p) { return std::abs(p.x - 0.28f) < 0.03f && p.z < -0.05f; };
  const auto bent = skinned(sleeve(), cloth, "bend", 30);
  const double squeezed = lengthRatio(cloth, bent, {1, 0, 0}, inner);
  RecordProperty("ratio", std::to_string(squeezed));
  EXPECT_LT(squeezed, 0.7);
  EXPECT_GT(lengthRatio(cloth, bent, {1, 0, 0}, outer), 1.1);
  const auto straight = skinned(sleeve(), cloth, "bend", 0);
  EXPECT_NEAR(lengthRatio(cloth, straight, {1, 0, 0}, inner), 1.0, 1e-4);
}

TEST(Content, TwistSqueezesAlongOneHelixAndStretchesTheOther) {
  const Primitive& cloth = part(sleeve(), "cloth");
  const auto top = [](glm::vec3 p) { return p.x > 0.36f && p.x < 0.42f && p.y > 0.045f; };
  const auto turned = skinned(sleeve(), cloth, "twist", 22);
  const double a = lengthRatio(cloth, turned, glm::normalize(glm::dvec3(1, 0, 1)), top);
  const double b = lengthRatio(cloth, turned, glm::normalize(glm::dvec3(1, 0, -1)), top);
  RecordProperty("ratio", std::to_string(std::min(a, b)));
  EXPECT_LT(std::min(a, b), 0.9);
  EXPECT_GT(std::max(a, b), 1.05);
}

TEST(Content, JacketIsMirroredSkinnedSmoothlyAndClosedAtItsSeams) {
  const Primitive& cloth = part(jacket(), "cloth");
  EXPECT_GE(cloth.indices.size() / 3, 15000u);
  size_t blended = 0, on_seam = 0;
  std::map<Key, size_t> places;
  float hem = 0;
  for (size_t v = 0; v < cloth.positions.size(); ++v) {
    const glm::vec4 w = cloth.weights[v];
    ASSERT_NEAR(w.x + w.y + w.z + w.w, 1.0f, 1e-5f);
    blended += std::max({w.x, w.y, w.z, w.w}) < 0.95f;
    hem = std::min(hem, cloth.positions[v].y);
    const auto [place, fresh] = places.emplace(keyOf(cloth.positions[v]), v);
    if (fresh) continue;
    ++on_seam;
    EXPECT_EQ(w, cloth.weights[place->second]);
    EXPECT_NE(cloth.uvs[v], cloth.uvs[place->second]);
  }
  EXPECT_GT(blended, cloth.positions.size() / 4);
  EXPECT_GT(on_seam, 300u);
  EXPECT_NEAR(hem, -0.385f, 0.004f);
  const auto nearest = [&](glm::vec3 p) {
    float best = 1;
    for (const auto& [key, v] : places) best = std::min(best, glm::distance(p, cloth.positions[v]));
    return best;
  };
  for (size_t v = 0; v < cloth.positions.size(); v += 97)
    EXPECT_LT(nearest(cloth.positions[v] * glm::vec3(-1, 1, 1)), 1e-4f);
}

// Blended between the arms' joints alone, a sleeve bent by 85 degrees keeps 0.86 of its radius.
TEST(Content, ABentElbowKeepsItsThickness) {
  const Primitive& cloth = part(jacket(), "cloth");
  const std::vector<glm::vec3> bent = skinned(jacket(), cloth, "bend", 30);
  const glm::vec3 elbow(0.399f, -0.088f, -0.01f), along = glm::normalize(glm::vec3(0.78f, -0.62f, 0.13f));
  const auto radius = [&](const std::vector<glm::vec3>& positions) {
    std::vector<glm::vec3> ring;
    for (size_t v = 0; v < positions.size(); ++v) {
      const glm::vec3 from = cloth.positions[v] - elbow;
      if (glm::length(from) < 0.1f && std::abs(glm::dot(from, along)) < 0.01f) ring.push_back(positions[v]);
    }
    EXPECT_GT(ring.size(), 40u);
    glm::vec3 middle(0.0f);
    for (glm::vec3 p : ring) middle += p / static_cast<float>(ring.size());
    float sum = 0.0f;
    for (glm::vec3 p : ring) sum += glm::distance(p, middle);
    return sum / static_cast<float>(ring.size());
  };
  EXPECT_GT(radius(bent) / radius(cloth.positions), 0.96f);
}

// Raised by the shoulder joint alone, the arm stands beside the shoulder like a wall; the collarbone lifts
// both.
TEST(Content, ARaisedArmGrowsOutOfTheShoulder) {
  const Primitive& cloth = part(jacket(), "cloth");
  const std::vector<glm::vec3> raised = skinned(jacket(), cloth, "raise", 27);
  std::array<float, 16> top;  // a centimetre each, from beside the collar outwards
  top.fill(-1.0f);
  for (glm::vec3 p : raised) {
    const float column = (p.x - 0.09f) * 100.0f;
    if (column >= 0.0f && column < 16.0f)
      top[static_cast<size_t>(column)] = std::max(top[static_cast<size_t>(column)], p.y);
  }
  float steepest = 0.0f;
  for (size_t i = 1; i < top.size(); ++i) steepest = std::max(steepest, top[i] - top[i - 1]);
  RecordProperty("steepest", std::to_string(steepest));
  EXPECT_LT(steepest, 0.03f);
}

TEST(Content, JacketIsSqueezedAtElbowShoulderAndWaist) {
  const Primitive& cloth = part(jacket(), "cloth");
  const auto ratio = [&](const char* clip, size_t key, glm::dvec3 d, glm::vec3 centre, float radius) {
    return lengthRatio(cloth, skinned(jacket(), cloth, clip, key), d,
                       [=](glm::vec3 p) { return glm::distance(p, centre) < radius; });
  };
  const glm::dvec3 along = glm::normalize(glm::dvec3(0.78, -0.62, 0.1));
  EXPECT_LT(ratio("bend", 30, along, {0.39, -0.05, 0.06}, 0.05f), 0.80);    // inside of the elbow
  EXPECT_GT(ratio("bend", 30, along, {0.41, -0.12, -0.07}, 0.05f), 1.10);   // outside
  EXPECT_LT(ratio("raise", 27, along, {0.17, 0.155, 0.0}, 0.06f), 0.90);    // over the shoulder, arm up
  EXPECT_GT(ratio("raise", 27, along, {0.21, -0.02, 0.0}, 0.08f), 1.10);    // under the arm
  EXPECT_LT(ratio("lean", 30, {0, 1, 0}, {0, -0.18, 0.11}, 0.06f), 0.85);   // belly
  EXPECT_GT(ratio("lean", 30, {0, 1, 0}, {0, -0.18, -0.11}, 0.06f), 1.10);  // back
  EXPECT_LT(ratio("sway", 22, {0, 1, 0}, {-0.16, -0.18, 0}, 0.06f) *
                ratio("sway", 22, {0, 1, 0}, {0.16, -0.18, 0}, 0.06f),
            1.0);
  const double left = ratio("twist", 22, glm::normalize(glm::dvec3(1, 1, 0)), {0, -0.18, 0.11}, 0.06f),
               right = ratio("twist", 22, glm::normalize(glm::dvec3(1, -1, 0)), {0, -0.18, 0.11}, 0.06f);
  EXPECT_LT(std::min(left, right), 0.93);
  EXPECT_GT(std::max(left, right), 1.05);
}

TEST(Content, PanelIsShearedPinchedAndSqueezed) {
  const Primitive& cloth = part(panel(), "cloth");
  const auto posed = [&](size_t morph) {
    std::vector<glm::vec3> result = cloth.positions;
    for (size_t v = 0; v < result.size(); ++v) result[v] += cloth.morphs[morph].positions[v];
    return result;
  };
  EXPECT_THAT(panel().meshes[0].morphs, testing::ElementsAre("shear", "pinch", "squeeze"));
  const auto all = [](glm::vec3) { return true; };
  EXPECT_NEAR(lengthRatio(cloth, posed(2), {1, 0, 0}, all), 0.74, 0.02);
  EXPECT_LT(lengthRatio(cloth, posed(0), glm::normalize(glm::dvec3(1, 1, 0)), all), 0.90);
  EXPECT_GT(lengthRatio(cloth, posed(0), glm::normalize(glm::dvec3(1, -1, 0)), all), 1.10);
  const auto beside = [](glm::vec3 p) {
    return std::abs(p.x - 0.08f) < 0.02f && std::abs(p.y - 0.03f) < 0.02f;
  };
  EXPECT_LT(lengthRatio(cloth, posed(1), {0, 1, 0}, beside), 0.75);  // around the pinch
}

TEST(Content, ReadsBackAsItWasBuilt) {
  const std::filesystem::path file = temporary("face.glb");
  writeGlb(face(), file);
  tinygltf::TinyGLTF reader;
  tinygltf::Model model;
  std::string error, warning;
  ASSERT_TRUE(reader.LoadBinaryFromFile(&model, &error, &warning, file.string())) << error;
  EXPECT_EQ(warning, "");
  ASSERT_EQ(model.meshes.size(), face().meshes.size());
  ASSERT_EQ(model.meshes[0].primitives.size(), face().meshes[0].primitives.size());
  for (size_t p = 0; p < model.meshes[0].primitives.size(); ++p) {
    const Primitive& source = face().meshes[0].primitives[p];
    ASSERT_EQ(model.meshes[0].primitives[p].targets.size(), source.morphs.size());
    for (size_t m = 0; m < source.morphs.size(); ++m) {
      const auto& accessor = model.accessors[model.meshes[0].primitives[p].targets[m].at("POSITION")];
      ASSERT_EQ(accessor.count, source.positions.size());
      std::vector<glm::vec3> values(accessor.count, glm::vec3(0.0f));
      if (accessor.sparse.isSparse) {
        const auto view = [&](int index, size_t offset) {
          return &model.buffers[0].data[model.bufferViews[index].byteOffset + offset];
        };
        const unsigned char* indices =
            view(accessor.sparse.indices.bufferView, accessor.sparse.indices.byteOffset);
        const unsigned char* moved =
            view(accessor.sparse.values.bufferView, accessor.sparse.values.byteOffset);
        for (int k = 0; k < accessor.sparse.count; ++k) {
          uint32_t vertex = 0;
          std::memcpy(&vertex, indices + 4 * k, 4);
          std::memcpy(&values.at(vertex), moved + 12 * k, 12);
        }
      }
      ASSERT_EQ(values, source.morphs[m].positions);
    }
  }
  std::filesystem::remove(file);
}

TEST(Content, SameBytesEveryTime) {
  const std::filesystem::path one = temporary("1.glb"), two = temporary("2.glb");
  writeGlb(face(), one);
  writeGlb(buildFace(), two);
  EXPECT_TRUE(bytesOf(one) == bytesOf(two));
  writeGlb(jacket(), one);
  writeGlb(buildJacket(), two);
  EXPECT_TRUE(bytesOf(one) == bytesOf(two));
  std::filesystem::remove(one);
  std::filesystem::remove(two);
}

}  // namespace
}  // namespace furrow::content
