#include "daemon/slip_monitor.h"

#include <cmath>
#include <fmt/format.h>

namespace risorius {
namespace {

/// Slips and drifts take seconds: more frames than this tell nothing more. A little less than 1/60 s, so that a stream
/// of 60 Hz with jitter is taken whole.
constexpr std::int64_t kLeastStepNs = 15'000'000;

}  // namespace

void SlipMonitor::take(const OutputItem& item) {
  switch (item.kind) {
    case OutputItem::Kind::kMarkerSet:
      markers_ = *item.marker_set;
      watch_.reset();
      break;
    case OutputItem::Kind::kNeutral:
    case OutputItem::Kind::kEndOfStream:
      watch_.reset();
      break;
    case OutputItem::Kind::kSolved:
      look_at(item.solved);
      break;
    case OutputItem::Kind::kRecordingStarted:
    case OutputItem::Kind::kRecordingStopped:
      break;
  }
}

void SlipMonitor::look_at(const SolvedFrame& frame) {
  // Without a marker set it is a stream of face shapes; without AUs the rig does not fit.
  if (!markers_ || frame.markers.count != markers_->names.size()) return;
  const std::int64_t time_ns = frame.markers.header.capture_time_ns;
  if (!watch_) {
    watch_.emplace(current_rig_(), *markers_);
    slips_told_ = 0;
  } else if (const std::int64_t step_ns = difference_ns(time_ns, last_fed_ns_);
             step_ns >= 0 && step_ns < kLeastStepNs) {
    return;
  }
  last_fed_ns_ = time_ns;
  watch_->add(frame);
  const DriftSample& now = watch_->now();
  const std::scoped_lock lock(mutex_);
  state_.stabiliser_mm = now.stabiliser_mm;
  state_.band_mm = now.band_mm;
  state_.neutral_mm = std::isfinite(now.neutral_mm) ? now.neutral_mm : 0;
  for (; slips_told_ < watch_->slips().size(); ++slips_told_) {
    const Slip& slip = watch_->slips()[slips_told_];
    ++state_.count;
    state_.last = fmt::format("{} slipped by {:.1f} mm at {:.1f} s of its take",
                              slip.marker.empty() ? "the head band, or all stabilisers," : slip.marker, slip.moved_mm,
                              slip.time_s);
  }
}

SlipMonitor::State SlipMonitor::state() const {
  const std::scoped_lock lock(mutex_);
  return state_;
}

}  // namespace risorius
