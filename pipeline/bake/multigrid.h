#pragma once

// Linear equations on large meshes in linear time.

#include <complex>
#include <cstdint>
#include <span>
#include <vector>

namespace furrow::pipeline {

// A connection Laplacian plus a positive diagonal: Hermitian and positive definite, with a_ij minus the
// weight of an edge times the turn from j to i. Entries are of single precision, 12
// bytes each, so that millions of points fit.
struct Equations {
  struct Entry {
    uint32_t column;
    std::complex<float> value;
  };
  std::vector<double> diagonal;
  std::vector<uint32_t> begins;  // a row and one: of its entries
  std::vector<Entry> entries;    // but the diagonal; by column in a row, which may stand there several times

  uint32_t rows() const { return static_cast<uint32_t>(diagonal.size()); }
  std::span<const Entry> row(uint32_t i) const {
    return std::span(entries).subspan(begins[i], begins[i + 1] - begins[i]);
  }
};

// Solves a x = b to a residual of 1e-5 |b|: conjugate gradients, preconditioned by a cycle over aggregates of
// neighbours.
std::vector<std::complex<double>> solveMultigrid(const Equations& a, std::vector<std::complex<double>> b);

}  // namespace furrow::pipeline
