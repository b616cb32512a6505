#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <map>

#include "content/expressions.h"
#include "content/head.h"
#include "content/models.h"
#include "content/surface_mesh.h"

// The skin is a grid about the front of the head, cut open along a row at the eyes and at the mouth, drawn
// onto the sculpted head and relaxed there. The left half is made and mirrored; the midline is a UV seam.
// Centimetres until the very end.

namespace furrow::content {
namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double kPi = glm::pi<double>();

enum MaterialIndex : uint32_t {
  kSkin,
  kLips,
  kBrows,
  kLashes,
  kLidInside,
  kMouthInside,
  kTeeth,
  kEyeWhite,
  kIris,
  kPupil,
  kHood
};

std::vector<Material> materials() {
  return {{"skin", {0.80f, 0.55f, 0.42f}, 0.55f},     {"lips", {0.66f, 0.31f, 0.27f}, 0.45f},
          {"brows", {0.20f, 0.12f, 0.085f}, 0.8f},    {"lashes", {0.09f, 0.05f, 0.04f}, 0.8f, true},
          {"lid", {0.62f, 0.33f, 0.28f}, 0.5f, true}, {"mouth", {0.16f, 0.035f, 0.035f}, 0.6f, true},
          {"teeth", {0.80f, 0.77f, 0.70f}, 0.3f},     {"eye", {0.88f, 0.86f, 0.83f}, 0.2f},
          {"iris", {0.17f, 0.26f, 0.30f}, 0.2f},      {"pupil", {0.01f, 0.01f, 0.012f}, 0.2f},
          {"hood", {0.10f, 0.12f, 0.15f}, 0.9f, true}};
}

// Stations from `begin` to `end` whose distance follows step(station); the last step is evened out over all.
template <class Step>
std::vector<double> stations(double begin, double end, Step&& step) {
  std::vector<double> result{begin};
  while (result.back() < end) result.push_back(result.back() + step(result.back()));
  const double scale = (end - begin) / (result.back() - begin);
  for (double& s : result) s = begin + (s - begin) * scale;
  return result;
}

uint32_t nearest(const std::vector<double>& values, double value) {
  const auto closer = [&](double a, double b) { return std::abs(a - value) < std::abs(b - value); };
  return static_cast<uint32_t>(std::min_element(values.begin(), values.end(), closer) - values.begin());
}

struct Skin {
  SurfaceMesh mesh;
  std::vector<HeadPoint> points;    // the labels of mesh.points
  std::vector<uint32_t> materials;  // a triangle
};

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
  Skin take() { return std::move(skin_); }

 private:
  static constexpr double kAxis = -5.5;  // z of the upright axis the columns turn about

  uint32_t columns() const { return static_cast<uint32_t>(angles_.size()); }
  uint32_t rows() const { return static_cast<uint32_t>(heights_.size()); }
  uint32_t upper(uint32_t i, uint32_t j) const { return j * columns() + i; }
  // On a cut row, the point of the lower edge.
  uint32_t lower(uint32_t i, uint32_t j) const {
    const auto found = lower_.find(upper(i, j));
    return found == lower_.end() ? upper(i, j) : found->second;
  }
  dvec3& at(uint32_t point) { return skin_.mesh.points[point]; }

  uint32_t addPoint(dvec3 position, bool lower_lip = false, bool lower_lid = false) {
    skin_.mesh.points.push_back(position);
    skin_.points.push_back({position, lower_lip, lower_lid});
    return static_cast<uint32_t>(skin_.mesh.points.size() - 1);
  }

  void layOut() {
    const auto angle_step = [](double a) { return 0.0125 + 0.022 * smoothRamp(0.62, 1.3, a); };
    const auto height_step = [](double y) {
      const double eyes = std::exp(-std::pow(y / 1.3, 4)), mouth = std::exp(-std::pow((y + 7.0) / 1.3, 4));
      const double nose = std::exp(-std::pow((y + 4.3) / 0.9, 4));
      const double throat = smoothRamp(-11.0, -13.0, y);
      const double brows = std::exp(-std::pow((y - 1.9) / 0.7, 4));
      return 0.21 - 0.10 * std::max({eyes, mouth, 0.9 * brows}) - 0.05 * nose + 0.2 * throat;
    };
    angles_ = stations(0.0, 1.85, angle_step);
    heights_ = stations(-15.2, 8.2, height_step);
    eye_row_ = nearest(heights_, -0.02);
    mouth_row_ = nearest(heights_, -7.0);
    const auto column = [&](double x, double z) { return nearest(angles_, std::atan2(x, z - kAxis)); };
    eye_begin_ = column(head::kEyeInner, 0.7);
    eye_end_ = column(head::kEyeOuter, 0.2);
    mouth_end_ = column(head::kMouth, 1.4);
  }

  void place() {
    for (uint32_t j = 0; j < rows(); ++j) {
      for (uint32_t i = 0; i < columns(); ++i) {
        const dvec3 out(std::sin(angles_[i]), 0, std::cos(angles_[i]));
        addPoint(head::trace(dvec3(0, heights_[j], kAxis) + 16.0 * out, -out));
        pinned_.push_back(j == 0 || j + 1 == rows() || i + 1 == columns());
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
      lower_[point] = addPoint(fromFront(x, margins.y), false, true);
      pinned_.push_back(true);
    }
    for (uint32_t i = 0; i <= mouth_end_; ++i) {
      const double x = head::kMouth * i / mouth_end_;
      const uint32_t point = upper(i, mouth_row_);
      at(point) = fromFront(x, head::lipLine(x)) - dvec3(0, 0, 0.06 * (1 - std::pow(x / head::kMouth, 2)));
      pinned_[point] = true;
      if (i == mouth_end_) continue;
      lower_[point] = addPoint(at(point), true);
      pinned_.push_back(true);
    }
  }

  // Every free point goes to the mean of its neighbours, each weighted by how near it was meant to be, and
  // back onto the head.
  void relax() {
    std::vector<dvec3> next(skin_.mesh.points);
    for (int round = 0; round < 70; ++round) {
      for (uint32_t j = 1; j + 1 < rows(); ++j) {
        for (uint32_t i = 0; i + 1 < columns(); ++i) {
          const uint32_t point = upper(i, j);
          if (pinned_[point]) continue;
          const double right = 1 / (angles_[i + 1] - angles_[i]),
                       left = i ? 1 / (angles_[i] - angles_[i - 1]) : right;
          const double up = 8 / (heights_[j + 1] - heights_[j]), down = 8 / (heights_[j] - heights_[j - 1]);
          const dvec3 to_left = i ? at(upper(i - 1, j)) : at(upper(i + 1, j)) * dvec3(-1, 1, 1);
          const dvec3 goal = (right * at(upper(i + 1, j)) + left * to_left + up * at(lower(i, j + 1)) +
                              down * at(upper(i, j - 1))) /
                             (right + left + up + down);
          next[point] = head::onto(glm::mix(at(point), goal, 0.9), round < 69 ? 1 : 4);
          if (i == 0) next[point].x = 0;
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
        result.push_back(addPoint(head::kEye + radius * direction, false, skin_.points[p].lower_lid));
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
    strip(part(edge, 0, top), part(outer, 0, top), kLashes);
    strip(part(edge, top, 2 * top), part(outer, top, 2 * top), kLidInside);
    strip(inside, edge, kLidInside);
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
        inner_above.push_back(addPoint(p + apart));
        inner_below.push_back(back || i == mouth_end_ ? inner_above.back() : addPoint(p - apart, true));
      }
      const uint32_t material = k == 0 ? kLips : kMouthInside;
      strip(inner_above, outer_above, material);
      strip(outer_below, inner_below, material);
      outer_above = inner_above;
      outer_below = inner_below;
    }
  }

  void cells() {
    // Texture space in proportion to the surface: mean lengths of columns and rows.
    std::vector<double> across(columns(), 0.0), along(rows(), 0.0);
    for (uint32_t i = 1; i < columns(); ++i) {
      double sum = 0;
      for (uint32_t j = 0; j < rows(); ++j) sum += glm::distance(at(upper(i, j)), at(upper(i - 1, j)));
      across[i] = across[i - 1] + sum / rows();
    }
    for (uint32_t j = 1; j < rows(); ++j) {
      double sum = 0;
      for (uint32_t i = 0; i < columns(); ++i) sum += glm::distance(at(lower(i, j)), at(upper(i, j - 1)));
      along[j] = along[j - 1] + sum / columns();
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
    for (uint32_t j = 0; j + 1 < rows(); ++j)
      for (uint32_t i = 0; i + 1 < columns(); ++i)
        quad(top[upper(i, j)], top[upper(i + 1, j)], bottom[upper(i + 1, j + 1)], bottom[upper(i, j + 1)],
             kSkin);
  }

  std::vector<double> angles_, heights_;
  uint32_t eye_row_ = 0, eye_begin_ = 0, eye_end_ = 0, mouth_row_ = 0, mouth_end_ = 0, strips_ = 0;
  std::map<uint32_t, uint32_t> lower_;
  std::vector<bool> pinned_;
  Skin skin_;
};

// Cuts the triangles of material `from` along level(point) = 0 and gives the part below 0 to material `to`.
template <class Level>
void paint(Skin& skin, uint32_t from, uint32_t to, Level&& level) {
  SurfaceMesh& mesh = skin.mesh;
  std::vector<double> levels(mesh.points.size());
  for (size_t p = 0; p < levels.size(); ++p) levels[p] = level(mesh.points[p]);
  // A line that passes close by a point passes through it, so that no sliver is left.
  std::vector<bool> snapped(levels.size(), false);
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (skin.materials[t] != from) continue;
    for (int k = 0; k < 3; ++k) {
      const uint32_t a = mesh.triangles[t].points[k], b = mesh.triangles[t].points[(k + 1) % 3];
      if (levels[a] * levels[b] >= 0) continue;
      const double cut = levels[a] / (levels[a] - levels[b]);
      if (cut < 0.2) snapped[a] = true;
      if (cut > 0.8) snapped[b] = true;
    }
  }
  for (size_t p = 0; p < levels.size(); ++p) {
    if (!snapped[p]) continue;
    dvec3& point = mesh.points[p];
    constexpr double e = 1e-4;
    const dvec2 slope = dvec2(level(point + dvec3(e, 0, 0)) - level(point - dvec3(e, 0, 0)),
                              level(point + dvec3(0, e, 0)) - level(point - dvec3(0, e, 0))) /
                        (2 * e);
    if (point.x > 0 && glm::dot(slope, slope) > 0.1)
      point = head::onto(point - dvec3(slope * levels[p] / glm::dot(slope, slope), 0), 3);
    skin.points[p].position = point;
    levels[p] = 0;
  }

  std::map<std::pair<uint32_t, uint32_t>, uint32_t> cut_points, cut_vertices;
  const auto cutVertex = [&](uint32_t va, uint32_t vb) {
    const auto vertex_key = std::minmax(va, vb);
    if (const auto found = cut_vertices.find(vertex_key); found != cut_vertices.end()) return found->second;
    const uint32_t a = mesh.vertices[vertex_key.first].point, b = mesh.vertices[vertex_key.second].point;
    const auto [point, fresh] =
        cut_points.try_emplace(std::minmax(a, b), static_cast<uint32_t>(mesh.points.size()));
    const double t = levels[a] / (levels[a] - levels[b]);
    if (fresh) {
      mesh.points.push_back(head::onto(glm::mix(mesh.points[a], mesh.points[b], t), 3));
      skin.points.push_back(skin.points[a]);
      skin.points.back().position = mesh.points.back();
      levels.push_back(0);
    }
    const uint32_t vertex = mesh.addVertex(
        point->second, glm::mix(mesh.vertices[vertex_key.first].uv, mesh.vertices[vertex_key.second].uv, t));
    cut_vertices.emplace(vertex_key, vertex);
    return vertex;
  };

  const size_t count = mesh.triangles.size();
  for (size_t t = 0; t < count; ++t) {
    if (skin.materials[t] != from) continue;
    const auto triangle = mesh.triangles[t];
    std::vector<uint32_t> below, above;
    for (int k = 0; k < 3; ++k) {
      const uint32_t va = triangle.vertices[k], vb = triangle.vertices[(k + 1) % 3];
      const double la = levels[triangle.points[k]], lb = levels[triangle.points[(k + 1) % 3]];
      if (la <= 0) below.push_back(va);
      if (la >= 0) above.push_back(va);
      if (la * lb < 0) {
        below.push_back(cutVertex(va, vb));
        above.push_back(below.back());
      }
    }
    bool any_below = false, any_above = false;
    for (uint32_t p : triangle.points) {
      any_below |= levels[p] < 0;
      any_above |= levels[p] > 0;
    }
    if (!any_below) continue;
    if (!any_above) {
      skin.materials[t] = to;
      continue;
    }
    bool first = true;
    const auto emit = [&](const std::vector<uint32_t>& polygon, uint32_t material) {
      for (size_t k = 1; k + 1 < polygon.size(); ++k) {
        const SurfaceMesh::Triangle piece{{mesh.vertices[polygon[0]].point, mesh.vertices[polygon[k]].point,
                                           mesh.vertices[polygon[k + 1]].point},
                                          {polygon[0], polygon[k], polygon[k + 1]}};
        if (first) {
          mesh.triangles[t] = piece;
          skin.materials[t] = material;
        } else {
          mesh.triangles.push_back(piece);
          skin.materials.push_back(material);
        }
        first = false;
      }
    };
    emit(below, to);
    emit(above, from);
  }
}

// Both halves; points of the midline are shared, vertices are not.
Skin mirrored(const Skin& half) {
  Skin whole = half;
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

// A row of teeth, `lower` or upper: a band along the dental arch.
void addTeeth(Skin& skin, bool lower) {
  constexpr uint32_t kAcross = 84, kDown = 5;
  SurfaceMesh& mesh = skin.mesh;
  const uint32_t first = static_cast<uint32_t>(mesh.vertices.size());
  for (uint32_t j = 0; j <= kDown; ++j) {
    for (uint32_t i = 0; i <= kAcross; ++i) {
      const double u = 2.0 * i / kAcross - 1, v = static_cast<double>(j) / kDown;
      const double tooth =
          std::abs(std::sin(0.5 * kPi * (u * 5.0)));  // gaps at the middle and every fifth of a side
      const double x = 2.0 * std::sin(1.25 * u), arch = 1.55 - 1.3 * (1 - std::cos(1.25 * u));
      const double edge = lower ? -7.02 : -7.26 + 0.06 * (1 - tooth), root = lower ? -7.75 : -6.45;
      const double bulge = 0.10 * std::pow(tooth, 0.35) + 0.06 * std::sin(kPi * v) - (lower ? 0.22 : 0.0);
      const dvec3 p(x, glm::mix(edge, root, v), arch + bulge);
      mesh.points.push_back(p);
      skin.points.push_back({p, lower, lower});
      mesh.addVertex(static_cast<uint32_t>(mesh.points.size() - 1),
                     {0.02 + 0.96 * (u + 1) / 2, (lower ? 0.088 : 0.072) + 0.012 * v});
    }
  }
  for (uint32_t j = 0; j < kDown; ++j) {
    for (uint32_t i = 0; i < kAcross; ++i) {
      const uint32_t a = first + j * (kAcross + 1) + i, b = a + kAcross + 1;
      if (lower)
        mesh.addQuad(a, b, b + 1, a + 1);
      else
        mesh.addQuad(a, a + 1, b + 1, b);
    }
  }
  skin.materials.resize(mesh.triangles.size(), kTeeth);
}

// The edge of the hood, seen from a point inside the head: `turn` about the way it faces, then so far away
// from there.
constexpr dvec3 kInside{0, -3.7, -5.0};

double hoodOpening(double turn) {
  const double s = std::sin(turn);
  return glm::radians(s > 0 ? 69.0 - 10.0 * s * s : 69.0 + 3.0 * s * s);
}

dvec3 hoodDirection(double turn) {
  const double opening = hoodOpening(turn);
  return {std::sin(opening) * std::cos(turn), std::sin(opening) * std::sin(turn), std::cos(opening)};
}

// How far a point of the skin lies behind the edge, about.
double underHood(dvec3 p) {
  const dvec3 q = p - kInside;
  return (std::atan2(glm::length(dvec2(q)), q.z) - hoodOpening(std::atan2(q.y, q.x))) * glm::length(q);
}

double browLevel(dvec3 p) {
  const double x = std::abs(p.x), t = (x - 1.2) / (4.9 - 1.2);
  if (p.y < 0.9 || p.y > 3.5 || t < -0.3 || t > 1.3) return 1.0;
  const double middle = 1.78 + 0.55 * std::sin(kPi * std::clamp(0.10 + 0.72 * t, 0.0, 1.0)) - 0.50 * t * t;
  const double half = 0.27 * std::min({1.0, 0.45 + 3.5 * t, 0.4 + 1.5 * (1 - t)});
  return std::max({std::abs(p.y - middle) - half, 3.7 * (t - 0.97), -3.7 * (t + 0.04)});
}

double lipLevel(dvec3 p) {
  const double x = std::abs(p.x);
  if (x > head::kMouth) return 0.05 + x - head::kMouth;
  const dvec2 borders = head::lipBorders(x);
  return std::max(p.y - borders.x, borders.y - p.y);
}

struct Painting {
  glm::vec4 mask;        // forehead, glabella, crow's feet, mouth
  glm::vec3 eye, mouth;  // across the creases
  float bias;
};

// A unit tangent of the head at p along `wish`.
glm::vec3 tangent(dvec3 p, dvec3 wish) {
  const dvec3 n = head::normal(p);
  const dvec3 t = wish - n * glm::dot(n, wish);
  return glm::length(t) > 1e-3 ? glm::vec3(glm::normalize(t)) : glm::vec3(0, 1, 0);
}

Painting paintingAt(dvec3 p) {
  Painting result;
  const dvec3 m(std::abs(p.x), p.y, p.z);
  const double mirror = p.x < 0 ? -1.0 : 1.0;
  const double in_front = smoothRamp(-5.0, -3.0, p.z);
  const double forehead =
      smoothRamp(1.5, 3.0, m.y) * smoothRamp(6.7, 5.0, m.y) * smoothRamp(6.4, 3.6, m.x) * in_front;
  const double glabella = smoothRamp(1.0, 0.3, glm::length(dvec2(m.x / 2.4, (m.y - 1.9) / 2.0)));

  const dvec2 from_corner = dvec2(m) - dvec2(head::kEyeOuter - 0.35, 0.0);
  const double reach = glm::length(from_corner), angle = std::atan2(from_corner.y, from_corner.x);
  const double crow = smoothRamp(0.3, 0.8, reach) * smoothRamp(2.6, 1.2, reach) *
                      smoothRamp(1.45, 0.5, std::abs(angle)) * in_front;
  const double under_eye = smoothRamp(1.0, 0.4, glm::length(dvec2((m.x - 3.3) / 2.2, (m.y + 1.15) / 0.8))) *
                           smoothRamp(-0.5, -0.75, m.y);

  const auto [beside, across] = head::nasolabialFold(dvec2(m));
  const double distance = std::abs(beside);
  const double mouth = smoothRamp(1.6, 0.1, distance) * smoothRamp(-2.8, -4.4, m.y) *
                       smoothRamp(-9.4, -7.6, m.y) * smoothRamp(1.0, 1.7, m.x) * smoothRamp(-3.0, -1.0, m.z);
  result.mask = glm::vec4(forehead, glabella, std::max(crow, 0.75 * under_eye), mouth);

  // Beside the corner creases are spokes of it; under the eye they run along the lid.
  const dvec3 about(-from_corner.y * mirror, from_corner.x, 0.0);
  result.eye =
      tangent(p, glm::length(from_corner) > 1e-6 ? glm::mix(dvec3(0.15 * mirror, 1, 0), glm::normalize(about),
                                                            smoothRamp(-0.2, 0.4, from_corner.x))
                                                 : dvec3(0, 1, 0));
  result.mouth = tangent(p, {across.x * mirror, across.y, 0});

  // Lines that never leave: two on the forehead, one under each eye, a trace of the nasolabial fold.
  double bias =
      0.10 * std::exp(-std::pow((m.y - 4.1 - 0.12 * std::cos(m.x)) / 0.55, 2)) * smoothRamp(4.6, 2.8, m.x);
  bias += 0.13 * under_eye;
  bias += 0.10 * std::exp(-std::pow(distance / 0.5, 2)) * mouth;
  result.bias = static_cast<float>(0.5 + bias * in_front);
  return result;
}

// A mesh of head points as primitives, one a material, with every expression; centimetres become metres.
std::vector<Primitive> primitives(const Skin& skin) {
  const std::vector<dvec3> normals = pointNormals(skin.mesh, skin.mesh.points);
  const size_t expressions = expressionNames().size();
  std::vector<Morph> morphs(expressions);
  std::vector<dvec3> posed(skin.mesh.points.size());
  for (size_t e = 0; e < expressions; ++e) {
    Morph& morph = morphs[e];
    morph.positions.resize(posed.size());
    morph.normals.resize(posed.size());
    for (size_t p = 0; p < posed.size(); ++p) {
      dvec3 moved = displacement(e, skin.points[p]);
      if (glm::length(moved) < 2e-4) moved = dvec3(0);
      posed[p] = skin.mesh.points[p] + moved;
      morph.positions[p] = glm::vec3(moved * 0.01);
    }
    const std::vector<dvec3> posed_normals = pointNormals(skin.mesh, posed);
    for (size_t p = 0; p < posed.size(); ++p) {
      const dvec3 turned = posed_normals[p] - normals[p];
      morph.normals[p] = glm::length(turned) < 1e-4 ? glm::vec3(0) : glm::vec3(turned);
    }
  }
  std::vector<Painting> paintings;
  for (const dvec3& p : skin.mesh.points) paintings.push_back(paintingAt(p));

  std::map<uint32_t, Primitive> by_material;
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> index_of;  // material, vertex
  for (size_t t = 0; t < skin.mesh.triangles.size(); ++t) {
    const uint32_t material = skin.materials[t];
    Primitive& out = by_material[material];
    if (out.indices.empty()) {
      out.material = material;
      out.morphs.resize(expressions);
      out.vec4_attributes.emplace_back("_MASK_A", std::vector<glm::vec4>());
      out.vec3_attributes.emplace_back("_DIR_EYE", std::vector<glm::vec3>());
      out.vec3_attributes.emplace_back("_DIR_MOUTH", std::vector<glm::vec3>());
    }
    for (uint32_t vertex : skin.mesh.triangles[t].vertices) {
      const auto [slot, fresh] =
          index_of.try_emplace({material, vertex}, static_cast<uint32_t>(out.positions.size()));
      out.indices.push_back(slot->second);
      if (!fresh) continue;
      const uint32_t point = skin.mesh.vertices[vertex].point;
      out.positions.emplace_back(skin.mesh.points[point] * 0.01);
      out.normals.emplace_back(normals[point]);
      out.uvs.emplace_back(skin.mesh.vertices[vertex].uv.x, 1 - skin.mesh.vertices[vertex].uv.y);
      out.colors.emplace_back(glm::vec3(paintings[point].bias), 1.0f);
      out.vec4_attributes[0].second.push_back(paintings[point].mask);
      out.vec3_attributes[0].second.push_back(paintings[point].eye);
      out.vec3_attributes[1].second.push_back(paintings[point].mouth);
      for (size_t e = 0; e < expressions; ++e) {
        out.morphs[e].positions.push_back(morphs[e].positions[point]);
        out.morphs[e].normals.push_back(morphs[e].normals[point]);
      }
    }
  }
  std::vector<Primitive> result;
  for (auto& [material, primitive] : by_material) result.push_back(std::move(primitive));
  return result;
}

// Drops the skin that the hood hides for good.
void trim(Skin& skin) {
  Skin kept;
  kept.mesh.vertices.reserve(skin.mesh.vertices.size());
  std::vector<uint32_t> point_of(skin.mesh.points.size(), ~0u), vertex_of(skin.mesh.vertices.size(), ~0u);
  for (size_t t = 0; t < skin.mesh.triangles.size(); ++t) {
    const SurfaceMesh::Triangle& triangle = skin.mesh.triangles[t];
    const auto hidden = [&](uint32_t p) { return underHood(skin.mesh.points[p]) > 0.8; };
    if (skin.materials[t] == kSkin && std::ranges::all_of(triangle.points, hidden)) continue;
    std::array<uint32_t, 3> corners{};
    for (int k = 0; k < 3; ++k) {
      uint32_t& point = point_of[triangle.points[k]];
      if (point == ~0u) {
        point = static_cast<uint32_t>(kept.mesh.points.size());
        kept.mesh.points.push_back(skin.mesh.points[triangle.points[k]]);
        kept.points.push_back(skin.points[triangle.points[k]]);
      }
      uint32_t& vertex = vertex_of[triangle.vertices[k]];
      if (vertex == ~0u) vertex = kept.mesh.addVertex(point, skin.mesh.vertices[triangle.vertices[k]].uv);
      corners[k] = vertex;
    }
    kept.mesh.addTriangle(corners[0], corners[1], corners[2]);
    kept.materials.push_back(skin.materials[t]);
  }
  skin = std::move(kept);
}

// Rings from a rolled edge about the face to the back of the head.
Skin hood() {
  constexpr uint32_t kSpokes = 120, kBack = 44;
  constexpr dvec3 kCentre{0, -1.5, -6.5};
  Skin hood;
  SurfaceMesh& mesh = hood.mesh;
  // A roll of cloth: distance behind the edge and height above the skin, centimetres.
  constexpr dvec2 kRoll[] = {{0.45, 0.02}, {0.12, 0.06}, {-0.05, 0.2}, {-0.08, 0.38}, {0.0, 0.56},
                             {0.17, 0.68}, {0.38, 0.7},  {0.58, 0.62}, {0.76, 0.48},  {0.98, 0.40}};
  const uint32_t rings = std::size(kRoll) + kBack;
  std::vector<dvec3> last(kSpokes);
  for (uint32_t ring = 0; ring < rings; ++ring) {
    for (uint32_t spoke = 0; spoke < kSpokes; ++spoke) {
      const double angle = 2 * kPi * (spoke - 0.25 * kSpokes) / kSpokes;
      if (ring < std::size(kRoll)) {
        const dvec3 out = hoodDirection(angle), foot = head::trace(kInside + 20.0 * out, -out);
        const dvec3 n = head::normal(foot), away = glm::normalize(dvec3(out.x, out.y, -0.6));
        const dvec3 back = glm::normalize(away - n * glm::dot(away, n));
        last[spoke] = head::onto(foot + back * kRoll[ring].x, 3);
        last[spoke] += head::normal(last[spoke]) * kRoll[ring].y;
        mesh.points.push_back(last[spoke]);
      } else {
        const double t = static_cast<double>(ring - std::size(kRoll) + 1) / kBack;
        const dvec3 begin = glm::normalize(last[spoke] - kCentre), end = glm::normalize(dvec3(0, 0.1, -1));
        const double whole = std::acos(std::clamp(glm::dot(begin, end), -1.0, 1.0));
        const dvec3 direction =
            glm::normalize((begin * std::sin((1 - t) * whole) + end * std::sin(t * whole)) / std::sin(whole));
        mesh.points.push_back(head::trace(kCentre + 22.0 * direction, -direction, 0.38));
      }
    }
  }
  // Even out the cloth behind the roll.
  for (int round = 0; round < 12; ++round) {
    std::vector<dvec3> next = mesh.points;
    for (uint32_t ring = std::size(kRoll); ring + 1 < rings; ++ring) {
      for (uint32_t spoke = 0; spoke < kSpokes; ++spoke) {
        const uint32_t at = ring * kSpokes + spoke;
        const uint32_t before = ring * kSpokes + (spoke + kSpokes - 1) % kSpokes,
                       after = ring * kSpokes + (spoke + 1) % kSpokes;
        next[at] = 0.25 * (mesh.points[before] + mesh.points[after] + mesh.points[at - kSpokes] +
                           mesh.points[at + kSpokes]);
      }
    }
    mesh.points = std::move(next);
  }
  for (uint32_t p = kSpokes * std::size(kRoll); p < mesh.points.size(); ++p)
    mesh.points[p] = head::onto(mesh.points[p], 4, 0.4);
  for (uint32_t ring = 0; ring < rings; ++ring)
    for (uint32_t spoke = 0; spoke <= kSpokes; ++spoke)
      mesh.addVertex(ring * kSpokes + spoke % kSpokes,
                     {0.01 + 0.98 * spoke / kSpokes, 0.01 + 0.98 * ring / (rings - 1)});
  for (uint32_t ring = 0; ring + 1 < rings; ++ring) {
    for (uint32_t spoke = 0; spoke < kSpokes; ++spoke) {
      const uint32_t a = ring * (kSpokes + 1) + spoke, b = a + kSpokes + 1;
      mesh.addQuad(a, b, b + 1, a + 1);
    }
  }
  // Cloth goes with the skin under it.
  for (const dvec3& p : mesh.points)
    hood.points.push_back({head::onto(p, 4), p.y < head::lipLine(0), p.y < 0});
  hood.materials.assign(mesh.triangles.size(), kHood);
  return hood;
}

// A ball about the origin looking along +Z: white, iris, pupil.
Mesh eyeball() {
  constexpr uint32_t kSpokes = 40, kRings = 26;
  constexpr double kRadius = head::kEyeball * 0.01, kIrisAngle = 0.45, kPupilAngle = 0.18;
  const auto ringAngle = [](uint32_t ring) {
    if (ring <= 3) return kPupilAngle * ring / 3.0;
    if (ring <= 8) return glm::mix(kPupilAngle, kIrisAngle, (ring - 3) / 5.0);
    return glm::mix(kIrisAngle, kPi, (ring - 8) / static_cast<double>(kRings - 8));
  };
  Mesh mesh;
  mesh.name = "Eye";
  const std::array<std::array<uint32_t, 3>, 3> bands{{{kPupil, 0, 3}, {kIris, 3, 8}, {kEyeWhite, 8, kRings}}};
  for (const auto& [material, begin, end] : bands) {
    Primitive primitive;
    primitive.material = material;
    for (uint32_t ring = begin; ring <= end; ++ring) {
      for (uint32_t spoke = 0; spoke <= kSpokes; ++spoke) {
        const double a = ringAngle(ring), b = 2 * kPi * (spoke % kSpokes) / kSpokes;
        const dvec3 n = ring == 0 ? dvec3(0, 0, 1)
                        : ring == kRings
                            ? dvec3(0, 0, -1)
                            : dvec3(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a));
        primitive.positions.emplace_back(kRadius * n);
        primitive.normals.emplace_back(n);
        primitive.uvs.emplace_back(static_cast<double>(spoke) / kSpokes, static_cast<double>(ring) / kRings);
      }
    }
    for (uint32_t ring = begin; ring < end; ++ring) {
      for (uint32_t spoke = 0; spoke < kSpokes; ++spoke) {
        const uint32_t a = (ring - begin) * (kSpokes + 1) + spoke, b = a + kSpokes + 1;
        if (ring + 1 < kRings) primitive.indices.insert(primitive.indices.end(), {a, b, b + 1});
        if (ring > 0) primitive.indices.insert(primitive.indices.end(), {a, b + 1, a + 1});
      }
    }
    mesh.primitives.push_back(std::move(primitive));
  }
  return mesh;
}

// The expressions one after another, each up, held and down.
Clip performance(uint32_t node) {
  struct Cue {
    double begin, end;
    std::vector<std::pair<std::string_view, double>> weights;
  };
  const std::vector<Cue> cues = {
      {0.3, 1.6, {{"browInnerUp", 1}, {"browOuterUpLeft", 0.8}, {"browOuterUpRight", 0.8}}},
      {1.5,
       2.7,
       {{"browDownLeft", 1},
        {"browDownRight", 1},
        {"eyeSquintLeft", 0.5},
        {"eyeSquintRight", 0.5},
        {"noseSneerLeft", 0.4},
        {"noseSneerRight", 0.4}}},
      {2.8, 3.2, {{"eyeBlinkLeft", 1}, {"eyeBlinkRight", 1}}},
      {3.1,
       4.5,
       {{"mouthSmileLeft", 1},
        {"mouthSmileRight", 1},
        {"cheekSquintLeft", 0.8},
        {"cheekSquintRight", 0.8},
        {"eyeSquintLeft", 0.8},
        {"eyeSquintRight", 0.8}}},
      {4.5,
       5.5,
       {{"noseSneerLeft", 1}, {"noseSneerRight", 1}, {"browDownLeft", 0.6}, {"browDownRight", 0.6}}},
      {5.5, 6.8, {{"jawOpen", 1}, {"browInnerUp", 0.8}, {"browOuterUpLeft", 1}, {"browOuterUpRight", 1}}},
      {6.8,
       7.7,
       {{"mouthSmileLeft", 0.9}, {"eyeBlinkLeft", 1}, {"cheekSquintLeft", 0.9}, {"browOuterUpRight", 0.7}}},
  };
  constexpr double kSeconds = 8.0;
  constexpr int kKeys = 160;
  const auto names = expressionNames();
  Clip clip;
  clip.name = "performance";
  clip.weights.push_back({node, {}});
  for (int key = 0; key <= kKeys; ++key) {
    const double t = kSeconds * key / kKeys;
    std::vector<float> weights(names.size(), 0.0f);
    for (const Cue& cue : cues) {
      const double edge = 0.4 * (cue.end - cue.begin);
      const double level =
          smoothRamp(cue.begin, cue.begin + edge, t) * smoothRamp(cue.end, cue.end - edge, t);
      for (const auto& [name, weight] : cue.weights) {
        float& w = weights[std::ranges::find(names, name) - names.begin()];
        w = std::max(w, static_cast<float>(level * weight));
      }
    }
    clip.times.push_back(static_cast<float>(t));
    clip.weights[0].weights.push_back(std::move(weights));
  }
  return clip;
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
  Skin skin = HalfFace().take();
  paint(skin, kSkin, kLips, lipLevel);
  paint(skin, kSkin, kBrows, browLevel);
  trim(skin);
  skin = mirrored(skin);
  addTeeth(skin, false);
  addTeeth(skin, true);

  Scene scene;
  scene.materials = materials();
  Mesh face;
  face.name = "Face";
  for (std::string_view name : expressionNames()) face.morphs.emplace_back(name);
  face.primitives = primitives(skin);
  for (Primitive& primitive : primitives(hood())) face.primitives.push_back(std::move(primitive));
  scene.meshes = {std::move(face), eyeball(), foreheadLines()};
  scene.nodes = {{"Head", -1, {}},
                 {"Face", 0, {}, 0},
                 {"EyeLeft", 0, glm::vec3(head::kEye * 0.01), 1},
                 {"EyeRight", 0, glm::vec3(head::kEye * dvec3(-0.01, 0.01, 0.01)), 1},
                 {"ForeheadLines", 0, {}, 2}};
  scene.clips = {performance(1)};
  return scene;
}

}  // namespace furrow::content
