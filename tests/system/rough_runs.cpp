#include "system/rough_runs.h"

#include <csignal>
#include <sys/wait.h>
#include <unistd.h>

#include "capture/monotonic_clock.h"
#include "replay/live/pacer.h"
#include "replay/live/sender.h"
#include "support/native_stream.h"
#include "system/own_daemon.h"

namespace risorius::test {
namespace {

constexpr std::size_t kMarkers = 60;

/// A process that sends at 120 Hz until it is killed.
pid_t start_sender(const SendTarget& target) {
  const pid_t id = fork();
  if (id != 0) return id;
  Sender sender(target);
  sender.send_marker_set(marker_set(kMarkers));
  Pacer pacer;
  for (std::uint64_t s = 0;; ++s) {
    MarkerFrame frame = marker_frame(s % 1000, kMarkers);
    frame.header.sequence = s;
    frame.header.capture_time_ns = static_cast<std::int64_t>(s) * 8'333'333;
    pacer.wait(frame.header.capture_time_ns);
    sender.send_frame(frame);
  }
}

void end_sender(pid_t id) {
  kill(id, SIGKILL);
  waitpid(id, nullptr, 0);
}

}  // namespace

RestartRun kill_and_restart_sender(std::size_t times) {
  OwnDaemon daemon(source_table("face"));
  const SendTarget target = parse_send_target(daemon.running.input("face"));
  const auto processed = [&] { return number(daemon.stream("face"), "/processed"); };
  RestartRun run;
  pid_t sender = start_sender(target);
  bool heard = wait_until([&] { return processed() > 30; });
  const ProcessUsage before = daemon.usage();
  ProcessUsage settled;
  for (std::size_t i = 0; i < times && heard; ++i) {
    if (i == times / 4) settled = daemon.usage();
    end_sender(sender);
    // What the dead sender left in the sockets is worked off.
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    const std::uint64_t so_far = processed();
    const std::int64_t begin_ns = monotonic_now_ns();
    sender = start_sender(target);
    heard = wait_until([&] { return processed() > so_far; });
    run.resume_ms.push_back(static_cast<double>(monotonic_now_ns() - begin_ns) * 1e-6);
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
  }
  end_sender(sender);
  if (!heard) throw std::runtime_error("the daemon hears no sender");
  const ProcessUsage after = daemon.usage();
  run.descriptors_before = before.descriptors;
  run.descriptors_after = after.descriptors;
  run.resident_growth_bytes = after.resident_bytes - before.resident_bytes;
  run.settled_resident_growth_bytes = after.resident_bytes - settled.resident_bytes;
  run.sessions = number(daemon.stream("face"), "/frames/sessions");
  daemon.running.end();
  return run;
}

ClockJumpRun jump_tracker_clock(std::uint64_t frames) {
  constexpr std::int64_t kSecondNs = 1'000'000'000;
  OwnDaemon daemon(source_table("face"));
  Sender sender(parse_send_target(daemon.running.input("face")));
  sender.send_marker_set(marker_set(kMarkers));
  Pacer pacer;
  ClockJumpRun run;
  std::int64_t offset_ns = 0;
  for (const std::int64_t jump_ns :
       {std::int64_t{0}, 3600 * kSecondNs, -7200 * kSecondNs, 60 * kSecondNs, -kSecondNs}) {
    offset_ns += jump_ns;
    run.jumps += jump_ns != 0 ? 1 : 0;
    for (std::uint64_t i = 0; i < frames; ++i) {
      const auto time_ns = static_cast<std::int64_t>(static_cast<double>(run.sent) * 1e9 / 240);
      pacer.wait(time_ns);
      MarkerFrame frame = marker_frame(run.sent++, kMarkers);
      frame.header.capture_time_ns = time_ns + offset_ns;
      sender.send_frame(frame);
    }
  }
  sender.send_end_of_stream();
  wait_until([&] {
    const auto stream = daemon.stream("face");
    return number(stream, "/processed") + gone(stream) >= run.sent;
  });
  const auto stream = daemon.stream("face");
  run.processed = number(stream, "/processed");
  run.gone = gone(stream);
  run.leaps = number(stream, "/clock/leaps");
  daemon.running.end();
  return run;
}

}  // namespace risorius::test
