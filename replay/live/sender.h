// Sends marker sets and frames in the native protocol over UDP or a ZeroMQ PUSH socket, in millimetres and LUF axes, so
// that what is received equals what was sent bit for bit. Sequence and capture time are the frame's own. The marker set
// goes out first, and again ahead of a frame once `repeat_set_ns` of wall time have passed. UDP: errors of the network
// are counted and tried again where that can help, never fatal. ZeroMQ: blocks while the receiver is behind. One
// thread; allocates nothing per frame (ZeroMQ does inside).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "capture/frames.h"
#include "capture/marker_set.h"
#include "capture/wire/curve_keys.h"
#include "capture/wire/marker_codec.h"
#include "replay/live/datagram_sender.h"
#include "replay/live/send_target.h"

namespace risorius {

struct SenderOptions {
  std::uint32_t session = 0;                       ///< tells this run from others; 0: a random one
  std::int64_t repeat_set_ns = 1'000'000'000;      ///< >= 0; 0: ahead of every frame
  std::optional<CurveClient> curve;                ///< ZeroMQ: for a receiver with keys
  int zmq_high_water_mark = 1000;                  ///< messages that wait for a slow receiver before sending blocks
  std::int64_t give_up_after_ns = 10'000'000'000;  ///< ZeroMQ: the longest block, and the longest wait at the end; > 0
};

struct SenderStatistics {
  std::uint64_t frames = 0;           ///< handed to the network whole
  std::uint64_t frames_not_sent = 0;  ///< at least one datagram could not be sent
  std::uint64_t datagrams = 0;
  std::uint64_t send_errors = 0;  ///< refusals by the system, those included that a second try made good
};

class Sender {
 public:
  /// Throws UserError naming the target and the remedy.
  explicit Sender(const SendTarget& target, const SenderOptions& options = {});
  /// Waits until ZeroMQ has handed its messages over, at most give_up_after_ns.
  ~Sender();
  Sender(const Sender&) = delete;
  Sender& operator=(const Sender&) = delete;

  /// Sends the set and keeps it in force; its unit and axes are replaced by mm and LUF, which frames are in.
  /// Throws UserError if the set has problems_of.
  void send_marker_set(const MarkerSet& set);
  /// Throws std::invalid_argument if the frame is not of the set in force, UserError if a ZeroMQ receiver takes
  /// nothing.
  void send_frame(const MarkerFrame& frame);
  /// Tells how many frames were sent and which was the last; repeated over UDP, where it may get lost.
  void send_end_of_stream();

  std::uint32_t session() const noexcept { return session_; }
  const SenderStatistics& statistics() const noexcept { return statistics_; }

 private:
  bool send(std::size_t bytes);
  void send_set_in_force();

  SenderOptions options_;
  std::uint32_t session_;
  DatagramSender channel_;
  DatagramBuffer buffer_{};
  MarkerSet set_;
  std::uint16_t revision_ = 0;
  std::int64_t set_sent_ns_ = 0;
  std::int64_t repeat_set_ns_ = 0;    ///< grows from a twentieth of a second to the option
  std::uint64_t frames_offered_ = 0;  ///< those too that the network refused: the receiver counts them as lost
  std::uint64_t last_sequence_ = 0;
  SenderStatistics statistics_;
};

}  // namespace risorius
