#include "pipeline/bake/multigrid.h"

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <deque>
#include <vector>

namespace furrow::pipeline {
namespace {

using Complex = std::complex<double>;
using Vector = Eigen::VectorXcd;
using Index = Eigen::Index;

constexpr Index kDirect = 500;  // unknowns that are solved at once
constexpr double kTolerance = 1e-5;
constexpr double kStrong = 0.25;  // of the strongest entry of a row
constexpr double kOver = 1.6;     // what a constant correction of an aggregate leaves undone
constexpr int kMostIterations = 300;

// The operator of std::complex looks out for infinities.
Complex times(Complex a, Complex b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

// A matrix and, unless it is the last, its aggregates: an unknown follows one of the next level, turned; or
// none, if it has no neighbours.
struct Level {
  const HermitianMatrix& matrix;
  std::vector<int> aggregate;  // an unknown, -1: none
  Vector turn;                 // an unknown, length 1

  // An unknown with its free strong neighbours is an aggregate; what is left over joins its strongest
  // neighbour's. Weak neighbours, such as those across a long thin triangle, would tell it nothing.
  HermitianMatrix coarsen() {
    const Index count = matrix.rows();
    aggregate.assign(static_cast<size_t>(count), -1);
    turn.setOnes(count);
    std::vector<double> strong(static_cast<size_t>(count), 0.0);
    for (Index i = 0; i < count; ++i)
      for (HermitianMatrix::InnerIterator e(matrix, i); e; ++e)
        if (e.col() != i) strong[i] = std::max(strong[i], kStrong * kStrong * std::norm(e.value()));
    const auto isStrong = [&](const HermitianMatrix::InnerIterator& e) {
      const double norm = std::norm(e.value());
      return e.col() != e.row() && norm > 0.0 && norm >= strong[e.row()];
    };
    const auto join = [&](Index i, Index j, Complex a_ij) {
      aggregate[i] = aggregate[j];
      turn[i] = -a_ij / std::abs(a_ij) * turn[j];
    };
    int next = 0;
    for (Index i = 0; i < count; ++i) {
      bool open = aggregate[i] < 0 && strong[i] > 0.0;
      for (HermitianMatrix::InnerIterator e(matrix, i); e && open; ++e)
        open = !isStrong(e) || aggregate[e.col()] < 0;
      if (!open) continue;
      aggregate[i] = next++;
      for (HermitianMatrix::InnerIterator e(matrix, i); e; ++e)
        if (isStrong(e)) join(e.col(), i, std::conj(e.value()));
    }
    const std::vector<int> first = aggregate;
    for (Index i = 0; i < count; ++i) {
      if (aggregate[i] >= 0 || strong[i] == 0.0) continue;
      Index best = -1;
      Complex strongest = 0.0;
      for (HermitianMatrix::InnerIterator e(matrix, i); e; ++e)
        if (isStrong(e) && first[e.col()] >= 0 && std::norm(e.value()) >= std::norm(strongest)) {
          best = e.col();
          strongest = e.value();
        }
      if (best >= 0)
        join(i, best, strongest);
      else
        aggregate[i] = next++;
    }
    std::vector<Eigen::Triplet<Complex>> entries;
    entries.reserve(static_cast<size_t>(matrix.nonZeros()));
    for (Index i = 0; i < count; ++i)
      for (HermitianMatrix::InnerIterator e(matrix, i); e; ++e)
        if (aggregate[i] >= 0 && aggregate[e.col()] >= 0)
          entries.push_back(
              {aggregate[i], aggregate[e.col()], times(times(std::conj(turn[i]), e.value()), turn[e.col()])});
    HermitianMatrix coarse(next, next);
    coarse.setFromTriplets(entries.begin(), entries.end());
    return coarse;
  }

  // A sweep of Gauss-Seidel from zero, and b - matrix * x, which is then what it has not looked at: the
  // entries right of the diagonal.
  void begin(const Vector& b, Vector& x, Vector& left) const {
    for (Index i = 0; i < matrix.rows(); ++i) {
      Complex rest = b[i];
      HermitianMatrix::InnerIterator e(matrix, i);
      for (; e.col() < i; ++e) rest -= times(e.value(), x[e.col()]);
      x[i] = rest / e.value().real();
    }
    for (Index i = matrix.rows() - 1; i >= 0; --i) {
      Complex rest = 0.0;
      for (HermitianMatrix::ReverseInnerIterator e(matrix, i); e.col() > i; --e)
        rest -= times(e.value(), x[e.col()]);
      left[i] = rest;
    }
  }

  // A sweep backwards.
  void end(const Vector& b, Vector& x) const {
    for (Index i = matrix.rows() - 1; i >= 0; --i) {
      Complex rest = b[i];
      double diagonal = 1.0;
      for (HermitianMatrix::InnerIterator e(matrix, i); e; ++e) {
        if (e.col() == i)
          diagonal = e.value().real();
        else
          rest -= times(e.value(), x[e.col()]);
      }
      x[i] = rest / diagonal;
    }
  }
};

// The preconditioner, as Eigen's conjugate gradients want it.
class Cycle {
 public:
  void prepare(const HermitianMatrix& matrix) {  // which must outlive it
    levels_.push_back({matrix, {}, {}});
    while (levels_.back().matrix.rows() > kDirect) {
      matrices_.push_back(levels_.back().coarsen());
      if (matrices_.back().rows() > levels_.back().matrix.rows() * 9 / 10) break;
      levels_.push_back({matrices_.back(), {}, {}});
    }
    direct_.compute(levels_.back().matrix);
  }
  template <class Matrix>
  Cycle& compute(const Matrix&) {
    return *this;
  }
  Eigen::ComputationInfo info() const { return Eigen::Success; }

  Vector solve(const Vector& b) const { return cycle(0, b); }

 private:
  Vector cycle(size_t l, const Vector& b) const {
    const Level& level = levels_[l];
    if (l + 1 == levels_.size()) return direct_.solve(b);
    Vector x(b.size()), left(b.size());
    level.begin(b, x, left);
    Vector coarse = Vector::Zero(levels_[l + 1].matrix.rows());
    for (Index i = 0; i < b.size(); ++i)
      if (level.aggregate[i] >= 0) coarse[level.aggregate[i]] += times(std::conj(level.turn[i]), left[i]);
    const Vector correction = kOver * cycle(l + 1, coarse);
    for (Index i = 0; i < b.size(); ++i)
      if (level.aggregate[i] >= 0) x[i] += times(level.turn[i], correction[level.aggregate[i]]);
    level.end(b, x);
    return x;
  }

  std::deque<HermitianMatrix> matrices_;  // of the levels but the first
  std::vector<Level> levels_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<Complex>> direct_;
};

}  // namespace

Eigen::VectorXcd solveMultigrid(const HermitianMatrix& a, const Eigen::VectorXcd& b) {
  Eigen::ConjugateGradient<HermitianMatrix, Eigen::Lower | Eigen::Upper, Cycle> solver;
  solver.setTolerance(kTolerance);
  solver.setMaxIterations(kMostIterations);
  solver.preconditioner().prepare(a);
  solver.compute(a);
  return solver.solve(b);
}

}  // namespace furrow::pipeline
