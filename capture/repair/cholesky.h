// Cholesky factor and triangular solves in place, which allocate nothing whatever the size: Eigen's own blocked ones
// take memory for large sizes. Only the lower triangle is read. Matrices are positive definite.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace risorius {

/// A becomes L with A = L L^T.
inline void factorize_lower(Eigen::Map<Eigen::MatrixXd>& a) noexcept {
  const Eigen::Index size = a.cols();
  for (Eigen::Index c = 0; c < size; ++c) {
    for (Eigen::Index k = 0; k < c; ++k) a.col(c).tail(size - c) -= a(c, k) * a.col(k).tail(size - c);
    a.col(c).tail(size - c) /= std::sqrt(a(c, c));
  }
}

/// X becomes L^-1 X.
template <class Columns>
void solve_lower(const Eigen::Map<const Eigen::MatrixXd>& l, Columns&& x) noexcept {
  const Eigen::Index size = l.cols();
  for (Eigen::Index k = 0; k < x.cols(); ++k) {
    auto column = x.col(k);
    for (Eigen::Index c = 0; c < size; ++c) {
      column[c] /= l(c, c);
      column.tail(size - c - 1) -= column[c] * l.col(c).tail(size - c - 1);
    }
  }
}

/// x becomes L^-T x.
template <class Column>
void solve_lower_transposed(const Eigen::Map<const Eigen::MatrixXd>& l, Column&& x) noexcept {
  const Eigen::Index size = l.cols();
  for (Eigen::Index c = size - 1; c >= 0; --c) {
    x[c] = (x[c] - l.col(c).tail(size - c - 1).dot(x.tail(size - c - 1))) / l(c, c);
  }
}

}  // namespace risorius
