#pragma once

// Linear equations on large meshes in linear time.

#include <Eigen/SparseCore>
#include <complex>

namespace furrow::pipeline {

using HermitianMatrix = Eigen::SparseMatrix<std::complex<double>, Eigen::RowMajor>;

// Solves a x = b to a residual of 1e-5 |b|: conjugate gradients, preconditioned by a cycle over aggregates of
// neighbours. `a` is a connection Laplacian plus a positive diagonal: Hermitian, positive definite, a_ij
// minus the weight of an edge times the turn from j to i.
Eigen::VectorXcd solveMultigrid(const HermitianMatrix& a, const Eigen::VectorXcd& b);

}  // namespace furrow::pipeline
