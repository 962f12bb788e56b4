#include "capture/repair/gap_regression.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace risorius {
namespace {

/// A marker that is a linear map of two features, plus what it does on its own.
struct Sampled {
  Eigen::MatrixXd features;
  Eigen::VectorXd time_s;
  Eigen::Matrix3Xd position_mm;
};

Sampled sampled(double from_s, double to_s, double noise_mm, double own_mm, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0, 1);
  const auto count = static_cast<Eigen::Index>(std::lround((to_s - from_s) * 60));
  Sampled s{Eigen::MatrixXd(2, count), Eigen::VectorXd(count), Eigen::Matrix3Xd(3, count)};
  for (Eigen::Index k = 0; k < count; ++k) {
    const double t = from_s + static_cast<double>(k) / 60;
    s.time_s[k] = t;
    s.features.col(k) << 3 * std::sin(4 * t), 2 * std::cos(2.3 * t);
    const double own = own_mm * std::sin(1.1 * t);
    s.position_mm.col(k) = Eigen::Vector3d(10, 20, 30) + s.features(0, k) * Eigen::Vector3d(1, 0.5, -0.3) +
                           s.features(1, k) * Eigen::Vector3d(0.2, -1, 0.4) + own * Eigen::Vector3d(0.3, 1, 0.2) +
                           noise_mm * Eigen::Vector3d(normal(random), normal(random), normal(random));
  }
  return s;
}

Sampled joined(const Sampled& a, const Sampled& b) {
  Sampled s{Eigen::MatrixXd(2, a.time_s.size() + b.time_s.size()), {}, {}};
  s.time_s.resize(s.features.cols());
  s.position_mm.resize(3, s.features.cols());
  s.features << a.features, b.features;
  s.time_s << a.time_s, b.time_s;
  s.position_mm << a.position_mm, b.position_mm;
  return s;
}

TEST(GapRegression, FindsTheMapOfTheOtherMarkersAcrossALongGap) {
  const Sampled known = joined(sampled(0, 2, 0.05, 0, 1), sampled(4, 5, 0.05, 0, 2));
  const Sampled truth = sampled(2, 4, 0, 0, 3);
  const auto fill = GapRegression({known.features, known.time_s, {}}, known.position_mm, 0.05)
                        .fill({truth.features, truth.time_s, {}});
  const double rms =
      (fill.position_mm - truth.position_mm).norm() / std::sqrt(static_cast<double>(truth.time_s.size()));
  EXPECT_LT(rms, 0.1);  // the noise is 0.087 mm in three axes
}

TEST(GapRegression, WithoutFeaturesItGoesFromEndToEnd) {
  Sampled known = joined(sampled(0, 2, 0, 0.5, 1), sampled(2.1, 4, 0, 0.5, 2));
  const Sampled truth = sampled(2, 2.1, 0, 0.5, 3);
  known.features.setZero();
  const auto fill = GapRegression({known.features, known.time_s, {}}, known.position_mm, 0.01)
                        .fill({0 * truth.features, truth.time_s, {}});
  EXPECT_LT((fill.position_mm - truth.position_mm).colwise().norm().maxCoeff(), 0.2);
}

// Nine in ten of the errors lie within 1.64 standard deviations; over thirty draws of three axes and 120 frames that
// are far from independent the share may wander by some percents.
TEST(GapRegression, StatesHowFarItIsOff) {
  double inside = 0, all = 0;
  for (unsigned seed = 0; seed < 30; ++seed) {
    const double own_mm = 0.2 + 0.05 * seed;
    const Sampled known = joined(sampled(0, 2, 0.1, own_mm, 2 * seed), sampled(4, 6, 0.1, own_mm, 2 * seed + 1));
    const Sampled truth = sampled(2, 4, 0, own_mm, 99);
    const auto fill = GapRegression({known.features, known.time_s, {}}, known.position_mm, 0.1)
                          .fill({truth.features, truth.time_s, {}});
    for (Eigen::Index k = 0; k < truth.time_s.size(); ++k) {
      const double bound = 1.6449 * std::sqrt(fill.variance_mm2[k]);
      inside += static_cast<double>(((fill.position_mm - truth.position_mm).col(k).array().abs() <= bound).count());
      all += 3;
    }
  }
  EXPECT_GT(inside / all, 0.85);
}

TEST(GapRegression, BelievesAGuessThatItsSamplesBearOutAndNoOther) {
  // Ten samples only: too few to learn the map of two features from, in noise.
  Sampled known = sampled(0, 0.17, 0.3, 0, 1);
  const Sampled truth = sampled(2, 3, 0, 0, 3);
  const auto guessed = [](const Sampled& s) {
    Eigen::Matrix3Xd guess(3, s.features.cols());
    for (Eigen::Index k = 0; k < guess.cols(); ++k) {
      guess.col(k) =
          s.features(0, k) * Eigen::Vector3d(1, 0.5, -0.3) + s.features(1, k) * Eigen::Vector3d(0.2, -1, 0.4);
    }
    return guess;
  };
  const auto error = [&](const Eigen::Matrix3Xd& of_known, const Eigen::Matrix3Xd& of_truth) {
    const auto fill = GapRegression({known.features, known.time_s, of_known}, known.position_mm, 0.3)
                          .fill({truth.features, truth.time_s, of_truth});
    return (fill.position_mm - truth.position_mm).norm() / std::sqrt(static_cast<double>(truth.time_s.size()));
  };
  const double alone = error({}, {});
  EXPECT_LT(error(guessed(known), guessed(truth)), 0.7 * alone);
  known = joined(sampled(0, 2, 0.05, 0, 1), sampled(4, 5, 0.05, 0, 2));
  EXPECT_LT(error(-guessed(known), -guessed(truth)), 0.1);  // against what all samples say
}

TEST(GapRegression, ASingleSampleIsHeldWithADeviation) {
  const Sampled one = sampled(0, 1.0 / 60, 0, 0, 1), truth = sampled(0.5, 1, 0, 0, 2);
  const auto fill =
      GapRegression({one.features, one.time_s, {}}, one.position_mm, 0.1).fill({truth.features, truth.time_s, {}});
  EXPECT_TRUE(fill.position_mm.allFinite());
  EXPECT_GT(fill.variance_mm2.minCoeff(), 0);
}

}  // namespace
}  // namespace risorius
