// The commands of a QTM client and their replies, in order: greeting, version (downwards until one is accepted), state,
// settings, labels, streaming; later labels again when settings change. One command is under way at a time, because
// replies do not say what they answer. Events come between replies.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "capture/wire/byte_appender.h"
#include "capture/wire/qtm_codec.h"
#include "capture/wire/qtm_settings.h"

namespace risorius {

class QtmDialog {
 public:
  explicit QtmDialog(ByteAppender& out) : out_(out) {}

  /// `udp_port` 0: data over TCP.
  void connected(std::uint16_t udp_port, std::int64_t now_ns);
  void disconnected() noexcept { phase_ = Phase::kOff; }
  /// An error packet (`error`) or a command packet.
  void on_text(std::string_view text, bool error, std::int64_t now_ns);
  /// False if it is no settings document.
  bool on_xml(std::string_view xml, std::int64_t now_ns);
  void on_event(QtmEvent event, std::int64_t now_ns);
  void on_data(std::int64_t now_ns) noexcept;
  void on_no_more_data(std::int64_t now_ns);
  /// Asks for the labels again, now or when a second has passed since the last time.
  void refresh_labels(std::int64_t now_ns);
  void tick(std::int64_t now_ns);

  /// The server does not answer, or not as QTM does.
  bool failed() const noexcept { return failed_; }
  /// Whether the next text answers "Version".
  bool asks_version() const noexcept { return phase_ == Phase::kVersion; }
  bool streaming() const noexcept { return phase_ == Phase::kStreaming; }
  const QtmSettings& settings() const noexcept { return settings_; }
  /// "1.13"; "1.1" where no version was accepted.
  std::string version() const;

 private:
  enum class Phase : std::uint8_t { kOff, kGreeting, kVersion, kState, kGeneral, kMarkers, kStreaming, kResting };

  void say(std::string_view command, std::int64_t now_ns);
  void ask(Phase phase, std::int64_t now_ns);
  void ask_stream(std::int64_t now_ns);
  void ask_next_version(std::int64_t now_ns);
  void rest(std::int64_t now_ns) noexcept;

  ByteAppender& out_;
  QtmSettings settings_;
  Phase phase_ = Phase::kOff;
  std::uint16_t udp_port_ = 0;
  int minor_ = 0;
  std::size_t attempt_ = 0;  ///< which row of components to ask for
  bool failed_ = false, data_came_ = false, refreshing_ = false, refresh_wanted_ = false;
  std::int64_t asked_ns_ = 0;      ///< the command under way, or the beginning of a rest
  std::int64_t heard_ns_ = 0;      ///< the last sign of life
  std::int64_t refreshed_ns_ = 0;  ///< the last time that labels were asked for
  std::int64_t probed_ns_ = 0;
};

}  // namespace risorius
