// Sends datagrams over UDP or messages over a ZeroMQ PUSH socket, whatever is in them. UDP: errors of the network are
// counted and tried again where that can help, never fatal. ZeroMQ: blocks while the receiver is behind.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "capture/wire/curve_keys.h"
#include "replay/live/send_target.h"

namespace risorius {

struct DatagramSenderOptions {
  std::optional<CurveClient> curve;                ///< ZeroMQ: for a receiver with keys
  int zmq_high_water_mark = 1000;                  ///< messages that wait for a slow receiver before sending blocks
  std::int64_t give_up_after_ns = 10'000'000'000;  ///< ZeroMQ: the longest block, and the longest wait at the end; > 0
};

class DatagramSender {
 public:
  /// Throws UserError naming the target or the option, and the remedy.
  explicit DatagramSender(const SendTarget& target, const DatagramSenderOptions& options = {});
  /// Waits until ZeroMQ has handed its messages over, at most give_up_after_ns.
  ~DatagramSender();
  DatagramSender(const DatagramSender&) = delete;
  DatagramSender& operator=(const DatagramSender&) = delete;

  /// False if it could not be sent; every refusal of the system counts into `errors`. Throws UserError if a ZeroMQ
  /// receiver takes nothing.
  bool send(std::span<const std::byte> bytes, std::uint64_t& errors);
  /// How many times a message is sent that must not get lost.
  int copies() const noexcept;

 private:
  class Channel;
  class UdpChannel;
  class ZmqChannel;
  std::unique_ptr<Channel> channel_;
};

}  // namespace risorius
