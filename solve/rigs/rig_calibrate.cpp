#include "solve/rigs/rig_calibrate.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <set>

#include "capture/errors.h"
#include "solve/head_pose.h"
#include "solve/rigs/au_name.h"
#include "solve/rigs/rank_one_motion.h"
#include "solve/rigs/stabilisers.h"

namespace risorius {
namespace {

constexpr std::size_t kLeastFrames = 10;
/// A stabiliser that the AU is expected to carry along this far cannot hold the head in its recording.
constexpr double kMovedStabiliserMm = 1.0;
constexpr double kDriftedRestMm = 2.0;
constexpr double kMidlineMm = 3.0;
constexpr double kLeastSideShare = 0.6;

double cosine(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b) {
  return a.cwiseProduct(b).sum() / std::max(a.norm() * b.norm(), 1e-12);
}

const RigAu* find_au(const Rig& rig, const std::string& name) {
  const auto found = std::ranges::find(rig.aus, name, &RigAu::name);
  return found == rig.aus.end() ? nullptr : &*found;
}

/// The rig's stabilisers without those that this AU is expected to move, unless too few would be left.
Eigen::VectorXd stabilisers_for(const Rig& fitted, const RigAu* expected) {
  Eigen::VectorXd weight = fitted.stabiliser_weight;
  if (expected == nullptr) return weight;
  for (Eigen::Index m = 0; m < weight.size(); ++m) {
    if (expected->displacement_mm.col(m).norm() > kMovedStabiliserMm) weight[m] = 0;
  }
  return hold_still(fitted.neutral_mm, weight) ? weight : fitted.stabiliser_weight;
}

Displacements in_head_frame(const Rig& fitted, const CalibrationRecording& recording, const RigAu* expected) {
  const auto markers = static_cast<Eigen::Index>(fitted.marker_count());
  const Eigen::VectorXd stabiliser = stabilisers_for(fitted, expected);
  std::vector<Eigen::Vector3d> neutral(fitted.marker_count()), world(fitted.marker_count());
  for (Eigen::Index m = 0; m < markers; ++m) neutral[static_cast<std::size_t>(m)] = fitted.neutral_mm.col(m);
  std::vector<double> pose_weight(fitted.marker_count());
  HeadPose pose(fitted.marker_count(), HeadPoseOptions{});
  Displacements result;
  for (const Eigen::Matrix3Xd& frame : recording.world_mm) {
    Eigen::VectorXd weight(markers);
    for (Eigen::Index m = 0; m < markers; ++m) {
      const auto i = static_cast<std::size_t>(m);
      weight[m] = frame.col(m).allFinite() ? 1 : 0;
      world[i] = weight[m] > 0 ? Eigen::Vector3d(frame.col(m)) : Eigen::Vector3d::Zero();
      pose_weight[i] = weight[m] * stabiliser[m];
    }
    const HeadPoseResult head = pose.estimate(neutral, world, pose_weight);
    if (!head.determined) continue;
    const RigidTransform head_from_world = head.world_from_head.inverse();
    Eigen::Matrix3Xd d = Eigen::Matrix3Xd::Zero(3, markers);
    for (Eigen::Index m = 0; m < markers; ++m) {
      if (weight[m] > 0) d.col(m) = head_from_world * world[static_cast<std::size_t>(m)] - fitted.neutral_mm.col(m);
    }
    result.d_mm.push_back(std::move(d));
    result.weight.push_back(std::move(weight));
  }
  return result;
}

void describe(const Rig& fitted, const RankOneMotion& model, const RigCalibrateOptions& options,
              AuCalibration& result) {
  Eigen::Index peak = 0;
  result.peak_mm = model.field_mm.colwise().norm().maxCoeff(&peak);
  result.peak_marker = fitted.marker_names[static_cast<std::size_t>(peak)];
  result.noise_mm = model.noise_mm;
  for (const double a : model.amplitude) result.held_frames += a >= options.hold_share;
  double left = 0;
  for (Eigen::Index m = 0; m < model.field_mm.cols(); ++m) {
    const double x = fitted.neutral_mm(0, m);
    left += model.field_mm.col(m).squaredNorm() * (x > kMidlineMm ? 1 : x < -kMidlineMm ? 0 : 0.5);
  }
  result.left_share = left / std::max(model.field_mm.squaredNorm(), 1e-12);
  const RigAu* expected = find_au(fitted, result.au);
  result.match = expected == nullptr ? std::numeric_limits<double>::quiet_NaN()
                                     : cosine(model.field_mm, expected->displacement_mm);
  for (const RigAu& other : fitted.aus) {
    const double match = cosine(model.field_mm, other.displacement_mm);
    if (match > result.best_match_cosine) result.best_match_cosine = match, result.best_match = other.name;
  }
}

void doubt(const AuCalibration& au, const std::string& place, const RigCalibrateOptions& options,
           std::vector<std::string>& warnings) {
  const auto name = parse_au_name(au.au);
  const bool is_left = name && name->side == AuSide::kLeft, is_right = name && name->side == AuSide::kRight;
  const double own_share = is_left ? au.left_share : 1 - au.left_share;
  if ((is_left || is_right) && own_share < kLeastSideShare) {
    warnings.push_back(
        fmt::format("{}: {} moves the subject's {} side with {:.0f} % of its energy; was the side "
                    "mistaken, or both sides moved?",
                    place, au.au, is_left ? "left" : "right", 100 * own_share));
  }
  if (au.match < options.least_match) {
    warnings.push_back(fmt::format("{}: what moves is little like {} (cosine {:.2f}); it is most like {} ({:.2f})",
                                   place, au.au, au.match, au.best_match, au.best_match_cosine));
  }
  if (au.rest_mm > kDriftedRestMm) {
    warnings.push_back(
        fmt::format("{}: the face at rest lies {:.1f} mm (rms) from the neutral; record a new neutral "
                    "if markers were put on again",
                    place, au.rest_mm));
  }
}

/// Which AUs the markers cannot tell apart: by pairs, and by what all others together explain of one.
void compare_fields(RigCalibration& result, const RigCalibrateOptions& options) {
  const auto count = static_cast<Eigen::Index>(result.rig.au_count());
  Eigen::MatrixXd gram(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index j = 0; j < count; ++j) {
      gram(i, j) = cosine(result.rig.aus[static_cast<std::size_t>(i)].displacement_mm,
                          result.rig.aus[static_cast<std::size_t>(j)].displacement_mm);
    }
  }
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index j = i + 1; j < count; ++j) {
      if (gram(i, j) <= options.alike_cosine) continue;
      result.warnings.push_back(fmt::format("the markers hardly tell {} and {} apart (cosine {:.3f})",
                                            result.rig.aus[static_cast<std::size_t>(i)].name,
                                            result.rig.aus[static_cast<std::size_t>(j)].name, gram(i, j)));
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(gram);
  const double least = eigen.eigenvalues()[0];
  result.condition = eigen.eigenvalues()[count - 1] / std::max(least, 1e-15);
  const Eigen::MatrixXd regular = gram + 1e-9 * Eigen::MatrixXd::Identity(count, count);
  const Eigen::VectorXd unexplained = regular.inverse().diagonal().cwiseInverse();
  for (Eigen::Index i = 0; i < count; ++i) {
    if (count < 3 || unexplained[i] > 1 - options.alike_cosine * options.alike_cosine) continue;
    result.warnings.push_back(fmt::format("{} is explained by the other AUs together but for {:.1f} % of its energy",
                                          result.rig.aus[static_cast<std::size_t>(i)].name, 100 * unexplained[i]));
  }
}

AuCalibration calibrate_au(const Rig& fitted, const CalibrationRecording& recording, const RigCalibrateOptions& options,
                           RigAu& column) {
  const RigAu* expected = find_au(fitted, recording.au);
  Displacements take = in_head_frame(fitted, recording, expected);
  AuCalibration result{.au = recording.au, .frames = take.d_mm.size()};
  if (take.d_mm.size() < kLeastFrames) {
    throw UserError(recording.place,
                    fmt::format("the head can be found in {} of {} frames, {} are needed for {}", take.d_mm.size(),
                                recording.world_mm.size(), kLeastFrames, recording.au),
                    "record it again with the stabilisers visible");
  }
  const Eigen::Matrix3Xd rest = rest_of(take);
  result.rest_mm = std::sqrt(rest.squaredNorm() / static_cast<double>(rest.cols()));
  for (std::size_t t = 0; t < take.d_mm.size(); ++t) {
    take.d_mm[t] -= rest * take.weight[t].asDiagonal();
  }
  RankOneMotion model = find_rank_one_motion(take, options.hold_share);
  shrink_to_evidence(model);
  describe(fitted, model, options, result);
  if (!(result.peak_mm >= options.least_peak_mm)) {
    throw UserError(recording.place,
                    fmt::format("{} moves no marker by more than {:.2f} mm (noise {:.2f} mm)", recording.au,
                                result.peak_mm, result.noise_mm),
                    fmt::format("record {} at its maximum, held for a second", recording.au));
  }
  column = {recording.au, model.field_mm, expected == nullptr ? RigAu{}.upper_bound : expected->upper_bound};
  return result;
}

}  // namespace

RigCalibration calibrate_rig(const Rig& fitted, const std::vector<CalibrationRecording>& recordings,
                             const RigCalibrateOptions& options) {
  if (recordings.empty()) throw UserError("calibration", "no recording of an AU", "give at least one --au NAME=TAKE");
  RigCalibration result;
  result.rig = fitted;
  result.rig.aus.clear();
  std::set<std::string> names;
  for (const CalibrationRecording& recording : recordings) {
    if (!names.insert(recording.au).second) {
      throw UserError(recording.place, fmt::format("{} is given twice", recording.au), "keep one recording per AU");
    }
    RigAu column;
    result.aus.push_back(calibrate_au(fitted, recording, options, column));
    result.rig.aus.push_back(std::move(column));
    doubt(result.aus.back(), recording.place, options, result.warnings);
  }
  compare_fields(result, options);
  return result;
}

}  // namespace risorius
