// The equations of facial_muscles.h.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "solve/faces/builtin_head_surface.h"
#include "solve/faces/facial_muscles.h"
#include "solve/faces/smooth_shapes.h"

namespace risorius {
namespace {

/// A vertex at rest, as seen from the muscle's side: x > 0 is that side.
struct Skin {
  Eigen::Vector3d p;
  bool is_above_mouth, is_above_eye;
};

/// Distance from the insertion in radii of the region, in the frontal plane.
double distance_of(const Muscle& muscle, const Eigen::Vector3d& p) noexcept {
  const Eigen::Vector2d offset = (p - muscle.insertion_mm).head<2>();
  Eigen::Vector2d along = (muscle.origin_mm - muscle.insertion_mm).head<2>();
  if (muscle.kind == MuscleKind::kSphincter || along.norm() < 1e-6) along = Eigen::Vector2d::UnitX();
  along.normalize();
  const double u = offset.dot(along) / muscle.along_mm;
  const double v = (along.x() * offset.y() - along.y() * offset.x()) / muscle.across_mm;
  return std::hypot(u, v);
}

/// 1 on the lids, whose skin is thin and loose and slides on the eyeball, to 0 beyond the rim of the orbit.
double lid_share(const Eigen::Vector3d& p) noexcept {
  const double across = (std::abs(p.x()) - 31.5) / 20, up = (p.y() - 30) / 14;  // the rim is at 1
  return smooth_between(1.4, 0.7, std::hypot(across, up));
}

/// Skin and the fat under it draw what is around them along, half as much and so far beyond the muscle's own region as
/// it moves in scanned faces; less across the middle, where skin is held. Not on the lids, and what only pulls a lid
/// draws nothing else along.
double tissue_weight(Muscle muscle, const Skin& skin, double of_muscle) noexcept {
  constexpr double kBeyondMm = 45, kAcrossMiddleMm = 40;
  const double share = (muscle.kind == MuscleKind::kSphincter ? 0.25 : 0.5) * (1 - lid_share(muscle.insertion_mm));
  muscle.along_mm += kBeyondMm;
  muscle.across_mm += kBeyondMm;
  double of_tissue = compact_bell(distance_of(muscle, skin.p)) * (1 - lid_share(skin.p));
  if (muscle.is_paired) of_tissue *= smooth_between(-kAcrossMiddleMm, 0.25 * kAcrossMiddleMm, skin.p.x());
  return (1 - share) * of_muscle + share * of_tissue;
}

double weight_of(const Muscle& muscle, const Skin& skin) noexcept {
  const double distance = distance_of(muscle, skin.p);
  constexpr double kSheetCore = 0.18;
  const double of_muscle = muscle.kind == MuscleKind::kLinear
                               ? compact_bell(distance)
                               : compact_bell(std::max(0.0, (distance - kSheetCore) / (1 - kSheetCore)));
  const double weight = tissue_weight(muscle, skin, of_muscle);
  double share = smooth_between(0, 25, skin.p.z());  // the back of the head has other muscles
  // Across the lips' slit the other lip stays; beyond the corner both are one.
  const bool is_other_lip = (muscle.lips == LipShare::kUpper && !skin.is_above_mouth) ||
                            (muscle.lips == LipShare::kLower && skin.is_above_mouth);
  if (is_other_lip) share *= smooth_between(13, head::kMouthCornerXMm, std::abs(skin.p.x()));
  return weight * share;
}

Eigen::Vector3d pull_mm(const Muscle& muscle, const Skin& skin) noexcept {
  const Eigen::Vector3d direction = (muscle.origin_mm - muscle.insertion_mm).normalized();
  return weight_of(muscle, skin) * (muscle.amplitude_mm * direction + Eigen::Vector3d(0, 0, muscle.outward_mm));
}

/// Draws in by a share of the distance to the middle; forward most where the lips are. The ring is carried by the
/// teeth's bow, so what is drawn to the middle comes forward by itself.
Eigen::Vector3d sphincter_mm(const Muscle& muscle, const Skin& skin) noexcept {
  const double weight = weight_of(muscle, skin);
  const double share = muscle.amplitude_mm / head::kMouthCornerXMm;
  const Eigen::Vector3d offset = skin.p - muscle.insertion_mm;
  return weight * Eigen::Vector3d(-share * offset.x(), -0.25 * share * offset.y(), muscle.outward_mm);
}

/// Red of the lips between its border and the slit is drawn towards the slit, and back by `outward_mm`; skin beyond
/// follows as far as `along_mm`.
Eigen::Vector3d roll_in_mm(const Muscle& muscle, const Skin& skin) noexcept {
  const double x = std::abs(skin.p.x()), line = lip_line_y_mm(x);
  const double border =
      std::max(1.0, std::abs((skin.is_above_mouth ? upper_lip_border_y_mm(x) : lower_lip_border_y_mm(x)) - line));
  const double middle_border = skin.is_above_mouth ? 6.0 : 8.6;
  const double from_slit = std::max(0.0, std::abs(skin.p.y() - line));
  const double taper =
      compact_bell(std::max(0.0, std::abs(skin.p.x() - muscle.insertion_mm.x()) / muscle.across_mm - 0.25) / 0.75) *
      smooth_between(0, 40, skin.p.z());
  const double narrowing = std::min(muscle.amplitude_mm, 0.70 * border) * std::min(1.0, border / middle_border);
  const double beyond = std::max(0.0, from_slit - border) / muscle.along_mm;
  const double in_red = smooth_between(-0.25, 1, from_slit / border) - smooth_between(-0.25, 1, 0);
  const double all = 1 - smooth_between(-0.25, 1, 0);
  const double along = in_red / all * compact_bell(beyond);
  const double back = compact_bell(0.8 * from_slit / (border + 0.6 * muscle.along_mm));
  const double towards_slit = skin.is_above_mouth ? -1 : 1;
  return taper * Eigen::Vector3d(0, towards_slit * narrowing * along, muscle.outward_mm * back);
}

/// The edge slides on the eyeball; the skin up to the fold follows less and less.
Eigen::Vector3d lid_mm(const Muscle& muscle, const Skin& skin) noexcept {
  const bool is_upper = muscle.kind == MuscleKind::kUpperLid;
  const double x = skin.p.x();
  if (is_upper != skin.is_above_eye || x <= head::kEyeInnerXMm || x >= head::kEyeOuterXMm) return {0, 0, 0};
  const double upper = upper_lid_y_mm(x), lower = lower_lid_y_mm(x), edge = is_upper ? upper : lower;
  const double beyond = (is_upper ? skin.p.y() - edge : edge - skin.p.y()) / muscle.along_mm;
  if (beyond >= 1 || skin.p.z() < 40) return {0, 0, 0};
  // The opening's height at x against its greatest: the edge keeps its bow, and the corners stay.
  constexpr double kOpeningMm = 10.3;
  const double travel = muscle.amplitude_mm * (upper - lower) / kOpeningMm;
  const double follow = std::pow(1 - std::max(0.0, beyond), 1.6);
  const double y = skin.p.y() + travel * follow;
  const double slide = lid_depth_mm(x, y) - lid_depth_mm(x, skin.p.y());
  return {0, travel * follow, slide * smooth_between(1, 0.4, beyond)};
}

/// How much of the jaw's motion the skin takes: half where the lips' line runs on to the joint, all at the chin, none
/// above; between the corners of the mouth the lips part. The neck follows less and less.
double jaw_share(const Muscle& muscle, const Skin& skin) noexcept {
  const Eigen::Vector3d& p = skin.p;
  const double along = std::clamp((93 - p.z()) / (93 - head::kCondyleMm.z()), -0.2, 1.0);
  const double line = head::kMouthYMm + along * (head::kCondyleMm.y() - head::kMouthYMm);
  const double above = p.y() - line, x = std::abs(p.x());
  const double beside = smooth_between(muscle.along_mm, -muscle.across_mm, above);
  const double at_line = smooth_between(muscle.along_mm, -muscle.across_mm, 0);
  const double inside = smooth_between(head::kMouthCornerXMm + 1, 5, x);
  const double share = skin.is_above_mouth
                           ? beside * (1 - inside)
                           : 1 - (1 - beside) / (1 - at_line) * (1 - (at_line + inside * (1 - at_line)));
  const double edge = -84 + 0.45 * (86 - p.z());
  return share * smooth_between(-75, 4, p.y() - edge) * smooth_between(12, 66, p.z());
}

Eigen::Vector3d jaw_mm(const Muscle& muscle, const Skin& skin, HeadPart part) noexcept {
  double share = jaw_share(muscle, skin);
  if (part == HeadPart::kLowerTeeth || part == HeadPart::kTongue) share = 1;
  if (part == HeadPart::kUpperTeeth || part == HeadPart::kEyeball) share = 0;
  if (share <= 0) return {0, 0, 0};
  if (muscle.kind == MuscleKind::kJawShift) {
    return share * muscle.amplitude_mm * (muscle.origin_mm - muscle.insertion_mm).normalized();
  }
  const Eigen::Vector3d hinge(0, head::kCondyleMm.y(), head::kCondyleMm.z());
  const double angle = muscle.amplitude_mm / (muscle.insertion_mm - hinge).norm();
  const Eigen::Vector3d arm = skin.p - hinge;
  const Eigen::Vector3d turned = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitX()) * arm;
  return share * (turned - arm + Eigen::Vector3d(0, 0, muscle.outward_mm));
}

Eigen::Vector3d muscle_mm(const Muscle& muscle, const Skin& skin, HeadPart part) noexcept {
  switch (muscle.kind) {
    case MuscleKind::kLinear:
    case MuscleKind::kSheet:
      return pull_mm(muscle, skin);
    case MuscleKind::kSphincter:
      return sphincter_mm(muscle, skin);
    case MuscleKind::kRollIn:
      return roll_in_mm(muscle, skin);
    case MuscleKind::kUpperLid:
    case MuscleKind::kLowerLid:
      return lid_mm(muscle, skin);
    case MuscleKind::kJawTurn:
    case MuscleKind::kJawShift:
      return jaw_mm(muscle, skin, part);
  }
  return {0, 0, 0};
}

}  // namespace

Eigen::Matrix3Xd au_displacement_mm(const HeadMesh& mesh, const AuColumn& column) {
  Eigen::Matrix3Xd displacement = Eigen::Matrix3Xd::Zero(3, mesh.vertices_mm.cols());
  const Eigen::Vector3d mirror(column.side == 'R' ? -1 : 1, 1, 1);
  for (Eigen::Index v = 0; v < mesh.vertices_mm.cols(); ++v) {
    const auto vertex = static_cast<std::size_t>(v);
    const HeadPart part = mesh.part[vertex];
    const bool is_soft = part == HeadPart::kSkin || part == HeadPart::kLidRim || part == HeadPart::kMouthPocket;
    const auto anchor = static_cast<std::size_t>(mesh.anchor[vertex]);
    const Skin skin{mirror.cwiseProduct(mesh.vertices_mm.col(mesh.anchor[vertex])), mesh.is_above_mouth[anchor],
                    mesh.is_above_eye[anchor]};
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Muscle& muscle : facial_muscles()) {
      if (muscle.au != column.au) continue;
      const bool is_jaw = muscle.kind == MuscleKind::kJawTurn || muscle.kind == MuscleKind::kJawShift;
      if (is_soft || is_jaw) sum += muscle_mm(muscle, skin, part);
    }
    displacement.col(v) = mirror.cwiseProduct(sum);
  }
  return displacement;
}

}  // namespace risorius
