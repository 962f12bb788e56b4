#include "system/chaos_run.h"

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <stdexcept>
#include <thread>

#include "replay/live/chaos_proxy.h"
#include "replay/live/pacer.h"
#include "replay/live/sender.h"
#include "support/native_stream.h"
#include "support/test_data.h"
#include "system/running_daemon.h"

namespace risorius::test {
namespace {

constexpr std::uint64_t kReorderDepth = 8;

/// The proxy on a thread of its own.
class ProxyThread {
 public:
  ProxyThread(const SendTarget& to, const ChaosOptions& options)
      : proxy_(io_, parse_listen_address("udp://127.0.0.1:0"), to, options),
        input_(parse_send_target(proxy_.endpoint())) {
    proxy_.start();
    thread_ = std::thread([this] { io_.run(); });
  }
  ~ProxyThread() { end(); }
  const SendTarget& input() const { return input_; }
  /// Hands on all that it has, and stops.
  void end() {
    if (!thread_.joinable()) return;
    io_.stop();
    thread_.join();
    proxy_.stop();
  }
  nlohmann::json truth() const { return proxy_.truth(); }

 private:
  boost::asio::io_context io_;
  ChaosProxy proxy_;
  SendTarget input_;
  std::thread thread_;
};

void send_all(Sender& sender, std::uint64_t frames, double rate_hz, std::size_t markers) {
  MarkerSet set = marker_set(markers, 1, "m");  // short names: one datagram
  set.rate_hz = rate_hz;
  sender.send_marker_set(set);
  Pacer pacer;
  for (std::uint64_t s = 0; s < frames; ++s) {
    MarkerFrame frame = marker_frame(s, markers);
    frame.header.capture_time_ns = static_cast<std::int64_t>(static_cast<double>(s) * 1e9 / rate_hz);
    pacer.wait(frame.header.capture_time_ns);
    sender.send_frame(frame);
  }
  sender.send_end_of_stream();
}

std::uint64_t number(const nlohmann::json& json, const char* path) {
  return json.value(nlohmann::json::json_pointer(path), std::uint64_t{0});
}

/// The stream's status once it has all `datagrams`, and the pipeline has all frames.
nlohmann::json settled(const RunningDaemon& daemon, std::uint64_t datagrams) {
  for (int attempt = 0; attempt < 1000; ++attempt) {
    const auto stream = daemon.status().at("streams").at("face");
    const bool received =
        number(stream, "/datagrams/received") + number(stream, "/datagrams/kernel_drops") >= datagrams;
    if (received && number(stream, "/processed") >= number(stream, "/admission/emitted")) return stream;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  throw std::runtime_error("the daemon did not get all datagrams, or did not work them off");
}

}  // namespace

ChaosRun run_through_chaos(const ChaosOptions& options, std::uint64_t frames, double rate_hz, std::size_t markers) {
  const TemporaryFolder folder;
  RunningDaemon daemon(folder.path(), "[[source]]\nname = \"face\"\nlisten = \"udp://127.0.0.1:0\"\n",
                       "[reorder]\ndepth = 8\ntimeout_s = 10\n", Recording::kOff);
  if (!daemon.up()) throw std::runtime_error("risoriusd did not start: " + daemon.process().output());
  ProxyThread proxy(parse_send_target(daemon.input("face")), options);
  Sender sender(proxy.input(), {.session = 7});
  send_all(sender, frames, rate_hz, markers);
  // What is held back or delayed goes on before the proxy ends.
  std::this_thread::sleep_for(
      std::chrono::nanoseconds(2 * ChaosProxy::kLongestHoldNs + options.delay_ns + options.jitter_ns));
  proxy.end();
  ChaosRun run{.truth = proxy.truth(), .stream = {}, .frames = frames};
  run.stream = settled(daemon, number(run.truth, "/datagrams/forwarded"));
  daemon.end();
  return run;
}

std::vector<Compared> compare(const ChaosRun& run) {
  const nlohmann::json &d = run.stream, &t = run.truth.at("datagrams");
  const nlohmann::json &frames = run.truth.at("sessions").at("7").at("frames"),
                       &parts = run.truth.at("sessions").at("7").at("datagrams");
  const auto daemon = [&](const char* path) { return number(d, path); };
  std::uint64_t overtaken_too_far = 0;
  for (const auto& [by, count] : frames.at("overtaken_by").items())
    overtaken_too_far += std::stoull(by) >= kReorderDepth ? count.get<std::uint64_t>() : 0;
  const std::uint64_t late = number(frames, "/late_before_first") + number(frames, "/after_end") + overtaken_too_far;
  const std::uint64_t ends = number(parts, "/end_of_stream");
  return {
      {"frames offered to the proxy", run.frames, number(frames, "/offered")},
      {"proxy's own kernel drops", 0, number(t, "/kernel_drops")},
      {"datagrams.kernel_drops", daemon("/datagrams/kernel_drops"), 0},
      {"datagrams.received", daemon("/datagrams/received"), number(t, "/forwarded")},
      {"datagrams.emitted", daemon("/datagrams/emitted"),
       number(parts, "/frame_parts_used") + number(parts, "/marker_set") + (ends > 0 ? 1 : 0)},
      {"datagrams.dropped + held", daemon("/datagrams/dropped") + daemon("/datagrams/held"),
       number(parts, "/frame_parts_repeated") + number(parts, "/frame_parts_of_incomplete") +
           (ends > 0 ? ends - 1 : 0)},
      {"datagrams.refused", daemon("/datagrams/refused"),
       number(t, "/corrupted") + number(parts, "/frame_parts_before_set")},
      {"errors.bad_magic", daemon("/datagrams/errors/bad_magic"), number(t, "/corrupted_in/magic")},
      {"errors.bad_version", daemon("/datagrams/errors/bad_version"), number(t, "/corrupted_in/version")},
      {"errors.bad_checksum", daemon("/datagrams/errors/bad_checksum"), number(t, "/corrupted_in/elsewhere")},
      {"errors.unknown_set", daemon("/datagrams/errors/unknown_set"), number(parts, "/frame_parts_before_set")},
      {"frames.incomplete + held", daemon("/frames/incomplete") + daemon("/frames/assembled/held"),
       number(frames, "/incomplete")},
      {"frames.assembled", daemon("/frames/assembled/emitted"), number(frames, "/whole")},
      {"frames.lost", daemon("/frames/lost"), number(frames, "/lost")},
      {"reorder.duplicates", daemon("/reorder/duplicates"), 0},  // a repeated datagram goes no further than its frame
      {"reorder.late", daemon("/reorder/late"), late},
      {"reorder.restarts", daemon("/reorder/restarts"), 0},
      {"processed", daemon("/processed"), number(frames, "/whole") - late},
  };
}

}  // namespace risorius::test
