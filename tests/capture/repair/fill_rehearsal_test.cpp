#include "capture/repair/fill_rehearsal.h"

#include <gtest/gtest.h>
#include <numeric>
#include <random>

#include "capture/repair/gap_filler.h"
#include "support/allocation_counter.h"
#include "support/synthetic_take.h"
#include "support/test_data.h"

namespace risorius {
namespace {

constexpr std::size_t kMarkers = 24;
constexpr double kStepS = 1.0 / 60;

std::vector<int> newcomers(std::size_t count) { return std::vector<int>(count, -1); }

/// A face that moves as one for so many frames, and in which then each marker trembles by itself for so many.
FillRehearsal rehearsed(int together, int alone) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(0, 0.5);
  FillModel live;
  live.remap(newcomers(kMarkers));
  FillRehearsal rehearsal;
  rehearsal.remap(newcomers(kMarkers));
  const std::vector<std::uint8_t> measured(kMarkers, 1);
  std::vector<Eigen::Vector3d> position(kMarkers);
  Eigen::Vector3d common = Eigen::Vector3d::Zero();
  for (int f = 0; f < together + alone; ++f) {
    common = 0.8 * common + Eigen::Vector3d(normal(random), normal(random), normal(random));
    for (std::size_t i = 0; i < kMarkers; ++i) {
      const auto place = static_cast<double>(i);
      position[i] = Eigen::Vector3d(20 * (place - 12), 10 * std::sin(place), 5 * std::cos(3 * place));
      position[i] += f < together ? common : Eigen::Vector3d(normal(random), normal(random), normal(random));
    }
    live.observe(position, measured, kStepS);
    live.learn(measured, kStepS, true);
    rehearsal.take(position, measured);
    rehearsal.practise(live, kStepS, true);
  }
  return rehearsal;
}

/// Which share of a move of so many believed deviations a rehearsal lets the model have.
double share_of_move(const FillRehearsal& rehearsal, double deviations, double gap_s) {
  const double variance = 0.25;
  // 1.2 + 7 t^0.8 of the stated variance is what is believed at first (fill_rehearsal.cpp).
  const double believed = variance * (1.2 + 7 * std::pow(gap_s, 0.8));
  const Eigen::Vector3d moved = Eigen::Vector3d::Constant(deviations * std::sqrt(believed));
  return rehearsal.weigh(0, {moved, variance}, Eigen::Vector3d::Zero(), gap_s).position_head_mm.x() / moved.x();
}

TEST(FillRehearsal, BelievesTheModelBeforeItHasRehearsed) {
  FillRehearsal rehearsal;
  rehearsal.remap(newcomers(kMarkers));
  for (const double gap_s : {0.017, 0.1, 0.5, 2.0, 30.0}) {
    EXPECT_NEAR(share_of_move(rehearsal, 1, gap_s), 1, 1e-9) << gap_s;
    const MarkerFill fill = rehearsal.weigh(0, {Eigen::Vector3d::Ones(), 0.25}, Eigen::Vector3d::Zero(), gap_s);
    const double believed = 0.25 * (1.2 + 7 * std::pow(gap_s, 0.8));
    EXPECT_NEAR(fill.variance_mm2 / believed, 1, 0.1) << gap_s;  // to the width of a bin
  }
}

TEST(FillRehearsal, LearnsToStayWhereWhatTheOthersSayIsNoise) {
  const FillRehearsal together = rehearsed(3600, 0);
  const FillRehearsal alone = rehearsed(600, 3000);
  EXPECT_GT(share_of_move(together, 0.5, 0.1), 0.9);
  EXPECT_LT(share_of_move(alone, 0.5, 0.1), share_of_move(together, 0.5, 0.1) - 0.1);
  // What it has not seen, a great move, it goes on believing.
  EXPECT_GT(share_of_move(alone, 10, 0.1), 0.9);
}

TEST(FillRehearsal, ForgetsWithReset) {
  FillRehearsal rehearsal = rehearsed(300, 900);
  ASSERT_LT(share_of_move(rehearsal, 0.5, 0.1), 0.95);
  rehearsal.reset();
  EXPECT_NEAR(share_of_move(rehearsal, 0.5, 0.1), 1, 1e-9);
}

TEST(FillRehearsal, WorksWithFewMarkersAndWithNone) {
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{3}, std::size_t{7}}) {
    FillModel live;
    live.remap(newcomers(count));
    FillRehearsal rehearsal;
    rehearsal.remap(newcomers(count));
    const std::vector<Eigen::Vector3d> position(count, Eigen::Vector3d::Ones());
    const std::vector<std::uint8_t> measured(count, 1);
    for (int f = 0; f < 300; ++f) {
      rehearsal.take(position, measured);
      rehearsal.practise(live, kStepS, true);
    }
    if (count == 0) continue;
    const MarkerFill fill = rehearsal.weigh(0, {Eigen::Vector3d::Ones(), 0.25}, Eigen::Vector3d::Ones(), 0.1);
    EXPECT_TRUE(fill.position_head_mm.allFinite());
  }
}

/// Root mean square of the errors against the truth, in stated deviations, on a face that nothing was set on.
double error_in_deviations(double noise_mm) {
  const test::SyntheticOptions options{.markers = 40, .frames = 2400, .noise_mm = noise_mm, .seed = 5};
  auto without_noise = options;
  without_noise.noise_mm = 0;
  test::MarkerTake take = test::synthetic_take(options);
  const test::MarkerTake truth = test::synthetic_take(without_noise);
  constexpr std::size_t kGap = 45;
  std::vector<std::pair<std::size_t, std::size_t>> gaps;
  for (std::size_t begin = 900; begin + kGap < 2400; begin += 80) gaps.emplace_back(begin / 80 * 7 % 40, begin);
  for (const auto& [marker, begin] : gaps) test::hide(take, marker, begin, kGap);
  GapFiller filler;
  filler.use_marker_set(take.set);
  const auto filled = test::run_stage(filler, take.frames);
  double squared = 0, axes = 0;
  for (const auto& [marker, begin] : gaps) {
    for (std::size_t f = begin; f < begin + kGap; ++f) {
      const Eigen::Vector3d error =
          test::vector_of(filled[f].position_mm[marker]) - test::vector_of(truth.frames[f].position_mm[marker]);
      const double deviation = filled[f].standard_deviation_mm[marker];
      squared += error.squaredNorm() / (deviation * deviation);
      axes += 3;
    }
  }
  return std::sqrt(squared / axes);
}

/// The belief alone states two and a half times too much here (0.40).
TEST(FillRehearsal, MakesTheStatedDeviationHonest) {
  const double error = error_in_deviations(0.02);
  EXPECT_GT(error, 0.45);
  EXPECT_LT(error, 1.3);
}

TEST(FillRehearsal, AllocatesNothingPerFrame) {
  FillModel live;
  live.remap(newcomers(kMarkers));
  FillRehearsal rehearsal;
  rehearsal.remap(newcomers(kMarkers));
  std::vector<Eigen::Vector3d> position(kMarkers, Eigen::Vector3d::Ones());
  const std::vector<std::uint8_t> measured(kMarkers, 1);
  const std::uint64_t before = test::allocations_of_this_thread();
  for (int f = 0; f < 400; ++f) {
    position[static_cast<std::size_t>(f) % kMarkers].x() += 0.1;
    rehearsal.take(position, measured);
    rehearsal.practise(live, kStepS, true);
  }
  EXPECT_EQ(test::allocations_of_this_thread(), before);
}

}  // namespace
}  // namespace risorius
