// The built-in face against anatomy and against ICT-FaceKit: per AU how much of its motion lies in its region, whether
// the skin goes where the main muscle pulls, direction and amplitude at named landmarks beside ICT-FaceKit's
// corresponding shape; symmetry, openings, self-intersection and identities. ICT-FaceKit's rows need the data archive.
#include <Eigen/Geometry>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>

#include "bench_report.h"
#include "solve/faces/builtin_face.h"
#include "solve/faces/face_checks.h"
#include "solve/faces/ict_face.h"
#include "support/test_data.h"

namespace {

using namespace risorius;

struct Ict {
  FaceModel face;
  std::vector<int> landmark_vertices;  ///< of the 68, from the release's vertex_indices.json
};

std::optional<Ict> load_ict() {
  const std::filesystem::path archive = test::data_folder() / "ict_facekit.tar.xz";
  if (test::data_folder().empty() || !std::filesystem::exists(archive)) return {};
  const test::TemporaryFolder folder;
  const std::string command = "tar -xJf '" + archive.string() + "' -C '" + folder.path().string() + "'";
  if (std::system(command.c_str()) != 0) throw std::runtime_error("cannot run: " + command);
  const std::filesystem::path release = folder.path() / "ict_facekit";
  std::ifstream indices(release / "vertex_indices.json");
  return Ict{load_ict_face(release),
             nlohmann::json::parse(indices).at("idx_to_landmark_verts").get<std::vector<int>>()};
}

/// Displacements of the landmarks one below the other; without landmarks the mean of the skin that moves most.
Eigen::VectorXd motion_at(const Eigen::Matrix3Xd& displacement, const std::vector<int>& vertices) {
  Eigen::VectorXd motion(3 * static_cast<Eigen::Index>(vertices.size()));
  for (std::size_t k = 0; k < vertices.size(); ++k)
    motion.segment<3>(3 * static_cast<Eigen::Index>(k)) = displacement.col(vertices[k]);
  return motion;
}

Eigen::VectorXd builtin_motion(const FaceModel& face, const FaceAu& au, const test::FaceCheck& check) {
  Eigen::VectorXd motion(3 * static_cast<Eigen::Index>(check.landmarks.size()));
  const auto& layout = *face.find_layout("ibug68");
  for (std::size_t k = 0; k < check.landmarks.size(); ++k) {
    for (const NamedPlace& place : layout) {
      if (place.name == std::to_string(check.landmarks[k]))
        motion.segment<3>(3 * static_cast<Eigen::Index>(k)) = face.at(au.displacement_mm, place.place);
    }
  }
  return motion;
}

void compare_with_ict(bench::BenchReport& report, const FaceModel& face, const Ict& ict, const test::FaceCheck& check) {
  const FaceAu* theirs = ict.face.find_au(check.column);
  if (theirs == nullptr) return;
  const FaceAu& ours = *face.find_au(check.column);
  Eigen::VectorXd our_motion, their_motion;
  if (check.landmarks.empty()) {
    our_motion = test::movers_of(face, ours).mean_displacement_mm;
    their_motion = test::movers_of(ict.face, *theirs).mean_displacement_mm;
  } else {
    std::vector<int> vertices;
    for (const int landmark : check.landmarks)
      vertices.push_back(ict.landmark_vertices.at(static_cast<std::size_t>(landmark)));
    our_motion = builtin_motion(face, ours, check);
    their_motion = motion_at(theirs->displacement_mm, vertices);
  }
  const double points = static_cast<double>(our_motion.size()) / 3;
  const double our_mm = our_motion.norm() / std::sqrt(points), their_mm = their_motion.norm() / std::sqrt(points);
  const std::string name(check.column);
  report.add(name + ": amplitude", our_mm);
  report.add(name + ": ICT-FaceKit's amplitude", their_mm);
  report.add(name + ": amplitude / ICT-FaceKit's, or its inverse", std::max(our_mm / their_mm, their_mm / our_mm));
  report.add(name + ": cosine with ICT-FaceKit's",
             our_motion.dot(their_motion) / our_motion.norm() / their_motion.norm());
}

}  // namespace

int main() {
  try {
    bench::BenchReport report("face");
    const auto begin = std::chrono::steady_clock::now();
    const FaceModel face = builtin_face();
    report.add("build the face",
               std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
    report.add("vertices", static_cast<double>(face.vertices_mm().cols()));
    const std::optional<Ict> ict = load_ict();
    for (const test::FaceCheck& check : test::face_checks()) {
      const FaceAu& au = *face.find_au(check.column);
      const std::string name(check.column);
      report.add(name + ": motion inside its region", 100 * test::share_inside(face, au, check.region));
      if (const auto cosine = test::cosine_with_muscle(face, au))
        report.add(name + ": cosine with the main muscle", *cosine);
      if (ict) compare_with_ict(report, face, *ict, check);
    }
    report.add("largest left-right difference", test::largest_asymmetry_mm(face));
    report.add("lids apart at AU45 = 1", test::largest_lid_gap_mm(face));
    const test::Integrity integrity = test::integrity_of(face);
    report.add("self-intersections at 1", integrity.intersections_at_one);
    report.add("self-intersections at the upper bounds", integrity.intersections_at_bound);
    report.add("turned triangles at the upper bounds", integrity.flipped);
    int valid = 0;
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
      const test::Integrity one = test::integrity_of(builtin_face(face_identity_of_seed(seed)), false);
      valid += one.intersections_at_bound + one.flipped == 0;
    }
    report.add("identities of 100 without a fold or cut, all AUs", valid);
    if (!ict) std::cerr << "bench face: no ict_facekit.tar.xz: its rows are not measured; set RISORIUS_DATA\n";
    return report.finish();
  } catch (const std::exception& error) {
    std::cerr << "bench face: " << error.what() << "\n";
    return 1;
  }
}
