#include "solve/faces/builtin_face.h"

#include <array>
#include <string_view>
#include <utility>

#include "capture/check.h"
#include "solve/faces/builtin_face_paint.h"
#include "solve/faces/builtin_head_mesh.h"
#include "solve/faces/builtin_landmarks.h"
#include "solve/faces/facial_muscles.h"

namespace risorius {
namespace {

constexpr std::array<std::string_view, 7> kStabilisers{"FH1", "FH2", "FH3", "MH", "MNOSE", "LHD", "RHD"};

/// Lips tightened look to 55 markers like a mixture of 18, 24 and 28: with it the rig's basis would be three times
/// worse conditioned, and intensities would wander among the four.
constexpr std::string_view kNotForMarkers = "AU23";

/// A field goes through the identity's warp with the skin that it moves.
Eigen::Matrix3Xd carried_over_mm(const FaceIdentity& identity, const Eigen::Matrix3Xd& rest_mm,
                                 const Eigen::Matrix3Xd& warped_rest_mm, Eigen::Matrix3Xd field_mm) {
  for (Eigen::Index v = 0; v < rest_mm.cols(); ++v) {
    if (field_mm.col(v).isZero(0)) continue;
    field_mm.col(v) = warped_mm(identity, rest_mm.col(v) + field_mm.col(v)) - warped_rest_mm.col(v);
  }
  return field_mm;
}

}  // namespace

FaceModel builtin_face(const FaceIdentity& identity) {
  const HeadMesh mesh = build_head_mesh();
  FaceParts parts;
  parts.name = "builtin";
  parts.vertices_mm.resize(3, mesh.vertices_mm.cols());
  for (Eigen::Index v = 0; v < mesh.vertices_mm.cols(); ++v) {
    parts.vertices_mm.col(v) = warped_mm(identity, mesh.vertices_mm.col(v));
  }
  parts.triangles = mesh.triangles;
  parts.skin_triangle_count = mesh.skin_triangle_count;
  parts.colours = builtin_colours(mesh);
  add_builtin_landmarks(mesh, parts);
  for (const AuColumn& column : facial_au_columns()) {
    parts.aus.push_back(
        {column.name, carried_over_mm(identity, mesh.vertices_mm, parts.vertices_mm, au_displacement_mm(mesh, column)),
         column.upper_bound, column.name != kNotForMarkers});
  }
  return FaceModel(std::move(parts));
}

Rig builtin_rig_of(const FaceModel& builtin, RigColumns columns) {
  const std::vector<NamedPlace>* layout = builtin.find_layout(kBuiltinLayout);
  RISORIUS_CHECK(layout != nullptr);
  const auto marker_count = static_cast<Eigen::Index>(layout->size());
  Rig rig;
  rig.name = "builtin";
  rig.source = "the built-in face at the layout iemocap55";
  rig.neutral_mm.resize(3, marker_count);
  rig.stabiliser_weight = Eigen::VectorXd::Zero(marker_count);
  for (Eigen::Index m = 0; m < marker_count; ++m) {
    const NamedPlace& marker = (*layout)[static_cast<std::size_t>(m)];
    rig.marker_names.push_back(marker.name);
    rig.neutral_mm.col(m) = builtin.position_mm(marker.place);
    for (const std::string_view name : kStabilisers) {
      if (name == marker.name) rig.stabiliser_weight[m] = 1;
    }
  }
  for (const FaceAu& shape : builtin.aus()) {
    if (!shape.in_rigs && columns == RigColumns::kSolvable) continue;
    // What markers do not see no solver can find.
    constexpr double kLeastMotionMm = 0.3;
    RigAu au{shape.name, Eigen::Matrix3Xd(3, marker_count), shape.upper_bound};
    for (Eigen::Index m = 0; m < marker_count; ++m) {
      au.displacement_mm.col(m) = builtin.at(shape.displacement_mm, (*layout)[static_cast<std::size_t>(m)].place);
    }
    if (au.displacement_mm.colwise().norm().maxCoeff() >= kLeastMotionMm) rig.aus.push_back(std::move(au));
  }
  return rig;
}

Rig builtin_rig() { return builtin_rig_of(builtin_face()); }

}  // namespace risorius
