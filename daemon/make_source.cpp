#include "daemon/make_source.h"

#include <fmt/format.h>
#include <utility>

#include "capture/errors.h"
#include "capture/wire/natnet_source.h"
#include "capture/wire/qtm_session.h"
#include "capture/wire/tracker_client.h"
#include "capture/wire/udp_source.h"
#include "capture/wire/vicon_session.h"
#include "capture/wire/zmq_source.h"
#include "daemon/source_address.h"

namespace risorius {
namespace {

DecoderOptions decoder_options(std::uint32_t stream_id, const SourceConfig& config) {
  DecoderOptions options{.stream_id = stream_id};
  if (!config.units.empty()) options.mm_per_unit = parse_unit(config.units);
  if (!config.axes.empty()) options.axes = Axes::parse(config.axes);
  return options;
}

/// ZeroMQ writes "any port" as a star.
std::string zmq_endpoint(const SourceAddress& listen) {
  return (listen.host.find(':') == std::string::npos ? "tcp://" + listen.host : "tcp://[" + listen.host + "]") + ":" +
         (listen.port == 0 ? "*" : std::to_string(listen.port));
}

ZmqSourceOptions zmq_options(const SourceAddress& address, std::uint32_t stream_id, const SourceConfig& config) {
  ZmqSourceOptions options;
  options.endpoint = zmq_endpoint(address);
  options.pattern = config.zmq_pattern == "sub" ? ZmqPattern::kSubscribe : ZmqPattern::kPull;
  options.high_water_mark = static_cast<int>(config.zmq_high_water_mark);
  options.curve =
      load_curve_server(config.curve_key, config.curve_clients, fmt::format("[[source]] \"{}\"", config.name));
  options.decoder = decoder_options(stream_id, config);
  return options;
}

NatnetSourceOptions natnet_options(const SourceAddress& address, std::uint32_t stream_id, const SourceConfig& config) {
  NatnetSourceOptions options{.host = address.host, .command_port = address.port};
  options.local_address = config.natnet_local_address;
  options.multicast_group = config.natnet_multicast_group;
  options.data_port = static_cast<std::uint16_t>(config.natnet_data_port);
  options.receive_buffer_bytes = static_cast<std::size_t>(config.receive_buffer_bytes);
  NatnetOptions& session = options.session;
  session.stream_id = stream_id;
  session.markers = config.natnet_markers;
  if (!config.units.empty()) session.mm_per_unit = parse_unit(config.units).value_or(session.mm_per_unit);
  if (!config.axes.empty()) session.axes = Axes::parse(config.axes).value_or(session.axes);
  const NatnetTimecode timecode = parse_natnet_timecode(config.natnet_timecode).value_or(NatnetTimecode{});
  session.timecode_rate = timecode.rate;
  session.timecode_drop_frame = timecode.drop_frame;
  return options;
}

TrackerSessionOptions session_options(std::uint32_t stream_id, const SourceConfig& config) {
  TrackerSessionOptions options{.stream_id = stream_id};
  if (!config.units.empty()) options.mm_per_unit = parse_unit(config.units);
  if (!config.axes.empty()) options.axes = Axes::parse(config.axes);
  return options;
}

TrackerClientOptions client_options(const SourceAddress& address, const SourceConfig& config) {
  const auto buffer_bytes = static_cast<std::size_t>(config.receive_buffer_bytes);
  return {.url = to_url(address),
          .link = {.host = address.host, .port = address.port, .receive_buffer_bytes = buffer_bytes},
          .receive_buffer_bytes = buffer_bytes};
}

std::unique_ptr<Source> make_qtm_source(boost::asio::io_context& io, const SourceAddress& address,
                                        std::uint32_t stream_id, const SourceConfig& config,
                                        std::function<void()> on_ready) {
  TrackerClientOptions options = client_options(address, config);
  options.udp_frames = config.qtm_frames == "udp";
  const QtmSessionOptions session{.tracker = session_options(stream_id, config),
                                  .label_prefix = config.qtm_label_prefix};
  return std::make_unique<TrackerClient>(io, options, std::make_unique<QtmSession>(session), std::move(on_ready));
}

std::unique_ptr<Source> make_vicon_source(boost::asio::io_context& io, const SourceAddress& address,
                                          std::uint32_t stream_id, const SourceConfig& config,
                                          std::function<void()> on_ready) {
  const ViconSessionOptions options{
      .tracker = session_options(stream_id, config), .subject = config.vicon_subject, .rate_hz = config.vicon_rate_hz};
  return std::make_unique<TrackerClient>(io, client_options(address, config), std::make_unique<ViconSession>(options),
                                         std::move(on_ready));
}

}  // namespace

std::unique_ptr<Source> make_source(boost::asio::io_context& io, std::uint32_t stream_id, const SourceConfig& config,
                                    std::function<void()> on_ready) {
  const SourceAddress address = parse_source_address(config.listen);
  const auto buffer_bytes = static_cast<std::size_t>(config.receive_buffer_bytes);
  switch (address.kind) {
    case SourceKind::kUdp:
      return std::make_unique<UdpSource>(io,
                                         UdpSourceOptions{.address = address.host,
                                                          .port = address.port,
                                                          .receive_buffer_bytes = buffer_bytes,
                                                          .decoder = decoder_options(stream_id, config)},
                                         std::move(on_ready));
    case SourceKind::kZmq:
      return std::make_unique<ZmqSource>(io, zmq_options(address, stream_id, config), std::move(on_ready));
    case SourceKind::kNatnet:
      return std::make_unique<NatnetSource>(io, natnet_options(address, stream_id, config), std::move(on_ready));
    case SourceKind::kLiveLink:
      return std::make_unique<LiveLinkSource>(io,
                                              LiveLinkSourceOptions{.address = address.host,
                                                                    .port = address.port,
                                                                    .receive_buffer_bytes = buffer_bytes,
                                                                    .decoder = {.stream_id = stream_id,
                                                                                .device = config.livelink_device,
                                                                                .rate_hz = config.livelink_rate_hz}},
                                              std::move(on_ready));
    case SourceKind::kQtm:
      return make_qtm_source(io, address, stream_id, config, std::move(on_ready));
    case SourceKind::kVicon:
      return make_vicon_source(io, address, stream_id, config, std::move(on_ready));
  }
  throw UserError(config.listen, "this build has no client for it", "use udp:// or zmq+tcp://");
}

bool tells_shapes(const SourceConfig& config) {
  return parse_source_address(config.listen).kind == SourceKind::kLiveLink;
}

}  // namespace risorius
