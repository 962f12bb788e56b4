// What the daemon adds between a marker datagram and its AU message: 240 Hz x 60 markers on loopback, against a bare
// echo (UDP in, ZeroMQ PUB out, nothing between) through the same kinds of socket, in alternating blocks of one run. A
// second daemon records what it solves; the threads of a third sleep until a frame comes (awake_share 0).
#include <algorithm>
#include <arpa/inet.h>
#include <array>
#include <csignal>
#include <cstring>
#include <fmt/core.h>
#include <map>
#include <optional>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>
#include <zmq.hpp>

#include "bench/bench_report.h"
#include "capture/monotonic_clock.h"
#include "capture/wire/marker_codec.h"
#include "replay/live/daemon_client.h"
#include "replay/live/pacer.h"
#include "replay/performer/performer.h"
#include "solve/faces/builtin_face.h"
#include "support/process.h"
#include "support/process_usage.h"
#include "support/test_data.h"
#include "system/running_daemon.h"

namespace risorius::bench {
namespace {

constexpr double kRateHz = 240;
constexpr std::size_t kMarkers = 60;
constexpr int kFramesPerBlock = 240;
constexpr int kBlocks = 24;  // of each kind

sockaddr_in loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  inet_pton(AF_INET, "127.0.0.1", &address.sin_addr);
  return address;
}

/// The echo, in a process of its own as the daemon is.
class Echo {
 public:
  Echo() {
    int ends[2];
    if (pipe(ends) != 0) throw std::runtime_error("no pipe");
    id_ = fork();
    if (id_ == 0) serve(ends[1]);
    if (read(ends[0], ports_, sizeof ports_) != sizeof ports_) throw std::runtime_error("the echo did not start");
    close(ends[0]);
    close(ends[1]);
  }
  ~Echo() {
    kill(id_, SIGKILL);
    waitpid(id_, nullptr, 0);
  }
  int udp_port() const { return ports_[0]; }
  std::string publish() const { return fmt::format("tcp://127.0.0.1:{}", ports_[1]); }

 private:
  [[noreturn]] static void serve(int ports_out) {
    const int in = ::socket(AF_INET, SOCK_DGRAM, 0);
    sockaddr_in address = loopback(0);
    socklen_t size = sizeof address;
    if (bind(in, reinterpret_cast<sockaddr*>(&address), size) != 0) _exit(1);
    getsockname(in, reinterpret_cast<sockaddr*>(&address), &size);
    zmq::context_t context;
    zmq::socket_t out(context, zmq::socket_type::pub);
    out.bind("tcp://127.0.0.1:*");
    const auto endpoint = out.get(zmq::sockopt::last_endpoint);
    const int ports[2] = {ntohs(address.sin_port), std::stoi(endpoint.substr(endpoint.rfind(':') + 1))};
    if (write(ports_out, ports, sizeof ports) != sizeof ports) _exit(1);
    char bytes[2048];
    while (true) {
      const ssize_t count = recv(in, bytes, sizeof bytes, 0);
      if (count < 0) _exit(1);
      out.send(zmq::str_buffer("au"), zmq::send_flags::sndmore);
      out.send(zmq::buffer(bytes, static_cast<std::size_t>(count)), zmq::send_flags::none);
    }
  }
  pid_t id_ = 0;
  int ports_[2] = {};
};

/// One of the ways: where datagrams go, and where answers come from.
struct Way {
  sockaddr_in target;
  zmq::socket_t answers;
  std::vector<double> block_p50_us, block_p99_us;
  std::uint64_t unanswered = 0;
};

zmq::socket_t subscribe(zmq::context_t& context, const std::string& endpoint) {
  zmq::socket_t socket(context, zmq::socket_type::sub);
  socket.set(zmq::sockopt::subscribe, "au");
  socket.connect(endpoint);
  return socket;
}

double quantile(std::vector<double> values, double q) {
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1) + 0.5)];
}

/// Sends a block at its rate, closed loop: an answer counts for the datagram before it; a late one is counted as
/// unanswered.
void run_block(Way& way, int udp, const std::vector<std::vector<std::byte>>& datagrams) {
  Pacer pacer;
  std::vector<double> latency_us;
  for (std::size_t i = 0; i < datagrams.size(); ++i) {
    pacer.wait(static_cast<std::int64_t>(static_cast<double>(i) * 1e9 / kRateHz));
    zmq::message_t topic, body;
    while (way.answers.recv(topic, zmq::recv_flags::dontwait)) {
    }
    const std::int64_t sent_ns = monotonic_now_ns();
    sendto(udp, datagrams[i].data(), datagrams[i].size(), 0, reinterpret_cast<const sockaddr*>(&way.target),
           sizeof way.target);
    way.answers.set(zmq::sockopt::rcvtimeo, 100);
    if (!way.answers.recv(topic)) {
      ++way.unanswered;
      continue;
    }
    latency_us.push_back(static_cast<double>(monotonic_now_ns() - sent_ns) * 1e-3);
  }
  if (latency_us.empty()) return;
  way.block_p50_us.push_back(quantile(latency_us, 0.5));
  way.block_p99_us.push_back(quantile(latency_us, 0.99));
}

std::vector<std::byte> to_bytes(const DatagramBuffer& buffer, std::size_t size) {
  return {buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(size)};
}

/// The performer's 55 markers and five more that the rig does not know.
struct Stream {
  PerformerTake take{builtin_rig(), PerformerOptions{.rate_hz = kRateHz, .seconds = 600}};
  MarkerSet set;
  Stream() : set(take.info().markers) {
    while (set.names.size() < kMarkers) set.names.push_back(fmt::format("extra{}", set.names.size()));
  }
  std::vector<std::byte> next_datagram() {
    MarkerFrame frame;
    take.next(frame);
    frame.header.set_id = set.id;
    for (std::uint32_t m = frame.count; m < kMarkers; ++m) {
      frame.state[m] = MarkerState::kMeasured;
      frame.position_mm[m] = frame.position_mm[m - 5];
      frame.position_mm[m].z += 7;  // not on the marker that it copies: that would be a ghost
    }
    frame.count = kMarkers;
    DatagramBuffer buffer;
    return to_bytes(buffer, encode(frame, 1, 0, buffer).bytes);
  }
  std::vector<std::byte> set_datagram() const {
    DatagramBuffer buffer;
    return to_bytes(buffer, encode(set, 1, 0, 0, buffer).bytes);
  }
};

Way way_through(test::RunningDaemon& daemon, zmq::context_t& context) {
  if (!daemon.up()) throw std::runtime_error("risoriusd did not start: " + daemon.process().output());
  const auto input = daemon.input("face");
  return {loopback(std::stoi(input.substr(input.rfind(':') + 1))), subscribe(context, daemon.publish()), {}, {}, 0};
}

/// Over the blocks, of the difference between two ways' quantiles of the same block.
double median_excess_us(const Way& way, const Way& echo, std::vector<double> Way::*of_blocks) {
  std::vector<double> excess_us;
  for (std::size_t b = 0; b < std::min((way.*of_blocks).size(), (echo.*of_blocks).size()); ++b)
    excess_us.push_back((way.*of_blocks)[b] - (echo.*of_blocks)[b]);
  return quantile(excess_us, 0.5);
}

int measure() {
  test::TemporaryFolder folder;
  Echo echo;
  zmq::context_t context;
  const std::string source = "[[source]]\nname = \"face\"\nlisten = \"udp://127.0.0.1:0\"\n";
  test::RunningDaemon daemon(folder.path(), source, "", test::Recording::kOff);
  Way through_daemon = way_through(daemon, context);
  // In a folder of its own, for its configuration file.
  const test::TemporaryFolder recording_folder;
  test::RunningDaemon recording(recording_folder.path(), source);
  Way through_recording = way_through(recording, context);
  const test::TemporaryFolder sleeping_folder;
  test::RunningDaemon sleeping(sleeping_folder.path(), "[latency]\nawake_share = 0\n" + source, "",
                               test::Recording::kOff);
  Way through_sleeping = way_through(sleeping, context);
  Way through_echo{loopback(echo.udp_port()), subscribe(context, echo.publish()), {}, {}, 0};
  const std::array ways{&through_daemon, &through_recording, &through_sleeping, &through_echo};
  const int udp = ::socket(AF_INET, SOCK_DGRAM, 0);
  Stream stream;
  const auto set = stream.set_datagram();
  for (const Way* way : {&through_daemon, &through_recording, &through_sleeping}) {
    sendto(udp, set.data(), set.size(), 0, reinterpret_cast<const sockaddr*>(&way->target), sizeof way->target);
  }

  double awake_s = 0, sleeping_s = 0;  // processor time of the two
  for (int block = -1; block < kBlocks; ++block) {
    std::vector<std::vector<std::byte>> datagrams;
    for (int i = 0; i < kFramesPerBlock; ++i) datagrams.push_back(stream.next_datagram());
    for (Way* way : ways) run_block(*way, udp, datagrams);
    if (block < 0) {  // warm-up
      for (Way* way : ways) *way = {way->target, std::move(way->answers), {}, {}, 0};
      awake_s = -test::processor_seconds(daemon.process().id());
      sleeping_s = -test::processor_seconds(sleeping.process().id());
    }
    fmt::print(stderr, "\rblock {} of {} ", block + 1, kBlocks);
  }
  fmt::print(stderr, "\n");
  awake_s += test::processor_seconds(daemon.process().id());
  sleeping_s += test::processor_seconds(sleeping.process().id());
  const auto status = daemon.status().at("streams").at("face");
  close(udp);

  BenchReport report("latency");
  report.add("daemon p50, median over blocks", quantile(through_daemon.block_p50_us, 0.5) * 1e-3);
  report.add("echo p50, median over blocks", quantile(through_echo.block_p50_us, 0.5) * 1e-3);
  report.add("excess p50, median over blocks",
             median_excess_us(through_daemon, through_echo, &Way::block_p50_us) * 1e-3);
  report.add("daemon p99, median over blocks", quantile(through_daemon.block_p99_us, 0.5) * 1e-3);
  report.add("echo p99, median over blocks", quantile(through_echo.block_p99_us, 0.5) * 1e-3);
  report.add("excess p99, median over blocks",
             median_excess_us(through_daemon, through_echo, &Way::block_p99_us) * 1e-3);
  report.add("while recording: excess p50, median over blocks",
             median_excess_us(through_recording, through_echo, &Way::block_p50_us) * 1e-3);
  report.add("while recording: excess p99, median over blocks",
             median_excess_us(through_recording, through_echo, &Way::block_p99_us) * 1e-3);
  report.add("with awake_share 0: excess p50, median over blocks",
             median_excess_us(through_sleeping, through_echo, &Way::block_p50_us) * 1e-3);
  report.add("with awake_share 0: excess p99, median over blocks",
             median_excess_us(through_sleeping, through_echo, &Way::block_p99_us) * 1e-3);
  constexpr double kStreamed = kBlocks * kFramesPerBlock / kRateHz;  // s
  report.add("processor time while streaming", 100 * awake_s / kStreamed);
  report.add("with awake_share 0: processor time while streaming", 100 * sleeping_s / kStreamed);
  report.add("frames unanswered", static_cast<double>(through_daemon.unanswered));
  const auto& forecast = status.at("forecast");
  const auto received = status.at("admission").at("received").get<double>();
  report.add("frames that came when expected", 100 * forecast.at("foreseen").get<double>() / std::max(1.0, received));
  const auto inside = [&status](const char* way) {
    return status.at("latency_us").at(way).at("p50").get<double>() * 1e-3;
  };
  report.add("inside the daemon, receive to publish, p50", inside("received_to_published"));
  report.add("inside the daemon, receive to cleaned, p50", inside("received_to_cleaned"));
  report.add("inside the daemon, cleaned to solved, p50", inside("cleaned_to_solved"));
  report.add("inside the daemon, solved to publish, p50", inside("solved_to_published"));
  daemon.end();
  recording.end();
  sleeping.end();
  return report.finish();
}

}  // namespace
}  // namespace risorius::bench

int main() {
  try {
    return risorius::bench::measure();
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench latency: {}\n", error.what());
    return 1;
  }
}
