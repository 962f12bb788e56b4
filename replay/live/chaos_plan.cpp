#include "replay/live/chaos_plan.h"

#include <fmt/format.h>

#include "capture/errors.h"

namespace risorius {
namespace {

enum Stream : std::uint64_t {
  kLossStream,
  kBurstStream,
  kDuplicateStream,
  kCorruptStream,
  kReorderStream,
  kJitterStream
};

void require(bool ok, const char* option, double value, const char* range) {
  if (!ok) throw UserError(option, fmt::format("{} is out of range", value), range);
}

const ChaosOptions& checked(const ChaosOptions& options) {
  const auto probability = [](const char* name, double p) {
    require(p >= 0 && p <= 1, name, p, "a probability, 0 to 1: 0.05 is 5 %");
  };
  probability("loss", options.loss);
  probability("reorder", options.reorder);
  probability("duplicate", options.duplicate);
  probability("corrupt", options.corrupt);
  const auto time = [](const char* name, std::int64_t ns, std::int64_t least_ns, const char* range) {
    constexpr std::int64_t kDayNs = 86'400'000'000'000;
    require(ns >= least_ns && ns <= kDayNs, name, static_cast<double>(ns), range);
  };
  time("burst_ns", options.burst_ns, 0, "0 to a day, in ns");
  time("burst_interval_ns", options.burst_interval_ns, 1, "more than 0, at most a day, in ns");
  time("delay_ns", options.delay_ns, 0, "0 to a day, in ns");
  time("jitter_ns", options.jitter_ns, 0, "0 to a day, in ns");
  return options;
}

}  // namespace

ChaosPlan::ChaosPlan(const ChaosOptions& options)
    : options_(checked(options)),
      loss_(options.seed, kLossStream),
      burst_(options.seed, kBurstStream),
      duplicate_(options.seed, kDuplicateStream),
      corrupt_(options.seed, kCorruptStream),
      reorder_(options.seed, kReorderStream),
      jitter_(options.seed, kJitterStream) {}

bool ChaosPlan::in_burst(std::int64_t time_ns) noexcept {
  if (options_.burst_ns == 0) return false;
  const auto next_after = [this](std::int64_t end_ns) {
    return end_ns + static_cast<std::int64_t>(burst_.exponential(static_cast<double>(options_.burst_interval_ns)));
  };
  if (!burst_begin_ns_) burst_begin_ns_ = next_after(time_ns);
  while (time_ns >= *burst_begin_ns_ + options_.burst_ns) {
    if (!burst_counted_) ++bursts_;  // it passed between two datagrams
    burst_counted_ = false;
    burst_begin_ns_ = next_after(*burst_begin_ns_ + options_.burst_ns);
  }
  if (time_ns < *burst_begin_ns_) return false;
  if (!burst_counted_) ++bursts_;
  burst_counted_ = true;
  return true;
}

ChaosDecision ChaosPlan::decide(std::size_t bytes, std::int64_t time_ns) noexcept {
  ChaosDecision decision;
  const bool lost = loss_.chance(options_.loss), twice = duplicate_.chance(options_.duplicate);
  for (ChaosCopy& copy : decision.copy) {
    const bool corrupt = corrupt_.chance(options_.corrupt), hold = reorder_.chance(options_.reorder);
    const double bit = corrupt_.uniform();
    const std::size_t held_back = 1 + reorder_.index(kMostHeldBack);
    const double jitter = jitter_.uniform();
    if (corrupt && bytes > 0) copy.turned_bit = static_cast<std::size_t>(bit * static_cast<double>(8 * bytes));
    if (hold) copy.held_back = static_cast<std::uint32_t>(held_back);
    copy.delay_ns = options_.delay_ns + static_cast<std::int64_t>(jitter * static_cast<double>(options_.jitter_ns));
  }
  if (in_burst(time_ns)) {
    decision.fate = ChaosFate::kLostInBurst;
  } else if (lost) {
    decision.fate = ChaosFate::kLost;
  } else {
    decision.copies = twice ? 2 : 1;
  }
  return decision;
}

}  // namespace risorius
