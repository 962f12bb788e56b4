#include "solve/faces/face_checks.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "solve/faces/builtin_head_mesh.h"
#include "solve/faces/facial_muscles.h"
#include "solve/faces/self_intersection.h"

namespace risorius::test {
namespace {

constexpr FaceRegion kBrow{-8, 75, 32, 95}, kEye{8, 56, 10, 48}, kMouth{-55, 55, -85, 2}, kLowerFace{-85, 85, -170, 10};

const FaceCheck kChecks[] = {
    {"AU1L", kBrow, {22, 23, 24}},
    {"AU2L", kBrow, {24, 25, 26}},
    {"AU4L", kBrow, {22, 23, 24, 25}},
    {"AU5L", kEye, {43, 44}},
    {"AU6L", {12, 75, -20, 50}, {}},
    {"AU7L", kEye, {46, 47}},
    {"AU9L", {-10, 40, -36, 75}, {35, 51, 52, 53}},
    {"AU10L", {-10, 50, -45, 30}, {35, 51, 52, 53}},
    {"AU12L", {-5, 75, -80, 30}, {53, 54, 55}},
    {"AU13L", {-5, 70, -75, 25}, {}},
    {"AU14L", {5, 60, -60, -10}, {54}},
    {"AU15L", {-5, 60, -85, -5}, {54}},
    {"AU16L", {-16, 45, -80, -28}, {55, 56, 57}},
    {"AU17", {-45, 45, -110, -15}, {8, 56, 57, 58}},
    {"AU18", kMouth, {48, 50, 51, 52, 54, 57}},
    {"AU20L", {-5, 80, -100, 5}, {54}},
    {"AU22", kMouth, {48, 50, 51, 52, 54, 56, 57, 58}},
    {"AU23", kMouth, {}},
    {"AU24L", {-25, 50, -95, -10}, {56, 57}},
    {"AU25", kMouth, {}},
    {"AU27", kLowerFace, {7, 8, 9, 57}},
    {"AU28", kMouth, {50, 51, 52, 56, 57, 58}},
    {"AU29", kLowerFace, {8, 57}},
    {"AU30L", kLowerFace, {8, 57}},
    {"AU34L", {-5, 80, -75, 20}, {54}},
    {"AU45L", kEye, {43, 44}},
};

/// A third of the area of the skin triangles about each vertex.
Eigen::VectorXd vertex_areas(const FaceModel& face) {
  Eigen::VectorXd areas = Eigen::VectorXd::Zero(face.vertices_mm().cols());
  for (int t = 0; t < face.skin_triangle_count(); ++t) {
    const Eigen::Vector3i v = face.triangles().col(t);
    const Eigen::Vector3d a = face.vertices_mm().col(v[0]);
    const Eigen::Vector3d ab = face.vertices_mm().col(v[1]) - a, ac = face.vertices_mm().col(v[2]) - a;
    for (const int corner : v) areas[corner] += ab.cross(ac).norm() / 6;
  }
  return areas;
}

std::string other_side(std::string name) {
  if (name.back() == 'L') {
    name.back() = 'R';
  } else if (name.back() == 'R') {
    name.back() = 'L';
  }
  return name;
}

}  // namespace

std::span<const FaceCheck> face_checks() { return kChecks; }

Movers movers_of(const FaceModel& face, const FaceAu& au) {
  const Eigen::VectorXd areas = vertex_areas(face);
  Eigen::VectorXd moved = au.displacement_mm.colwise().norm();
  for (Eigen::Index v = 0; v < moved.size(); ++v) moved[v] *= areas[v] > 0;
  const double half = 0.5 * moved.maxCoeff();
  Movers movers;
  double weight = 0;
  for (Eigen::Index v = 0; v < moved.size(); ++v) {
    if (moved[v] < half) continue;
    movers.mean_place_mm += areas[v] * face.vertices_mm().col(v);
    movers.mean_displacement_mm += areas[v] * au.displacement_mm.col(v);
    weight += areas[v];
  }
  movers.mean_place_mm /= weight;
  movers.mean_displacement_mm /= weight;
  return movers;
}

double share_inside(const FaceModel& face, const FaceAu& au, const FaceRegion& region) {
  const Eigen::VectorXd areas = vertex_areas(face);
  double inside = 0, all = 0;
  for (Eigen::Index v = 0; v < areas.size(); ++v) {
    const double energy = areas[v] * au.displacement_mm.col(v).squaredNorm();
    const double x = face.vertices_mm()(0, v), y = face.vertices_mm()(1, v);
    all += energy;
    const bool is_inside = x > region.least_x && x < region.greatest_x && y > region.least_y && y < region.greatest_y;
    if (is_inside) inside += energy;
  }
  return inside / all;
}

std::optional<double> cosine_with_muscle(const FaceModel& builtin, const FaceAu& au) {
  const bool is_sided = au.name.ends_with('L') && !au.name.starts_with("AU30");
  const std::string_view name = std::string_view(au.name).substr(0, au.name.size() - (is_sided ? 1 : 0));
  const Muscle* main = nullptr;
  for (const Muscle& muscle : facial_muscles()) {
    const bool is_straight =
        muscle.kind == MuscleKind::kLinear || muscle.kind == MuscleKind::kSheet || muscle.kind == MuscleKind::kJawShift;
    if (muscle.au != name || !is_straight) continue;
    if (main == nullptr || muscle.amplitude_mm > main->amplitude_mm) main = &muscle;
  }
  if (main == nullptr) return {};
  const Eigen::Vector3d pull = (main->origin_mm - main->insertion_mm).normalized();
  return pull.dot(movers_of(builtin, au).mean_displacement_mm.normalized());
}

double largest_asymmetry_mm(const FaceModel& builtin) {
  const std::vector<int> mirror = build_head_mesh().mirror_vertex;
  const Eigen::Vector3d flip(-1, 1, 1);
  double largest = 0;
  const auto compare = [&](const Eigen::Matrix3Xd& left, const Eigen::Matrix3Xd& right) {
    for (Eigen::Index v = 0; v < left.cols(); ++v) {
      const auto image = static_cast<Eigen::Index>(mirror[static_cast<std::size_t>(v)]);
      largest = std::max(largest, (left.col(v) - flip.cwiseProduct(right.col(image))).norm());
    }
  };
  compare(builtin.vertices_mm(), builtin.vertices_mm());
  for (const FaceAu& au : builtin.aus())
    compare(au.displacement_mm, builtin.find_au(other_side(au.name))->displacement_mm);
  return largest;
}

double largest_lid_gap_mm(const FaceModel& builtin) {
  const HeadMesh mesh = build_head_mesh();
  const Eigen::Matrix3Xd closed = builtin.vertices_mm() + builtin.find_au("AU45L")->displacement_mm;
  double largest = 0;
  for (std::size_t k = 1; k + 1 < mesh.upper_lid_edge.size(); ++k) {
    const Eigen::Vector3d gap = closed.col(mesh.upper_lid_edge[k]) - closed.col(mesh.lower_lid_edge[k]);
    if (gap.y() < 0) return gap.y();
    largest = std::max(largest, gap.norm());
  }
  return largest;
}

Integrity integrity_of(const FaceModel& face, bool with_one) {
  Integrity sum;
  const auto intersections = [&](const Eigen::Matrix3Xd& vertices) {
    return static_cast<int>(self_intersections(vertices, face.triangles(), face.skin_triangle_count()).size());
  };
  const auto flipped = [&](const Eigen::Matrix3Xd& vertices) {
    return static_cast<int>(
        flipped_triangles(face.vertices_mm(), vertices, face.triangles(), face.skin_triangle_count()).size());
  };
  sum.intersections_at_one = intersections(face.vertices_mm());
  sum.intersections_at_bound = sum.intersections_at_one;
  sum.flipped = flipped(face.vertices_mm());
  for (const FaceAu& au : face.aus()) {
    // Right sides are mirror images.
    if (au.name.ends_with('R')) continue;
    const Eigen::Matrix3Xd at_bound = face.vertices_mm() + au.upper_bound * au.displacement_mm;
    if (with_one) sum.intersections_at_one += intersections(face.vertices_mm() + au.displacement_mm);
    sum.intersections_at_bound += intersections(at_bound);
    sum.flipped += flipped(at_bound);
  }
  return sum;
}

}  // namespace risorius::test
