// ICT-FaceKit's published files, and a real actor's neutral fitted to them. Skipped without the data.
#include "solve/faces/ict_face.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <optional>
#include <sstream>
#include <utility>

#include "capture/errors.h"
#include "solve/faces/rig_fit.h"
#include "support/test_data.h"

namespace {

using namespace risorius;

void unpack(const std::filesystem::path& archive, const std::filesystem::path& folder) {
  const std::string command = "tar -xJf '" + archive.string() + "' -C '" + folder.string() + "'";
  if (std::system(command.c_str()) != 0) throw std::runtime_error("cannot run: " + command);
}

/// Unpacks and loads; takes seconds, so one test checks all that needs it.
FaceModel load_archive(const std::filesystem::path& archive) {
  const test::TemporaryFolder folder;
  unpack(archive, folder.path());
  std::size_t calls = 0, last = 0;
  FaceModel loaded = load_ict_face(folder.path() / "ict_facekit", [&](std::size_t done, std::size_t in_all) {
    EXPECT_EQ(done, ++calls);
    last = in_all;
  });
  EXPECT_EQ(calls, last);
  return loaded;
}

/// Mean displacement of the skin vertices that move at least half as much as the one that moves most, and their mean
/// place.
struct Movers {
  Eigen::Vector3d place_mm = Eigen::Vector3d::Zero(), displacement_mm = Eigen::Vector3d::Zero();
  double largest_mm = 0;
};

Movers movers_of(const FaceModel& face, const char* name) {
  const FaceAu* au = face.find_au(name);
  if (au == nullptr) throw std::runtime_error(std::string("no ") + name);
  const auto skin = au->displacement_mm.leftCols(kIctFaceVertexCount);
  Movers movers;
  movers.largest_mm = skin.colwise().norm().maxCoeff();
  double count = 0;
  for (Eigen::Index v = 0; v < skin.cols(); ++v) {
    if (skin.col(v).norm() < 0.5 * movers.largest_mm) continue;
    movers.place_mm += face.vertices_mm().col(v);
    movers.displacement_mm += skin.col(v);
    ++count;
  }
  movers.place_mm /= count;
  movers.displacement_mm /= count;
  return movers;
}

struct Neutral {
  std::vector<std::string> names;
  Eigen::Matrix3Xd position_mm;
};

/// Mean of rows 20 to 90 (the still part, see the data's README) of an AnimFace CSV, centimetres.
Neutral animface_neutral(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line, cell;
  std::getline(file, line);
  Neutral neutral;
  for (std::istringstream header(line); std::getline(header, cell, ',');) {
    if (cell.ends_with("_x")) neutral.names.push_back(cell.substr(0, cell.size() - 2));
  }
  neutral.position_mm = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(neutral.names.size()));
  for (int row = 0; row <= 90 && std::getline(file, line); ++row) {
    if (row < 20) continue;
    std::istringstream cells(line);
    std::getline(cells, cell, ',');
    std::getline(cells, cell, ',');
    for (double& coordinate : neutral.position_mm.reshaped()) {
      std::getline(cells, cell, ',');
      coordinate += 10 * std::stod(cell) / 71;
    }
  }
  return neutral;
}

constexpr const char* kArchive = "ict_facekit.tar.xz";

void expect_published_mesh(const FaceModel& face) {
  EXPECT_EQ(face.vertices_mm().cols(), kIctVertexCount);
  // The release: 25,836 quads and 548 triangles.
  EXPECT_EQ(face.triangles().cols(), 2 * 25836 + 548);
  EXPECT_LT(face.triangles().leftCols(face.skin_triangle_count()).maxCoeff(), kIctFaceVertexCount);
  EXPECT_EQ(face.aus().size(), 42u);
  // First and last vertex line of generic_neutral_mesh.obj's order: the middle of the upper lip, centimetres to mm.
  EXPECT_LT((face.vertices_mm().col(0) - Eigen::Vector3d(0, -24.8251, 118.387)).norm(), 1e-3);
}

void expect_vertex_order(const FaceModel& face) {
  double longest_mm = 0;
  for (int t = 0; t < face.skin_triangle_count(); ++t) {
    const Eigen::Vector3i v = face.triangles().col(t);
    longest_mm = std::max(longest_mm, (face.vertices_mm().col(v[0]) - face.vertices_mm().col(v[1])).norm());
  }
  EXPECT_LT(longest_mm, 25);  // a shuffled order would connect vertices across the head (180 mm)
}

void expect_left_is_left(const FaceModel& face) {
  const Movers smile = movers_of(face, "AU12L");
  EXPECT_GT(smile.place_mm.x(), 15);
  EXPECT_GT(smile.displacement_mm.x(), 3);
  EXPECT_GT(smile.displacement_mm.y(), 3);
  EXPECT_LT(movers_of(face, "AU12R").place_mm.x(), -15);
  EXPECT_GT(movers_of(face, "AU2L").displacement_mm.y(), 3);
  EXPECT_GT(movers_of(face, "AU30L").displacement_mm.x(), 3);
  EXPECT_LT(movers_of(face, "AU27").displacement_mm.y(), -10);
}

void expect_plausible_motion(const FaceModel& face) {
  for (const FaceAu& au : face.aus()) {
    const double largest_mm = movers_of(face, au.name.c_str()).largest_mm;
    EXPECT_GT(largest_mm, 1) << au.name;
    EXPECT_LT(largest_mm, 60) << au.name;
  }
}

void expect_landmarks_in_place(const FaceModel& face) {
  for (const auto& [name, place] : face.landmarks()) {
    const Eigen::Vector3d p = face.position_mm(place);
    if (!name.ends_with("_left")) {
      if (!name.ends_with("_right")) {
        EXPECT_NEAR(p.x(), 0, 0.1) << name;
      }
      continue;
    }
    const SurfacePoint* right = face.find_landmark(name.substr(0, name.size() - 4) + "right");
    ASSERT_NE(right, nullptr) << name;
    EXPECT_GT(p.x(), 5) << name;
    EXPECT_LT((face.position_mm(*right) - Eigen::Vector3d(-p.x(), p.y(), p.z())).norm(), 0.1) << name;
  }
  const auto height = [&](const char* name) { return face.position_mm(*face.find_landmark(name)).y(); };
  const std::vector<double> downwards{
      height("brow_inner_left"),   height("nose_bridge"), height("nose_tip"), height("lip_upper"),
      height("mouth_corner_left"), height("lip_lower"),   height("chin")};
  EXPECT_TRUE(std::is_sorted(downwards.rbegin(), downwards.rend()));
}

TEST(IctFace, NamesTheFilesThatAreMissing) {
  const test::TemporaryFolder folder;
  try {
    load_ict_face(folder.path());
    FAIL() << "loaded nothing";
  } catch (const UserError& error) {
    EXPECT_NE(std::string(error.what()).find("generic_neutral_mesh.obj"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("mouthSmile_L.obj"), std::string::npos) << error.what();
  }
}

TEST(IctFace, RefusesAnotherMesh) {
  const test::TemporaryFolder folder;
  std::vector<std::string> names = ict_shape_names();
  names.push_back("generic_neutral_mesh");
  for (const std::string& name : names) {
    std::ofstream(folder.path() / (name + ".obj")) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  }
  EXPECT_THROW(load_ict_face(folder.path()), UserError);
}

/// Rewrites the lines of a file.
void edit(const std::filesystem::path& path, const std::function<bool(std::string&)>& keeps) {
  std::ifstream in(path);
  std::string text;
  for (std::string line; std::getline(in, line);) {
    if (keeps(line)) text += line + "\n";
  }
  in.close();
  std::ofstream(path) << text;
}

std::string refusal_of(const std::filesystem::path& folder) {
  try {
    load_ict_face(folder);
  } catch (const UserError& error) {
    return error.what();
  }
  return "loaded";
}

TEST(IctFace, NamesTheFileThatIsDamaged) {
  RISORIUS_NEEDS_DATA(archive, kArchive);
  const test::TemporaryFolder folder;
  unpack(archive, folder.path());
  const auto at = folder.path() / "ict_facekit";
  bool is_first = true;
  edit(at / "browInnerUp_L.obj", [&](std::string& line) {
    if (line.starts_with("v ") && std::exchange(is_first, false)) line = "v 1e30 0 0";
    return true;
  });
  std::string refusal = refusal_of(at);
  EXPECT_NE(refusal.find("browInnerUp_L.obj"), std::string::npos) << refusal;
  EXPECT_NE(refusal.find("vertex 1 is at 1e+30"), std::string::npos) << refusal;
  int faces = 0;
  edit(at / "generic_neutral_mesh.obj", [&](std::string& line) { return !line.starts_with("f ") || ++faces <= 6000; });
  refusal = refusal_of(at);
  EXPECT_NE(refusal.find("generic_neutral_mesh.obj"), std::string::npos) << refusal;
  EXPECT_NE(refusal.find("triangles instead of 52220"), std::string::npos) << refusal;
}

void expect_fit(const FaceModel& face, const Neutral& neutral) {
  ASSERT_EQ(neutral.names.size(), 41u);
  const RigFitResult fit = fit_rig(face, neutral.names, neutral.position_mm, find_landmark_map("animface41"));
  std::printf("[ measured ] %s; worst landmark %.1f mm\n", fit.rig.source.c_str(), fit.largest_landmark_residual_mm);
  for (const std::string& au : fit.dropped_aus) std::printf("[ measured ] dropped %s\n", au.c_str());
  for (const std::string& warning : fit.warnings) std::printf("[ measured ] %s\n", warning.c_str());
  EXPECT_LT(fit.median_distance_mm, 8);
  EXPECT_GT(fit.scale, 0.9);
  EXPECT_LT(fit.scale, 1.4);
  EXPECT_EQ(fit.rig.marker_count(), 41u);
  EXPECT_EQ((fit.rig.stabiliser_weight.array() > 0).count(), 4);
  // Left is left, and the face looks forward: the marker on the left mouth corner lies left of the right one.
  const auto column = [&](const char* name) {
    return fit.rig.neutral_mm.col(std::find(neutral.names.begin(), neutral.names.end(), name) - neutral.names.begin());
  };
  EXPECT_GT(column("Mouth_Lend").x(), 20);
  EXPECT_LT(column("Mouth_Rend").x(), -20);
  EXPECT_GT(column("NoseHead").z(), column("Leye_Outside").z());
}

void expect_mirrored_is_refused(const FaceModel& face, Neutral neutral) {
  neutral.position_mm.row(0) *= -1;
  try {
    fit_rig(face, neutral.names, neutral.position_mm, find_landmark_map("animface41"));
    FAIL() << "fitted a mirrored face";
  } catch (const UserError& error) {
    EXPECT_NE(std::string(error.what()).find("mirrored"), std::string::npos) << error.what();
  }
}

void expect_wrong_map_is_refused(const FaceModel& face, const Neutral& neutral) {
  LandmarkMap map = find_landmark_map("animface41");
  std::swap(map.marker_of_landmark["chin"], map.marker_of_landmark["nose_tip"]);
  EXPECT_THROW(fit_rig(face, neutral.names, neutral.position_mm, map), UserError);
}

TEST(IctFace, LoadsAsPublishedAndFitsARealActorTheRightWayRound) {
  RISORIUS_NEEDS_DATA(archive, kArchive);
  const FaceModel face = load_archive(archive);
  expect_published_mesh(face);
  expect_vertex_order(face);
  expect_left_is_left(face);
  expect_plausible_motion(face);
  expect_landmarks_in_place(face);
  const Neutral neutral = animface_neutral(test::data_folder() / "animface" / "jaw.csv");
  expect_fit(face, neutral);
  expect_mirrored_is_refused(face, neutral);
  expect_wrong_map_is_refused(face, neutral);
}

}  // namespace
