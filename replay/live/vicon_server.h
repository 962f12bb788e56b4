// A Vicon DataStream server that plays frames: one subject with the take's markers, pushed or pulled, with what each
// client wants so far. Tells positions as Vicon does: mm, Z up.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "capture/wire/byte_appender.h"
#include "capture/wire/vicon_codec.h"
#include "capture/wire/vicon_packet_writer.h"
#include "replay/live/tcp_server.h"
#include "replay/live/tracker_server.h"

namespace risorius {

struct ViconServerOptions {
  TcpServerOptions tcp{.port = 801};
  std::string subject = "face";
  bool y_up = false;
};

class ViconServer : public TrackerServer {
 public:
  /// Binds. Throws UserError.
  ViconServer(boost::asio::io_context& io, const ViconServerOptions& options);
  ~ViconServer() override;

  void start(const MarkerSet& set) override;
  void send_frame(const MarkerFrame& frame, std::int64_t exposure_ns) override;
  void stop() noexcept override;
  std::size_t streaming_clients() const noexcept override;
  std::string endpoint() const override;
  const TrackerServerStatistics& statistics() const noexcept override { return statistics_; }

 private:
  struct Client {
    std::set<std::uint32_t> wanted;
    bool push = false;
    std::uint64_t owed_frames = 0;  ///< asked for one by one
  };

  void greet(TcpServer::ClientId id);
  std::optional<std::size_t> take(TcpServer::ClientId id, std::span<const std::byte> bytes);
  bool take_object(TcpServer::ClientId id, Client& client, const ViconObject& object);
  void write_frame(const Client& client);
  void write_subject(ViconPacketWriter& packet) const;
  void write_recons(ViconPacketWriter& packet);
  bool send_latest(TcpServer::ClientId id, const Client& client);

  ViconServerOptions options_;
  TcpServer tcp_;
  TrackerServerStatistics statistics_;
  std::map<TcpServer::ClientId, Client> clients_;
  MarkerSet set_;
  Axes axes_;
  bool has_frame_ = false;
  MarkerFrame frame_;
  std::int64_t exposure_ns_ = 0;
  std::vector<ViconRecon> recons_;
  ByteAppender packet_;
};

}  // namespace risorius
