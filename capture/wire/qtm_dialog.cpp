#include "capture/wire/qtm_dialog.h"

#include <array>
#include <fmt/format.h>
#include <utility>

namespace risorius {
namespace {

// 1.8 brought the component header that decode_qtm_data reads; what came after 1.27 does not concern markers.
constexpr int kNewestMinor = 27, kOldestMinor = 8, kMinorWithoutVersion = 1;
constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kReplyTimeoutNs = 5 * kSecond;
constexpr std::int64_t kOptionalReplyTimeoutNs = kSecond;
constexpr std::int64_t kRestNs = kSecond;  ///< until a server that has no data is asked again
constexpr std::int64_t kNoDataTimeoutNs = 3 * kSecond;
constexpr std::int64_t kSilenceTimeoutNs = 5 * kSecond;
constexpr std::string_view kGreeting = "QTM RT Interface connected";
constexpr std::string_view kVersionSet = "Version set to 1.";
// Servers refuse a whole command for one component that they do not have.
constexpr std::array<std::string_view, 3> kComponents{"3D 3DNoLabels Timecode", "3D Timecode", "3D"};

bool begins_with(std::string_view text, std::string_view words) noexcept {
  if (text.size() < words.size()) return false;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
    if (lower(text[i]) != lower(words[i])) return false;
  }
  return true;
}

int minor_in(std::string_view reply) noexcept {
  int minor = 0;
  for (const char c : reply.substr(kVersionSet.size())) {
    if (c < '0' || c > '9' || minor > 1000) break;
    minor = 10 * minor + (c - '0');
  }
  return minor;
}

}  // namespace

std::string QtmDialog::version() const { return fmt::format("1.{}", minor_); }

void QtmDialog::connected(std::uint16_t udp_port, std::int64_t now_ns) {
  udp_port_ = udp_port;
  settings_ = {};
  minor_ = kMinorWithoutVersion;
  attempt_ = 0;
  failed_ = data_came_ = refreshing_ = refresh_wanted_ = false;
  phase_ = Phase::kGreeting;
  asked_ns_ = heard_ns_ = probed_ns_ = refreshed_ns_ = now_ns;
}

void QtmDialog::say(std::string_view command, std::int64_t now_ns) {
  append_qtm_text(QtmPacketType::kCommand, command, out_);
  asked_ns_ = now_ns;
}

void QtmDialog::ask(Phase phase, std::int64_t now_ns) {
  phase_ = phase;
  switch (phase) {
    case Phase::kVersion:
      return say(fmt::format("Version 1.{}", minor_), now_ns);
    case Phase::kState:
      return say("GetState", now_ns);
    case Phase::kGeneral:
      return say("GetParameters General", now_ns);
    case Phase::kMarkers:
      refreshed_ns_ = now_ns;
      return say("GetParameters 3D", now_ns);
    default:
      return;
  }
}

void QtmDialog::ask_stream(std::int64_t now_ns) {
  phase_ = Phase::kStreaming;
  data_came_ = false;
  const std::string udp = udp_port_ == 0 ? "" : fmt::format("UDP:{} ", udp_port_);
  say(fmt::format("StreamFrames AllFrames {}{}", udp, kComponents[attempt_]), now_ns);
}

void QtmDialog::ask_next_version(std::int64_t now_ns) {
  if (minor_ > kOldestMinor) {
    --minor_;
    return ask(Phase::kVersion, now_ns);
  }
  minor_ = kMinorWithoutVersion;
  ask(Phase::kState, now_ns);
}

void QtmDialog::rest(std::int64_t now_ns) noexcept {
  phase_ = Phase::kResting;
  asked_ns_ = now_ns;
}

void QtmDialog::on_text(std::string_view text, bool error, std::int64_t now_ns) {
  heard_ns_ = now_ns;
  switch (phase_) {
    case Phase::kGreeting:
      if (error || !begins_with(text, kGreeting)) {
        failed_ = true;
        return;
      }
      minor_ = kNewestMinor;
      return ask(Phase::kVersion, now_ns);
    case Phase::kVersion:
      if (error || !begins_with(text, kVersionSet)) return ask_next_version(now_ns);
      minor_ = minor_in(text);
      return ask(Phase::kState, now_ns);
    case Phase::kState:
      return ask(Phase::kGeneral, now_ns);
    case Phase::kGeneral:
      return ask(Phase::kMarkers, now_ns);
    case Phase::kMarkers:
      return rest(now_ns);
    case Phase::kStreaming:
      if (std::exchange(refreshing_, false) || !error || data_came_) return;
      if (++attempt_ < kComponents.size()) return ask_stream(now_ns);
      attempt_ = 0;
      return rest(now_ns);
    case Phase::kResting:
    case Phase::kOff:
      return;
  }
}

bool QtmDialog::on_xml(std::string_view xml, std::int64_t now_ns) {
  heard_ns_ = now_ns;
  auto read = parse_qtm_settings(xml);
  if (read) {
    if (read->labels) {
      settings_.labels = std::move(read->labels);
      settings_.axis_upwards = std::move(read->axis_upwards);
    }
    if (read->frequency_hz) settings_.frequency_hz = read->frequency_hz;
    if (read->timecode_rate_hz) settings_.timecode_rate_hz = read->timecode_rate_hz;
  }
  refreshing_ = false;
  if (phase_ == Phase::kGeneral) {
    ask(Phase::kMarkers, now_ns);
  } else if (phase_ == Phase::kMarkers) {
    // Without labels there is nothing to solve; they come with a measurement or a model.
    if (settings_.labels && !settings_.labels->empty()) {
      ask_stream(now_ns);
    } else {
      rest(now_ns);
    }
  }
  return read.has_value();
}

void QtmDialog::on_event(QtmEvent event, std::int64_t now_ns) {
  heard_ns_ = now_ns;
  if (phase_ == Phase::kState) return ask(Phase::kGeneral, now_ns);
  switch (event) {
    case QtmEvent::kConnected:
    case QtmEvent::kCaptureStarted:
    case QtmEvent::kRtFromFileStarted:
      if (phase_ == Phase::kResting) return ask(Phase::kMarkers, now_ns);
      break;
    case QtmEvent::kCameraSettingsChanged:
      if (phase_ == Phase::kStreaming) refresh_labels(now_ns);
      break;
    default:
      break;
  }
}

void QtmDialog::on_data(std::int64_t now_ns) noexcept {
  heard_ns_ = now_ns;
  data_came_ = true;
}

void QtmDialog::on_no_more_data(std::int64_t now_ns) {
  heard_ns_ = now_ns;
  if (phase_ == Phase::kStreaming) rest(now_ns);
}

void QtmDialog::refresh_labels(std::int64_t now_ns) {
  // Asked for too soon, it waits for a Tick.
  refresh_wanted_ = true;
  if (phase_ != Phase::kStreaming || refreshing_ || now_ns - refreshed_ns_ < kSecond) return;
  refresh_wanted_ = false;
  refreshing_ = true;
  refreshed_ns_ = now_ns;
  append_qtm_text(QtmPacketType::kCommand, "GetParameters 3D", out_);
}

void QtmDialog::tick(std::int64_t now_ns) {
  const std::int64_t waited_ns = now_ns - asked_ns_;
  switch (phase_) {
    case Phase::kOff:
      return;
    case Phase::kGreeting:
    case Phase::kVersion:
    case Phase::kMarkers:
      failed_ = failed_ || waited_ns > kReplyTimeoutNs;
      return;
    case Phase::kState:
      if (waited_ns > kOptionalReplyTimeoutNs) ask(Phase::kGeneral, now_ns);
      return;
    case Phase::kGeneral:
      if (waited_ns > kOptionalReplyTimeoutNs) ask(Phase::kMarkers, now_ns);
      return;
    case Phase::kResting:
      if (waited_ns > kRestNs) ask(Phase::kMarkers, now_ns);
      return;
    case Phase::kStreaming:
      break;
  }
  if (refresh_wanted_) refresh_labels(now_ns);
  if (!data_came_ && waited_ns > kNoDataTimeoutNs) {
    attempt_ = (attempt_ + 1) % kComponents.size();
    return ask_stream(now_ns);
  }
  if (now_ns - heard_ns_ <= kSilenceTimeoutNs || now_ns - probed_ns_ <= kSilenceTimeoutNs) return;
  // Silent since the last probe: the connection is dead, though nobody closed it.
  if (probed_ns_ > heard_ns_) {
    failed_ = true;
    return;
  }
  probed_ns_ = now_ns;
  append_qtm_text(QtmPacketType::kCommand, "GetState", out_);
}

}  // namespace risorius
