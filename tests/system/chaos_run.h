// A stream through a ChaosProxy into a real daemon, and the daemon's counters beside the proxy's truth.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "replay/live/chaos_plan.h"

namespace risorius::test {

struct ChaosRun {
  nlohmann::json truth;      ///< ChaosProxy::truth
  nlohmann::json stream;     ///< the stream's status, when all that came was worked off
  std::uint64_t frames = 0;  ///< sent
};

/// `frames` frames of `markers` (those of more than 117 are two datagrams) at `rate_hz`, through the proxy, with the
/// end-of-stream message. The daemon's reorder window (8 frames) waits for frames, not for time, so that its counters
/// depend on the order of datagrams alone. Throws std::runtime_error if a program does not start or the daemon does not
/// settle.
ChaosRun run_through_chaos(const ChaosOptions& options, std::uint64_t frames, double rate_hz,
                           std::size_t markers = 165);

/// A number that both sides know.
struct Compared {
  std::string what;
  std::uint64_t daemon = 0, truth = 0;
};

/// All of them, as they should be equal. Datagrams that the kernel dropped before our socket are the daemon's
/// `kernel_drops`, and known to be 0 or the comparison means nothing: they are compared with 0.
std::vector<Compared> compare(const ChaosRun& run);

}  // namespace risorius::test
