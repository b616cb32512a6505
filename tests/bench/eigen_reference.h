#pragma once

#include <Eigen/SparseCore>
#include <cstdint>

namespace furrow::bench {

// Rows [begin, end) of rings * in. In a file of its own, aligned, so that its loop is the same code at the
// same place whatever else the benchmark holds: it is a sixth slower or faster with where the compiler
// happens to put it.
void gather(const Eigen::SparseMatrix<float, Eigen::RowMajor>& rings, const Eigen::VectorXf& in,
            uint32_t begin, uint32_t end, Eigen::VectorXf& out);

}  // namespace furrow::bench
