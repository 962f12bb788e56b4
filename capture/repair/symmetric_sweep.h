// The inverse of a symmetric positive definite matrix by Gauss and Jordan's sweeps, pivot by pivot, so that it can be
// spread over many calls; nothing is allocated. Only the lower triangle is read and written.
#pragma once

#include <Eigen/Core>

namespace risorius {

/// After every pivot had its turn, -A^-1 stands in place of A. `column`: room, as many as the matrix has rows.
inline void sweep_pivot(Eigen::MatrixXd& a, Eigen::Index pivot, Eigen::VectorXd& column) noexcept {
  const Eigen::Index size = a.cols();
  const double scale = 1 / a(pivot, pivot);
  for (Eigen::Index c = 0; c < pivot; ++c) column[c] = a(pivot, c);
  column.tail(size - pivot) = a.col(pivot).tail(size - pivot);
  column[pivot] = 0;
  for (Eigen::Index c = 0; c < size; ++c) {
    const double share = scale * column[c];
    a.col(c).tail(size - c) -= share * column.tail(size - c);
  }
  for (Eigen::Index c = 0; c < pivot; ++c) a(pivot, c) = scale * column[c];
  a.col(pivot).tail(size - pivot) = scale * column.tail(size - pivot);
  a(pivot, pivot) = -scale;
}

/// Both triangles of `whole` become what stands in the lower one of `swept`, times -1.
inline void negate_whole(const Eigen::MatrixXd& swept, Eigen::MatrixXd& whole) noexcept {
  for (Eigen::Index c = 0; c < swept.cols(); ++c) {
    const Eigen::Index below = swept.cols() - c;
    whole.col(c).tail(below) = -swept.col(c).tail(below);
    whole.row(c).tail(below) = whole.col(c).tail(below).transpose();
  }
}

}  // namespace risorius
