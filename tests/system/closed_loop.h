// A performed stream into a running daemon, and its answers back: how long each frame took from sending to receiving.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>
#include <zmq.hpp>

#include "capture/frames.h"
#include "capture/marker_set.h"
#include "replay/live/loop_clock.h"
#include "replay/live/sender.h"
#include "replay/performer/performer.h"
#include "system/running_daemon.h"

namespace risorius::test {

class ClosedLoop {
 public:
  /// The performer's 55 markers, and others that the rig does not know, until there are `markers`, 55 to 110.
  ClosedLoop(const RunningDaemon& daemon, const std::string& source, double rate_hz, std::size_t markers);

  /// Sends for so long; appends the time to each frame's AU message. Returns the number of frames without one within
  /// 100 ms.
  std::uint64_t run(double seconds, std::vector<double>& latency_ms);
  /// Frames in all.
  std::uint64_t sent() const { return sender_.statistics().frames; }

 private:
  const MarkerFrame& next();

  double rate_hz_;
  PerformerTake take_;
  LoopClock clock_;
  MarkerSet set_;
  MarkerFrame frame_;
  Sender sender_;
  zmq::context_t context_;
  zmq::socket_t answers_;
};

/// Of at least one value; throws std::runtime_error otherwise.
double quantile(std::vector<double> values, double q);

}  // namespace risorius::test
