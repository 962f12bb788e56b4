#include "solve/faces/builtin_face_paint.h"

#include <array>
#include <cmath>

#include "solve/faces/builtin_head_surface.h"
#include "solve/faces/smooth_shapes.h"

namespace risorius {
namespace {

const Eigen::Vector3d kSkin{0.82, 0.64, 0.545}, kRuddy{0.80, 0.53, 0.455}, kLipRed{0.71, 0.42, 0.39},
    kBrowHair{0.24, 0.16, 0.11}, kLash{0.20, 0.13, 0.11}, kSclera{0.93, 0.92, 0.90}, kIris{0.30, 0.40, 0.42},
    kIrisEdge{0.12, 0.16, 0.18}, kPupil{0.02, 0.02, 0.02}, kTooth{0.91, 0.88, 0.80}, kGap{0.62, 0.52, 0.45},
    kPocket{0.20, 0.06, 0.06}, kRim{0.78, 0.52, 0.47}, kNostril{0.22, 0.10, 0.08};

Eigen::Vector3d mixed(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double share) {
  return a + std::min(1.0, std::max(0.0, share)) * (b - a);
}

/// A bow from above the inner corner of the eye to beyond the outer one, thinning outwards.
double brow_share(double x, double y) noexcept {
  const double t = (x - 9) / 48.5;
  if (t <= 0 || t >= 1) return 0;
  const double middle = 50 + t * (26.5 - 29 * t), half = 3.3 * std::pow(1 - t, 0.55) * smooth_between(-0.06, 0.06, t);
  return 0.88 * smooth_between(1.7, 0.25, std::abs(y - middle) / half);
}

double lip_share(double x, double y) noexcept {
  if (x > 25.5) return 0;
  const double line = lip_line_y_mm(x);
  const double border = y >= line ? upper_lip_border_y_mm(x) : lower_lip_border_y_mm(x);
  return smooth_between(1.1, 0.9, std::abs(y - line) / std::max(0.5, std::abs(border - line)));
}

Eigen::Vector3d skin_colour(const Eigen::Vector3d& p) {
  const double x = std::abs(p.x()), y = p.y();
  Eigen::Vector3d colour = kSkin;
  if (p.z() < 20) return colour;
  colour = mixed(colour, kRuddy, 0.45 * gauss((x - 40) / 14, (y - 3) / 12) + 0.4 * gauss(x / 9, (y + 3) / 9));
  colour = mixed(colour, kRuddy, 0.35 * gauss((x - 31) / 16, (y - 31) / 9));
  colour = mixed(colour, kLipRed, lip_share(x, y));
  colour = mixed(colour, kNostril, 0.95 * smooth_between(1.25, 0.45, std::hypot((x - 6.4) / 3.3, (y + 10.4) / 1.9)));
  if (x > head::kEyeInnerXMm && x < head::kEyeOuterXMm) {
    const double over = y - upper_lid_y_mm(x);
    if (over >= -0.5) colour = mixed(colour, kLash, 0.8 * smooth_between(1.1, 0.1, over));
    if (over < -0.5) colour = mixed(colour, kLash, 0.35 * smooth_between(0.9, 0.1, lower_lid_y_mm(x) - y));
  }
  return mixed(colour, kBrowHair, brow_share(x, y));
}

Eigen::Vector3d eye_colour(const Eigen::Vector3d& p) {
  const Eigen::Vector3d from_centre = Eigen::Vector3d(std::abs(p.x()), p.y(), p.z()) - head::kEyeballMm;
  const double degrees = std::atan2(std::hypot(from_centre.x(), from_centre.y()), from_centre.z()) * 57.29577951;
  if (degrees < 9.9) return kPupil;
  if (degrees > 29) return mixed(kSclera, kRim, smooth_between(42, 66, degrees));
  return degrees > 25 ? kIrisEdge : kIris;
}

Eigen::Vector3d tooth_colour(const Eigen::Vector3d& p) {
  const double half_width = p.y() > -35.9 ? 23 : 20;  // as in builtin_head_parts.cpp
  const double a = std::asin(std::min(1.0, std::abs(p.x()) / half_width)) / (0.5 * 3.14159265358979);
  return mixed(kGap, kTooth, 3 * std::abs(std::sin(3.14159265358979 * 7 * a)));
}

}  // namespace

Eigen::Matrix3Xd builtin_colours(const HeadMesh& mesh) {
  Eigen::Matrix3Xd colours(3, mesh.vertices_mm.cols());
  for (Eigen::Index v = 0; v < mesh.vertices_mm.cols(); ++v) {
    const Eigen::Vector3d p = mesh.vertices_mm.col(v);
    switch (mesh.part[static_cast<std::size_t>(v)]) {
      case HeadPart::kSkin:
        colours.col(v) = skin_colour(p);
        break;
      case HeadPart::kLidRim:
        colours.col(v) = kRim;
        break;
      case HeadPart::kMouthPocket:
        colours.col(v) = kPocket;
        break;
      case HeadPart::kUpperTeeth:
      case HeadPart::kLowerTeeth:
        colours.col(v) = tooth_colour(p);
        break;
      case HeadPart::kEyeball:
        colours.col(v) = eye_colour(p);
        break;
      case HeadPart::kTongue:
        colours.col(v) = kLipRed;
        break;
    }
  }
  return colours;
}

}  // namespace risorius
