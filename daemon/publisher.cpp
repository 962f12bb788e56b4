#include "daemon/publisher.h"

#include <cerrno>

#include "capture/errors.h"
#include "capture/monotonic_clock.h"

namespace risorius {

Publisher::Publisher(zmq::context_t& context, Options options, Channel<OutputItem>& results,
                     Channel<Continuation>& continuations)
    : options_(std::move(options)),
      socket_(context, zmq::socket_type::pub),
      results_(results),
      continuations_(continuations),
      states_(options_.streams.size()) {
  socket_.set(zmq::sockopt::sndhwm, options_.high_water_mark);
  socket_.set(zmq::sockopt::linger, 500);
  if (options_.gate != nullptr) options_.gate->guard(socket_);
  try {
    socket_.bind(options_.endpoint);
  } catch (const zmq::error_t& error) {
    throw UserError("[output] publish", "cannot bind \"" + options_.endpoint + "\": " + error.what(),
                    error.num() == EADDRINUSE
                        ? "another program, perhaps another risoriusd, has this port: end it or choose another port"
                        : "give an address of this machine, such as \"tcp://127.0.0.1:7001\"");
  }
  endpoint_ = socket_.get(zmq::sockopt::last_endpoint);
  thread_ = std::thread([this] { run(); });
}

Publisher::~Publisher() { stop(); }

void Publisher::request_status() noexcept {
  status_due_ = true;
  results_.ring();
}

void Publisher::request_shown() noexcept {
  shown_due_ = true;
  results_.ring();
}

void Publisher::stop() {
  stopping_ = true;
  results_.ring();
  if (thread_.joinable()) thread_.join();
}

void Publisher::run() noexcept {
  while (true) {
    const bool last_round = stopping_;
    while (const OutputItem* item = results_.front()) {
      publish(*item);
      if (options_.shown != nullptr && options_.shown->take(*item, shown_)) publish(shown_);
      if (options_.after_publishing) options_.after_publishing(*item);
      results_.release();
    }
    while (const Continuation* continuation = continuations_.front()) {
      publish(*continuation);
      if (options_.shown != nullptr) options_.shown->take(*continuation);
      continuations_.release();
    }
    if (shown_due_.exchange(false)) pass_time();
    if (status_due_.exchange(false) || last_round) send_status(last_round);
    if (last_round) return;
    results_.wait();
  }
}

void Publisher::publish(const OutputItem& item) {
  StreamState& state = states_[item.stream_id];
  const Stream& stream = options_.streams[item.stream_id];
  if (item.kind == OutputItem::Kind::kMarkerSet) state.marker_names = item.marker_set->names;
  if (item.kind != OutputItem::Kind::kSolved) return;

  // AUs first: they are what a live client waits for.
  MessageContext context{.stream = stream.name, .publish_time_ns = monotonic_now_ns(), .names = {}};
  const AuFrame& aus = item.solved.aus;
  if (aus.count == stream.au_names.size()) {
    context.message = state.au_messages++;
    context.names = stream.au_names;
    encode_aus(aus, context, buffer_);
    send("au");
    record(SessionTopic::kAus, item.stream_id, context.publish_time_ns);
    if (aus.header.receive_time_ns > 0) note_latencies(item, state.latencies);
  }
  // A stream of face shapes has no markers.
  if (item.solved.markers.count > 0 && item.solved.markers.count == state.marker_names.size()) {
    context.message = state.marker_messages++;
    context.names = state.marker_names;
    encode_markers(item.solved.markers, context, buffer_);
    send("markers");
    record(SessionTopic::kMarkerView, item.stream_id, context.publish_time_ns);
  }
}

void Publisher::note_latencies(const OutputItem& item, StageLatencies& latencies) noexcept {
  const std::int64_t received_ns = item.solved.aus.header.receive_time_ns, published_ns = monotonic_now_ns();
  latencies.received_to_cleaned.add(item.cleaned_ns - received_ns);
  latencies.cleaned_to_solved.add(item.solved_ns - item.cleaned_ns);
  latencies.solved_to_published.add(published_ns - item.solved_ns);
  latencies.received_to_published.add(published_ns - received_ns);
}

void Publisher::publish(const Continuation& continuation) {
  const Stream& stream = options_.streams[continuation.header.stream_id];
  if (continuation.au_count != stream.au_names.size()) return;
  const MessageContext context{.stream = stream.name,
                               .message = states_[continuation.header.stream_id].continuation_messages++,
                               .publish_time_ns = monotonic_now_ns(),
                               .names = stream.au_names};
  encode_continuation(continuation, context, buffer_);
  send("continuation");
  record(SessionTopic::kContinuations, continuation.header.stream_id, context.publish_time_ns);
}

void Publisher::pass_time() {
  if (options_.shown == nullptr) return;
  for (std::uint32_t i = 0; i < options_.shown->size(); ++i) {
    if (options_.shown->pass(i, monotonic_now_ns(), shown_)) publish(shown_);
  }
}

void Publisher::publish(const ShownFrame& shown) {
  const std::uint32_t stream_id = shown.aus.header.stream_id;
  const Stream& stream = options_.streams[stream_id];
  if (shown.aus.count != stream.au_names.size()) return;
  const MessageContext context{.stream = stream.name,
                               .message = states_[stream_id].shown_messages++,
                               .publish_time_ns = monotonic_now_ns(),
                               .names = stream.au_names};
  encode_shown(shown, context, buffer_);
  send("shown");
}

void Publisher::send(std::string_view topic) {
  // A PUB socket never blocks: for a subscriber beyond its mark the message is dropped.
  socket_.send(zmq::buffer(topic), zmq::send_flags::sndmore);
  socket_.send(zmq::buffer(buffer_.data(), buffer_.size()), zmq::send_flags::none);
  published_.add();
}

void Publisher::send_status(bool last) {
  buffer_ = options_.make_status(last, status_messages_++);
  send("status");
  record(SessionTopic::kStatus, 0, monotonic_now_ns());
}

/// What was just sent.
void Publisher::record(SessionTopic topic, std::uint32_t stream_id, std::int64_t time_ns) noexcept {
  if (options_.session != nullptr) options_.session->published(topic, stream_id, buffer_, time_ns);
}

}  // namespace risorius
