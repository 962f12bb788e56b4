// The skin of the built-in head as a smooth function of two coordinates: how far around the head, and how high along
// its profile. Millimetres; x to the subject's left, y up, z out of the face, origin between the ears. Symmetric in x.
#pragma once

#include <Eigen/Core>

namespace risorius {

/// Places of the face that surface, mesh and AU fields share. Left side; the right one is its mirror image.
namespace head {
inline constexpr double kFrontHalfWidthMm = 68.5;  ///< of the chart's front; the rows scale towards it sideways
inline constexpr double kEyeInnerXMm = 16.3, kEyeOuterXMm = 45.5, kEyeSlitYMm = 30;
inline constexpr double kEyeInnerYMm = 29.2, kEyeOuterYMm = 31.4;
inline constexpr double kMouthYMm = -34, kMouthCornerXMm = 25;
inline constexpr double kEyeballRadiusMm = 12.2, kLidOverEyeballMm = 1.1;
inline const Eigen::Vector3d kEyeballMm{31, 30.6, 77.6};
/// The joint of the jaw, before and a little below the ear's canal.
inline const Eigen::Vector3d kCondyleMm{52, 8, 14};
}  // namespace head

/// Heights of the slits' edges (mm) over x >= 0: where the lips meet, and the edges of the open lids.
double lip_line_y_mm(double x_mm) noexcept;
double upper_lid_y_mm(double x_mm) noexcept;
double lower_lid_y_mm(double x_mm) noexcept;
/// z (mm) of a lid that lies on the eyeball, at x >= 0; away from the eyeball it goes on smoothly.
double lid_depth_mm(double x_mm, double y_mm) noexcept;
/// Heights of the borders between skin and red of the lips (mm) over x >= 0.
double upper_lip_border_y_mm(double x_mm) noexcept;
double lower_lip_border_y_mm(double x_mm) noexcept;

/// The half width of the head (mm) at a height of the profile, and the height of the row's middle point as seen at x.
double head_half_width_mm(double profile_y_mm) noexcept;
double height_on_row_mm(double x_mm, double profile_y_mm) noexcept;

/// A point of the front, |x| below the half width; profile_y_mm -165 (throat) to 134 (crown).
Eigen::Vector3d front_of_head_mm(double x_mm, double profile_y_mm) noexcept;
/// A point behind: angle 90 (the side) to 180 degrees (the back of the head), in radians.
Eigen::Vector3d back_of_head_mm(double angle, double profile_y_mm) noexcept;

}  // namespace risorius
