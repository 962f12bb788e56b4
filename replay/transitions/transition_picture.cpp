#include "replay/transitions/transition_picture.h"

#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "replay/picture/plot.h"

namespace risorius {
namespace {

using Eigen::Index;

constexpr int kPanelWidth = 560, kPanelHeight = 240, kTitle = 34, kLegendRow = 20;
constexpr double kTextSize = 12, kSample = 22, kMargin = 12;
constexpr Colour kInk{0.15, 0.15, 0.18}, kStart{0.5, 0.5, 0.55, 0.6};

/// AUs in order of their range over all courses, the largest first.
std::vector<Index> by_range(const AuMatrix& past, const std::vector<TransitionCourse>& courses) {
  std::vector<Index> order(static_cast<std::size_t>(past.cols()));
  std::iota(order.begin(), order.end(), 0);
  std::vector<float> range(order.size(), 0);
  for (const Index au : order) {
    float low = past(past.rows() - 1, au), high = low;
    for (const TransitionCourse& course : courses) {
      low = std::min(low, course.rows.col(au).minCoeff());
      high = std::max(high, course.rows.col(au).maxCoeff());
    }
    range[static_cast<std::size_t>(au)] = high - low;
  }
  std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) {
    return range[static_cast<std::size_t>(a)] > range[static_cast<std::size_t>(b)];
  });
  return order;
}

Colour colour_of(const std::vector<TransitionCourse>& courses, std::size_t c) {
  return courses[c].is_reference ? kInk : plot_colour(c);
}

/// Where each label begins, as many to a row as `width` takes. Beside the panels, a legend hides no course.
std::vector<PicturePoint> legend_places(const std::vector<TransitionCourse>& courses, int width) {
  const Canvas measure(1, 1);
  std::vector<PicturePoint> places;
  PicturePoint at{kMargin, kTitle};
  for (const TransitionCourse& course : courses) {
    const double length = kSample + 6 + measure.text_width(course.label, kTextSize) + 2 * kMargin;
    if (at.x > kMargin && at.x + length > width) at = {kMargin, at.y + kLegendRow};
    places.push_back(at);
    at.x += length;
  }
  return places;
}

void draw_legend(Canvas& canvas, const std::vector<TransitionCourse>& courses,
                 const std::vector<PicturePoint>& places) {
  for (std::size_t c = 0; c < courses.size(); ++c) {
    const double middle = places[c].y + 0.5 * kLegendRow;
    canvas.line({places[c].x, middle}, {places[c].x + kSample, middle}, colour_of(courses, c),
                courses[c].is_reference ? 3 : 2.2);
    canvas.text({places[c].x + kSample + 6, middle + 0.36 * kTextSize}, courses[c].label, kTextSize, kInk);
  }
}

}  // namespace

Canvas transition_picture(const std::string& title, const std::vector<std::string>& names, const AuMatrix& past,
                          const std::vector<TransitionCourse>& courses, double rate_hz, std::size_t most_panels) {
  const auto aus = static_cast<Index>(names.size());
  const bool fits = past.rows() > 0 && past.cols() == aus && !courses.empty() &&
                    std::all_of(courses.begin(), courses.end(), [&](const TransitionCourse& course) {
                      return course.rows.cols() == aus && course.rows.rows() > 0;
                    });
  if (!fits || most_panels < 1) throw std::invalid_argument("transition_picture: sizes that do not fit");
  std::vector<Index> order = by_range(past, courses);
  order.resize(std::min(order.size(), most_panels));
  const int columns = order.size() > 1 ? 2 : 1;
  const int rows = (static_cast<int>(order.size()) + columns - 1) / columns;
  const std::vector<PicturePoint> places = legend_places(courses, columns * kPanelWidth);
  const int head = static_cast<int>(places.back().y) + kLegendRow;
  Canvas canvas(columns * kPanelWidth, head + rows * kPanelHeight);
  canvas.text({kMargin, 22}, title, 15, kInk);
  draw_legend(canvas, courses, places);
  for (std::size_t panel = 0; panel < order.size(); ++panel) {
    const Index au = order[panel];
    Plot plot({.title = names[static_cast<std::size_t>(au)], .x = "time, s", .y = "intensity"});
    plot.limit_y(-0.02, 1.22);
    plot.mark_x(0, kStart);
    for (std::size_t c = 0; c < courses.size(); ++c) {
      std::vector<double> x, y;
      for (Index row = 0; row < past.rows(); ++row) {
        x.push_back(static_cast<double>(row - past.rows() + 1) / rate_hz);
        y.push_back(past(row, au));
      }
      for (Index row = 0; row < courses[c].rows.rows(); ++row) {
        x.push_back(static_cast<double>(row + 1) / rate_hz);
        y.push_back(courses[c].rows(row, au));
      }
      plot.line(x, y, colour_of(courses, c), {}, courses[c].is_reference ? 3 : 1.6);
    }
    const auto place = static_cast<int>(panel);
    plot.draw(canvas, {static_cast<double>(place % columns * kPanelWidth),
                       static_cast<double>(head + place / columns * kPanelHeight), kPanelWidth, kPanelHeight});
  }
  return canvas;
}

}  // namespace risorius
