#include "generate/expression_generator.h"

#include <cmath>
#include <gtest/gtest.h>
#include <stdexcept>

#include "capture/errors.h"
#include "generate/au_kind.h"
#include "generate/transition_features.h"
#include "made_weights.h"

namespace risorius {
namespace {

const std::vector<std::string> kNames{"AU1", "AU12L", "AU12R", "AU27", "AU45L", "mouthLeft"};

/// Untrained weights: what holds for them holds whatever was learnt.
void add_member(Safetensors& file, const std::string& name, float reach) {
  test::add_lstm(file, name + "encoder", 8, kTransitionPastWidth, reach);
  test::add_dense(file, name + "state", 2 * 16, 8 + kTransitionFixedWidth, reach);
  test::add_lstm(file, name + "decoder", 16, kTransitionFixedWidth + kTransitionStepWidth + 4, reach);
  test::add_dense(file, name + "output", 1, 16, reach);
}
Safetensors wild_weights(float reach = 0.6F) {
  Safetensors file;
  file.metadata["model"] = "expression_generator";
  add_member(file, "member_0.", reach);
  add_member(file, "member_1.", reach);
  test::add_dense(file, "duration_hidden", 16, kTransitionWholeWidth, reach);
  test::add_dense(file, "duration", 1, 16, reach);
  return file;
}

/// A face that moves with constant velocities and is to stop elsewhere.
TransitionRequest request_of(Eigen::Index frames, float speed_per_s = 0.5F) {
  TransitionRequest request;
  request.rate_hz = 120;
  request.frames = frames;
  request.past.resize(20, static_cast<Eigen::Index>(kNames.size()));
  for (Eigen::Index row = 0; row < 20; ++row) {
    for (Eigen::Index k = 0; k < request.past.cols(); ++k)
      request.past(row, k) = 0.3F + 0.05F * static_cast<float>(k) + speed_per_s * static_cast<float>(row - 19) / 120;
  }
  request.target.resize(request.past.cols());
  request.target << 0.9F, 0, 0.1F, 0.6F, 0.5F, 0.55F;
  return request;
}

TEST(ExpressionGenerator, LeavesWithThePastsVelocityAndArrivesAtTheTargetAtRest) {
  ExpressionGenerator generator(wild_weights(), "test", kNames);
  const TransitionRequest request = request_of(120);
  AuMatrix result;
  generator.generate(request, result);
  ASSERT_EQ(result.rows(), 120);
  for (Eigen::Index k = 0; k < result.cols(); ++k) {
    const float start = request.past(19, k);
    // 0.5 per second for a frame; accelerations of the residual and of minimum jerk begin at 0.
    EXPECT_NEAR(result(0, k) - start, 0.5F / 120, 3e-4F) << k;
    EXPECT_NEAR(result(1, k) - 2 * result(0, k) + start, 0, 4e-4F) << k;
    EXPECT_EQ(result(119, k), request.target(k));
    EXPECT_NEAR(result(118, k), request.target(k), 2e-3F);
  }
}

TEST(ExpressionGenerator, StaysWithinBoundsWhateverTheWeights) {
  ExpressionGenerator generator(wild_weights(20), "test", kNames);
  AuMatrix result;
  for (const Eigen::Index frames : {1, 2, 5, 41, 402}) {
    generator.generate(request_of(frames, 3), result);
    ASSERT_EQ(result.rows(), frames);
    EXPECT_GE(result.minCoeff(), 0);
    EXPECT_LE(result.maxCoeff(), 1.2F);
    EXPECT_EQ(result.row(frames - 1), request_of(1).target.transpose());
  }
}

TEST(ExpressionGenerator, IsContinuousInsideTheWay) {
  ExpressionGenerator generator(wild_weights(), "test", kNames);
  AuMatrix slow, fast;
  TransitionRequest request = request_of(240);
  generator.generate(request, slow);
  const AuMatrix steps = slow.bottomRows(239) - slow.topRows(239);
  EXPECT_LT((steps.bottomRows(238) - steps.topRows(238)).cwiseAbs().maxCoeff(), 0.01F) << "no kink between knots";
}

TEST(ExpressionGenerator, TheSameRequestGivesTheSameBitsAndRepetitionsDiffer) {
  ExpressionGenerator a(wild_weights(), "test", kNames), b(wild_weights(), "test", kNames);
  AuMatrix first, second, third;
  TransitionRequest request = request_of(100);
  a.generate(request_of(77), first);  // leaves nothing behind
  a.generate(request, first);
  b.generate(request, second);
  EXPECT_EQ(first, second);
  request.repetition = 1;
  a.generate(request, second);
  a.generate(request, third);
  EXPECT_EQ(second, third);
  EXPECT_NE(first, second);
  request.repetition = 2;
  a.generate(request, third);
  EXPECT_NE(second, third);
}

TEST(ExpressionGenerator, TheExpectedCourseIsTheMeanOfItsMembers) {
  const Safetensors both = wild_weights();
  const auto only = [&](const std::string& kept) {
    Safetensors file = both;
    std::erase_if(file.tensors, [](const auto& item) { return item.first.starts_with("member_"); });
    for (const auto& [name, tensor] : both.tensors)
      if (name.starts_with(kept)) file.tensors["member_0." + name.substr(kept.size())] = tensor;
    return file;
  };
  // A short way from values well inside the bounds, so that nothing is cut.
  TransitionRequest request = request_of(100, 0);
  request.target = request.past.row(19).transpose().array() + 0.02F;
  AuMatrix mean, first, second;
  ExpressionGenerator(both, "test", kNames).generate(request, mean);
  ExpressionGenerator(only("member_0."), "test", kNames).generate(request, first);
  ExpressionGenerator(only("member_1."), "test", kNames).generate(request, second);
  EXPECT_GT((first - second).cwiseAbs().maxCoeff(), 1e-3F);
  EXPECT_LT((mean - 0.5F * (first + second)).cwiseAbs().maxCoeff(), 1e-6F);
}

TEST(ExpressionGenerator, OneRowOfPastSuffices) {
  ExpressionGenerator generator(wild_weights(), "test", kNames);
  TransitionRequest request = request_of(60);
  request.past = request.past.bottomRows(1).eval();
  AuMatrix result;
  generator.generate(request, result);
  for (Eigen::Index k = 0; k < result.cols(); ++k) EXPECT_NEAR(result(0, k), request.past(0, k), 1e-3F);
  const Eigen::Index frames = generator.expected_frames(request);
  EXPECT_GE(frames, 41);
  EXPECT_LE(frames, 402);
}

TEST(ExpressionGenerator, ExpectsTheSameSecondsAtAnyRateAndWhateverIsAskedFor) {
  ExpressionGenerator generator(wild_weights(), "test", kNames);
  TransitionRequest request = request_of(1, 0);
  const Eigen::Index at_120 = generator.expected_frames(request);
  request.frames = 400;
  EXPECT_EQ(generator.expected_frames(request), at_120);
  request.rate_hz = 60;
  EXPECT_NEAR(static_cast<double>(generator.expected_frames(request)), static_cast<double>(at_120) / 2, 1);
  request.past(19, 0) = std::nanf("");
  EXPECT_THROW(generator.expected_frames(request), std::invalid_argument);
}

TEST(ExpressionGenerator, GivesTheSameCourseAtAnyRate) {
  ExpressionGenerator generator(wild_weights(), "test", kNames);
  TransitionRequest request = request_of(120, 0);
  AuMatrix at_120, at_60;
  generator.generate(request, at_120);
  request.rate_hz = 60;
  request.frames = 60;
  generator.generate(request, at_60);
  for (Eigen::Index frame = 0; frame < 60; ++frame)
    EXPECT_LT((at_60.row(frame) - at_120.row(2 * frame + 1)).cwiseAbs().maxCoeff(), 1e-4F) << frame;
}

TEST(ExpressionGenerator, MirroredFacesGetMirroredCourses) {
  ExpressionGenerator generator(wild_weights(), "test", kNames);
  TransitionRequest request = request_of(90), mirrored = request;
  mirrored.past.col(1).swap(mirrored.past.col(2));
  std::swap(mirrored.target(1), mirrored.target(2));
  AuMatrix result, other;
  generator.generate(request, result);
  generator.generate(mirrored, other);
  // But for the order in which the ways of all AUs are added up.
  EXPECT_LT((result.col(1) - other.col(2)).cwiseAbs().maxCoeff(), 1e-5F);
  EXPECT_LT((result.col(2) - other.col(1)).cwiseAbs().maxCoeff(), 1e-5F);
}

TEST(ExpressionGenerator, RefusesWhatDoesNotFit) {
  ExpressionGenerator generator(wild_weights(), "test", kNames);
  AuMatrix result;
  for (const int wrong : {0, 1, 2, 3, 4, 5}) {
    TransitionRequest request = request_of(60);
    if (wrong == 0) request.frames = 0;
    if (wrong == 1) request.rate_hz = 0;
    if (wrong == 2) request.target.conservativeResize(3);
    if (wrong == 3) request.past.resize(0, request.past.cols());
    if (wrong == 4) request.past(3, 3) = std::nanf("");
    if (wrong == 5) request.target(0) = INFINITY;
    EXPECT_THROW(generator.generate(request, result), std::invalid_argument) << wrong;
  }
  Safetensors other = wild_weights();
  other.metadata["model"] = "continuation";
  EXPECT_THROW(ExpressionGenerator(other, "test", kNames), UserError);
  other = wild_weights();
  other.tensors.erase("member_0.output.bias");
  EXPECT_THROW(ExpressionGenerator(other, "test", kNames), UserError);
  other = wild_weights();
  test::add_tensor(other, "member_1.state.weight", {3, 3}, 1);
  EXPECT_THROW(ExpressionGenerator(other, "test", kNames), UserError);
}

TEST(AuKind, KnowsTheFaceByName) {
  EXPECT_EQ(kind_of_au("AU1"), AuKind::kBrow);
  EXPECT_EQ(kind_of_au("AU45L"), AuKind::kLid);
  EXPECT_EQ(kind_of_au("AU12R"), AuKind::kMouth);
  EXPECT_EQ(kind_of_au("AU27"), AuKind::kJaw);
  EXPECT_EQ(kind_of_au("mouthLeft"), AuKind::kMouth);
  EXPECT_EQ(kind_of_au("AU12X"), AuKind::kOther);
  EXPECT_EQ(kind_of_au(""), AuKind::kOther);
  EXPECT_EQ(other_sides({"AU12L", "AU27", "AU12R", "mouthLeft", "mouthRight", "AU30L", ""}),
            (std::vector<std::size_t>{2, 1, 0, 4, 3, 5, 6}));
}

}  // namespace
}  // namespace risorius
