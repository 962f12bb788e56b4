#include "solve/bounded_qp.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gtest/gtest.h>
#include <random>

#include "support/allocation_counter.h"

namespace risorius {
namespace {

constexpr double kKktBar = 1e-9;

struct Qp {
  Eigen::MatrixXd h;
  Eigen::VectorXd b, upper;
};

/// H = A'A + ridge of a random tall A; `collinear`: every other column nearly repeats its left neighbour.
Qp random_qp(int size, unsigned seed, bool collinear = false) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0, 1);
  Eigen::MatrixXd a(3 * size, size);
  for (double& entry : a.reshaped()) entry = normal(random);
  for (int i = 0; i < size; ++i) {
    if (collinear && i % 2 == 1) a.col(i) = a.col(i - 1) + 1e-3 * a.col(i);
    a.col(i) *= std::pow(10.0, 2 * uniform(random) - 1);  // AUs differ in size
  }
  Qp qp;
  qp.h = a.transpose() * a;
  qp.h.diagonal().array() += 1e-6 * qp.h.diagonal().mean();
  Eigen::VectorXd truth(size);
  qp.upper.resize(size);
  for (int i = 0; i < size; ++i) {
    truth[i] = 3 * uniform(random) - 1;  // below 0, within, above the bound
    qp.upper[i] = 1.2;
  }
  qp.b = qp.h * truth;
  return qp;
}

double objective(const Qp& qp, const Eigen::VectorXd& x) { return 0.5 * x.dot(qp.h * x) - qp.b.dot(x); }

/// The best feasible point among the stationary points of all 3^K active sets: the definition, not an algorithm.
Eigen::VectorXd enumerate_active_sets(const Qp& qp) {
  const int size = static_cast<int>(qp.b.size());
  int sets = 1;
  for (int i = 0; i < size; ++i) sets *= 3;
  Eigen::VectorXd best;
  double least = std::numeric_limits<double>::infinity();
  for (int set = 0; set < sets; ++set) {
    Eigen::VectorXd x = Eigen::VectorXd::Zero(size);
    std::vector<int> free;
    for (int i = 0, code = set; i < size; ++i, code /= 3) {
      if (code % 3 == 1) x[i] = qp.upper[i];
      if (code % 3 == 2) free.push_back(i);
    }
    const Eigen::VectorXd rest = qp.b - qp.h * x;
    if (!free.empty()) {
      const Eigen::MatrixXd h_free = qp.h(free, free);
      const Eigen::VectorXd x_free = h_free.ldlt().solve(rest(free).eval());
      for (std::size_t k = 0; k < free.size(); ++k) x[free[k]] = x_free[static_cast<Eigen::Index>(k)];
    }
    const bool feasible = (x.array() >= 0).all() && (x.array() <= qp.upper.array()).all();
    if (!feasible || !(objective(qp, x) < least)) continue;
    least = objective(qp, x);
    best = x;
  }
  return best;
}

/// Accelerated projected gradient with restarts, in the variables in which the diagonal is 1.
Eigen::VectorXd projected_gradient(const Qp& qp, int steps) {
  const Eigen::VectorXd scale = qp.h.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd h = scale.asDiagonal() * qp.h * scale.asDiagonal();
  const Eigen::VectorXd b = scale.cwiseProduct(qp.b), upper = qp.upper.cwiseQuotient(scale);
  const double lipschitz = h.cwiseAbs().rowwise().sum().maxCoeff();
  Eigen::VectorXd x = Eigen::VectorXd::Zero(b.size()), previous = x, y = x;
  double momentum = 1;
  for (int step = 0; step < steps; ++step) {
    x = (y - (h * y - b) / lipschitz).cwiseMax(0).cwiseMin(upper);
    if ((y - x).dot(x - previous) > 0) momentum = 1;
    const double next = (1 + std::sqrt(1 + 4 * momentum * momentum)) / 2;
    y = x + (momentum - 1) / next * (x - previous);
    momentum = next;
    previous = x;
  }
  return x.cwiseProduct(scale);
}

void expect_solved(BoundedQp& solver, const Qp& qp, Eigen::VectorXd& x) {
  const QpResult result = solver.solve(qp.h, qp.b, qp.upper, x);
  EXPECT_EQ(result.status, QpStatus::kConverged);
  EXPECT_LE(result.kkt_residual, kKktBar);
  EXPECT_GE(x.minCoeff(), 0);
  EXPECT_LE((x - qp.upper).maxCoeff(), 0);
  // The certificate, computed again from its definition.
  const Eigen::VectorXd g = qp.h * x - qp.b;
  const Eigen::VectorXd projected = (x - g.cwiseQuotient(qp.h.diagonal())).cwiseMax(0).cwiseMin(qp.upper);
  EXPECT_LE((x - projected).cwiseAbs().maxCoeff(), kKktBar);
}

TEST(BoundedQp, EqualsTheBestOfAllActiveSets) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    const int size = 1 + static_cast<int>(seed % 6);
    for (const bool collinear : {false, true}) {
      const Qp qp = random_qp(size, seed, collinear);
      BoundedQp solver(size);
      Eigen::VectorXd x(size);
      expect_solved(solver, qp, x);
      EXPECT_LE((x - enumerate_active_sets(qp)).cwiseAbs().maxCoeff(), 1e-7) << "size " << size << " seed " << seed;
    }
  }
}

TEST(BoundedQp, IsNoWorseThanConvergedProjectedGradient) {
  for (const int size : {15, 52}) {
    for (unsigned seed = 0; seed < 3; ++seed) {
      for (const bool collinear : {false, true}) {
        const Qp qp = random_qp(size, 100 + seed, collinear);
        BoundedQp solver(size);
        Eigen::VectorXd x(size);
        expect_solved(solver, qp, x);
        const Eigen::VectorXd reference = projected_gradient(qp, 4000);
        EXPECT_LE(objective(qp, x), objective(qp, reference) + 1e-12 * std::abs(objective(qp, reference)));
        // Collinear columns leave their difference open to the last digits; what they explain together is determined.
        if (!collinear) {
          EXPECT_LE((x - reference).cwiseAbs().maxCoeff(), 1e-6);
        }
      }
    }
  }
}

TEST(BoundedQp, FallbackFindsTheSameMinimum) {
  for (unsigned seed = 0; seed < 30; ++seed) {
    const int size = 2 + static_cast<int>(seed * 2);
    const Qp qp = random_qp(size, 200 + seed, seed % 2 == 0);
    BoundedQp pivoting(size), descending(size);
    descending.force_fallback(true);
    Eigen::VectorXd x(size), y(size);
    expect_solved(pivoting, qp, x);
    expect_solved(descending, qp, y);
    EXPECT_LE(std::abs(objective(qp, x) - objective(qp, y)), 1e-12 * std::abs(objective(qp, x)));
  }
}

TEST(BoundedQp, WarmStartFollowsAChangingProblemExactly) {
  constexpr int kSize = 52;
  BoundedQp warm(kSize);
  Qp qp = random_qp(kSize, 7);
  const Eigen::VectorXd from = qp.b, to = random_qp(kSize, 7).h * Eigen::VectorXd::LinSpaced(kSize, 2, -1);
  Eigen::VectorXd x(kSize), cold_x(kSize);
  int solves = 0;
  for (int frame = 0; frame <= 50; ++frame) {
    qp.b = from + frame / 50.0 * (to - from);
    const QpResult result = warm.solve(qp.h, qp.b, qp.upper, x);
    EXPECT_LE(result.kkt_residual, kKktBar);
    solves += result.free_set_solves;
    BoundedQp cold(kSize);
    cold.solve(qp.h, qp.b, qp.upper, cold_x);
    EXPECT_LE((x - cold_x).cwiseAbs().maxCoeff(), 1e-9);
  }
  EXPECT_LT(solves, 51 * 6);  // a cold start needs about 6 free sets here, a warm one rarely more than 3
}

TEST(BoundedQp, KeepsVariablesOfBoundZeroAtZero) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    Qp qp = random_qp(15, 300 + seed);
    for (int i = 0; i < 15; i += 3) qp.upper[i] = 0;
    BoundedQp solver(15);
    Eigen::VectorXd x(15);
    expect_solved(solver, qp, x);
    for (int i = 0; i < 15; i += 3) EXPECT_EQ(x[i], 0);
    qp.upper.setZero();
    expect_solved(solver, qp, x);
    EXPECT_EQ(x.norm(), 0);
  }
}

TEST(BoundedQp, SolvesDegenerateProblems) {
  // Every variable lies exactly on a bound with zero gradient: b = H x for x on the bounds.
  for (unsigned seed = 0; seed < 20; ++seed) {
    Qp qp = random_qp(20, 400 + seed);
    Eigen::VectorXd truth = Eigen::VectorXd::Zero(20);
    for (int i = 0; i < 20; i += 2) truth[i] = qp.upper[i];
    qp.b = qp.h * truth;
    for (const bool fallback : {false, true}) {
      BoundedQp solver(20);
      solver.force_fallback(fallback);
      Eigen::VectorXd x(20);
      expect_solved(solver, qp, x);
      EXPECT_LE((x - truth).cwiseAbs().maxCoeff(), 1e-8);
    }
  }
}

TEST(BoundedQp, ReportsAMatrixThatIsNotPositiveDefinite) {
  Qp qp;
  qp.h = (Eigen::Matrix2d() << 1, -2, -2, 1).finished();  // eigenvalues -1 and 3; both variables pull each other up
  qp.b = Eigen::Vector2d(1, 1);
  qp.upper = Eigen::Vector2d(1.2, 1.2);
  BoundedQp solver(2);
  Eigen::VectorXd x(2);
  EXPECT_EQ(solver.solve(qp.h, qp.b, qp.upper, x).status, QpStatus::kNotPositiveDefinite);
  EXPECT_GE(x.minCoeff(), 0);
  EXPECT_LE((x - qp.upper).maxCoeff(), 0);
}

TEST(BoundedQp, SolvesTiedColumnsWhereBlocksAreSingular) {
  Qp qp;
  qp.h = Eigen::Matrix2d::Ones();
  qp.b = Eigen::Vector2d(0.5, 0.5);
  qp.upper = Eigen::Vector2d(0.3, 0.3);
  BoundedQp solver(2);
  Eigen::VectorXd x(2);
  expect_solved(solver, qp, x);
  EXPECT_NEAR(x.sum(), 0.5, 1e-12);
}

TEST(BoundedQp, InverseDiagonalIsThatOfTheFreeBlock) {
  const Qp qp = random_qp(15, 11);
  BoundedQp solver(15);
  Eigen::VectorXd x(15), diagonal(15);
  expect_solved(solver, qp, x);
  solver.inverse_diagonal(qp.h, diagonal);
  std::vector<int> free;
  for (int i = 0; i < 15; ++i) {
    if (solver.is_free(i)) {
      free.push_back(i);
    } else {
      EXPECT_EQ(diagonal[i], 1 / qp.h(i, i));
    }
  }
  ASSERT_GT(free.size(), 1u);
  const Eigen::MatrixXd inverse = qp.h(free, free).inverse();
  for (std::size_t k = 0; k < free.size(); ++k) {
    const auto kk = static_cast<Eigen::Index>(k);
    EXPECT_NEAR(diagonal[free[k]], inverse(kk, kk), 1e-9 * inverse(kk, kk));
  }
}

TEST(BoundedQp, AllocatesNothingWhateverTheFreeSet) {
  for (const int size : {1, 15, 52, 64}) {
    std::vector<Qp> problems;
    for (unsigned seed = 0; seed < 8; ++seed) problems.push_back(random_qp(size, 500 + seed));
    BoundedQp solver(size);
    Eigen::VectorXd x(size), diagonal(size);
    for (const bool fallback : {false, true}) {
      solver.force_fallback(fallback);
      for (Qp& qp : problems) {
        for (const double lift : {-10.0, -1.0, 0.0, 0.3, 10.0}) {
          const Eigen::VectorXd b = qp.b + lift * qp.h.diagonal();
          const std::uint64_t before = test::allocations_of_this_thread();
          solver.solve(qp.h, b, qp.upper, x);
          solver.inverse_diagonal(qp.h, diagonal);
          EXPECT_EQ(test::allocations_of_this_thread(), before) << "size " << size;
        }
      }
    }
  }
}

TEST(BoundedQp, RefusesSizesOutOfRange) {
  EXPECT_THROW(BoundedQp(0), std::invalid_argument);
  EXPECT_THROW(BoundedQp(65), std::invalid_argument);
}

}  // namespace
}  // namespace risorius
