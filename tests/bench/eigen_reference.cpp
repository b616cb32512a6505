#include "eigen_reference.h"

namespace furrow::bench {

void gather(const Eigen::SparseMatrix<float, Eigen::RowMajor>& rings, const Eigen::VectorXf& in,
            uint32_t begin, uint32_t end, Eigen::VectorXf& out) {
  out.segment(begin, end - begin).noalias() = rings.middleRows(begin, end - begin) * in;
}

}  // namespace furrow::bench
