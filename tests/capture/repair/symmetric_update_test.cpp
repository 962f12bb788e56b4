#include "capture/repair/symmetric_update.h"

#include <gtest/gtest.h>

#include "support/allocation_counter.h"

namespace risorius {
namespace {

Eigen::MatrixXd symmetric(Eigen::Index size) {
  const Eigen::MatrixXd half = Eigen::MatrixXd::Random(size, size);
  return half + half.transpose();
}

TEST(SymmetricUpdate, MultipliesInOneOrderOfSumsWhateverTheVectorsAre) {
  for (const Eigen::Index size : {1, 3, 4, 7, 33, 165}) {
    const Eigen::MatrixXd a = symmetric(size);
    const Eigen::VectorXd x = Eigen::VectorXd::Random(size);
    Eigen::VectorXd y(size);
    multiply_symmetric(a, x, y);
    EXPECT_LT((y - a * x).norm(), 1e-12 * a.norm() * x.norm()) << size;
    for (Eigen::Index row = 0; row < size; ++row) {
      // volatile: each sum as it stands here, by no vector.
      volatile double sum = 0;
      Eigen::Index c = 0;
      for (; c + 4 <= size; c += 4) {
        volatile const double first = a(row, c) * x[c] + a(row, c + 1) * x[c + 1];
        volatile const double second = a(row, c + 2) * x[c + 2] + a(row, c + 3) * x[c + 3];
        sum = sum + (first + second);
      }
      for (; c < size; ++c) sum = sum + a(row, c) * x[c];
      EXPECT_EQ(y[row], sum) << size << " " << row;
    }
  }
}

TEST(SymmetricUpdate, StaysSymmetricToTheBit) {
  Eigen::MatrixXd a = symmetric(37);
  const Eigen::MatrixXd before = a;
  const Eigen::VectorXd v = Eigen::VectorXd::Random(37);
  scale_less_square(a, 1.001, v);
  EXPECT_LT((a - (1.001 * before - v * v.transpose())).norm(), 1e-12);
  for (int i = 0; i < 1000; ++i) scale_less_square(a, 0.999, v);
  EXPECT_EQ(a, Eigen::MatrixXd(a.transpose()));
}

TEST(SymmetricUpdate, AllocatesNothing) {
  Eigen::MatrixXd a = symmetric(165);
  const Eigen::VectorXd x = Eigen::VectorXd::Random(165);
  Eigen::VectorXd y(165);
  const auto before = test::allocations_of_this_thread();
  multiply_symmetric(a, x, y);
  scale_less_square(a, 1, y);
  EXPECT_EQ(test::allocations_of_this_thread(), before);
}

}  // namespace
}  // namespace risorius
