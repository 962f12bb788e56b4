// The sockets of a TrackerSession: a connection that is always wanted, and a UDP socket where the tracker sends frames
// by UDP. What a [[source]] of QTM or Vicon is to the daemon.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "capture/wire/source.h"
#include "capture/wire/tcp_link.h"
#include "capture/wire/tracker_session.h"

namespace risorius {

struct TrackerClientOptions {
  std::string url;  ///< as the user wrote it, for endpoint()
  TcpLinkOptions link;
  bool udp_frames = false;                             ///< ask for frames over UDP, at our end of the connection
  std::size_t receive_buffer_bytes = 8 * 1024 * 1024;  ///< asked of the kernel, for the UDP socket
};

class TrackerClient : public Source {
 public:
  TrackerClient(boost::asio::io_context& io, const TrackerClientOptions& options,
                std::unique_ptr<TrackerSession> session, std::function<void()> on_ready);
  ~TrackerClient() override;

  void tap_raw(const RawTap& tap) noexcept override;
  void start() override;
  void stop() noexcept override;
  void resume() override;
  bool pop(SourceEvent& event) noexcept override;
  void flush() noexcept override;
  bool keeps_order() const noexcept override;
  std::string endpoint() const override;
  const SourceCounters& counters() const noexcept override;

  const TrackerSession& session() const noexcept;

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;  ///< shared with the handlers that wait in the io_context
};

}  // namespace risorius
