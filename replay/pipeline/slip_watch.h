// Watches what a rig takes for granted while a take goes on: that the stabilisers keep their places on the skull, and
// that the face at rest stays the rig's neutral. A stabiliser that comes off or a head band that slips shows as a
// lasting change between them (an expression goes back, a slip does not); a neutral that wanders as what is left of the
// markers while no AU is on. Fed with solved frames in order; no clock of its own.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "replay/pipeline/frame_pipeline.h"
#include "solve/rigs/rig.h"

namespace risorius {

struct SlipWatchOptions {
  double settle_s = 3;         ///< the first seconds say where the stabilisers are, > 0
  double memory_s = 2;         ///< time constant of their places, > 0
  double slip_mm = 1.5;        ///< a lasting change of this much is a slip, > 0
  double lasting_s = 4;        ///< how long it must last, > 0
  double drift_memory_s = 10;  ///< time constant of the neutral's wandering, > 0
  double rest_mm = 1;          ///< the face is at rest where its AUs move the markers less (rms), > 0
};

struct Slip {
  std::string marker;  ///< empty: the stabilisers together against the face (a head band)
  double time_s = 0;   ///< since the first frame, when it began
  double moved_mm = 0;
};

/// At one moment of the take.
struct DriftSample {
  double time_s = 0;
  double stabiliser_mm = 0;  ///< the largest lasting change of a stabiliser
  double neutral_mm = 0;     ///< rms over markers: the face at rest against the neutral; NaN before it was at rest
  double band_mm = 0;        ///< the part of it that is the whole face moving against the stabilisers
};

class SlipWatch {
 public:
  SlipWatch(const Rig& rig, const MarkerSet& set, const SlipWatchOptions& options = {});

  /// Frames in the order of their times; those without AUs count as time that passes.
  void add(const SolvedFrame& frame);

  const std::vector<Slip>& slips() const noexcept { return slips_; }
  /// About one a second.
  const std::vector<DriftSample>& history() const noexcept { return history_; }
  const DriftSample& now() const noexcept { return now_; }

 private:
  struct Stabiliser {
    std::size_t marker = 0;  // of the rig
    Eigen::Vector3d settled_mm = Eigen::Vector3d::Zero(), place_mm = Eigen::Vector3d::Zero();
    double settled_count = 0, off_since_s = -1;
    bool has_place = false, has_slipped = false;
  };

  void follow_stabilisers(const SolvedFrame& frame, double step_s);
  void follow_neutral(const SolvedFrame& frame, double step_s);
  void note(Stabiliser* stabiliser, double off_mm, double& off_since_s, bool& has_slipped);

  Rig rig_;
  SlipWatchOptions options_;
  std::vector<int> set_index_;
  std::vector<Stabiliser> stabilisers_;
  std::vector<Eigen::Vector3d> seen_mm_, neutral_mm_;  // M
  std::vector<double> weight_;                         // M
  Eigen::Matrix3Xd drift_mm_;                          // 3 x M
  Eigen::VectorXd drift_count_;                        // M
  double band_off_since_s_ = -1, band_settled_mm_ = -1;
  bool band_has_slipped_ = false;
  std::int64_t first_ns_ = 0, last_ns_ = 0;
  bool has_first_ = false;
  DriftSample now_;
  std::vector<Slip> slips_;
  std::vector<DriftSample> history_;
};

}  // namespace risorius
