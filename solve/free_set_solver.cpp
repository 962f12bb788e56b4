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
    size_ = static_cast<Eigen::Index>(free.size());
    for (Eigen::Index j = 0; j < size_; ++j) {
      if (!(h(free[j], free[j]) > 0)) return false;
      scale_[j] = 1 / std::sqrt(h(free[j], free[j]));
    }
    for (Eigen::Index j = 0; j < size_; ++j) {
      lower_(j, j) = 1;
      for (Eigen::Index i = j + 1; i < size_; ++i) lower_(i, j) = h(free[i], free[j]) * scale_[i] * scale_[j];
    }
    return factor_in_place();
  }

  void solve(std::span<const double> c, std::span<double> x) noexcept {
    const int n = static_cast<int>(c.size());
    residual_.upper.setIdentity();
    for (Eigen::Index j = 0; j < size_; ++j) residual_.upper.row(j).segment(j, size_ - j) = column(j).transpose();
    residual_.whitened_c.setZero();
    for (int i = 0; i < n; ++i) residual_.whitened_c[i] = scale_[i] * c[i];
    substitute_forward(residual_.whitened_c, 0);
    z_.setZero();
    solver_.Solve(residual_, &z_);
    for (int i = 0; i < n; ++i) x[i] = scale_[i] * z_[i];
  }

  void predict(std::span<const double> c, std::span<double> x) noexcept {
    const int n = static_cast<int>(c.size());
    for (int i = 0; i < n; ++i) z_[i] = scale_[i] * c[i];
    substitute_forward(z_, 0);
    for (Eigen::Index j = size_ - 1; j >= 0; --j) {
      const Eigen::Index below = size_ - j - 1;
      z_[j] = (z_[j] - column(j).tail(below).dot(z_.segment(j + 1, below))) / lower_(j, j);
    }
    for (int i = 0; i < n; ++i) x[i] = scale_[i] * z_[i];
  }

  /// Column by column of L^-1, each of which begins at its own row.
  void inverse_diagonal(std::span<double> diagonal) noexcept {
    for (Eigen::Index j = 0; j < size_; ++j) {
      z_.segment(j, size_ - j).setZero();
      z_[j] = 1;
      substitute_forward(z_, j);
      diagonal[static_cast<std::size_t>(j)] = scale_[j] * scale_[j] * z_.segment(j, size_ - j).squaredNorm();
    }
  }

 private:
  using Residual = SquareRootResidual<N>;
  using Vector = typename Residual::Vector;
  using Matrix = typename Residual::Matrix;

  auto column(Eigen::Index j) noexcept { return lower_.col(j).segment(j, size_ - j); }

  /// Cholesky, by columns, of the leading size_ x size_ part: the free set is small, and a blocked or padded
  /// factorisation would spend its time on packing and on zeros. False if a pivot is not positive.
  bool factor_in_place() noexcept {
    for (Eigen::Index j = 0; j < size_; ++j) {
      for (Eigen::Index k = 0; k < j; ++k) column(j) -= lower_(j, k) * lower_.col(k).segment(j, size_ - j);
      if (!(lower_(j, j) > 0)) return false;
      column(j) /= std::sqrt(lower_(j, j));
    }
    return true;
  }

  /// z becomes L^-1 z, where its entries before `first` are zero.
  void substitute_forward(Vector& z, Eigen::Index first) noexcept {
    for (Eigen::Index j = first; j < size_; ++j) {
      const Eigen::Index below = size_ - j - 1;
      z[j] /= lower_(j, j);
      z.segment(j + 1, below) -= z[j] * column(j).tail(below);
    }
  }

  Eigen::Index size_ = 0;              // of the free set; everything beyond is padding
  Matrix lower_ = Matrix::Identity();  // L; above the diagonal nothing is meant
  Vector scale_ = Vector::Ones();
  Vector z_ = Vector::Zero();
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

void FreeSetSolver::inverse_diagonal(std::span<double> diagonal) noexcept {
  RISORIUS_CHECK(diagonal.size() == buckets_->free_count);
  if (diagonal.empty()) return;
  buckets_->with_current([&](auto& bucket) { bucket.inverse_diagonal(diagonal); });
}

}  // namespace risorius
