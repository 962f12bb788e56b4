#include "solve/joint/take_solver.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <fmt/format.h>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "capture/check.h"
#include "solve/joint/take_neutral.h"
#include "solve/rigs/rig_markers.h"
#include "solve/robust_weight.h"

namespace risorius {
namespace {

/// What a window shares with its neighbours on either side: more than a course remembers.
constexpr double kOverlap_s = 0.2;
constexpr Eigen::Index kLeastOverlap = 24, kWindowOverlaps = 4;  // frames; a window is so many overlaps long
constexpr double kNominalRate_hz = 60;
/// Frames whose distance strays so far from the usual one are no neighbours: something was lost between them.
constexpr double kEvenStep = 1.5;
constexpr int kFirstRounds = 12, kLaterRounds = 60, kMostSweeps = 30;
constexpr double kCertified = 1e-7;
constexpr int kNeutralTurns = 8;
constexpr double kStillMm = 0.02;  // a neutral whose markers all move less has been found
/// Shares of the whole work, for the progress line: the causal solve, the first sweep, all others.
constexpr double kCausalShare = 0.1, kFirstSweepShare = 0.5;

void require(const char* name, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw std::invalid_argument(fmt::format("TakeSolverOptions.{} {} is not in [{}, {}]", name, value, low, high));
}

RigidTransform head_from_world_of(const AuFrame& frame) {
  RigidTransform world_from_head;
  world_from_head.rotation = Eigen::Quaterniond(frame.world_from_head.rotation_xyzw.data());
  world_from_head.translation = Eigen::Vector3d(frame.world_from_head.translation_mm.data());
  return world_from_head.inverse();
}

JointFrame joint_frame_of(const Rig& rig, const RigMarkers& markers, const Eigen::VectorXd& weight,
                          const AuFrame& solved) {
  JointFrame frame;
  frame.capture_time_ns = solved.header.capture_time_ns;
  frame.is_solved = solved.status == SolverStatus::kConverged || solved.status == SolverStatus::kIterationLimit;
  if (!frame.is_solved) return frame;
  const auto marker_count = static_cast<Eigen::Index>(rig.marker_count());
  frame.head_from_world = head_from_world_of(solved);
  frame.weight = weight;
  frame.y_mm = Eigen::VectorXd::Zero(3 * marker_count);
  for (Eigen::Index m = 0; m < marker_count; ++m) {
    frame.measured.push_back(markers.is_measured(static_cast<std::size_t>(m)));
    if (!(weight[m] > 0)) continue;
    frame.y_mm.segment<3>(3 * m) =
        frame.head_from_world * markers.world_mm(static_cast<std::size_t>(m)) - rig.neutral_mm.col(m);
  }
  for (std::size_t i = 0; i < rig.au_count(); ++i) frame.observed.push_back(solved.state[i] == AuState::kObserved);
  return frame;
}

}  // namespace

struct TakeSolver::Take {
  explicit Take(const Rig& rig, double neutral_mm) : neutral(rig, neutral_mm) {}

  TakeNeutral neutral;
  std::vector<AuFrame> out;
  std::vector<JointFrame> frames;
  std::vector<double> variances_mm2;
  JointPenalties penalties;
  double variance_mm2 = 0, smoothness_mm2 = 0, step_s = 0;
  Eigen::Index overlap = kLeastOverlap, window = kWindowOverlaps * kLeastOverlap;  // frames
  JointSmoothness joints;
  JointState state;
  std::vector<double> kkt_residual;
};

TakeSolver::TakeSolver(Rig rig, const TakeSolverOptions& options)
    : rig_(std::move(rig)), rig_of_take_(rig_), options_(options) {
  require("smoothness", options.smoothness, 1e-6, 1e6);
  require("acceleration_per_s2", options.acceleration_per_s2, 1e-6, 1e6);
  require("neutral_mm", options.neutral_mm, 0, 20);
  require("threads", options.threads, 0, 1024);
  const AuSolver refuses_what_is_wrong(rig_, options.solve);
  upper_.resize(static_cast<Eigen::Index>(rig_.au_count()));
  for (Eigen::Index i = 0; i < upper_.size(); ++i) upper_[i] = rig_.aus[static_cast<std::size_t>(i)].upper_bound;
}

std::vector<AuFrame> TakeSolver::solve(const MarkerSet& set, std::span<const MarkerFrame> frames,
                                       const TakeSolverProgress& progress) {
  Take take(rig_, options_.neutral_mm);
  solve_causally(set, frames, take);
  rig_of_take_ = rig_;
  if (take.frames.empty()) return {};
  if (options_.neutral_mm > 0) find_neutral(set, frames, take);
  const auto all = static_cast<double>(frames.size());
  if (progress) progress(static_cast<std::uint64_t>(kCausalShare * all), frames.size());
  join(take);
  sweep(take, kFirstRounds, progress);
  smooth_by_course(take);
  certify(take, progress, frames.size());
  for (int turn = 0; turn < kNeutralTurns && options_.neutral_mm > 0; ++turn) {
    const double moved_mm = take.neutral.update(take.frames, take.state, take.variance_mm2, take.step_s);
    certify(take, {}, frames.size());
    if (moved_mm < kStillMm) break;
  }
  publish(take);
  rig_of_take_ = take.neutral.rig();
  return std::move(take.out);
}

/// Sweeps until every frame is certified, or no more is to be had.
void TakeSolver::certify(Take& take, const TakeSolverProgress& progress, std::uint64_t all) const {
  for (int sweeps = 0; sweeps < kMostSweeps; ++sweeps) {
    if (sweep(take, kLaterRounds, {}) <= kCertified) break;
    const double share = 1 - (1 - kCausalShare - kFirstSweepShare) * std::pow(0.7, sweeps);
    if (progress) progress(static_cast<std::uint64_t>(share * static_cast<double>(all)), all);
  }
}

/// The causal solve by turns with the neutral, so that poses and the markers' weights are those of the face as it is.
void TakeSolver::find_neutral(const MarkerSet& set, std::span<const MarkerFrame> frames, Take& take) const {
  for (int turn = 0; turn < kNeutralTurns; ++turn) {
    join(take);
    const double moved_mm = take.neutral.update(take.frames, take.state, take.variance_mm2, take.step_s);
    solve_causally(set, frames, take);
    if (moved_mm < kStillMm) break;
  }
}

void TakeSolver::solve_causally(const MarkerSet& set, std::span<const MarkerFrame> frames, Take& take) const {
  const Rig& rig = take.neutral.rig();
  AuSolver solver(rig, options_.solve);
  solver.use_marker_set(set);
  RigMarkers markers(rig, options_.solve.noise_mm);
  markers.use_marker_set(rig, set);
  take.out.clear();
  take.frames.clear();
  take.variances_mm2.clear();
  for (const MarkerFrame& frame : frames) {
    AuFrame& out = take.out.emplace_back();
    RISORIUS_CHECK(solver.push(frame) && solver.pop(out));
    markers.read(frame);
    take.frames.push_back(joint_frame_of(rig, markers, solver.pulling_weights(), out));
    if (take.frames.back().is_solved) take.variances_mm2.push_back(solver.residual_variance_mm2());
  }
}

/// What stands between the frames: the prices, the courses' smoothness, and the causal solution as a start.
void TakeSolver::join(Take& take) const {
  const auto count = static_cast<Eigen::Index>(take.frames.size()), k = upper_.size();
  const double unit_mm2 = MarkerBasis(rig_).mean_diagonal_mm2();
  take.variance_mm2 = lower_median(take.variances_mm2);
  take.penalties = {options_.solve.ridge * unit_mm2, options_.solve.l1 * take.variance_mm2};
  std::vector<double> steps_s;
  for (Eigen::Index f = 1; f < count; ++f) {
    steps_s.push_back(static_cast<double>(difference_ns(take.frames[static_cast<std::size_t>(f)].capture_time_ns,
                                                        take.frames[static_cast<std::size_t>(f) - 1].capture_time_ns)) *
                      1e-9);
  }
  std::vector<double> sorted = steps_s;
  take.step_s = lower_median(sorted);
  if (take.step_s > 0) {
    take.overlap = std::max(kLeastOverlap, std::min(count, static_cast<Eigen::Index>(kOverlap_s / take.step_s)));
    take.window = kWindowOverlaps * take.overlap;
  }
  // The integral of the squared acceleration, as a sum over frames: (x'' dt^2)^2 / dt^3.
  const double rate = take.step_s > 0 ? 1 / (take.step_s * kNominalRate_hz) : 0;
  take.smoothness_mm2 = options_.smoothness * unit_mm2 * rate * rate * rate;
  take.joints.weight_mm2 = Eigen::MatrixXd::Zero(k, count);
  const auto is_even = [&](Eigen::Index f) {
    const double step_s = steps_s[static_cast<std::size_t>(f)];
    return step_s > take.step_s / kEvenStep && step_s < take.step_s * kEvenStep;
  };
  for (Eigen::Index f = 1; f + 1 < count; ++f) {
    if (is_even(f - 1) && is_even(f)) take.joints.weight_mm2.col(f).setConstant(take.smoothness_mm2);
  }
  take.state.x.resize(k, count);
  take.state.d = Eigen::MatrixXd::Zero(6, count);
  take.state.place.clear();
  for (Eigen::Index f = 0; f < count; ++f) {
    for (Eigen::Index i = 0; i < k; ++i) {
      const double x = take.out[static_cast<std::size_t>(f)].intensity[static_cast<std::size_t>(i)];
      take.state.x(i, f) = x;
      take.state.place.push_back(x <= 0 ? JointPlace::kLower : x >= upper_[i] ? JointPlace::kUpper : JointPlace::kFree);
    }
  }
  take.kkt_residual.assign(take.frames.size(), 0);
}

/// Where a course bends, it is meant: onsets stay as steep as they are.
void TakeSolver::smooth_by_course(Take& take) const {
  const double usual = options_.acceleration_per_s2 * take.step_s * take.step_s;
  for (Eigen::Index f = 1; f + 1 < take.state.x.cols(); ++f) {
    const Eigen::ArrayXd bend = take.state.x.col(f - 1) - 2 * take.state.x.col(f) + take.state.x.col(f + 1);
    take.joints.weight_mm2.col(f).array() /= 1 + (bend / usual).square();
  }
}

/// All windows once, each from the same state of the take. Returns the KKT residual of the take before the sweep's
/// last exchange, that is after it.
double TakeSolver::sweep(Take& take, int rounds, const TakeSolverProgress& progress) const {
  const auto count = static_cast<Eigen::Index>(take.frames.size()), k = upper_.size();
  const Eigen::Index windows = (count + take.window - 1) / take.window;
  JointState next = take.state;
  std::atomic<Eigen::Index> turn{0};
  std::mutex mutex;
  Eigen::Index done = 0;
  const auto in_parallel = [&](const auto& work) {
    turn = 0;
    const unsigned machine = std::max(1U, std::thread::hardware_concurrency());
    const auto threads =
        std::min<Eigen::Index>(windows, options_.threads > 0 ? options_.threads : static_cast<Eigen::Index>(machine));
    std::vector<std::jthread> workers;
    for (Eigen::Index t = 0; t < threads; ++t) {
      workers.emplace_back([&] {
        JointNormalMaker maker(take.neutral.rig());
        for (Eigen::Index w = turn++; w < windows; w = turn++) work(maker, w);
      });
    }
  };
  const auto window_of = [&](JointNormalMaker& maker, Eigen::Index first, Eigen::Index last) {
    std::vector<JointNormal> normals;
    for (Eigen::Index f = first; f < last; ++f) {
      normals.push_back(maker.make(take.frames[static_cast<std::size_t>(f)], take.penalties));
    }
    return JointWindow(std::move(normals), first, take.joints, upper_);
  };
  in_parallel([&](JointNormalMaker& maker, Eigen::Index w) {
    const Eigen::Index own = w * take.window, end = std::min(count, own + take.window);
    const Eigen::Index first = std::max<Eigen::Index>(0, own - take.overlap),
                       last = std::min(count, end + take.overlap);
    JointWindow window = window_of(maker, first, last);
    window.solve(take.state, rounds);
    const JointState& solved = window.solution();
    const std::scoped_lock lock(mutex);
    next.x.middleCols(own, end - own) = solved.x.middleCols(own - first, end - own);
    next.d.middleCols(own, end - own) = solved.d.middleCols(own - first, end - own);
    std::copy(solved.place.begin() + (own - first) * k, solved.place.begin() + (end - first) * k,
              next.place.begin() + own * k);
    done += end - own;
    const double share = kCausalShare + kFirstSweepShare * static_cast<double>(done) / static_cast<double>(count);
    if (progress) progress(static_cast<std::uint64_t>(share * static_cast<double>(count)), take.frames.size());
  });
  take.state = std::move(next);
  in_parallel([&](JointNormalMaker& maker, Eigen::Index w) {
    const Eigen::Index own = w * take.window, end = std::min(count, own + take.window);
    const JointWindow window = window_of(maker, own, end);
    for (Eigen::Index f = own; f < end; ++f) {
      take.kkt_residual[static_cast<std::size_t>(f)] = window.kkt_residual(take.state, f - own);
    }
  });
  return *std::max_element(take.kkt_residual.begin(), take.kkt_residual.end());
}

void TakeSolver::publish(Take& take) const {
  const Rig& rig = take.neutral.rig();
  const MarkerBasis basis(rig);
  const JointNormalMaker maker(rig);
  Eigen::VectorXd fitted_mm(3 * basis.marker_count());
  for (std::size_t f = 0; f < take.frames.size(); ++f) {
    const JointFrame& frame = take.frames[f];
    if (!frame.is_solved) continue;
    AuFrame& out = take.out[f];
    const auto column = static_cast<Eigen::Index>(f);
    const Eigen::VectorXd x = take.state.x.col(column);
    const RigidTransform step = maker.moved({}, take.state.d.col(column));
    const RigidTransform world_from_head = maker.moved(frame.head_from_world, take.state.d.col(column)).inverse();
    basis.deform(x, fitted_mm);
    double squared = 0;
    int measured = 0;
    for (Eigen::Index m = 0; m < basis.marker_count(); ++m) {
      if (!frame.measured[static_cast<std::size_t>(m)]) continue;
      const Eigen::Vector3d neutral = rig.neutral_mm.col(m);
      const Eigen::Vector3d seen = step * Eigen::Vector3d(frame.y_mm.segment<3>(3 * m) + neutral) - neutral;
      squared += (fitted_mm.segment<3>(3 * m) - seen).squaredNorm();
      ++measured;
    }
    const Eigen::Quaterniond& q = world_from_head.rotation;
    out.world_from_head = {
        {q.x(), q.y(), q.z(), q.w()},
        {world_from_head.translation.x(), world_from_head.translation.y(), world_from_head.translation.z()}};
    out.residual_rms_mm = measured > 0 ? std::sqrt(squared / measured) : 0;
    out.kkt_residual = take.kkt_residual[f];
    out.status = out.kkt_residual <= 1e-6 ? SolverStatus::kConverged : SolverStatus::kIterationLimit;
    for (std::size_t i = 0; i < rig_.au_count(); ++i) out.intensity[i] = x[static_cast<Eigen::Index>(i)];
  }
}

}  // namespace risorius
