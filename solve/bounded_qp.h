// A small dense quadratic programme with bounds, solved exactly:
//     minimise 1/2 x' H x - b' x   subject to   0 <= x <= upper,   H symmetric positive definite, K <= 64.
//
// Block principal pivoting (Judice & Pires 1994; Kim & Park 2011) chooses which variables are free, warm-started from
// the last call, predicting with the factored Gram form; on the set on which it settles, Ceres solves
// (solve/free_set_solver.h). Where pivoting does not settle, a primal active-set method with Bland's rule takes over,
// which cannot cycle. Nothing allocates after construction.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "solve/free_set_solver.h"

namespace risorius {

enum class QpStatus : std::uint8_t { kConverged, kIterationLimit, kNotPositiveDefinite };

/// kPrediction leaves Ceres out: for the steps of an outer iteration whose last one is exact.
enum class QpEffort : std::uint8_t { kExact, kPrediction };

/// kSame promises the very matrix of the last call, which spares its factor where the free set stays.
enum class QpHessian : std::uint8_t { kNew, kSame };

struct QpResult {
  QpStatus status = QpStatus::kConverged;
  double kkt_residual = 0;     ///< || x - clip(x - D^-1 g, 0, upper) ||_inf at the returned x; D = diag(H), g = H x - b
  int free_set_solves = 0;     ///< how many free sets were tried
  bool used_fallback = false;  ///< pivoting did not settle
};

class BoundedQp {
 public:
  /// For `size` (1 to kMaxAus) variables; std::invalid_argument otherwise.
  explicit BoundedQp(int size);

  /// `h` is K x K, both triangles filled, diagonal > 0; `upper` >= 0, and an upper bound of 0 fixes the variable at 0.
  /// `x` has K entries and is overwritten; it always lies within the bounds.
  QpResult solve(const Eigen::MatrixXd& h, const Eigen::VectorXd& b, const Eigen::VectorXd& upper, Eigen::VectorXd& x,
                 QpEffort effort = QpEffort::kExact, QpHessian hessian = QpHessian::kNew) noexcept;

  /// Variances of the last solution at unit noise under a Hessian `h`, which may be another than the solution's:
  /// diag(H_FF^-1) for free variables; 1 / H_ii, which is conditional on all others, for variables at a bound.
  void inverse_diagonal(const Eigen::MatrixXd& h, Eigen::VectorXd& diagonal) noexcept;

  /// Whether variable i was strictly free in the last solution.
  bool is_free(int i) const noexcept { return place_[i] == Place::kFree; }

  /// Forgets the active set: the next solve starts with all variables at 0.
  void reset() noexcept;

  /// Starts the next solve in the fallback, so that a test can reach it.
  void force_fallback(bool force) noexcept { force_fallback_ = force; }

 private:
  enum class Place : std::uint8_t { kLower, kFree, kUpper };
  struct Problem {
    const Eigen::MatrixXd& h;
    const Eigen::VectorXd& b;
    const Eigen::VectorXd& upper;
    double tolerance;  // of x and D^-1 g
  };
  enum class Method : std::uint8_t { kPredict, kCeres };

  bool factor_free_set(const Problem& problem) noexcept;
  void minimise_on_free_set(const Problem& problem, Method method) noexcept;
  bool settle_with_ceres(const Problem& problem) noexcept;
  void update_gradient(const Problem& problem) noexcept;
  double violation(const Problem& problem, int i) const noexcept;
  bool pivot_blocks(const Problem& problem, QpResult& result) noexcept;
  int exchange_violators(const Problem& problem, bool exchange) noexcept;
  void descend_feasibly(const Problem& problem, QpResult& result) noexcept;
  bool step_to_minimum(const Problem& problem) noexcept;
  int variable_to_release(const Problem& problem, bool least_index) const noexcept;
  void move_inside_bounds(const Problem& problem) noexcept;
  double kkt_residual(const Problem& problem) const noexcept;

  int size_;
  FreeSetSolver free_set_;
  std::vector<Place> place_;
  std::vector<int> free_;      // ascending; capacity K
  std::vector<int> factored_;  // the free set whose factor free_set_ holds; capacity K
  bool factor_holds_ = false;
  std::vector<double> c_free_, x_free_;
  Eigen::VectorXd x_, gradient_, feasible_;
  bool force_fallback_ = false;
};

}  // namespace risorius
