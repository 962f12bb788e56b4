#include "solve/au_solver.h"

#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <stdexcept>

#include "capture/errors.h"
#include "solve/faces/builtin_face.h"
#include "support/allocation_counter.h"
#include "synthetic_face.h"

namespace risorius {
namespace {

using test::add_noise;
using test::marker_frame;
using test::marker_set_of;
using test::smooth_intensities;
using test::synthetic_rig;

constexpr int kMarkers = 55, kAus = 15, kStabilisers = 6;
constexpr double kNoise_mm = 0.2;  // EVALUATION section 2

RigidTransform some_pose(int frame) {
  RigidTransform pose;
  pose.rotation = Eigen::AngleAxisd(0.3 * std::sin(0.1 * frame), Eigen::Vector3d(1, 2, -1).normalized());
  pose.translation = {10 * std::sin(0.07 * frame), 5, -20 * std::cos(0.05 * frame)};
  return pose;
}

class Bench {
 public:
  explicit Bench(const AuSolverOptions& options = {}, Rig rig = synthetic_rig(kMarkers, kAus))
      : rig_(std::move(rig)), solver_(rig_, options) {
    solver_.use_marker_set(marker_set_of(rig_));
  }
  const Rig& rig() const { return rig_; }
  AuSolver& solver() { return solver_; }
  AuFrame solve(const MarkerFrame& frame) {
    AuFrame out;
    EXPECT_TRUE(solver_.push(frame));
    EXPECT_TRUE(solver_.pop(out));
    return out;
  }

 private:
  Rig rig_;
  AuSolver solver_;
};

MarkerFrame noisy_frame(const Rig& rig, int frame) {
  MarkerFrame result = marker_frame(rig, smooth_intensities(static_cast<int>(rig.au_count()), frame / 60.0),
                                    some_pose(frame), static_cast<std::uint64_t>(frame));
  add_noise(result, kNoise_mm, static_cast<unsigned>(frame));
  return result;
}

void expect_finite_and_bounded(const Rig& rig, const AuFrame& frame) {
  EXPECT_TRUE(std::isfinite(frame.residual_rms_mm) && std::isfinite(frame.kkt_residual));
  for (const double q : frame.world_from_head.rotation_xyzw) EXPECT_TRUE(std::isfinite(q));
  for (const double t : frame.world_from_head.translation_mm) EXPECT_TRUE(std::isfinite(t));
  for (std::size_t i = 0; i < rig.au_count(); ++i) {
    EXPECT_GE(frame.intensity[i], 0);
    EXPECT_LE(frame.intensity[i], rig.aus[i].upper_bound);
    EXPECT_GT(frame.standard_deviation[i], 0);
    EXPECT_LE(frame.standard_deviation[i], rig.aus[i].upper_bound);
  }
}

TEST(AuSolver, RecoversKnownIntensitiesWithoutNoise) {
  Bench bench({.ridge = 1e-9, .temporal = 0, .l1 = 0});
  for (int f = 0; f < 60; ++f) {
    const Eigen::VectorXd x = smooth_intensities(kAus, f / 60.0);
    const AuFrame out = bench.solve(marker_frame(bench.rig(), x, some_pose(f), static_cast<std::uint64_t>(f)));
    EXPECT_EQ(out.status, SolverStatus::kConverged);
    EXPECT_LE(out.kkt_residual, 1e-9);
    // Positions are rounded to float: 4e-6 mm at 100 mm, over displacements of about 10 mm, times the basis's
    // condition.
    EXPECT_LT(out.residual_rms_mm, 2e-5);
    for (int i = 0; i < kAus; ++i) EXPECT_NEAR(out.intensity[i], x[i], 1e-5) << "frame " << f << " AU " << i;
  }
}

TEST(AuSolver, KktResidualStaysBelowItsBarOnNoisyFramesOfEverySize) {
  for (const auto& [markers, aus] : {std::pair{16, 8}, {55, 15}, {55, 52}, {165, 52}, {256, 64}}) {
    Bench bench({.temporal = 0.01, .l1 = 5, .left_right = 0.01}, synthetic_rig(markers, aus));
    for (int f = 0; f < 40; ++f) {
      const AuFrame out = bench.solve(noisy_frame(bench.rig(), f));
      EXPECT_EQ(out.status, SolverStatus::kConverged);
      EXPECT_LE(out.kkt_residual, 1e-9) << markers << "x" << aus << " frame " << f;
      expect_finite_and_bounded(bench.rig(), out);
    }
  }
}

/// Equation (2) of solve/README.md, written out.
double objective(const Rig& rig, const AuSolverOptions& o, const MarkerFrame& frame, const AuFrame& out,
                 const Eigen::VectorXd& weight, double variance_mm2, const Eigen::VectorXd& previous,
                 const Eigen::VectorXd& x) {
  RigidTransform world_from_head;
  world_from_head.rotation = Eigen::Quaterniond(out.world_from_head.rotation_xyzw.data());
  world_from_head.translation = Eigen::Vector3d(out.world_from_head.translation_mm.data());
  double sum = 0, unit = 0;
  for (int m = 0; m < kMarkers; ++m) {
    const Position& p = frame.position_mm[m];
    Eigen::Vector3d rest = rig.neutral_mm.col(m) - world_from_head.inverse() * Eigen::Vector3d(p.x, p.y, p.z);
    for (int i = 0; i < kAus; ++i) rest += x[i] * rig.aus[i].displacement_mm.col(m);
    sum += weight[m] * (1 + 5 * rig.stabiliser_weight[m]) / 2 * rest.squaredNorm();
  }
  for (const RigAu& au : rig.aus) unit += au.displacement_mm.squaredNorm() / kAus;
  sum += unit * (o.ridge / 2 * x.squaredNorm() + o.temporal / 2 * (x - previous).squaredNorm());
  sum += o.l1 * variance_mm2 * x.sum();
  for (int i = 0; i + 1 < kAus; i += 2) sum += unit * o.left_right / 2 * (x[i] - x[i + 1]) * (x[i] - x[i + 1]);
  return sum;
}

TEST(AuSolver, NoFeasibleChangeLowersTheStatedObjective) {
  const AuSolverOptions options{.ridge = 0.01, .temporal = 0.05, .temporal_speed = 1000, .l1 = 20, .left_right = 0.05};
  Bench bench(options);
  Eigen::VectorXd previous = Eigen::VectorXd::Zero(kAus);
  for (int f = 0; f < 20; ++f) {
    MarkerFrame frame = noisy_frame(bench.rig(), f);
    frame.position_mm[20 + f].y += 15;  // so that robust weights are at work
    const double variance_mm2 = bench.solver().residual_variance_mm2();
    const AuFrame out = bench.solve(frame);
    const Eigen::VectorXd x = Eigen::Map<const Eigen::VectorXd>(out.intensity.data(), kAus);
    if (f == 0) {
      previous = x;  // the first frame has no temporal term
      continue;
    }
    const Eigen::VectorXd weight = bench.solver().marker_weights();
    const double least = objective(bench.rig(), options, frame, out, weight, variance_mm2, previous, x);
    for (int i = 0; i < kAus; ++i) {
      for (const double change : {-1e-3, 1e-3}) {
        Eigen::VectorXd other = x;
        other[i] = std::clamp(x[i] + change, 0.0, bench.rig().aus[i].upper_bound);
        EXPECT_GE(objective(bench.rig(), options, frame, out, weight, variance_mm2, previous, other),
                  least * (1 - 1e-9));
      }
    }
    previous = x;
  }
}

TEST(AuSolver, HeadMotionAloneLeavesIntensitiesAtZero) {
  Bench bench;
  for (int f = 0; f < 60; ++f) {
    const RigidTransform pose = some_pose(f);
    const AuFrame out = bench.solve(marker_frame(bench.rig(), Eigen::VectorXd::Zero(kAus), pose));
    // Float positions: 4e-6 mm over displacements of about 10 mm, times the basis's condition.
    for (int i = 0; i < kAus; ++i) EXPECT_LT(out.intensity[i], 1e-5);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(out.world_from_head.translation_mm[axis], pose.translation[axis], 1e-4);
    }
    const Eigen::Quaterniond found(out.world_from_head.rotation_xyzw.data());
    EXPECT_LT(found.angularDistance(pose.rotation), 1e-6);
  }
}

TEST(AuSolver, ExactHeadMotionLeavesIntensitiesAtZero) {
  Rig rig = synthetic_rig(kMarkers, kAus);
  rig.neutral_mm = (64 * rig.neutral_mm.array()).round() / 64;  // with the motions below, exact in float
  Bench bench({}, rig);
  for (int axis = 0; axis < 3; ++axis) {
    for (int quarter = 0; quarter < 4; ++quarter) {
      RigidTransform pose;
      Eigen::Matrix3d turn = Eigen::AngleAxisd(quarter * std::acos(-1.0) / 2, Eigen::Vector3d::Unit(axis)).matrix();
      pose.rotation = Eigen::Quaterniond(turn.array().round().matrix().eval());
      pose.translation = {100, -30, 8.0 * quarter};
      const AuFrame out = bench.solve(marker_frame(rig, Eigen::VectorXd::Zero(kAus), pose));
      for (int i = 0; i < kAus; ++i) EXPECT_LT(out.intensity[i], 1e-9);
      EXPECT_LT(out.residual_rms_mm, 1e-9);
    }
  }
}

TEST(AuSolver, PoseAndIntensitiesConvergeWhereAusMoveStabilisers) {
  Rig rig = synthetic_rig(kMarkers, kAus);
  rig.aus[0].displacement_mm.leftCols(kStabilisers).row(1).setConstant(2);  // a brow AU that pulls the forehead up
  Bench bench({.ridge = 1e-9, .temporal = 0, .l1 = 0}, rig);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(kAus);
  x[0] = 0.8;
  AuFrame out;
  for (int f = 0; f < 40; ++f) out = bench.solve(marker_frame(rig, x, some_pose(5), static_cast<std::uint64_t>(f)));
  EXPECT_NEAR(out.intensity[0], 0.8, 0.01);
  EXPECT_LT(out.residual_rms_mm, 0.05);
}

/// The bar of EVALUATION section 2: observed AUs differ by at most 0.05 from those with that marker missing.
TEST(AuSolver, AMarkerDisplacedBy20MmDoesNotBendTheFace) {
  const Rig rig = synthetic_rig(kMarkers, kAus);
  for (const int f : {3, 40, 77}) {
    const MarkerFrame clean = noisy_frame(rig, f);
    for (int m = 0; m < kMarkers; ++m) {
      MarkerFrame without = clean;
      without.state[m] = MarkerState::kMissing;
      const AuFrame expected = Bench().solve(without);
      for (int axis = 0; axis < 3; ++axis) {
        MarkerFrame displaced = clean;
        Position& p = displaced.position_mm[m];
        (axis == 0 ? p.x : axis == 1 ? p.y : p.z) += 20;
        const AuFrame out = Bench().solve(displaced);
        for (int i = 0; i < kAus; ++i) {
          if (expected.state[i] != AuState::kObserved) continue;
          EXPECT_LE(std::abs(out.intensity[i] - expected.intensity[i]), 0.05)
              << "frame " << f << " marker " << m << " axis " << axis << " AU " << i;
        }
      }
    }
  }
}

TEST(AuSolver, DoesNotObserveAnAuBehindAMarkerThatItGivesUp) {
  constexpr int kMarker = 30, kAu = 3;
  Rig rig = synthetic_rig(kMarkers, kAus);
  rig.aus[kAu].displacement_mm.setZero();
  rig.aus[kAu].displacement_mm.col(kMarker) << 0, 5, 0;
  Bench bench({}, rig);
  EXPECT_EQ(bench.solve(noisy_frame(rig, 0)).state[kAu], AuState::kObserved);
  MarkerFrame displaced = noisy_frame(rig, 1);
  displaced.position_mm[kMarker].x += 20;
  const AuFrame out = bench.solve(displaced);
  EXPECT_EQ(out.state[kAu], AuState::kHeld);
  EXPECT_EQ(out.status, SolverStatus::kConverged);
  EXPECT_EQ(bench.solve(noisy_frame(rig, 2)).state[kAu], AuState::kObserved);
}

TEST(AuSolver, MissingMarkersLeaveTheOthersExact) {
  Bench bench({.ridge = 1e-9, .temporal = 0, .l1 = 0});
  for (int f = 0; f < 40; ++f) {
    const Eigen::VectorXd x = smooth_intensities(kAus, f / 60.0);
    MarkerFrame frame = marker_frame(bench.rig(), x, some_pose(f), static_cast<std::uint64_t>(f));
    for (int m = f % 9; m < kMarkers; m += 9) {
      frame.state[m] = f % 2 == 0 ? MarkerState::kMissing : MarkerState::kRejected;
      frame.position_mm[m] = {std::numeric_limits<float>::quiet_NaN(), 1e30f, -7};
    }
    const AuFrame out = bench.solve(frame);
    for (int i = 0; i < kAus; ++i) {
      if (out.state[i] == AuState::kObserved) {
        EXPECT_NEAR(out.intensity[i], x[i], 1e-4);
      }
    }
  }
}

TEST(AuSolver, HoldsAnAuWhoseMarkersAreGoneAndNeverInventsOne) {
  Rig rig = synthetic_rig(kMarkers, kAus);
  std::vector<int> movers;  // only these carry AU 0
  for (int m = kStabilisers; m < kMarkers; ++m) {
    if (rig.aus[0].displacement_mm.col(m).norm() > 0.5) movers.push_back(m);
  }
  Eigen::VectorXd x = Eigen::VectorXd::Zero(kAus);
  x[0] = 0.7;
  const MarkerFrame seen = marker_frame(rig, x);
  MarkerFrame hidden = marker_frame(rig, Eigen::VectorXd::Zero(kAus));
  for (const int m : movers) hidden.state[m] = MarkerState::kMissing;

  Bench bench({}, rig);
  const AuFrame never = bench.solve(hidden);
  EXPECT_EQ(never.state[0], AuState::kNotObserved);
  EXPECT_EQ(never.intensity[0], 0);
  const AuFrame observed = bench.solve(seen);
  EXPECT_EQ(observed.state[0], AuState::kObserved);
  const AuFrame held = bench.solve(hidden);
  EXPECT_EQ(held.state[0], AuState::kHeld);
  EXPECT_EQ(held.intensity[0], observed.intensity[0]);
  EXPECT_GT(held.standard_deviation[0], observed.standard_deviation[0]);
  EXPECT_LE(held.kkt_residual, 1e-9);
}

TEST(AuSolver, HoldsEverythingWhileThePoseIsUndetermined) {
  Bench bench;
  const AuFrame before = bench.solve(noisy_frame(bench.rig(), 10));
  MarkerFrame blind = noisy_frame(bench.rig(), 11);
  for (int m = 0; m < kStabilisers - 2; ++m) blind.state[m] = MarkerState::kMissing;
  MarkerFrame nothing = noisy_frame(bench.rig(), 12);
  nothing.state.fill(MarkerState::kMissing);
  for (const MarkerFrame& frame : {blind, nothing}) {
    const AuFrame out = bench.solve(frame);
    EXPECT_EQ(out.status, SolverStatus::kTooFewMarkers);
    EXPECT_EQ(out.world_from_head.rotation_xyzw, before.world_from_head.rotation_xyzw);
    EXPECT_EQ(out.world_from_head.translation_mm, before.world_from_head.translation_mm);
    for (int i = 0; i < kAus; ++i) {
      EXPECT_EQ(out.state[i], AuState::kHeld);
      EXPECT_EQ(out.intensity[i], before.intensity[i]);
    }
    expect_finite_and_bounded(bench.rig(), out);
  }
  EXPECT_EQ(bench.solve(noisy_frame(bench.rig(), 13)).status, SolverStatus::kConverged);
}

TEST(AuSolver, OutputsAreFiniteAndBoundedForAbsurdPositions) {
  Bench bench;
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  for (int f = 0; f < 60; ++f) {
    MarkerFrame frame = noisy_frame(bench.rig(), f);
    for (int m = f % 7; m < kMarkers; m += 1 + f % 5) {
      frame.position_mm[m] = std::array{Position{nan, 0, 0}, Position{1e38f, -1e38f, 0}, Position{inf, 1, 1},
                                        Position{9e5f, 9e5f, -9e5f}, Position{0, 0, 0}}[f % 5];
      frame.state[m] = f % 2 == 0 ? MarkerState::kMeasured : MarkerState::kFilled;
      frame.standard_deviation_mm[m] = f % 3 == 0 ? nan : -1;
    }
    expect_finite_and_bounded(bench.rig(), bench.solve(frame));
  }
}

TEST(AuSolver, FilledMarkersWeighByTheirStatedError) {
  Bench bench;
  MarkerFrame frame = noisy_frame(bench.rig(), 0);
  frame.state[20] = frame.state[21] = MarkerState::kFilled;
  frame.standard_deviation_mm[20] = static_cast<float>(kNoise_mm);  // s0^2 / (s0^2 + s0^2)
  frame.standard_deviation_mm[21] = 2;                              // 0.04 / 4.04
  bench.solve(frame);
  EXPECT_NEAR(bench.solver().marker_weights()[20], 0.5, 1e-6);
  EXPECT_NEAR(bench.solver().marker_weights()[21], 0.04 / 4.04, 1e-6);
  EXPECT_EQ(bench.solver().marker_weights()[22], 1);
}

TEST(AuSolver, GoesByNameWhateverTheOrderOfTheSet) {
  Bench bench;
  MarkerSet permuted = marker_set_of(bench.rig());
  std::reverse(permuted.names.begin(), permuted.names.end());
  permuted.names.insert(permuted.names.begin() + 3, "a marker on the shoulder");
  AuSolver other(bench.rig());
  other.use_marker_set(permuted);
  for (int f = 0; f < 20; ++f) {
    const MarkerFrame frame = noisy_frame(bench.rig(), f);
    MarkerFrame moved = frame;
    moved.count = static_cast<std::uint32_t>(permuted.names.size());
    for (std::size_t m = 0; m < permuted.names.size(); ++m) {
      const int from = index_map(bench.rig().marker_names, permuted.names)[m];
      moved.position_mm[m] = from < 0 ? Position{1, 2, 3} : frame.position_mm[from];
      moved.state[m] = MarkerState::kMeasured;
    }
    const AuFrame expected = bench.solve(frame);
    AuFrame out;
    ASSERT_TRUE(other.push(moved) && other.pop(out));
    EXPECT_EQ(std::memcmp(&out, &expected, sizeof out), 0);
  }
}

TEST(AuSolver, SaysWhichMarkersAreMissingWhenTheRigDoesNotMatchTheTake) {
  const Rig rig = synthetic_rig(kMarkers, kAus);
  AuSolver solver(rig);
  MarkerSet set = marker_set_of(rig);
  for (int m = 0; m < 4; ++m) set.names[m] += "?";  // two of six stabilisers remain
  try {
    solver.use_marker_set(set);
    FAIL();
  } catch (const UserError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("the rig does not match the take"), std::string::npos) << text;
    EXPECT_NE(text.find("M0, M1, M2, M3"), std::string::npos) << text;
    EXPECT_NE(text.find("2 of its 6 stabilisers"), std::string::npos) << text;
  }
  set = marker_set_of(rig);
  set.names.resize(27);  // of 55: less than half
  EXPECT_THROW(solver.use_marker_set(set), UserError);
  set.names = marker_set_of(rig).names;
  set.names.resize(28);
  EXPECT_NO_THROW(solver.use_marker_set(set));
}

TEST(AuSolver, RefusesFramesOfAnotherSetAndCountsThem) {
  Bench bench;
  AuSolver unset(bench.rig());
  MarkerFrame frame = noisy_frame(bench.rig(), 0);
  AuFrame out;
  EXPECT_TRUE(unset.push(frame));
  EXPECT_FALSE(unset.pop(out));
  EXPECT_EQ(unset.ledger().refused.value(), 1u);
  frame.header.set_id = 8;
  EXPECT_TRUE(bench.solver().push(frame));
  frame.header.set_id = 7;
  frame.count = 54;
  EXPECT_TRUE(bench.solver().push(frame));
  EXPECT_EQ(bench.solver().ledger().refused.value(), 2u);
  frame.count = 55;
  EXPECT_TRUE(bench.solver().push(frame));
  EXPECT_FALSE(bench.solver().push(frame));  // not ready: the first result has not been popped
  EXPECT_TRUE(bench.solver().ledger().balanced());
  EXPECT_TRUE(bench.solver().pop(out));
  EXPECT_TRUE(bench.solver().ledger().balanced());
  EXPECT_EQ(bench.solver().ledger().held.value(), 0u);
}

TEST(AuSolver, AllocatesNothingWhileMarkersComeAndGo) {
  Bench bench({.temporal = 0.01, .left_right = 0.01});
  std::vector<MarkerFrame> frames;
  for (int f = 0; f < 60; ++f) {
    frames.push_back(noisy_frame(bench.rig(), f));
    for (int m = 0; m < kMarkers; m += 1 + f % 7) frames.back().state[m] = static_cast<MarkerState>((f + m) % 4);
    frames.back().position_mm[10].x += 30;
  }
  AuFrame out;
  const std::uint64_t before = test::allocations_of_this_thread();
  for (const MarkerFrame& frame : frames) {
    bench.solver().push(frame);
    bench.solver().pop(out);
  }
  bench.solver().tick({});
  bench.solver().flush();
  EXPECT_EQ(test::allocations_of_this_thread(), before);
}

TEST(AuSolver, SameTakeGivesEqualBitsAlsoAfterAFlush) {
  Bench one, two;
  for (int f = 0; f < 30; ++f) two.solve(noisy_frame(two.rig(), 200 - f));  // another take, ended
  two.solver().flush();
  for (int f = 0; f < 60; ++f) {
    MarkerFrame frame = noisy_frame(one.rig(), f);
    if (f % 5 == 0) frame.state[20 + f / 5] = MarkerState::kMissing;
    const AuFrame a = one.solve(frame), b = two.solve(frame);
    EXPECT_EQ(std::memcmp(&a, &b, sizeof a), 0) << "frame " << f;
  }
}

TEST(AuSolver, NewNeutralTakesTheOldOnesPlace) {
  Bench bench({.ridge = 1e-9, .temporal = 0, .l1 = 0});
  Rig shifted = bench.rig();
  shifted.neutral_mm.row(2).tail(kMarkers - kStabilisers).array() += 1;  // markers glued on again, 1 mm off
  bench.solver().set_neutral(shifted.neutral_mm);
  const Eigen::VectorXd x = smooth_intensities(kAus, 0.5);
  const AuFrame out = bench.solve(marker_frame(shifted, x));
  for (int i = 0; i < kAus; ++i) EXPECT_NEAR(out.intensity[i], x[i], 1e-5);
  EXPECT_THROW(bench.solver().set_neutral(Eigen::Matrix3Xd::Zero(3, 4)), UserError);
}

TEST(AuSolver, PredictsItsMarkersInTheWorld) {
  Bench bench({.ridge = 1e-9, .temporal = 0, .l1 = 0});
  const MarkerFrame frame = marker_frame(bench.rig(), smooth_intensities(kAus, 0.5), some_pose(3));
  bench.solve(frame);
  Eigen::Matrix3Xd predicted(3, kMarkers);
  bench.solver().predict_markers(predicted);
  for (int m = 0; m < kMarkers; ++m) {
    const Position& p = frame.position_mm[m];
    EXPECT_LT((predicted.col(m) - Eigen::Vector3d(p.x, p.y, p.z)).norm(), 1e-4);
  }
}

TEST(AuSolver, StandardDeviationsAreThoseOfTheErrors) {
  Bench bench({.ridge = 1e-6, .temporal = 0, .l1 = 0});
  Eigen::VectorXd x = Eigen::VectorXd::Constant(kAus, 0.5);  // inside the bounds, where the fit is linear
  double squared_z = 0;
  constexpr int kFrames = 200;
  for (int f = 0; f < kFrames; ++f) {
    MarkerFrame frame = marker_frame(bench.rig(), x);
    for (int m = 0; m < kStabilisers; ++m) frame.standard_deviation_mm[m] = 0;
    MarkerFrame noisy = frame;
    add_noise(noisy, kNoise_mm, static_cast<unsigned>(f));
    for (int m = 0; m < kStabilisers; ++m) noisy.position_mm[m] = frame.position_mm[m];  // the pose is not in question
    const AuFrame out = bench.solve(noisy);
    for (int i = 0; i < kAus; ++i) {
      const double z = (out.intensity[i] - x[i]) / out.standard_deviation[i];
      squared_z += z * z / (kFrames * kAus);
    }
  }
  // 1 for honest deviations; 15 x 200 draws, correlated within a frame, stay within 10 %.
  EXPECT_NEAR(squared_z, 1, 0.1);
}

TEST(AuSolver, RefusesABadRigAndOptionsOutOfRange) {
  Rig rig = synthetic_rig(kMarkers, kAus);
  rig.aus[3].upper_bound = 0;
  EXPECT_THROW(AuSolver{rig}, UserError);
  const Rig good = synthetic_rig(kMarkers, kAus);
  EXPECT_THROW(AuSolver(good, {.noise_mm = 0}), std::invalid_argument);
  EXPECT_THROW(AuSolver(good, {.ridge = 0}), std::invalid_argument);
  EXPECT_THROW(AuSolver(good, {.temporal = -1}), std::invalid_argument);
  EXPECT_THROW(AuSolver(good, {.robust_iterations = 21}), std::invalid_argument);
  EXPECT_THROW(AuSolver(good, {.min_visible_share = std::numeric_limits<double>::quiet_NaN()}), std::invalid_argument);
}

TEST(AuSolver, SaysThatAFaceIsMirrored) {
  Bench bench({}, builtin_rig());
  for (int f = 0; f < 20; ++f) {
    const MarkerFrame frame = noisy_frame(bench.rig(), f);
    EXPECT_EQ(bench.solve(frame).status, SolverStatus::kConverged);
  }
  for (int f = 20; f < 40; ++f) {
    MarkerFrame frame = noisy_frame(bench.rig(), f);
    for (std::uint32_t m = 0; m < frame.count; ++m) frame.position_mm[m].x = -frame.position_mm[m].x;
    const AuFrame out = bench.solve(frame);
    EXPECT_EQ(out.status, SolverStatus::kMirrored);
    for (std::uint32_t i = 0; i < out.count; ++i) EXPECT_NE(out.state[i], AuState::kObserved);
  }
  EXPECT_EQ(bench.solve(noisy_frame(bench.rig(), 40)).status, SolverStatus::kConverged);
}

TEST(AuSolver, ObservesNothingByFilledMarkersAlone) {
  Bench bench({}, builtin_rig());
  for (int f = 0; f < 20; ++f) bench.solve(noisy_frame(bench.rig(), f));
  const auto fill_all_but = [](MarkerFrame frame, std::uint32_t measured) {
    for (std::uint32_t m = measured; m < frame.count; ++m) {
      frame.state[m] = MarkerState::kFilled;
      frame.standard_deviation_mm[m] = 0.3F;
    }
    return frame;
  };
  const AuFrame none = bench.solve(fill_all_but(noisy_frame(bench.rig(), 20), 0));
  EXPECT_EQ(none.status, SolverStatus::kTooFewMarkers);
  for (std::uint32_t i = 0; i < none.count; ++i) EXPECT_NE(none.state[i], AuState::kObserved);
  // Filled markers still hold the head: with a few measured ones the frame is solved, and AUs elsewhere are held.
  const AuFrame few = bench.solve(fill_all_but(noisy_frame(bench.rig(), 21), 12));
  EXPECT_EQ(few.status, SolverStatus::kConverged);
  EXPECT_GT(std::count(few.state.begin(), few.state.begin() + few.count, AuState::kHeld), 0);
}

}  // namespace
}  // namespace risorius
