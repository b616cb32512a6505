#include "tests/image/ball_asset.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <vector>

#include "pipeline/maps/encode.h"

namespace furrow::tests {

namespace {

constexpr uint32_t kColumns = 64, kRows = 40;  // cells of the grid
constexpr uint32_t kMapSize = 512;
constexpr float kPi = std::numbers::pi_v<float>;

glm::vec3 onBall(float u, float v) {
  const float longitude = (u - 0.5f) * 2.0f * kPi, latitude = (0.5f - v) * kPi;
  return {std::sin(longitude) * std::cos(latitude), std::sin(latitude),
          std::cos(longitude) * std::cos(latitude)};
}

float smooth(float low, float high, float x) {
  const float t = std::clamp((x - low) / (high - low), 0.0f, 1.0f);
  return t * t * (3.0f - 2.0f * t);
}

float maskAt(uint32_t layer, glm::vec3 p) {
  if (p.z <= 0.0f) return 0.0f;
  const float far = layer == 0 ? glm::length(glm::vec2(p.x / 0.8f, p.y / 0.55f))
                               : glm::length(glm::vec2(p.x / 0.3f, (p.y - 0.1f) / 0.45f));
  return 1.0f - smooth(0.6f, 1.0f, far);
}

// Height of wandering creases across d, in the unit of the ball.
float heightAt(uint32_t layer, float u, float v) {
  const float along = layer == 0 ? v * kPi : u * 2.0f * kPi, side = layer == 0 ? u * 2.0f * kPi : v * kPi;
  const float wave =
      along * 2.0f * kPi / 0.12f + 1.1f * std::sin(side * 3.1f) + 0.5f * std::sin(side * 7.7f + 1.0f);
  return 0.011f * (1.0f - std::pow(0.5f + 0.5f * std::sin(wave), 3.0f) * 2.0f);
}

template <typename T>
int16_t snorm16(T x) {
  return static_cast<int16_t>(std::lround(x * T(32767)));
}

}  // namespace

struct BallAsset::Arrays {
  std::vector<Float3> positions, normals;
  std::vector<Float4> tangents;
  std::vector<Float2> uvs;
  std::vector<uint32_t> source_vertex, vertex_point, indices, surface_indices, point_vertex, ring_offsets,
      ring_triangles, morph_vertices, morph_entries;
  std::vector<uint16_t> joints, weights, ring_weights;
  std::vector<int32_t> morph_deltas;
  std::vector<int16_t> bias;
  std::vector<float> coefficients[2];
  std::vector<uint8_t> masks[2];
  std::vector<int8_t> directions[2];
  pipeline::EncodedTexture normal_maps, shading_maps, mask_maps;
  Part part{};
  PaletteEntry palette[2]{};
  Morph morph{};
  Layer layers[2]{};
  TextureSet texture_set{};

  void makeVertices();
  void makeTriangles();
  void makeRings();
  void makeMorph();
  void makeLayers();
  void makeMaps();
};

void BallAsset::Arrays::makeVertices() {
  for (uint32_t row = 0; row <= kRows; ++row)
    for (uint32_t column = 0; column <= kColumns; ++column) {
      const float u = static_cast<float>(column) / kColumns, v = static_cast<float>(row) / kRows;
      // The seam and the poles lie at one place to the bit.
      const bool pole = row == 0 || row == kRows;
      const glm::vec3 p =
          pole ? glm::vec3(0, row == 0 ? 1 : -1, 0) : onBall(column == kColumns ? 0.0f : u, v);
      const float longitude = (u - 0.5f) * 2.0f * kPi;
      positions.push_back({p.x, p.y, p.z});
      normals.push_back({p.x, p.y, p.z});
      tangents.push_back({std::cos(longitude), 0.0f, -std::sin(longitude), 1.0f});
      uvs.push_back({u, v});
      source_vertex.push_back(static_cast<uint32_t>(source_vertex.size()));
      const uint32_t vertex = static_cast<uint32_t>(vertex_point.size());
      if ((pole && column > 0) || column == kColumns) {
        vertex_point.push_back(vertex_point[row * (kColumns + 1)]);
      } else {
        vertex_point.push_back(static_cast<uint32_t>(point_vertex.size()));
        point_vertex.push_back(vertex);
      }
      const auto upper = static_cast<uint16_t>(std::lround(65535.0f * smooth(-0.35f, 0.35f, p.y)));
      joints.insert(joints.end(), {0, 1});
      weights.insert(weights.end(), {static_cast<uint16_t>(65535 - upper), upper});
    }
}

void BallAsset::Arrays::makeTriangles() {
  for (uint32_t row = 0; row < kRows; ++row)
    for (uint32_t column = 0; column < kColumns; ++column) {
      const uint32_t a = row * (kColumns + 1) + column, b = a + 1, c = a + kColumns + 1, d = c + 1;
      if (row > 0) indices.insert(indices.end(), {a, c, b});
      if (row + 1 < kRows) indices.insert(indices.end(), {b, c, d});
    }
  for (uint32_t vertex : indices) surface_indices.push_back(point_vertex[vertex_point[vertex]]);
}

void BallAsset::Arrays::makeRings() {
  struct Corner {
    uint32_t triangle;
    float angle;
  };
  std::vector<std::vector<Corner>> rings(point_vertex.size());
  const auto at = [&](uint32_t i) {
    const Float3 p = positions[surface_indices[i]];
    return glm::vec3(p.x, p.y, p.z);
  };
  for (uint32_t i = 0; i < surface_indices.size(); ++i) {
    const uint32_t t = i / 3;
    const glm::vec3 e1 = at(3 * t + (i + 1) % 3) - at(i), e2 = at(3 * t + (i + 2) % 3) - at(i);
    const float angle = std::acos(std::clamp(glm::dot(glm::normalize(e1), glm::normalize(e2)), -1.0f, 1.0f));
    rings[vertex_point[surface_indices[i]]].push_back({t, angle});
  }
  ring_offsets.push_back(0);
  for (const auto& ring : rings) {
    float sum = 0.0f;
    for (const Corner& corner : ring) sum += corner.angle;
    uint32_t left = 65535;
    for (size_t i = 0; i < ring.size(); ++i) {
      const auto share = i + 1 == ring.size() ? left : static_cast<uint32_t>(65535.0f * ring[i].angle / sum);
      left -= share;
      ring_triangles.push_back(ring[i].triangle);
      ring_weights.push_back(static_cast<uint16_t>(share));
    }
    ring_offsets.push_back(static_cast<uint32_t>(ring_triangles.size()));
  }
}

void BallAsset::Arrays::makeMorph() {
  constexpr float kStep = 1.0f / 32767.0f;
  std::vector<uint32_t> entries;
  morph_entries.assign(positions.size() + 1, 0);
  for (uint32_t v = 0; v < positions.size(); ++v) {
    morph_entries[v] = static_cast<uint32_t>(morph_vertices.size());
    const Float3 p = positions[v];
    const float pull = -0.45f * p.x * maskAt(0, {p.x, p.y, p.z});
    if (pull == 0.0f) continue;
    const int32_t dx = snorm16(pull);
    morph_vertices.push_back(v);
    morph_deltas.insert(morph_deltas.end(), {dx, 0, 0});
    entries.insert(entries.end(), {static_cast<uint32_t>(dx) & 0xffffffu, 0u, 0u, 0u});
  }
  morph_entries[positions.size()] = static_cast<uint32_t>(morph_vertices.size());
  morph_entries.insert(morph_entries.end(), entries.begin(), entries.end());
  morph = {"pinch", 0.0f, kStep, 1.0f / 127.0f, morph_vertices, morph_deltas, {}};
}

void BallAsset::Arrays::makeLayers() {
  const auto vec = [](Float3 p) { return glm::vec3(p.x, p.y, p.z); };
  const auto directionAt = [](uint32_t layer, glm::vec3 p) {
    const glm::vec3 east = glm::vec3(p.z, 0.0f, -p.x);
    const glm::vec3 d = layer == 0 ? glm::cross(p, east) : east;
    return glm::length(d) > 1e-3f ? glm::normalize(d) : glm::vec3(0.0f);
  };
  for (uint32_t layer = 0; layer < 2; ++layer) {
    for (size_t i = 0; i < surface_indices.size(); i += 3) {
      const glm::vec3 p0 = vec(positions[surface_indices[i]]);
      const glm::vec3 e1 = vec(positions[surface_indices[i + 1]]) - p0,
                      e2 = vec(positions[surface_indices[i + 2]]) - p0;
      const glm::vec3 d = directionAt(layer, glm::normalize(p0 + (e1 + e2) / 3.0f));
      const float a = glm::dot(e1, e1), b = glm::dot(e1, e2), c = glm::dot(e2, e2), f = glm::dot(d, e1),
                  g = glm::dot(d, e2);
      const float c1 = (c * f - b * g) / (a * c - b * b), c2 = (a * g - b * f) / (a * c - b * b);
      const float length = glm::length(c1 * e1 + c2 * e2);
      coefficients[layer].insert(coefficients[layer].end(), {c1 / length, c2 / length});
    }
    for (const Float3& p : positions)
      masks[layer].push_back(static_cast<uint8_t>(std::lround(255.0f * maskAt(layer, vec(p)))));
    for (uint32_t v : point_vertex) {
      const glm::vec3 d = directionAt(layer, vec(positions[v]));
      for (int i = 0; i < 3; ++i)
        directions[layer].push_back(static_cast<int8_t>(std::lround(127.0f * d[i])));
      directions[layer].push_back(
          static_cast<int8_t>(std::lround(127.0f * (0.15f + 0.85f * maskAt(layer, vec(positions[v]))))));
    }
    layers[layer] = {layer == 0 ? "lines" : "frown",
                     Measure::kDirectional,
                     Response{},
                     coefficients[layer],
                     {},
                     masks[layer],
                     directions[layer],
                     layer,
                     0,
                     0};
  }
  for (const Float3& p : positions) bias.push_back(snorm16(p.x < -0.2f ? 0.5f : 0.0f));
  layers[1].bias = bias;
}

void BallAsset::Arrays::makeMaps() {
  using pipeline::Image;
  const auto image = [](uint32_t channels) {
    return Image{kMapSize, kMapSize, channels, std::vector<float>(size_t{kMapSize} * kMapSize * channels)};
  };
  std::vector<Image> normal_slices, shading_slices;
  Image mask = image(4);
  for (uint32_t slice = 0; slice < 3;
       ++slice) {  // lines, frown, and half of the lines for the stretched pose
    Image normal = image(2), shading = image(1);
    const uint32_t layer = slice == 1 ? 1 : 0;
    const float gain = slice == 2 ? 0.5f : 1.0f;
    for (uint32_t y = 0; y < kMapSize; ++y)
      for (uint32_t x = 0; x < kMapSize; ++x) {
        const float u = (static_cast<float>(x) + 0.5f) / kMapSize,
                    v = (static_cast<float>(y) + 0.5f) / kMapSize;
        const float turn = slice == 2 ? 0.25f : 0.0f;  // the stretch map runs elsewhere
        const float e = 1.0f / 4096.0f, width = std::max(std::sin(v * kPi), 0.05f);
        const float hx = (heightAt(layer, u + e + turn, v) - heightAt(layer, u - e + turn, v)) /
                         (2.0f * e * 2.0f * kPi * width);
        const float hy =
            -(heightAt(layer, u + turn, v + e) - heightAt(layer, u + turn, v - e)) / (2.0f * e * kPi);
        const glm::vec3 n = glm::normalize(glm::vec3(-hx * gain, -hy * gain, 1.0f));
        normal.at(x, y)[0] = n.x;
        normal.at(x, y)[1] = n.y;
        shading.at(x, y)[0] =
            gain * 0.7f * std::clamp(0.5f - heightAt(layer, u + turn, v) / 0.022f, 0.0f, 1.0f);
        const glm::vec3 p = onBall(u, v);
        mask.at(x, y)[0] = maskAt(0, p);
        mask.at(x, y)[1] = maskAt(1, p);
      }
    normal_slices.push_back(std::move(normal));
    shading_slices.push_back(std::move(shading));
  }
  normal_maps = pipeline::encode(TextureFormat::kBc5, normal_slices);
  shading_maps = pipeline::encode(TextureFormat::kBc4, shading_slices);
  mask_maps = pipeline::encodeBytes(std::array{pipeline::toBytes(mask)});
  const auto view = [](const pipeline::EncodedTexture& t) {
    return Texture{t.format, t.width, t.height, t.slices, t.levels, t.data};
  };
  texture_set.name = "ball";
  texture_set.normals = view(normal_maps);
  texture_set.shading = view(shading_maps);
  texture_set.masks = view(mask_maps);
  std::fill(std::begin(texture_set.compress_slice), std::end(texture_set.compress_slice), kAbsent);
  std::fill(std::begin(texture_set.stretch_slice), std::end(texture_set.stretch_slice), kAbsent);
  std::fill(std::begin(texture_set.windows), std::end(texture_set.windows), Float4{0, 0, 1, 1});
  texture_set.compress_slice[0] = 0;
  texture_set.compress_slice[1] = 1;
  texture_set.stretch_slice[0] = 2;
}

BallAsset::BallAsset(const BallOptions& options) : arrays_(std::make_unique<Arrays>()) {
  Arrays& a = *arrays_;
  a.makeVertices();
  a.makeTriangles();
  a.makeRings();
  a.makeMorph();
  a.makeLayers();
  if (options.maps) a.makeMaps();
  if (!options.masks) a.texture_set.masks = {};
  a.palette[0].node = "lower";
  a.palette[1].node = "upper";
  a.part.mesh = "ball";
  a.part.vertex_end = static_cast<uint32_t>(a.positions.size());
  a.part.triangle_end = static_cast<uint32_t>(a.indices.size() / 3);
  a.part.texture_set = options.maps ? 0 : kAbsent;
  a.part.base_color = {1, 1, 1, 1};
  a.part.has_normals = a.part.has_uvs = true;

  view_.positions = a.positions;
  view_.normals = a.normals;
  view_.tangents = a.tangents;
  view_.uvs = a.uvs;
  view_.source_vertex = a.source_vertex;
  view_.vertex_point = a.vertex_point;
  view_.influences = 2;
  view_.joints = a.joints;
  view_.weights = a.weights;
  view_.indices = a.indices;
  view_.surface_indices = a.surface_indices;
  view_.point_vertex = a.point_vertex;
  view_.ring_offsets = a.ring_offsets;
  view_.ring_triangles = a.ring_triangles;
  view_.ring_weights = a.ring_weights;
  view_.morph_entries = a.morph_entries;
  view_.parts = {&a.part, 1};
  view_.palette = a.palette;
  view_.morphs = {&a.morph, 1};
  view_.layers = a.layers;
  if (options.maps) view_.texture_sets = {&a.texture_set, 1};
}

BallAsset::~BallAsset() = default;

}  // namespace furrow::tests
