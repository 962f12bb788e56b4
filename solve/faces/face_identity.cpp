#include "solve/faces/face_identity.h"

#include <cmath>
#include <random>

#include "solve/faces/builtin_head_surface.h"
#include "solve/faces/smooth_shapes.h"

namespace risorius {
namespace {

/// Scales about the lips' line: fuller reds, further forward.
void fill_lips(double fullness_mm, Eigen::Vector3d& p) noexcept {
  const double x = std::abs(p.x()), from_line = p.y() - lip_line_y_mm(x);
  const double near = smooth_between(27, 8, x) * smooth_between(50, 75, p.z());
  p.y() += near * fullness_mm * from_line / 8 * compact_bell(std::abs(from_line) / 24);
  p.z() += near * 0.7 * fullness_mm * compact_bell(std::abs(from_line) / 18);
}

}  // namespace

FaceIdentity face_identity_of_seed(std::uint64_t seed) {
  FaceIdentity identity;
  if (seed == 0) return identity;
  std::mt19937_64 random(seed);
  for (const IdentityParameter& parameter : kIdentityParameters) {
    // 53 random bits; the library's distributions differ from one standard library to the next.
    const double share = static_cast<double>(random() >> 11) * 0x1p-53;
    identity.*parameter.value = parameter.least + share * (parameter.greatest - parameter.least);
  }
  return identity;
}

Eigen::Vector3d warped_mm(const FaceIdentity& identity, const Eigen::Vector3d& p_mm) noexcept {
  Eigen::Vector3d p = p_mm;
  const double x = std::abs(p_mm.x()), y = p_mm.y();
  const double front = smooth_between(25, 60, p_mm.z());
  fill_lips(identity.lip_fullness_mm, p);
  const double eye = smooth_between(36, 17, std::hypot(x - head::kEyeballMm.x(), y - head::kEyeballMm.y()));
  p.x() += std::copysign(0.5 * identity.eye_spacing_mm * eye * smooth_between(1, 16, x), p_mm.x());
  p.x() += identity.nose_width * p_mm.x() * smooth_between(30, 12, x) * smooth_between(-28, -14, y) *
           smooth_between(32, 8, y) * front;
  p.y() -= identity.nose_length_mm * smooth_between(34, 2, y) * smooth_between(-27, -13, y) *
           smooth_between(34, 13, x) * front;
  p.z() += identity.brow_depth_mm * gauss((y - 51) / 11) * smooth_between(66, 40, x) * front;
  p.z() += identity.chin_forward_mm * gauss((y + 74) / 17) * smooth_between(52, 8, x) * front;
  p.x() *= 1 + identity.jaw_width * smooth_between(0, -48, y);
  p.x() *= 1 + identity.face_width;
  p.y() *= 1 + identity.face_height;
  return p;
}

}  // namespace risorius
