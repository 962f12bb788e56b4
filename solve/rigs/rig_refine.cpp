#include "solve/rigs/rig_refine.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <stdexcept>

#include "capture/errors.h"
#include "solve/rigs/au_guard.h"
#include "solve/rigs/marker_basis.h"
#include "solve/rigs/marker_rigidity.h"
#include "solve/rigs/stabiliser_choice.h"

namespace risorius {
namespace {

constexpr double kDegreesPerRadian = 180 / 3.14159265358979323846;
constexpr double kAtBound = 1e-6;
constexpr double kConvergedShare = 0.003;  // of the residual: a round that gains less was the last
/// The median of |r| over a normal residual's axes is 0.6745 of its standard deviation.
constexpr double kMedianOfNormal = 0.6745;

void validate(const RigRefineOptions& o) {
  const auto require = [](bool good, const char* name, double value, const char* range) {
    if (!good) throw std::invalid_argument(fmt::format("RigRefineOptions.{} = {}: must be {}", name, value, range));
  };
  require(o.rounds >= 1 && o.rounds <= 100, "rounds", o.rounds, "1 to 100");
  require(o.independent_s > 0, "independent_s", o.independent_s, "above 0");
  require(o.least_noise_mm > 0, "least_noise_mm", o.least_noise_mm, "above 0");
  require(o.least_intensity > 0 && o.least_intensity < 1, "least_intensity", o.least_intensity, "between 0 and 1");
  require(o.least_moved_mm > 0, "least_moved_mm", o.least_moved_mm, "above 0");
  validate(o.prior);
}

double quantile(std::vector<double>& values, double q) {
  if (values.empty()) return 0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// One pass of solves over the takes: evidence for the update, and what the rig left.
struct Pass {
  BasisEvidence evidence;
  std::vector<std::vector<double>> intensity;  // per AU, where observed
  std::vector<double> active_s, displaced_mm, residual_axis_mm;
  double squares = 0, samples = 0;
  std::size_t frames = 0;

  double residual_rms_mm() const { return samples > 0 ? std::sqrt(squares / samples) : 0; }
};

/// Covariance of the intensities for a noise of 1 mm per axis: of those above 0, given the others (K x K).
Eigen::MatrixXd unit_covariance(const ExplainedFrame& frame, const MarkerBasis& basis,
                                const RigRefineOptions& options) {
  std::vector<Eigen::Index> free;
  for (Eigen::Index i = 0; i < frame.x.size(); ++i) {
    if (frame.x[i] > kAtBound) free.push_back(i);
  }
  Eigen::MatrixXd gram(frame.x.size(), frame.x.size());
  basis.gram(frame.weight, gram);
  gram.diagonal().array() += options.solve.ridge * basis.mean_diagonal_mm2();
  const Eigen::MatrixXd of_free = gram(free, free);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(gram.rows(), gram.cols());
  const Eigen::MatrixXd inverse = of_free.llt().solve(Eigen::MatrixXd::Identity(of_free.rows(), of_free.cols()));
  covariance(free, free) = inverse;
  return covariance;
}

/// `start_neutral_mm`: displacements are told from it, because the priors stand around it.
void add_frame(const ExplainedFrame& frame, const Rig& rig, const MarkerBasis& basis,
               const Eigen::Matrix3Xd& start_neutral_mm, const RigRefineOptions& options, Pass& pass) {
  const Eigen::Matrix3Xd y_mm = frame.displacement_mm + rig.neutral_mm - start_neutral_mm;
  pass.evidence.add(frame.x, unit_covariance(frame, basis, options), y_mm, frame.weight,
                    std::clamp(frame.share_of_time / options.independent_s, 1e-6, 1.0));
  ++pass.frames;
  for (Eigen::Index m = 0; m < frame.measured.size(); ++m) {
    if (frame.measured[m] == 0) continue;
    pass.squares += frame.residual_mm.col(m).squaredNorm();
    pass.samples += 1;
    pass.displaced_mm.push_back(frame.displacement_mm.col(m).norm());
    for (const double axis : frame.residual_mm.col(m)) pass.residual_axis_mm.push_back(std::abs(axis));
  }
  for (std::size_t i = 0; i < pass.intensity.size(); ++i) {
    if (!frame.observed[i]) continue;
    const double x = frame.x[static_cast<Eigen::Index>(i)];
    pass.intensity[i].push_back(x);
    if (x > options.least_intensity) pass.active_s[i] += frame.share_of_time;
  }
}

Pass solve_takes(const Rig& rig, const Eigen::Matrix3Xd& start_neutral_mm, const std::vector<TakeFrames>& takes,
                 const RigRefineOptions& options, const std::function<void()>& frame_done) {
  Pass pass{.evidence = BasisEvidence(rig.marker_count(), rig.au_count()),
            .intensity = std::vector<std::vector<double>>(rig.au_count()),
            .active_s = std::vector<double>(rig.au_count(), 0.0)};
  const MarkerBasis basis(rig);
  for (const TakeFrames& take : takes) {
    const std::size_t before = pass.frames;
    explain_take(rig, take, options.solve, [&](const ExplainedFrame& frame) {
      add_frame(frame, rig, basis, start_neutral_mm, options, pass);
      frame_done();
    });
    if (pass.frames == before) {
      throw UserError(take.place, "not one frame could be solved with this rig",
                      "is it a take of this actor; are unit and axes right?");
    }
  }
  return pass;
}

/// Which AUs are in the takes. Throws where nothing is to be learned.
std::vector<char> informed_aus(Pass& pass, const std::vector<TakeFrames>& takes, const RigRefineOptions& options) {
  const std::string& place = takes.front().place;
  const double moved_mm = quantile(pass.displaced_mm, 0.9);
  if (moved_mm < options.least_moved_mm) {
    throw UserError(
        place, fmt::format("the face hardly moves: 90 % of the markers stay within {:.2f} mm of the neutral", moved_mm),
        "refine on a range of motion: each AU to its maximum and back");
  }
  std::vector<char> informed;
  for (std::vector<double>& x : pass.intensity) informed.push_back(quantile(x, 0.98) > options.least_intensity);
  if (std::ranges::none_of(informed, [](char i) { return i != 0; })) {
    throw UserError(place, fmt::format("no AU rises above {:.2f}", options.least_intensity),
                    "refine on a range of motion: each AU to its maximum and back");
  }
  return informed;
}

/// Stabilisers that move with the face give their place to others.
void choose_stabilisers(Rig& rig, const std::vector<TakeFrames>& takes, RigRefinement& result) {
  Eigen::VectorXd unrest_mm = marker_unrest_mm(rig, takes.front());
  for (std::size_t t = 1; t < takes.size(); ++t) {
    const Eigen::VectorXd other_mm = marker_unrest_mm(rig, takes[t]);
    for (Eigen::Index m = 0; m < unrest_mm.size(); ++m) unrest_mm[m] = std::fmax(unrest_mm[m], other_mm[m]);
  }
  const StabiliserChoice choice = choose_by_unrest(rig, unrest_mm);
  rig.stabiliser_weight = choice.weight;
  for (const std::size_t m : choice.dropped) result.stabilisers_dropped.push_back(rig.marker_names[m]);
  for (const std::size_t m : choice.added) result.stabilisers_added.push_back(rig.marker_names[m]);
}

void describe_activity(Pass& pass, RigRefinement& result) {
  for (std::size_t i = 0; i < result.aus.size(); ++i) {
    result.aus[i].peak = quantile(pass.intensity[i], 0.98);
    result.aus[i].active_s = pass.active_s[i];
  }
}

void describe(const Rig& start, RigRefinement& result) {
  for (std::size_t i = 0; i < start.au_count(); ++i) {
    AuRefinement& au = result.aus[i];
    const Eigen::Matrix3Xd &before = start.aus[i].displacement_mm, &after = result.rig.aus[i].displacement_mm;
    au.moved_mm = (after - before).colwise().norm().maxCoeff();
    au.turned_degrees = kDegreesPerRadian * std::acos(std::clamp(cosine_of(before, after), -1.0, 1.0));
    au.gain = after.norm() / before.norm();
  }
  Eigen::Index marker = 0;
  result.neutral_moved_mm = (result.rig.neutral_mm - start.neutral_mm).colwise().norm().maxCoeff(&marker);
  result.neutral_moved_marker = start.marker_names[static_cast<std::size_t>(marker)];
  std::vector<std::string> held_back;
  for (const AuRefinement& au : result.aus) {
    if (au.guarded) held_back.push_back(au.au);
  }
  if (!held_back.empty()) {
    result.warnings.push_back(fmt::format("held back, because the takes would have made them another action: {}",
                                          fmt::join(held_back, ", ")));
  }
  if (!(result.residual_after_mm < result.residual_before_mm)) {
    result.warnings.push_back("the refined rig explains these takes no better than the one that it began with");
  }
}

}  // namespace

RigRefinement refine_rig(const Rig& given, const std::vector<TakeFrames>& takes, const RigRefineOptions& options,
                         const RefineProgress& progress) {
  validate(options);
  if (takes.empty()) throw UserError("refinement", "no take", "give at least one take of the actor");
  RigRefinement result;
  Rig start = given;
  if (options.chooses_stabilisers) choose_stabilisers(start, takes, result);
  result.rig = start;
  for (const RigAu& au : start.aus) result.aus.push_back({.au = au.name});
  std::size_t frames_per_pass = 0;
  for (const TakeFrames& take : takes) frames_per_pass += take.frames.size();
  const std::size_t all = frames_per_pass * static_cast<std::size_t>(options.rounds + 1);
  std::size_t done = 0;
  const auto frame_done = [&] {
    if (progress && ++done % 64 == 0) progress(std::min(done, all), all);
  };

  const AuGuard guard(start, {.least_cosine = options.least_cosine,
                              .least_gain = options.least_gain,
                              .largest_gain = options.largest_gain,
                              .largest_far_share = options.largest_far_share,
                              .reach_mm = options.prior.reach_mm});
  Pass pass = solve_takes(start, start.neutral_mm, takes, options, frame_done);
  const std::vector<char> informed = informed_aus(pass, takes, options);
  describe_activity(pass, result);
  for (std::size_t i = 0; i < start.au_count(); ++i) result.aus[i].informed = informed[i] != 0;
  result.residual_before_mm = result.residual_after_mm = pass.residual_rms_mm();
  result.frames = pass.frames;
  for (int round = 0; round < options.rounds; ++round) {
    const double noise_mm = std::max(quantile(pass.residual_axis_mm, 0.5) / kMedianOfNormal, options.least_noise_mm);
    Rig updated = update_basis(start, pass.evidence, options.prior, noise_mm, informed);
    std::vector<char> guarded;
    for (std::size_t i = 0; i < start.au_count(); ++i) {
      guarded.push_back(guard.hold_back(i, updated.aus[i].displacement_mm));
    }
    Pass next = solve_takes(updated, start.neutral_mm, takes, options, frame_done);
    const double before_mm = result.residual_after_mm, after_mm = next.residual_rms_mm();
    pass = std::move(next);
    if (after_mm >= before_mm) continue;  // the guard may cost a round; the next one makes the best of it
    result.rig = std::move(updated);
    result.residual_after_mm = after_mm;
    result.rounds = round + 1;
    describe_activity(pass, result);
    for (std::size_t i = 0; i < start.au_count(); ++i) result.aus[i].guarded = guarded[i] != 0;
    if (before_mm - after_mm < kConvergedShare * before_mm) break;
  }
  if (progress) progress(all, all);
  describe(start, result);
  return result;
}

}  // namespace risorius
