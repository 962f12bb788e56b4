#include "solve/faces/builtin_head_surface.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "solve/faces/smooth_shapes.h"

namespace risorius {
namespace {

/// A closed section of the head: front point (y, z) in the mirror plane, side point (half width, y, z), back point.
/// Sections are level at the eyes and rise to the side from the mouth down, as the jaw's edge does.
struct Section {
  double front_y, front_z, half_width, side_y, side_z, back_y, back_z, roundness;
};

// Profile without nose, lips and chin's boss, which are relief. Proportions after Farkas (Anthropometry of the Head and
// Face, 1994): nasion to menton 120, bizygomatic 135, bigonial 106, head length 190, head breadth 148.
constexpr std::array kSections = std::to_array<Section>({{-190, 36, 66, -172, -14, -160, -80, 2},
                                                         {-165, 38, 57, -150, -14, -140, -76, 2},
                                                         {-125, 42, 51.5, -108, -11, -100, -68, 2},
                                                         {-103, 51, 51.5, -82, -3, -75, -68, 2.05},
                                                         {-92, 69, 53, -66, 5, -60, -70, 2.1},
                                                         {-84, 83.5, 56, -55, 9, -50, -72, 2.1},
                                                         {-72, 89, 58.5, -46, 11, -40, -75, 2.15},
                                                         {-53, 90.5, 62.5, -35, 11, -28, -79, 2.25},
                                                         {-34, 91.5, 65.5, -22, 11, -14, -82, 2.3},
                                                         {-13, 92.5, 67.3, -7, 11, 2, -84, 2.35},
                                                         {8, 93.5, 68.3, 10, 10, 20, -85, 2.3},
                                                         {30, 95, 69, 30, 8, 38, -86, 2.3},
                                                         {50, 99.5, 71, 50, 4, 56, -85, 2.3},
                                                         {75, 101, 73.5, 75, 0, 78, -82, 2.25},
                                                         {97, 94, 70.5, 97, -1, 98, -74, 2.15},
                                                         {115, 77, 60, 115, 0, 115, -58, 2.05},
                                                         {128, 52, 43, 128, 2, 128, -36, 2},
                                                         {135, 25, 21, 135, 3, 135, -14, 2},
                                                         {138, 8, 6, 138, 3, 138, -2, 2}});

/// Catmull-Rom through four values at their own heights, between the middle two.
double cubic(const std::array<double, 4>& y, const std::array<double, 4>& v, double at) noexcept {
  const double width = y[2] - y[1], t = (at - y[1]) / width;
  const double slope1 = width * (v[2] - v[0]) / (y[2] - y[0]), slope2 = width * (v[3] - v[1]) / (y[3] - y[1]);
  const double t2 = t * t, t3 = t2 * t;
  return (2 * t3 - 3 * t2 + 1) * v[1] + (t3 - 2 * t2 + t) * slope1 + (3 * t2 - 2 * t3) * v[2] + (t3 - t2) * slope2;
}

Section section_at(double y) noexcept {
  std::size_t i = 1;
  while (i + 3 < kSections.size() && kSections[i + 1].front_y < y) ++i;
  std::array<double, 4> heights{};
  for (std::size_t k = 0; k < 4; ++k) heights[k] = kSections[i - 1 + k].front_y;
  const auto value = [&](double Section::*member) {
    return cubic(heights,
                 {kSections[i - 1].*member, kSections[i].*member, kSections[i + 1].*member, kSections[i + 2].*member},
                 y);
  };
  return {y,
          value(&Section::front_z),
          value(&Section::half_width),
          value(&Section::side_y),
          value(&Section::side_z),
          value(&Section::back_y),
          value(&Section::back_z),
          value(&Section::roundness)};
}

/// How far forward, as a share of the way from the side to the front.
double forward_share(const Section& section, double x) noexcept {
  const double a = std::min(1.0, std::abs(x) / section.half_width);
  return std::pow(1 - std::pow(a, section.roundness), 1 / section.roundness);
}

double bump(double x, double y, double cx, double cy, double rx, double ry) noexcept {
  return gauss((x - cx) / rx, (y - cy) / ry);
}

/// Brow ridge, cheekbones, the hollow below them, the curve of the teeth, chin, temples.
double bones_mm(double x, double y) noexcept {
  // With its mirror image, so that the middle stays smooth.
  const auto both = [&](double cx, double cy, double rx, double ry) {
    return bump(x, y, cx, cy, rx, ry) + bump(x, y, -cx, cy, rx, ry);
  };
  double z = 3.2 * both(27, 50, 15, 6.5) + 0.6 * bump(x, y, 0, 49, 9, 6);
  z += 2.4 * both(20, 78, 18, 14);                                      // frontal eminences
  z -= 2.0 * both(60, 60, 9, 18);                                       // temple
  z += 4.6 * both(46, 7, 13, 10) + 1.8 * both(30, -2, 13, 14);          // cheekbone, cheek
  z -= 2.2 * both(47, -26, 12, 13);                                     // hollow of the cheek
  z += 5.0 * bump(x, y, 0, -33, 21, 17);                                // teeth
  z += 6.4 * bump(x, y, 0, -72, 13, 8) + 1.1 * both(10, -74, 6, 7);     // chin
  z -= 3.4 * bump(x, y, 0, -54, 17, 4.5) + 1.2 * both(27, -52, 10, 9);  // above the chin
  z -= 1.8 * gauss((x - (19 + 0.45 * (-8 - y))) / 3.2, (y + 19) / 9);   // nasolabial fold
  z -= 2.6 * both(19, 17, 7, 6);                                        // tear trough
  return z;
}

/// The bridge's height over the face along its ridge, and the half width of its foot.
constexpr std::array<std::array<double, 3>, 9> kRidge{{{-40, 0, 9},
                                                       {-16, 0, 8},
                                                       {-4, 19, 8.4},
                                                       {4, 19.5, 8.6},
                                                       {14, 14, 8.2},
                                                       {25, 8.3, 7.4},
                                                       {36, 3.0, 7.4},
                                                       {48, 0.6, 8},
                                                       {70, 0, 9}}};

double ridge_value(double y, std::size_t column) noexcept {
  std::size_t i = 1;
  while (i + 3 < kRidge.size() && kRidge[i + 1][0] < y) ++i;
  if (y <= kRidge.front()[0] || y >= kRidge.back()[0]) return column == 1 ? 0 : 9;
  return cubic({kRidge[i - 1][0], kRidge[i][0], kRidge[i + 1][0], kRidge[i + 2][0]},
               {kRidge[i - 1][column], kRidge[i][column], kRidge[i + 1][column], kRidge[i + 2][column]}, y);
}

double nose_mm(double x, double y) noexcept {
  // The underside cuts the ridge off between the columella and the tip.
  const double under = smooth_between(-14.5, -6.5, y - 0.02 * x * x);
  const double above = y > -4 ? ridge_value(y, 1) : 19;
  double z = under * above * std::exp(-std::pow(std::abs(x) / ridge_value(std::max(y, -4.0), 2), 2.1));
  z += under * 3.2 * bump(x, y, 0, -2.5, 6, 5.5);  // tip
  z += smooth_between(-14, -9, y) * 9.0 *
       std::exp(-std::pow(std::hypot((x - 11.5) / 6.2, (y + 5.5) / 6.6), 2.6));  // wing
  z -= 1.6 * std::exp(-std::pow((std::hypot((x - 11.5) / 7.2, (y + 6) / 8) - 1) / 0.2, 2)) *
       smooth_between(9, 14, x);                // its groove
  z -= 3.4 * bump(x, y, 6.4, -10.2, 2.4, 1.7);  // nostril
  return z;
}

double share_along(double from, double to, double x) noexcept { return std::clamp((x - from) / (to - from), 0.0, 1.0); }

/// The red of the lips swells between its border and the line where the lips meet, and turns in there.
double lips_mm(double x, double y) noexcept {
  const double line = lip_line_y_mm(x), taper = std::pow(1 - std::pow(std::min(1.0, x / 27), 2.0), 0.6);
  double z = -2.6 * bump(x, y, 26.5, line - 0.5, 4, 4.2);  // corner
  if (taper <= 0) return z;
  z -= 1.1 * gauss(x / 3.2, (y + 20) / 5.5);  // philtrum
  z += 0.6 * gauss((std::abs(x) - 5) / 2.2, (y + 20) / 6);
  const bool is_upper = y >= line;
  const double border = is_upper ? upper_lip_border_y_mm(x) : lower_lip_border_y_mm(x);
  const double height = std::max(1.2, std::abs(border - line));
  const double v = std::abs(y - line) / height;
  const double swell = is_upper ? 2.3 : 3.6;
  const double turn_in = 4.6 * std::exp(-std::pow(v / 0.27, 1.5));
  const double red = v < 1 ? std::pow(std::sin(3.14159265358979 * (0.12 + 0.82 * v)), 0.8) : 0;
  const double edge = v < 1 ? 0 : std::exp(-std::pow((v - 1) / 0.5, 2));
  const double at_border = std::pow(std::sin(3.14159265358979 * 0.94), 0.8);
  return z + taper * (swell * (red + at_border * edge) - turn_in + (is_upper ? 0.5 : 0.2) * gauss((v - 1.05) / 0.16));
}

/// The lids lie on the eyeball; around them the socket. Blended in place of what was there.
double with_eye_mm(double x, double y, double z) noexcept {
  const Eigen::Vector3d c = head::kEyeballMm;
  const double dx = x - c.x(), dy = y - c.y();
  double lid = lid_depth_mm(x, y);
  const double s = share_along(head::kEyeInnerXMm, head::kEyeOuterXMm, x);
  const double along = std::pow(std::max(0.0, 4 * s * (1 - s)), 0.6);
  lid += along * (1.3 * gauss((y - upper_lid_y_mm(x) - 6.6) / 1.9) - 1.5 * gauss((y - upper_lid_y_mm(x) - 3.7) / 0.9));
  lid -= along * 0.5 * gauss((y - lower_lid_y_mm(x) + 5.2) / 1.2);
  const double below = dy < 0 ? 1 : 0;
  const double rx = dx < 0 ? 1.0 / 21 : 1.0 / 25;
  const double ry = below > 0 ? 1.0 / 17.5 : 1.0 / 17;
  const double d = std::hypot(dx * rx, dy * ry);
  const double weight = smooth_between(1.0, 0.42, d);
  return z + weight * (lid - z);
}

/// The outer ear is a shell on the side of the head: a raised rim, a hollow, a lobe.
double ear_mm(double z, double y) noexcept {
  const double u = (z + 4 + 0.12 * (y - 12)) / 15, v = (y - 14) / 29, d = std::hypot(u, v);
  if (d > 1.3) return 0;
  const double shell = smooth_between(1.22, 0.84, d);
  const double hollow = 0.55 * smooth_between(0.8, 0.35, std::hypot((u - 0.18) / 0.9, (v + 0.05) / 0.85));
  const double back_is_proud = 0.45 + 0.55 * smooth_between(0.8, -0.6, u);
  return 11 * shell * back_is_proud * (1 - hollow);
}

}  // namespace

double lip_line_y_mm(double x_mm) noexcept {
  const double x = std::abs(x_mm);
  return head::kMouthYMm - 0.5 * gauss(x / 4.5) + 0.5 * gauss((x - 10) / 6) - 0.9 * smooth_between(12, 27, x);
}

double upper_lid_y_mm(double x_mm) noexcept {
  const double s = share_along(head::kEyeInnerXMm, head::kEyeOuterXMm, x_mm), t = std::pow(s, 0.9);
  return head::kEyeInnerYMm + (head::kEyeOuterYMm - head::kEyeInnerYMm) * s +
         6.0 * std::pow(std::max(0.0, 4 * t * (1 - t)), 0.72);
}

double lower_lid_y_mm(double x_mm) noexcept {
  const double s = share_along(head::kEyeInnerXMm, head::kEyeOuterXMm, x_mm), t = std::pow(s, 1.15);
  return head::kEyeInnerYMm + (head::kEyeOuterYMm - head::kEyeInnerYMm) * s -
         4.3 * std::pow(std::max(0.0, 4 * t * (1 - t)), 0.75);
}

double lid_depth_mm(double x_mm, double y_mm) noexcept {
  const double r = std::hypot(x_mm - head::kEyeballMm.x(), y_mm - head::kEyeballMm.y());
  const double radius = head::kEyeballRadiusMm + head::kLidOverEyeballMm, turn = 10.4;
  const double at_turn = std::sqrt(radius * radius - turn * turn), slope = turn / at_turn, reach = 4.5;
  const double depth =
      r < turn ? std::sqrt(radius * radius - r * r) : at_turn - slope * reach * std::tanh((r - turn) / reach);
  return head::kEyeballMm.z() + depth;
}

double upper_lip_border_y_mm(double x_mm) noexcept {
  const double x = std::min(std::abs(x_mm), 26.0), taper = std::pow(1 - std::pow(x / 26, 2), 0.72);
  return lip_line_y_mm(x) + 6.7 * taper - 1.3 * gauss(x / 2.6) + 0.3 * gauss((x - 5.5) / 3);
}

double lower_lip_border_y_mm(double x_mm) noexcept {
  const double x = std::min(std::abs(x_mm), 26.0);
  return lip_line_y_mm(x) - 8.6 * std::pow(1 - std::pow(x / 26, 2), 0.85);
}

double head_half_width_mm(double profile_y_mm) noexcept { return section_at(profile_y_mm).half_width; }

double height_on_row_mm(double x_mm, double profile_y_mm) noexcept {
  const Section section = section_at(profile_y_mm);
  return section.front_y + (section.side_y - section.front_y) * (1 - forward_share(section, x_mm));
}

Eigen::Vector3d front_of_head_mm(double x_mm, double profile_y_mm) noexcept {
  const Section section = section_at(profile_y_mm);
  const double forward = forward_share(section, x_mm), x = std::abs(x_mm);
  const double y = section.front_y + (section.side_y - section.front_y) * (1 - forward);
  double z = section.side_z + (section.front_z - section.side_z) * forward;
  // Relief belongs to the front of the face; below the chin and beside the cheeks there is none.
  const double below_chin = smooth_between(-98, -80, profile_y_mm);
  const double beside = smooth_between(0.0, 0.45, forward);
  z += below_chin * beside * (bones_mm(x, y) + nose_mm(x, y) + lips_mm(x, y));
  if (y > 0 && y < 60 && x > 4) z = with_eye_mm(x, y, z);
  Eigen::Vector3d point(x_mm, y, z);
  point.x() += std::copysign(ear_mm(z, y), x_mm) * smooth_between(50, 62, x);
  return point;
}

Eigen::Vector3d back_of_head_mm(double angle, double profile_y_mm) noexcept {
  const Section section = section_at(profile_y_mm);
  const double backward = -std::cos(angle);
  const double x = section.half_width * std::sin(angle),
               z = section.side_z + (section.back_z - section.side_z) * backward;
  const double y = section.side_y + (section.back_y - section.side_y) * backward;
  return {x + ear_mm(z, y) * smooth_between(50, 62, x), y, z};
}

}  // namespace risorius
