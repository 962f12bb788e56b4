#include "replay/live/vicon_server.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

#include "capture/monotonic_clock.h"

namespace risorius {
namespace {

constexpr std::size_t kLongestRequest = 1 << 15;
constexpr std::uint32_t kSubject = 1;
constexpr std::uint64_t kMostOwedFrames = 1000;
constexpr std::array<std::uint32_t, 10> kOffered{1, 2, 5, 6, 7, 23, 26, 37, 39, 42};

}  // namespace

ViconServer::ViconServer(boost::asio::io_context& io, const ViconServerOptions& options)
    : options_(options),
      tcp_(io, "vicon", options.tcp,
           {.joined = [this](auto id) { greet(id); },
            .received = [this](auto id, auto bytes) { return take(id, bytes); },
            .left = [this](auto id) { clients_.erase(id); }}),
      axes_(*Axes::parse(options.y_up ? "FUR" : "FLU")) {}

ViconServer::~ViconServer() { stop(); }

void ViconServer::start(const MarkerSet& set) {
  set_ = set;
  recons_.reserve(set.names.size());
  tcp_.start();
}

void ViconServer::stop() noexcept {
  tcp_.finish();
  clients_.clear();
}

std::size_t ViconServer::streaming_clients() const noexcept {
  // Whatever they want: some clients ask for markers only after they have received something.
  std::size_t count = 0;
  for (const auto& [id, client] : clients_) count += client.push || client.owed_frames > 0 ? 1 : 0;
  return count;
}

std::string ViconServer::endpoint() const { return fmt::format("vicon://{}:{}", options_.tcp.address, tcp_.port()); }

void ViconServer::greet(TcpServer::ClientId id) {
  ++statistics_.clients;
  clients_[id];
  packet_.clear();
  ViconPacketWriter packet(packet_);
  packet.ids(ViconId::kObjectEnums, kOffered);
  packet.finish();
  tcp_.send(id, packet_.bytes());
}

std::optional<std::size_t> ViconServer::take(TcpServer::ClientId id, std::span<const std::byte> bytes) {
  std::span<const std::byte> rest = bytes, objects;
  while (true) {
    ViconError error = ViconError::kNone;
    const PacketStatus status = take_vicon_packet(rest, kLongestRequest, objects, error);
    if (status == PacketStatus::kIncomplete) return bytes.size() - rest.size();
    if (status == PacketStatus::kBad) {
      ++statistics_.refused_requests;
      return {};
    }
    while (!objects.empty()) {
      ViconObject object;
      const bool good = take_vicon_object(objects, object) && take_object(id, clients_[id], object);
      ++(good ? statistics_.requests : statistics_.refused_requests);
      if (!good) return {};
    }
  }
}

/// False if the object is too short for its kind; one that is not known is nothing to answer.
bool ViconServer::take_object(TcpServer::ClientId id, Client& client, const ViconObject& object) {
  switch (static_cast<ViconId>(object.id)) {
    case ViconId::kObjectEnums: {
      const auto ids = decode_vicon_ids(object.body);
      if (!ids) return false;
      client.wanted.clear();
      for (const std::uint32_t offered : kOffered)
        if (ids->contains(offered)) client.wanted.insert(offered);
      return true;
    }
    case ViconId::kRequestFrame: {
      const auto push = decode_vicon_u8(object.body);
      if (!push) return false;
      client.push = *push != 0;
      // A pull is for the latest frame, which is there unless the take has not begun.
      if (!client.push && !(has_frame_ && send_latest(id, client))) ++client.owed_frames;
      return true;
    }
    case ViconId::kRequestNextFrame: {
      const auto count = decode_vicon_u32(object.body);
      if (!count) return false;
      client.owed_frames = std::min(kMostOwedFrames, client.owed_frames + *count);
      return true;
    }
    case ViconId::kPing: {
      const auto number = decode_vicon_i64(object.body);
      if (!number) return false;
      packet_.clear();
      ViconPacketWriter packet(packet_);
      packet.i64(ViconId::kPing, *number);
      packet.finish();
      tcp_.send(id, packet_.bytes());
      return true;
    }
    default:
      return true;
  }
}

void ViconServer::write_subject(ViconPacketWriter& packet) const {
  ViconSubject subject{.id = kSubject, .name = options_.subject, .markers = {}};
  for (std::size_t i = 0; i < set_.names.size(); ++i)
    subject.markers.push_back({.id = static_cast<std::uint32_t>(i + 1), .name = set_.names[i]});
  packet.subject(subject);
}

void ViconServer::write_recons(ViconPacketWriter& packet) {
  recons_.clear();
  for (std::size_t i = 0; i < frame_.count; ++i) {
    if (frame_.state[i] != MarkerState::kMeasured) continue;  // occluded: no record
    const Position p = axes_.from_world(frame_.position_mm[i]);
    recons_.push_back({.subject = kSubject,
                       .marker = static_cast<std::uint32_t>(i + 1),
                       .position_mm = {double{p.x}, double{p.y}, double{p.z}}});
  }
  packet.labelled(recons_);
}

/// Every static object in every packet: a client forgets those that are missing when it gets any.
void ViconServer::write_frame(const Client& client) {
  packet_.clear();
  ViconPacketWriter packet(packet_);
  const auto wants = [&client](ViconId id) { return client.wanted.contains(static_cast<std::uint32_t>(id)); };
  if (wants(ViconId::kStreamInfo) && set_.rate_hz > 0)
    packet.i64(ViconId::kStreamInfo, std::llround(kViconTicksPerSecond / set_.rate_hz));
  if (wants(ViconId::kSubjectInfo)) write_subject(packet);
  if (wants(ViconId::kApplicationInfo)) packet.u8(ViconId::kApplicationInfo, options_.y_up ? 1 : 0);
  if (wants(ViconId::kFrameInfo)) packet.u32(ViconId::kFrameInfo, static_cast<std::uint32_t>(frame_.header.sequence));
  if (wants(ViconId::kTimecode) && frame_.header.timecode.frame_rate > 0) packet.timecode(frame_.header.timecode);
  if (wants(ViconId::kLatencyInfo)) {
    const double seconds = std::max(0.0, static_cast<double>(monotonic_now_ns() - exposure_ns_) * 1e-9);
    const std::array<std::pair<std::string_view, double>, 1> latency{{{"Playback", seconds}}};
    packet.latencies(latency);
  }
  if (wants(ViconId::kFrameRateInfo) && set_.rate_hz > 0) packet.frame_rate("Frame Rate", set_.rate_hz);
  if (wants(ViconId::kLabeledRecons)) write_recons(packet);
  if (wants(ViconId::kUnlabeledRecons)) packet.no_unlabelled();
  packet.finish();
}

bool ViconServer::send_latest(TcpServer::ClientId id, const Client& client) {
  write_frame(client);
  const bool sent = tcp_.send_frame(id, packet_.bytes());
  ++(sent ? statistics_.frames_sent : statistics_.frames_not_sent);
  return sent;
}

void ViconServer::send_frame(const MarkerFrame& frame, std::int64_t exposure_ns) {
  ++statistics_.frames;
  frame_ = frame;
  exposure_ns_ = exposure_ns;
  has_frame_ = true;
  for (auto& [id, client] : clients_) {
    if (!client.push && client.owed_frames == 0) continue;
    if (!client.push) --client.owed_frames;
    send_latest(id, client);
  }
}

}  // namespace risorius
