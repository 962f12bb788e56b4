// Bad networks between a sender and the daemon: every counter of the daemon against the truth of the proxy that made
// the faults. Then senders that are killed, a tracker's clock that jumps, and a flood of garbage beside a stream.
#include <algorithm>
#include <fmt/core.h>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/bench_report.h"
#include "system/chaos_run.h"
#include "system/flood_run.h"
#include "system/rough_runs.h"

namespace risorius::bench {
namespace {

constexpr std::uint64_t kFrames = 4800;
constexpr double kRateHz = 480;
constexpr std::int64_t kMs = 1'000'000;

struct Case {
  std::string name;
  ChaosOptions options;
  std::size_t markers = 165;
};

ChaosOptions outages(std::int64_t ms) {
  return {.burst_ns = ms * kMs, .burst_interval_ns = 1000 * kMs, .seed = static_cast<std::uint64_t>(ms)};
}

std::vector<Case> cases() {
  return {{"loss 0 %", {}},
          {"loss 1 %", {.loss = 0.01, .seed = 1}},
          {"loss 5 %", {.loss = 0.05, .seed = 2}},
          {"loss 10 %", {.loss = 0.1, .seed = 3}},
          {"loss 20 %", {.loss = 0.2, .seed = 4}},
          {"outages of 50 ms", outages(50)},
          {"outages of 200 ms", outages(200)},
          {"outages of 500 ms", outages(500)},
          {"5 % reordered", {.reorder = 0.05, .seed = 5}},
          {"5 % duplicated", {.duplicate = 0.05, .seed = 6}},
          {"1 % corrupted", {.corrupt = 0.01, .seed = 7}},
          {"all together",
           {.loss = 0.2,
            .reorder = 0.05,
            .duplicate = 0.05,
            .corrupt = 0.01,
            .burst_ns = 200 * kMs,
            .burst_interval_ns = 2000 * kMs,
            .seed = 8}},
          {"20 ms of jitter, 60 markers", {.jitter_ns = 20 * kMs, .seed = 9}, 60}};
}

void compare_all(BenchReport& report) {
  double compared = 0, sent = 0, lost = 0;
  for (const Case& c : cases()) {
    fmt::print(stderr, "{}\n", c.name);
    const test::ChaosRun run = test::run_through_chaos(c.options, kFrames, kRateHz, c.markers);
    double differ = 0;
    for (const auto& [what, daemon, truth] : test::compare(run)) {
      ++compared;
      if (daemon == truth) continue;
      ++differ;
      fmt::print(stderr, "  {}: daemon {}, truth {}\n", what, daemon, truth);
    }
    sent += static_cast<double>(run.frames);
    lost += run.stream.at("frames").at("lost").get<double>();
    report.add(c.name + ": numbers that differ from the truth", differ);
  }
  report.add("numbers compared in all", compared);
  report.add("frames sent in all", sent);
  report.add("frames lost, by the daemon and by the truth", lost);
}

int measure() {
  BenchReport report("chaos");
  compare_all(report);

  fmt::print(stderr, "20 restarts of a killed sender\n");
  const test::RestartRun restarts = test::kill_and_restart_sender(20);
  report.add("20 restarts: longest until heard",
             *std::max_element(restarts.resume_ms.begin(), restarts.resume_ms.end()));
  report.add("20 restarts: descriptors gained",
             static_cast<double>(restarts.descriptors_after) - static_cast<double>(restarts.descriptors_before));
  report.add("20 restarts: memory gained", restarts.resident_growth_bytes * 1e-6);
  report.add("20 restarts: memory gained from the 5th to the last", restarts.settled_resident_growth_bytes * 1e-6);

  fmt::print(stderr, "jumps of the tracker's clock\n");
  const test::ClockJumpRun jumps = test::jump_tracker_clock(1200);
  report.add("clock jumps: frames gone", static_cast<double>(jumps.sent) - static_cast<double>(jumps.processed));
  report.add("clock jumps: of four, noticed", static_cast<double>(jumps.leaps));

  fmt::print(stderr, "a flood beside a stream\n");
  const test::FloodRun flood = test::flood_beside_a_stream(6, 5);
  report.add("flood: garbage sent", flood.flood_rate_hz);
  report.add("flood: p50 without", flood.quiet_p50_ms);
  report.add("flood: p50 with", flood.flooded_p50_ms);
  report.add("flood: p99 without", flood.quiet_p99_ms);
  report.add("flood: p99 with", flood.flooded_p99_ms);
  report.add("flood: p99 with / without", flood.flooded_p99_ms / flood.quiet_p99_ms);
  report.add("flood: frames of the other stream gone", static_cast<double>(flood.lost));
  report.add("flood: garbage unaccounted for",
             static_cast<double>(flood.flood_sent) - static_cast<double>(flood.flood_accounted));
  report.add("flood: memory gained", flood.resident_growth_bytes * 1e-6);
  return report.finish();
}

}  // namespace
}  // namespace risorius::bench

int main() {
  try {
    return risorius::bench::measure();
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench chaos: {}\n", error.what());
    return 2;
  }
}
