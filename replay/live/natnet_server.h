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
  std::uint16_t data_port = kNatnetDataPort;        ///< of the group, and of clients where to_data_port
  bool to_data_port = false;  ///< unicast frames go to the client's data port; else to the port that it commands from
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
  /// Those that have asked for the model definition, and have had the time to understand it.
  std::size_t streaming_clients() const noexcept override;
  std::string endpoint() const override;
  const TrackerServerStatistics& statistics() const noexcept override { return statistics_; }

  /// As somebody could do at the tracker while it streams: for all clients, and those to come.
  void change_version(NatnetVersion version) noexcept;
  void set_recording(bool recording) noexcept { recording_ = recording; }

 private:
  using udp = boost::asio::ip::udp;
  struct Client {
    udp::endpoint endpoint;
    NatnetVersion version;
    bool version_changed = false;  ///< the next frame says so
    std::int64_t heard_ns = 0;
    std::int64_t asked_model_ns = INT64_MAX;
  };

  void wait();
  void receive_all();
  void answer(std::span<const std::byte> datagram, const udp::endpoint& from);
  bool answer_command(std::string_view command, Client& client);
  bool answer_bitstream(std::string_view version, Client& client);
  Client& client_of(const udp::endpoint& from);
  void forget_silent_clients(std::int64_t now_ns);
  bool reply(const udp::endpoint& to);
  NatnetSuffix suffix_of(const MarkerFrame& frame, std::int64_t exposure_ns, std::int64_t now_ns) const noexcept;
  void encode_for(NatnetVersion version, bool version_changed);
  NatnetServerInfo info(NatnetVersion version) const;

  NatnetServerOptions options_;
  std::vector<std::byte> receive_buffer_;
  udp::socket socket_;
  std::uint16_t port_ = 0;
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
