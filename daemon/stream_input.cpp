#include "daemon/stream_input.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "capture/monotonic_clock.h"
#include "daemon/make_source.h"

namespace risorius {
namespace {

/// A source whose clock runs so much faster or slower than ours is a take at another pace: its latencies mean nothing.
constexpr double kLiveSkewPpm = 2000;

}  // namespace

StreamInput::StreamInput(boost::asio::io_context& io, std::uint32_t stream_id, const SourceConfig& config,
                         double awake_share, Channel<AdmittedItem>& admitted, std::function<void()> on_state_change,
                         SessionRecorder* session)
    : name_(config.name),
      stream_id_(stream_id),
      admitted_(admitted),
      session_(session),
      tells_shapes_(tells_shapes(config)),
      reorder_(config.stages.reorder),
      shape_reorder_(config.stages.reorder),
      source_(make_source(io, stream_id, config, [this] { on_ready(); })),
      tick_timer_(io),
      tick_period_ns_(std::max<std::int64_t>(1'000'000, config.stages.reorder.timeout_ns / 4)),
      watchdog_timer_(io),
      forecast_(awake_share),
      forecast_timer_(io),
      on_state_change_(std::move(on_state_change)) {
  if (session_ != nullptr) source_->tap_raw(session_->raw_tap(stream_id_));
}

void StreamInput::start() { source_->start(); }

void StreamInput::stop() {
  source_->stop();
  source_->flush();
  on_ready();
  end_stream();
  tick_timer_.cancel();
  watchdog_timer_.cancel();
  forecast_timer_.cancel();
}

bool StreamInput::admit_neutral_capture(std::int64_t duration_ns) {
  if (!stream_open_) return false;
  item_.duration_ns = duration_ns;
  return admit_control(AdmittedItem::Kind::kNeutralCapture, nullptr);
}

void StreamInput::on_ready() {
  while (source_->pop(event_)) {
    switch (event_.kind) {
      case SourceEventKind::kNewSession:
        end_stream();
        clock_.reset();
        sets_.clear();
        admitted_set_ = nullptr;
        break;
      case SourceEventKind::kMarkerSet:
        describe(*event_.set);
        break;
      case SourceEventKind::kFrame:
        admitted_.announce();  // the pipeline wakes while the frame is put in order
        push_in_order(reorder_, event_.frame);
        note_arrival(event_.frame.header);
        break;
      case SourceEventKind::kShapes:
        admitted_.announce();
        push_in_order(shape_reorder_, event_.shapes);
        note_arrival(event_.shapes.header);
        break;
      case SourceEventKind::kEndOfStream:
        // The window goes on knowing what came: a straggler after the end is late, not the first frame of a new stream.
        if (event_.end.frames_sent > 0) {
          reorder_.end_of_stream(event_.end.last_sequence);
          admit_ordered_frames();
        } else {
          flush_reorder();
        }
        admit_end();
        break;
      case SourceEventKind::kRecordingStarted:
      case SourceEventKind::kRecordingStopped:
        follow_recording();
        break;
    }
  }
  for (ClockSample sample; source_->pop_clock_sample(sample);)
    clock_.add_echo(sample.sent_ns, sample.tracker_ns, sample.received_ns);
  arm_watchdog();
  arm_forecast();
  if (reorder().ledger().held.value() > 0) arm_tick();
}

template <class Frame>
void StreamInput::push_in_order(ReorderWindowOf<Frame>& window, const Frame& frame) {
  while (!window.push(frame)) admit_ordered_frames();
  if (source_->keeps_order()) window.give_up_gaps();
  admit_ordered_frames();
}

void StreamInput::admit_ordered_frames() {
  while (reorder_.pop(item_.frame)) admit_ordered(AdmittedItem::Kind::kFrame, item_.frame.header);
  while (shape_reorder_.pop(item_.shapes)) admit_ordered(AdmittedItem::Kind::kShapes, item_.shapes.header);
}

void StreamInput::admit_ordered(AdmittedItem::Kind kind, const FrameHeader& header) {
  stream_open_ = true;
  admission_.received.add();
  const bool has_set = use_set_of(header);
  item_.kind = kind;
  item_.stream_id = stream_id_;
  const bool admitted = has_set && admitted_.send_frame(item_);
  (admitted ? admission_.emitted : admission_.dropped).add();
  if (!admitted) return;
  note_time(header);
  note_admitted();
}

/// Where the sequence goes back a new run begins, whose clock may be another.
void StreamInput::note_time(const FrameHeader& header) noexcept {
  const bool goes_on = std::exchange(has_last_, true) && header.sequence > last_sequence_;
  if (goes_on && header.capture_time_ns <= last_capture_ns_) time_stands_.add();
  last_sequence_ = header.sequence;
  last_capture_ns_ = header.capture_time_ns;
}

/// After the item is on its way.
void StreamInput::note_admitted() noexcept {
  if (session_ != nullptr) session_->admitted(item_);
}

void StreamInput::flush_reorder() {
  reorder_.flush();
  shape_reorder_.flush();
  admit_ordered_frames();
}

/// Frames name their set, so a set is admitted ahead of the first frame of it that comes in order. Only a redefinition
/// of one id must first let the frames pass that still mean the old one.
void StreamInput::describe(const MarkerSet& set) {
  if (sets_.contains(set.id)) flush_reorder();
  sets_[set.id] = &set;
}

/// False if the set could not be admitted: then its frames must not be either, and the next one tries again.
bool StreamInput::use_set_of(const FrameHeader& header) {
  const auto set = sets_.find(header.set_id);
  if (set == sets_.end()) return false;  // the source hands on no frame of a set that it has not
  if (set->second == admitted_set_) return true;
  // The same markers once more cost nothing.
  const bool is_change = set->second->names != admitted_names_;
  if (is_change && !set_changes_.take(header.receive_time_ns)) {
    hasty_sets_.add();
    return false;
  }
  watchdog_.use_rate(set->second->rate_hz);
  admitted_set_ = admit_control(AdmittedItem::Kind::kMarkerSet, set->second) ? set->second : nullptr;
  if (admitted_set_ == nullptr) return false;
  if (is_change) admitted_names_ = set->second->names;
  return true;
}

bool StreamInput::admit_control(AdmittedItem::Kind kind, const MarkerSet* set) {
  item_.kind = kind;
  item_.stream_id = stream_id_;
  item_.marker_set = set;
  if (admitted_.send_control(item_)) {
    note_admitted();
    return true;
  }
  control_lost_.add();
  return false;
}

void StreamInput::end_stream() {
  flush_reorder();
  admit_end();
}

void StreamInput::admit_end() {
  if (stream_open_) admit_control(AdmittedItem::Kind::kEndOfStream, nullptr);
  stream_open_ = has_last_ = false;
  watchdog_.stream_ended();
  forecast_.reset();
}

std::string_view StreamInput::state() const noexcept {
  if (watchdog_.stale()) return "stale";
  if (stream_open_) return "streaming";
  // What streams to us is between two streams: the one that came has ended, or of the next nothing is in order yet.
  const LinkState link = source().link.load();
  return name_of(link == LinkState::kStreaming ? LinkState::kWaiting : link);
}

/// After the frame is on its way.
void StreamInput::note_arrival(const FrameHeader& header) noexcept {
  if (watchdog_.frame_came(header.receive_time_ns)) on_state_change_();
  if (stream_open_) {
    forecast_.frame_came(header.receive_time_ns);
  } else {
    watchdog_.stream_ended();  // a straggler, after which no others are due
  }
  clock_.add_arrival(header.capture_time_ns, header.receive_time_ns);
  if (!clock_.known() || std::abs(clock_.skew_ppm()) > kLiveSkewPpm) return;
  exposure_to_received_.add(difference_ns(header.receive_time_ns, clock_.to_ours_ns(header.capture_time_ns)));
}

/// One timer, moved on when it fires: a frame costs no timer of its own.
void StreamInput::arm_watchdog() {
  if (watchdog_armed_ || !watchdog_.running() || watchdog_.stale()) return;
  watchdog_armed_ = true;
  const std::int64_t wait_ns = std::max<std::int64_t>(0, watchdog_.deadline_ns() - monotonic_now_ns());
  watchdog_timer_.expires_after(std::chrono::nanoseconds(wait_ns));
  watchdog_timer_.async_wait([this](const boost::system::error_code& error) {
    watchdog_armed_ = false;
    if (error) return;
    if (watchdog_.look(monotonic_now_ns())) on_state_change_();
    arm_watchdog();
  });
}

bool StreamInput::awaits_frame() const noexcept {
  const auto& window = forecast_.window();
  if (!window) return false;
  const std::int64_t now_ns = monotonic_now_ns();
  return now_ns >= window->from_ns && now_ns < window->until_ns;
}

/// Shortly before the next frame is due, the pipeline wakes, and the I/O thread by this very timer.
void StreamInput::arm_forecast() {
  const auto& window = forecast_.window();
  if (!window || window->from_ns == armed_from_ns_) return;
  armed_from_ns_ = window->from_ns;
  forecast_timer_.expires_after(std::chrono::nanoseconds(window->from_ns - monotonic_now_ns()));
  forecast_timer_.async_wait([this](const boost::system::error_code& error) {
    if (!error && awaits_frame()) admitted_.announce(forecast_.window()->until_ns);
  });
}

/// What was captured before the tracker's word goes before it.
void StreamInput::follow_recording() {
  recording_events_.add();
  flush_reorder();
  item_.recording_name_size = event_.recording_name_size;
  item_.recording_name_bytes = event_.recording_name_bytes;
  admit_control(event_.kind == SourceEventKind::kRecordingStarted ? AdmittedItem::Kind::kRecordingStarted
                                                                  : AdmittedItem::Kind::kRecordingStopped,
                nullptr);
}

// Only while frames wait behind a gap: an idle stream costs no wake-ups.
void StreamInput::arm_tick() {
  if (tick_armed_) return;
  tick_armed_ = true;
  tick_timer_.expires_after(std::chrono::nanoseconds(tick_period_ns_));
  tick_timer_.async_wait([this](const boost::system::error_code& error) {
    tick_armed_ = false;
    if (error) return;
    const Tick tick{.stream_id = stream_id_, .time_ns = monotonic_now_ns()};
    reorder_.tick(tick);
    shape_reorder_.tick(tick);
    admit_ordered_frames();
    if (reorder().ledger().held.value() > 0) arm_tick();
  });
}

}  // namespace risorius
