// The synthetic performer: a seeded face on a rig, with exact ground truth. A script (performer_script.h) or a recorded
// AU series drives a true face, which is the rig or a perturbed one (truth_model.h); the head wanders; the markers are
// occluded, confused and noisy (marker_defects.h). The same options give the same bits on one machine; the AUs and
// poses do not depend on the defects.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "replay/performer/au_wander.h"
#include "replay/performer/head_motion.h"
#include "replay/performer/marker_defects.h"
#include "replay/performer/performer_script.h"
#include "replay/performer/truth_model.h"
#include "replay/takes/au_timeline.h"
#include "replay/takes/take.h"
#include "solve/rigs/rig.h"

namespace risorius {

struct PerformerOptions {
  std::uint64_t seed = 1;
  double rate_hz = 120;              ///< 1 to 2000
  double seconds = 60;               ///< above 0, at most 86400; 0: as long as the script's list or the series is
  double noise_mm = 0.1;             ///< standard deviation per axis, 0 to 10
  double occlusion_share = 0.03;     ///< of all samples, 0 to 0.5
  double false_track_share = 0.005;  ///< of the visible samples, 0 to 0.2
  double head_motion = 1;            ///< 0 (still) to 3; 1 sways by up to 8 mm and 5 degrees
  double micro_motion = 1;           ///< 0 (none) to 3, of what the dynamics table says; none over a recorded series
  ScriptKind script = ScriptKind::kMixed;
  bool co_activation = true;      ///< in range of motion
  double amplitude = 2;           ///< of range of motion, 0.1 to 4: a phone's full scale is seldom reached, a rig's is
  double coloured_noise_mm = 0;   ///< standard deviation per axis, 0 to 10
  double regions_per_minute = 0;  ///< occluded regions, 0 to 60
  PerturbOptions perturb;         ///< of the true face; the rig of rig() stays as it was given
};

/// A performance as it goes on, frame by frame.
class Performance {
 public:
  /// Throws std::invalid_argument: options out of range, a rig without markers or AUs or beyond the frames' capacity.
  explicit Performance(Rig rig, const PerformerOptions& options = {});
  /// Driven by a recorded series of the rig's AUs instead of a script; intensities are clipped to the rig's bounds.
  Performance(Rig rig, AuTimeline series, const PerformerOptions& options = {});

  /// False at the end. `observed`: what a tracker would send. `truth`: AUs of the rig and head pose. `clean`: all
  /// marker positions as they truly are; its states say what became of the observed sample: kMeasured true, kMissing
  /// occluded, kRejected false, with the reason. Allocates nothing.
  bool next(MarkerFrame& observed, AuFrame& truth, MarkerFrame& clean) noexcept;
  void rewind();

  /// What became of each marker in the last frame.
  std::span<const DefectCause> causes() const noexcept { return defects_.causes(); }
  std::uint64_t frame_count() const noexcept { return frame_count_; }
  const Rig& rig() const noexcept { return rig_; }
  /// The face that the markers really sit on.
  const Rig& true_rig() const noexcept { return model_.rig(); }
  const PerformerOptions& options() const noexcept { return options_; }
  /// Null where a series drives the face.
  const PerformerScript* script() const noexcept { return script_ ? &*script_ : nullptr; }
  /// The markers' names, rate and axes; set id 1.
  MarkerSet marker_set() const;

 private:
  Performance(Rig rig, std::optional<AuTimeline> series, std::optional<PerformerScript> script,
              const PerformerOptions& options);

  Rig rig_;
  PerformerOptions options_;
  std::optional<AuTimeline> series_;
  std::optional<PerformerScript> script_;
  std::uint64_t frame_count_;
  std::uint64_t next_index_ = 0;
  std::vector<double> upper_;
  AuWander wander_;
  HeadMotion head_;
  TruthModel model_;
  MarkerDefects defects_;
  Eigen::Matrix3Xd head_mm_;  ///< 3 x M, of the frame at hand
};

/// A performance as a take, so that the built-in face streams like a file. Its path is "builtin".
class PerformerTake : public TakeReader {
 public:
  explicit PerformerTake(Rig rig, const PerformerOptions& options = {});
  explicit PerformerTake(Performance performance);

  const TakeInfo& info() const noexcept override { return info_; }
  bool next(MarkerFrame& frame) override { return performance_.next(frame, truth_, clean_); }
  void rewind() override { performance_.rewind(); }
  /// Of the frame that was read last.
  const AuFrame& truth() const noexcept { return truth_; }
  const MarkerFrame& clean() const noexcept { return clean_; }
  const Performance& performance() const noexcept { return performance_; }

 private:
  Performance performance_;
  TakeInfo info_;
  AuFrame truth_;
  MarkerFrame clean_;
};

}  // namespace risorius
