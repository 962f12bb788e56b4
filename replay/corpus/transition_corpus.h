// Transitions: stretches of motion between two still poses, cut out of recorded AU series, or performed between two
// expressions. What the Expression-Generator learns and is measured on.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "replay/corpus/au_recording.h"

namespace risorius {

/// A face is still while no AU but the lids' moves faster than `most_speed`, measured over `window_s` around.
struct StillnessOptions {
  double most_speed = 0.3;      ///< intensity per second, (0, 10]
  double window_s = 1.0 / 15;   ///< of the central difference: two frames at 30 Hz
  double least_still_s = 0.05;  ///< [0, 10]: a shorter rest is a passage, no pose
  double least_change = 0.1;    ///< (0, 1]: what some AU but the lids' must have changed from pose to pose
  Eigen::Index least_frames = 41, most_frames = 402;  ///< of a transition; seed 003's shortest and longest
};

/// Frames of the past that stand before a transition.
inline constexpr Eigen::Index kTransitionPastFrames = 20;

enum class CorpusPart : std::uint8_t { kTrain, kValidation, kTest };

struct Transition {
  std::string take;      ///< where it was cut from
  std::string from, to;  ///< expressions; empty where nobody named them
  std::size_t variant = 0;
  /// What must stay on one side of a split: copies of one performance share it.
  std::string sibling;
  CorpusPart part = CorpusPart::kTrain;
  /// How far some AU but the lids' goes beyond both its ends on the way: large where the face passes through a third
  /// pose without resting there.
  float stray = 0;
  double begin_s = 0;  ///< in its take: the time of the last row of `past`
  AuMatrix past;       ///< kTransitionPastFrames x AUs; the last row is the pose that is left
  AuMatrix course;     ///< N x AUs; the last row is the pose that is reached
};

struct TransitionCorpus {
  std::vector<std::string> names;  ///< AUs
  double rate_hz = kCorpusRateHz;
  std::vector<Transition> transitions;
};

/// Frames at which the face is still, one flag per row. Lids (AU43, AU45) do not count.
std::vector<bool> still_frames(const AuMotion& motion, const StillnessOptions& options = {});

/// All transitions of a motion. Each goes from the last still frame of a pose to the first of the next. A take is
/// divided into blocks of `block_s`, of which every fifth goes to the test and every fifth to validation.
TransitionCorpus cut_transitions(const AuMotion& motion, const StillnessOptions& options = {}, double block_s = 10);

/// The same AUs for all: transitions of `from` are appended, with its columns taken by name; an AU that `from` does not
/// have stays 0.
void append(TransitionCorpus& to, const TransitionCorpus& from);

/// Transition::stray of a course that starts at `start` (1 x AUs).
float stray_of(const std::vector<std::string>& names, const Eigen::RowVectorXf& start, const AuMatrix& course);

/// Those of one part.
std::vector<const Transition*> part_of(const TransitionCorpus& corpus, CorpusPart part);

}  // namespace risorius
