#include "replay/picture/repair_picture.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <limits>

#include "capture/errors.h"
#include "replay/picture/plot.h"

namespace risorius {
namespace {

constexpr double kPlotWidth = 620, kPlotHeight = 250, kMargin = 10;
constexpr double kTwoSided90 = 1.6449;
constexpr std::size_t kMostMarkers = 40;
constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
constexpr Colour kRejectedColour{0.84, 0.37, 0.0, 1.0}, kBandColour{0.0, 0.62, 0.45, 0.25},
    kFilledColour{0.0, 0.5, 0.36, 1.0}, kMeasuredColour{0.25, 0.25, 0.3, 1.0};

double coordinate(Position p, int axis) noexcept { return double{axis == 0 ? p.x : axis == 1 ? p.y : p.z}; }

std::size_t index_of(const MarkerSet& set, const std::string& name) {
  const auto found = std::ranges::find(set.names, name);
  if (found != set.names.end()) return static_cast<std::size_t>(found - set.names.begin());
  std::string names;
  for (const std::string& known : set.names) names += (names.empty() ? "" : ", ") + known;
  throw UserError(name, "is no marker of this take", "there are: " + names);
}

struct Track {
  std::vector<double> time_s, measured, filled, low, high, rejected;
};

/// The filled line reaches to the measured samples beside it, so that a step shows.
Track track_of(const std::vector<MarkerFrame>& before, const std::vector<MarkerFrame>& after, std::size_t i, int axis) {
  Track track;
  for (std::size_t f = 0; f < after.size(); ++f) {
    const auto elapsed_ns = after[f].header.capture_time_ns - after.front().header.capture_time_ns;
    track.time_s.push_back(static_cast<double>(elapsed_ns) * 1e-9);
    const double value = coordinate(after[f].position_mm[i], axis);
    const bool is_measured = after[f].state[i] == MarkerState::kMeasured;
    const bool is_filled = after[f].state[i] == MarkerState::kFilled;
    const auto filled_at = [&](std::size_t g) { return g < after.size() && after[g].state[i] == MarkerState::kFilled; };
    const bool is_beside = is_measured && (filled_at(f + 1) || (f > 0 && filled_at(f - 1)));
    const double half = kTwoSided90 * double{after[f].standard_deviation_mm[i]};
    track.measured.push_back(is_measured ? value : kMissing);
    track.filled.push_back(is_filled || is_beside ? value : kMissing);
    track.low.push_back(is_filled ? value - half : kMissing);
    track.high.push_back(is_filled ? value + half : kMissing);
    const bool is_rejected = after[f].reason[i] != RejectReason::kNone && before[f].state[i] == MarkerState::kMeasured;
    track.rejected.push_back(is_rejected ? coordinate(before[f].position_mm[i], axis) : kMissing);
  }
  return track;
}

/// A far-off false track must not flatten the rest.
void limit_to_repaired(Plot& plot, const Track& track) {
  double low = 1e30, high = -1e30;
  for (const auto* values : {&track.measured, &track.filled, &track.low, &track.high}) {
    for (const double v : *values) {
      if (v == v) low = std::min(low, v), high = std::max(high, v);
    }
  }
  if (low > high) return;
  const double room = std::max(0.5, 0.15 * (high - low));
  plot.limit_y(low - room, high + room);
}

}  // namespace

Canvas repair_picture(const std::vector<MarkerFrame>& before, const std::vector<MarkerFrame>& after,
                      const MarkerSet& set, const std::vector<std::string>& markers) {
  if (markers.empty() || markers.size() > kMostMarkers) {
    throw UserError("--marker", fmt::format("{} markers", markers.size()), fmt::format("give 1 to {}", kMostMarkers));
  }
  Canvas canvas(static_cast<int>(3 * kPlotWidth + 2 * kMargin),
                static_cast<int>(static_cast<double>(markers.size()) * kPlotHeight + 2 * kMargin));
  constexpr std::array kAxes{"x (left)", "y (up)", "z (front)"};
  for (std::size_t row = 0; row < markers.size(); ++row) {
    const std::size_t i = index_of(set, markers[row]);
    for (int axis = 0; axis < 3; ++axis) {
      const Track track = track_of(before, after, i, axis);
      Plot plot({.title = fmt::format("{} {}", markers[row], kAxes[static_cast<std::size_t>(axis)]),
                 .x = "time, s",
                 .y = "mm"});
      plot.band(track.time_s, track.low, track.high, kBandColour, "filled, 90 %");
      plot.line(track.time_s, track.filled, kFilledColour, "filled", 1.6);
      plot.line(track.time_s, track.measured, kMeasuredColour, "measured", 1.2);
      plot.points(track.time_s, track.rejected, kRejectedColour, "rejected", 2.4);
      limit_to_repaired(plot, track);
      if (axis != 2) plot.without_legend();
      plot.draw(canvas, {kMargin + axis * kPlotWidth, kMargin + static_cast<double>(row) * kPlotHeight, kPlotWidth,
                         kPlotHeight});
    }
  }
  return canvas;
}

}  // namespace risorius
