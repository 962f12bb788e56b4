#include "generate/transition_features.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <stdexcept>

namespace risorius {
namespace {

const std::vector<std::string> kNames{"AU12L", "AU12R", "AU27"};

/// A smile on its way from t = 0 (the last row) on; the jaw rests.
TransitionRequest request_of(double rate_hz, float strength = 1) {
  TransitionRequest request;
  request.rate_hz = rate_hz;
  request.frames = static_cast<Eigen::Index>(rate_hz);
  const auto rows = static_cast<Eigen::Index>(std::lround(rate_hz / 6));
  request.past = AuMatrix::Zero(rows, 3);
  for (Eigen::Index row = 0; row < rows; ++row) {
    const auto t = static_cast<float>(static_cast<double>(row - rows + 1) / rate_hz);
    request.past(row, 0) = strength * (0.2F + 0.9F * t);
    request.past(row, 1) = strength * (0.2F + 0.5F * t);
  }
  request.target = strength * Eigen::Vector3f(0.6F, 0.5F, 0);
  return request;
}

TransitionFeatures features_of(const TransitionRequest& request) {
  TransitionFeatures features;
  TransitionFeatureMaker(kNames).make(request, features);
  return features;
}

TEST(TransitionFeatures, ThePastIsToldTwentyMillisecondsApartAtAnyRate) {
  const TransitionFeatures at_120 = features_of(request_of(120)), at_50 = features_of(request_of(50));
  EXPECT_LT((at_120.past - at_50.past).cwiseAbs().maxCoeff(), 1e-3F);
  // 0.9 per second, in units of the scale, and the other side beside it.
  const Eigen::Index before = (kTransitionPastSteps - 2) * kTransitionPastWidth;
  EXPECT_NEAR(at_120.past(0, before), -0.02F * 0.9F / at_120.scale(0), 1e-3F);
  EXPECT_NEAR(at_120.past(0, before + 1), -0.02F * 0.5F / at_120.scale(1), 1e-3F);
  EXPECT_EQ(at_120.past(0, before + kTransitionPastWidth), 0) << "the last row is where all begins";
}

TEST(TransitionFeatures, TheScaleFollowsTheWay) {
  const TransitionFeatures weak = features_of(request_of(120, 0.5F)), strong = features_of(request_of(120));
  EXPECT_NEAR(weak.scale(0) / strong.scale(0), 0.5F, 0.01F);
  EXPECT_GT(strong.scale(2), 0) << "of an AU that has no way, too";
}

TEST(TransitionFeatures, TheEnvelopeLeavesBothEndsAlone) {
  constexpr float kStep = 0.001F;
  for (const float end : {0.0F, 1.0F}) {
    const float inwards = end == 0 ? kStep : -kStep;
    EXPECT_EQ(transition_envelope(end), 0);
    EXPECT_NEAR(transition_envelope(end + inwards) / kStep, 0, 1e-3F);
    EXPECT_NEAR(transition_envelope(end + 2 * inwards) / (kStep * kStep), 0, 1);
  }
  EXPECT_EQ(transition_envelope(0.5F), 1);
}

TEST(TransitionFeatures, TheSplineOfEqualCoefficientsIsAConstant) {
  Eigen::VectorXf weights(kTransitionKnots);
  for (float u = 0; u <= 1; u += 0.01F) {
    transition_spline(u, weights);
    EXPECT_NEAR(weights.sum(), 1, 1e-5F) << u;
    EXPECT_GE(weights.minCoeff(), 0) << u;
  }
}

TEST(TransitionFeatures, RefusesWhatIsNoRequest) {
  const auto refused = [](auto change) {
    TransitionRequest request = request_of(120);
    change(request);
    EXPECT_THROW(features_of(request), std::invalid_argument);
  };
  refused([](TransitionRequest& r) { r.target.conservativeResize(2); });
  refused([](TransitionRequest& r) { r.past.resize(0, 3); });
  refused([](TransitionRequest& r) { r.past(3, 1) = std::numeric_limits<float>::quiet_NaN(); });
  refused([](TransitionRequest& r) { r.target(0) = std::numeric_limits<float>::infinity(); });
  refused([](TransitionRequest& r) { r.frames = 0; });
  refused([](TransitionRequest& r) { r.rate_hz = 0; });
}

}  // namespace
}  // namespace risorius
