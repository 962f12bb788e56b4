// One pose of a range of motion: how high an AU gets and stays, whether the other side follows, and what moves beside
// it. Of a take (rom_check.h) or live, while the actor stands before the cameras and can do it again (PoseWatch).
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace risorius {

/// All AUs at one time.
struct PoseFrame {
  double time_s = 0;
  Eigen::VectorXd x;  ///< K; NaN where not observed
};

struct PoseCheck {
  std::string au;
  double peak = 0;             ///< the highest intensity that lasts for a tenth of a second, over two frames at least
  double peak_s = 0;           ///< when, by the frames' clock
  double other_side_peak = 0;  ///< of the other side's AU; NaN where there is none
  std::string company;         ///< the strongest AU beside it (the other side left out) at its peak
  double company_intensity = 0;
  bool is_seen = false;      ///< it reaches `least_peak`
  bool is_lopsided = false;  ///< it is less than half of the other side
};

/// Of AU number `au` of `aus` (K names). At least one frame, in order.
PoseCheck check_pose(std::span<const std::string> aus, std::span<const PoseFrame> frames, std::size_t au,
                     double least_peak);

/// "seen", "not seen: again", or "weaker than the other side".
std::string verdict_of(const PoseCheck& check);

/// A pose as it is asked for: an AU, both sides of it together where a face can do that.
struct PromptedPose {
  std::string name;              ///< "AU12", "AU30L"
  std::vector<std::size_t> aus;  ///< one, or left and right, as numbers into the names
};

/// In the order of the names. Names without a FACS number are poses of their own.
std::vector<PromptedPose> prompted_poses(std::span<const std::string> aus);

struct PoseWatchOptions {
  double least_peak = 0.4;  ///< what counts as seen, (0, 1.2]
  double longest_s = 20;    ///< then it is called not seen, > 0
};

/// Sees a pose come and go. It is over when one of its AUs had a lasting peak of `least_peak` and all of them have been
/// observed below half of their peaks for 0.3 s.
class PoseWatch {
 public:
  enum class State : std::uint8_t { kWaiting, kOver, kTimedOut };

  PoseWatch(std::vector<std::string> aus, PromptedPose pose, const PoseWatchOptions& options = {});

  /// Where time goes back (the tracker began anew), so does the watch.
  State add(PoseFrame frame);

  /// Of the pose's AUs, by all frames so far; none before the first.
  std::vector<PoseCheck> checks() const;
  std::span<const PoseFrame> frames() const noexcept { return frames_; }

 private:
  bool rests(const PoseFrame& frame) const;

  std::vector<std::string> aus_;
  PromptedPose pose_;
  PoseWatchOptions options_;
  std::vector<PoseFrame> frames_;
  std::vector<double> peak_;  ///< of the pose's AUs so far, lasting
  std::size_t frames_looked_at_ = 0;
  double rest_since_s_ = 0;
};

}  // namespace risorius
