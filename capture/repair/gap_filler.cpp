#include "capture/repair/gap_filler.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "capture/errors.h"
#include "capture/stage.h"

namespace risorius {

static_assert(Stage<GapFiller, MarkerFrame, MarkerFrame>);

GapFiller::GapFiller(GapFillerOptions options)
    : options_(std::move(options)), head_(options_.head_frame), statistics_(options_.statistics) {
  if (options_.max_gap_ns <= 0) {
    throw UserError("max_gap_ns", fmt::format("{} is not > 0", options_.max_gap_ns),
                    "2000000000 (2 s) is the default; the method `none` fills nothing");
  }
}

void GapFiller::use_marker_set(const MarkerSet& set) {
  if (const auto problems = problems_of(set); !problems.empty()) {
    throw UserError(fmt::format("marker set {}", set.id), problems.front(), "correct the sender's marker set");
  }
  settle();
  const std::vector<int> old_index = index_map(set_.names, set.names);
  head_.use_names(set.names);
  statistics_.remap(old_index);
  residuals_.remap(old_index);
  std::vector<HeldMarker> held(set.names.size());
  for (std::size_t i = 0; i < held.size(); ++i) {
    if (old_index[i] >= 0) held[i] = held_[static_cast<std::size_t>(old_index[i])];
  }
  held_ = std::move(held);
  if (set_.names.empty()) clock_.reset(set.rate_hz);
  set_ = set;
}

void GapFiller::reset() noexcept {
  is_settled_ = true;
  head_.reset();
  statistics_.reset();
  residuals_.reset();
  std::fill(held_.begin(), held_.end(), HeldMarker{});
  clock_.reset(set_.rate_hz);
  if (has_waiting_) ledger_.dropped.add();
  has_waiting_ = false;
  ledger_.held.set(0);
}

bool GapFiller::push(const MarkerFrame& frame) noexcept {
  if (has_waiting_) return false;
  settle();
  ledger_.received.add();
  if (frame.count != set_.names.size()) {
    ledger_.refused.add();
    return true;
  }
  waiting_ = frame;
  has_waiting_ = true;
  ledger_.held.set(1);
  if (options_.method != FillMethod::kNone) process(waiting_);
  return true;
}

bool GapFiller::pop(MarkerFrame& frame) noexcept {
  if (!has_waiting_) return false;
  frame = waiting_;
  has_waiting_ = false;
  ledger_.held.set(0);
  ledger_.emitted.add();
  return true;
}

void GapFiller::process(MarkerFrame& frame) noexcept {
  step_s_ = clock_.advance(frame.header.capture_time_ns);
  const bool determined = head_.process(frame);
  const auto& measured = head_.measured();
  const bool low_rank = options_.method == FillMethod::kLowRank;
  // A pose that is not determined, or few visible markers, say too little of the face: the last frame's word is held.
  is_informed_ = determined && low_rank && 3 * std::count(measured.begin(), measured.end(), 1) >= frame.count;
  if (low_rank) residuals_.begin_frame(step_s_);
  if (is_informed_) statistics_.observe(head_.position_head_mm(), measured);
  for (std::size_t i = 0; i < frame.count; ++i) {
    if (!measured[i] || !determined) {
      held_[i].miss(step_s_);
      continue;
    }
    held_[i].observe(head_.position_head_mm()[i], step_s_);
  }
  for (std::size_t i = 0; i < frame.count; ++i) {
    if (measured[i]) continue;
    if (frame.state[i] == MarkerState::kMeasured) {
      frame.state[i] = MarkerState::kRejected;
      frame.reason[i] = RejectReason::kNotFinite;
    }
    fill(frame, i);
  }
  is_settled_ = false;
}

void GapFiller::settle() noexcept {
  if (is_settled_) return;
  is_settled_ = true;
  const auto& measured = head_.measured();
  for (std::size_t i = 0; is_informed_ && i < measured.size(); ++i) {
    if (measured[i]) residuals_.observe(i, statistics_.residual_mm(i), statistics_.variance_mm2(i));
  }
  head_.learn(step_s_, measured);
  if (is_informed_) statistics_.learn(step_s_);
}

GapFiller::Fill GapFiller::estimate(std::size_t i) const noexcept {
  const HeldMarker& held = held_[i];
  if (options_.method == FillMethod::kHold) return {held.hold_mm(), held.variance_mm2()};
  if (options_.method == FillMethod::kDampedVelocity) return {held.damped_mm(), held.variance_mm2()};
  const double variance = statistics_.variance_mm2(i);
  const ResidualMemory::Forecast forecast = residuals_.forecast(i, held.gap_s(), variance);
  return {statistics_.prediction_mm(i) + forecast.residual_mm, forecast.variance_mm2};
}

void GapFiller::fill(MarkerFrame& frame, std::size_t i) noexcept {
  const HeldMarker& held = held_[i];
  // Half a microsecond of slack: the gap is a sum of rounded steps.
  if (!held.seen() || held.gap_s() * 1e9 > static_cast<double>(options_.max_gap_ns) + 500) {
    if (frame.state[i] != MarkerState::kRejected) frame.state[i] = MarkerState::kMissing;
    left_missing_.add();
    return;
  }
  const Fill fill = estimate(i);
  const Eigen::Vector3f world = (head_.head_from_world().inverse() * fill.position_head_mm).cast<float>();
  frame.position_mm[i] = {world.x(), world.y(), world.z()};
  frame.standard_deviation_mm[i] = static_cast<float>(std::sqrt(fill.variance_mm2));
  frame.state[i] = MarkerState::kFilled;
  filled_[static_cast<std::size_t>(frame.reason[i])].add();
}

}  // namespace risorius
