#include "replay/picture/plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <stdexcept>

namespace risorius {
namespace {

constexpr Colour kInk{0.15, 0.15, 0.18};
constexpr Colour kGrid{0.88, 0.89, 0.91};
constexpr double kTitleSize = 15, kLabelSize = 12, kTickSize = 11;
constexpr double kPadding = 8;
constexpr double kLegendRow = 17, kLegendSample = 22;
constexpr double kMostHeadroom = 0.45;     // of a plot's height, for its legend
constexpr double kMostStackedShare = 0.3;  // of a plot's height; a higher legend lies down
constexpr int kLeastTicks = 2;

Colour faded(Colour colour, double alpha) {
  colour.alpha *= alpha;
  return colour;
}

/// The fewest decimals that tell ticks of this step apart.
std::string tick_text(double value, double step) {
  if (value != 0 && (std::abs(value) >= 1e5 || step < 1e-4)) return fmt::format("{:.3g}", value);
  const int decimals = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
  return fmt::format("{:.{}f}", value == 0 ? 0.0 : value, decimals);
}

std::vector<double> log_ticks(double low, double high) {
  std::vector<double> ticks;
  for (double decade = std::pow(10, std::floor(std::log10(low))); decade <= high * 1.0001; decade *= 10) {
    for (const double factor : {1.0, 2.0, 5.0}) {
      const double tick = factor * decade;
      if (tick >= low * 0.9999 && tick <= high * 1.0001) ticks.push_back(tick);
    }
  }
  return ticks;
}

}  // namespace

Colour plot_colour(std::size_t index) noexcept {
  constexpr std::array<Colour, 7> kColours{{{0.00, 0.35, 0.70},
                                            {0.84, 0.37, 0.00},
                                            {0.00, 0.60, 0.45},
                                            {0.80, 0.47, 0.65},
                                            {0.90, 0.62, 0.00},
                                            {0.34, 0.70, 0.91},
                                            {0.35, 0.35, 0.38}}};
  return kColours[index % kColours.size()];
}

std::vector<double> round_ticks(double low, double high, int most) {
  if (!(high > low) || most < 2) return {low};
  const double raw = (high - low) / (most - 1);
  const double decade = std::pow(10, std::floor(std::log10(raw)));
  double step = 10 * decade;
  for (const double factor : {5.0, 2.0, 1.0}) {
    if (factor * decade >= raw * 0.999) step = factor * decade;
  }
  std::vector<double> ticks;
  for (double n = std::ceil(low / step - 1e-9); n * step <= high + 1e-9 * step; ++n) ticks.push_back(n * step);
  return ticks;
}

/// Where the data is drawn, and how values become pixels.
struct Plot::Frame {
  PictureRectangle box;
  double x_low, x_high, y_low, y_high;
  bool is_log_x;
  std::vector<double> x_ticks, y_ticks;

  double x(double value) const {
    if (is_log_x && !(value > 0)) return std::numeric_limits<double>::quiet_NaN();
    const double share =
        is_log_x ? std::log(value / x_low) / std::log(x_high / x_low) : (value - x_low) / (x_high - x_low);
    return box.x + share * box.width;
  }
  double y(double value) const { return box.y + box.height * (1 - (value - y_low) / (y_high - y_low)); }
  PicturePoint at(double vx, double vy) const { return {x(vx), y(vy)}; }
};

Plot::Plot(PlotLabels labels) : labels_(std::move(labels)) {}

void Plot::line(std::span<const double> x, std::span<const double> y, Colour colour, std::string label, double width) {
  if (x.size() != y.size()) throw std::invalid_argument("Plot::line: x and y are of unequal length");
  series_.push_back({Kind::kLine, {x.begin(), x.end()}, {}, {y.begin(), y.end()}, colour, std::move(label), width});
}

void Plot::points(std::span<const double> x, std::span<const double> y, Colour colour, std::string label,
                  double radius) {
  if (x.size() != y.size()) throw std::invalid_argument("Plot::points: x and y are of unequal length");
  series_.push_back({Kind::kPoints, {x.begin(), x.end()}, {}, {y.begin(), y.end()}, colour, std::move(label), radius});
}

void Plot::band(std::span<const double> x, std::span<const double> low, std::span<const double> high, Colour colour,
                std::string label) {
  if (x.size() != low.size() || x.size() != high.size())
    throw std::invalid_argument("Plot::band: x, low and high are of unequal length");
  series_.push_back({Kind::kBand,
                     {x.begin(), x.end()},
                     {low.begin(), low.end()},
                     {high.begin(), high.end()},
                     colour,
                     std::move(label)});
}

void Plot::ecdf(std::span<const double> values, Colour colour, std::string label) {
  std::vector<double> sorted;
  std::copy_if(values.begin(), values.end(), std::back_inserter(sorted), [](double v) { return std::isfinite(v); });
  std::sort(sorted.begin(), sorted.end());
  std::vector<double> x, y;
  const auto count = static_cast<double>(sorted.size());
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    x.insert(x.end(), 2, sorted[i]);
    y.push_back(static_cast<double>(i) / count);
    y.push_back(static_cast<double>(i + 1) / count);
  }
  line(x, y, colour, std::move(label), 2);
}

void Plot::histogram(std::span<const double> values, double low, double high, int bins, Colour colour,
                     std::string label) {
  if (!(high > low) || bins < 1) throw std::invalid_argument("Plot::histogram: no range or no bins");
  Series series{Kind::kBars, {}, {}, {}, colour, std::move(label)};
  const double width = (high - low) / bins;
  for (int i = 0; i <= bins; ++i) series.x.push_back(low + i * width);
  series.high.assign(static_cast<std::size_t>(bins), 0);
  for (const double value : values) {
    if (value >= low && value <= high)
      ++series.high[std::min(static_cast<std::size_t>((value - low) / width), series.high.size() - 1)];
  }
  series_.push_back(std::move(series));
}

void Plot::span_x(double from, double to, Colour colour) { marks_.push_back({from, to, true, colour}); }
void Plot::mark_x(double x, Colour colour) { marks_.push_back({x, x, true, colour}); }
void Plot::mark_y(double y, Colour colour) { marks_.push_back({y, y, false, colour}); }
void Plot::limit_x(double low, double high) {
  x_low_ = low;
  x_high_ = high;
}
void Plot::limit_y(double low, double high) {
  y_low_ = low;
  y_high_ = high;
}

Plot::Frame Plot::frame_of(const Canvas& canvas, const PictureRectangle& where, double headroom) const {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  double x_low = kFar, x_high = -kFar, y_low = kFar, y_high = -kFar;
  const auto widen = [](double value, double& low, double& high) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  };
  for (const Series& series : series_) {
    for (const double x : series.x) {
      if (!is_log_x_ || x > 0) widen(x, x_low, x_high);
    }
    for (const double y : series.high) widen(y, y_low, y_high);
    for (const double y : series.low) widen(y, y_low, y_high);
    if (series.kind == Kind::kBars) widen(0, y_low, y_high);
  }
  if (!(x_high >= x_low)) x_low = is_log_x_ ? 0.1 : 0, x_high = 1;
  if (!(y_high >= y_low)) y_low = 0, y_high = 1;
  if (x_high == x_low) x_high = x_low + (is_log_x_ ? x_low : 1);
  if (y_high == y_low) y_high = y_low + 1;
  const double room = 0.04 * (y_high - y_low);
  const bool from_zero = y_low >= 0 && y_low < 0.25 * y_high;
  Frame frame{{},
              x_low_.value_or(x_low),
              x_high_.value_or(x_high),
              y_low_.value_or(from_zero ? 0 : y_low - room),
              y_high_.value_or(y_high + room),
              is_log_x_,
              {},
              {}};
  frame.y_high += headroom / (1 - headroom) * (frame.y_high - frame.y_low);
  const double top = where.y + kPadding + (labels_.title.empty() ? 0 : kTitleSize + kPadding);
  const double bottom = where.y + where.height - kPadding - kTickSize - 6 - (labels_.x.empty() ? 0 : kLabelSize + 8);
  int ticks = std::max(kLeastTicks, static_cast<int>((bottom - top) / 38));
  do {
    frame.y_ticks = round_ticks(frame.y_low, frame.y_high, ticks++);
  } while (frame.y_ticks.size() < kLeastTicks && ticks < 4 * kLeastTicks);
  double widest = 0;
  const double step = frame.y_ticks.size() > 1 ? frame.y_ticks[1] - frame.y_ticks[0] : 1;
  for (const double tick : frame.y_ticks)
    widest = std::max(widest, canvas.text_width(tick_text(tick, step), kTickSize));
  const double left = where.x + kPadding + (labels_.y.empty() ? 0 : kLabelSize + 8) + widest + 8;
  const double right = where.x + where.width - 2 * kPadding;
  frame.box = {left, top, std::max(1.0, right - left), std::max(1.0, bottom - top)};
  frame.x_ticks = is_log_x_
                      ? log_ticks(frame.x_low, frame.x_high)
                      : round_ticks(frame.x_low, frame.x_high, std::max(2, static_cast<int>(frame.box.width / 70)));
  return frame;
}

void Plot::draw_axes(Canvas& canvas, const Frame& frame) const {
  const PictureRectangle& box = frame.box;
  const double bottom = box.y + box.height, right = box.x + box.width;
  const double x_step = frame.x_ticks.size() > 1 ? frame.x_ticks[1] - frame.x_ticks[0] : 1;
  const double y_step = frame.y_ticks.size() > 1 ? frame.y_ticks[1] - frame.y_ticks[0] : 1;
  for (const double tick : frame.x_ticks) {
    const double x = frame.x(tick);
    canvas.line({x, box.y}, {x, bottom}, kGrid);
    const std::string text = frame.is_log_x ? fmt::format("{:g}", tick) : tick_text(tick, x_step);
    canvas.text({x, bottom + kTickSize + 5}, text, kTickSize, kInk, TextAnchor::kCentre);
  }
  for (const double tick : frame.y_ticks) {
    const double y = frame.y(tick);
    canvas.line({box.x, y}, {right, y}, kGrid);
    canvas.text({box.x - 6, y + 0.36 * kTickSize}, tick_text(tick, y_step), kTickSize, kInk, TextAnchor::kRight);
  }
  canvas.line({box.x, bottom}, {right, bottom}, kInk);
  canvas.line({box.x, box.y}, {box.x, bottom}, kInk);
  canvas.text({box.x + 0.5 * box.width, bottom + kTickSize + kLabelSize + 12}, labels_.x, kLabelSize, kInk,
              TextAnchor::kCentre);
  const double widest = [&] {
    double width = 0;
    for (const double tick : frame.y_ticks)
      width = std::max(width, canvas.text_width(tick_text(tick, y_step), kTickSize));
    return width;
  }();
  canvas.text({box.x - widest - 14, box.y + 0.5 * box.height}, labels_.y, kLabelSize, kInk, TextAnchor::kCentre, true);
  canvas.text({box.x, box.y - kPadding}, labels_.title, kTitleSize, kInk);
}

void Plot::draw_series(Canvas& canvas, const Frame& frame, const Series& series) const {
  std::vector<PicturePoint> path;
  switch (series.kind) {
    case Kind::kLine:
      for (std::size_t i = 0; i < series.x.size(); ++i) path.push_back(frame.at(series.x[i], series.high[i]));
      canvas.polyline(path, series.colour, series.width);
      return;
    case Kind::kPoints:
      for (std::size_t i = 0; i < series.x.size(); ++i)
        canvas.fill_circle(frame.at(series.x[i], series.high[i]), series.width, series.colour);
      return;
    case Kind::kBand:
      for (std::size_t i = 0; i + 1 < series.x.size(); ++i) {
        // Piece by piece, so that a gap stays a gap; overlapping by nothing, so that the shade stays even.
        const std::array<PicturePoint, 4> piece{
            frame.at(series.x[i], series.low[i]), frame.at(series.x[i + 1], series.low[i + 1]),
            frame.at(series.x[i + 1], series.high[i + 1]), frame.at(series.x[i], series.high[i])};
        canvas.fill_polygon(piece, faded(series.colour, 0.25));
      }
      return;
    case Kind::kBars:
      for (std::size_t i = 0; i < series.high.size(); ++i) {
        const PicturePoint a = frame.at(series.x[i], series.high[i]), b = frame.at(series.x[i + 1], 0);
        canvas.fill_rectangle({a.x, a.y, b.x - a.x - 1, b.y - a.y}, faded(series.colour, 0.55));
      }
      return;
  }
}

/// How long the way from a to b is within a rectangle, in pixels (Liang & Barsky 1984).
double length_within(const PictureRectangle& r, const PicturePoint& a, const PicturePoint& b) {
  const double dx = b.x - a.x, dy = b.y - a.y;
  double from = 0, to = 1;
  const auto cut = [&](double step, double room_low, double room_high) {  // room_low <= t step <= room_high
    if (step == 0) return room_low <= 0 && room_high >= 0;
    const double first = std::min(room_low / step, room_high / step),
                 last = std::max(room_low / step, room_high / step);
    from = std::max(from, first);
    to = std::min(to, last);
    return from < to;
  };
  if (!cut(dx, r.x - a.x, r.x + r.width - a.x) || !cut(dy, r.y - a.y, r.y + r.height - a.y)) return 0;
  return (to - from) * std::hypot(dx, dy);
}

/// Pixels of lines and edges of bands, and points, that a rectangle would hide.
double Plot::hidden_by(const PictureRectangle& r, const Frame& frame) const {
  double hidden = 0;
  for (const Series& series : series_) {
    const bool joined = series.kind == Kind::kLine || series.kind == Kind::kBand;
    for (const std::vector<double>* y : {&series.high, &series.low}) {
      for (std::size_t i = 0; i < y->size(); ++i) {
        const PicturePoint p = frame.at(series.x[i], (*y)[i]);
        if (joined && i + 1 < y->size()) hidden += length_within(r, p, frame.at(series.x[i + 1], (*y)[i + 1]));
        hidden += p.x >= r.x && p.x <= r.x + r.width && p.y >= r.y && p.y <= r.y + r.height;
      }
    }
  }
  return hidden;
}

/// In the corner that hides least.
Plot::Legend Plot::place_legend(const Canvas& canvas, const Frame& frame) const {
  Legend legend;
  double widest = 0, together = 0;
  for (const Series& series : series_) {
    if (series.label.empty()) continue;
    legend.entries.push_back(&series);
    const double width = canvas.text_width(series.label, kTickSize) + kLegendSample + 18;
    widest = std::max(widest, width);
    together += width;
  }
  if (legend.entries.empty() || !has_legend_) return {};
  const PictureRectangle& box = frame.box;
  const double stacked = kLegendRow * static_cast<double>(legend.entries.size());
  legend.is_row = stacked > kMostStackedShare * box.height && together < box.width - 12;
  PictureRectangle where{0, 0, legend.is_row ? together : widest, (legend.is_row ? kLegendRow : stacked) + 8};
  legend.hidden = std::numeric_limits<double>::infinity();
  for (const double share_y : {0.0, 1.0}) {
    for (const double share_x : {1.0, 0.0}) {
      where.x = box.x + 6 + share_x * (box.width - where.width - 12);
      where.y = box.y + 6 + share_y * (box.height - where.height - 12);
      const double hidden = hidden_by(where, frame);
      if (hidden >= legend.hidden) continue;
      legend.hidden = hidden;
      legend.where = where;
    }
  }
  return legend;
}

void Plot::draw_legend(Canvas& canvas, const Legend& legend) const {
  if (legend.entries.empty()) return;
  canvas.fill_rectangle(legend.where, {1, 1, 1, 0.85});
  double left = legend.where.x + 6, y = legend.where.y + 4;
  for (const Series* series : legend.entries) {
    const double middle = y + 0.5 * kLegendRow;
    if (series->kind == Kind::kBand || series->kind == Kind::kBars) {
      canvas.fill_rectangle({left, middle - 5, kLegendSample, 10}, faded(series->colour, 0.4));
    } else if (series->kind == Kind::kPoints) {
      canvas.fill_circle({left + 0.5 * kLegendSample, middle}, 3, series->colour);
    } else {
      canvas.line({left, middle}, {left + kLegendSample, middle}, series->colour, 2.2);
    }
    canvas.text({left + 6 + kLegendSample, middle + 0.36 * kTickSize}, series->label, kTickSize, kInk);
    if (legend.is_row) {
      left += canvas.text_width(series->label, kTickSize) + kLegendSample + 18;
    } else {
      y += kLegendRow;
    }
  }
}

void Plot::draw(Canvas& canvas, const PictureRectangle& where) const {
  Frame frame = frame_of(canvas, where, 0);
  Legend legend = place_legend(canvas, frame);
  if (legend.hidden > 0 && !y_high_) {  // no corner is free: the axis goes on above the data
    frame = frame_of(canvas, where, std::min(kMostHeadroom, (legend.where.height + 12) / frame.box.height));
    legend = place_legend(canvas, frame);
  }
  draw_axes(canvas, frame);
  canvas.begin_clip({frame.box.x, frame.box.y - 2, frame.box.width + 2, frame.box.height + 4});
  for (const Mark& mark : marks_) {
    if (mark.is_x && mark.from != mark.to) {
      const double from = frame.x(mark.from), to = frame.x(mark.to);
      canvas.fill_rectangle({from, frame.box.y, to - from, frame.box.height}, faded(mark.colour, 0.18));
    } else if (mark.is_x) {
      const double x = frame.x(mark.from);
      canvas.line({x, frame.box.y}, {x, frame.box.y + frame.box.height}, mark.colour, 1.2);
    } else {
      const double y = frame.y(mark.from);
      canvas.line({frame.box.x, y}, {frame.box.x + frame.box.width, y}, mark.colour, 1.2);
    }
  }
  for (const Series& series : series_) draw_series(canvas, frame, series);
  canvas.end_clip();
  draw_legend(canvas, legend);
}

}  // namespace risorius
