#include "replay/session/session_player.h"

#include "capture/errors.h"
#include "replay/live/datagram_sender.h"
#include "replay/live/sender.h"
#include "replay/session/known_set.h"
#include "replay/session/tick_codec.h"

namespace risorius {
namespace {

class DatagramPlayer : public SessionPlayer {
 public:
  DatagramPlayer(const SendTarget& target, const std::optional<CurveClient>& curve)
      : sender_(target, {.curve = curve}) {}

  SessionTopic topic() const noexcept override { return SessionTopic::kRaw; }
  const char* unit() const noexcept override { return "datagrams"; }
  void send(SessionTopic, std::span<const std::byte> message) override {
    ++(sender_.send(message, counts_.send_errors) ? counts_.sent : counts_.not_sent);
  }

 private:
  DatagramSender sender_;
};

/// Sequences are the tracker's, so what was lost then is lost again.
class TickPlayer : public SessionPlayer {
 public:
  TickPlayer(std::string stream, SendTarget target, std::optional<CurveClient> curve)
      : stream_(std::move(stream)), target_(std::move(target)), curve_(std::move(curve)) {}

  SessionTopic topic() const noexcept override { return SessionTopic::kTicks; }
  const char* unit() const noexcept override { return "frames"; }

  bool takes(SessionTopic other) const noexcept override { return other == topic() || other == SessionTopic::kSets; }

  void send(SessionTopic of, std::span<const std::byte> message) override {
    if (!known_set_.is_news(of, message)) return;
    if (!decode_tick(message, tick_))
      throw UserError(stream_, "has a Tick that cannot be read", "was it recorded by another version of risorius?");
    switch (tick_.kind) {
      case TickKind::kFrame:
        if (set_.names.empty() || tick_.frame.header.set_id != set_.id || tick_.frame.count != set_.names.size()) {
          ++counts_.without_set;
          break;
        }
        open();
        sender_->send_frame(tick_.frame);
        break;
      case TickKind::kMarkerSet:
        set_ = tick_.set;
        if (sender_) sender_->send_marker_set(set_);
        break;
      case TickKind::kEndOfStream:
        close();
        break;
      case TickKind::kShapes:
        throw UserError(stream_, "has face shapes, which the native protocol has not", "");
      case TickKind::kNeutralCapture:
      case TickKind::kRecordingStarted:
      case TickKind::kRecordingStopped:
        ++counts_.left_out;
        break;
    }
    count();
  }
  void finish() override { close(); }

 private:
  /// After an end the tracker may count from the start again: that is another run.
  void open() {
    if (sender_) return;
    sender_.emplace(target_, SenderOptions{.curve = curve_});
    sender_->send_marker_set(set_);
  }
  void close() {
    if (!sender_) return;
    sender_->send_end_of_stream();
    count();
    const SenderStatistics& ended = sender_->statistics();
    ended_ = {.sent = ended_.sent + ended.frames,
              .not_sent = ended_.not_sent + ended.frames_not_sent,
              .send_errors = ended_.send_errors + ended.send_errors};
    sender_.reset();
  }
  void count() {
    const SenderStatistics now = sender_ ? sender_->statistics() : SenderStatistics{};
    counts_.sent = ended_.sent + now.frames;
    counts_.not_sent = ended_.not_sent + now.frames_not_sent;
    counts_.send_errors = ended_.send_errors + now.send_errors;
  }

  std::string stream_;
  SendTarget target_;
  std::optional<CurveClient> curve_;
  KnownSet known_set_;
  MarkerSet set_;
  std::optional<Sender> sender_;
  Counts ended_;  ///< of the senders before this one
  SessionTick tick_;
};

}  // namespace

std::unique_ptr<SessionPlayer> make_session_player(const StreamFacts& stream, const SendTarget& target,
                                                   const std::optional<CurveClient>& curve) {
  const bool is_live_link = stream.protocol == "livelink";
  if (is_live_link && target.transport != Transport::kUdp)
    throw UserError("--to", "stream " + stream.name + " is of Live Link Face, which is sent over UDP",
                    "give udp://HOST:PORT");
  if (is_live_link || stream.protocol == "udp" || stream.protocol == "zmq+tcp")
    return std::make_unique<DatagramPlayer>(target, curve);
  return std::make_unique<TickPlayer>(stream.name, target, curve);
}

}  // namespace risorius
