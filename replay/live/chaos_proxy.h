// A UDP proxy that does to datagrams what a ChaosPlan says, one way (no answers come back), and keeps the truth of it.
// Runs on the thread of its io_context. Datagrams that the plan holds back, and that nothing overtakes, go on after
// kLongestHoldNs: the end of a stream is not held back for good.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstddef>
#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "capture/wire/receive_batch.h"
#include "replay/live/chaos_plan.h"
#include "replay/live/native_truth.h"
#include "replay/live/send_target.h"

namespace risorius {

/// Of datagrams, whatever is in them. received = lost + lost_in_bursts + those that were forwarded at least once or
/// not_sent.
struct ChaosCounts {
  std::uint64_t received = 0;
  std::uint64_t lost = 0, lost_in_bursts = 0, bursts = 0;
  std::uint64_t forwarded = 0;   ///< copies
  std::uint64_t duplicated = 0;  ///< datagrams of which two copies were made
  std::uint64_t overtaken = 0;   ///< copies that went on after a copy of a later datagram
  std::uint64_t corrupted = 0;   ///< copies with a bit turned; of these by where the bit is, in a native datagram:
  std::uint64_t corrupted_magic = 0, corrupted_version = 0, corrupted_elsewhere = 0;
  std::uint64_t not_native = 0;
  std::uint64_t not_sent = 0;      ///< copies that the system refused to send
  std::uint64_t kernel_drops = 0;  ///< that never reached the proxy: its own socket's buffer was full
};

class ChaosProxy {
 public:
  static constexpr std::int64_t kLongestHoldNs = 100'000'000;

  /// Binds. Throws UserError naming the address or the option.
  ChaosProxy(boost::asio::io_context& io, const SendTarget& listen, const SendTarget& to, const ChaosOptions& options);

  void start() { wait(); }
  /// Sends what is waiting, and closes.
  void stop();

  std::string endpoint() const;
  const ChaosCounts& counts() const noexcept { return counts_; }
  /// {"datagrams": {...}, "sessions": {...}}.
  nlohmann::json truth() const;

 private:
  struct Copy {
    std::uint64_t datagram = 0;  ///< which, from 0
    std::vector<std::byte> bytes;
    std::optional<std::size_t> turned_bit;
    std::int64_t delay_ns = 0;
  };
  struct Held {
    Copy copy;
    std::uint64_t until_datagram = 0;
    std::int64_t until_ns = 0;
  };

  void wait();
  void drain();
  void take(std::span<const std::byte> datagram, std::int64_t now_ns);
  void release_held(std::uint64_t datagram, std::int64_t now_ns);
  void schedule(Copy copy, std::int64_t now_ns);
  void send_due(std::int64_t now_ns);
  void send(Copy& copy);
  void arm_timer();

  boost::asio::ip::udp::socket in_, out_;
  boost::asio::ip::udp::endpoint to_;
  boost::asio::steady_timer timer_;
  ReceiveBatch batch_;
  ChaosPlan plan_;
  std::vector<Held> held_;                     ///< in the order of their coming
  std::multimap<std::int64_t, Copy> delayed_;  ///< by the time at which they are due
  std::uint64_t newest_sent_ = 0;
  std::uint32_t known_drops_ = 0;
  ChaosCounts counts_;
  NativeTruth native_;
};

}  // namespace risorius
