#include "capture/clock_sync.h"

#include <algorithm>
#include <cmath>

#include "capture/frames.h"

namespace risorius {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;
/// A reading further from the line than this is another clock, not a late packet: a tracker was restarted, or set.
/// Arrivals may be late, but never so early.
constexpr std::int64_t kLeapEarlyNs = 100'000'000, kLeapLateNs = 5 * kSecond;
/// Takes are played at up to this pace. A tracker's clock that advances more between two frames has leapt.
constexpr double kFastestPace = 20;
/// A packet that was overtaken is behind for itself; so many in a row are a clock that was set back.
constexpr std::int64_t kBehindNs = 250'000'000;
constexpr std::size_t kReadingsBehind = 16;
/// Round trips up to so much longer than the shortest one are believed.
constexpr double kBelievedRoundTrip = 1.5;
constexpr std::int64_t kBelievedSlackNs = 50'000;
/// A slope from a shorter stretch says more about jitter than about clocks.
constexpr std::int64_t kShortestStretchNs = 5 * kSecond;
/// 73 years either way: beyond, a time is no time, and differences of differences would overflow.
constexpr std::int64_t kFarthestNs = (std::int64_t{1} << 61U) - 1;

bool is_time(std::int64_t time_ns) noexcept { return time_ns > -kFarthestNs && time_ns < kFarthestNs; }

std::int64_t second_of(std::int64_t time_ns) noexcept { return time_ns / kSecond - (time_ns % kSecond < 0 ? 1 : 0); }

}  // namespace

void ClockSync::add_arrival(std::int64_t capture_ns, std::int64_t receive_ns) noexcept {
  if (has_echo()) return;  // the better evidence
  if (!is_time(capture_ns) || !is_time(receive_ns)) return;
  add({.tracker_ns = capture_ns, .offset_ns = difference_ns(receive_ns, capture_ns), .round_trip_ns = 0}, false);
}

void ClockSync::add_echo(std::int64_t sent_ns, std::int64_t tracker_ns, std::int64_t received_ns) noexcept {
  if (!is_time(sent_ns) || !is_time(tracker_ns) || !is_time(received_ns)) return;
  const std::int64_t round_trip_ns = received_ns - sent_ns;
  if (round_trip_ns < 0 || round_trip_ns > kLeapLateNs) return;
  if (!has_echo()) reset();  // arrivals measured something else
  add({.tracker_ns = tracker_ns,
       .offset_ns = difference_ns(sent_ns + round_trip_ns / 2, tracker_ns),
       .round_trip_ns = round_trip_ns},
      true);
}

void ClockSync::reset() noexcept {
  first_ = count_ = behind_ = 0;
  slope_ = 0;
  has_echo_.store(false, std::memory_order_relaxed);
  known_.store(false, std::memory_order_release);
}

std::int64_t ClockSync::to_ours_ns(std::int64_t tracker_ns) const noexcept { return tracker_ns + offset_ns(); }

bool ClockSync::stays_behind(const Point& point) noexcept {
  const std::int64_t behind_ns = difference_ns(newest_ns_, point.tracker_ns);
  behind_ = behind_ns > kBehindNs ? behind_ + 1 : 0;
  return behind_ns > kSecond || behind_ == kReadingsBehind;
}

/// Against the reading before it alone. So does a fresh packet after a late one: the line must say the same.
bool ClockSync::steps_ahead(const Point& point) const noexcept {
  const auto theirs_ns = static_cast<double>(difference_ns(point.tracker_ns, previous_.tracker_ns));
  const double ours_ns = theirs_ns + static_cast<double>(difference_ns(point.offset_ns, previous_.offset_ns));
  return theirs_ns - ours_ns > static_cast<double>(kLeapEarlyNs) + kFastestPace * std::max(ours_ns, 0.0);
}

bool ClockSync::leaps(const Point& point) noexcept {
  if (count_ == 0) return false;
  if (stays_behind(point)) return true;
  const double ahead_ns = static_cast<double>(difference_ns(point.tracker_ns, reference_ns_));
  const double expected_ns = static_cast<double>(offset_ns()) + slope_ * ahead_ns;
  const double error_ns = static_cast<double>(point.offset_ns) - expected_ns;
  // Before the slope is known, a take played at another pace runs away from the line by itself, step by step.
  const bool has_slope = slope_ != 0;
  if (error_ns < -static_cast<double>(kLeapEarlyNs)) return has_slope || steps_ahead(point);
  return error_ns > static_cast<double>(kLeapLateNs) + (has_slope ? 0 : std::abs(ahead_ns));
}

void ClockSync::add(const Point& point, bool is_echo) noexcept {
  if (leaps(point)) {
    leaps_.add();
    reset();
  }
  newest_ns_ = count_ == 0 ? point.tracker_ns : std::max(newest_ns_, point.tracker_ns);
  previous_ = point;
  has_echo_.store(is_echo, std::memory_order_relaxed);
  Point* last = count_ > 0 ? &points_[(first_ + count_ - 1) % kSeconds] : nullptr;
  if (last != nullptr && second_of(point.tracker_ns) < second_of(last->tracker_ns)) return;  // late; nothing new in it
  if (last == nullptr || second_of(point.tracker_ns) > second_of(last->tracker_ns)) {
    if (count_ == kSeconds) {
      first_ = (first_ + 1) % kSeconds;
      --count_;
    }
    points_[(first_ + count_++) % kSeconds] = point;
    fit();
    return;
  }
  const bool better = is_echo ? point.round_trip_ns < last->round_trip_ns : point.offset_ns < last->offset_ns;
  if (!better) return;
  *last = point;
  fit();
}

void ClockSync::fit() noexcept {
  if (has_echo()) {
    fit_shortest_round_trips();
  } else {
    fit_under_all();
  }
}

/// The line under all points with the smallest sum of distances passes along the lower hull's edge above the mean time.
void ClockSync::fit_under_all() noexcept {
  std::array<std::size_t, kSeconds> hull{};
  std::size_t corners = 0;
  const auto at = [&](std::size_t i) -> const Point& { return points_[(first_ + i) % kSeconds]; };
  // Relative to the first point, so that doubles hold nanoseconds.
  const auto x = [&](std::size_t i) { return static_cast<double>(at(i).tracker_ns - at(0).tracker_ns); };
  const auto y = [&](std::size_t i) { return static_cast<double>(at(i).offset_ns - at(0).offset_ns); };
  double mean = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    mean += x(i) / static_cast<double>(count_);
    while (corners >= 2) {
      const std::size_t a = hull[corners - 2], b = hull[corners - 1];
      if ((y(b) - y(a)) * (x(i) - x(a)) < (y(i) - y(a)) * (x(b) - x(a))) break;
      --corners;  // b lies on or above the line from a to i
    }
    hull[corners++] = i;
  }
  const double stretch_ns = x(count_ - 1);
  double slope = 0, offset = 0;
  if (stretch_ns >= static_cast<double>(kShortestStretchNs)) {
    std::size_t edge = 1;
    while (edge + 1 < corners && x(hull[edge]) < mean) ++edge;
    const std::size_t a = hull[edge - 1], b = hull[edge];
    slope = (y(b) - y(a)) / (x(b) - x(a));
    offset = y(a) + slope * (stretch_ns - x(a));
  } else {
    // One level: the smallest of all.
    offset = y(0);
    for (std::size_t i = 1; i < count_; ++i) offset = std::min(offset, y(i));
  }
  uncertainty_ns_.store(0, std::memory_order_relaxed);
  publish(offset, slope);
}

/// Least squares through the points whose round trips are near the shortest one.
void ClockSync::fit_shortest_round_trips() noexcept {
  const auto at = [&](std::size_t i) -> const Point& { return points_[(first_ + i) % kSeconds]; };
  std::int64_t shortest_ns = at(0).round_trip_ns;
  for (std::size_t i = 1; i < count_; ++i) shortest_ns = std::min(shortest_ns, at(i).round_trip_ns);
  const double believed_ns =
      kBelievedRoundTrip * static_cast<double>(shortest_ns) + static_cast<double>(kBelievedSlackNs);
  double n = 0, sum_x = 0, sum_y = 0, sum_xx = 0, sum_xy = 0, first_x = 0, last_x = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    if (static_cast<double>(at(i).round_trip_ns) > believed_ns) continue;
    const auto x = static_cast<double>(at(i).tracker_ns - at(0).tracker_ns);
    const auto y = static_cast<double>(at(i).offset_ns - at(0).offset_ns);
    if (n == 0) first_x = x;
    last_x = x;
    n += 1;
    sum_x += x;
    sum_y += y;
    sum_xx += x * x;
    sum_xy += x * y;
  }
  const double spread = n * sum_xx - sum_x * sum_x;
  const bool has_slope = last_x - first_x >= static_cast<double>(kShortestStretchNs) && spread > 0;
  const double slope = has_slope ? (n * sum_xy - sum_x * sum_y) / spread : 0;
  const auto stretch_ns = static_cast<double>(at(count_ - 1).tracker_ns - at(0).tracker_ns);
  uncertainty_ns_.store(shortest_ns / 2, std::memory_order_relaxed);
  publish(sum_y / n + slope * (stretch_ns - sum_x / n), slope);
}

void ClockSync::publish(double offset_ns_from_first, double slope) noexcept {
  const Point& first = points_[first_];
  reference_ns_ = points_[(first_ + count_ - 1) % kSeconds].tracker_ns;
  slope_ = slope;
  const double farthest = static_cast<double>(kFarthestNs);
  offset_ns_.store(first.offset_ns + std::llround(std::clamp(offset_ns_from_first, -farthest, farthest)),
                   std::memory_order_relaxed);
  skew_ppm_.store(1e6 * slope, std::memory_order_relaxed);
  known_.store(true, std::memory_order_release);
}

}  // namespace risorius
