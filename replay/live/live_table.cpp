#include "replay/live/live_table.h"

#include <cstdio>
#include <fmt/format.h>
#include <unistd.h>

#include "capture/monotonic_clock.h"

namespace risorius {

LiveTable::LiveTable() : terminal_(isatty(STDOUT_FILENO) == 1) {}

void LiveTable::redraw() {
  const std::int64_t now = monotonic_now_ns();
  if (now - drawn_ns_ < (terminal_ ? 200'000'000 : 1'000'000'000)) return;
  const bool first = drawn_ns_ == 0;
  drawn_ns_ = now;
  const auto lines = view_.lines(now);
  if (first) return;  // rates need two looks
  if (terminal_ && drawn_lines_ > 0) fmt::print("\x1b[{}A", drawn_lines_);
  for (const auto& line : lines) fmt::print("{}{}\n", line, terminal_ ? "\x1b[K" : "");
  drawn_lines_ = lines.size();
  std::fflush(stdout);
}

}  // namespace risorius
