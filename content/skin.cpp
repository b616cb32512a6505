#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <map>

#include "content/face_parts.h"
#include "content/head.h"

// The skin is a grid about the head, cut open along a row at the eyes and at the mouth, drawn onto the
// sculpted head and relaxed there. The left half is made and mirrored; the midline is a UV seam.

namespace furrow::content {
namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double kPi = glm::pi<double>();

// A multiple of `count` steps from `begin` to `end` whose length follows step(station); what is too much is
// evened out over all.
template <class Step>
std::vector<double> stations(double begin, double end, size_t count, Step&& step) {
  std::vector<double> result{begin};
  while (result.back() < end || (result.size() - 1) % count)
    result.push_back(result.back() + step(result.back()));
  const double scale = (end - begin) / (result.back() - begin);
  for (double& s : result) s = begin + (s - begin) * scale;
  return result;
}

uint32_t nearest(const std::vector<double>& values, double value) {
  const auto closer = [&](double a, double b) { return std::abs(a - value) < std::abs(b - value); };
  return static_cast<uint32_t>(std::min_element(values.begin(), values.end(), closer) - values.begin());
}

// The left half, x >= 0.
class HalfFace {
 public:
  HalfFace() {
    layOut();
    place();
    relax();
    lidLoop();
    mouthLoop();
    cells();
  }
  FacePart take() { return std::move(skin_); }

 private:
  static constexpr double kAxis = -6.5;  // z of the upright axis the columns turn about
  // Rows are level up to here; above, they fan out over a dome.
  static constexpr double kShoulder = 3.0, kDome = 8.5;

  uint32_t columns() const { return static_cast<uint32_t>(angles_.size()); }
  uint32_t rows() const { return static_cast<uint32_t>(heights_.size()); }
  bool onMidline(uint32_t i) const { return i == 0 || i + 1 == columns(); }
  uint32_t upper(uint32_t i, uint32_t j) const { return j * columns() + i; }
  // On a cut row, the point of the lower edge.
  uint32_t lower(uint32_t i, uint32_t j) const {
    const auto found = lower_.find(upper(i, j));
    return found == lower_.end() ? upper(i, j) : found->second;
  }
  dvec3& at(uint32_t point) { return skin_.mesh.points[point]; }

  void layOut() {
    const auto angle_step = [](double a) { return 0.0118 + 0.12 * smoothRamp(0.78, 1.8, a); };
    const auto height_step = [](double y) {
      const double eyes = std::exp(-std::pow(y / 1.3, 4)), mouth = std::exp(-std::pow((y + 7.0) / 1.3, 4));
      const double nose = std::exp(-std::pow((y + 4.3) / 0.9, 4));
      const double throat = smoothRamp(-11.0, -13.0, y), scalp = smoothRamp(7.5, 11.0, y);
      const double brows = std::exp(-std::pow((y - 1.9) / 0.7, 4));
      return 0.21 - 0.10 * std::max({eyes, mouth, 0.9 * brows}) - 0.05 * nose + 0.2 * throat + 0.35 * scalp;
    };
    angles_ = stations(0.0, kPi, 4, angle_step);
    heights_ = stations(-15.3, kShoulder + 1.555 * kDome, 2, height_step);
    side_ = nearest(angles_, 1.02) / 4 * 4;
    eye_row_ = nearest(heights_, -0.02);
    mouth_row_ = nearest(heights_, -7.0);
    const auto column = [&](double x, double z) { return nearest(angles_, std::atan2(x, z - kAxis)); };
    eye_begin_ = column(head::kEyeInner, 1.0);
    eye_end_ = column(head::kEyeOuter, 0.5);
    mouth_end_ = column(head::kMouth, 2.0);
  }

  void place() {
    for (uint32_t j = 0; j < rows(); ++j) {
      const double rise = std::max(0.0, (heights_[j] - kShoulder) / kDome);
      const dvec3 from(0, std::min(heights_[j], kShoulder), kAxis);
      for (uint32_t i = 0; i < columns(); ++i) {
        const dvec3 out(std::sin(angles_[i]) * std::cos(rise), std::sin(rise),
                        std::cos(angles_[i]) * std::cos(rise));
        skin_.addPoint(head::trace(from + 18.0 * out, -out));
        if (onMidline(i)) skin_.mesh.points.back().x = 0;
        pinned_.push_back(j == 0 || j + 1 == rows());
      }
    }
    const auto fromFront = [](double x, double y) { return head::trace({x, y, 8}, {0, 0, -1}); };
    for (uint32_t i = eye_begin_; i <= eye_end_; ++i) {
      const double t = static_cast<double>(i - eye_begin_) / (eye_end_ - eye_begin_);
      const double x = glm::mix(head::kEyeInner, head::kEyeOuter, t);
      const dvec2 margins = head::lidMargins(x);
      const uint32_t point = upper(i, eye_row_);
      at(point) = fromFront(x, margins.x);
      pinned_[point] = true;
      if (i == eye_begin_ || i == eye_end_) continue;
      lower_[point] = skin_.addPoint(fromFront(x, margins.y), false, true);
      pinned_.push_back(true);
    }
    for (uint32_t i = 0; i <= mouth_end_; ++i) {
      const double x = head::kMouth * i / mouth_end_;
      const uint32_t point = upper(i, mouth_row_);
      at(point) = fromFront(x, head::lipLine(x)) - dvec3(0, 0, 0.06 * (1 - std::pow(x / head::kMouth, 2)));
      pinned_[point] = true;
      if (i == mouth_end_) continue;
      lower_[point] = skin_.addPoint(at(point), true);
      pinned_.push_back(true);
    }
  }

  // Every free point goes to the mean of its neighbours, each weighted by how near it was meant to be, and
  // back onto the head.
  void relax() {
    constexpr int kRounds = 50;
    std::vector<dvec3> next(skin_.mesh.points);
    for (int round = 0; round < kRounds; ++round) {
      for (uint32_t j = 1; j + 1 < rows(); ++j) {
        const double up = 8 / (heights_[j + 1] - heights_[j]), down = 8 / (heights_[j] - heights_[j - 1]);
        for (uint32_t i = 0; i < columns(); ++i) {
          const uint32_t point = upper(i, j);
          if (pinned_[point]) continue;
          const bool first = i == 0, last = i + 1 == columns();
          const double right = 1 / (last ? angles_[i] - angles_[i - 1] : angles_[i + 1] - angles_[i]);
          const double left = first ? right : 1 / (angles_[i] - angles_[i - 1]);
          const dvec3 mirror(-1, 1, 1);
          const dvec3 to_right = last ? at(upper(i - 1, j)) * mirror : at(upper(i + 1, j));
          const dvec3 to_left = first ? at(upper(i + 1, j)) * mirror : at(upper(i - 1, j));
          const dvec3 goal =
              (right * to_right + left * to_left + up * at(lower(i, j + 1)) + down * at(upper(i, j - 1))) /
              (right + left + up + down);
          next[point] = head::onto(glm::mix(at(point), goal, 0.9), round + 1 < kRounds ? 1 : 4);
          if (onMidline(i)) next[point].x = 0;
        }
      }
      std::swap(skin_.mesh.points, next);
      if (round == 0) next = skin_.mesh.points;
    }
    for (uint32_t j = 0; j < mouth_row_; ++j)
      for (uint32_t i = 0; i < columns(); ++i) skin_.points[upper(i, j)].lower_lip = true;
    for (uint32_t j = 0; j < eye_row_; ++j)
      for (uint32_t i = 0; i < columns(); ++i) skin_.points[upper(i, j)].lower_lid = true;
    for (uint32_t p = 0; p < skin_.points.size(); ++p) skin_.points[p].position = at(p);
  }

  void strip(const std::vector<uint32_t>& outer, const std::vector<uint32_t>& inner, uint32_t material) {
    // Each strip is a chart of its own in the band below the halves' charts.
    const double v = 0.004 + 0.012 * strips_++;
    std::vector<uint32_t> a, b;
    for (size_t k = 0; k < outer.size(); ++k) {
      const double u = 0.01 + 0.47 * static_cast<double>(k) / static_cast<double>(outer.size() - 1);
      a.push_back(skin_.mesh.addVertex(outer[k], {u, v}));
      b.push_back(skin_.mesh.addVertex(inner[k], {u, v + 0.008}));
    }
    for (size_t k = 0; k + 1 < outer.size(); ++k) quad(a[k], a[k + 1], b[k + 1], b[k], material);
  }

  void quad(uint32_t a, uint32_t b, uint32_t c, uint32_t d, uint32_t material) {
    SurfaceMesh& mesh = skin_.mesh;
    const auto point = [&](uint32_t v) { return mesh.vertices[v].point; };
    if (point(c) == point(d) || point(b) == point(c))
      mesh.addTriangle(a, b, d);
    else if (point(a) == point(b) || point(a) == point(d))
      mesh.addTriangle(b, c, d);
    else
      mesh.addQuad(a, b, c, d);
    skin_.materials.resize(mesh.triangles.size(), material);
  }

  // From the lid margins inwards: the thickness of the lid, then its inside along the eyeball.
  void lidLoop() {
    std::vector<uint32_t> loop;  // the upper margin outwards, the lower one back; closed
    for (uint32_t i = eye_begin_; i <= eye_end_; ++i) loop.push_back(upper(i, eye_row_));
    for (uint32_t i = eye_end_ - 1; i > eye_begin_; --i) loop.push_back(lower(i, eye_row_));
    dvec3 middle(0);
    for (uint32_t p : loop) middle += at(p) / static_cast<double>(loop.size());
    const dvec3 axis = glm::normalize(middle - head::kEye);
    const auto ring = [&](double radius, double tilt) {
      std::vector<uint32_t> result;
      for (uint32_t p : loop) {
        const dvec3 out = glm::normalize(at(p) - head::kEye);
        const dvec3 away = glm::normalize(out - axis * glm::dot(out, axis));
        const dvec3 direction = glm::normalize(out + away * tilt);
        result.push_back(skin_.addPoint(head::kEye + radius * direction, false, skin_.points[p].lower_lid));
      }
      result.push_back(result.front());
      return result;
    };
    std::vector<uint32_t> outer = loop;
    outer.push_back(loop.front());
    const std::vector<uint32_t> edge = ring(head::kEyeball + 0.035, 0.0),
                                inside = ring(head::kEyeball + 0.03, 0.25);
    const uint32_t top = eye_end_ - eye_begin_;
    const auto part = [](const std::vector<uint32_t>& ring_points, uint32_t begin, uint32_t end) {
      return std::vector<uint32_t>(ring_points.begin() + begin, ring_points.begin() + end + 1);
    };
    strip(part(edge, 0, top), part(outer, 0, top), kLid);
    strip(part(edge, top, 2 * top), part(outer, top, 2 * top), kLid);
    strip(inside, edge, kLid);
  }

  // The pocket behind the lips.
  void mouthLoop() {
    std::vector<uint32_t> above, below;
    for (uint32_t i = 0; i <= mouth_end_; ++i) {
      above.push_back(upper(i, mouth_row_));
      below.push_back(lower(i, mouth_row_));
    }
    constexpr dvec3 kRings[] = {
        {0.99, 0.03, -0.25}, {0.97, 0.12, -0.7}, {0.93, 0.25, -1.5}, {0.85, 0.0, -3.2}};
    std::vector<uint32_t> outer_above = above, outer_below = below;
    for (size_t k = 0; k < std::size(kRings); ++k) {
      const bool back = k + 1 == std::size(kRings);
      std::vector<uint32_t> inner_above, inner_below;
      for (uint32_t i = 0; i <= mouth_end_; ++i) {
        const double fade = std::sqrt(1 - std::pow(static_cast<double>(i) / mouth_end_, 4));
        const dvec3 from = at(above[i]);
        const dvec3 p(from.x * kRings[k].x, from.y, from.z + kRings[k].z * (0.4 + 0.6 * fade));
        const dvec3 apart(0, kRings[k].y * fade, 0);
        inner_above.push_back(skin_.addPoint(p + apart));
        inner_below.push_back(back || i == mouth_end_ ? inner_above.back() : skin_.addPoint(p - apart, true));
      }
      const uint32_t material = k == 0 ? kLid : kMouth;
      strip(inner_above, outer_above, material);
      strip(outer_below, inner_below, material);
      outer_above = inner_above;
      outer_below = inner_below;
    }
  }

  void cells() {
    // Texture space in proportion to the surface, mean lengths of columns and rows; less where hair and
    // collar are.
    std::vector<double> across(columns(), 0.0), along(rows(), 0.0);
    for (uint32_t i = 1; i < columns(); ++i) {
      double sum = 0;
      for (uint32_t j = 0; j < rows(); ++j) sum += glm::distance(at(upper(i, j)), at(upper(i - 1, j)));
      across[i] = across[i - 1] + sum / rows() * glm::mix(1.0, 0.35, smoothRamp(0.95, 1.5, angles_[i]));
    }
    for (uint32_t j = 1; j < rows(); ++j) {
      double sum = 0;
      for (uint32_t i = 0; i < columns(); ++i) sum += glm::distance(at(lower(i, j)), at(upper(i, j - 1)));
      along[j] = along[j - 1] + sum / columns() * (heights_[j] < -11.8 || heights_[j] > 8.0 ? 0.45 : 1.0);
    }
    std::vector<uint32_t> top(columns() * rows()), bottom(top.size());
    for (uint32_t j = 0; j < rows(); ++j) {
      for (uint32_t i = 0; i < columns(); ++i) {
        const dvec2 uv(0.505 + 0.485 * across[i] / across.back(), 0.12 + 0.87 * along[j] / along.back());
        const uint32_t k = upper(i, j);
        top[k] = bottom[k] = skin_.mesh.addVertex(k, uv);
        if (lower(i, j) != k) bottom[k] = skin_.mesh.addVertex(lower(i, j), uv);
      }
    }
    const auto block = [&](uint32_t i0, uint32_t i1, uint32_t j0, uint32_t j1) {
      // Counter-clockwise; finer neighbours have a point halfway along an edge.
      const uint32_t a = top[upper(i0, j0)], b = top[upper(i1, j0)], c = bottom[upper(i1, j1)],
                     d = bottom[upper(i0, j1)], i = (i0 + i1) / 2;
      std::vector<uint32_t> rim{b, c};
      if (i1 - i0 > stride(j1)) rim.push_back(bottom[upper(i, j1)]);
      rim.push_back(d);
      if (j1 - j0 > 1 && i0 == side_) rim.push_back(top[upper(i0, j0 + 1)]);
      rim.push_back(a);
      if (i1 - i0 > stride(j0)) rim.push_back(top[upper(i, j0)]);
      if (rim.size() == 4)
        quad(a, b, c, d, kSkin);
      else
        fan(rim, std::ranges::find_if(rim, [&](uint32_t v) { return v != a && v != b && v != c && v != d; }));
    };
    for (uint32_t j = 0; j + 1 < rows(); ++j) {
      const uint32_t step = std::max(stride(j), stride(j + 1));
      for (uint32_t i = 0; i < side_; i += step) block(i, i + step, j, j + 1);
    }
    for (uint32_t j = 0; j + 1 < rows(); j += 2) {
      const uint32_t step = std::max(stride(j), stride(j + 2));
      for (uint32_t i = side_; i + 1 < columns(); i += step) block(i, i + step, j, j + 2);
    }
  }

  // Every how many columns of a row are used: all on the face, fewer under the hair and down the neck, where
  // they crowd. Behind side_ every other row is.
  uint32_t stride(uint32_t j) const {
    const double h = heights_[j / 2 * 2];
    return h > 11.0 ? 4 : h > 7.6 || h < -10.9 ? 2 : 1;
  }

  // Triangles from `middle` to the other points of the rim.
  void fan(std::vector<uint32_t>& rim, std::vector<uint32_t>::iterator middle) {
    std::rotate(rim.begin(), middle, rim.end());
    for (size_t k = 1; k + 1 < rim.size(); ++k) skin_.mesh.addTriangle(rim[0], rim[k], rim[k + 1]);
    skin_.materials.resize(skin_.mesh.triangles.size(), kSkin);
  }

  std::vector<double> angles_, heights_;
  uint32_t side_ = 0, eye_row_ = 0, eye_begin_ = 0, eye_end_ = 0, mouth_row_ = 0, mouth_end_ = 0, strips_ = 0;
  std::map<uint32_t, uint32_t> lower_;
  std::vector<bool> pinned_;
  FacePart skin_;
};

// Both halves; points of the midline are shared, vertices are not.
FacePart mirrored(const FacePart& half) {
  FacePart whole = half;
  std::vector<uint32_t> twin(half.mesh.points.size());
  for (uint32_t p = 0; p < twin.size(); ++p) {
    twin[p] = p;
    if (half.mesh.points[p].x == 0) continue;
    twin[p] = static_cast<uint32_t>(whole.mesh.points.size());
    whole.mesh.points.push_back(half.mesh.points[p] * dvec3(-1, 1, 1));
    whole.points.push_back(half.points[p]);
    whole.points.back().position = whole.mesh.points.back();
  }
  const uint32_t vertices = static_cast<uint32_t>(half.mesh.vertices.size());
  for (const SurfaceMesh::Vertex& vertex : half.mesh.vertices)
    whole.mesh.addVertex(twin[vertex.point],
                         {vertex.uv.y < 0.11 ? vertex.uv.x + 0.5 : 1 - vertex.uv.x, vertex.uv.y});
  for (size_t t = 0; t < half.mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = half.mesh.triangles[t].vertices;
    whole.mesh.addTriangle(vertices + a, vertices + c, vertices + b);
    whole.materials.push_back(half.materials[t]);
  }
  return whole;
}

}  // namespace

uint32_t FacePart::addPoint(dvec3 position, bool lower_lip, bool lower_lid) {
  mesh.points.push_back(position);
  points.push_back({position, lower_lip, lower_lid});
  return static_cast<uint32_t>(mesh.points.size() - 1);
}

FacePart withMirrorImage(FacePart part) {
  const FacePart half = part;
  const uint32_t points = static_cast<uint32_t>(half.mesh.points.size()),
                 vertices = static_cast<uint32_t>(half.mesh.vertices.size());
  constexpr dvec3 kMirror(-1, 1, 1);
  for (uint32_t p = 0; p < points; ++p) {
    part.mesh.points.push_back(half.mesh.points[p] * kMirror);
    HeadPoint mover = half.points[p];
    mover.position *= kMirror;
    mover.offset *= kMirror;
    part.points.push_back(mover);
    part.colors.push_back(half.colors[p]);
  }
  for (const SurfaceMesh::Vertex& vertex : half.mesh.vertices)
    part.mesh.addVertex(vertex.point + points, vertex.uv);
  for (const SurfaceMesh::Triangle& triangle : half.mesh.triangles)
    part.mesh.addTriangle(vertices + triangle.vertices[0], vertices + triangle.vertices[2],
                          vertices + triangle.vertices[1]);
  part.materials.resize(part.mesh.triangles.size(), half.materials[0]);
  return part;
}

FacePart faceSkin() {
  FacePart skin = mirrored(HalfFace().take());
  const std::vector<dvec3> normals = pointNormals(skin.mesh, skin.mesh.points);
  for (size_t p = 0; p < normals.size(); ++p)
    skin.colors.push_back(skinOcclusion(skin.mesh.points[p], normals[p]));
  return skin;
}

}  // namespace furrow::content
