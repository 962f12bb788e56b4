// The other side of a tracker's protocol: a server that plays frames to whoever connects, so that clients can be tried
// without hardware. Lives on the thread that runs the io_context; all of its network traffic happens in there. What a
// client asks for, and when, is its own affair: frames that nobody wants are sent to nobody. A client that does not
// read loses frames, counted, and holds nobody up.
//
//   server.start(set);  loop { server.send_frame(frame, exposure_ns); }  server.stop();     // see take_player.h
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "capture/frames.h"
#include "capture/marker_set.h"

namespace risorius {

struct TrackerServerStatistics {
  std::uint64_t frames = 0;            ///< handed to send_frame
  std::uint64_t frames_sent = 0;       ///< frames times the clients that they were sent to
  std::uint64_t frames_not_sent = 0;   ///< frames times clients that did not get them: slow, or an error of the network
  std::uint64_t requests = 0;          ///< understood and answered
  std::uint64_t refused_requests = 0;  ///< not understood, or not possible
  std::uint64_t clients = 0;           ///< that ever connected
};

class TrackerServer {
 public:
  virtual ~TrackerServer() = default;

  /// Begins to answer clients. `set`: names and rate of the frames to come; their unit and axes are always mm and LUF,
  /// which the server turns into what its protocol has. Throws UserError if the set cannot be told in the protocol.
  virtual void start(const MarkerSet& set) = 0;
  /// The frame to all clients that stream. `exposure_ns` is its capture time on CLOCK_MONOTONIC, which is the clock
  /// that the server pretends the tracker to have.
  virtual void send_frame(const MarkerFrame& frame, std::int64_t exposure_ns) = 0;
  /// Says good-bye where the protocol can, and closes the sockets. Final.
  virtual void stop() noexcept = 0;

  /// Clients that get the next frame.
  virtual std::size_t streaming_clients() const noexcept = 0;
  /// Where clients connect to, as the daemon's `listen` wants it.
  virtual std::string endpoint() const = 0;
  virtual const TrackerServerStatistics& statistics() const noexcept = 0;

 protected:
  TrackerServer() = default;
  TrackerServer(const TrackerServer&) = delete;
  TrackerServer& operator=(const TrackerServer&) = delete;
};

}  // namespace risorius
