#include "solve/rigs/pose_check.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "solve/rigs/au_name.h"

namespace risorius {
namespace {

constexpr double kLasts_s = 0.1, kRest_s = 0.3;
constexpr double kLopsided = 0.5, kRestShare = 0.5;

std::optional<std::size_t> other_side(std::span<const std::string> aus, std::size_t i) {
  const auto name = parse_au_name(aus[i]);
  if (!name || name->side == AuSide::kBoth) return std::nullopt;
  for (std::size_t j = 0; j < aus.size(); ++j) {
    const auto other = parse_au_name(aus[j]);
    if (j != i && other && other->number == name->number && other->side != AuSide::kBoth) return j;
  }
  return std::nullopt;
}

/// The frame at which AU i is highest, counting at each frame the least of what follows for a tenth of a second.
std::size_t lasting_peak(std::span<const PoseFrame> frames, std::size_t au, double& peak) {
  const auto i = static_cast<Eigen::Index>(au);
  std::size_t at = 0;
  peak = 0;
  for (std::size_t t = 0; t < frames.size(); ++t) {
    if (frames[t].x[i] <= peak) continue;
    double least = frames[t].x[i];
    for (std::size_t k = t; k < frames.size() && frames[k].time_s - frames[t].time_s <= kLasts_s; ++k) {
      least = std::min(least, frames[k].x[i]);
    }
    if (least > peak) peak = least, at = t;
  }
  return at;
}

}  // namespace

PoseCheck check_pose(std::span<const std::string> aus, std::span<const PoseFrame> frames, std::size_t au,
                     double least_peak) {
  PoseCheck pose{.au = aus[au], .other_side_peak = std::numeric_limits<double>::quiet_NaN()};
  const std::size_t at = lasting_peak(frames, au, pose.peak);
  pose.peak_s = frames[at].time_s;
  const auto other = other_side(aus, au);
  if (other) lasting_peak(frames, *other, pose.other_side_peak);
  for (std::size_t j = 0; j < aus.size(); ++j) {
    const double x = frames[at].x[static_cast<Eigen::Index>(j)];
    if (j == au || j == other || x <= pose.company_intensity) continue;
    pose.company = aus[j];
    pose.company_intensity = x;
  }
  pose.is_seen = pose.peak >= least_peak;
  pose.is_lopsided = other && pose.peak < kLopsided * pose.other_side_peak && pose.other_side_peak >= least_peak;
  return pose;
}

std::string verdict_of(const PoseCheck& check) {
  return !check.is_seen ? "not seen: again" : check.is_lopsided ? "weaker than the other side" : "";
}

std::vector<PromptedPose> prompted_poses(std::span<const std::string> aus) {
  std::vector<PromptedPose> poses;
  for (std::size_t i = 0; i < aus.size(); ++i) {
    const auto name = parse_au_name(aus[i]);
    const std::string pose = name ? format_au_name({name->number, AuSide::kBoth}) : aus[i];
    const auto found = std::ranges::find(poses, pose, &PromptedPose::name);
    if (found == poses.end()) {
      poses.push_back({pose, {i}});
    } else {
      found->aus.push_back(i);
    }
  }
  return poses;
}

PoseWatch::PoseWatch(std::vector<std::string> aus, PromptedPose pose, const PoseWatchOptions& options)
    : aus_(std::move(aus)),
      pose_(std::move(pose)),
      options_(options),
      highest_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(pose_.aus.size()))) {}

PoseWatch::State PoseWatch::add(PoseFrame frame) {
  if (!frames_.empty() && frame.time_s < frames_.back().time_s) return State::kWaiting;
  bool rests = true;
  for (std::size_t k = 0; k < pose_.aus.size(); ++k) {
    double& highest = highest_[static_cast<Eigen::Index>(k)];
    const double x = frame.x[static_cast<Eigen::Index>(pose_.aus[k])];
    highest = std::max(highest, x);
    rests = rests && x <= kRestShare * std::max(highest, options_.least_peak);
  }
  if (!rests) rest_since_s_ = frame.time_s;
  if (frames_.empty()) rest_since_s_ = frame.time_s;
  frames_.push_back(std::move(frame));
  const double now_s = frames_.back().time_s;
  if (highest_.maxCoeff() >= options_.least_peak && now_s - rest_since_s_ >= kRest_s && is_over()) return State::kOver;
  return now_s - frames_.front().time_s >= options_.longest_s ? State::kTimedOut : State::kWaiting;
}

/// A leap of one frame is no pose.
bool PoseWatch::is_over() const {
  return std::ranges::any_of(
      pose_.aus, [&](std::size_t au) { return check_pose(aus_, frames_, au, options_.least_peak).is_seen; });
}

std::vector<PoseCheck> PoseWatch::checks() const {
  std::vector<PoseCheck> checks;
  if (frames_.empty()) return checks;
  for (const std::size_t au : pose_.aus) checks.push_back(check_pose(aus_, frames_, au, options_.least_peak));
  return checks;
}

}  // namespace risorius
