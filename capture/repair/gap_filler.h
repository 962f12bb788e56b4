// Fills missing and rejected markers, causally: a frame goes in, the same frame comes out, lookahead_frames later.
// Default: what the visible markers say (how markers move together in the head's frame) plus a forecast of the marker's
// own residual, learnt per lag, with the error that such forecasts had. Measured samples leave bit-equal.
// With look-ahead, a marker that comes back tells how far off its fill had gone, and the last lookahead_frames of the
// fill are led there, so that it is met without a step; the frames wait so long.
// A gap longer than max_gap_ns stays missing from there on; so does a marker that was never seen.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "capture/counters.h"
#include "capture/marker_set.h"
#include "capture/repair/baselines/held_marker.h"
#include "capture/repair/fill_model.h"
#include "capture/repair/fill_rehearsal.h"
#include "capture/repair/frame_clock.h"
#include "capture/repair/head_frame.h"

namespace risorius {

enum class FillMethod : std::uint8_t { kNone, kHold, kDampedVelocity, kCovariance };

struct GapFillerOptions {
  FillMethod method = FillMethod::kCovariance;
  std::int64_t max_gap_ns = 2'000'000'000;  ///< > 0
  std::uint32_t lookahead_frames = 0;       ///< that every frame waits for later ones, 0 to 64
  HeadFrameOptions head_frame;
  MarkerCovarianceOptions covariance;
  std::shared_ptr<const KnownMotion> known_motion;  ///< such as a rig's; null: only what is seen
};

class Despiker;

class GapFiller {
 public:
  /// Throws UserError for an option out of its range.
  explicit GapFiller(GapFillerOptions options = {});

  /// A set begins or changes; allocates. State stays with markers of the same name.
  /// Throws UserError if the set itself is not valid (problems_of). A frame held at that moment is kept.
  void use_marker_set(const MarkerSet& set);
  /// A new take of the same set: forgets everything but the counters. A held frame is dropped and counted.
  void reset() noexcept;

  /// A frame whose count is not the set's is consumed and refused. False only while a frame waits to be popped. Where a
  /// set begins while frames look ahead, flush and pop first, or they are dropped and counted.
  bool push(const MarkerFrame& frame) noexcept;
  /// The same for the frame that `despiker` has just handed on: its head pose is used instead of being found out once
  /// more. Frames of one take go all through this or all through the other.
  bool push(const MarkerFrame& frame, const Despiker& despiker) noexcept;
  bool pop(MarkerFrame& frame) noexcept;
  /// Learns from the frame last pushed (capture/stage.h).
  void settle() noexcept;
  void tick(Tick) noexcept {}
  /// What looks ahead waits no longer.
  void flush() noexcept { is_flushing_ = true; }

  const StageLedger& ledger() const noexcept { return ledger_; }
  std::uint32_t lookahead_frames() const noexcept { return options_.lookahead_frames; }
  /// Marker samples filled, by the reason for which they had been rejected (kNone: they were missing).
  const Counter& filled(RejectReason reason) const noexcept { return filled_[static_cast<std::size_t>(reason)]; }
  /// Marker samples left without a position: gap too long, or never seen.
  const Counter& left_missing() const noexcept { return left_missing_; }

 private:
  bool take_in(const MarkerFrame& frame, const Despiker* despiker) noexcept;
  bool look_at(const MarkerFrame& frame, const Despiker* despiker) noexcept;
  void process(MarkerFrame& frame, const Despiker* despiker) noexcept;
  void fill(MarkerFrame& frame, std::size_t i) noexcept;
  void leave_missing(MarkerFrame& frame, std::size_t i) noexcept;
  MarkerFrame& back(std::size_t frames_ago) noexcept;
  void drop_waiting() noexcept;
  bool is_ready() const noexcept { return waiting_ > (is_flushing_ ? 0 : options_.lookahead_frames); }
  void lead_home(const MarkerFrame& frame, std::size_t i) noexcept;
  MarkerFill estimate(std::size_t i) noexcept;

  GapFillerOptions options_;
  MarkerSet set_;
  HeadFrame own_head_;                  ///< without a despiker's
  const HeadFrame* head_ = &own_head_;  ///< of the frame being processed
  FillModel model_;
  FillRehearsal rehearsal_;
  std::vector<std::uint8_t> measured_;  ///< in the frame last pushed
  std::vector<HeldMarker> held_;
  FrameClock clock_;
  double step_s_ = 0;              ///< from the frame before the one last pushed
  bool owns_head_ = true;          ///< the frame last pushed came without a despiker
  bool is_informed_ = false;       ///< the frame last pushed showed enough of the face to learn from
  bool is_settled_ = true;         ///< the frame last pushed has been learnt from
  std::vector<MarkerFrame> ring_;  ///< lookahead_frames + 1
  std::size_t oldest_ = 0, waiting_ = 0;
  bool is_flushing_ = false;
  StageLedger ledger_;
  std::array<Counter, 7> filled_;
  Counter left_missing_;
};

}  // namespace risorius
