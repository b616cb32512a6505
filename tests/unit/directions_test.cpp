// Direction fields with known answers: from guide curves, images, attributes and the squeeze.

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <map>
#include <numbers>

#include "pipeline/bake/image_directions.h"
#include "pipeline/bake/intrinsic_delaunay.h"
#include "pipeline/bake/multigrid.h"
#include "pipeline/bake/nearest.h"
#include "sheets.h"

namespace furrow::tests {
namespace {

using namespace pipeline;
using Segments = std::vector<std::array<glm::dvec3, 2>>;

constexpr double kPi = std::numbers::pi, kDegree = kPi / 180.0;

// Degrees between two lines.
double apart(glm::dvec3 a, glm::dvec3 b) {
  return std::acos(std::min(1.0, std::abs(glm::dot(glm::normalize(a), glm::normalize(b))))) / kDegree;
}

void addNormals(Surface& surface) {
  std::vector<glm::vec3> normals(surface.point_positions.size(), glm::vec3(0.0f));
  for (size_t t = 0; t < surface.triangles.size(); ++t) {
    const glm::uvec3 p = surface.trianglePoints(t);
    const glm::vec3 a = surface.point_positions[p.x];
    for (int c = 0; c < 3; ++c)
      normals[p[c]] += glm::cross(surface.point_positions[p.y] - a, surface.point_positions[p.z] - a);
  }
  for (const glm::vec3& n : normals) surface.point_normals.push_back(glm::normalize(n));
}

// rows x columns quads of at(u, v), u and v in [0, 1]; every vertex is a point.
template <class At>
Surface grid(uint32_t columns, uint32_t rows, const At& at) {
  Surface surface;
  for (uint32_t row = 0; row <= rows; ++row)
    for (uint32_t column = 0; column <= columns; ++column) {
      const glm::dvec2 uv(static_cast<double>(column) / columns, static_cast<double>(row) / rows);
      surface.positions.emplace_back(at(uv.x, uv.y));
      surface.uvs.emplace_back(uv);
      surface.vertex_point.push_back(static_cast<uint32_t>(surface.vertex_point.size()));
    }
  for (uint32_t row = 0; row < rows; ++row)
    for (uint32_t column = 0; column < columns; ++column) {
      const uint32_t a = row * (columns + 1) + column, b = a + 1, c = a + columns + 1;
      surface.triangles.emplace_back(a, b, c + 1);
      surface.triangles.emplace_back(a, c + 1, c);
    }
  surface.point_positions = surface.positions;
  addNormals(surface);
  SurfacePart part;
  part.vertex_end = static_cast<uint32_t>(surface.positions.size());
  part.triangle_end = static_cast<uint32_t>(surface.triangles.size());
  part.has_uvs = true;
  surface.parts = {part};
  return surface;
}

Surface square(uint32_t n) {
  return grid(n, n, [](double u, double v) { return glm::dvec3(u, v, 0.0); });
}

std::vector<bool> all(const Surface& surface) {
  return std::vector<bool>(surface.triangles.size(), true);
}

// The worst angle to `wanted`(position) over the points where `where`(position).
template <class Wanted, class Where>
double worst(const Surface& surface, const DirectionField& field, const Wanted& wanted, const Where& where) {
  double most = 0.0;
  size_t points = 0;
  for (size_t p = 0; p < surface.point_positions.size(); ++p) {
    const glm::dvec3 at = surface.point_positions[p];
    if (!where(at)) continue;
    most = std::max(most, apart(field.direction[p], wanted(at)));
    ++points;
  }
  EXPECT_GT(points, 8u);
  return most;
}

const auto kEverywhere = [](glm::dvec3) { return true; };

// ---- images ----

// A square in the xy plane whose chart is turned, stretched and mirrored: uv = chart * xy.
Surface charted(uint32_t n, glm::dmat2 chart) {
  Surface surface = square(n);
  for (size_t v = 0; v < surface.uvs.size(); ++v)
    surface.uvs[v] = chart * glm::dvec2(surface.positions[v].x, surface.positions[v].y);
  return surface;
}

glm::dmat2 turn(double angle) {
  return {std::cos(angle), std::sin(angle), -std::sin(angle), std::cos(angle)};
}

// Whole waves (x, y) over the image, so that it repeats.
Image waves(uint32_t size, glm::ivec2 count) {
  Image image{size, size, 1, std::vector<float>(size_t{size} * size)};
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) {
      const double phase = 2.0 * kPi * ((x + 0.5) * count.x + (y + 0.5) * count.y) / size;
      image.at(x, y)[0] = static_cast<float>(0.5 + 0.5 * std::sin(phase));
    }
  return image;
}

// A normal map of the same relief, 8 bits a channel; `slope` at its steepest, for isotropic charts.
Image waveSlopes(uint32_t size, glm::ivec2 count, double slope) {
  Image image{size, size, 2, std::vector<float>(size_t{2} * size * size)};
  const glm::dvec2 k = glm::normalize(glm::dvec2(count));
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) {
      const double phase = 2.0 * kPi * ((x + 0.5) * count.x + (y + 0.5) * count.y) / size;
      const double s = slope * std::cos(phase);  // rows run down, slopes up
      image.at(x, y)[0] = static_cast<float>(-s * k.x);
      image.at(x, y)[1] = static_cast<float>(s * k.y);
    }
  return image;
}

struct Chart {
  const char* name;
  glm::dmat2 matrix;
};
const Chart kCharts[] = {{"plain", glm::dmat2(1.0)},
                         {"turned", turn(0.7)},
                         {"mirrored", glm::dmat2(-1, 0, 0, 1)},
                         {"mirrored, turned and small", 0.4 * glm::dmat2(-1, 0, 0, 1) * turn(1.9)},
                         {"repeated", 3.0 * turn(0.3)}};

TEST(ImageDirections, ASineReliefIsWithinTwoDegreesOfItsRidgesNormal) {
  for (const glm::ivec2 count : {glm::ivec2(16, 0), {15, 4}, {12, 11}, {-9, 14}, {0, 20}, {31, 12}})
    for (const Chart& chart : kCharts)
      for (const uint32_t n : {2u, 24u}) {
        const Surface surface = charted(n, chart.matrix);
        // The phase is count . uv, so its gradient in the plane is chart^T count.
        const glm::dvec3 across(glm::transpose(chart.matrix) * glm::dvec2(count), 0.0);
        const DirectionField heights = directionsFromTensors(
            surface, all(surface),
            tensorsOfImage(surface, all(surface), waves(256, count), ImageKind::kHeight));
        const DirectionField normals = directionsFromTensors(
            surface, all(surface),
            tensorsOfImage(surface, all(surface), waveSlopes(256, count, 0.4), ImageKind::kSlopes));
        const auto wanted = [&](glm::dvec3) { return across; };
        EXPECT_LT(worst(surface, heights, wanted, kEverywhere), 2.0)
            << count.x << ' ' << count.y << ' ' << chart.name << ' ' << n;
        EXPECT_LT(worst(surface, normals, wanted, kEverywhere), 2.0)
            << count.x << ' ' << count.y << ' ' << chart.name << ' ' << n;
        for (float c : heights.confidence) EXPECT_GT(c, 0.8f);
      }
}

TEST(ImageDirections, AStretchedChartTurnsTheRidgesOfAHeightMap) {
  const glm::dmat2 chart = glm::dmat2(2.0, 0.0, 0.0, 0.5) * turn(0.4);
  const Surface surface = charted(16, chart);
  const glm::ivec2 count(10, 13);
  const DirectionField field = directionsFromTensors(
      surface, all(surface), tensorsOfImage(surface, all(surface), waves(512, count), ImageKind::kHeight));
  const glm::dvec3 across(glm::transpose(chart) * glm::dvec2(count), 0.0);
  EXPECT_LT(worst(
                surface, field, [&](glm::dvec3) { return across; }, kEverywhere),
            2.0);
}

TEST(ImageDirections, AReliefWithoutADirectionIsNotSureOfOne) {
  const Surface surface = square(16);
  Image image = waves(256, {16, 0});
  const Image other = waves(256, {0, 16});
  for (size_t i = 0; i < image.pixels.size(); ++i)
    image.pixels[i] = 0.5f * (image.pixels[i] + other.pixels[i]);
  for (const Image& relief : {image, Image{8, 8, 1, std::vector<float>(64, 0.5f)}}) {
    const DirectionField field = directionsFromTensors(
        surface, all(surface), tensorsOfImage(surface, all(surface), relief, ImageKind::kHeight));
    for (size_t p = 0; p < field.direction.size(); ++p) {
      EXPECT_LT(field.confidence[p], 0.1f);
      EXPECT_NEAR(glm::length(field.direction[p]), 1.0f, 1e-5f);
    }
  }
}

TEST(ImageDirections, AFlowTextureComesBackThroughAnyChart) {
  const auto flow = [](glm::dvec2 xy) {
    const double angle = 0.4 + 1.6 * xy.x - 0.9 * xy.y;
    return glm::dvec2(std::cos(angle), std::sin(angle));
  };
  for (const Chart& chart :
       {kCharts[0], kCharts[3], Chart{"stretched", 0.5 * glm::dmat2(1, 0.2, 0, 0.4) * turn(0.3)}}) {
    Surface surface = charted(30, chart.matrix);
    for (glm::vec2& uv : surface.uvs) uv += glm::vec2(5.0f, -3.0f);  // repeats
    const glm::dmat2 to_xy = glm::inverse(chart.matrix);
    const uint32_t size = 256;
    Image image{size, size, 4, std::vector<float>(size_t{4} * size * size, 1.0f)};
    for (uint32_t y = 0; y < size; ++y)
      for (uint32_t x = 0; x < size; ++x) {
        glm::dvec2 uv = (glm::dvec2(x, y) + 0.5) / static_cast<double>(size);
        // The chart is within one period of the origin, on whichever side.
        glm::dvec2 xy = to_xy * uv;
        for (const double du : {0.0, -1.0})
          for (const double dv : {0.0, -1.0}) {
            const glm::dvec2 other = to_xy * (uv + glm::dvec2(du, dv));
            if (std::abs(other.x - 0.5) + std::abs(other.y - 0.5) <
                std::abs(xy.x - 0.5) + std::abs(xy.y - 0.5))
              xy = other;
          }
        const glm::dvec2 in_uv = glm::normalize(chart.matrix * flow(xy));
        const double sign = (x + y) % 2 ? 1.0 : -1.0;  // which must not matter
        image.at(x, y)[0] = static_cast<float>(std::round((0.5 + 0.5 * sign * in_uv.x) * 255.0) / 255.0);
        image.at(x, y)[1] = static_cast<float>(std::round((0.5 - 0.5 * sign * in_uv.y) * 255.0) / 255.0);
      }
    const DirectionField field = directionsFromTensors(
        surface, all(surface), tensorsOfImage(surface, all(surface), image, ImageKind::kFlow));
    EXPECT_LT(worst(
                  surface, field, [&](glm::dvec3 p) { return glm::dvec3(flow(glm::dvec2(p)), 0.0); },
                  [](glm::dvec3 p) {
                    return std::min({p.x, p.y, 1 - p.x, 1 - p.y}) > 0.06;
                  }),
              2.0)
        << chart.name;
  }
}

TEST(ImageDirections, WildUvsSayNothing) {
  Surface surface = square(4);
  surface.uvs.assign(surface.uvs.size(), glm::vec2(0.5f));
  surface.uvs[0] = glm::vec2(3e38f, -3e38f);
  surface.uvs[7] = glm::vec2(1e20f);
  for (const ImageKind kind : {ImageKind::kFlow, ImageKind::kHeight, ImageKind::kSlopes})
    for (const glm::vec3& tensor : tensorsOfImage(surface, all(surface), waveSlopes(8, {1, 0}, 0.4), kind))
      EXPECT_EQ(tensor, glm::vec3(0.0f));
}

// ---- guides ----

Segments curve(const std::vector<glm::dvec3>& points) {
  Segments segments;
  for (size_t i = 0; i + 1 < points.size(); ++i) segments.push_back({points[i], points[i + 1]});
  return segments;
}

TEST(Guides, HelicesOnACylinderGiveTheDirectionAcrossThem) {
  for (const double pitch : {0.0, 0.5, -1.2}) {
    // The creases run around and rise by `pitch`.
    const auto at = [](double angle, double y) { return glm::dvec3(std::sin(angle), y, std::cos(angle)); };
    Surface surface = grid(96, 40, [&](double u, double v) { return at(2.0 * kPi * u, 3.0 * v); });
    for (uint32_t& point : surface.vertex_point) point = point % 97 == 96 ? point - 96 : point;  // closed
    surface.point_normals.clear();
    for (glm::dvec3 p : surface.point_positions)
      surface.point_normals.emplace_back(glm::normalize(glm::dvec3(p.x, 0, p.z)));
    std::vector<glm::dvec3> points;
    for (int i = 0; i <= 40; ++i)
      points.push_back(1.01 * at(0.1 * i, 0.0) + glm::dvec3(0, 1.5 + pitch * (0.1 * i - 2.0) * 0.3, 0));
    const double rise = 0.3 * pitch;
    const DirectionField field = directionsFromGuides(surface, all(surface), curve(points));
    const auto wanted = [&](glm::dvec3 p) {
      const glm::dvec3 around = glm::normalize(glm::dvec3(p.z, 0.0, -p.x));
      return glm::dvec3(0, 1, 0) - rise * around;
    };
    EXPECT_LT(worst(surface, field, wanted, kEverywhere), 2.0) << pitch;
    // Sure at the curve, less and less away from it.
    double near = 0.0, far = 1.0;
    for (size_t p = 0; p < surface.point_positions.size(); ++p) {
      if (surface.vertex_point[p] != p) continue;
      const glm::dvec3 q = surface.point_positions[p];
      if (std::abs(q.y - 1.5) < 0.05 && q.x > 0.9) near = std::max(near, double{field.confidence[p]});
      if (q.y < 0.05) far = std::min(far, double{field.confidence[p]});
    }
    EXPECT_GT(near, 0.8);
    EXPECT_LT(far, 0.4);
  }
}

TEST(Guides, CirclesOfLatitudeOnASphereGiveItsMeridians) {
  const auto at = [](double angle, double down) {
    return glm::dvec3(std::sin(down) * std::sin(angle), std::cos(down), std::sin(down) * std::cos(angle));
  };
  const Surface surface = grid(90, 60, [&](double u, double v) { return at(3.0 * u, 0.5 + 2.1 * v); });
  Segments segments;
  for (const double down : {0.7, 1.5, 2.4}) {
    std::vector<glm::dvec3> points;
    for (int i = 0; i <= 30; ++i) points.push_back(at(0.1 * i, down));
    for (const auto& segment : curve(points)) segments.push_back(segment);
  }
  const DirectionField field = directionsFromGuides(surface, all(surface), segments);
  const auto meridian = [](glm::dvec3 p) { return glm::dvec3(0, 1, 0) - p.y * p; };
  // Between the curves, away from the free borders, where a smoother field than the meridians bends away.
  EXPECT_LT(
      worst(surface, field, meridian,
            [](glm::dvec3 p) { return std::abs(std::atan2(p.x, p.z) - 1.5) < 1.0 && std::abs(p.y) < 0.75; }),
      4.0);
}

TEST(Guides, ThatRunAgainstEachOtherAgree) {
  const Surface surface = square(40);
  const Segments forth = curve({{0.1, 0.3, 0}, {0.9, 0.4, 0}}), back = curve({{0.9, 0.6, 0}, {0.1, 0.5, 0}});
  Segments both = forth;
  both.insert(both.end(), back.begin(), back.end());
  const DirectionField field = directionsFromGuides(surface, all(surface), both);
  const auto across = [](glm::dvec3) { return glm::dvec3(-0.1, 0.8, 0.0); };
  EXPECT_LT(worst(surface, field, across, kEverywhere), 0.5);
  const DirectionField one = directionsFromGuides(surface, all(surface), forth);
  for (size_t p = 0; p < field.confidence.size(); ++p)
    EXPECT_GE(field.confidence[p], one.confidence[p] - 1e-3f);
}

TEST(Guides, StayOnTheSurfaceThatIsCovered) {
  Surface surface = square(20);
  std::vector<bool> covered = all(surface);
  for (size_t t = 0; t < covered.size() / 2; ++t) covered[t] = false;
  const DirectionField field =
      directionsFromGuides(surface, covered, curve({{0.2, 0.7, 0.0}, {0.8, 0.7, 0.01}}));
  for (size_t p = 0; p < field.direction.size(); ++p)
    EXPECT_EQ(field.direction[p] == glm::vec3(0.0f), surface.positions[p].y < 0.49f);
}

std::string faultOf(const Segments& segments) {
  const Surface surface = square(10);
  try {
    directionsFromGuides(surface, all(surface), segments);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "none";
}

TEST(Guides, OffTheSurfaceOrWithoutLengthAreRefused) {
  EXPECT_EQ(faultOf(curve({{0.1, 0.5, 0.02}, {0.9, 0.5, -0.02}})), "none");
  EXPECT_EQ(faultOf(curve({{0.1, 0.5, 0}, {0.9, 0.5, 3.5}})),
            "a guide curve at (0.9, 0.5, 3.5) is 3.5 from its surface, which is 1 across");
  EXPECT_EQ(faultOf(curve({{0.1, 0.5, 0}, {0.1, 0.5, 0}})), "its guide curves have no length");
  EXPECT_EQ(faultOf({}), "its guide curves have no length");
}

TEST(NearestTriangle, IsWhatASearchOfAllPlacesFinds) {
  const Surface surface =
      grid(9, 7, [](double u, double v) { return glm::dvec3(u, v, 0.3 * std::sin(7 * u) * v); });
  const NearestTriangle nearest(surface, all(surface));
  for (int k = 0; k < 60; ++k) {
    const glm::dvec3 p(std::fmod(0.37 * k, 1.6) - 0.3, std::fmod(0.61 * k, 1.6) - 0.3,
                       std::fmod(0.23 * k, 1.0) - 0.5);
    double least = INFINITY;
    for (const glm::uvec3& t : surface.triangles)
      for (int i = 0; i <= 40; ++i)
        for (int j = 0; i + j <= 40; ++j) {
          const glm::dvec3 a = surface.positions[t.x], b = surface.positions[t.y], c = surface.positions[t.z];
          least = std::min(least, glm::distance(p, a + (b - a) * (i / 40.0) + (c - a) * (j / 40.0)));
        }
    const auto found = nearest.find(p);
    EXPECT_LE(found.distance, least + 1e-9);
    EXPECT_GE(found.distance, least - 0.005);
  }
}

// ---- smoothing ----

TEST(LineField, DAndMinusDDoNotCancel) {
  const Surface surface = square(12);
  std::vector<glm::vec3> vectors;
  for (size_t v = 0; v < surface.positions.size(); ++v)
    vectors.push_back((v % 3 ? 1.0f : -5.0f) * glm::vec3(0.6f, 0.8f, 0.0f));
  const DirectionField field =
      directionsFromTensors(surface, all(surface), tensorsOfVectors(surface, vectors));
  EXPECT_LT(worst(
                surface, field, [](glm::dvec3) { return glm::dvec3(0.6, 0.8, 0.0); }, kEverywhere),
            0.1);
  for (float c : field.confidence) EXPECT_GT(c, 0.95f);
}

TEST(LineField, ASqueezedRegionOutvotesAStillOne) {
  const Surface surface = square(40);
  LineTensors tensors;
  for (const glm::uvec3& t : surface.triangles)  // still: faint, and all along y
    tensors.push_back(surface.positions[t.x].x < 0.5f ? glm::vec3(0.2f, 0.0f, 0.0f)
                                                      : glm::vec3(0.0f, 0.0f, 0.0002f));
  // The frames of the two kinds of triangles differ; what is along x in the plane is made so in both.
  for (size_t t = 0; t < tensors.size(); ++t) {
    const glm::uvec3 v = surface.triangles[t];
    const TriangleFrame frame =
        triangleFrame(surface.positions[v.x], surface.positions[v.y], surface.positions[v.z]);
    const glm::dvec3 d = tensors[t].x > 0.0f ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const double strength = tensors[t].x + tensors[t].z, x = glm::dot(d, frame.x), y = glm::dot(d, frame.y);
    tensors[t] = glm::vec3(strength * x * x, strength * x * y, strength * y * y);
  }
  const DirectionField field = directionsFromTensors(surface, all(surface), tensors);
  const auto along = [](glm::dvec3) { return glm::dvec3(1, 0, 0); };
  EXPECT_LT(worst(surface, field, along, [](glm::dvec3 p) { return p.x < 0.55; }), 1.0);
}

TEST(LineField, PlacesWithoutEvidenceAreFilledAndLessSure) {
  const Surface surface = square(30);
  std::vector<glm::vec3> vectors(surface.positions.size(), glm::vec3(0.0f));
  for (size_t v = 0; v < vectors.size(); ++v)
    if (surface.positions[v].x < 0.2f) vectors[v] = glm::vec3(1.0f, 1.0f, 0.0f);
  const DirectionField field =
      directionsFromTensors(surface, all(surface), tensorsOfVectors(surface, vectors));
  EXPECT_LT(worst(
                surface, field, [](glm::dvec3) { return glm::dvec3(1, 1, 0); }, kEverywhere),
            0.1);
  EXPECT_GT(field.confidence[15 * 31], 0.95f);
  EXPECT_LT(field.confidence[15 * 31 + 30], 0.25f);
}

// The same bump, squeezed the same way, in coarse and in fine triangles of other shapes, and in rows that are
// pushed along each other until most triangles are obtuse.
TEST(LineField, IsOfTheSurfaceAndNotOfItsTriangles) {
  const auto height = [](glm::dvec2 p) { return 0.35 * std::exp(-6.0 * glm::dot(p - 0.5, p - 0.5)); };
  const auto field = [&](uint32_t columns, uint32_t rows, double uneven, double pushed, Surface& surface) {
    surface = grid(columns, rows, [&](double u, double v) {
      const double push = pushed * std::sin(kPi * u) * std::sin(6.0 * kPi * v);
      const glm::dvec2 p(u + uneven * std::sin(2.0 * kPi * u) * std::sin(kPi * v) + push,
                         v + uneven * std::sin(4.0 * kPi * v));
      return glm::dvec3(p, height(p));
    });
    LineTensors tensors;
    for (const glm::uvec3& t : surface.triangles) {
      const glm::dvec3 middle =
          glm::dvec3(surface.positions[t.x] + surface.positions[t.y] + surface.positions[t.z]) / 3.0;
      const TriangleFrame frame =
          triangleFrame(surface.positions[t.x], surface.positions[t.y], surface.positions[t.z]);
      const glm::dvec3 d(std::cos(3.0 * middle.y), std::sin(3.0 * middle.y), 0.0);
      const double s = std::max(0.0, 1.0 - 3.0 * glm::distance(glm::dvec2(middle), glm::dvec2(0.4, 0.5)));
      const double x = glm::dot(d, frame.x), y = glm::dot(d, frame.y);
      tensors.push_back(glm::vec3(s * x * x, s * x * y, s * y * y));
    }
    return directionsFromTensors(surface, all(surface), tensors);
  };
  Surface fine;
  const DirectionField from_fine = field(110, 80, 0.05, 0.0, fine);
  const NearestTriangle nearest(fine, all(fine));
  for (const double pushed : {0.0, 0.1}) {
    Surface coarse;
    const DirectionField from_coarse = field(24, 31, 0.0, pushed, coarse);
    double most = 0.0, most_confidence = 0.0;
    for (size_t p = 0; p < coarse.point_positions.size(); ++p) {
      const auto found = nearest.find(coarse.point_positions[p]);
      const glm::uvec3 corners = fine.trianglePoints(found.triangle);
      const int c = found.barycentric.x > 0.4 ? 0 : found.barycentric.y > 0.4 ? 1 : 2;
      if (from_coarse.confidence[p] > 0.3f)
        most = std::max(most, apart(from_coarse.direction[p], from_fine.direction[corners[c]]));
      most_confidence = std::max(
          most_confidence, std::abs(double{from_coarse.confidence[p]} - from_fine.confidence[corners[c]]));
    }
    EXPECT_LT(most, 5.0) << pushed;
    EXPECT_LT(most_confidence, 0.1) << pushed;
  }
}

// A lone triangle's edges have nobody to make up for an angle of more than 90 degrees, which would push its
// ends apart, or for one of next to none, which would make one of them: their weights end at 0 and at 10.
TEST(LineField, WeightsOfEdgesEndAtNothingAndAtTen) {
  struct Case {
    std::array<glm::vec3, 3> corners;
    double ab, bc, ca;  // half the cotangents of the angles that face them
  };
  for (const auto& [corners, ab, bc, ca] :
       {Case{{glm::vec3(0, 0, 0), {2, 0, 0}, {1, 0.5f, 0}}, 0.0, 1.0, 1.0},         // not -0.375
        Case{{glm::vec3(0, 0, 0), {1, 0, 0}, {1, 0.01f, 0}}, 0.005, 10.0, 0.0}}) {  // not 50
    Surface surface;
    surface.positions.assign(corners.begin(), corners.end());
    surface.point_positions = surface.positions;
    surface.vertex_point = {0, 1, 2};
    surface.triangles = {{0, 1, 2}};
    addNormals(surface);
    const std::vector<bool> covered = {true};
    for (int from = 0; from < 3; ++from) {
      constexpr double kPull = 3.0;
      glm::dvec3 at(0.0);
      at[from] = 1.0;
      LineField field(surface, covered);
      field.add(0, at, 1.0, kPull);
      const DirectionField found = std::move(field).solve();
      const double own = 16.0 / 3.0;  // a third of the area over the square of R
      glm::dmat3 equations({own + ab + ca, -ab, -ca}, {-ab, own + ab + bc, -bc}, {-ca, -bc, own + bc + ca});
      equations[from][from] += kPull;
      const glm::dvec3 z = glm::inverse(equations) * (kPull * at);
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(found.confidence[c], z[c], 1e-4) << from << ' ' << c;
        EXPECT_TRUE(z[c] < 1e-3 || apart(found.direction[c], {1, 0, 0}) < 0.1) << from << ' ' << c;
      }
    }
  }
}

// ---- the solver ----

// Long thin triangles, as hair has them: a thousandth of the weight across them, and next to no diagonal.
TEST(Multigrid, SolvesWhatIsStretched) {
  constexpr int kSide = 200;
  constexpr double kAcross = 1e-3, kDiagonal = 1e-7;
  std::vector<std::map<uint32_t, std::complex<float>>> rows(kSide * kSide);
  Equations a;
  a.diagonal.assign(rows.size(), kDiagonal);
  const auto connect = [&](uint32_t i, uint32_t j, double weight) {
    const std::complex<float> entry(-std::polar(weight, 0.1 * ((7 * i + 3 * j) % 5)));
    rows[i][j] = entry;
    rows[j][i] = std::conj(entry);
    for (const uint32_t k : {i, j}) a.diagonal[k] += std::abs(std::complex<double>(entry));
  };
  for (uint32_t i = 0; i < rows.size(); ++i) {
    if (i % kSide + 1 < kSide) connect(i, i + 1, kAcross);
    if (i + kSide < rows.size()) connect(i, i + kSide, 1.0);
  }
  std::vector<std::complex<double>> b;
  for (uint32_t i = 0; i < rows.size(); ++i) {
    a.begins.push_back(static_cast<uint32_t>(a.entries.size()));
    for (const auto& [column, value] : rows[i]) a.entries.push_back({column, value});
    b.emplace_back(std::sin(0.01 * i), std::cos(0.37 * i));
  }
  a.begins.push_back(static_cast<uint32_t>(a.entries.size()));
  const std::vector<std::complex<double>> x = solveMultigrid(a, b);
  double left = 0.0, given = 0.0;
  for (uint32_t i = 0; i < rows.size(); ++i) {
    std::complex<double> sum = a.diagonal[i] * x[i];
    for (const Equations::Entry& e : a.row(i)) sum += std::complex<double>(e.value) * x[e.column];
    left += std::norm(sum - b[i]);
    given += std::norm(b[i]);
  }
  EXPECT_LE(std::sqrt(left), 1.1e-5 * std::sqrt(given));
}

// A chain without evidence beside one unknown without neighbours that has some, and unknowns without
// neighbours alone: no level has anything to solve.
TEST(Multigrid, SolvesWhatFallsApart) {
  constexpr uint32_t kCount = 2000;
  for (const bool chain : {true, false}) {
    Equations a;
    for (uint32_t i = 0; i < kCount; ++i) {
      a.begins.push_back(static_cast<uint32_t>(a.entries.size()));
      for (const uint32_t j : {i - 1, i + 1})
        if (chain && i > 0 && j > 0 && j < kCount) a.entries.push_back({j, {-1.0f, 0.0f}});
      a.diagonal.push_back(0.5 + static_cast<double>(a.entries.size() - a.begins.back()));
    }
    a.begins.push_back(static_cast<uint32_t>(a.entries.size()));
    std::vector<std::complex<double>> b(kCount, 0.0);
    b[0] = {3.0, 4.0};
    const std::vector<std::complex<double>> x = solveMultigrid(a, b);
    EXPECT_LT(std::abs(x[0] - std::complex<double>(6.0, 8.0)), 1e-4);
    for (uint32_t i = 1; i < kCount; ++i) ASSERT_EQ(x[i], 0.0) << i;
  }
}

// ---- intrinsic Delaunay triangulation ----

std::vector<IntrinsicTriangle> intrinsic(const Surface& surface) {
  std::vector<IntrinsicTriangle> triangles;
  for (size_t t = 0; t < surface.triangles.size(); ++t) {
    const glm::uvec3 p = surface.trianglePoints(t);
    IntrinsicTriangle& triangle = triangles.emplace_back();
    for (int c = 0; c < 3; ++c) {
      triangle.corners[c] = p[c];
      triangle.lengths[c] = glm::distance(glm::dvec3(surface.positions[surface.triangles[t][(c + 1) % 3]]),
                                          glm::dvec3(surface.positions[surface.triangles[t][(c + 2) % 3]]));
    }
  }
  return triangles;
}

double areaOf(const std::vector<IntrinsicTriangle>& triangles) {
  double area = 0.0;
  for (const IntrinsicTriangle& t : triangles)  // sum of a^2 cot(alpha) is four times the area
    for (int c = 0; c < 3; ++c) area += 0.25 * t.lengths[c] * t.lengths[c] * t.cotangent(c);
  return area;
}

double leastWeight(const std::vector<IntrinsicTriangle>& triangles) {
  std::map<std::array<uint32_t, 2>, std::vector<double>> cotangents;
  for (const IntrinsicTriangle& t : triangles)
    for (int c = 0; c < 3; ++c) {
      const uint32_t a = t.corners[(c + 1) % 3], b = t.corners[(c + 2) % 3];
      cotangents[{std::min(a, b), std::max(a, b)}].push_back(t.cotangent(c));
    }
  double least = INFINITY;
  for (const auto& [edge, two] : cotangents)
    if (two.size() == 2) least = std::min(least, two[0] + two[1]);
  return least;
}

// A sheared sheet, and the same rolled to a cylinder: what is flipped on it must go around it.
TEST(IntrinsicDelaunay, LengthsAreThoseWithinTheSurface) {
  constexpr uint32_t kColumns = 30, kRows = 12;
  constexpr double kRadius = 1.0;
  const auto flat = [](double u, double v) { return glm::dvec2(2.0 * u + 1.3 * v, v); };
  for (const bool rolled : {false, true}) {
    const Surface surface = grid(kColumns, kRows, [&](double u, double v) {
      const glm::dvec2 p = flat(u, v);
      return rolled ? glm::dvec3(kRadius * std::sin(p.x / kRadius), p.y, kRadius * std::cos(p.x / kRadius))
                    : glm::dvec3(p, 0.0);
    });
    std::vector<IntrinsicTriangle> triangles = intrinsic(surface);
    const double area = areaOf(triangles);
    EXPECT_LT(leastWeight(triangles), -0.1);
    makeDelaunay(triangles);
    EXPECT_EQ(triangles.size(), surface.triangles.size());
    EXPECT_NEAR(areaOf(triangles), area, 1e-6 * area);
    EXPECT_GT(leastWeight(triangles), -1e-6);
    size_t flipped = 0;
    for (const IntrinsicTriangle& t : triangles)
      for (int c = 0; c < 3; ++c) {
        const uint32_t a = t.corners[(c + 1) % 3], b = t.corners[(c + 2) % 3];
        const glm::dvec2 from = flat(surface.uvs[a].x, surface.uvs[a].y),
                         to = flat(surface.uvs[b].x, surface.uvs[b].y);
        EXPECT_NEAR(t.lengths[c], glm::distance(from, to), (rolled ? 2e-2 : 1e-5) * t.lengths[c]);
        const uint32_t step = std::max(a, b) - std::min(a, b);
        flipped += step > 1 && step <= kColumns;
      }
    EXPECT_GT(flipped, 0u);
  }
}

// Three triangles at an edge, a side against its like, and a fan whose flips fold a triangle onto itself.
TEST(IntrinsicDelaunay, KeepsWhatCannotBeFlipped) {
  const IntrinsicTriangle flat{{0, 1, 2}, {1.0, 1.0, 1.9}};
  IntrinsicTriangle other = flat;
  other.corners = {1, 0, 3};
  std::vector<IntrinsicTriangle> three = {flat, other, other}, same_way = {flat, flat};
  three[2].corners[2] = 4;
  same_way[1].corners[2] = 3;
  for (std::vector<IntrinsicTriangle>* triangles : {&three, &same_way}) {
    const std::vector<IntrinsicTriangle> before = *triangles;
    makeDelaunay(*triangles);
    for (size_t t = 0; t < before.size(); ++t) EXPECT_EQ((*triangles)[t].corners, before[t].corners);
  }
  std::vector<IntrinsicTriangle> tent;  // closed around its top, so steep that its rim's points are far apart
  for (uint32_t i = 0; i < 3; ++i) tent.push_back({{3, i, (i + 1) % 3}, {1.9, 1.0, 1.0}});
  const double area = areaOf(tent);
  makeDelaunay(tent);
  EXPECT_NEAR(areaOf(tent), area, 1e-9);
}

}  // namespace
}  // namespace furrow::tests
