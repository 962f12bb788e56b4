#include "capture/repair/gap_filler.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "capture/errors.h"
#include "capture/plausible_position.h"
#include "capture/repair/despiker.h"
#include "capture/repair/position_vector.h"
#include "capture/stage.h"

namespace risorius {

static_assert(Stage<GapFiller, MarkerFrame, MarkerFrame>);

namespace {
constexpr std::uint32_t kMostLookahead = 64;
}  // namespace

GapFiller::GapFiller(GapFillerOptions options)
    : options_(std::move(options)),
      own_head_(options_.head_frame),
      model_(options_.covariance),
      rehearsal_(options_.covariance) {
  if (options_.max_gap_ns <= 0) {
    throw UserError("max_gap_ns", fmt::format("{} is not > 0", options_.max_gap_ns),
                    "2000000000 (2 s) is the default; the method `none` fills nothing");
  }
  if (options_.lookahead_frames > kMostLookahead) {
    throw UserError("lookahead_frames", fmt::format("{} is more than {}", options_.lookahead_frames, kMostLookahead),
                    "0 is the default: frames do not wait");
  }
  ring_.resize(options_.lookahead_frames + 1);
}

void GapFiller::use_marker_set(const MarkerSet& set) {
  if (const auto problems = problems_of(set); !problems.empty()) {
    throw UserError(fmt::format("marker set {}", set.id), problems.front(), "correct the sender's marker set");
  }
  settle();
  const std::vector<int> old_index = index_map(set_.names, set.names);
  own_head_.use_names(set.names);
  model_.remap(old_index);
  rehearsal_.remap(old_index);
  if (set.names != set_.names) {
    model_.know(options_.known_motion, set.names);
    rehearsal_.know(options_.known_motion, set.names);
  }
  measured_.assign(set.names.size(), 0);
  std::vector<HeldMarker> held(set.names.size());
  for (std::size_t i = 0; i < held.size(); ++i) {
    if (old_index[i] >= 0) held[i] = held_[static_cast<std::size_t>(old_index[i])];
  }
  held_ = std::move(held);
  if (!set_.names.empty() && options_.lookahead_frames > 0) drop_waiting();
  if (set_.names.empty()) clock_.reset(set.rate_hz);
  set_ = set;
}

void GapFiller::reset() noexcept {
  is_settled_ = true;
  own_head_.reset();
  model_.reset();
  rehearsal_.reset();
  std::fill(held_.begin(), held_.end(), HeldMarker{});
  clock_.reset(set_.rate_hz);
  drop_waiting();
}

void GapFiller::drop_waiting() noexcept {
  ledger_.dropped.add(waiting_);
  waiting_ = 0;
  is_flushing_ = false;
  ledger_.held.set(0);
}

bool GapFiller::push(const MarkerFrame& frame) noexcept { return take_in(frame, nullptr); }

bool GapFiller::push(const MarkerFrame& frame, const Despiker& despiker) noexcept {
  return take_in(frame, despiker.has_model() ? &despiker : nullptr);
}

bool GapFiller::take_in(const MarkerFrame& frame, const Despiker* despiker) noexcept {
  if (is_ready()) return false;
  is_flushing_ = false;
  settle();
  ledger_.received.add();
  if (frame.count != set_.names.size()) {
    ledger_.refused.add();
    return true;
  }
  ++waiting_;
  back(0) = frame;
  ledger_.held.set(waiting_);
  if (options_.method != FillMethod::kNone) process(back(0), despiker);
  return true;
}

bool GapFiller::pop(MarkerFrame& frame) noexcept {
  if (!is_ready()) return false;
  frame = ring_[oldest_];
  oldest_ = (oldest_ + 1) % ring_.size();
  --waiting_;
  ledger_.held.set(waiting_);
  ledger_.emitted.add();
  return true;
}

/// Of the frames that wait; 0 is the one pushed last.
MarkerFrame& GapFiller::back(std::size_t frames_ago) noexcept {
  return ring_[(oldest_ + waiting_ - 1 - frames_ago) % ring_.size()];
}

/// Carries the frame into the head's frame, or takes the despiker's word, and asks how markers move together. False if
/// the pose is not determined.
bool GapFiller::look_at(const MarkerFrame& frame, const Despiker* despiker) noexcept {
  owns_head_ = despiker == nullptr;
  head_ = owns_head_ ? &own_head_ : &despiker->head();
  const bool determined = owns_head_ ? own_head_.process(frame) : head_->determined();
  for (std::size_t i = 0; i < measured_.size(); ++i) {
    measured_[i] = frame.state[i] == MarkerState::kMeasured && head_->measured()[i] != 0;
  }
  // A pose that is not determined, or few visible markers, say too little of the face: the last frame's word is held.
  is_informed_ = determined && options_.method == FillMethod::kCovariance &&
                 3 * std::count(measured_.begin(), measured_.end(), 1) >= frame.count;
  if (is_informed_) {
    model_.observe(head_->position_head_mm(), measured_, step_s_);
    rehearsal_.take(head_->position_head_mm(), measured_);
  }
  return determined;
}

void GapFiller::process(MarkerFrame& frame, const Despiker* despiker) noexcept {
  step_s_ = clock_.advance(frame.header.capture_time_ns);
  const bool determined = look_at(frame, despiker);
  for (std::size_t i = 0; i < frame.count; ++i) {
    if (!measured_[i] || !determined) {
      held_[i].miss(step_s_);
      continue;
    }
    if (waiting_ > 1 && held_[i].gap_s() > 0) lead_home(frame, i);
    held_[i].observe(head_->position_head_mm()[i], step_s_);
  }
  for (std::size_t i = 0; i < frame.count; ++i) {
    if (measured_[i]) continue;
    if (frame.state[i] == MarkerState::kMeasured) {
      frame.state[i] = MarkerState::kRejected;
      frame.reason[i] = RejectReason::kNotFinite;
    }
    fill(frame, i);
  }
  is_settled_ = false;
}

/// Marker i is back: what its fill would have been off by now is taken from the fills that still wait, more of it the
/// later they are.
void GapFiller::lead_home(const MarkerFrame& frame, std::size_t i) noexcept {
  std::size_t gap = 0;  // fills that still wait
  while (gap + 1 < waiting_ && back(gap + 1).state[i] == MarkerState::kFilled) ++gap;
  if (gap == 0 || !held_[i].seen()) return;
  held_[i].miss(step_s_);
  const Eigen::Vector3d world = head_->head_from_world().inverse() * estimate(i).position_head_mm;
  const Eigen::Vector3d off = to_vector(frame.position_mm[i]) - world;
  for (std::size_t k = 1; k <= gap; ++k) {
    const double share = 1 - static_cast<double>(k) / static_cast<double>(gap + 1);
    Position& p = back(k).position_mm[i];
    p = to_position(to_vector(p) + share * off);
  }
}

void GapFiller::settle() noexcept {
  if (is_settled_) return;
  is_settled_ = true;
  if (options_.method == FillMethod::kCovariance) {
    model_.learn(measured_, step_s_, is_informed_);
    rehearsal_.practise(model_, step_s_, is_informed_);
  }
  if (owns_head_) own_head_.learn(step_s_, measured_);
}

MarkerFill GapFiller::estimate(std::size_t i) noexcept {
  const HeldMarker& held = held_[i];
  if (options_.method == FillMethod::kHold) return {held.hold_mm(), held.variance_mm2()};
  if (options_.method == FillMethod::kDampedVelocity) return {held.damped_mm(), held.variance_mm2()};
  return rehearsal_.weigh(i, model_.estimate(i, held.gap_s()), model_.stayed_head_mm(i), held.gap_s());
}

void GapFiller::leave_missing(MarkerFrame& frame, std::size_t i) noexcept {
  if (frame.state[i] != MarkerState::kRejected) frame.state[i] = MarkerState::kMissing;
  left_missing_.add();
}

void GapFiller::fill(MarkerFrame& frame, std::size_t i) noexcept {
  const HeldMarker& held = held_[i];
  // Half a microsecond of slack: the gap is a sum of rounded steps.
  if (!held.seen() || held.gap_s() * 1e9 > static_cast<double>(options_.max_gap_ns) + 500) {
    leave_missing(frame, i);
    return;
  }
  const MarkerFill fill = estimate(i);
  const Eigen::Vector3f world = (head_->head_from_world().inverse() * fill.position_head_mm).cast<float>();
  if (!is_plausible_position(world.x(), world.y(), world.z()) || !(fill.variance_mm2 >= 0)) {
    leave_missing(frame, i);  // never a position that is none, whatever the numbers did
    return;
  }
  frame.position_mm[i] = {world.x(), world.y(), world.z()};
  frame.standard_deviation_mm[i] = static_cast<float>(std::sqrt(fill.variance_mm2));
  frame.state[i] = MarkerState::kFilled;
  filled_[static_cast<std::size_t>(frame.reason[i])].add();
}

}  // namespace risorius
