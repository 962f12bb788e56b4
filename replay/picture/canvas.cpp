#include "replay/picture/canvas.h"

#include <algorithm>
#include <cairo.h>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <string>

#include "capture/check.h"
#include "capture/errors.h"
#include "replay/atomic_file.h"

namespace risorius {
namespace {

constexpr int kLargestSide = 16384;

bool is_finite(PicturePoint p) { return std::isfinite(p.x) && std::isfinite(p.y); }

}  // namespace

struct Canvas::Surface {
  cairo_surface_t* pixels = nullptr;
  cairo_t* context = nullptr;

  Surface(int width, int height)
      : pixels(cairo_image_surface_create(CAIRO_FORMAT_ARGB32, width, height)), context(cairo_create(pixels)) {}
  ~Surface() {
    cairo_destroy(context);
    cairo_surface_destroy(pixels);
  }
  Surface(const Surface&) = delete;
  Surface& operator=(const Surface&) = delete;

  void set(Colour colour) const { cairo_set_source_rgba(context, colour.red, colour.green, colour.blue, colour.alpha); }
};

Canvas::Canvas(int width, int height, Colour background) {
  if (width < 1 || height < 1 || width > kLargestSide || height > kLargestSide) {
    throw UserError("picture", fmt::format("{} x {} pixels", width, height),
                    fmt::format("each side 1 to {}", kLargestSide));
  }
  surface_ = std::make_unique<Surface>(width, height);
  if (cairo_status(surface_->context) != CAIRO_STATUS_SUCCESS) {
    throw UserError("picture", cairo_status_to_string(cairo_status(surface_->context)),
                    "a smaller picture needs less memory");
  }
  cairo_set_line_join(surface_->context, CAIRO_LINE_JOIN_ROUND);
  cairo_set_line_cap(surface_->context, CAIRO_LINE_CAP_ROUND);
  cairo_select_font_face(surface_->context, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  fill_rectangle({0.0, 0.0, static_cast<double>(width), static_cast<double>(height)}, background);
}

Canvas::~Canvas() = default;
Canvas::Canvas(Canvas&&) noexcept = default;
Canvas& Canvas::operator=(Canvas&&) noexcept = default;

int Canvas::width() const noexcept { return cairo_image_surface_get_width(surface_->pixels); }
int Canvas::height() const noexcept { return cairo_image_surface_get_height(surface_->pixels); }

void Canvas::fill_rectangle(const PictureRectangle& r, Colour colour) {
  surface_->set(colour);
  cairo_rectangle(surface_->context, r.x, r.y, r.width, r.height);
  cairo_fill(surface_->context);
}

void Canvas::fill_polygon(std::span<const PicturePoint> points, Colour colour) {
  if (!std::all_of(points.begin(), points.end(), is_finite)) return;
  surface_->set(colour);
  cairo_new_path(surface_->context);
  for (const PicturePoint& p : points) cairo_line_to(surface_->context, p.x, p.y);
  cairo_close_path(surface_->context);
  cairo_fill(surface_->context);
}

void Canvas::fill_circle(PicturePoint centre, double radius, Colour colour) {
  if (!is_finite(centre)) return;
  surface_->set(colour);
  cairo_new_path(surface_->context);
  cairo_arc(surface_->context, centre.x, centre.y, radius, 0.0, 2.0 * M_PI);
  cairo_fill(surface_->context);
}

void Canvas::line(PicturePoint from, PicturePoint to, Colour colour, double width) {
  const PicturePoint points[] = {from, to};
  polyline(points, colour, width);
}

void Canvas::polyline(std::span<const PicturePoint> points, Colour colour, double width) {
  surface_->set(colour);
  cairo_set_line_width(surface_->context, width);
  cairo_new_path(surface_->context);
  bool is_down = false;
  for (const PicturePoint& p : points) {
    if (!is_finite(p)) {
      is_down = false;
      continue;
    }
    if (is_down) {
      cairo_line_to(surface_->context, p.x, p.y);
    } else {
      cairo_move_to(surface_->context, p.x, p.y);
    }
    is_down = true;
  }
  cairo_stroke(surface_->context);
}

void Canvas::arrow(PicturePoint from, PicturePoint to, Colour colour, double width) {
  const double dx = to.x - from.x, dy = to.y - from.y;
  const double length = std::hypot(dx, dy), head = 3.5 * width;
  if (!(length > head)) {
    fill_circle(from, 0.75 * width, colour);
    return;
  }
  const double ux = dx / length, uy = dy / length;
  const PicturePoint neck{to.x - head * ux, to.y - head * uy};
  const double half = 0.45 * head;
  const PicturePoint corners[] = {
      to, {neck.x - half * uy, neck.y + half * ux}, {neck.x + half * uy, neck.y - half * ux}};
  line(from, neck, colour, width);
  fill_polygon(corners, colour);
}

void Canvas::text(PicturePoint at, std::string_view utf8, double size, Colour colour, TextAnchor anchor, bool turned) {
  const std::string line(utf8);
  const double share = anchor == TextAnchor::kLeft ? 0.0 : anchor == TextAnchor::kCentre ? 0.5 : 1.0;
  const double shift = share * text_width(utf8, size);
  surface_->set(colour);
  cairo_save(surface_->context);
  cairo_set_font_size(surface_->context, size);
  cairo_translate(surface_->context, at.x, at.y);
  if (turned) cairo_rotate(surface_->context, -M_PI / 2.0);
  cairo_move_to(surface_->context, -shift, 0.0);
  cairo_show_text(surface_->context, line.c_str());
  cairo_restore(surface_->context);
}

double Canvas::text_width(std::string_view utf8, double size) const {
  const std::string line(utf8);
  cairo_text_extents_t extents;
  cairo_save(surface_->context);
  cairo_set_font_size(surface_->context, size);
  cairo_text_extents(surface_->context, line.c_str(), &extents);
  cairo_restore(surface_->context);
  return extents.x_advance;
}

void Canvas::begin_clip(const PictureRectangle& r) {
  cairo_save(surface_->context);
  cairo_rectangle(surface_->context, r.x, r.y, r.width, r.height);
  cairo_clip(surface_->context);
}

void Canvas::end_clip() { cairo_restore(surface_->context); }

void Canvas::image(PicturePoint at, std::span<const std::uint32_t> pixels, int width) {
  RISORIUS_CHECK(width > 0 && pixels.size() % static_cast<std::size_t>(width) == 0);
  const int rows = static_cast<int>(pixels.size()) / width;
  cairo_surface_t* picture = cairo_image_surface_create(CAIRO_FORMAT_ARGB32, width, rows);
  unsigned char* bytes = cairo_image_surface_get_data(picture);
  const auto stride = static_cast<std::size_t>(cairo_image_surface_get_stride(picture));
  for (std::size_t row = 0; row < static_cast<std::size_t>(rows); ++row) {
    std::memcpy(bytes + row * stride, pixels.data() + row * static_cast<std::size_t>(width),
                4 * static_cast<std::size_t>(width));
  }
  cairo_surface_mark_dirty(picture);
  cairo_set_source_surface(surface_->context, picture, at.x, at.y);
  cairo_paint(surface_->context);
  cairo_surface_destroy(picture);
}

void Canvas::save_png(const std::filesystem::path& path) const {
  AtomicFile file(path);
  const auto append = [](void* closure, const unsigned char* data, unsigned int size) {
    static_cast<std::string*>(closure)->append(reinterpret_cast<const char*>(data), size);
    return CAIRO_STATUS_SUCCESS;
  };
  std::string bytes;
  const cairo_status_t status = cairo_surface_write_to_png_stream(surface_->pixels, append, &bytes);
  if (status != CAIRO_STATUS_SUCCESS) throw UserError(path.string(), cairo_status_to_string(status), "");
  file.write(bytes);
  file.commit();
}

std::uint32_t Canvas::pixel(int x, int y) const {
  RISORIUS_CHECK(x >= 0 && y >= 0 && x < width() && y < height());
  cairo_surface_flush(surface_->pixels);
  std::uint32_t value = 0;
  std::memcpy(
      &value,
      cairo_image_surface_get_data(surface_->pixels) + y * cairo_image_surface_get_stride(surface_->pixels) + 4 * x, 4);
  return value;
}

}  // namespace risorius
