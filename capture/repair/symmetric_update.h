// What an online inverse costs: y = A x and A = s A - v v^T, of a symmetric A that is stored whole. Both run over whole
// columns and reorder no sum, so the bits are the same whatever the width of the machine's vectors, and the widest that
// this processor has is chosen when the program runs. The limit is the cache that A lies in.
#pragma once

#include <Eigen/Core>

namespace risorius {

/// y = A x. Sizes agree; y is apart from x.
void multiply_symmetric(const Eigen::MatrixXd& a, const Eigen::VectorXd& x, Eigen::VectorXd& y) noexcept;

/// A = scale A - v v^T: symmetric to the bit if A was.
void scale_less_square(Eigen::MatrixXd& a, double scale, const Eigen::VectorXd& v) noexcept;

}  // namespace risorius
