#include "replay/picture/plot.h"

#include <cmath>
#include <gtest/gtest.h>
#include <stdexcept>

namespace {

using namespace risorius;

constexpr std::uint32_t kWhite = 0xffffffffu;
constexpr Colour kRed{1, 0, 0};

/// How many pixels of a row or a region are of this very colour.
int count_of(const Canvas& canvas, std::uint32_t colour, const PictureRectangle& where) {
  int count = 0;
  for (int y = static_cast<int>(where.y); y < where.y + where.height; ++y)
    for (int x = static_cast<int>(where.x); x < where.x + where.width; ++x) count += canvas.pixel(x, y) == colour;
  return count;
}

TEST(Plot, TicksAreRoundAndInside) {
  EXPECT_EQ(round_ticks(0, 1, 6), (std::vector<double>{0, 0.2, 0.4, 0.6000000000000001, 0.8, 1}));
  EXPECT_EQ(round_ticks(-30, 130, 5), (std::vector<double>{0, 50, 100}));
  for (const double scale : {1e-6, 0.37, 5.0, 1234.5}) {
    const auto ticks = round_ticks(-0.3 * scale, scale, 7);
    EXPECT_GE(ticks.size(), 3u);
    EXPECT_LE(ticks.size(), 7u);
    EXPECT_GE(ticks.front(), -0.3 * scale - 1e-12);
    EXPECT_LE(ticks.back(), scale * (1 + 1e-12));
  }
  EXPECT_EQ(round_ticks(2, 2, 5), std::vector<double>{2});
}

TEST(Plot, DrawsInsideItsPlaceAndHigherValuesHigher) {
  const std::vector<double> x{0, 1, 2}, low{0, 0, 0}, high{1, 1, 1};
  for (const bool up : {false, true}) {
    Canvas canvas(400, 300);
    Plot plot({"", "time, s", ""});
    plot.limit_y(0, 1);
    plot.line(x, up ? high : low, kRed, "", 4);
    plot.draw(canvas, {100, 50, 250, 200});
    EXPECT_EQ(count_of(canvas, 0xffff0000u, {0, 0, 100, 300}), 0);
    EXPECT_EQ(count_of(canvas, 0xffff0000u, {0, 0, 400, 50}), 0);
    EXPECT_GT(
        count_of(canvas, 0xffff0000u, up ? PictureRectangle{100, 50, 250, 30} : PictureRectangle{100, 180, 250, 60}),
        100);
  }
}

TEST(Plot, AGapInTheValuesIsAGapInTheLine) {
  Canvas canvas(400, 200);
  Plot plot;
  std::vector<double> x, y;
  for (int i = 0; i <= 100; ++i) {
    x.push_back(i);
    y.push_back(i > 40 && i < 60 ? NAN : 0.5);
  }
  plot.limit_y(0, 1);
  plot.line(x, y, kRed, "", 4);
  plot.draw(canvas, {0, 0, 400, 200});
  int left = 0, middle = 0, right = 0;
  for (int column = 60; column < 380; ++column) {
    const bool red = count_of(canvas, 0xffff0000u, {static_cast<double>(column), 0, 1, 199}) > 0;
    (column < 170 ? left : column > 270 ? right : middle) += red;
  }
  EXPECT_GT(left, 80);
  EXPECT_GT(right, 80);
  EXPECT_LT(middle, 60);
}

TEST(Plot, TheLegendHidesNoLine) {
  // Two points each, whose joining lines pass through all four corners.
  const std::vector<double> x{0, 1}, up{0, 1}, down{1, 0};
  Canvas canvas(400, 300);
  Plot plot;
  plot.line(x, up, kRed, "", 3);
  plot.line(x, down, kRed, "", 3);
  plot.line({}, {}, {0, 0, 1}, "a label of some length");
  plot.draw(canvas, {0, 0, 400, 300});
  for (int column = 45; column < 375; ++column) {
    const auto at = static_cast<double>(column);
    int runs = 0;  // each column has both lines, or the place where they cross
    for (int y = 1; y < 280; ++y) {
      runs += canvas.pixel(column, y) == 0xffff0000u && canvas.pixel(column, y - 1) != 0xffff0000u;
    }
    EXPECT_GE(runs, std::abs(at - 210) < 25 ? 1 : 2) << "column " << column;
  }
}

TEST(Plot, EmptyPlotsAndOddValuesAreDrawnToo) {
  Canvas canvas(300, 200);
  Plot{}.draw(canvas, {0, 0, 300, 200});
  Plot plot({"title", "x", "y"});
  const std::vector<double> nothing{}, odd{NAN, INFINITY, 3, 3};
  plot.line(nothing, nothing, kRed, "nothing");
  plot.ecdf(odd, kRed, "odd");
  plot.logarithmic_x();
  plot.histogram(odd, 0, 5, 5, kRed, "bars");
  plot.band(odd, odd, odd, kRed, "band");
  plot.mark_x(2, kRed);
  plot.span_x(1, 2, kRed);
  plot.mark_y(0.5, kRed);
  plot.draw(canvas, {0, 0, 300, 200});
  EXPECT_LT(count_of(canvas, kWhite, {0, 0, 300, 200}), 60000);
  EXPECT_THROW(plot.line(odd, nothing, kRed), std::invalid_argument);
  EXPECT_THROW(plot.histogram(odd, 1, 1, 5, kRed), std::invalid_argument);
}

}  // namespace
