// Offset and skew of a tracker's clock against ours, from what a source sees.
//
// Two kinds of evidence. Where the protocol has an echo, the middle of a round trip is when the tracker read its clock,
// wrong by at most half the round trip: the shortest ones are kept. Otherwise there are only arrival times, each late
// by an unknown delay that is never negative: our clock minus theirs lies on or under all points, and the line nearest
// under them all is found on the lower convex hull (Moon, Skelly, Towsley 1999). That offset contains the smallest
// delay of the way: latencies measured with it are latencies above that smallest one. One thread; the values are read
// from any. Bounded memory, no allocation; capture times never change by it.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "capture/counters.h"

namespace risorius {

class ClockSync {
 public:
  /// A frame of this capture time (tracker's clock) was received at this time (ours).
  void add_arrival(std::int64_t capture_ns, std::int64_t receive_ns) noexcept;
  /// An echo left at `sent_ns` and came back at `received_ns` (ours) with the tracker's clock in it.
  void add_echo(std::int64_t sent_ns, std::int64_t tracker_ns, std::int64_t received_ns) noexcept;
  /// The tracker has begun anew: nothing that was learnt holds.
  void reset() noexcept;

  bool known() const noexcept { return known_.load(std::memory_order_acquire); }
  /// Of echoes rather than of arrivals.
  bool has_echo() const noexcept { return has_echo_.load(std::memory_order_relaxed); }
  /// Our clock minus the tracker's, at its latest reading.
  std::int64_t offset_ns() const noexcept { return offset_ns_.load(std::memory_order_relaxed); }
  /// By how many millionths our clock runs faster than the tracker's; 0 until some seconds were seen. A take played at
  /// twice its pace has -500,000.
  double skew_ppm() const noexcept { return skew_ppm_.load(std::memory_order_relaxed); }
  /// Half the shortest round trip; with arrivals alone the delay is unknown, and this is 0.
  std::int64_t uncertainty_ns() const noexcept { return uncertainty_ns_.load(std::memory_order_relaxed); }
  /// The tracker's time in our clock.
  std::int64_t to_ours_ns(std::int64_t tracker_ns) const noexcept;
  /// How often the tracker's clock leapt against the line and all was learnt anew.
  const Counter& leaps() const noexcept { return leaps_; }

 private:
  /// The best evidence of one second of the tracker's clock.
  struct Point {
    std::int64_t tracker_ns = 0, offset_ns = 0, round_trip_ns = 0;
  };
  static constexpr std::size_t kSeconds = 64;

  void add(const Point& point, bool is_echo) noexcept;
  bool leaps(const Point& point) noexcept;
  bool stays_behind(const Point& point) noexcept;
  bool steps_ahead(const Point& point) const noexcept;
  void fit() noexcept;
  void fit_under_all() noexcept;
  void fit_shortest_round_trips() noexcept;
  void publish(double offset_ns_from_first, double slope) noexcept;

  std::array<Point, kSeconds> points_;  ///< ring, by time
  std::size_t first_ = 0, count_ = 0;
  double slope_ = 0;               ///< of the offset, per ns of the tracker's clock
  std::int64_t reference_ns_ = 0;  ///< the tracker's time that offset_ns_ belongs to
  Point previous_;                 ///< the reading before this one
  std::int64_t newest_ns_ = 0;     ///< the tracker's latest time
  std::size_t behind_ = 0;         ///< readings in a row that are behind it

  std::atomic<bool> known_{false}, has_echo_{false};
  std::atomic<std::int64_t> offset_ns_{0}, uncertainty_ns_{0};
  std::atomic<double> skew_ppm_{0};
  Counter leaps_;
};

}  // namespace risorius
