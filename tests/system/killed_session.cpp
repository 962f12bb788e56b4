#include "system/killed_session.h"

#include <chrono>
#include <csignal>
#include <cstring>
#include <thread>
#include <vector>

#include "capture/monotonic_clock.h"
#include "replay/performer/performer.h"
#include "replay/session/session_reader.h"
#include "replay/session/session_recover.h"
#include "replay/session/session_verify.h"
#include "replay/session/tick_codec.h"
#include "solve/faces/builtin_face.h"
#include "system/running_daemon.h"

namespace risorius::test {
namespace {

constexpr const char* kTake = "builtin:60";

void no_progress(std::uint64_t, std::uint64_t) {}

/// Both in mm and LUF: what the performer made, and what was admitted.
bool is_equal(const MarkerFrame& sent, const MarkerFrame& admitted) {
  if (sent.header.sequence != admitted.header.sequence || sent.count != admitted.count) return false;
  if (sent.header.capture_time_ns != admitted.header.capture_time_ns) return false;
  for (std::uint32_t m = 0; m < sent.count; ++m) {
    const bool measured = sent.state[m] == MarkerState::kMeasured;
    if (measured != (admitted.state[m] == MarkerState::kMeasured)) return false;
    if (measured && std::memcmp(&sent.position_mm[m], &admitted.position_mm[m], sizeof(Position)) != 0) return false;
  }
  return true;
}

/// Compares the Ticks with the take and takes the time of the last.
void compare(const std::filesystem::path& file, KilledSession& result, std::int64_t& last_tick_ns) {
  PerformerTake take(builtin_rig(), {.seconds = 60});
  SessionReader reader(file);
  SessionTick tick;
  MarkerFrame sent;
  while (reader.next()) {
    if (reader.topic() != SessionTopic::kTicks) continue;
    last_tick_ns = reader.message().log_time_ns;
    if (!decode_tick(reader.message().data, tick)) {
      ++result.corrupted_frames;
      continue;
    }
    if (tick.kind != TickKind::kFrame) continue;
    ++result.frames;
    // The first frames may have come before the daemon knew the set; from then on none is left out.
    bool more = take.next(sent);
    while (result.frames == 1 && more && sent.header.sequence < tick.frame.header.sequence) more = take.next(sent);
    if (!more || !is_equal(sent, tick.frame)) ++result.corrupted_frames;
  }
}

}  // namespace

KilledSession record_and_kill(const std::filesystem::path& folder, double seconds) {
  KilledSession result;
  const auto file = folder / "killed.mcap", recovered = folder / "recovered.mcap";
  RunningDaemon daemon(folder, "[[source]]\nname = \"face\"\nlisten = \"udp://127.0.0.1:0\"\n",
                       "session = \"" + file.string() + "\"\n", Recording::kOff);
  if (!daemon.up()) {
    result.problem = daemon.process().output();
    return result;
  }
  Process sender({program("risorius").string(), "replay", kTake, "--to", daemon.input("face"), "--quiet"});
  const std::int64_t begin_ns = monotonic_now_ns();
  while (daemon.status().at("streams").at("face").at("processed") == 0) {
    if (monotonic_now_ns() - begin_ns > 30'000'000'000) {
      result.problem = "no frame was solved within 30 s";
      return result;
    }
  }
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  const std::int64_t killed_ns = utc_now_ns();
  daemon.process().send_signal(SIGKILL);
  daemon.process().finish(10);
  try {
    recover_session(file, recovered, no_progress);
    std::int64_t last_tick_ns = 0;
    compare(recovered, result, last_tick_ns);
    result.lost_s = static_cast<double>(killed_ns - last_tick_ns) * 1e-9;
    const SessionVerdict verdict = verify_session(recovered, no_progress);
    result.solved_equal = verdict.equal();
    result.solved_different = verdict.different();
  } catch (const std::exception& error) {
    result.problem = error.what();
  }
  return result;
}

}  // namespace risorius::test
