// Fills missing and rejected markers, causally and without look-ahead: a frame goes in, the same frame comes out.
// Default: what the visible markers say (low-rank statistics in the head's frame) plus a forecast of the marker's own
// residual, learnt per lag, with the error that such forecasts had. Measured samples leave bit-equal.
// A gap longer than max_gap_ns stays missing from there on; so does a marker that was never seen.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "capture/counters.h"
#include "capture/marker_set.h"
#include "capture/repair/frame_clock.h"
#include "capture/repair/gap_baselines.h"
#include "capture/repair/head_frame.h"
#include "capture/repair/marker_statistics.h"
#include "capture/repair/residual_memory.h"

namespace risorius {

enum class FillMethod : std::uint8_t { kNone, kHold, kDampedVelocity, kLowRank };

struct GapFillerOptions {
  FillMethod method = FillMethod::kLowRank;
  std::int64_t max_gap_ns = 2'000'000'000;  ///< > 0
  HeadFrameOptions head_frame;
  MarkerStatisticsOptions statistics;
};

class GapFiller {
 public:
  /// Throws UserError for an option out of its range.
  explicit GapFiller(GapFillerOptions options = {});

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

  const StageLedger& ledger() const noexcept { return ledger_; }
  /// Marker samples filled, by the reason for which they had been rejected (kNone: they were missing).
  const Counter& filled(RejectReason reason) const noexcept { return filled_[static_cast<std::size_t>(reason)]; }
  /// Marker samples left without a position: gap too long, or never seen.
  const Counter& left_missing() const noexcept { return left_missing_; }

 private:
  struct Fill {
    Eigen::Vector3d position_head_mm;
    double variance_mm2;
  };
  void process(MarkerFrame& frame) noexcept;
  void fill(MarkerFrame& frame, std::size_t i) noexcept;
  Fill estimate(std::size_t i) const noexcept;

  GapFillerOptions options_;
  MarkerSet set_;
  HeadFrame head_;
  MarkerStatistics statistics_;
  ResidualMemory residuals_;
  std::vector<HeldMarker> held_;
  FrameClock clock_;
  double step_s_ = 0;         ///< from the frame before the one last pushed
  bool is_informed_ = false;  ///< the frame last pushed showed enough of the face to learn from
  bool is_settled_ = true;    ///< the frame last pushed has been learnt from
  MarkerFrame waiting_;
  bool has_waiting_ = false;
  StageLedger ledger_;
  std::array<Counter, 7> filled_;
  Counter left_missing_;
};

}  // namespace risorius
