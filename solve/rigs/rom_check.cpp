#include "solve/rigs/rom_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "capture/errors.h"
#include "solve/rigs/au_name.h"

namespace risorius {
namespace {

constexpr double kLasts_s = 0.1;
constexpr double kLopsided = 0.5;

struct Frame {
  double time_s = 0;
  Eigen::VectorXd x;
};

std::optional<std::size_t> other_side(const Rig& rig, std::size_t i) {
  const auto name = parse_au_name(rig.aus[i].name);
  if (!name || name->side == AuSide::kBoth) return std::nullopt;
  for (std::size_t j = 0; j < rig.au_count(); ++j) {
    const auto other = parse_au_name(rig.aus[j].name);
    if (j != i && other && other->number == name->number && other->side != AuSide::kBoth) return j;
  }
  return std::nullopt;
}

/// The frame at which AU i is highest, counting at each frame the least of what follows for a tenth of a second.
std::size_t lasting_peak(const std::vector<Frame>& frames, Eigen::Index i, double& peak) {
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

std::vector<PoseCheck> check_range_of_motion(const Rig& rig, const TakeFrames& take, double least_peak,
                                             const AuSolverOptions& options) {
  std::vector<Frame> frames;
  explain_take(rig, take, options, [&](const ExplainedFrame& frame) {
    const std::int64_t time_ns =
        difference_ns(take.frames[frame.index].header.capture_time_ns, take.frames.front().header.capture_time_ns);
    frames.push_back({static_cast<double>(time_ns) * 1e-9, frame.x});
  });
  if (frames.empty()) {
    throw UserError(take.place, "not one frame could be solved with this rig",
                    "is it a take of this actor; are unit and axes right?");
  }
  std::vector<PoseCheck> poses;
  for (std::size_t i = 0; i < rig.au_count(); ++i) {
    PoseCheck pose{.au = rig.aus[i].name, .other_side_peak = std::numeric_limits<double>::quiet_NaN()};
    const std::size_t at = lasting_peak(frames, static_cast<Eigen::Index>(i), pose.peak);
    pose.peak_s = frames[at].time_s;
    const auto other = other_side(rig, i);
    if (other) lasting_peak(frames, static_cast<Eigen::Index>(*other), pose.other_side_peak);
    for (std::size_t j = 0; j < rig.au_count(); ++j) {
      const double x = frames[at].x[static_cast<Eigen::Index>(j)];
      if (j == i || j == other || x <= pose.company_intensity) continue;
      pose.company = rig.aus[j].name;
      pose.company_intensity = x;
    }
    pose.is_seen = pose.peak >= least_peak;
    pose.is_lopsided = other && pose.peak < kLopsided * pose.other_side_peak && pose.other_side_peak >= least_peak;
    poses.push_back(std::move(pose));
  }
  return poses;
}

}  // namespace risorius
