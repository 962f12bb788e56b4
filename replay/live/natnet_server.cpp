#include "replay/live/natnet_server.h"

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/multicast.hpp>
#include <fmt/format.h>

#include "capture/errors.h"
#include "capture/monotonic_clock.h"

namespace risorius {
namespace {

using boost::asio::ip::address_v4;
using boost::asio::ip::udp;
using boost::system::error_code;

constexpr std::size_t kMostDatagramsPerWakeUp = 64;
constexpr int kSendBufferBytes = 4 << 20;
constexpr std::int64_t kSettleNs = 50'000'000;  // from a client's request for the model to its readiness for frames
constexpr std::int64_t kLongestSettleNs = 1'000'000'000;
constexpr std::int32_t kModel = 1;
constexpr float kMarkerSizeM = 0.004f;

address_v4 parse_address(const std::string& text, const char* key) {
  error_code error;
  const auto address = boost::asio::ip::make_address_v4(text, error);
  if (error) throw UserError(key, "\"" + text + "\" is no IPv4 address", "such as 127.0.0.1");
  return address;
}

float metres(float mm) noexcept { return static_cast<float>(static_cast<double>(mm) / 1000); }

}  // namespace

NatnetServer::NatnetServer(boost::asio::io_context& io, const NatnetServerOptions& options)
    : options_(options), receive_buffer_(kMaxNatnetDatagramBytes), socket_(io), data_socket_(io) {
  const address_v4 address = parse_address(options.address, "--listen");
  const std::string place = fmt::format("{}:{}", options.address, options.command_port);
  if (options.marker_set.empty() || options.marker_set.size() > 255) {
    throw UserError("--subject", fmt::format("a name of {} bytes", options.marker_set.size()), "give 1 to 255 bytes");
  }
  error_code error;
  socket_.open(udp::v4(), error);
  if (!error) socket_.bind(udp::endpoint(address, options.command_port), error);
  if (error) {
    const bool busy = error == boost::asio::error::address_in_use;
    throw UserError(place, "cannot listen: " + error.message(),
                    busy ? "another server has this port: stop it, or choose another with --listen ADDRESS:PORT"
                         : "choose an address of this machine and a port above 1023");
  }
  socket_.non_blocking(true);
  socket_.set_option(udp::socket::send_buffer_size(kSendBufferBytes), error);
  port_ = socket_.local_endpoint().port();
  open_data_port(address);
  if (options.multicast_group.empty()) return;
  if (!parse_address(options.multicast_group, "--multicast").is_multicast()) {
    throw UserError("--multicast", "\"" + options.multicast_group + "\" is no multicast address",
                    "such as 239.255.42.99");
  }
  udp::socket& sending = data_socket_.is_open() ? data_socket_ : socket_;
  sending.set_option(boost::asio::ip::multicast::outbound_interface(address), error);
  if (error) throw UserError("--multicast", "cannot send from " + options.address + ": " + error.message(), "");
}

NatnetServer::~NatnetServer() { stop(); }

/// OptiTrack's own client library takes frames only if they come from the server's data port. Shared, because clients
/// on this machine may listen on it, too; a client that wants frames *at* that port would then not get them here.
void NatnetServer::open_data_port(const address_v4& address) {
  data_port_ = options_.data_port;
  if (options_.to_data_port) return;
  error_code error;
  data_socket_.open(udp::v4(), error);
  if (!error) data_socket_.set_option(udp::socket::reuse_address(true), error);
  if (!error) data_socket_.bind(udp::endpoint(address, options_.data_port), error);
  if (error) {
    error_code ignored;
    data_socket_.close(ignored);
    data_port_problem_ = fmt::format("port {} is not ours ({})", options_.data_port, error.message());
    return;
  }
  data_socket_.non_blocking(true);
  data_socket_.set_option(udp::socket::send_buffer_size(kSendBufferBytes), error);
  if (data_port_ == 0) data_port_ = data_socket_.local_endpoint().port();
}

void NatnetServer::start(const MarkerSet& set) {
  for (const std::string& name : set.names) {
    if (name.find('\0') != std::string::npos) throw UserError("marker \"" + name + "\"", "has a NUL in its name", "");
  }
  model_ = {{.kind = NatnetAsset::Kind::kMarkerSet, .name = options_.marker_set, .marker_names = set.names}};
  rate_hz_ = static_cast<float>(set.rate_hz);
  markers_.resize(set.names.size());
  running_ = true;
  wait();
}

void NatnetServer::stop() noexcept {
  if (!running_) return;
  running_ = false;
  *alive_ = false;
  encode_bare(NatnetMessage::kDisconnect, reply_);
  for (const Client& client : clients_) reply(client.endpoint);
  error_code ignored;
  socket_.close(ignored);
  data_socket_.close(ignored);
}

void NatnetServer::wait() {
  socket_.async_wait(udp::socket::wait_read, [this, alive = alive_](const error_code& error) {
    if (error || !*alive) return;
    receive_all();
    wait();
  });
}

void NatnetServer::receive_all() {
  for (std::size_t i = 0; i < kMostDatagramsPerWakeUp; ++i) {
    udp::endpoint from;
    error_code error;
    const std::size_t size = socket_.receive_from(boost::asio::buffer(receive_buffer_), from, 0, error);
    if (error == boost::asio::error::would_block) return;
    // Others tell of an earlier datagram that found nobody: a client that is gone says nothing, and is forgotten.
    if (!error) answer(std::span<const std::byte>(receive_buffer_).first(size), from);
  }
}

NatnetServer::Client& NatnetServer::client_of(const udp::endpoint& from) {
  const auto known =
      std::find_if(clients_.begin(), clients_.end(), [&](const Client& client) { return client.endpoint == from; });
  if (known != clients_.end()) return *known;
  ++statistics_.clients;
  return clients_.emplace_back(Client{.endpoint = from, .version = options_.version});
}

void NatnetServer::forget_silent_clients(std::int64_t now_ns) {
  std::erase_if(clients_, [&](const Client& client) { return now_ns - client.heard_ns > options_.client_timeout_ns; });
}

NatnetSuffix NatnetServer::suffix_of(const MarkerFrame& frame, std::int64_t exposure_ns,
                                     std::int64_t now_ns) const noexcept {
  NatnetSuffix suffix;
  const Timecode& timecode = frame.header.timecode;
  if (timecode.frame_rate > 0) {
    suffix.timecode = static_cast<std::uint32_t>(timecode.hours) << 24 |
                      static_cast<std::uint32_t>(timecode.minutes) << 16 |
                      static_cast<std::uint32_t>(timecode.seconds) << 8 | timecode.frames;
  }
  suffix.timestamp_s = static_cast<double>(frame.header.capture_time_ns) * 1e-9;
  suffix.mid_exposure_ticks = static_cast<std::uint64_t>(exposure_ns);
  suffix.data_received_ticks = suffix.transmit_ticks = static_cast<std::uint64_t>(std::max(exposure_ns, now_ns));
  if (recording_) suffix.params = NatnetSuffix::kRecording;
  return suffix;
}

void NatnetServer::encode_for(NatnetVersion version, bool version_changed) {
  NatnetFrameToSend frame = frame_;
  if (version_changed) frame.suffix.params |= NatnetSuffix::kBitstreamChanged;
  encode_frame(frame, version, datagram_);
}

void NatnetServer::send_frame(const MarkerFrame& frame, std::int64_t exposure_ns) {
  using Marker = NatnetLabelledMarker;
  ++statistics_.frames;
  const std::int64_t now_ns = monotonic_now_ns();
  forget_silent_clients(now_ns);
  for (std::size_t i = 0; i < markers_.size(); ++i) {
    const bool seen = i < frame.count && frame.state[i] == MarkerState::kMeasured;
    const Position p = seen ? frame.position_mm[i] : Position{};
    const int params = (seen ? Marker::kPointCloudSolved : Marker::kOccluded) | Marker::kHasModel;
    markers_[i] = {.id = kModel << 16 | static_cast<std::int32_t>(i + 1),
                   .x = metres(p.x),
                   .y = metres(p.y),
                   .z = metres(p.z),
                   .size = kMarkerSizeM,
                   .params = static_cast<std::int16_t>(params)};
  }
  frame_ = {.frame_number = static_cast<std::int32_t>(frame.header.sequence & 0x7FFFFFFF),
            .marker_set = options_.marker_set,
            .markers = markers_,
            .suffix = suffix_of(frame, exposure_ns, now_ns)};
  const auto send = [this](const udp::endpoint& to) {
    error_code error;
    udp::socket& from = data_socket_.is_open() ? data_socket_ : socket_;
    from.send_to(boost::asio::buffer(datagram_), to, 0, error);
    ++(error ? statistics_.frames_not_sent : statistics_.frames_sent);
  };
  if (!options_.multicast_group.empty()) {
    const bool changed =
        std::any_of(clients_.begin(), clients_.end(), [](const Client& c) { return c.version_changed; });
    encode_for(options_.version, changed);
    send({parse_address(options_.multicast_group, "--multicast"), data_port_});
    for (Client& client : clients_) client.version_changed = false;
    return;
  }
  const Client* before = nullptr;
  for (auto client = clients_.begin(); client != clients_.end(); ++client) {
    // Two clients on one machine have one data port.
    const auto same_host = [&](const Client& c) { return c.endpoint.address() == client->endpoint.address(); };
    if (options_.to_data_port && std::find_if(clients_.begin(), client, same_host) != client) continue;
    const bool encoded = before != nullptr && before->version == client->version && !client->version_changed;
    if (!encoded) encode_for(client->version, client->version_changed);
    send(options_.to_data_port ? udp::endpoint(client->endpoint.address(), data_port_) : client->endpoint);
    before = client->version_changed ? nullptr : &*client;
    client->version_changed = false;
  }
}

std::size_t NatnetServer::streaming_clients() const noexcept {
  const std::int64_t now_ns = monotonic_now_ns();
  return static_cast<std::size_t>(std::count_if(clients_.begin(), clients_.end(), [&](const Client& client) {
    if (now_ns - client.heard_ns > options_.client_timeout_ns) return false;  // as send_frame forgets them
    const bool knows_model = client.asked_model_ns != INT64_MAX && now_ns - client.asked_model_ns >= kSettleNs;
    return knows_model || now_ns - client.connected_ns >= kLongestSettleNs;  // some never ask, or asked before
  }));
}

std::string NatnetServer::endpoint() const { return fmt::format("natnet://{}:{}", options_.address, port_); }

void NatnetServer::change_version(NatnetVersion version) noexcept {
  options_.version = version;
  for (Client& client : clients_) {
    client.version_changed = client.version_changed || client.version != version;
    client.version = version;
  }
}

}  // namespace risorius
