#include "system/flood_run.h"

#include <algorithm>
#include <arpa/inet.h>
#include <atomic>
#include <sys/socket.h>
#include <unistd.h>
#include <vector>

#include "replay/live/send_target.h"
#include "system/closed_loop.h"
#include "system/own_daemon.h"

namespace risorius::test {
namespace {

sockaddr_in loopback(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

/// Garbage to one port, many datagrams a call, while it is on.
class Flood {
 public:
  explicit Flood(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
    const sockaddr_in to = loopback(port);
    ::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  }
  ~Flood() {
    end();
    ::close(socket_);
  }
  void begin() {
    on_ = true;
    thread_ = std::thread([this] { run(); });
  }
  void end() {
    on_ = false;
    if (thread_.joinable()) thread_.join();
  }
  void send_one() { sent_ += ::send(socket_, garbage_, sizeof garbage_, 0) > 0 ? 1 : 0; }
  std::uint64_t sent() const { return sent_; }

 private:
  void run() {
    constexpr unsigned kAtOnce = 64;
    iovec part{garbage_, sizeof garbage_};
    std::vector<mmsghdr> messages(kAtOnce);
    for (mmsghdr& message : messages) {
      message.msg_hdr.msg_iov = &part;
      message.msg_hdr.msg_iovlen = 1;
    }
    while (on_) {
      const int sent = ::sendmmsg(socket_, messages.data(), kAtOnce, 0);
      if (sent > 0) sent_ += static_cast<std::uint64_t>(sent);
    }
  }
  int socket_;
  char garbage_[64] = "no datagram of ours";
  std::atomic<bool> on_{false};
  std::uint64_t sent_ = 0;  ///< of the thread while it runs
  std::thread thread_;
};

}  // namespace

FloodRun flood_beside_a_stream(int blocks, double seconds) {
  OwnDaemon daemon(source_table("face") + source_table("flooded"));
  Flood flood(parse_send_target(daemon.running.input("flooded")).port);
  ClosedLoop loop(daemon.running, "face", 240, 60);
  FloodRun run;
  std::vector<double> quiet_ms, flooded_ms, warm_up_ms;
  loop.run(1, warm_up_ms);
  const ProcessUsage before = daemon.usage();
  for (int block = 0; block < blocks; ++block) {
    run.unanswered += loop.run(seconds, quiet_ms);
    flood.begin();
    run.unanswered += loop.run(seconds, flooded_ms);
    flood.end();
    run.resident_growth_bytes =
        std::max(run.resident_growth_bytes, daemon.usage().resident_bytes - before.resident_bytes);
    // The garbage that still lies in the socket's buffer is not of the quiet block that follows.
    std::this_thread::sleep_for(std::chrono::milliseconds(1000));
  }
  run.flood_rate_hz = static_cast<double>(flood.sent()) / (blocks * seconds);
  const auto accounted = [&] {
    const auto stream = daemon.stream("flooded");
    return number(stream, "/datagrams/received") + number(stream, "/datagrams/kernel_drops");
  };
  // The kernel tells its drops with the next datagram only.
  wait_until([&] {
    flood.send_one();
    return accounted() >= flood.sent();
  });
  run.flood_sent = flood.sent();
  run.flood_accounted = accounted();
  wait_until([&] { return number(daemon.stream("face"), "/processed") >= loop.sent(); });
  const auto face = daemon.stream("face");
  run.lost = gone(face) + (loop.sent() - std::min(loop.sent(), number(face, "/processed")));
  run.quiet_p99_ms = quantile(quiet_ms, 0.99);
  run.quiet_p50_ms = quantile(quiet_ms, 0.5);
  run.flooded_p99_ms = quantile(flooded_ms, 0.99);
  run.flooded_p50_ms = quantile(flooded_ms, 0.5);
  daemon.running.end();
  return run;
}

}  // namespace risorius::test
