// Plays a take through a TrackerServer at the take's pace, on the io_context's timer: absolute deadlines (Pacer), so
// that errors do not add up, and the server answers its clients in between.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <functional>
#include <optional>

#include "replay/live/loop_clock.h"
#include "replay/live/pacer.h"
#include "replay/live/tracker_server.h"
#include "replay/takes/take.h"

namespace risorius {

struct TakePlayerOptions {
  PacerOptions pace;
  bool loop = false;             ///< begin again at the end; sequence and capture time go on counting
  bool wait_for_client = false;  ///< the take's first frame waits until a client streams
};

class TakePlayer {
 public:
  /// Take and server must outlive the player. `on_end` is called once, from the io_context, after the last frame.
  /// Throws UserError if the take has no frames.
  TakePlayer(boost::asio::io_context& io, TakeReader& take, TrackerServer& server, const TakePlayerOptions& options,
             std::function<void()> on_end);

  /// Starts the server and the clock.
  void start();
  /// No further frame; on_end is not called.
  void stop() noexcept;

  std::uint64_t frames_played() const noexcept { return frames_; }
  const PacerStatistics& pace() const noexcept { return pacer_.statistics(); }

 private:
  bool read_next();
  void wait_for_client();
  void arm();
  void play();

  TakeReader& take_;
  TrackerServer& server_;
  TakePlayerOptions options_;
  std::function<void()> on_end_;
  Pacer pacer_;
  LoopClock clock_;
  boost::asio::steady_timer timer_;
  MarkerFrame frame_;
  std::int64_t due_ns_ = 0;
  std::optional<std::int64_t> monotonic_minus_take_ns_;  ///< what makes an exposure time of a capture time
  std::uint64_t frames_ = 0;
};

}  // namespace risorius
