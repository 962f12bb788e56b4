// The thread that turns results into MessagePack and publishes them on a ZeroMQ PUB socket (topics markers, au,
// continuation, shown, status). Off the live path: a slow subscriber loses messages at its own high-water mark and sees
// it in the message numbers; it never delays anybody.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>
#include <zmq.hpp>

#include "capture/wire/curve_gate.h"
#include "daemon/channel.h"
#include "daemon/latency_histogram.h"
#include "daemon/pipeline_items.h"
#include "daemon/session_recorder.h"
#include "daemon/shown_streams.h"
#include "replay/live/messages.h"

namespace risorius {

/// Of a stream's frames on their way, by CLOCK_MONOTONIC; published: the AU message was handed to ZeroMQ.
struct StageLatencies {
  LatencyHistogram received_to_cleaned, cleaned_to_solved, solved_to_published, received_to_published;
};

class Publisher {
 public:
  struct Stream {
    std::string name;
    std::vector<std::string> au_names;
  };
  struct Options {
    std::string endpoint;                ///< such as "tcp://127.0.0.1:7001"; throws UserError if it cannot be bound
    int high_water_mark = 1000;          ///< messages per subscriber
    CurveGate* gate = nullptr;           ///< who may subscribe; null: anybody
    SessionRecorder* session = nullptr;  ///< records what is published, but `shown`; may be null
    ShownStreams* shown = nullptr;       ///< what to show of it; may be null
    std::vector<Stream> streams;         ///< by stream id
    /// Shown every item after it was published, on the publisher thread.
    std::function<void(const OutputItem& item)> after_publishing;
    /// Makes the MessagePack of a status message, the `message`-th; called on the publisher thread when a status is
    /// due.
    std::function<MessageBuffer(bool last, std::uint64_t message)> make_status;
  };

  Publisher(zmq::context_t& context, Options options, Channel<OutputItem>& results,
            Channel<Continuation>& continuations);
  ~Publisher();
  Publisher(const Publisher&) = delete;
  Publisher& operator=(const Publisher&) = delete;

  /// From any thread: publish a status soon.
  void request_status() noexcept;
  /// From any thread: time has passed for the silent streams of `shown`.
  void request_shown() noexcept;
  /// Publishes what is queued and a last status, then ends the thread.
  void stop();

  /// Where clients can connect (with the port that the system chose, if asked for one).
  const std::string& endpoint() const noexcept { return endpoint_; }
  const StageLatencies& latencies(std::uint32_t stream_id) const noexcept { return states_[stream_id].latencies; }
  std::uint64_t published() const noexcept { return published_.value(); }

 private:
  struct StreamState {
    std::vector<std::string> marker_names;
    std::uint64_t marker_messages = 0, au_messages = 0, continuation_messages = 0, shown_messages = 0;
    StageLatencies latencies;
  };

  void run() noexcept;
  void publish(const OutputItem& item);
  static void note_latencies(const OutputItem& item, StageLatencies& latencies) noexcept;
  void publish(const Continuation& continuation);
  void publish(const ShownFrame& shown);
  void pass_time();
  void send(std::string_view topic);
  void record(SessionTopic topic, std::uint32_t stream_id, std::int64_t time_ns) noexcept;
  void send_status(bool last);

  Options options_;
  zmq::socket_t socket_;
  std::string endpoint_;
  Channel<OutputItem>& results_;
  Channel<Continuation>& continuations_;
  std::deque<StreamState> states_;
  MessageBuffer buffer_;
  Counter published_;
  std::uint64_t status_messages_ = 0;
  ShownFrame shown_;
  std::atomic<bool> status_due_{false}, shown_due_{false}, stopping_{false};
  std::thread thread_;
};

}  // namespace risorius
