// OptiTrack's side of NatNet: answers every form of CONNECT, describes one marker set, streams it unicast or multicast
// in the layouts of 3.0 to 4.1, as labelled markers and as the legacy marker set. Its clock is CLOCK_MONOTONIC in ns.
#pragma once

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "capture/wire/natnet_codec.h"
#include "replay/live/tracker_server.h"

namespace risorius {

struct NatnetServerOptions {
  std::string address = "127.0.0.1";                ///< of the interface to listen on and to send from, IPv4
  std::uint16_t command_port = kNatnetCommandPort;  ///< 0: the system chooses
  std::string multicast_group;                      ///< "": unicast
  std::uint16_t data_port = kNatnetDataPort;  ///< frames come from it, and go to it of the group; 0: unicast only,
                                              ///< the system chooses
  bool to_data_port = false;  ///< unicast frames go to this port of the client, from our command port; else from our
                              ///< data port to the port that the client commands from
  NatnetVersion version{4, 1};
  std::string marker_set = "face";                  ///< the marker set's name, 1 to 255 bytes
  std::int64_t client_timeout_ns = 10'000'000'000;  ///< a client that says nothing so long is forgotten
};

class NatnetServer : public TrackerServer {
 public:
  /// Binds. Throws UserError naming the address or option, and the remedy.
  NatnetServer(boost::asio::io_context& io, const NatnetServerOptions& options);
  ~NatnetServer() override;

  void start(const MarkerSet& set) override;
  void send_frame(const MarkerFrame& frame, std::int64_t exposure_ns) override;
  void stop() noexcept override;
  /// Those that have had the time to understand the model definition, whether they asked for it or not.
  std::size_t streaming_clients() const noexcept override;
  std::string endpoint() const override;
  const TrackerServerStatistics& statistics() const noexcept override { return statistics_; }

  /// As somebody could do at the tracker while it streams: for all clients, and those to come.
  void change_version(NatnetVersion version) noexcept;
  void set_recording(bool recording) noexcept { recording_ = recording; }
  /// Why frames come from the command port and not, as some clients demand, from the data port; empty if they do not.
  const std::string& data_port_problem() const noexcept { return data_port_problem_; }

 private:
  using udp = boost::asio::ip::udp;
  struct Client {
    udp::endpoint endpoint;
    NatnetVersion version;
    bool version_changed = false;  ///< the next frame says so
    std::int64_t heard_ns = 0, connected_ns = 0;
    std::int64_t asked_model_ns = INT64_MAX;
  };

  void open_data_port(const boost::asio::ip::address_v4& address);
  void wait();
  void receive_all();
  void answer(std::span<const std::byte> datagram, const udp::endpoint& from);
  bool answer_command(std::string_view command, Client& client);
  bool answer_bitstream(std::string_view version, Client& client);
  Client& client_of(const udp::endpoint& from);
  void forget_silent_clients(std::int64_t now_ns);
  void adopt_asked_version(std::span<const std::byte> connect, Client& client) const noexcept;
  bool reply(const udp::endpoint& to);
  NatnetSuffix suffix_of(const MarkerFrame& frame, std::int64_t exposure_ns, std::int64_t now_ns) const noexcept;
  void encode_for(NatnetVersion version, bool version_changed);
  NatnetServerInfo info(NatnetVersion version) const;

  NatnetServerOptions options_;
  std::vector<std::byte> receive_buffer_;
  udp::socket socket_;       ///< commands
  udp::socket data_socket_;  ///< frames; closed where they come from socket_
  std::uint16_t port_ = 0, data_port_ = 0;
  std::string data_port_problem_;
  std::vector<Client> clients_;
  std::vector<NatnetAsset> model_;
  float rate_hz_ = 0;
  bool running_ = false, recording_ = false;
  std::vector<NatnetLabelledMarker> markers_;
  NatnetFrameToSend frame_;
  NatnetDatagram datagram_, reply_;
  TrackerServerStatistics statistics_;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);  ///< false for handlers that outlive the server
};

/// "3.0" to "4.1". Throws UserError.
NatnetVersion parse_natnet_version(std::string_view text);

}  // namespace risorius
