// A picture being drawn: pixels from the top left, anti-aliased lines, text and images; saved as PNG. Colours are sRGB,
// 0 to 1. Everything that Risorius draws (plots, faces, contact sheets) goes through this one class; it is the only
// user of Cairo.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>

namespace risorius {

struct Colour {
  double red = 0.0;
  double green = 0.0;
  double blue = 0.0;
  double alpha = 1.0;
};

struct PicturePoint {
  double x = 0.0;  ///< pixels, to the right
  double y = 0.0;  ///< pixels, downwards
};

struct PictureRectangle {
  double x = 0.0;
  double y = 0.0;
  double width = 0.0;
  double height = 0.0;
};

enum class TextAnchor { kLeft, kCentre, kRight };

class Canvas {
 public:
  /// width and height in pixels, 1 to 16384. Throws UserError with the size if it is not.
  Canvas(int width, int height, Colour background = {1.0, 1.0, 1.0, 1.0});
  ~Canvas();
  Canvas(Canvas&&) noexcept;
  Canvas& operator=(Canvas&&) noexcept;

  int width() const noexcept;
  int height() const noexcept;

  void fill_rectangle(const PictureRectangle& rectangle, Colour colour);
  void fill_polygon(std::span<const PicturePoint> points, Colour colour);
  void fill_circle(PicturePoint centre, double radius, Colour colour);
  void line(PicturePoint from, PicturePoint to, Colour colour, double width = 1.0);
  /// Breaks at points that are not finite, so a gap in a track is a gap in its line.
  void polyline(std::span<const PicturePoint> points, Colour colour, double width = 1.0);
  /// A line with a head whose size follows the line's width; shorter than the head, it is a dot.
  void arrow(PicturePoint from, PicturePoint to, Colour colour, double width = 1.0);
  /// One line of UTF-8; `at` is on the baseline. `turned` runs upwards (the label of a vertical axis).
  void text(PicturePoint at, std::string_view utf8, double size = 12.0, Colour colour = {},
            TextAnchor anchor = TextAnchor::kLeft, bool turned = false);
  double text_width(std::string_view utf8, double size) const;
  /// Draws inside `rectangle` only, until end_clip.
  void begin_clip(const PictureRectangle& rectangle);
  void end_clip();
  /// Copies pixels (0xAARRGGBB with alpha premultiplied, rows from the top, width * rows of them) to `at`.
  void image(PicturePoint at, std::span<const std::uint32_t> pixels, int width);

  /// Throws UserError naming the file and what the system says; nothing half-written stays under the name.
  void save_png(const std::filesystem::path& path) const;
  std::uint32_t pixel(int x, int y) const;  ///< 0xAARRGGBB; for tests

 private:
  struct Surface;
  std::unique_ptr<Surface> surface_;
};

}  // namespace risorius
