#include "pipeline/maps/kernels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdio>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <numbers>
#include <numeric>
#include <queue>
#include <stdexcept>
#include <tuple>

#include "pipeline/bake/bucket_sort.h"
#include "pipeline/bake/nearest.h"
#include "pipeline/scene/rig.h"

namespace furrow::pipeline {
namespace {

constexpr double kCell = 0.62;     // spacings
constexpr double kJitter = 0.6;    // cells
constexpr double kCapture = 0.55;  // cells; a plane has 2 kCapture kernels per cell side squared at any angle
// No surface in use lies along the grid.
const glm::dquat kTilt = glm::normalize(glm::dquat(0.82, 0.31, -0.27, 0.39));
constexpr double kPatch = 0.3;                          // spacings: triangles that share a cell lie within it
constexpr double kMaxPieces = 4e6, kMaxCells = 0x1p27;  // slivers have few pieces and many cells
constexpr int kSweeps = 48;
constexpr float kBroken = 0.65f,
                kWhole = 0.97f;  // coherence where a line has lost its depth, and where it begins to lose it
constexpr uint32_t kTaperSteps = 6;

uint64_t mix(uint64_t x) {  // the finaliser of SplitMix64
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

using CellIndex = std::array<int64_t, 3>;

uint64_t hash(const CellIndex& cell, uint64_t seed) {
  uint64_t h = mix(seed);
  for (const int64_t i : cell) {
    h = mix(h ^ static_cast<uint64_t>(i));
  }
  return h;
}

double unitInterval(uint64_t h) {
  return static_cast<double>(h >> 11) * 0x1p-53;
}

CellIndex cellOf(const glm::dvec3& p) {
  return {static_cast<int64_t>(std::floor(p.x)), static_cast<int64_t>(std::floor(p.y)),
          static_cast<int64_t>(std::floor(p.z))};
}

// Value noise in [-1, 1], smooth, period of its lattice 1.
double noise(const glm::dvec3& p, uint64_t seed) {
  const CellIndex cell = cellOf(p);
  std::array<double, 3> t{};
  for (int i = 0; i < 3; ++i) {
    const double f = p[i] - static_cast<double>(cell[i]);
    t[i] = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
  }
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    CellIndex at = cell;
    double weight = 1.0;
    for (int i = 0; i < 3; ++i) {
      const bool high = (corner >> i & 1) != 0;
      at[i] += high ? 1 : 0;
      weight *= high ? t[i] : 1.0 - t[i];
    }
    sum += weight * (2.0 * unitInterval(hash(at, seed)) - 1.0);
  }
  return sum;
}

glm::dvec3 closestPoint(const glm::dvec3& p, const std::array<glm::dvec3, 3>& t) {
  const glm::dvec3 place = nearestPlace(t, p);
  return t[0] * place.x + t[1] * place.y + t[2] * place.z;
}

// d and -d become one.
glm::vec3 canonical(const glm::vec3& d) {
  const float lead = d.x != 0.0f ? d.x : d.y != 0.0f ? d.y : d.z;
  return lead < 0.0f ? -d : d;
}

struct Corner3 {
  std::array<glm::dvec3, 3> p;
  double area2 = 0.0;  // of the parallelogram

  glm::dvec2 barycentric(const glm::dvec3& x) const {
    const glm::dvec3 e1 = p[1] - p[0], e2 = p[2] - p[0], n = glm::cross(e1, e2), d = x - p[0];
    return {glm::dot(glm::cross(d, e2), n) / (area2 * area2),
            glm::dot(glm::cross(e1, d), n) / (area2 * area2)};
  }
};

struct Candidate {
  CellIndex cell{};
  double distance = 0.0;
  uint32_t triangle = 0;
};

struct Neighbour {
  uint32_t kernel = 0;
  bool same_sign = true;
  float weight = 0.0f;
  float along = 0.0f;  // spacings, across the creases
  std::complex<float> turn{
      1};  // by which the neighbour's phasor, conjugated unless same_sign, is seen from here
};

class Builder {
 public:
  Builder(const Surface& surface, const LayerField& field, double spacing, uint32_t seed)
      : surface_(surface),
        field_(field),
        spacing_(spacing),
        seed_(seed),
        reached_(surface.triangles.size(), false),
        first_of_(firstOfEqual(surface)) {
    double pieces = 0.0, cells = 0.0;
    for (uint32_t t = 0; t < surface.triangles.size(); ++t) {
      const glm::uvec3 points = surface.trianglePoints(t);
      const Corner3 c = corners(t);
      const float strength =
          std::max({field.strength[points.x], field.strength[points.y], field.strength[points.z]});
      if (first_of_[t] != t || !(strength > 0.0f) || !(c.area2 > 0.0) || !std::isfinite(c.area2)) {
        continue;
      }
      reached_[t] = true;
      pieces += c.area2 / (spacing * spacing) + longestEdge(c.p) / spacing;
      cells += partsOf(c, 1) * partsOf(c, 2);
    }
    if (!(pieces < kMaxPieces && cells < kMaxCells)) {
      char what[80];
      std::snprintf(what, sizeof what, "a wrinkle spacing of %.4g is too small for the surface", spacing);
      throw std::length_error(what);
    }
  }

  // Of triangles with the same corners in the same order, the first stands for all.
  const std::vector<bool>& reached() const { return reached_; }
  uint32_t firstOf(uint32_t triangle) const { return first_of_[triangle]; }
  Corner3 corners(uint32_t triangle) const {
    const glm::uvec3 points = surface_.trianglePoints(triangle);
    const glm::dvec3 a = surface_.point_positions[points.x], b = surface_.point_positions[points.y],
                     c = surface_.point_positions[points.z];
    return {{a, b, c}, glm::length(glm::cross(b - a, c - a))};
  }
  // Of its edge from corner 0 to `corner`, about a spacing each.
  double partsOf(const Corner3& triangle, int corner) const {
    return std::clamp(std::ceil(glm::distance(triangle.p[0], triangle.p[corner]) / spacing_), 1.0, 4096.0);
  }
  uint32_t triangleOf(uint32_t kernel) const { return triangle_of_[kernel]; }
  uint64_t randomOf(uint32_t kernel, uint64_t salt) const { return mix(random_of_[kernel] ^ salt); }
  float confidenceOf(uint32_t kernel) const { return confidence_of_[kernel]; }

  // One kernel a cell of a space grid and sheet of the surface near its jittered centre: the point nearest to
  // that.
  std::vector<Kernel> place() {
    std::vector<Candidate> candidates;
    for (uint32_t t = 0; t < reached_.size(); ++t) {
      if (reached_[t]) {
        collect(t, candidates);
      }
    }
    std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
      return std::tie(a.cell, a.distance, a.triangle) < std::tie(b.cell, b.distance, b.triangle);
    });

    const std::vector<uint32_t> sheets = connectedSheets();
    std::vector<Kernel> kernels;
    size_t cell_begin = 0;  // kernel
    for (size_t i = 0; i < candidates.size(); ++i) {
      const Candidate& candidate = candidates[i];
      if (i == 0 || candidate.cell != candidates[i - 1].cell) {
        cell_begin = kernels.size();
      }
      const glm::uvec3 points = surface_.trianglePoints(candidate.triangle);
      Kernel kernel;
      const Corner3 corners3 = corners(candidate.triangle);
      const glm::dvec3 position =
          closestPoint(glm::conjugate(kTilt) * centreOf(candidate.cell) * (kCell * spacing_), corners3.p);
      const glm::vec2 b(corners3.barycentric(position));
      const glm::vec3 w(1.0f - b.x - b.y, b.x, b.y);
      kernel.position = glm::vec3(position);
      const glm::vec3 sum = surface_.point_normals[points.x] * w.x + surface_.point_normals[points.y] * w.y +
                            surface_.point_normals[points.z] * w.z;
      kernel.normal = glm::dot(sum, sum) > 0.0f ? glm::normalize(sum) : surface_.point_normals[points.x];
      bool taken = false;
      for (size_t k = cell_begin; k < kernels.size() && !taken; ++k) {
        taken = sheets[surface_.trianglePoints(triangle_of_[k]).x] == sheets[points.x] &&
                glm::dot(kernels[k].normal, kernel.normal) > 0.3f;
      }
      if (taken) {
        continue;
      }
      kernel.direction =
          meanLine(canonical(field_.direction[points.x]), canonical(field_.direction[points.y]),
                   canonical(field_.direction[points.z]), w, kernel.normal);
      kernels.push_back(kernel);
      triangle_of_.push_back(candidate.triangle);
      random_of_.push_back(hash(candidate.cell, seed_));
      confidence_of_.push_back(field_.confidence[points.x] * w.x + field_.confidence[points.y] * w.y +
                               field_.confidence[points.z] * w.z);
    }
    return kernels;
  }

  // For each corner's edge (to the next corner) the reached triangles it joins.
  struct Edges {
    std::vector<uint32_t> edge_of;  // 3 a triangle
    std::vector<uint32_t> offsets, triangles;
  };
  Edges edges() const {
    std::vector<uint32_t> sides;
    for (uint32_t t = 0; t < reached_.size(); ++t)
      if (reached_[t]) sides.insert(sides.end(), {3 * t, 3 * t + 1, 3 * t + 2});
    const auto ends = [&](uint32_t i) {
      const glm::uvec3 p = surface_.trianglePoints(sides[i] / 3);
      return std::minmax({p[sides[i] % 3], p[(sides[i] + 1) % 3]});
    };
    const std::vector<uint32_t> order = sidesByEnds(
        static_cast<uint32_t>(sides.size()), static_cast<uint32_t>(surface_.point_positions.size()), ends);
    Edges result;
    result.edge_of.resize(3 * reached_.size());
    for (size_t i = 0; i < order.size(); ++i) {
      if (i == 0 || ends(order[i]) != ends(order[i - 1])) {
        result.offsets.push_back(static_cast<uint32_t>(i));
      }
      result.edge_of[sides[order[i]]] = static_cast<uint32_t>(result.offsets.size() - 1);
      result.triangles.push_back(sides[order[i]] / 3);
    }
    result.offsets.push_back(static_cast<uint32_t>(order.size()));
    return result;
  }

 private:
  static std::vector<uint32_t> firstOfEqual(const Surface& surface) {
    const auto count = static_cast<uint32_t>(surface.triangles.size());
    const auto key = [&](uint32_t t) {
      const glm::uvec3 p = surface.trianglePoints(t);
      return std::tuple(p.y, p.z);
    };
    const auto bucket = [&](uint32_t t) { return surface.trianglePoints(t).x; };
    const std::vector<uint32_t> order =
        bucketSorted(count, static_cast<uint32_t>(surface.point_positions.size()), bucket,
                     [&](uint32_t a, uint32_t b) { return std::tuple(key(a), a) < std::tuple(key(b), b); });
    std::vector<uint32_t> first(count);
    for (uint32_t i = 0; i < count; ++i) {
      const uint32_t t = order[i], before = i > 0 ? order[i - 1] : t;
      first[t] = i > 0 && bucket(t) == bucket(before) && key(t) == key(before) ? first[before] : t;
    }
    return first;
  }

  static double longestEdge(const std::array<glm::dvec3, 3>& p) {
    return std::max({glm::distance(p[0], p[1]), glm::distance(p[1], p[2]), glm::distance(p[2], p[0])});
  }

  // Of a cell, jittered, in cells.
  glm::dvec3 centreOf(const CellIndex& cell) const {
    glm::dvec3 centre(0.0);
    uint64_t h = hash(cell, seed_);
    for (int i = 0; i < 3; ++i) {
      centre[i] = static_cast<double>(cell[i]) + 0.5 + kJitter * (unitInterval(h) - 0.5);
      h = mix(h);
    }
    return centre;
  }

  // Cuts the triangle (in cells) into pieces of at most two cells, so that a piece's bounding box is not much
  // more than the piece.
  void collect(uint32_t triangle, std::vector<Candidate>& candidates) const {
    std::array<glm::dvec3, 3> whole = corners(triangle).p;
    for (glm::dvec3& p : whole) p = kTilt * p / (kCell * spacing_);
    std::vector<std::array<glm::dvec3, 3>> stack = {whole};
    while (!stack.empty()) {
      const std::array<glm::dvec3, 3> p = stack.back();
      stack.pop_back();
      if (longestEdge(p) > 2.0) {
        int i = 0;
        while (glm::distance(p[i], p[(i + 1) % 3]) < longestEdge(p)) {
          ++i;
        }
        const glm::dvec3 a = p[i], b = p[(i + 1) % 3], c = p[(i + 2) % 3], middle = (a + b) * 0.5;
        stack.push_back({a, middle, c});
        stack.push_back({middle, b, c});
        continue;
      }
      const double nearest = kCapture - 0.5 + 0.5 * kJitter,
                   furthest = kCapture + 0.5 + 0.5 * kJitter;  // from a cell's low corner
      const CellIndex low = cellOf(glm::min(p[0], glm::min(p[1], p[2])) - furthest);
      const CellIndex high = cellOf(glm::max(p[0], glm::max(p[1], p[2])) + nearest);
      CellIndex cell{};
      for (cell[2] = low[2]; cell[2] <= high[2]; ++cell[2]) {
        for (cell[1] = low[1]; cell[1] <= high[1]; ++cell[1]) {
          for (cell[0] = low[0]; cell[0] <= high[0]; ++cell[0]) {
            const glm::dvec3 centre = centreOf(cell);
            const double distance = glm::distance(closestPoint(centre, p), centre);
            if (distance < kCapture) {
              candidates.push_back({cell, distance, triangle});
            }
          }
        }
      }
    }
  }

  // Per point: the lowest point it is joined to by triangles.
  std::vector<uint32_t> connectedSheets() const {
    std::vector<uint32_t> parent(surface_.point_positions.size());
    std::iota(parent.begin(), parent.end(), 0u);
    const auto root = [&](uint32_t p) {
      while (parent[p] != p) {
        p = parent[p] = parent[parent[p]];
      }
      return p;
    };
    for (size_t t = 0; t < surface_.triangles.size(); ++t) {
      const glm::uvec3 p = surface_.trianglePoints(t);
      for (const uint32_t other : {p.y, p.z}) {
        const uint32_t a = root(p.x), b = root(other);
        parent[std::max(a, b)] = std::min(a, b);
      }
    }
    for (uint32_t p = 0; p < parent.size(); ++p) {
      parent[p] = root(p);
    }
    return parent;
  }

  const Surface& surface_;
  const LayerField& field_;
  double spacing_;
  uint64_t seed_;
  std::vector<bool> reached_;
  std::vector<uint32_t> first_of_;
  std::vector<uint32_t> triangle_of_;
  std::vector<uint64_t> random_of_;
  std::vector<float> confidence_of_;
};

// The neighbours of all kernels, one after the other.
struct Graph {
  std::vector<uint32_t> offsets = {0};
  std::vector<Neighbour> neighbours;

  std::span<const Neighbour> of(uint32_t k) const {
    return std::span(neighbours).subspan(offsets[k], offsets[k + 1] - offsets[k]);
  }
};

std::complex<float> seen(const Neighbour& n, std::complex<float> phasor) {
  return n.turn * (n.same_sign ? phasor : std::conj(phasor));
}

// Phasors from a front that spreads over the surface from the surest kernel of each sheet, always to where
// most of the neighbours already agree; then relaxed, so that the unevenness of the front's order is gone and
// lines break only where they must.
std::vector<std::complex<float>> align(const Graph& graph, const std::vector<float>& confidence) {
  const auto count = static_cast<uint32_t>(confidence.size());
  std::vector<std::complex<float>> phasors(count), sums(count);
  std::vector<bool> known(count, false);
  std::vector<uint32_t> seeds(count);
  std::iota(seeds.begin(), seeds.end(), 0u);
  const auto rank = [&](uint32_t k) {
    return std::lround(64.0f * confidence[k]);
  };  // rounding must not choose
  std::stable_sort(seeds.begin(), seeds.end(), [&](uint32_t a, uint32_t b) { return rank(a) > rank(b); });

  std::priority_queue<std::pair<float, uint32_t>> front;
  for (const uint32_t seed : seeds) {
    front.emplace(0.0f, seed);
    while (!front.empty()) {
      const uint32_t k = front.top().second;
      front.pop();
      if (known[k]) {
        continue;
      }
      known[k] = true;
      const float size = std::abs(sums[k]);
      phasors[k] = size > 0.0f ? sums[k] / size : std::complex<float>(1.0f);
      for (const Neighbour& n : graph.of(k)) {
        if (!known[n.kernel]) {
          Neighbour back = n;  // how the neighbour sees this kernel
          back.turn = n.same_sign ? std::conj(n.turn) : n.turn;
          sums[n.kernel] += n.weight * seen(back, phasors[k]);
          front.emplace(std::abs(sums[n.kernel]), n.kernel);
        }
      }
    }
  }

  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (uint32_t k = 0; k < count; ++k) {
      std::complex<float> sum(0.0f);
      for (const Neighbour& n : graph.of(k)) {
        sum += n.weight * seen(n, phasors[n.kernel]);
      }
      const float size = std::abs(sum);
      if (size > 0.0f) {
        phasors[k] = sum / size;
      }
    }
  }
  return phasors;
}

// 1 where all neighbours agree with the kernel's phase.
float coherence(const Graph& graph, const std::vector<std::complex<float>>& phasors, uint32_t k) {
  float agreed = 0.0f, total = 0.0f;
  for (const Neighbour& n : graph.of(k)) {
    agreed += n.weight * std::real(std::conj(phasors[k]) * seen(n, phasors[n.kernel]));
    total += n.weight;
  }
  return total > 0.0f ? agreed / total : 1.0f;
}

double wrapped(double turns) {
  return turns - std::floor(turns + 0.5);
}

// The neighbours that have the same line for their nearest. The lines are where the phase is `line` turns.
Graph linesOf(const Graph& graph, const std::vector<double>& phases, double line) {
  const auto count = static_cast<uint32_t>(phases.size());
  std::vector<double> offsets(count);  // of the line, in spacings along d
  for (uint32_t k = 0; k < count; ++k) {
    offsets[k] = wrapped(line - phases[k]);
  }
  Graph lines;
  for (uint32_t k = 0; k < count; ++k) {
    for (const Neighbour& n : graph.of(k)) {
      const double seen_from_here = (offsets[n.kernel] - n.along) * (n.same_sign ? 1.0 : -1.0);
      if (std::abs(seen_from_here - offsets[k]) < 0.5) {
        lines.neighbours.push_back(n);
      }
    }
    lines.offsets.push_back(static_cast<uint32_t>(lines.neighbours.size()));
  }
  return lines;
}

void spread(const Graph& lines, uint32_t steps, std::vector<float>& values) {
  const auto count = static_cast<uint32_t>(values.size());
  std::vector<float> next(count);
  for (uint32_t step = 0; step < steps; ++step) {
    for (uint32_t k = 0; k < count; ++k) {
      float sum = values[k], total = 1.0f;
      for (const Neighbour& n : lines.of(k)) {
        sum += n.weight * values[n.kernel];
        total += n.weight;
      }
      next[k] = sum / total;
    }
    values.swap(next);
  }
}

// Noise in [0, 1], about uniform, of its own for every line and changing slowly along it.
std::vector<float> lineNoise(const Graph& lines, const Builder& builder, uint64_t salt, uint32_t steps) {
  const auto count = static_cast<uint32_t>(lines.offsets.size() - 1);
  std::vector<float> values(count);
  for (uint32_t k = 0; k < count; ++k) {
    values[k] = static_cast<float>(unitInterval(builder.randomOf(k, salt))) - 0.5f;
  }
  spread(lines, steps, values);
  double mean = 0.0, square = 0.0;
  for (const float v : values) {
    mean += v;
    square += static_cast<double>(v) * v;
  }
  mean /= std::max(count, 1u);
  const double deviation = std::sqrt(std::max(square / std::max(count, 1u) - mean * mean, 1e-12));
  for (float& v : values) {
    v = static_cast<float>(1.0 / (1.0 + std::exp(-1.7 * (v - mean) / deviation)));
  }
  return values;
}

bool touch(const glm::uvec3& a, const glm::uvec3& b) {
  for (int i = 0; i < 3; ++i)
    if (a[i] == b.x || a[i] == b.y || a[i] == b.z) return true;
  return false;
}

float smoothStep(float low, float high, float v) {
  const float t = std::clamp((v - low) / (high - low), 0.0f, 1.0f);
  return t * t * (3.0f - 2.0f * t);
}

// Those whose waves meet a kernel's own.
Graph neighboursOf(const Kernels& kernels, const Builder& builder, double spacing) {
  Graph graph;
  for (uint32_t k = 0; k < kernels.size(); ++k) {
    const Kernel& here = kernels[k];
    const uint32_t triangle = builder.triangleOf(k);
    for (const uint32_t j : kernels.near(
             triangle, glm::vec2(builder.corners(triangle).barycentric(glm::dvec3(here.position))))) {
      const Kernel& there = kernels[j];
      const glm::dvec3 step = (glm::dvec3(here.position) - glm::dvec3(there.position)) / spacing;
      const double q = 1.0 - glm::dot(step, step) / (Kernels::kReach * Kernels::kReach);
      const double facing = glm::dot(here.normal, there.normal),
                   agreement = glm::dot(here.direction, there.direction);
      if (j == k || q <= 0.0 || facing <= 0.3) {
        continue;
      }
      const double sign = agreement < 0.0 ? -1.0 : 1.0;
      const double along =
          glm::dot((glm::dvec3(there.direction) + sign * glm::dvec3(here.direction)) * 0.5, step);
      const double angle = sign * 2.0 * std::numbers::pi * along;
      const double trust = 0.05 + 0.95 * builder.confidenceOf(j);
      graph.neighbours.push_back(
          {j,
           sign > 0.0,
           static_cast<float>(q * q * q * facing * agreement * agreement * trust),
           static_cast<float>(along),
           {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))}});
    }
    graph.offsets.push_back(static_cast<uint32_t>(graph.neighbours.size()));
  }
  return graph;
}

// Phases that agree, and depths that end where they cannot.
void shape(const Graph& graph, const Builder& builder, double spacing, uint32_t seed,
           const Irregularity& irregularity, std::vector<Kernel>& kernels) {
  const auto count = static_cast<uint32_t>(kernels.size());
  std::vector<float> confidence(count);
  for (uint32_t k = 0; k < count; ++k) confidence[k] = builder.confidenceOf(k);
  const std::vector<std::complex<float>> phasors = align(graph, confidence);
  std::vector<double> phases(count);
  for (uint32_t k = 0; k < count; ++k) {
    phases[k] = std::arg(std::complex<double>(phasors[k])) / (2.0 * std::numbers::pi);
  }
  const Graph lines = linesOf(graph, phases, irregularity.line),
              between = linesOf(graph, phases, irregularity.line + 0.5);
  const std::vector<float> depth = lineNoise(lines, builder, 1, irregularity.line_steps);
  const std::vector<float> minor = lineNoise(between, builder, 2, irregularity.line_steps);
  std::vector<float> taper(count);
  for (uint32_t k = 0; k < count; ++k) {
    taper[k] = smoothStep(kBroken, kWhole, coherence(graph, phasors, k));
  }
  spread(lines, kTaperSteps, taper);
  for (uint32_t k = 0; k < count; ++k) {
    Kernel& kernel = kernels[k];
    const glm::dvec3 at = glm::dvec3(kernel.position) / (spacing * irregularity.sway_length);
    glm::dvec3 sway(0.0);
    for (int i = 0; i < 3; ++i) {
      const uint64_t salt = mix(seed) + static_cast<uint64_t>(i);
      sway[i] = noise(at, salt) + 0.25 * noise(at * 2.7, salt + 3);
    }
    kernel.phase =
        static_cast<float>(phases[k] + irregularity.sway * glm::dot(sway, glm::dvec3(kernel.direction)));
    const auto ending = static_cast<float>(irregularity.ending),
               shallowest = static_cast<float>(irregularity.shallowest);
    kernel.depth =
        taper[k] * (shallowest + (1.0f - shallowest) * smoothStep(ending, ending + 0.5f, depth[k]));
    const auto without = static_cast<float>(1.0 - irregularity.minor);
    kernel.minor = taper[k] * smoothStep(without, without + 0.3f, minor[k]);
  }
}

}  // namespace

glm::vec3 meanLine(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& weights,
                   const glm::vec3& normal) {
  const glm::vec3 axis = std::abs(normal.x) < 0.7f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
  const glm::vec3 t1 = glm::normalize(axis - normal * glm::dot(axis, normal)), t2 = glm::cross(normal, t1);
  // (cos 2t, sin 2t) times the squared length, which does not know the sign.
  float cos2 = 0.0f, sin2 = 0.0f;
  const std::array<const glm::vec3*, 3> lines = {&a, &b, &c};
  for (int i = 0; i < 3; ++i) {
    const float x = glm::dot(*lines[i], t1), y = glm::dot(*lines[i], t2);
    cos2 += weights[i] * (x * x - y * y);
    sin2 += weights[i] * 2.0f * x * y;
  }
  const float length = std::sqrt(cos2 * cos2 + sin2 * sin2);
  if (!(length > 1e-12f)) {
    return t1;
  }
  const float cos = std::sqrt(std::max(0.5f + 0.5f * cos2 / length, 0.0f));
  const float sin = std::copysign(std::sqrt(std::max(0.5f - 0.5f * cos2 / length, 0.0f)), sin2);
  return t1 * cos + t2 * sin;
}

Kernels::Kernels(const Surface& surface, const LayerField& field, double spacing, uint32_t seed,
                 const Irregularity& irregularity) {
  Builder builder(surface, field, spacing, seed);
  kernels_ = builder.place();
  const auto count = static_cast<uint32_t>(kernels_.size());
  const double reach = kReach * spacing;

  // Grids of the triangles, then who reaches which of their cells. Small triangles that follow each other in
  // a row share a cell.
  grids_.resize(surface.triangles.size());
  uint32_t cells = 0;
  glm::dvec3 box_low(0.0), box_high(0.0);  // of the last cell's triangles
  for (uint32_t t = 0; t < grids_.size(); ++t) {
    if (builder.reached()[t]) {
      const Corner3 c = builder.corners(t);
      const auto& p = c.p;
      const glm::dvec3 low = glm::min(p[0], glm::min(p[1], p[2])),
                       high = glm::max(p[0], glm::max(p[1], p[2]));
      const glm::dvec3 both = glm::max(box_high, high) - glm::min(box_low, low);
      if (t > 0 && grids_[t - 1].columns > 0 &&
          touch(surface.trianglePoints(t - 1), surface.trianglePoints(t)) &&
          std::max({both.x, both.y, both.z}) < kPatch * spacing) {
        grids_[t] = grids_[t - 1];
        box_low = glm::min(box_low, low);
        box_high = glm::max(box_high, high);
        continue;
      }
      box_low = low;
      box_high = high;
      grids_[t] = {cells, static_cast<uint32_t>(builder.partsOf(c, 1)),
                   static_cast<uint32_t>(builder.partsOf(c, 2))};
      cells += grids_[t].columns * grids_[t].rows;
    }
  }
  const Builder::Edges edges = builder.edges();
  std::vector<std::pair<uint32_t, uint32_t>> reaches;  // cell, kernel
  std::vector<uint32_t> visited(surface.triangles.size(), kNoIndex), last(cells, kNoIndex), queue;
  for (uint32_t k = 0; k < count; ++k) {
    const glm::dvec3 centre(kernels_[k].position);
    const auto isWithinReach = [&](uint32_t t) {
      const auto p = builder.corners(t).p;
      return glm::distance(p[0], centre) < reach || glm::distance(closestPoint(centre, p), centre) < reach;
    };
    queue.assign(1, builder.triangleOf(k));
    visited[queue[0]] = k;
    for (size_t i = 0; i < queue.size(); ++i) {
      const uint32_t t = queue[i];
      const Corner3 c = builder.corners(t);
      const Grid& grid = grids_[t];
      const glm::dvec2 b = c.barycentric(centre);
      // Barycentric coordinate i changes by 1 over the altitude of corner i.
      const double extent1 = reach * glm::distance(c.p[0], c.p[2]) / c.area2,
                   extent2 = reach * glm::distance(c.p[0], c.p[1]) / c.area2;
      const auto range = [](double low, double high, uint32_t parts) {
        const double most = parts - 1.0;
        return std::array<uint32_t, 2>{
            static_cast<uint32_t>(std::clamp(std::floor(low * parts), 0.0, most)),
            static_cast<uint32_t>(std::clamp(std::floor(high * parts), 0.0, most))};
      };
      const auto [column0, column1] = range(b.x - extent1, b.x + extent1, grid.columns);
      const auto [row0, row1] = range(b.y - extent2, b.y + extent2, grid.rows);
      for (uint32_t row = row0; row <= row1; ++row) {
        for (uint32_t column = column0; column <= column1; ++column) {
          const uint32_t at = grid.begin + row * grid.columns + column;
          if (last[at] != k) {
            reaches.emplace_back(at, k);
          }
          last[at] = k;
        }
      }
      for (uint32_t corner = 0; corner < 3; ++corner) {
        const uint32_t edge = edges.edge_of[3 * t + corner];
        for (uint32_t e = edges.offsets[edge]; e < edges.offsets[edge + 1]; ++e) {
          const uint32_t other = edges.triangles[e];
          if (visited[other] != k && isWithinReach(other)) {
            visited[other] = k;
            queue.push_back(other);
          }
        }
      }
    }
  }
  for (uint32_t t = 0; t < grids_.size(); ++t) grids_[t] = grids_[builder.firstOf(t)];
  offsets_.assign(cells + 1, 0);
  for (const auto& [cell_index, k] : reaches) {
    ++offsets_[cell_index + 1];
  }
  std::partial_sum(offsets_.begin(), offsets_.end(), offsets_.begin());
  lists_.resize(reaches.size());
  std::vector<uint32_t> next(offsets_.begin(), offsets_.end() - 1);
  for (const auto& [cell_index, k] : reaches) {
    lists_[next[cell_index]++] = k;
  }

  shape(neighboursOf(*this, builder, spacing), builder, spacing, seed, irregularity, kernels_);
}

uint32_t Kernels::cell(uint32_t triangle, glm::vec2 barycentric) const {
  const Grid& grid = grids_[triangle];
  const auto part = [](float b, uint32_t parts) {
    return static_cast<uint32_t>(
        std::clamp(b * static_cast<float>(parts), 0.0f, static_cast<float>(parts) - 0.5f));
  };
  return grid.begin + part(barycentric.y, grid.rows) * grid.columns + part(barycentric.x, grid.columns);
}

std::span<const uint32_t> Kernels::near(uint32_t triangle, glm::vec2 barycentric) const {
  if (grids_[triangle].columns == 0) {
    return {};
  }
  const uint32_t c = cell(triangle, barycentric);
  return std::span(lists_).subspan(offsets_[c], offsets_[c + 1] - offsets_[c]);
}

}  // namespace furrow::pipeline
