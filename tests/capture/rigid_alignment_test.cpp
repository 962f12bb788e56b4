#include "capture/rigid_alignment.h"

#include <Eigen/SVD>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace risorius {
namespace {

std::vector<Eigen::Vector3d> random_points(std::size_t count, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0, 50);
  std::vector<Eigen::Vector3d> points(count);
  for (auto& p : points) p = {normal(random), normal(random), normal(random)};
  return points;
}

TEST(RigidAlignment, RecoversEveryRotation) {
  for (unsigned seed = 1; seed <= 50; ++seed) {
    const auto from = random_points(12, seed);
    const RigidTransform truth{Eigen::Quaterniond::UnitRandom(), Eigen::Vector3d(1000, -20, 3)};
    std::vector<Eigen::Vector3d> to;
    for (const auto& p : from) to.push_back(truth * p);
    const auto found = align_rigid(from, to, std::vector<double>(from.size(), 1.0));
    ASSERT_TRUE(found.determined);
    for (const auto& p : from) EXPECT_LT((found.to_from * p - truth * p).norm(), 1e-9);
    EXPECT_LT((found.to_from.inverse() * (found.to_from * from[0]) - from[0]).norm(), 1e-9);
    EXPECT_LT(found.rms, 1e-9);
  }
}

TEST(RigidAlignment, NeverMirrors) {
  const auto from = random_points(12, 7);
  auto to = from;
  for (auto& p : to) p.x() = -p.x();
  const auto found = align_rigid(from, to, std::vector<double>(from.size(), 1.0));
  EXPECT_NEAR(found.to_from.rotation.toRotationMatrix().determinant(), 1, 1e-12);
  EXPECT_GT(found.rms, 1);
}

/// Horn's problem by a singular value decomposition (Kabsch), as an independent judge.
double least_rms(const std::vector<Eigen::Vector3d>& from, const std::vector<Eigen::Vector3d>& to) {
  const auto n = static_cast<Eigen::Index>(from.size());
  Eigen::Matrix3Xd a(3, n), b(3, n);
  for (Eigen::Index i = 0; i < n; ++i)
    a.col(i) = from[static_cast<std::size_t>(i)], b.col(i) = to[static_cast<std::size_t>(i)];
  a.colwise() -= Eigen::Vector3d(a.rowwise().mean());
  b.colwise() -= Eigen::Vector3d(b.rowwise().mean());
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(b * a.transpose(), Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  const Eigen::Matrix3d rotation = svd.matrixU() * Eigen::Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
  return std::sqrt((rotation * a - b).squaredNorm() / static_cast<double>(n));
}

double rms_of(const RigidTransform& transform, const std::vector<Eigen::Vector3d>& from,
              const std::vector<Eigen::Vector3d>& to) {
  double squared = 0;
  for (std::size_t i = 0; i < from.size(); ++i) squared += (transform * from[i] - to[i]).squaredNorm();
  return std::sqrt(squared / static_cast<double>(from.size()));
}

// From perfect to hopeless fits, shapes from round to nearly a line, half turns, and scales from metres to kilometres.
TEST(RigidAlignment, IsTheBestRotationForAwkwardShapesToo) {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal(0, 1);
  for (const double flat : {1.0, 0.1, 4e-3}) {
    for (const double thin : {1.0, 0.0}) {
      for (const double noise : {0.0, 1e-6, 0.01, 1.0}) {
        for (const double scale : {1e-3, 50.0, 1e6}) {
          for (int draw = 0; draw < 8; ++draw) {
            std::vector<Eigen::Vector3d> from = random_points(9, static_cast<unsigned>(random())), to;
            const Eigen::Quaterniond turn = draw == 0   ? Eigen::Quaterniond(0, 1, 0, 0)
                                            : draw == 1 ? Eigen::Quaterniond(0, 0.6, 0, 0.8)
                                                        : Eigen::Quaterniond::UnitRandom();
            for (auto& p : from) {
              p = scale / 50 * Eigen::Vector3d(p.x(), flat * p.y(), flat * thin * p.z());
              to.push_back(turn * p +
                           flat * noise * scale * Eigen::Vector3d(normal(random), normal(random), normal(random)));
            }
            const auto found = align_rigid(from, to, std::vector<double>(from.size(), 1.0));
            ASSERT_TRUE(found.determined);
            const double rms = rms_of(found.to_from, from, to);
            EXPECT_LE(rms, (1 + 1e-9) * least_rms(from, to) + 1e-9 * scale)
                << flat << " " << thin << " " << noise << " " << scale;
            EXPECT_NEAR(found.rms, rms, 1e-6 * rms + 1e-12 * scale);
          }
        }
      }
    }
  }
}

TEST(RigidAlignment, FindsARotationWhereSeveralAreEquallyGood) {
  const std::vector<Eigen::Vector3d> from{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  std::vector<Eigen::Vector3d> mirrored;
  for (const auto& p : from) mirrored.push_back(-p);
  const auto found = align_rigid(from, mirrored, std::vector<double>(4, 1.0));
  EXPECT_NEAR(rms_of(found.to_from, from, mirrored), least_rms(from, mirrored), 1e-9);
  EXPECT_NEAR(found.to_from.rotation.norm(), 1, 1e-12);
}

TEST(RigidAlignment, IgnoresPointsOfWeightZero) {
  auto from = random_points(5, 3);
  auto to = from;
  from[2].setConstant(std::nan(""));
  const std::vector<double> weights{1, 1, 0, 2, 1};
  const auto found = align_rigid(from, to, weights);
  EXPECT_TRUE(found.determined);
  EXPECT_LT(found.rms, 1e-9);
}

TEST(RigidAlignment, SaysWhenPointsAreOnOneLine) {
  const std::vector<Eigen::Vector3d> line{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  EXPECT_FALSE(align_rigid(line, line, std::vector<double>(3, 1.0)).determined);
  const std::vector<Eigen::Vector3d> flat{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  EXPECT_TRUE(align_rigid(flat, flat, std::vector<double>(3, 1.0)).determined);
  EXPECT_FALSE(align_rigid(flat, flat, std::vector<double>{1, 1, 0}).determined);
}

}  // namespace
}  // namespace risorius
