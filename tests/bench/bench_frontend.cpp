// The streaming front end under load: whole sessions through the real daemon, counted to the frame; and receive + parse
// + reorder of our own source against bare receive calls on the same socket kind, in alternating blocks of one run.
#include <algorithm>
#include <arpa/inet.h>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <fmt/core.h>
#include <nlohmann/json.hpp>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include "bench/bench_report.h"
#include "capture/monotonic_clock.h"
#include "capture/wire/marker_codec.h"
#include "capture/wire/receive_batch.h"
#include "capture/wire/reorder_window.h"
#include "capture/wire/udp_source.h"
#include "replay/live/pacer.h"
#include "replay/live/sender.h"
#include "replay/performer/performer.h"
#include "solve/faces/builtin_face.h"
#include "support/test_data.h"
#include "system/running_daemon.h"

namespace risorius::bench {
namespace {

constexpr double kRateHz = 1000;

PerformerOptions options_of(std::uint64_t seed) {
  PerformerOptions options;
  options.rate_hz = kRateHz;
  options.seconds = 600;
  options.seed = seed;
  return options;
}

/// The performer's 55 markers, and others that the rig does not know, until there are `markers`: copies of its own, so
/// many millimetres away that none sits on another.
class Stage {
 public:
  Stage(std::size_t markers, std::uint64_t seed) : take_(builtin_rig(), options_of(seed)), set_(take_.info().markers) {
    for (std::size_t i = 0; set_.names.size() < markers; ++i) set_.names.push_back(fmt::format("extra{}", i));
  }
  const MarkerSet& set() const { return set_; }
  const MarkerFrame& next() {
    take_.next(frame_);
    const std::uint32_t own = frame_.count;
    frame_.count = static_cast<std::uint32_t>(set_.names.size());
    frame_.header.set_id = set_.id;
    for (std::uint32_t m = own; m < frame_.count; ++m) {
      frame_.state[m] = frame_.state[m - own];
      frame_.position_mm[m] = frame_.position_mm[m - own];
      frame_.position_mm[m].z += 7;
    }
    return frame_;
  }

 private:
  PerformerTake take_;
  MarkerSet set_;
  MarkerFrame frame_;
};

struct Session {
  double unexplained = 0, gone = 0, over_budget = 0, p50_ms = 0, p99_ms = 0;
};

/// `streams` sources of `markers` markers at 1000 Hz through one daemon.
Session run_session(std::size_t streams, std::size_t markers, double seconds) {
  test::TemporaryFolder folder;
  std::string sources;
  for (std::size_t i = 0; i < streams; ++i)
    sources += fmt::format("[[source]]\nname = \"face{}\"\nlisten = \"udp://127.0.0.1:0\"\n", i);
  // A queue of one second of all streams: what a busy machine holds up for so long is not lost.
  test::RunningDaemon daemon(folder.path(), sources, fmt::format("[queues]\nadmission = {}\n", 1024 * streams));
  if (!daemon.up()) throw std::runtime_error("risoriusd did not start: " + daemon.process().output());

  // Frames are made ahead: the performer's own work does not compete with the daemon.
  const auto frames = static_cast<std::size_t>(seconds * kRateHz);
  std::vector<std::vector<MarkerFrame>> script(streams);
  std::vector<std::unique_ptr<Sender>> senders;
  for (std::size_t i = 0; i < streams; ++i) {
    Stage stage(markers, i + 1);
    for (std::size_t f = 0; f < frames; ++f) script[i].push_back(stage.next());
    senders.push_back(std::make_unique<Sender>(parse_send_target(daemon.input(fmt::format("face{}", i)))));
    senders.back()->send_marker_set(stage.set());
  }
  Pacer pacer;
  for (std::size_t f = 0; f < frames; ++f) {
    pacer.wait(static_cast<std::int64_t>(static_cast<double>(f) * 1e9 / kRateHz));
    for (std::size_t i = 0; i < streams; ++i) senders[i]->send_frame(script[i][f]);
  }
  for (auto& sender : senders) sender->send_end_of_stream();

  // Until the daemon has worked off what it holds.
  nlohmann::json status = daemon.status();
  for (int attempt = 0; attempt < 100 && status.at("admission").at("queued").get<int>() > 0; ++attempt) {
    usleep(50'000);
    status = daemon.status();
  }
  usleep(100'000);
  status = daemon.status();
  Session session;
  for (std::size_t i = 0; i < streams; ++i) {
    const auto& s = status.at("streams").at(fmt::format("face{}", i));
    const auto count = [&](const char* path) { return s.at(nlohmann::json::json_pointer(path)).get<double>(); };
    const auto sent = static_cast<double>(senders[i]->statistics().frames);
    // Every way in which a frame can vanish has its counter; what is left over is unexplained.
    const double gone =
        count("/frames/lost") + count("/reorder/late") + count("/admission/dropped") + count("/refused_frames");
    session.gone += gone;
    session.unexplained += std::abs(sent - count("/processed") - gone);
    session.over_budget += count("/cycles/over_budget");
    session.p50_ms = std::max(session.p50_ms, count("/latency_us/received_to_published/p50") * 1e-3);
    session.p99_ms = std::max(session.p99_ms, count("/latency_us/received_to_published/p99") * 1e-3);
  }
  return session;
}

// ---- receive + parse + reorder against the bare socket

constexpr std::size_t kMarkers = 60;
constexpr std::size_t kFrames = 60'000;  // per block; each one datagram
constexpr int kBlocks = 10;              // of each kind

sockaddr_in loopback(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  inet_pton(AF_INET, "127.0.0.1", &address.sin_addr);
  return address;
}

/// All datagrams of a block, one after the other in memory.
struct Load {
  std::vector<std::byte> set;
  std::vector<std::byte> frames;
  std::size_t frame_bytes = 0;

  Load() {
    Stage stage(kMarkers, 1);
    DatagramBuffer buffer;
    const auto keep = [&](std::vector<std::byte>& to, std::size_t bytes) {
      to.insert(to.end(), buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(bytes));
    };
    keep(set, encode(stage.set(), 1, 0, 0, buffer).bytes);
    for (std::size_t f = 0; f < kFrames; ++f) {
      MarkerFrame frame = stage.next();
      frame.header.sequence = f;
      frame_bytes = encode(frame, 1, 0, buffer).bytes;
      keep(frames, frame_bytes);
    }
  }
};

/// As fast as the system takes them.
void flood(const Load& load, std::uint16_t port) {
  const int out = ::socket(AF_INET, SOCK_DGRAM, 0);
  const sockaddr_in address = loopback(port);
  ::connect(out, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  ::send(out, load.set.data(), load.set.size(), 0);
  constexpr unsigned kAtOnce = 64;
  std::vector<iovec> parts(kAtOnce);
  std::vector<mmsghdr> messages(kAtOnce);
  for (std::size_t f = 0; f < kFrames;) {
    unsigned count = 0;
    for (; count < kAtOnce && f + count < kFrames; ++count) {
      parts[count] = {const_cast<std::byte*>(load.frames.data() + (f + count) * load.frame_bytes), load.frame_bytes};
      messages[count].msg_hdr = {};
      messages[count].msg_hdr.msg_iov = &parts[count];
      messages[count].msg_hdr.msg_iovlen = 1;
    }
    const int sent = ::sendmmsg(out, messages.data(), count, 0);
    f += sent > 0 ? static_cast<std::size_t>(sent) : 1;
  }
  ::close(out);
}

/// Frames per second of a receiver while a thread floods it; both end when nothing came for a while.
template <class Receive>
double rate_while_flooded(const Load& load, std::uint16_t port, Receive receive) {
  std::atomic<bool> sending{true};
  const std::int64_t begin_ns = monotonic_now_ns();
  std::thread sender([&] {
    flood(load, port);
    sending = false;
  });
  std::uint64_t frames = 0;
  std::int64_t last_ns = begin_ns;
  while (true) {
    const std::uint64_t more = receive();
    const std::int64_t now_ns = monotonic_now_ns();
    frames += more;
    if (more > 0) last_ns = now_ns;
    if (!sending && now_ns - last_ns > 20'000'000) break;
  }
  sender.join();
  return static_cast<double>(frames) * 1e9 / static_cast<double>(last_ns - begin_ns);
}

constexpr int kBuffer = 8 << 20;

double bare_rate(const Load& load) {
  const int in = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address = loopback(0);
  socklen_t size = sizeof address;
  ::setsockopt(in, SOL_SOCKET, SO_RCVBUF, &kBuffer, sizeof kBuffer);
  if (bind(in, reinterpret_cast<sockaddr*>(&address), size) != 0) throw std::runtime_error("cannot bind");
  getsockname(in, reinterpret_cast<sockaddr*>(&address), &size);
  ReceiveBatch batch(32, 2048);
  const double rate = rate_while_flooded(load, ntohs(address.sin_port), [&]() -> std::uint64_t {
    pollfd readable{.fd = in, .events = POLLIN, .revents = 0};
    if (::poll(&readable, 1, 5) <= 0) return 0;
    std::uint64_t count = 0;
    for (int received = batch.receive(in, 32); received > 0; received = batch.receive(in, 32))
      count += static_cast<std::uint64_t>(received);
    return count;
  });
  ::close(in);
  return rate;
}

double our_rate(const Load& load) {
  boost::asio::io_context io;
  ReorderWindow reorder;
  SourceEvent event;
  MarkerFrame frame;
  std::uint64_t count = 0;
  UdpSource* running = nullptr;
  UdpSource source(io, UdpSourceOptions{.port = 0, .receive_buffer_bytes = kBuffer, .decoder = {}}, [&] {
    while (running->pop(event)) {
      if (event.kind != SourceEventKind::kFrame) continue;
      while (!reorder.push(event.frame)) {
        while (reorder.pop(frame)) ++count;
      }
      while (reorder.pop(frame)) ++count;
    }
  });
  running = &source;
  source.start();
  return rate_while_flooded(load, source.port(), [&]() -> std::uint64_t {
    count = 0;
    io.run_one_for(std::chrono::milliseconds(5));
    return count;
  });
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

int measure() {
  BenchReport report("frontend");
  const Load load;
  std::vector<double> bare, ours, ratio;
  for (int block = -1; block < kBlocks; ++block) {
    fmt::print(stderr, "\rflood {} of {} ", block + 1, kBlocks);
    const double b = bare_rate(load), o = our_rate(load);
    if (block < 0) continue;  // warm-up
    bare.push_back(b);
    ours.push_back(o);
    ratio.push_back(o / b);
  }
  report.add("bare loopback receive", median(bare));
  report.add("receive + parse + reorder", median(ours));
  report.add("receive + parse + reorder / bare", median(ratio));

  fmt::print(stderr, "\n1 x 1000 Hz x 165 markers, 20 s\n");
  const Session one = run_session(1, 165, 20);
  report.add("1 x 1000 Hz x 165: frames gone unexplained", one.unexplained);
  report.add("1 x 1000 Hz x 165: frames gone, counted", one.gone);
  report.add("1 x 1000 Hz x 165: cycles over 1 ms", one.over_budget);
  report.add("1 x 1000 Hz x 165: received to published, p50", one.p50_ms);
  report.add("1 x 1000 Hz x 165: received to published, p99", one.p99_ms);
  fmt::print(stderr, "4 x 1000 Hz x 60 markers, 20 s\n");
  const Session four = run_session(4, 60, 20);
  report.add("4 x 1000 Hz x 60: frames gone unexplained", four.unexplained);
  report.add("4 x 1000 Hz x 60: frames gone, counted", four.gone);
  report.add("4 x 1000 Hz x 60: cycles over 1 ms", four.over_budget);
  report.add("4 x 1000 Hz x 60: received to published, p50", four.p50_ms);
  report.add("4 x 1000 Hz x 60: received to published, p99", four.p99_ms);
  return report.finish();
}

}  // namespace
}  // namespace risorius::bench

int main() {
  try {
    return risorius::bench::measure();
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench frontend: {}\n", error.what());
    return 2;
  }
}
