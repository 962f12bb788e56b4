// The synthetic performer: a seeded face on a rig, with exact ground truth. Expressions, speech and blinks
// (performer_script.h) drive E = E0 + sum x_i e_i; the head sways; the markers are occluded, confused and noisy
// (marker_defects.h). The same options give the same bits on one machine; the AUs and poses do not depend on the
// defects.
#pragma once

#include <array>
#include <cstdint>

#include "replay/performer/marker_defects.h"
#include "replay/performer/performer_script.h"
#include "replay/takes/take.h"
#include "solve/rigs/rig.h"

namespace risorius {

struct PerformerOptions {
  std::uint64_t seed = 1;
  double rate_hz = 120;              ///< 1 to 2000
  double seconds = 60;               ///< above 0, at most 86400
  double noise_mm = 0.1;             ///< standard deviation per axis, 0 to 10
  double occlusion_share = 0.03;     ///< of all samples, 0 to 0.5
  double false_track_share = 0.005;  ///< of the visible samples, 0 to 0.2
  double head_motion = 1;            ///< 0 (still) to 3; 1 sways by up to 8 mm and 5 degrees
};

/// A performance as it goes on, frame by frame.
class Performance {
 public:
  /// Throws std::invalid_argument: options out of range, a rig without markers or AUs or beyond the frames' capacity.
  explicit Performance(Rig rig, const PerformerOptions& options = {});

  /// False at the end. `observed`: what a tracker would send. `truth`: AUs of the rig and head pose. `clean`: all
  /// marker positions as they truly are; its states say what became of the observed sample: kMeasured true, kMissing
  /// occluded, kRejected false, with the reason. Allocates nothing.
  bool next(MarkerFrame& observed, AuFrame& truth, MarkerFrame& clean) noexcept;
  void rewind();

  std::uint64_t frame_count() const noexcept { return frame_count_; }
  const Rig& rig() const noexcept { return rig_; }
  const PerformerOptions& options() const noexcept { return options_; }
  /// The markers' names, rate and axes; set id 1.
  MarkerSet marker_set() const;

 private:
  /// One coordinate of the head's sway: three slow sines.
  struct Sway {
    std::array<double, 3> amplitude{}, frequency_hz{}, phase{};
    double at(double time_s) const noexcept;
  };

  Pose pose_at(double time_s) const noexcept;

  Rig rig_;
  Eigen::Matrix3Xd head_mm_;  ///< 3 x M, of the frame at hand
  PerformerOptions options_;
  std::uint64_t frame_count_;
  std::uint64_t next_index_ = 0;
  PerformerScript script_;
  MarkerDefects defects_;
  std::array<Sway, 6> sway_;  ///< x, y, z in mm; pitch, yaw, roll in radians
};

/// A performance as a take, so that the built-in face streams like a file. Its path is "builtin".
class PerformerTake : public TakeReader {
 public:
  explicit PerformerTake(Rig rig, const PerformerOptions& options = {});

  const TakeInfo& info() const noexcept override { return info_; }
  bool next(MarkerFrame& frame) override { return performance_.next(frame, truth_, clean_); }
  void rewind() override { performance_.rewind(); }
  /// Of the frame that was read last.
  const AuFrame& truth() const noexcept { return truth_; }
  const MarkerFrame& clean() const noexcept { return clean_; }

 private:
  Performance performance_;
  TakeInfo info_;
  AuFrame truth_;
  MarkerFrame clean_;
};

}  // namespace risorius
