// One [[source]] on the I/O thread: source -> reorder window -> the admission point.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>

#include "capture/wire/reorder_window.h"
#include "capture/wire/source.h"
#include "daemon/channel.h"
#include "daemon/config.h"
#include "daemon/pipeline_items.h"

namespace risorius {

class StreamInput {
 public:
  /// Throws UserError if the address cannot be bound.
  StreamInput(boost::asio::io_context& io, std::uint32_t stream_id, const SourceConfig& config,
              Channel<AdmittedItem>& admitted);

  void start();
  /// Closes the socket and admits what is left, then the end of the stream.
  void stop();
  /// False if no frames are coming (there is no face to capture) or there is no room for the request.
  bool admit_neutral_capture(std::int64_t duration_ns);

  const std::string& name() const noexcept { return name_; }
  /// Where senders can send (with the port that the system chose, if asked for one), or what we are connected to.
  std::string endpoint() const { return source_->endpoint(); }
  const SourceCounters& source() const noexcept { return source_->counters(); }
  const ReorderWindow& reorder() const noexcept { return reorder_; }
  const StageLedger& admission() const noexcept { return admission_; }
  const Counter& control_lost() const noexcept { return control_lost_; }

 private:
  void on_ready();
  void push_in_order(const MarkerFrame& frame);
  void admit_ordered_frames();
  void describe(const MarkerSet& set);
  bool use_set_of(const MarkerFrame& frame);
  bool admit_control(AdmittedItem::Kind kind, const MarkerSet* set);
  void end_stream();
  void arm_tick();

  std::string name_;
  std::uint32_t stream_id_;
  Channel<AdmittedItem>& admitted_;
  ReorderWindow reorder_;
  std::unique_ptr<Source> source_;
  boost::asio::steady_timer tick_timer_;
  std::int64_t tick_period_ns_;
  bool tick_armed_ = false, stream_open_ = false;
  std::unordered_map<std::uint32_t, const MarkerSet*> sets_;  ///< of this session, by id
  const MarkerSet* admitted_set_ = nullptr;                   ///< which the pipeline has now
  SourceEvent event_;
  AdmittedItem item_;
  StageLedger admission_;
  Counter control_lost_;
};

}  // namespace risorius
