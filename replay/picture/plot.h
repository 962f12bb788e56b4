// Plots on a canvas: axes with round ticks, lines, bands, points, histograms, empirical distributions, spans, and a
// legend that finds its corner. A Plot is filled first and drawn last, so that it knows its ranges. Values in the axes'
// own units; what is not finite is a gap.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "replay/picture/canvas.h"

namespace risorius {

/// Colours that stay apart for most kinds of colour vision (after Okabe & Ito 2008); 0 is blue, 1 vermilion, ...
Colour plot_colour(std::size_t index) noexcept;

/// Round values that cover low to high, at most `most` of them, steps of 1, 2 or 5 times a power of ten.
std::vector<double> round_ticks(double low, double high, int most);

struct PlotLabels {
  std::string title, x, y;  ///< axes with their units, such as "time, s"
};

class Plot {
 public:
  explicit Plot(PlotLabels labels = {});

  /// As many x as y. An empty label stays out of the legend. Throws std::invalid_argument otherwise.
  void line(std::span<const double> x, std::span<const double> y, Colour colour, std::string label = {},
            double width = 1.6);
  void points(std::span<const double> x, std::span<const double> y, Colour colour, std::string label = {},
              double radius = 2);
  /// Between two curves.
  void band(std::span<const double> x, std::span<const double> low, std::span<const double> high, Colour colour,
            std::string label = {});
  /// Share of the values up to each value.
  void ecdf(std::span<const double> values, Colour colour, std::string label = {});
  /// Counts in equal bins between the limits.
  void histogram(std::span<const double> values, double low, double high, int bins, Colour colour,
                 std::string label = {});
  /// A stretch of x, shaded over the whole height.
  void span_x(double from, double to, Colour colour);
  /// A straight line across the plot.
  void mark_x(double x, Colour colour);
  void mark_y(double y, Colour colour);

  /// Instead of the data's own range.
  void limit_x(double low, double high);
  void limit_y(double low, double high);
  /// Draws x on a logarithmic axis; what is not above 0 is left out.
  void logarithmic_x() { is_log_x_ = true; }
  void without_legend() { has_legend_ = false; }

  void draw(Canvas& canvas, const PictureRectangle& where) const;

 private:
  enum class Kind { kLine, kPoints, kBand, kBars };
  struct Series {
    Kind kind;
    std::vector<double> x, low, high;  ///< `high` alone for lines and points
    Colour colour;
    std::string label;
    double width = 1;
  };
  struct Mark {
    double from, to;
    bool is_x;
    Colour colour;
  };
  struct Frame;
  struct Legend {
    PictureRectangle where;
    std::vector<const Series*> entries;
    bool is_row = false;  ///< side by side; else one below the other
    double hidden = 0;    ///< how much of the data is behind it, in pixels
  };
  /// `headroom`: share of the height to be left free above the data.
  Frame frame_of(const Canvas& canvas, const PictureRectangle& where, double headroom) const;
  void draw_axes(Canvas& canvas, const Frame& frame) const;
  void draw_series(Canvas& canvas, const Frame& frame, const Series& series) const;
  double hidden_by(const PictureRectangle& r, const Frame& frame) const;
  Legend place_legend(const Canvas& canvas, const Frame& frame) const;
  void draw_legend(Canvas& canvas, const Legend& legend) const;

  PlotLabels labels_;
  std::vector<Series> series_;
  std::vector<Mark> marks_;
  std::optional<double> x_low_, x_high_, y_low_, y_high_;
  bool is_log_x_ = false, has_legend_ = true;
};

}  // namespace risorius
