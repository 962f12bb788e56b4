// What a NatnetSession does on time alone: try, try again, keep alive, notice silence.
#include <algorithm>

#include "capture/wire/natnet_session.h"

namespace risorius {

NatnetDatagram* NatnetSession::outgoing() noexcept {
  if (outgoing_count_ == outgoing_.size()) return nullptr;  // it is asked again when no answer comes
  return &outgoing_[(first_outgoing_ + outgoing_count_++) % outgoing_.size()];
}

void NatnetSession::send(NatnetMessage message) {
  if (NatnetDatagram* datagram = outgoing()) encode_bare(message, *datagram);
}

bool NatnetSession::pop_datagram(NatnetDatagram& datagram) {
  if (outgoing_count_ == 0) return false;
  datagram = outgoing_[first_outgoing_];
  first_outgoing_ = (first_outgoing_ + 1) % outgoing_.size();
  --outgoing_count_;
  return true;
}

/// Asks what the phase asks for, with a new wait.
void NatnetSession::enter(Phase phase, std::int64_t now_ns) noexcept {
  phase_ = phase;
  wait_ns_ = options_.first_wait_ns;
  retry_at_ns_ = now_ns + wait_ns_;
  if (phase == Phase::kAskingRate) {
    rate_hz_ = 0;
    if (NatnetDatagram* datagram = outgoing()) encode_text(NatnetMessage::kRequest, "FrameRate", *datagram);
  } else if (phase == Phase::kAskingModel) {
    masked_request_ = false;
    send(NatnetMessage::kRequestModelDef);
  } else if (phase == Phase::kStreaming) {
    keep_alive_at_ns_ = echo_at_ns_ = connected_ns_ = now_ns;
    ask_again_at_ns_ = INT64_MIN;
    framed_ns_ = INT64_MIN;
  }
}

/// The next form; after the last one the waits are doubled.
void NatnetSession::connect_again(std::int64_t now_ns) noexcept {
  if (retry_at_ns_ != INT64_MIN) {
    connect_form_ = (connect_form_ + 1) % kNatnetConnectForms;
    if (connect_form_ == 0) wait_ns_ = std::min(2 * wait_ns_, options_.longest_wait_ns);
  }
  retry_at_ns_ = now_ns + wait_ns_;
  send_connect();
}

/// In the form that is in turn; once connected, in the one that was answered.
void NatnetSession::send_connect() {
  if (NatnetDatagram* datagram = outgoing()) encode_connect(static_cast<NatnetConnectForm>(connect_form_), *datagram);
}

void NatnetSession::retry(std::int64_t now_ns) {
  switch (phase_) {
    case Phase::kConnecting:
      return connect_again(now_ns);
    case Phase::kAskingRate:
      return enter(Phase::kAskingModel, now_ns);  // a server need not know it
    case Phase::kAskingModel:
      wait_ns_ = std::min(2 * wait_ns_, options_.longest_wait_ns);
      retry_at_ns_ = now_ns + wait_ns_;
      masked_request_ = !masked_request_;
      if (!masked_request_) return send(NatnetMessage::kRequestModelDef);
      if (NatnetDatagram* datagram = outgoing()) encode_masked_model_request(*datagram);
      return;
    case Phase::kStreaming:
      return;
  }
}

/// A server that began anew may answer echoes, but it sends no frames to a client that it does not know. Asked often at
/// first, because it may be back at once; then seldom, because it may only pause.
void NatnetSession::ask_again(std::int64_t now_ns) {
  const std::int64_t paused_ns = now_ns - std::max(framed_ns_, connected_ns_);
  if (paused_ns < longest_pause_ns() || now_ns < ask_again_at_ns_) return;
  ask_again_at_ns_ = now_ns + (paused_ns < options_.longest_wait_ns ? options_.first_wait_ns : options_.keep_alive_ns);
  send_connect();
}

void NatnetSession::keep_up(std::int64_t now_ns) {
  if (now_ns >= keep_alive_at_ns_) {
    keep_alive_at_ns_ = now_ns + options_.keep_alive_ns;
    send(NatnetMessage::kKeepAlive);
  }
  if (phase_ == Phase::kStreaming) ask_again(now_ns);
  if (now_ns >= echo_at_ns_) {
    echo_at_ns_ = now_ns + options_.echo_ns;
    echo_ticks_ = static_cast<std::uint64_t>(now_ns);
    if (NatnetDatagram* datagram = outgoing()) encode_echo_request(echo_ticks_, *datagram);
  }
}

/// Between frames; where they come seldom, three frame times.
std::int64_t NatnetSession::longest_pause_ns() const noexcept {
  const double frames_ns = rate_hz_ > 0 ? 3e9 / rate_hz_ : 0;
  return std::clamp(static_cast<std::int64_t>(std::min(frames_ns, 1e18)), options_.first_wait_ns,
                    std::max(options_.first_wait_ns, options_.silence_ns));
}

void NatnetSession::tick(Tick tick) noexcept {
  const std::int64_t now_ns = tick.time_ns;
  const bool connected = phase_ != Phase::kConnecting;
  if (connected && now_ns - heard_ns_ >= longest_silence_ns()) {
    if (!ready()) return;
    lose();
  }
  if (phase_ != Phase::kStreaming && now_ns >= retry_at_ns_) retry(now_ns);
  if (phase_ != Phase::kConnecting) keep_up(now_ns);
  if (counters_.link == LinkState::kStreaming && now_ns - framed_ns_ >= options_.silence_ns)
    counters_.link = LinkState::kWaiting;
}

/// A server that takes its time to define its models is not lost.
std::int64_t NatnetSession::longest_silence_ns() const noexcept {
  return phase_ == Phase::kStreaming ? options_.silence_ns : 2 * options_.longest_wait_ns;
}

std::int64_t NatnetSession::next_tick_ns() const noexcept {
  if (phase_ == Phase::kConnecting) return retry_at_ns_;
  const std::int64_t due_ns = std::min({keep_alive_at_ns_, echo_at_ns_, heard_ns_ + longest_silence_ns()});
  if (phase_ != Phase::kStreaming) return std::min(due_ns, retry_at_ns_);
  return std::min(due_ns, std::max(ask_again_at_ns_, std::max(framed_ns_, connected_ns_) + longest_pause_ns()));
}

void NatnetSession::lose() noexcept {
  if (phase_ == Phase::kConnecting) return;
  end_stream();
  counters_.link = LinkState::kLost;
  phase_ = Phase::kConnecting;
  server_.reset();
  wait_ns_ = options_.first_wait_ns;
  retry_at_ns_ = INT64_MIN;  // at once, in the form that was answered
  changing_until_ns_ = INT64_MIN;
  models_changed_bit_ = bitstream_changed_bit_ = false;
}

void NatnetSession::end_stream() noexcept {
  if (!stream_open_) return;
  if (recording_) events_.emit(SourceEventKind::kRecordingStopped, session_);
  events_.emit(SourceEventKind::kEndOfStream, session_);
  stream_open_ = recording_ = false;
  set_ = nullptr;
}

}  // namespace risorius
