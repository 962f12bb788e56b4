// Ceres on the free set: solves H_FF x_F = c_F for any subset F of up to 64 variables, without allocating.
//
// With D = diag(H_FF) and the scaled matrix D^-1/2 H_FF D^-1/2 = L L^T, ceres::TinySolver minimises
//     1/2 || L^T z - L^-1 D^-1/2 c_F ||^2,   x_F = D^-1/2 z:
// square, with zero residual at the optimum, so that its cost keeps full relative precision. TinySolver's dynamic sizes
// allocate at every product; therefore one fixed-size solver per multiple of 16, padded with the identity.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>

namespace risorius {

class FreeSetSolver {
 public:
  /// For matrices of up to `max_size` (1 to kMaxAus) variables.
  explicit FreeSetSolver(int max_size);
  ~FreeSetSolver();
  FreeSetSolver(const FreeSetSolver&) = delete;
  FreeSetSolver& operator=(const FreeSetSolver&) = delete;

  /// Factors H_FF; `h` is K x K symmetric, of which the lower triangle is read, `free` ascending indices into it.
  /// False if H_FF is not numerically positive definite.
  [[nodiscard]] bool factor(const Eigen::MatrixXd& h, std::span<const int> free) noexcept;

  /// Solves with the last factor. Both spans have as many entries as the `free` of factor(). solve() is Ceres;
  /// predict() only substitutes into the factor, a tenth of the work: good for choosing the free set and a starting
  /// point.
  void solve(std::span<const double> c, std::span<double> x) noexcept;
  void predict(std::span<const double> c, std::span<double> x) noexcept;

  /// diag(H_FF^-1) of the last factor.
  void inverse_diagonal(std::span<double> diagonal) noexcept;

 private:
  struct Buckets;
  std::unique_ptr<Buckets> buckets_;
};

}  // namespace risorius
