#include "replay/performer/performer.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <map>
#include <memory>
#include <stdexcept>

#include "solve/faces/builtin_face.h"
#include "support/allocation_counter.h"

namespace {

using namespace risorius;

const Rig& rig() {
  static const Rig built = builtin_rig();
  return built;
}

PerformerOptions options_of(double seconds, std::uint64_t seed = 7) {
  PerformerOptions options;
  options.seed = seed;
  options.seconds = seconds;
  return options;
}

struct Frame {
  MarkerFrame observed, clean;
  AuFrame truth;
};

/// Calls visit(frame) for each frame of a performance.
template <class Visit>
void play(Performance& performance, Visit visit) {
  const auto frame = std::make_unique<Frame>();
  while (performance.next(frame->observed, frame->truth, frame->clean)) visit(*frame);
}

Eigen::Quaterniond rotation_of(const Pose& pose) {
  return {pose.rotation_xyzw[3], pose.rotation_xyzw[0], pose.rotation_xyzw[1], pose.rotation_xyzw[2]};
}

Eigen::Vector3d vector_of(const Position& p) { return {p.x, p.y, p.z}; }

/// Equal in every value that travels. (Padding bytes are not values.)
void expect_equal_bits(const Frame& a, const Frame& b) {
  ASSERT_EQ(a.observed.header.capture_time_ns, b.observed.header.capture_time_ns);
  ASSERT_EQ(a.observed.state, b.observed.state);
  ASSERT_EQ(a.clean.state, b.clean.state);
  ASSERT_EQ(a.clean.reason, b.clean.reason);
  ASSERT_EQ(a.observed.position_mm, b.observed.position_mm);
  ASSERT_EQ(a.clean.position_mm, b.clean.position_mm);
  ASSERT_EQ(a.truth.intensity, b.truth.intensity);
  ASSERT_EQ(a.truth.world_from_head.rotation_xyzw, b.truth.world_from_head.rotation_xyzw);
  ASSERT_EQ(a.truth.world_from_head.translation_mm, b.truth.world_from_head.translation_mm);
}

TEST(Performance, SameSeedGivesEqualBits) {
  Performance first(rig(), options_of(20)), second(rig(), options_of(20));
  const auto other = std::make_unique<Frame>();
  play(first, [&](const Frame& frame) {
    ASSERT_TRUE(second.next(other->observed, other->truth, other->clean));
    expect_equal_bits(frame, *other);
  });
}

TEST(Performance, RewindGivesEqualBits) {
  Performance performance(rig(), options_of(5));
  std::vector<Frame> frames;
  play(performance, [&](const Frame& frame) { frames.push_back(frame); });
  EXPECT_EQ(frames.size(), 600u);  // 5 s at 120 Hz
  performance.rewind();
  std::size_t i = 0;
  play(performance, [&](const Frame& frame) { expect_equal_bits(frame, frames[i++]); });
  EXPECT_EQ(i, frames.size());
}

TEST(Performance, OtherSeedGivesAnotherPerformance) {
  Performance first(rig(), options_of(10, 1)), second(rig(), options_of(10, 2));
  const auto other = std::make_unique<Frame>();
  double difference = 0;
  play(first, [&](const Frame& frame) {
    second.next(other->observed, other->truth, other->clean);
    for (std::size_t k = 0; k < rig().au_count(); ++k)
      difference += std::abs(frame.truth.intensity[k] - other->truth.intensity[k]);
  });
  EXPECT_GT(difference / 1200, 0.2);  // summed over AUs, mean over 10 s at 120 Hz
}

TEST(Performance, TruthDoesNotDependOnDefects) {
  PerformerOptions bad = options_of(10);
  bad.noise_mm = 2;
  bad.occlusion_share = 0.3;
  bad.false_track_share = 0.1;
  Performance spoiled(rig(), bad), standard(rig(), options_of(10));
  const auto other = std::make_unique<Frame>();
  play(standard, [&](const Frame& frame) {
    ASSERT_TRUE(spoiled.next(other->observed, other->truth, other->clean));
    ASSERT_EQ(frame.truth.intensity, other->truth.intensity);
    ASSERT_EQ(frame.clean.position_mm, other->clean.position_mm);
  });
}

TEST(Performance, CleanMarkersAreTheRigUnderTheTruth) {
  Performance performance(rig(), options_of(10));
  play(performance, [&](const Frame& frame) {
    const Pose& pose = frame.truth.world_from_head;
    const Eigen::Map<const Eigen::Vector3d> translation(pose.translation_mm.data());
    for (std::size_t m = 0; m < rig().marker_count(); ++m) {
      const auto column = static_cast<Eigen::Index>(m);
      Eigen::Vector3d head_mm = rig().neutral_mm.col(column);
      for (std::size_t k = 0; k < rig().au_count(); ++k)
        head_mm += frame.truth.intensity[k] * rig().aus[k].displacement_mm.col(column);
      const Eigen::Vector3d world_mm = rotation_of(pose) * head_mm + translation;
      ASSERT_LT((vector_of(frame.clean.position_mm[m]) - world_mm).norm(), 1e-3);
    }
  });
}

TEST(Performance, ObservedDiffersFromCleanOnlyAsTheStatesSay) {
  PerformerOptions options = options_of(30);
  options.noise_mm = 0;
  Performance performance(rig(), options);
  std::map<RejectReason, int> false_samples;
  play(performance, [&](const Frame& frame) {
    for (std::size_t m = 0; m < rig().marker_count(); ++m) {
      const double error_mm = (vector_of(frame.observed.position_mm[m]) - vector_of(frame.clean.position_mm[m])).norm();
      switch (frame.clean.state[m]) {
        case MarkerState::kMeasured:
          ASSERT_EQ(frame.observed.state[m], MarkerState::kMeasured);
          ASSERT_EQ(error_mm, 0);
          break;
        case MarkerState::kMissing:
          ASSERT_EQ(frame.observed.state[m], MarkerState::kMissing);
          ASSERT_EQ(frame.observed.position_mm[m], Position{});
          break;
        case MarkerState::kRejected:
          ASSERT_EQ(frame.observed.state[m], MarkerState::kMeasured);  // a tracker does not know better
          ASSERT_GT(error_mm, 1);
          ++false_samples[frame.clean.reason[m]];
          break;
        case MarkerState::kFilled:
          FAIL() << "nobody fills here";
      }
    }
  });
  EXPECT_GT(false_samples[RejectReason::kJump], 50);
  EXPECT_GT(false_samples[RejectReason::kGhost], 50);
  EXPECT_GT(false_samples[RejectReason::kSwap], 50);
  EXPECT_EQ(false_samples.size(), 3u);
}

TEST(Performance, APerturbedFaceIsNotTheRigAndLeavesItsTruthAlone) {
  PerformerOptions options = options_of(5);
  options.noise_mm = options.occlusion_share = options.false_track_share = 0;
  PerformerOptions perturbed = options;
  perturbed.perturb = PerturbOptions::like_people();
  Performance plain(rig(), options), other(rig(), perturbed);
  const auto frame = std::make_unique<Frame>();
  double squares = 0, count = 0;
  play(plain, [&](const Frame& one) {
    ASSERT_TRUE(other.next(frame->observed, frame->truth, frame->clean));
    ASSERT_EQ(one.truth.intensity, frame->truth.intensity);
    for (std::size_t m = 0; m < rig().marker_count(); ++m) {
      squares += (vector_of(one.clean.position_mm[m]) - vector_of(frame->clean.position_mm[m])).squaredNorm();
      ++count;
    }
  });
  // 4 mm of identity and 2 mm per axis of placement: 5.3 mm.
  EXPECT_NEAR(std::sqrt(squares / count), 5.3, 1);
  EXPECT_EQ(other.rig().neutral_mm, rig().neutral_mm);
  EXPECT_NE(other.true_rig().neutral_mm, rig().neutral_mm);
}

TEST(Performance, ARecordedSeriesDrivesTheRigByName) {
  AuSeries series{{"AU12R", "AU12L", "AU27", "AU99"}, {}, {}};
  for (std::uint64_t f = 0; f <= 30; ++f) {
    series.frames.push_back(f);
    series.intensities.push_back({0.2, 0.01 * static_cast<double>(f), 5, 1});
  }
  PerformerOptions options = options_of(0);
  Performance performance(rig(), AuTimeline(series, 30, rig().au_names()), options);
  const auto names = rig().au_names();
  const auto at = [&](const char* name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  std::size_t frames = 0;
  play(performance, [&](const Frame& frame) {
    const double time_s = static_cast<double>(frames++) / 120;
    EXPECT_NEAR(frame.truth.intensity[at("AU12R")], 0.2, 1e-12);
    EXPECT_NEAR(frame.truth.intensity[at("AU12L")], 0.3 * time_s, 2e-3);  // at rest at both ends
    EXPECT_EQ(frame.truth.intensity[at("AU27")], rig().aus[at("AU27")].upper_bound);
    EXPECT_EQ(frame.truth.intensity[at("AU45L")], 0) << "a series is the whole truth: nothing blinks over it";
  });
  EXPECT_EQ(frames, 121u);
  EXPECT_EQ(performance.script(), nullptr);
}

TEST(Performance, DefectSharesAreNearWhatWasAsked) {
  for (const double share : {0.01, 0.03, 0.2}) {
    PerformerOptions options = options_of(120);
    options.occlusion_share = share;
    options.false_track_share = 0.01;
    Performance performance(rig(), options);
    double samples = 0, missing = 0, rejected = 0;
    play(performance, [&](const Frame& frame) {
      for (std::size_t m = 0; m < rig().marker_count(); ++m) {
        ++samples;
        missing += frame.clean.state[m] == MarkerState::kMissing;
        rejected += frame.clean.state[m] == MarkerState::kRejected;
      }
    });
    // About 350 gaps at 1 %, whose lengths vary by their mean: 4 standard deviations are 0.3 of the share.
    EXPECT_NEAR(missing / samples, share, 0.3 * share);
    EXPECT_NEAR(rejected / (samples - missing), 0.01, 0.002);
  }
}

TEST(Performance, GapsAreManyShortAndFewLong) {
  PerformerOptions options = options_of(120);
  options.occlusion_share = 0.1;
  Performance performance(rig(), options);
  std::vector<int> running(rig().marker_count(), 0);
  std::vector<int> gaps;
  play(performance, [&](const Frame& frame) {
    for (std::size_t m = 0; m < rig().marker_count(); ++m) {
      if (frame.clean.state[m] == MarkerState::kMissing) {
        ++running[m];
      } else if (running[m] > 0) {
        gaps.push_back(std::exchange(running[m], 0));
      }
    }
  });
  ASSERT_GT(gaps.size(), 1000u);
  std::sort(gaps.begin(), gaps.end());
  // Log-normal, median 0.12 s = 14.4 frames at 120 Hz, sigma 0.9; the longest 2 s = 240 frames.
  EXPECT_NEAR(gaps[gaps.size() / 2], 14.4, 2);
  EXPECT_NEAR(gaps[gaps.size() * 9 / 10], 14.4 * std::exp(1.2816 * 0.9), 8);
  EXPECT_LE(gaps.back(), 240);
}

TEST(Performance, NoiseHasTheAskedDeviation) {
  PerformerOptions options = options_of(20);
  options.noise_mm = 0.5;
  Performance performance(rig(), options);
  double squares = 0, count = 0;
  play(performance, [&](const Frame& frame) {
    for (std::size_t m = 0; m < rig().marker_count(); ++m) {
      if (frame.clean.state[m] != MarkerState::kMeasured) continue;
      squares += (vector_of(frame.observed.position_mm[m]) - vector_of(frame.clean.position_mm[m])).squaredNorm();
      count += 3;
    }
  });
  EXPECT_NEAR(std::sqrt(squares / count), 0.5, 0.01);  // 390,000 draws: the deviation is known to 0.1 %
}

TEST(Performance, IntensitiesAreSmoothBoundedAndEveryAuMoves) {
  PerformerOptions options = options_of(300);
  Performance performance(rig(), options);
  std::vector<double> last(rig().au_count(), 0), largest(rig().au_count(), 0);
  double largest_step = 0;
  play(performance, [&](const Frame& frame) {
    for (std::size_t k = 0; k < rig().au_count(); ++k) {
      const double x = frame.truth.intensity[k];
      ASSERT_GE(x, 0);
      ASSERT_LE(x, rig().aus[k].upper_bound);
      largest_step = std::max(largest_step, std::abs(x - last[k]));
      largest[k] = std::max(largest[k], x);
      last[k] = x;
    }
  });
  // The fastest action is the blink: minimum jerk over 0.07 s peaks at 1.875 / 0.07 per second, 0.22 per frame at 120
  // Hz; micro-motion adds a little.
  EXPECT_LT(largest_step, 0.24);
  // Nobody moves the jaw sideways when speaking or feeling: there it only wanders. Range of motion shows every AU.
  for (std::size_t k = 0; k < rig().au_count(); ++k) EXPECT_GT(largest[k], 0.1) << rig().aus[k].name;
}

TEST(Performance, RangeOfMotionShowsEveryAu) {
  PerformerOptions options = options_of(0);
  options.script = ScriptKind::kRom;
  options.micro_motion = 0;  // what moves, moves because the list says so; how far is drawn
  Performance performance(rig(), options);
  std::vector<double> largest(rig().au_count(), 0);
  play(performance, [&](const Frame& frame) {
    for (std::size_t k = 0; k < rig().au_count(); ++k) largest[k] = std::max(largest[k], frame.truth.intensity[k]);
  });
  for (std::size_t k = 0; k < rig().au_count(); ++k) EXPECT_GT(largest[k], 0.1) << rig().aus[k].name;
}

TEST(Performance, HeadSwaysByMillimetresAndDegrees) {
  PerformerOptions options = options_of(60);
  Performance performance(rig(), options);
  double largest_angle = 0;
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e9), high = -low;
  play(performance, [&](const Frame& frame) {
    const Eigen::Map<const Eigen::Vector3d> t(frame.truth.world_from_head.translation_mm.data());
    low = low.cwiseMin(t);
    high = high.cwiseMax(t);
    largest_angle = std::max(largest_angle,
                             rotation_of(frame.truth.world_from_head).angularDistance(Eigen::Quaterniond::Identity()));
  });
  EXPECT_GT((high - low).minCoeff(), 4);
  EXPECT_LE((high - low).maxCoeff(), 16);  // +-8 mm
  EXPECT_GT(largest_angle * 180 / 3.14159265, 3);
  EXPECT_LT(largest_angle * 180 / 3.14159265, 8);  // 5, 5 and 3 degrees at once: 7.7
}

TEST(Performance, StillHeadAndPerfectTrackerAreAnOption) {
  PerformerOptions options = options_of(5);
  options.noise_mm = options.occlusion_share = options.false_track_share = options.head_motion = 0;
  Performance performance(rig(), options);
  play(performance, [&](const Frame& frame) {
    ASSERT_EQ(frame.observed.position_mm, frame.clean.position_mm);
    ASSERT_EQ(frame.truth.world_from_head.rotation_xyzw, (std::array<double, 4>{0, 0, 0, 1}));
  });
}

TEST(Performance, NextAllocatesNothing) {
  Performance performance(rig(), options_of(10));
  const auto frame = std::make_unique<Frame>();
  const auto before = test::allocations_of_this_thread();
  while (performance.next(frame->observed, frame->truth, frame->clean)) {
  }
  EXPECT_EQ(test::allocations_of_this_thread(), before);
}

TEST(Performance, RefusesOptionsAndRigsOutOfRange) {
  const auto refuses = [](auto change) {
    PerformerOptions options;
    change(options);
    EXPECT_THROW(Performance(rig(), options), std::invalid_argument);
  };
  refuses([](PerformerOptions& o) { o.rate_hz = 0; });
  refuses([](PerformerOptions& o) { o.rate_hz = std::nan(""); });
  refuses([](PerformerOptions& o) { o.seconds = -1; });
  refuses([](PerformerOptions& o) { o.noise_mm = -0.1; });
  refuses([](PerformerOptions& o) { o.occlusion_share = 0.6; });
  refuses([](PerformerOptions& o) { o.false_track_share = 1; });
  refuses([](PerformerOptions& o) { o.head_motion = 4; });
  refuses([](PerformerOptions& o) { o.seconds = 0; });  // only lists end by themselves
  refuses([](PerformerOptions& o) { o.regions_per_minute = 61; });
  refuses([](PerformerOptions& o) { o.perturb.basis_share = 1; });
  EXPECT_THROW(Performance(Rig{}), std::invalid_argument);
  Rig broken = rig();
  broken.aus[0].displacement_mm.resize(3, 2);
  EXPECT_THROW(Performance{broken}, std::invalid_argument);
}

TEST(PerformerTake, StreamsLikeAFile) {
  PerformerOptions options = options_of(2);
  options.rate_hz = 60;
  PerformerTake take(rig(), options);
  EXPECT_EQ(take.info().path, "builtin");
  EXPECT_EQ(take.info().markers.names, rig().marker_names);
  EXPECT_EQ(take.info().markers.rate_hz, 60);
  EXPECT_EQ(take.info().frame_count, 120u);
  MarkerFrame frame;
  std::uint64_t count = 0;
  while (take.next(frame)) {
    EXPECT_EQ(frame.header.sequence, count);
    EXPECT_EQ(frame.header.capture_time_ns, std::llround(1e9 * static_cast<double>(count) / 60));
    EXPECT_EQ(take.truth().header.sequence, count++);
  }
  EXPECT_EQ(count, 120u);
  take.rewind();
  EXPECT_TRUE(take.next(frame));
  EXPECT_EQ(frame.header.sequence, 0u);
}

}  // namespace
