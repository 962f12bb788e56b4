// Finds measured positions that are false and marks them kRejected with a reason; it never changes a position.
// kDisplacement is the method of the seed 000 paper: too fast between two frames, in world coordinates.
// kHeadFrame (default) judges in the head's frame, so that head motion raises no alarm: a marker is false if it is
// implausibly fast, or if it strays from where the other markers and its own past expect it by more than a robust
// multiple of what it usually strays, while its neighbours do not stray alike. The worst is taken out first, then the
// rest are judged again without it. A rejected marker is taken back as soon as it is plausible, or when it has stayed
// where it is for accept_after_ns (it was relabelled, or slipped).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "capture/counters.h"
#include "capture/marker_set.h"
#include "capture/repair/frame_clock.h"
#include "capture/repair/head_frame.h"
#include "capture/repair/marker_statistics.h"
#include "capture/repair/neighbour_graph.h"

namespace risorius {

enum class DespikeMethod : std::uint8_t { kNone, kDisplacement, kHeadFrame };

struct DespikerOptions {
  DespikeMethod method = DespikeMethod::kHeadFrame;
  double max_speed_mm_s = 1000;     ///< of a marker: in the world (kDisplacement), about the head (kHeadFrame); > 0
  double deviation_multiple = 8;    ///< times the usual straying (standard deviation per axis), >= 3
  double least_deviation_mm = 2.5;  ///< nearer than this to the expected place nothing is rejected, > 0
  double most_deviation_mm = 10;    ///< farther than this everything is rejected, >= least_deviation_mm
  std::int64_t accept_after_ns = 500'000'000;  ///< > 0
  HeadFrameOptions head_frame;
  MarkerStatisticsOptions statistics;
};

class Despiker {
 public:
  /// Throws UserError for an option out of its range.
  explicit Despiker(DespikerOptions options = {});

  /// A set begins or changes; allocates. State stays with markers of the same name.
  /// Throws UserError if the set itself is not valid (problems_of). A frame held at that moment is kept.
  void use_marker_set(const MarkerSet& set);
  /// A new take of the same set: forgets everything but the counters. A held frame is dropped and counted.
  void reset() noexcept;

  /// A frame whose count is not the set's is consumed and refused. False only while a frame waits to be popped.
  bool push(const MarkerFrame& frame) noexcept;
  bool pop(MarkerFrame& frame) noexcept;
  /// Learns from the frame last pushed (capture/stage.h).
  void settle() noexcept;
  void tick(Tick) noexcept {}
  /// Nothing is delayed here: what was pushed can be popped at once, before and after a flush.
  void flush() noexcept {}

  /// What was found out about the frame last pushed, rejected markers hidden; for the stage behind. kHeadFrame only.
  bool has_model() const noexcept { return options_.method == DespikeMethod::kHeadFrame; }
  const HeadFrame& head() const noexcept { return head_; }
  const MarkerStatistics& statistics() const noexcept { return statistics_; }

  const StageLedger& ledger() const noexcept { return ledger_; }
  /// Marker samples rejected for this reason.
  const Counter& rejected(RejectReason reason) const noexcept { return rejected_[static_cast<std::size_t>(reason)]; }

 private:
  struct Track {
    Eigen::Vector3d accepted_mm =
        Eigen::Vector3d::Zero();  ///< last accepted position, head frame (kDisplacement: world)
    Eigen::Vector3d rejected_mm = Eigen::Vector3d::Zero();  ///< last rejected position
    Eigen::Vector3d offset_mm = Eigen::Vector3d::Zero();    ///< usual residual of late: the expected one
    double straying_mm2 = 0;                                ///< of the residual from the offset, per axis
    double residual_mm2 = 0;                                ///< of the residual itself, per axis
    double samples = 0;
    double unseen_s = 0;  ///< since the last accepted sample
    double stayed_s = 0;  ///< how long the rejected position has been steady
    bool started = false;
  };

  void process(MarkerFrame& frame) noexcept;
  void process_displacement(MarkerFrame& frame) noexcept;
  void find_false_markers() noexcept;
  void take_back_plausible() noexcept;
  void accept_or_reject(MarkerFrame& frame) noexcept;
  bool relabelled(std::size_t i) noexcept;
  void learn(std::size_t i) noexcept;
  Eigen::Vector3d stray_mm(std::size_t i) const noexcept;
  double allowed_mm(std::size_t i) const noexcept;
  bool too_fast(std::size_t i) const noexcept;
  bool neighbours_stray_alike(std::size_t i) const noexcept;
  RejectReason reason_of(std::size_t i) const noexcept;
  void reject(MarkerFrame& frame, std::size_t i, RejectReason reason) noexcept;

  DespikerOptions options_;
  MarkerSet set_;
  HeadFrame head_;
  MarkerStatistics statistics_;
  NeighbourGraph neighbours_;
  std::vector<Track> tracks_;
  std::vector<std::uint8_t> trusted_;
  FrameClock clock_;
  double step_s_ = 0;       ///< from the frame before the one last pushed
  bool is_settled_ = true;  ///< the frame last pushed has been learnt from
  std::uint32_t frames_to_renewal_ = 0;
  MarkerFrame waiting_;
  bool has_waiting_ = false;
  StageLedger ledger_;
  std::array<Counter, 7> rejected_;
};

}  // namespace risorius
