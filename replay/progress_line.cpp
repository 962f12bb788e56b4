#include "replay/progress_line.h"

#include <cstdio>
#include <fmt/format.h>
#include <unistd.h>

#include "capture/monotonic_clock.h"

namespace risorius {
namespace {

constexpr std::int64_t kRedrawTerminalNs = 100'000'000;
constexpr std::int64_t kRedrawFileNs = 10'000'000'000;

std::string duration_text(double seconds) {
  if (seconds < 90) return fmt::format("{:.0f} s", seconds);
  return fmt::format("{:.0f} min", seconds / 60);
}

}  // namespace

ProgressLine::ProgressLine(std::string what, std::string unit)
    : what_(std::move(what)),
      unit_(std::move(unit)),
      begin_ns_(monotonic_now_ns()),
      terminal_(isatty(STDERR_FILENO) == 1) {}

ProgressLine::~ProgressLine() {
  if (terminal_ && !finished_ && drawn_ns_ > 0) std::fputs("\n", stderr);
}

void ProgressLine::show(std::uint64_t done, std::uint64_t of) {
  const std::scoped_lock lock(mutex_);
  const std::int64_t now = monotonic_now_ns();
  const std::int64_t last = drawn_ns_ > 0 ? drawn_ns_ : begin_ns_;
  if (finished_ || now - last < (terminal_ ? kRedrawTerminalNs : kRedrawFileNs)) return;
  drawn_ns_ = now;
  draw(done, of, false);
}

void ProgressLine::finish(std::uint64_t done) {
  const std::scoped_lock lock(mutex_);
  if (finished_) return;
  finished_ = true;
  draw(done, done, true);
}

void ProgressLine::draw(std::uint64_t done, std::uint64_t of, bool last) {
  const double seconds = static_cast<double>(monotonic_now_ns() - begin_ns_) * 1e-9;
  const double rate = seconds > 0 ? static_cast<double>(done) / seconds : 0;
  std::string line = fmt::format("{}: {} {}", what_, done, unit_);
  const bool is_share = unit_ == "%";  // which needs no share and no rate of its own
  if (!last && of > 0 && !is_share)
    line += fmt::format(" of {} ({:.0f} %)", of, 100 * static_cast<double>(done) / static_cast<double>(of));
  if (!is_share && rate > 0)
    line += fmt::format(", {} {}/s", rate < 10 ? fmt::format("{:.2g}", rate) : fmt::format("{:.0f}", rate), unit_);
  if (!last && of > done && rate > 0) line += ", " + duration_text(static_cast<double>(of - done) / rate) + " left";
  if (last) line += fmt::format(", {:.1f} s", seconds);
  // The terminal's line is padded: a shorter text must cover the longer one before it.
  if (terminal_) {
    fmt::print(stderr, "\r{:<100}{}", line, last ? "\n" : "");
  } else {
    fmt::print(stderr, "{}\n", line);
  }
  std::fflush(stderr);
}

}  // namespace risorius
