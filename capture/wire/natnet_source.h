// A NatNet client: the sockets around a NatnetSession. One socket for commands, at whose port some servers send frames
// too, and one at the data port (or in the multicast group) for the others. Lives on the thread that runs the
// io_context; pauses like every source. Takes datagrams from the server's address only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "capture/wire/natnet_session.h"
#include "capture/wire/source.h"

namespace boost::asio {
class io_context;
}

namespace risorius {

struct NatnetSourceOptions {
  std::string host = "127.0.0.1";  ///< of the server: IPv4 address or name
  std::uint16_t command_port = kNatnetCommandPort;
  std::string local_address;    ///< of our interface, IPv4; "": the one from which the system reaches the server
  std::string multicast_group;  ///< "": as the server says
  std::uint16_t data_port = 0;  ///< 0: as the server says, 1511 before it has; and if that is busy, do without
  std::size_t receive_buffer_bytes = 8 * 1024 * 1024;  ///< asked of the kernel for each socket, 1 KiB to 1 GiB
  NatnetOptions session;
};

class NatnetSource : public Source {
 public:
  /// Binds. Throws UserError naming the address or option, and the remedy.
  NatnetSource(boost::asio::io_context& io, const NatnetSourceOptions& options, std::function<void()> on_ready);
  ~NatnetSource() override;

  void tap_raw(const RawTap& tap) noexcept override;
  void start() override;
  void stop() noexcept override;
  void resume() override;
  bool pop(SourceEvent& event) noexcept override;
  void flush() noexcept override;
  std::string endpoint() const override;
  const SourceCounters& counters() const noexcept override;
  bool pop_clock_sample(ClockSample& sample) noexcept override;

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;  ///< shared with the handlers that wait in the io_context
};

}  // namespace risorius
