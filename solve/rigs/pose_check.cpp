#include "solve/rigs/pose_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "solve/rigs/au_name.h"

namespace risorius {
namespace {

constexpr double kLasts_s = 0.1, kRest_s = 0.3;
constexpr double kHole_s = 0.25;  // frames farther apart are no course
constexpr double kLopsided = 0.5, kRestShare = 0.5;
constexpr int kBlink = 45, kJawSideways = 30;

std::optional<std::size_t> other_side(std::span<const std::string> aus, std::size_t i) {
  const auto name = parse_au_name(aus[i]);
  if (!name || name->side == AuSide::kBoth) return std::nullopt;
  for (std::size_t j = 0; j < aus.size(); ++j) {
    const auto other = parse_au_name(aus[j]);
    if (j != i && other && other->number == name->number && other->side != AuSide::kBoth) return j;
  }
  return std::nullopt;
}

/// The least of AU `au` from frame t on, for a tenth of a second and two frames at least; nothing where that is not yet
/// past, is not observed throughout, or has a hole as long.
std::optional<double> lasting_at(std::span<const PoseFrame> frames, std::size_t t, Eigen::Index au) {
  double least = frames[t].x[au];
  for (std::size_t k = t + 1; k < frames.size(); ++k) {
    if (frames[k].time_s - frames[k - 1].time_s > kHole_s) return std::nullopt;
    least = std::min(least, frames[k].x[au]);
    if (!std::isfinite(frames[k].x[au])) return std::nullopt;
    if (frames[k].time_s - frames[t].time_s >= kLasts_s) return least;
  }
  return std::nullopt;
}

/// The frame from which on AU `au` is highest.
std::size_t lasting_peak(std::span<const PoseFrame> frames, std::size_t au, double& peak) {
  const auto i = static_cast<Eigen::Index>(au);
  std::size_t at = 0;
  peak = 0;
  for (std::size_t t = 0; t < frames.size(); ++t) {
    if (!(frames[t].x[i] > peak) || !std::isfinite(frames[t].x[i])) continue;
    const auto lasting = lasting_at(frames, t, i);
    if (lasting && *lasting > peak) peak = *lasting, at = t;
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
    const auto name = parse_au_name(aus[j]);
    if (j == au || j == other || !(x > pose.company_intensity)) continue;
    if (name && name->number == kBlink) continue;  // people blink beside everything
    pose.company = aus[j];
    pose.company_intensity = x;
  }
  pose.is_seen = pose.peak >= least_peak;
  pose.is_lopsided = other && pose.peak < kLopsided * pose.other_side_peak && pose.other_side_peak >= least_peak;
  return pose;
}

std::string verdict_of(const PoseCheck& check) {
  return !check.is_seen ? "not seen: again" : check.is_lopsided ? "weaker than the other side" : "seen";
}

std::vector<PromptedPose> prompted_poses(std::span<const std::string> aus) {
  std::vector<PromptedPose> poses;
  for (std::size_t i = 0; i < aus.size(); ++i) {
    const auto name = parse_au_name(aus[i]);
    // Nobody moves the jaw to both sides at once.
    const bool together = name && name->number != kJawSideways;
    const std::string pose = together ? format_au_name({name->number, AuSide::kBoth}) : aus[i];
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
    : aus_(std::move(aus)), pose_(std::move(pose)), options_(options), peak_(pose_.aus.size(), 0) {}

PoseWatch::State PoseWatch::add(PoseFrame frame) {
  if (!frames_.empty() && frame.time_s < frames_.back().time_s) {
    frames_.clear();
    std::ranges::fill(peak_, 0);
    frames_looked_at_ = 0;
  }
  frames_.push_back(std::move(frame));
  for (; frames_looked_at_ < frames_.size(); ++frames_looked_at_) {
    const PoseFrame& at = frames_[frames_looked_at_];
    if (frames_.back().time_s - at.time_s < kLasts_s) break;  // what follows is not known yet
    for (std::size_t k = 0; k < pose_.aus.size(); ++k) {
      const auto lasting = lasting_at(frames_, frames_looked_at_, static_cast<Eigen::Index>(pose_.aus[k]));
      if (lasting) peak_[k] = std::max(peak_[k], *lasting);
    }
  }
  const double now_s = frames_.back().time_s;
  if (frames_.size() == 1 || !rests(frames_.back())) rest_since_s_ = now_s;
  if (*std::ranges::max_element(peak_) >= options_.least_peak && now_s - rest_since_s_ >= kRest_s) return State::kOver;
  return now_s - frames_.front().time_s >= options_.longest_s ? State::kTimedOut : State::kWaiting;
}

/// An AU that is not observed does not say that it rests.
bool PoseWatch::rests(const PoseFrame& frame) const {
  for (std::size_t k = 0; k < pose_.aus.size(); ++k) {
    const double x = frame.x[static_cast<Eigen::Index>(pose_.aus[k])];
    if (!(x <= kRestShare * std::max(peak_[k], options_.least_peak))) return false;
  }
  return true;
}

std::vector<PoseCheck> PoseWatch::checks() const {
  std::vector<PoseCheck> checks;
  if (frames_.empty()) return checks;
  for (const std::size_t au : pose_.aus) checks.push_back(check_pose(aus_, frames_, au, options_.least_peak));
  return checks;
}

}  // namespace risorius
