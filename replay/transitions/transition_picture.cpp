#include "replay/transitions/transition_picture.h"

#include <algorithm>
#include <fmt/format.h>
#include <numeric>
#include <stdexcept>
#include <tuple>

#include "generate/au_kind.h"
#include "replay/picture/plot.h"

namespace risorius {
namespace {

using Eigen::Index;

constexpr int kPanelWidth = 560, kPanelHeight = 240, kTitle = 34, kLegendRow = 20;
constexpr double kTitleSize = 15, kTextSize = 12, kSample = 22, kMargin = 12;
constexpr Colour kInk{0.15, 0.15, 0.18}, kStart{0.5, 0.5, 0.55, 0.6};

float range_of(Index au, const AuMatrix& past, const std::vector<TransitionCourse>& courses) {
  float low = past(past.rows() - 1, au), high = low;
  for (const TransitionCourse& course : courses) {
    low = std::min(low, course.rows.col(au).minCoeff());
    high = std::max(high, course.rows.col(au).maxCoeff());
  }
  return high - low;
}

/// AUs in order of their range over all courses, the largest first; both sides together, in the order of `names`.
std::vector<Index> by_range(const std::vector<std::string>& names, const AuMatrix& past,
                            const std::vector<TransitionCourse>& courses) {
  const std::vector<std::size_t> others = other_sides(names);
  std::vector<float> range;
  for (std::size_t au = 0; au < names.size(); ++au) {
    range.push_back(std::max(range_of(static_cast<Index>(au), past, courses),
                             range_of(static_cast<Index>(others[au]), past, courses)));
  }
  std::vector<Index> order(names.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](Index au) {
    const auto i = static_cast<std::size_t>(au);
    return std::tuple(-range[i], std::min(i, others[i]), i);
  };
  std::sort(order.begin(), order.end(), [&](Index a, Index b) { return key(a) < key(b); });
  return order;
}

/// So large that it fits.
void draw_title(Canvas& canvas, const std::string& title, double width) {
  const double length = canvas.text_width(title, kTitleSize), room = width - 2 * kMargin;
  canvas.text({kMargin, 22}, title, kTitleSize * std::min(1.0, room / length), kInk);
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
  std::vector<Index> order = by_range(names, past, courses);
  order.resize(std::min(order.size(), most_panels));
  const std::string left_out =
      order.size() < names.size() ? fmt::format("; the {} AUs of {} that move most", order.size(), names.size()) : "";
  const int columns = order.size() > 1 ? 2 : 1;
  const int rows = (static_cast<int>(order.size()) + columns - 1) / columns;
  const std::vector<PicturePoint> places = legend_places(courses, columns * kPanelWidth);
  const int head = static_cast<int>(places.back().y) + kLegendRow;
  Canvas canvas(columns * kPanelWidth, head + rows * kPanelHeight);
  draw_title(canvas, title + left_out, columns * kPanelWidth);
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
