// One [[source]] on the I/O thread, of markers or of face shapes: source -> reorder window -> the admission point.
// Beside that way: the watchdog, the comparison of the tracker's clock with ours, and what the tracker says of its own
// recording.
#pragma once

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "capture/clock_sync.h"
#include "capture/wire/reorder_window.h"
#include "capture/wire/source.h"
#include "daemon/arrival_forecast.h"
#include "daemon/channel.h"
#include "daemon/config.h"
#include "daemon/latency_histogram.h"
#include "daemon/pipeline_items.h"
#include "daemon/session_recorder.h"
#include "daemon/set_change_allowance.h"
#include "daemon/watchdog.h"

namespace risorius {

class StreamInput {
 public:
  /// `on_state_change`: called on the I/O thread when the stream goes stale or comes back. `session`: records what is
  /// received and admitted; may be null. `awake_share`: of ArrivalForecast. Throws UserError if the address cannot be
  /// bound.
  StreamInput(boost::asio::io_context& io, std::uint32_t stream_id, const SourceConfig& config, double awake_share,
              Channel<AdmittedItem>& admitted, std::function<void()> on_state_change, SessionRecorder* session);

  void start();
  /// Closes the socket and admits what is left, then the end of the stream.
  void stop();
  /// False if no frames are coming (there is no face to capture) or there is no room for the request.
  bool admit_neutral_capture(std::int64_t duration_ns);

  /// Whether a frame is due within microseconds, so that the I/O thread should not fall asleep.
  bool awaits_frame() const noexcept;

  const std::string& name() const noexcept { return name_; }
  /// Where senders can send (with the port that the system chose, if asked for one), or what we are connected to.
  std::string endpoint() const { return source_->endpoint(); }
  const SourceCounters& source() const noexcept { return source_->counters(); }
  const ReorderCounters& reorder() const noexcept {
    if (tells_shapes_) return shape_reorder_;
    return reorder_;
  }
  const StageLedger& admission() const noexcept { return admission_; }
  const Counter& control_lost() const noexcept { return control_lost_; }
  /// Frames dropped because their set came too soon after too many others.
  const Counter& hasty_sets() const noexcept { return hasty_sets_; }
  /// "streaming", "stale" (silent for three frame times), else the state of the link. From any thread.
  std::string_view state() const noexcept;
  const Watchdog& watchdog() const noexcept { return watchdog_; }
  const ClockSync& clock() const noexcept { return clock_; }
  const ArrivalForecast& forecast() const noexcept { return forecast_; }
  /// From the tracker's exposure, by its clock, to our receive call. With arrivals alone: above the shortest one.
  const LatencyHistogram& exposure_to_received() const noexcept { return exposure_to_received_; }
  /// Admitted frames whose capture time is not after that of the one before.
  const Counter& time_stands() const noexcept { return time_stands_; }
  /// Starts and stops of the tracker's own recording.
  const Counter& recording_events() const noexcept { return recording_events_; }

 private:
  void on_ready();
  template <class Frame>
  void push_in_order(ReorderWindowOf<Frame>& window, const Frame& frame);
  void admit_ordered_frames();
  void admit_ordered(AdmittedItem::Kind kind, const FrameHeader& header);
  void flush_reorder();
  void describe(const MarkerSet& set);
  bool use_set_of(const FrameHeader& header);
  bool admit_control(AdmittedItem::Kind kind, const MarkerSet* set);
  void note_admitted() noexcept;
  void note_time(const FrameHeader& header) noexcept;
  void end_stream();
  void admit_end();
  void arm_tick();
  void note_arrival(const FrameHeader& header) noexcept;
  void arm_watchdog();
  void arm_forecast();
  void follow_recording();

  std::string name_;
  std::uint32_t stream_id_;
  Channel<AdmittedItem>& admitted_;
  SessionRecorder* session_;
  bool tells_shapes_;
  ReorderWindow reorder_;  ///< one of the two is used
  ReorderWindowOf<ShapeFrame> shape_reorder_;
  std::unique_ptr<Source> source_;
  boost::asio::steady_timer tick_timer_;
  std::int64_t tick_period_ns_;
  bool tick_armed_ = false;
  std::atomic<bool> stream_open_{false};
  Watchdog watchdog_;
  boost::asio::steady_timer watchdog_timer_;
  bool watchdog_armed_ = false;
  ArrivalForecast forecast_;
  boost::asio::steady_timer forecast_timer_;
  std::int64_t armed_from_ns_ = 0;  ///< of the window that the timer was last set for
  std::function<void()> on_state_change_;
  ClockSync clock_;
  LatencyHistogram exposure_to_received_;
  Counter recording_events_;
  std::unordered_map<std::uint32_t, const MarkerSet*> sets_;  ///< of this session, by id
  const MarkerSet* admitted_set_ = nullptr;                   ///< which the pipeline has now
  std::vector<std::string> admitted_names_;                   ///< of the set that it had last
  SetChangeAllowance set_changes_;
  SourceEvent event_;
  AdmittedItem item_;
  StageLedger admission_;
  Counter control_lost_, hasty_sets_, time_stands_;
  bool has_last_ = false;
  std::uint64_t last_sequence_ = 0;  ///< of the frame admitted last in this stream, if there is one
  std::int64_t last_capture_ns_ = 0;
};

}  // namespace risorius
