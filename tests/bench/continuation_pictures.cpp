#include "bench/continuation_pictures.h"

#include <algorithm>

#include "replay/picture/plot.h"
#include "replay/takes/au_column.h"

namespace risorius::bench {
namespace {

constexpr int kWidth = 620, kHeight = 330;
constexpr double kExampleSeconds = 4;
constexpr Colour kTruth{0.15, 0.15, 0.18};

double range_of(const ContinuationTake& take, std::size_t au, std::size_t from, std::size_t to) {
  double low = 2, high = 0;
  for (std::size_t f = from; f < to; ++f) {
    low = std::min(low, take.frames[f].intensity[au]);
    high = std::max(high, take.frames[f].intensity[au]);
  }
  return high - low;
}

Plot example_of(const ContinuationTake& take, const std::vector<Prediction>& predictions, std::size_t au,
                std::size_t from, std::size_t to) {
  Plot plot({.title = take.name + ", " + take.aus[au] + ": predicted every 0.25 s, with 90 % bands",
             .x = "time, s",
             .y = "intensity"});
  const auto seconds = [](std::int64_t ns) { return static_cast<double>(ns) * 1e-9; };
  std::vector<double> x, y;
  for (std::size_t f = from; f < to; ++f) {
    x.push_back(seconds(take.frames[f].header.capture_time_ns));
    y.push_back(take.frames[f].intensity[au]);
  }
  plot.line(x, y, kTruth, "came", 2.2);
  double next_s = x.front();
  bool is_first = true;
  for (const Prediction& prediction : predictions) {
    const double at_s = seconds(take.frames[prediction.frame].header.capture_time_ns);
    if (prediction.frame < from || prediction.frame >= to || at_s < next_s) continue;
    next_s = at_s + 0.25;
    std::vector<double> px{at_s}, py{take.frames[prediction.frame].intensity[au]}, low{py}, high{py};
    const Continuation& c = prediction.continuation;
    for (std::size_t step = 0; step < c.step_count; ++step) {
      px.push_back(at_s + seconds(c.ahead_ns[step]));
      py.push_back(c.intensity[step][au]);
      low.push_back(py.back() - 1.645 * static_cast<double>(c.standard_deviation[step][au]));
      high.push_back(py.back() + 1.645 * static_cast<double>(c.standard_deviation[step][au]));
    }
    plot.band(px, low, high, plot_colour(0));
    plot.line(px, py, plot_colour(1), is_first ? "predicted" : "");
    is_first = false;
  }
  plot.limit_x(x.front(), x.back());
  plot.limit_y(-0.1, 1.1);
  return plot;
}

}  // namespace

void draw_continuation(const std::vector<HorizonPanel>& panels, const ContinuationTake& example,
                       const std::vector<Prediction>& predictions, const std::filesystem::path& path) {
  const auto rows = static_cast<int>((panels.size() + 1) / 2) + 1;
  Canvas canvas(2 * kWidth, rows * kHeight);
  for (std::size_t i = 0; i < panels.size(); ++i) {
    Plot plot({.title = panels[i].title, .x = "ahead, ms", .y = "mean absolute error"});
    double most = 0;
    for (const HorizonCurve& curve : panels[i].curves)
      most = std::max(most, *std::max_element(curve.mae.begin(), curve.mae.end()));
    plot.limit_y(0, 1.5 * most);  // room for the legend
    for (std::size_t m = 0; m < panels[i].curves.size(); ++m)
      plot.line(panels[i].horizons_ms, panels[i].curves[m].mae, plot_colour(m), panels[i].curves[m].model);
    plot.draw(canvas, {static_cast<double>(i % 2) * kWidth, static_cast<double>(i / 2) * kHeight, kWidth, kHeight});
  }
  const auto from = example.frames.size() / 3;
  const auto to = std::min(example.frames.size(), from + static_cast<std::size_t>(kExampleSeconds * example.rate_hz));
  std::vector<std::size_t> order = example.moving;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return range_of(example, a, from, to) > range_of(example, b, from, to);
  });
  // Another AU, not the other side of the first.
  const auto action = [&](std::size_t au) { return parse_au_column(example.aus[au]).number; };
  const auto other =
      std::find_if(order.begin(), order.end(), [&](std::size_t au) { return action(au) != action(order.front()); });
  if (other != order.end()) std::swap(order[std::min<std::size_t>(1, order.size() - 1)], *other);
  for (std::size_t i = 0; i < std::min<std::size_t>(2, order.size()); ++i) {
    example_of(example, predictions, order[i], from, to)
        .draw(canvas, {static_cast<double>(i) * kWidth, (rows - 1.0) * kHeight, kWidth, kHeight});
  }
  canvas.save_png(path);
}

}  // namespace risorius::bench
