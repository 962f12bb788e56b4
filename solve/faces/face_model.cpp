#include "solve/faces/face_model.h"

#include <Eigen/Geometry>
#include <cmath>
#include <set>
#include <stdexcept>
#include <utility>

namespace risorius {
namespace {

[[noreturn]] void refuse(const FaceParts& parts, const std::string& problem) {
  throw std::invalid_argument("FaceModel '" + parts.name + "': " + problem);
}

void check_place(const FaceParts& parts, const std::string& name, const SurfacePoint& place) {
  if (place.triangle < 0 || place.triangle >= parts.triangles.cols())
    refuse(parts, "place " + name + " is on no triangle");
  const bool inside = place.barycentric.allFinite() && place.barycentric.minCoeff() >= -1e-9;
  if (!inside || std::abs(place.barycentric.sum() - 1) > 1e-9)
    refuse(parts, "place " + name + " is not inside its triangle");
}

FaceParts checked(FaceParts parts) {
  const Eigen::Index vertex_count = parts.vertices_mm.cols();
  if (parts.triangles.cols() == 0) refuse(parts, "no triangle");
  if (parts.triangles.minCoeff() < 0 || parts.triangles.maxCoeff() >= vertex_count) {
    refuse(parts, "a triangle names a vertex outside 0 to " + std::to_string(vertex_count - 1));
  }
  if (!parts.vertices_mm.allFinite()) refuse(parts, "a vertex is not finite");
  if (parts.skin_triangle_count < 1 || parts.skin_triangle_count > parts.triangles.cols()) {
    refuse(parts, "skin_triangle_count must be 1 to " + std::to_string(parts.triangles.cols()));
  }
  if (parts.colours.cols() != 0 && parts.colours.cols() != vertex_count) refuse(parts, "has not one colour per vertex");
  std::set<std::string> names;
  for (const FaceAu& au : parts.aus) {
    if (!names.insert(au.name).second) refuse(parts, au.name + " is there twice");
    if (au.displacement_mm.cols() != vertex_count) refuse(parts, au.name + " has not one displacement per vertex");
    if (!au.displacement_mm.allFinite()) refuse(parts, au.name + " is not finite");
  }
  for (const auto& [name, place] : parts.landmarks) check_place(parts, name, place);
  for (const auto& [name, places] : parts.layouts) {
    for (const NamedPlace& marker : places) check_place(parts, name + "/" + marker.name, marker.place);
  }
  return parts;
}

template <class Map>
auto find_in(const Map& map, std::string_view name) noexcept -> const typename Map::mapped_type* {
  const auto found = map.find(name);
  return found == map.end() ? nullptr : &found->second;
}

}  // namespace

FaceModel::FaceModel(FaceParts parts)
    : parts_(checked(std::move(parts))), skin_(parts_.vertices_mm, parts_.triangles, parts_.skin_triangle_count) {}

const FaceAu* FaceModel::find_au(std::string_view name) const noexcept {
  for (const FaceAu& au : parts_.aus) {
    if (au.name == name) return &au;
  }
  return nullptr;
}

const SurfacePoint* FaceModel::find_landmark(std::string_view name) const noexcept {
  return find_in(parts_.landmarks, name);
}

const std::vector<NamedPlace>* FaceModel::find_layout(std::string_view name) const noexcept {
  return find_in(parts_.layouts, name);
}

Eigen::Vector3d FaceModel::at(const Eigen::Matrix3Xd& field, const SurfacePoint& place) const noexcept {
  const Eigen::Vector3i v = parts_.triangles.col(place.triangle);
  const Eigen::Vector3d& w = place.barycentric;
  return w[0] * field.col(v[0]) + w[1] * field.col(v[1]) + w[2] * field.col(v[2]);
}

Eigen::Matrix3Xd FaceModel::deformed_mm(const Eigen::VectorXd& intensities) const {
  if (intensities.size() != static_cast<Eigen::Index>(parts_.aus.size())) {
    throw std::invalid_argument("FaceModel '" + parts_.name + "': one intensity per AU, " +
                                std::to_string(parts_.aus.size()) + ", not " + std::to_string(intensities.size()));
  }
  Eigen::Matrix3Xd deformed = parts_.vertices_mm;
  for (std::size_t k = 0; k < parts_.aus.size(); ++k) {
    const double x = intensities[static_cast<Eigen::Index>(k)];
    if (x != 0) deformed += x * parts_.aus[k].displacement_mm;
  }
  return deformed;
}

Eigen::Vector3d FaceModel::normal(const SurfacePoint& place) const noexcept {
  const Eigen::Vector3i v = parts_.triangles.col(place.triangle);
  const Eigen::Vector3d a = parts_.vertices_mm.col(v[0]);
  const Eigen::Vector3d b = parts_.vertices_mm.col(v[1]), c = parts_.vertices_mm.col(v[2]);
  return (b - a).cross(c - a).normalized();
}

FaceModel FaceModel::warped_at_rest(const IdentityWarp& warp) const {
  FaceParts person = parts_;
  person.aus.clear();
  for (Eigen::Index v = 0; v < person.vertices_mm.cols(); ++v) {
    person.vertices_mm.col(v) = warp(parts_.vertices_mm.col(v));
  }
  return FaceModel(std::move(person));
}

SurfacePoint place_of_vertex(const Eigen::Matrix3Xi& triangles, int vertex) noexcept {
  for (Eigen::Index t = 0; t < triangles.cols(); ++t) {
    for (int corner = 0; corner < 3; ++corner) {
      if (triangles(corner, t) == vertex) return {static_cast<int>(t), Eigen::Vector3d::Unit(corner)};
    }
  }
  return {};
}

}  // namespace risorius
