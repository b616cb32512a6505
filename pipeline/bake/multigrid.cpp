#include "pipeline/bake/multigrid.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <deque>
#include <numeric>

namespace furrow::pipeline {
namespace {

using Complex = std::complex<double>;
using Short = std::complex<float>;  // of the preconditioner, which need not be exact
using Entry = Equations::Entry;

constexpr uint32_t kNone = ~0u;
constexpr uint32_t kDirect = 500;  // unknowns that are solved at once
constexpr double kTolerance = 1e-5;
constexpr float kStrong = 0.25f;  // of the strongest entry of a row
constexpr double kEnough = 0.25;  // of the residual that a first step leaves, to do without a second
constexpr int kMostIterations = 300;

// The operator of std::complex looks out for infinities.
template <typename T>
std::complex<T> times(std::complex<T> a, std::complex<T> b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

// Of the plane's vectors.
template <typename T>
T dot(std::complex<T> a, std::complex<T> b) {
  return a.real() * b.real() + a.imag() * b.imag();
}

double dot(const std::vector<Short>& a, const std::vector<Short>& b) {
  double sum = 0.0;
  for (size_t i = 0; i < a.size(); ++i) sum += double{dot(a[i], b[i])};
  return sum;
}

void add(double times, const std::vector<Short>& what, std::vector<Short>& to) {
  for (size_t i = 0; i < to.size(); ++i) to[i] += static_cast<float>(times) * what[i];
}

Complex wide(Short z) {
  return {double{z.real()}, double{z.imag()}};
}

Short narrow(Complex z) {
  return {static_cast<float>(z.real()), static_cast<float>(z.imag())};
}

// Equations and, unless it is the last, its aggregates: an unknown follows one of the next level, turned; or
// none, if it has no neighbours.
struct Level {
  const Equations& a;
  std::vector<uint32_t> aggregate = {};  // an unknown, kNone: none
  std::vector<Short> turn = {};          // an unknown, length 1
  std::vector<Short> b = {}, x = {}, left = {}, first = {}, image = {};

  // An unknown with its free strong neighbours is an aggregate; what is left over joins its strongest
  // neighbour's. Weak neighbours, such as those across a long thin triangle, would tell it nothing.
  Equations coarsen() {
    const uint32_t count = a.rows();
    aggregate.assign(count, kNone);
    turn.assign(count, Short(1.0f));
    const auto strongOf = [&](uint32_t i) {
      float most = 0.0f;
      for (const Entry& e : a.row(i)) most = std::max(most, std::norm(e.value));
      return kStrong * kStrong * most;
    };
    const auto join = [&](uint32_t i, uint32_t j, Short a_ij) {
      aggregate[i] = aggregate[j];
      turn[i] = times(-a_ij / std::abs(a_ij), turn[j]);
    };
    uint32_t next = 0;
    for (uint32_t i = 0; i < count; ++i) {
      const float strong = strongOf(i);
      const auto isTaken = [&](const Entry& e) {
        return std::norm(e.value) >= strong && aggregate[e.column] != kNone;
      };
      if (aggregate[i] != kNone || strong == 0.0f || std::ranges::any_of(a.row(i), isTaken)) continue;
      aggregate[i] = next++;
      for (const Entry& e : a.row(i))
        if (std::norm(e.value) >= strong) join(e.column, i, std::conj(e.value));
    }
    std::vector<bool> late(count);
    for (uint32_t i = 0; i < count; ++i) {
      if (aggregate[i] != kNone) continue;
      const Entry* strongest = nullptr;
      for (const Entry& e : a.row(i))
        if (aggregate[e.column] != kNone && !late[e.column] &&
            (!strongest || std::norm(e.value) >= std::norm(strongest->value)))
          strongest = &e;
      const float strong = strongOf(i);
      if (strong == 0.0f) continue;
      late[i] = true;
      if (strongest && std::norm(strongest->value) >= strong)
        join(i, strongest->column, strongest->value);
      else
        aggregate[i] = next++;
    }
    return galerkin(next);
  }

  Equations galerkin(uint32_t count) const {
    std::vector<uint32_t> members(a.rows()), ends(count + size_t{1}, 0);
    for (const uint32_t to : aggregate)
      if (to != kNone) ++ends[to];
    std::partial_sum(ends.begin(), ends.end(), ends.begin());
    for (uint32_t i = a.rows(); i-- > 0;)
      if (aggregate[i] != kNone) members[--ends[aggregate[i]]] = i;  // ends become begins

    Equations coarse;
    coarse.diagonal.assign(count, 0.0);
    coarse.begins.reserve(count + size_t{1});
    std::vector<uint32_t> at(count, kNone);  // where the row has its entry of a column
    for (uint32_t row = 0; row < count; ++row) {
      const size_t begin = coarse.entries.size();
      coarse.begins.push_back(static_cast<uint32_t>(begin));
      for (uint32_t m = ends[row]; m < ends[row + 1]; ++m) {
        const uint32_t i = members[m];
        coarse.diagonal[row] += a.diagonal[i];
        for (const Entry& e : a.row(i)) {
          const uint32_t to = aggregate[e.column];
          if (to == kNone) continue;
          if (to == row) {
            coarse.diagonal[row] +=
                times(times(std::conj(wide(turn[i])), wide(e.value)), wide(turn[e.column])).real();
            continue;
          }
          if (at[to] == kNone || at[to] < begin) {
            at[to] = static_cast<uint32_t>(coarse.entries.size());
            coarse.entries.push_back({to, {}});
          }
          coarse.entries[at[to]].value += times(times(std::conj(turn[i]), e.value), turn[e.column]);
        }
      }
      std::sort(coarse.entries.begin() + static_cast<std::ptrdiff_t>(begin), coarse.entries.end(),
                [](const Entry& one, const Entry& other) { return one.column < other.column; });
    }
    coarse.begins.push_back(static_cast<uint32_t>(coarse.entries.size()));
    return coarse;
  }

  // A sweep of Gauss-Seidel from zero, and b - a x, which is then what it has not looked at: the entries
  // right of the diagonal.
  template <typename T>
  void begin(const std::vector<std::complex<T>>& given) {
    x.resize(a.rows());
    left.resize(a.rows());
    for (uint32_t i = 0; i < a.rows(); ++i) {
      Short rest(given[i]);
      for (const Entry& e : a.row(i)) {
        if (e.column > i) break;
        rest -= times(e.value, x[e.column]);
      }
      x[i] = rest / static_cast<float>(a.diagonal[i]);
    }
    for (uint32_t i = 0; i < a.rows(); ++i) {
      Short rest = 0.0f;
      const auto row = a.row(i);
      for (size_t e = row.size(); e-- > 0 && row[e].column > i;)
        rest -= times(row[e].value, x[row[e].column]);
      left[i] = rest;
    }
  }

  // A sweep backwards.
  template <typename T>
  void end(const std::vector<std::complex<T>>& given) {
    for (uint32_t i = a.rows(); i-- > 0;) {
      Short rest(given[i]);
      for (const Entry& e : a.row(i)) rest -= times(e.value, x[e.column]);
      x[i] = rest / static_cast<float>(a.diagonal[i]);
    }
  }

  // a x.
  void multiply(std::vector<Short>& out) const {
    out.resize(a.rows());
    for (uint32_t i = 0; i < a.rows(); ++i) {
      Short sum = static_cast<float>(a.diagonal[i]) * x[i];
      for (const Entry& e : a.row(i)) sum += times(e.value, x[e.column]);
      out[i] = sum;
    }
  }
};

// The preconditioner.
class Cycle {
 public:
  explicit Cycle(const Equations& equations) {  // which must outlive it
    levels_.push_back({equations});
    while (levels_.back().a.rows() > kDirect) {
      coarse_.push_back(levels_.back().coarsen());
      const uint64_t rows = coarse_.back().rows();
      if (rows == 0 || rows > uint64_t{levels_.back().a.rows()} * 9 / 10) break;
      levels_.push_back({coarse_.back()});
    }
    const Equations& last = levels_.back().a;
    std::vector<Eigen::Triplet<Complex>> entries;
    for (uint32_t i = 0; i < last.rows(); ++i) {
      entries.push_back({static_cast<int>(i), static_cast<int>(i), last.diagonal[i]});
      for (const Entry& e : last.row(i))
        entries.push_back({static_cast<int>(i), static_cast<int>(e.column), wide(e.value)});
    }
    Eigen::SparseMatrix<Complex> matrix(last.rows(), last.rows());
    matrix.setFromTriplets(entries.begin(), entries.end());
    direct_.compute(matrix);
  }

  // An approximate solution of a z = b.
  const std::vector<Short>& operator()(const std::vector<Complex>& b) {
    cycle(0, b);
    return levels_[0].x;
  }

 private:
  template <typename T>
  void cycle(size_t l, const std::vector<std::complex<T>>& b) {
    Level& level = levels_[l];
    if (l + 1 == levels_.size()) {
      Eigen::VectorXcd right(b.size());
      for (size_t i = 0; i < b.size(); ++i) right[static_cast<Eigen::Index>(i)] = Complex(b[i]);
      const Eigen::VectorXcd z = direct_.solve(right);
      level.x.resize(b.size());
      for (size_t i = 0; i < b.size(); ++i) level.x[i] = narrow(z[static_cast<Eigen::Index>(i)]);
      return;
    }
    Level& coarse = levels_[l + 1];
    level.begin(b);
    coarse.b.assign(coarse.a.rows(), Short(0.0f));
    for (size_t i = 0; i < b.size(); ++i)
      if (level.aggregate[i] != kNone)
        coarse.b[level.aggregate[i]] += times(std::conj(level.turn[i]), level.left[i]);
    solve(l + 1);
    for (size_t i = 0; i < b.size(); ++i)
      if (level.aggregate[i] != kNone) level.x[i] += times(level.turn[i], coarse.x[level.aggregate[i]]);
    level.end(b);
  }

  // Level l's x from its b, which is used up: the best in the plane of two cycles' directions, so that what a
  // level leaves undone does not grow with the number of levels [Notay and Vassilevski 2008, the K-cycle].
  void solve(size_t l) {
    Level& level = levels_[l];
    cycle(l, level.b);
    if (l + 1 == levels_.size()) return;
    level.multiply(level.image);
    const double curvature = dot(level.x, level.image), before = dot(level.b, level.b);
    if (!(curvature > 0.0)) return;  // b is zero
    level.first = level.x;
    double first = dot(level.x, level.b) / curvature, second = 0.0;
    add(-first, level.image, level.b);
    if (dot(level.b, level.b) > kEnough * kEnough * before) {
      cycle(l, level.b);
      level.multiply(level.left);
      const double shared = dot(level.x, level.image);
      const double own = dot(level.x, level.left) - shared * shared / curvature;
      if (own > 0.0) second = dot(level.x, level.b) / own;
      first -= shared / curvature * second;
    }
    for (Short& z : level.x) z *= static_cast<float>(second);
    add(first, level.first, level.x);
  }

  std::deque<Equations> coarse_;  // of the levels but the first
  std::vector<Level> levels_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<Complex>> direct_;
};

}  // namespace

std::vector<Complex> solveMultigrid(const Equations& a, std::vector<Complex> b) {
  Cycle cycle(a);
  const uint32_t count = a.rows();
  std::vector<Complex> x(count), direction(count), image(count);
  std::vector<Complex>& left = b;
  double square = 0.0, curvature = 1.0;
  for (const Complex z : left) square += std::norm(z);
  const double enough = kTolerance * kTolerance * square;
  for (int i = 0; square > enough && i < kMostIterations; ++i) {
    const std::vector<Short>& z = cycle(left);
    double descent = 0.0, shared = 0.0;
    for (uint32_t k = 0; k < count; ++k) {
      descent += dot(left[k], wide(z[k]));
      shared += dot(image[k], wide(z[k]));
    }
    for (uint32_t k = 0; k < count; ++k) direction[k] = wide(z[k]) - shared / curvature * direction[k];
    curvature = 0.0;
    for (uint32_t k = 0; k < count; ++k) {
      Complex sum = a.diagonal[k] * direction[k];
      for (const Entry& e : a.row(k)) sum += times(wide(e.value), direction[e.column]);
      image[k] = sum;
      curvature += dot(direction[k], sum);
    }
    const double step = descent / curvature;
    square = 0.0;
    for (uint32_t k = 0; k < count; ++k) {
      x[k] += step * direction[k];
      left[k] -= step * image[k];
      square += std::norm(left[k]);
    }
  }
  return x;
}

}  // namespace furrow::pipeline
