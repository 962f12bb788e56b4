#include "solve/free_set_solver.h"

#include <Eigen/Cholesky>
#include <array>
#include <ceres/tiny_solver.h>
#include <cmath>
#include <limits>
#include <tuple>

#include "capture/check.h"
#include "capture/frames.h"

namespace risorius {
namespace {

// Each size costs ten seconds of compilation; four waste little, since free sets are small.
constexpr int kBucketStep = 16;
constexpr int kBucketCount = static_cast<int>(kMaxAus) / kBucketStep;

/// r(z) = L^T z - L^-1 c, Jacobian L^T.
template <int N>
struct SquareRootResidual {
  using Scalar = double;
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;
  enum { NUM_RESIDUALS = N, NUM_PARAMETERS = N };

  Matrix upper;       // L^T
  Vector whitened_c;  // L^-1 c

  bool operator()(const double* z, double* residual, double* jacobian) const {
    Eigen::Map<Vector> r(residual);
    r = -whitened_c;
    r.noalias() += upper * Eigen::Map<const Vector>(z);
    if (jacobian != nullptr) Eigen::Map<Matrix>{jacobian} = upper;
    return true;
  }
};

/// Everything that one padded size needs, allocated once.
template <int N>
class Bucket {
 public:
  Bucket() {
    // The residual is linear: the undamped first step is the solution, and none of Ceres's stopping rules may come
    // before it. An infinite function tolerance ends the iteration with that step, sparing a second Jacobian.
    solver_.options.initial_trust_region_radius = 1e30;
    solver_.options.gradient_tolerance = 0;
    solver_.options.parameter_tolerance = 0;
    solver_.options.cost_threshold = 0;
    solver_.options.function_tolerance = std::numeric_limits<double>::infinity();
    solver_.options.max_num_iterations = 2;
  }

  bool factor(const Eigen::MatrixXd& h, std::span<const int> free) noexcept {
    const int n = static_cast<int>(free.size());
    scaled_.setIdentity();
    for (int j = 0; j < n; ++j) {
      if (!(h(free[j], free[j]) > 0)) return false;
      scale_[j] = 1 / std::sqrt(h(free[j], free[j]));
    }
    for (int j = 0; j < n; ++j) {
      for (int i = j + 1; i < n; ++i) scaled_(i, j) = h(free[i], free[j]) * scale_[i] * scale_[j];
    }
    llt_.compute(scaled_);
    if (llt_.info() != Eigen::Success) return false;
    residual_.upper = llt_.matrixU();
    return true;
  }

  void solve(std::span<const double> c, std::span<double> x) noexcept {
    const int n = static_cast<int>(c.size());
    residual_.whitened_c.setZero();
    for (int i = 0; i < n; ++i) residual_.whitened_c[i] = scale_[i] * c[i];
    llt_.matrixL().solveInPlace(residual_.whitened_c);
    z_.setZero();
    solver_.Solve(residual_, &z_);
    for (int i = 0; i < n; ++i) x[i] = scale_[i] * z_[i];
  }

  void predict(std::span<const double> c, std::span<double> x) noexcept {
    const int n = static_cast<int>(c.size());
    z_.setZero();
    for (int i = 0; i < n; ++i) z_[i] = scale_[i] * c[i];
    llt_.solveInPlace(z_);
    for (int i = 0; i < n; ++i) x[i] = scale_[i] * z_[i];
  }

  void inverse_diagonal(std::span<double> diagonal) const noexcept {
    Matrix inverse_l = Matrix::Identity();
    llt_.matrixL().solveInPlace(inverse_l);
    for (int i = 0; i < static_cast<int>(diagonal.size()); ++i) {
      diagonal[i] = scale_[i] * scale_[i] * inverse_l.col(i).squaredNorm();
    }
  }

 private:
  using Residual = SquareRootResidual<N>;
  using Vector = typename Residual::Vector;
  using Matrix = typename Residual::Matrix;

  Matrix scaled_ = Matrix::Identity();
  Vector scale_ = Vector::Ones();
  Vector z_ = Vector::Zero();
  Eigen::LLT<Matrix> llt_;
  Residual residual_;
  ceres::TinySolver<Residual, Eigen::LLT<Matrix>> solver_;
};

}  // namespace

struct FreeSetSolver::Buckets {
  std::tuple<std::unique_ptr<Bucket<16>>, std::unique_ptr<Bucket<32>>, std::unique_ptr<Bucket<48>>,
             std::unique_ptr<Bucket<64>>>
      by_size;
  int allocated = 0;
  int current = 0;  // of the last factor()
  std::size_t free_count = 0;

  static_assert(std::tuple_size_v<decltype(by_size)> == kBucketCount);

  template <int I = 0>
  void allocate(int count) {
    if constexpr (I < kBucketCount) {
      if (I < count) std::get<I>(by_size) = std::make_unique<Bucket<(I + 1) * kBucketStep>>();
      allocate<I + 1>(count);
    }
    allocated = count;
  }

  /// Calls `act` with the current bucket.
  template <int I = 0, class Act>
  void with_current(Act&& act) noexcept {
    if constexpr (I < kBucketCount) {
      if (I == current) {
        act(*std::get<I>(by_size));
      } else {
        with_current<I + 1>(act);
      }
    }
  }
};

FreeSetSolver::FreeSetSolver(int max_size) : buckets_(std::make_unique<Buckets>()) {
  RISORIUS_CHECK(max_size >= 1 && max_size <= static_cast<int>(kMaxAus));
  buckets_->allocate((max_size + kBucketStep - 1) / kBucketStep);
}

FreeSetSolver::~FreeSetSolver() = default;

bool FreeSetSolver::factor(const Eigen::MatrixXd& h, std::span<const int> free) noexcept {
  buckets_->free_count = free.size();
  if (free.empty()) return true;
  buckets_->current = (static_cast<int>(free.size()) - 1) / kBucketStep;
  RISORIUS_CHECK(buckets_->current < buckets_->allocated);
  bool positive_definite = false;
  buckets_->with_current([&](auto& bucket) { positive_definite = bucket.factor(h, free); });
  return positive_definite;
}

void FreeSetSolver::solve(std::span<const double> c, std::span<double> x) noexcept {
  RISORIUS_CHECK(c.size() == buckets_->free_count && x.size() == c.size());
  if (c.empty()) return;
  buckets_->with_current([&](auto& bucket) { bucket.solve(c, x); });
}

void FreeSetSolver::predict(std::span<const double> c, std::span<double> x) noexcept {
  RISORIUS_CHECK(c.size() == buckets_->free_count && x.size() == c.size());
  if (c.empty()) return;
  buckets_->with_current([&](auto& bucket) { bucket.predict(c, x); });
}

void FreeSetSolver::inverse_diagonal(std::span<double> diagonal) const noexcept {
  RISORIUS_CHECK(diagonal.size() == buckets_->free_count);
  if (diagonal.empty()) return;
  buckets_->with_current([&](auto& bucket) { bucket.inverse_diagonal(diagonal); });
}

}  // namespace risorius
