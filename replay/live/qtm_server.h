// A server of QTM's real-time protocol that plays frames, as QTM does in "RT from file": several clients, each with the
// version, rate, transport and components that it asked for. Tells positions in mm with Y up.
#pragma once

#include <boost/asio/ip/udp.hpp>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "capture/wire/byte_appender.h"
#include "capture/wire/qtm_codec.h"
#include "replay/live/qtm_request.h"
#include "replay/live/tcp_server.h"
#include "replay/live/tracker_server.h"

namespace risorius {

struct QtmServerOptions {
  TcpServerOptions tcp{.port = 22223};
  int newest_minor = 27;  ///< of the versions 1.1 to 1.n that are accepted
};

class QtmServer : public TrackerServer {
 public:
  /// Binds. Throws UserError.
  QtmServer(boost::asio::io_context& io, const QtmServerOptions& options);
  ~QtmServer() override;

  void start(const MarkerSet& set) override;
  void send_frame(const MarkerFrame& frame, std::int64_t exposure_ns) override;
  void stop() noexcept override;
  std::size_t streaming_clients() const noexcept override;
  std::string endpoint() const override;
  const TrackerServerStatistics& statistics() const noexcept override { return statistics_; }

  /// The same take under other labels, as when QTM changes its settings while streaming: clients are told by an event.
  void change_set(const MarkerSet& set);
  /// To all clients.
  void send_event(QtmEvent event);

 private:
  using Words = std::vector<std::string>;
  struct Client {
    int minor = 1;
    std::optional<QtmStreamRequest> stream;
    std::optional<boost::asio::ip::udp::endpoint> udp;
    std::uint64_t frames = 0;  ///< since streaming began
    double due = 1;            ///< Frequency:n: a frame is sent when this reaches 1
  };

  void greet(TcpServer::ClientId id);
  std::optional<std::size_t> take(TcpServer::ClientId id, std::span<const std::byte> bytes);
  bool answer(TcpServer::ClientId id, Client& client, std::string_view command);
  bool answer_version(TcpServer::ClientId id, Client& client, const Words& words);
  bool answer_parameters(TcpServer::ClientId id, const Client& client, const Words& words);
  bool answer_stream(TcpServer::ClientId id, Client& client, const Words& words);
  bool answer_current_frame(TcpServer::ClientId id, const Words& words);
  bool answer_control(TcpServer::ClientId id, const Words& words);
  void say(TcpServer::ClientId id, std::string_view text);
  bool refuse(TcpServer::ClientId id, std::string_view text);
  void say_event(TcpServer::ClientId id, QtmEvent event);
  bool is_due(Client& client) const noexcept;
  void write_frame(const QtmComponents& components);
  bool send_packet(TcpServer::ClientId id, const Client& client);

  QtmServerOptions options_;
  TcpServer tcp_;
  boost::asio::ip::udp::socket udp_;
  TrackerServerStatistics statistics_;
  std::map<TcpServer::ClientId, Client> clients_;
  MarkerSet set_;
  bool has_frame_ = false;
  MarkerFrame frame_;
  std::vector<std::optional<std::array<float, 3>>> positions_mm_;
  ByteAppender packet_;
};

}  // namespace risorius
