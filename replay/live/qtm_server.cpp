#include "replay/live/qtm_server.h"

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <fmt/format.h>

#include "capture/version.h"
#include "capture/wire/qtm_settings.h"

namespace risorius {
namespace {

using boost::asio::ip::udp;
using boost::system::error_code;

constexpr std::size_t kLongestRequest = 1 << 15;
constexpr std::string_view kParseError = "Parse error";
// Of Risorius; in the only form that clients can read.
constexpr std::string_view kQtmVersion = "QTM Version is 0.1 (build 0)";

/// Settings of QTM that have nothing to do with markers: known, and empty here.
constexpr std::array<std::string_view, 9> kOtherSections{
    "6d", "analog", "force", "gazevector", "eyetracker", "image", "skeleton", "skeleton:global", "calibration"};
constexpr std::array<std::string_view, 14> kMasterCommands{
    "new",  "close",       "start",     "stop", "load",  "save",      "loadproject",
    "trig", "setqtmevent", "reprocess", "led",  "event", "calibrate", "getcapture"};

std::uint64_t microseconds(std::int64_t ns) noexcept {
  return ns <= 0 ? 0 : (static_cast<std::uint64_t>(ns) + 500) / 1000;
}

std::optional<int> minor_of(std::string_view version) {
  if (!version.starts_with("1.") || version.size() < 3 || version.size() > 4) return {};
  int minor = 0;
  for (const char c : version.substr(2)) {
    if (c < '0' || c > '9') return {};
    minor = 10 * minor + (c - '0');
  }
  return minor;
}

}  // namespace

QtmServer::QtmServer(boost::asio::io_context& io, const QtmServerOptions& options)
    : options_(options),
      tcp_(io, "qtm", options.tcp,
           {.joined = [this](auto id) { greet(id); },
            .received = [this](auto id, auto bytes) { return take(id, bytes); },
            .left = [this](auto id) { clients_.erase(id); }}),
      udp_(io) {}

QtmServer::~QtmServer() { stop(); }

void QtmServer::start(const MarkerSet& set) {
  set_ = set;
  positions_mm_.resize(set.names.size());
  tcp_.start();
}

void QtmServer::stop() noexcept {
  for (const auto& [id, client] : clients_) {
    packet_.clear();
    if (client.stream) append_qtm_no_more_data(packet_);
    append_qtm_event(QtmEvent::kRtFromFileStopped, packet_);
    tcp_.send(id, packet_.bytes());
  }
  tcp_.finish();
  clients_.clear();
}

std::size_t QtmServer::streaming_clients() const noexcept {
  return static_cast<std::size_t>(
      std::count_if(clients_.begin(), clients_.end(), [](const auto& client) { return client.second.stream; }));
}

std::string QtmServer::endpoint() const { return fmt::format("qtm://{}:{}", options_.tcp.address, tcp_.port()); }

void QtmServer::change_set(const MarkerSet& set) {
  set_ = set;
  positions_mm_.resize(set.names.size());
  send_event(QtmEvent::kCameraSettingsChanged);
}

void QtmServer::send_event(QtmEvent event) {
  for (const auto& [id, client] : clients_) say_event(id, event);
}

void QtmServer::greet(TcpServer::ClientId id) {
  ++statistics_.clients;
  clients_[id];
  say(id, "QTM RT Interface connected");
}

void QtmServer::say(TcpServer::ClientId id, std::string_view text) {
  packet_.clear();
  append_qtm_text(QtmPacketType::kCommand, text, packet_);
  tcp_.send(id, packet_.bytes());
}

bool QtmServer::refuse(TcpServer::ClientId id, std::string_view text) {
  packet_.clear();
  append_qtm_text(QtmPacketType::kError, text, packet_);
  tcp_.send(id, packet_.bytes());
  return false;
}

void QtmServer::say_event(TcpServer::ClientId id, QtmEvent event) {
  packet_.clear();
  append_qtm_event(event, packet_);
  tcp_.send(id, packet_.bytes());
}

std::optional<std::size_t> QtmServer::take(TcpServer::ClientId id, std::span<const std::byte> bytes) {
  std::span<const std::byte> rest = bytes;
  while (true) {
    QtmPacket packet;
    const PacketStatus status = take_qtm_packet(rest, kLongestRequest, packet);
    if (status == PacketStatus::kIncomplete) return bytes.size() - rest.size();
    if (status == PacketStatus::kBad) {
      ++statistics_.refused_requests;
      return {};
    }
    const bool answered = packet.type == QtmPacketType::kCommand
                              ? answer(id, clients_[id], qtm_text(packet.body))
                              : refuse(id, "Setting parameters failed");  // they can be read only
    ++(answered ? statistics_.requests : statistics_.refused_requests);
  }
}

/// False if the command was refused.
bool QtmServer::answer(TcpServer::ClientId id, Client& client, std::string_view command) {
  const Words words = qtm_words(command);
  if (words.empty()) return refuse(id, kParseError);
  if (words[0] == "version") return answer_version(id, client, words);
  if (words[0] == "getparameters") return answer_parameters(id, client, words);
  if (words[0] == "streamframes") return answer_stream(id, client, words);
  if (words[0] == "getcurrentframe") return answer_current_frame(id, words);
  if (words[0] == "getstate" || words[0] == "getlastevent") {
    say_event(id, QtmEvent::kRtFromFileStarted);
    return true;
  }
  if (words[0] == "qtmversion") {
    say(id, kQtmVersion);
    return true;
  }
  if (words[0] == "byteorder") {
    if (words.size() > 1 && words[1] != "littleendian") return refuse(id, kParseError);
    say(id, words.size() > 1 ? "Byte order set to little endian" : "Byte order is little endian");
    return true;
  }
  if (words[0] == "quit") {
    say(id, "Bye bye");
    tcp_.close(id);
    return true;
  }
  return answer_control(id, words);
}

bool QtmServer::answer_control(TcpServer::ClientId id, const Words& words) {
  if (words[0] == "takecontrol") return refuse(id, "Wrong or missing password");
  if (words[0] == "releasecontrol") {
    say(id, "You are already a regular client");
    return true;
  }
  if (words[0] == "getcapturec3d" || words[0] == "getcaptureqtm") return refuse(id, "No capture to get");
  if (words[0] == "checklicense") return refuse(id, "License fail");
  const bool known = std::find(kMasterCommands.begin(), kMasterCommands.end(), words[0]) != kMasterCommands.end();
  return refuse(id, known ? "You must be master to issue this command" : kParseError);
}

bool QtmServer::answer_version(TcpServer::ClientId id, Client& client, const Words& words) {
  if (words.size() == 1) {
    say(id, fmt::format("Version is 1.{}", client.minor));
    return true;
  }
  const auto minor = minor_of(words[1]);
  if (!minor || *minor < 1 || *minor > options_.newest_minor) return refuse(id, "Version NOT supported");
  client.minor = *minor;
  say(id, fmt::format("Version set to 1.{}", client.minor));
  return true;
}

bool QtmServer::answer_parameters(TcpServer::ClientId id, const Client& client, const Words& words) {
  QtmSettings settings{.axis_upwards = "+Y"};
  for (std::size_t i = 1; i < words.size(); ++i) {
    const bool all = words[i] == "all";
    if ((all || words[i] == "general") && set_.rate_hz > 0) {
      settings.frequency_hz = set_.rate_hz;
      if (has_frame_ && frame_.header.timecode.frame_rate > 0)
        settings.timecode_rate_hz = frame_.header.timecode.frame_rate;
    }
    if (all || words[i] == "3d") settings.labels = set_.names;
    const bool known = all || words[i] == "general" || words[i] == "3d" ||
                       std::find(kOtherSections.begin(), kOtherSections.end(), words[i]) != kOtherSections.end();
    if (!known) return refuse(id, kParseError);
  }
  if (words.size() == 1) return refuse(id, kParseError);
  packet_.clear();
  append_qtm_text(QtmPacketType::kXml, print_qtm_settings(settings, fmt::format("1.{}", client.minor)), packet_);
  tcp_.send(id, packet_.bytes());
  return true;
}

bool QtmServer::answer_stream(TcpServer::ClientId id, Client& client, const Words& words) {
  if (words.size() == 2 && words[1] == "stop") {
    client.stream.reset();
    return true;  // QTM says nothing to this
  }
  const auto request = parse_qtm_stream_request(words, 1);
  if (!request) return refuse(id, kParseError);
  client.udp.reset();
  if (request->udp) {
    error_code error;
    const std::string address = request->udp_address.empty() ? tcp_.peer_address(id) : request->udp_address;
    const auto to = boost::asio::ip::make_address(address, error);
    if (error) return refuse(id, kParseError);
    client.udp = udp::endpoint(to, request->udp_port);
    if (!udp_.is_open()) udp_.open(client.udp->protocol(), error);
    udp_.non_blocking(true, error);
  }
  client.stream = request;
  client.frames = 0;
  client.due = 1;
  return true;  // the answer is the data
}

bool QtmServer::answer_current_frame(TcpServer::ClientId id, const Words& words) {
  const auto components = parse_qtm_components(words, 1);
  if (!components) return refuse(id, kParseError);
  packet_.clear();
  if (has_frame_) {
    write_frame(*components);
  } else {
    append_qtm_no_more_data(packet_);
  }
  tcp_.send(id, packet_.bytes());
  return true;
}

bool QtmServer::is_due(Client& client) const noexcept {
  const std::uint64_t frame = client.frames++;
  switch (client.stream->rate) {
    case QtmStreamRequest::Rate::kAllFrames:
      return true;
    case QtmStreamRequest::Rate::kDivisor:
      return frame % client.stream->rate_argument == 0;
    case QtmStreamRequest::Rate::kFrequency:
      break;
  }
  if (set_.rate_hz <= 0) return true;
  client.due += std::min(1.0, client.stream->rate_argument / set_.rate_hz);
  if (client.due < 1) return false;
  client.due -= 1;
  return true;
}

void QtmServer::write_frame(const QtmComponents& components) {
  for (std::size_t i = 0; i < positions_mm_.size(); ++i) {
    const Position p = frame_.position_mm[i];
    const bool seen = i < frame_.count && frame_.state[i] == MarkerState::kMeasured;
    positions_mm_[i] = seen ? std::optional(std::array{p.x, p.y, p.z}) : std::nullopt;
  }
  const bool timed = frame_.header.timecode.frame_rate > 0;
  packet_.clear();
  append_qtm_data(microseconds(frame_.header.capture_time_ns), static_cast<std::uint32_t>(frame_.header.sequence),
                  components, positions_mm_, timed ? std::optional(frame_.header.timecode) : std::nullopt, packet_);
}

bool QtmServer::send_packet(TcpServer::ClientId id, const Client& client) {
  if (!client.udp) return tcp_.send_frame(id, packet_.bytes());
  error_code error;
  const auto bytes = packet_.bytes();
  udp_.send_to(boost::asio::buffer(bytes.data(), bytes.size()), *client.udp, 0, error);
  return !error;
}

void QtmServer::send_frame(const MarkerFrame& frame, std::int64_t) {
  ++statistics_.frames;
  frame_ = frame;
  has_frame_ = true;
  for (auto& [id, client] : clients_) {
    if (!client.stream || !is_due(client)) continue;
    write_frame(client.stream->components);
    ++(send_packet(id, client) ? statistics_.frames_sent : statistics_.frames_not_sent);
  }
}

}  // namespace risorius
