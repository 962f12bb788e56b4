// Says when a frame is due, and waits for it: absolute deadlines from the first frame on, so that errors do not add up.
//
//   deadline = start + (capture time - first capture time) / speed
//
// With speed 0 frames are due at once, but not closer to each other than 1 / cap. The reckoning is pure; only wait()
// looks at the clock.
#pragma once

#include <cstdint>
#include <optional>

namespace risorius {

struct PacerOptions {
  double speed = 1;                                 ///< 2 is twice as fast, 0.001 to 1000; 0: as fast as the cap allows
  double frame_cap_hz = 0;                          ///< with speed 0: frames per second at most, 0 no cap, at most 1e6
  std::int64_t late_after_ns = 1'000'000;           ///< a frame later than this counts as late; >= 0
  std::int64_t longest_gap_ns = 3'600'000'000'000;  ///< a longer jump of capture times, or one back, starts anew; > 0
};

struct PacerStatistics {
  std::uint64_t frames = 0;
  std::uint64_t late_frames = 0;
  std::int64_t max_lateness_ns = 0;
};

class Pacer {
 public:
  /// Throws UserError naming the option, its value and range.
  explicit Pacer(const PacerOptions& options = {});

  /// When the next frame is due, in ns of the clock that `now_ns` is read from. Call once per frame, in their order.
  std::int64_t deadline_ns(std::int64_t capture_time_ns, std::int64_t now_ns) noexcept;
  /// Takes note of when the frame went out that was due at `deadline_ns`.
  void record(std::int64_t deadline_ns, std::int64_t sent_ns) noexcept;
  /// Sleeps until the frame is due, by CLOCK_MONOTONIC, and records it. False if a signal came first: the frame is not
  /// recorded.
  bool wait(std::int64_t capture_time_ns) noexcept;

  const PacerStatistics& statistics() const noexcept { return statistics_; }

 private:
  struct Start {
    std::int64_t time_ns, capture_time_ns;
  };

  PacerOptions options_;
  std::optional<Start> start_;
  std::int64_t last_capture_time_ns_ = 0;
  std::optional<std::int64_t> last_deadline_ns_;
  PacerStatistics statistics_;
};

}  // namespace risorius
