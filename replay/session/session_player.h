// A recorded stream sent once more, message by message: the datagrams as they came where it was the native protocol or
// Live Link Face; of a conversation with a tracker, which cannot be had again, the frames that it gave, as the native
// protocol.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "capture/wire/curve_keys.h"
#include "replay/live/send_target.h"
#include "replay/session/session_reader.h"

namespace risorius {

class SessionPlayer {
 public:
  struct Counts {
    std::uint64_t sent = 0, not_sent = 0;
    std::uint64_t send_errors = 0;  ///< refusals by the system, those included that a second try made good
    /// What the session had beside frames and the native protocol has not: neutrals asked for, and the tracker's own
    /// recordings.
    std::uint64_t left_out = 0;
    /// Frames whose marker set lay in a damaged part of the file, up to the next repeat of it.
    std::uint64_t without_set = 0;
  };

  virtual ~SessionPlayer() = default;
  SessionPlayer(const SessionPlayer&) = delete;
  SessionPlayer& operator=(const SessionPlayer&) = delete;

  /// Whose messages it sends.
  virtual SessionTopic topic() const noexcept = 0;
  /// Whether it is to be given messages of this topic.
  virtual bool takes(SessionTopic other) const noexcept { return other == topic(); }
  /// What it sends, for people: "datagrams" or "frames".
  virtual const char* unit() const noexcept = 0;
  /// A message of a topic that it takes. Throws UserError if the message is damaged, or a ZeroMQ receiver takes
  /// nothing.
  virtual void send(SessionTopic of, std::span<const std::byte> message) = 0;
  /// After the last message.
  virtual void finish() {}

  const Counts& counts() const noexcept { return counts_; }

 protected:
  SessionPlayer() = default;
  Counts counts_;
};

/// Throws UserError if a stream of this protocol cannot be sent to such a target.
std::unique_ptr<SessionPlayer> make_session_player(const StreamFacts& stream, const SendTarget& target,
                                                   const std::optional<CurveClient>& curve);

}  // namespace risorius
