#include "replay/live/pacer.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <fmt/format.h>

#include "capture/errors.h"
#include "capture/monotonic_clock.h"

namespace risorius {
namespace {

void require(bool ok, const char* option, auto value, const char* range) {
  if (!ok) throw UserError(option, fmt::format("{} is out of range", value), range);
}

}  // namespace

Pacer::Pacer(const PacerOptions& options) : options_(options) {
  require(options.speed == 0 || (options.speed >= 0.001 && options.speed <= 1000), "speed", options.speed,
          "0.001 to 1000, or 0: as fast as possible");
  require(options.frame_cap_hz >= 0 && options.frame_cap_hz <= 1e6, "frame_cap_hz", options.frame_cap_hz,
          "0 to 1000000 frames/s; 0 is no cap");
  require(options.late_after_ns >= 0, "late_after_ns", options.late_after_ns, "0 or more");
  require(options.longest_gap_ns > 0, "longest_gap_ns", options.longest_gap_ns, "more than 0");
}

std::int64_t Pacer::deadline_ns(std::int64_t capture_time_ns, std::int64_t now_ns) noexcept {
  if (options_.speed == 0) {
    const double interval_ns = options_.frame_cap_hz > 0 ? 1e9 / options_.frame_cap_hz : 0;
    // Time that was lost is not made up for: a burst is what the cap is against.
    const std::int64_t earliest = last_deadline_ns_ ? *last_deadline_ns_ + std::llround(interval_ns) : now_ns;
    last_deadline_ns_ = std::max(earliest, now_ns);
    return *last_deadline_ns_;
  }
  // Unsigned: capture times may be any numbers, and their difference must not overflow.
  const std::uint64_t step =
      static_cast<std::uint64_t>(capture_time_ns) - static_cast<std::uint64_t>(last_capture_time_ns_);
  if (!start_ || step > static_cast<std::uint64_t>(options_.longest_gap_ns)) start_ = Start{now_ns, capture_time_ns};
  last_capture_time_ns_ = capture_time_ns;
  const auto since_start_ns = static_cast<double>(capture_time_ns - start_->capture_time_ns);
  return start_->time_ns + std::llround(since_start_ns / options_.speed);
}

void Pacer::record(std::int64_t deadline_ns, std::int64_t sent_ns) noexcept {
  const std::int64_t lateness_ns = std::max<std::int64_t>(sent_ns - deadline_ns, 0);
  ++statistics_.frames;
  if (lateness_ns > options_.late_after_ns) ++statistics_.late_frames;
  statistics_.max_lateness_ns = std::max(statistics_.max_lateness_ns, lateness_ns);
}

bool Pacer::wait(std::int64_t capture_time_ns) noexcept {
  const std::int64_t now_ns = monotonic_now_ns();
  const std::int64_t due_ns = deadline_ns(capture_time_ns, now_ns);
  if (due_ns > now_ns) {
    const timespec due{.tv_sec = due_ns / 1'000'000'000, .tv_nsec = due_ns % 1'000'000'000};
    if (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, nullptr) != 0) return false;
  }
  record(due_ns, monotonic_now_ns());
  return true;
}

}  // namespace risorius
