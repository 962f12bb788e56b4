#include "solve/rigs/rig_calibrate.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <set>

#include "capture/errors.h"
#include "solve/rigs/au_name.h"
#include "solve/rigs/rank_one_motion.h"
#include "solve/rigs/recording_heads.h"

namespace risorius {
namespace {

constexpr std::size_t kLeastFrames = 10;
constexpr int kHeadRounds = 3;
constexpr double kMostPeakMm = 80;  // of a marker; a jaw opened as far as it goes carries the chin 40 to 50 mm
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

/// The recorded movement, with the rest that it begins and ends with.
struct Recorded {
  Eigen::Matrix3Xd rest_mm;
  RankOneMotion motion;
};

Recorded movement_of(const RecordingHeads& heads, double hold_share) {
  Displacements take = heads.displacements();
  Recorded recorded{rest_of(take), {}};
  for (std::size_t t = 0; t < take.d_mm.size(); ++t) {
    take.d_mm[t] -= recorded.rest_mm * take.weight[t].asDiagonal();
  }
  recorded.motion = find_rank_one_motion(take, hold_share);
  return recorded;
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
  RecordingHeads heads(fitted, recording.world_mm, expected);
  AuCalibration result{.au = recording.au, .frames = heads.frame_count()};
  if (result.frames < kLeastFrames) {
    throw UserError(recording.place,
                    fmt::format("the head can be found in {} of {} frames, {} are needed for {}", result.frames,
                                recording.world_mm.size(), kLeastFrames, recording.au),
                    "record it again with the stabilisers visible");
  }
  Recorded recorded = movement_of(heads, options.hold_share);
  for (int round = 0; round < kHeadRounds; ++round) {
    recorded.motion.field_mm = heads.without_head_motion(recorded.motion.field_mm);
    heads.align_to(recorded.rest_mm, recorded.motion);
    recorded = movement_of(heads, options.hold_share);
  }
  result.rest_mm = std::sqrt(recorded.rest_mm.squaredNorm() / static_cast<double>(recorded.rest_mm.cols()));
  RankOneMotion& model = recorded.motion;
  shrink_to_evidence(model);
  describe(fitted, model, options, result);
  if (!(result.peak_mm >= options.least_peak_mm)) {
    throw UserError(recording.place,
                    fmt::format("{} moves no marker by more than {:.2f} mm (noise {:.2f} mm)", recording.au,
                                result.peak_mm, result.noise_mm),
                    fmt::format("record {} at its maximum, held for a second", recording.au));
  }
  if (result.peak_mm > kMostPeakMm) {
    throw UserError(recording.place,
                    fmt::format("{} moves marker {} by {:.0f} mm, farther than any face can", recording.au,
                                result.peak_marker, result.peak_mm),
                    "were labels exchanged? risorius clean mends swaps; is the unit right?");
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
