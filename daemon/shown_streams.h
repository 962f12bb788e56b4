// The topic `shown`: what an avatar is shown of each stream (generate/shown_face.h), beside what was measured. Off the
// live path: fed by the publisher thread with what it has published, and with time while a stream is silent. Targets
// come from the I/O thread; their courses are made on a thread of their own, since a network takes its time;
// how long one is to last takes 0.3 ms and is told at once.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "capture/counters.h"
#include "daemon/config.h"
#include "daemon/live_target_request.h"
#include "daemon/pipeline_items.h"
#include "generate/shown_face.h"

namespace risorius {

class ShownStreams {
 public:
  struct Stream {
    std::vector<std::string> au_names;
    std::vector<double> upper_bounds;
  };
  /// By stream id. Throws UserError for a model that is not known.
  ShownStreams(const std::vector<Stream>& streams, const ShownConfig& config);

  /// Publisher thread, of everything that was published, in order. True if `out` is to be published.
  bool take(const OutputItem& item, ShownFrame& out) noexcept;
  void take(const Continuation& continuation) noexcept;
  /// Publisher thread: time has come to CLOCK_MONOTONIC `now_ns`; for streams that are silent or have
  /// ended.
  bool pass(std::uint32_t stream_id, std::int64_t now_ns, ShownFrame& out) noexcept;

  /// I/O thread: whether the stream should be sending and does not. True if there is something to show meanwhile, also
  /// of a stream that has ended.
  bool note_silence(std::uint32_t stream_id, bool is_silent);
  /// I/O thread. Returns the seconds of the way there: `asked`'s, or the model's where it is "auto". Throws UserError:
  /// no face is there, another target is being prepared, numbers out of range, "auto" of a model that cannot tell.
  double go_to(std::uint32_t stream_id, const LiveTargetRequest& asked);
  /// I/O thread: also of a target that is still being prepared. Throws UserError if there is none.
  void release(std::uint32_t stream_id);

  std::size_t size() const noexcept { return states_.size(); }
  struct Counts {
    std::uint64_t messages = 0, predicted = 0, targets = 0;
  };
  Counts counts(std::uint32_t stream_id) const noexcept;

 private:
  struct State {
    State(const std::vector<double>& upper_bounds, const ShownOptions& options) : face(upper_bounds, options) {}
    std::mutex mutex;  ///< of face, arrived_ns and is_called_off
    ShownFace face;
    std::int64_t arrived_ns = 0;  ///< the last frame, CLOCK_MONOTONIC
    std::atomic<bool> is_silent{false}, has_ended{false}, is_preparing{false};
    bool is_called_off = false;              ///< the target that is being prepared; under the mutex
    std::unique_ptr<TransitionModel> model;  ///< of the thread that prepares; while none does, of the I/O thread
    Counter messages, predicted, targets;
    std::jthread preparing;  ///< last: it ends first
  };
  static void count(State& state, const ShownFrame& shown) noexcept;

  std::deque<State> states_;
};

}  // namespace risorius
