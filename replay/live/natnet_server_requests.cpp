// What a NatnetServer answers.
#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <charconv>
#include <fmt/format.h>

#include "capture/errors.h"
#include "capture/monotonic_clock.h"
#include "replay/live/natnet_server.h"

namespace risorius {
namespace {

using boost::asio::ip::udp;
using boost::system::error_code;

constexpr std::uint64_t kClockFrequency = 1'000'000'000;
constexpr NatnetVersion kOldest{3, 0}, kNewest{4, 1};

}  // namespace

NatnetVersion parse_natnet_version(std::string_view text) {
  NatnetVersion version;
  const char* end = text.data() + text.size();
  const auto major = std::from_chars(text.data(), end, version.major);
  const bool has_minor = major.ec == std::errc() && major.ptr != end && *major.ptr == '.';
  const auto minor = has_minor ? std::from_chars(major.ptr + 1, end, version.minor) : major;
  // "4.1.0.0" means the same.
  const bool ends = minor.ptr == end || *minor.ptr == '.';
  if (!has_minor || minor.ec != std::errc() || !ends || version < kOldest || version > kNewest) {
    throw UserError("NatNet version", "\"" + std::string(text) + "\" is none that can be served", "give 3.0 to 4.1");
  }
  return version;
}

void NatnetServer::answer(std::span<const std::byte> datagram, const udp::endpoint& from) {
  NatnetPacket packet;
  if (decode_natnet(datagram, packet) != NatnetError::kNone) {
    ++statistics_.refused_requests;
    return;
  }
  const std::int64_t now_ns = monotonic_now_ns();
  const auto known =
      std::find_if(clients_.begin(), clients_.end(), [&](const Client& client) { return client.endpoint == from; });
  if (known != clients_.end()) known->heard_ns = now_ns;
  ++statistics_.requests;
  switch (packet.message()) {
    case NatnetMessage::kConnect: {
      Client& client = client_of(from);
      client.heard_ns = now_ns;
      if (client.connected_ns == 0) client.connected_ns = now_ns;
      adopt_asked_version(packet.payload, client);
      encode_server_info(info(client.version), reply_);
      reply(from);
      return;
    }
    case NatnetMessage::kDiscovery:
      encode_server_info(info(options_.version), reply_);
      reply(from);
      return;
    case NatnetMessage::kRequestModelDef:
      encode_model(model_, known != clients_.end() ? known->version : options_.version, reply_);
      reply(from);
      if (known != clients_.end()) known->asked_model_ns = std::min(known->asked_model_ns, now_ns);
      return;
    case NatnetMessage::kRequestFrameOfData:
      if (frame_.markers.empty()) break;
      encode_frame(frame_, known != clients_.end() ? known->version : options_.version, reply_);
      reply(from);
      return;
    case NatnetMessage::kEchoRequest: {
      NatnetEcho echo;
      if (decode_echo_request(packet.payload, echo) != NatnetError::kNone) break;
      echo.host_ticks = static_cast<std::uint64_t>(now_ns);
      encode_echo_response(echo, reply_);
      reply(from);
      return;
    }
    case NatnetMessage::kRequest: {
      Client stranger{.endpoint = from, .version = options_.version};
      if (answer_command(decode_text(packet.payload), known != clients_.end() ? *known : stranger)) {
        reply(from);
        return;
      }
      break;
    }
    case NatnetMessage::kKeepAlive:
      return;
    case NatnetMessage::kDisconnect:
      if (known != clients_.end()) clients_.erase(known);
      return;
    default:
      break;
  }
  --statistics_.requests;
  ++statistics_.refused_requests;
  encode_bare(NatnetMessage::kUnrecognizedRequest, reply_);
  reply(from);
}

/// The commands that make sense for a take that plays; the answer is in reply_.
bool NatnetServer::answer_command(std::string_view command, Client& client) {
  constexpr std::string_view kBitstream = "Bitstream,";
  constexpr std::array<std::string_view, 6> kWithoutEffect{"LiveMode",     "EditMode",        "TimelinePlay",
                                                           "TimelineStop", "SubscribeToData", "SubscribedDataOnly"};
  constexpr std::array<std::string_view, 4> kWithoutEffectOn{"SetPlayback", "SubscribeToData,", "EnableAsset,",
                                                             "DisableAsset,"};
  if (command == "Bitstream") {
    encode_text(NatnetMessage::kResponse, fmt::format("Bitstream,{}.{}", client.version.major, client.version.minor),
                reply_);
    return true;
  }
  if (command.starts_with(kBitstream)) return answer_bitstream(command.substr(kBitstream.size()), client);
  if (command == "FrameRate") {
    encode_response(rate_hz_, reply_);
  } else if (command == "UnitsToMillimeters") {
    encode_response(1000.0f, reply_);
  } else if (command == "UpAxis") {
    encode_response(std::int32_t{1}, reply_);  // Y
  } else if (command == "AnalogSamplesPerMocapFrame" || command == "CurrentMode") {
    encode_response(std::int32_t{0}, reply_);  // none; live
  } else if (command == "StartRecording" || command == "StopRecording") {
    recording_ = command == "StartRecording";
    encode_response(std::int32_t{0}, reply_);
  } else if (std::ranges::find(kWithoutEffect, command) != kWithoutEffect.end() ||
             std::ranges::any_of(kWithoutEffectOn,
                                 [&](std::string_view begin) { return command.starts_with(begin); })) {
    // A take that plays is live, and all of it is sent: what they ask for is so already, or makes no difference.
    encode_response(std::int32_t{0}, reply_);
  } else {
    return false;
  }
  return true;
}

bool NatnetServer::answer_bitstream(std::string_view version, Client& client) {
  try {
    const NatnetVersion wanted = parse_natnet_version(version);
    if (!options_.multicast_group.empty()) change_version(wanted);  // all get the same bytes
    client.version_changed = client.version_changed || client.version != wanted;
    client.version = wanted;
  } catch (const UserError&) {
    return false;
  }
  encode_response(std::int32_t{0}, reply_);
  return true;
}

/// Behind its own name and versions a client may say which bit stream it wants; in multicast all get the same.
void NatnetServer::adopt_asked_version(std::span<const std::byte> connect, Client& client) const noexcept {
  constexpr std::size_t kAt = 265;  // 264 bytes of the sender, one for a choice of assets
  if (connect.size() < kAt + 4 || !options_.multicast_group.empty()) return;
  const NatnetVersion asked{std::to_integer<std::uint8_t>(connect[kAt]),
                            std::to_integer<std::uint8_t>(connect[kAt + 1])};
  if (asked.major != 0) client.version = std::clamp(asked, kOldest, kNewest);
}

bool NatnetServer::reply(const udp::endpoint& to) {
  error_code error;
  socket_.send_to(boost::asio::buffer(reply_), to, 0, error);
  return !error;
}

NatnetServerInfo NatnetServer::info(NatnetVersion version) const {
  NatnetServerInfo info{.name = "Risorius",
                        .application_version = {0, 1, 0, 0},
                        .version = version,
                        .clock_frequency = kClockFrequency,
                        .data_port = data_port_,
                        .multicast = !options_.multicast_group.empty()};
  if (info.multicast) info.group = boost::asio::ip::make_address_v4(options_.multicast_group).to_bytes();
  return info;
}

}  // namespace risorius
