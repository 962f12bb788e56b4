#include "solve/faces/builtin_face.h"

#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>

#include "capture/check.h"
#include "solve/faces/builtin_face_shapes.h"

namespace risorius {
namespace {

constexpr int kColumns = 45;  // odd: the middle column is the mirror plane
constexpr double kLowestMm = -95, kRowStepMm = 3;
constexpr int kRows = 71;
constexpr double kRoundness = 2.5;  // exponent of a horizontal section; 2 would be an ellipse, a face is flatter

/// A horizontal section of the head without nose, eyes, lips and chin.
struct Section {
  double y_mm, half_width_mm, depth_mm;
};

constexpr std::array kSections = std::to_array<Section>({{-110, 16, 66},
                                                         {-95, 27, 80},
                                                         {-80, 40, 91},
                                                         {-60, 52, 96},
                                                         {-35, 62, 98},
                                                         {0, 69, 97},
                                                         {30, 72, 95},
                                                         {60, 71, 99},
                                                         {85, 65, 94},
                                                         {105, 52, 79},
                                                         {115, 42, 68},
                                                         {125, 28, 54}});

/// A swelling (or hollow) of the face in z; with x > 0 also its mirror image.
struct Bump {
  double x_mm, y_mm, x_radius_mm, y_radius_mm, height_mm;
};

constexpr std::array kBumps = std::to_array<Bump>({
    {0, 30, 8, 14, 8},
    {0, 14, 9, 12, 13},
    {0, -3, 11, 9, 21},
    {13, -8, 8, 7, 8},  // nose, wings
    {28, 53, 22, 9, 5},
    {0, 50, 12, 8, 4},  // brow ridge
    {31, 31, 15, 10, -12},
    {31, 31, 11, 7, 7},  // sockets, eyes
    {44, 4, 18, 16, 6},
    {0, -28, 26, 14, 8},  // cheekbones, upper jaw
    {0, -31, 18, 4, 5},
    {0, -46, 16, 4.5, 6},
    {0, -38, 24, 3.5, -4},  // lips and their line
    {0, -58, 20, 6, -4},
    {0, -73, 16, 12, 10},  // below the lip, chin
});

struct Spot {
  std::string_view name;
  double x_mm, y_mm;
};

// Spots with x > 0 and their mirror images: {left name, right name}.
struct SpotPair {
  std::string_view left, right;
  double x_mm, y_mm;
};

constexpr std::array kMiddleMarkers = std::to_array<Spot>({{"CH2", 0, -78},
                                                           {"FH2", 0, 90},
                                                           {"MH", 0, 108},
                                                           {"MNOSE", 0, 40},
                                                           {"TNOSE", 0, -3},
                                                           {"Mou3", 0, -28},
                                                           {"Mou7", 0, -49}});

constexpr std::array kPairedMarkers = std::to_array<SpotPair>({
    {"CH3", "CH1", 16, -74},    {"FH3", "FH1", 32, 84},     {"LC1", "RC1", 24, 14},     {"LC2", "RC2", 42, 16},
    {"LC3", "RC3", 58, 12},     {"LC4", "RC4", 26, -8},     {"LC5", "RC5", 44, -8},     {"LC6", "RC6", 58, -16},
    {"LC7", "RC7", 46, -36},    {"LC8", "RC8", 38, -58},    {"LLID", "RLID", 31, 37},   {"LNSTRL", "RNSTRL", 15, -9},
    {"LBM0", "RBM0", 9, 47},    {"LBM1", "RBM1", 22, 49},   {"LBM2", "RBM2", 38, 49},   {"LBM3", "RBM3", 52, 44},
    {"LBRO1", "RBRO1", 12, 58}, {"LBRO2", "RBRO2", 26, 62}, {"LBRO3", "RBRO3", 42, 60}, {"LBRO4", "RBRO4", 56, 52},
    {"Mou5", "Mou1", 25, -38},  {"Mou4", "Mou2", 13, -29},  {"Mou6", "Mou8", 13, -47},  {"LHD", "RHD", 48, 100},
});

constexpr std::array kMiddleLandmarks = std::to_array<Spot>(
    {{"nose_bridge", 0, 40}, {"nose_tip", 0, -3}, {"lip_upper", 0, -28}, {"lip_lower", 0, -49}, {"chin", 0, -78}});

constexpr std::array kPairedLandmarks = std::to_array<SpotPair>({
    {"brow_inner_left", "brow_inner_right", 12, 58},
    {"brow_middle_left", "brow_middle_right", 34, 61},
    {"brow_outer_left", "brow_outer_right", 56, 52},
    {"eye_inner_left", "eye_inner_right", 18, 31},
    {"eye_outer_left", "eye_outer_right", 44, 32},
    {"mouth_corner_left", "mouth_corner_right", 25, -38},
});

constexpr std::array<std::string_view, 7> kStabilisers{"FH1", "FH2", "FH3", "MH", "MNOSE", "LHD", "RHD"};

/// Catmull-Rom through four values at their own heights, between the middle two.
double cubic(const std::array<double, 4>& y, const std::array<double, 4>& v, double at) {
  const double width = y[2] - y[1], t = (at - y[1]) / width;
  const double slope1 = width * (v[2] - v[0]) / (y[2] - y[0]), slope2 = width * (v[3] - v[1]) / (y[3] - y[1]);
  const double t2 = t * t, t3 = t2 * t;
  return (2 * t3 - 3 * t2 + 1) * v[1] + (t3 - 2 * t2 + t) * slope1 + (3 * t2 - 2 * t3) * v[2] + (t3 - t2) * slope2;
}

Section section_at(double y_mm) {
  std::size_t i = 1;
  while (i + 3 < kSections.size() && kSections[i + 1].y_mm < y_mm) ++i;
  std::array<double, 4> y{}, width{}, depth{};
  for (std::size_t k = 0; k < 4; ++k) {
    const Section& section = kSections[i - 1 + k];
    y[k] = section.y_mm, width[k] = section.half_width_mm, depth[k] = section.depth_mm;
  }
  return {y_mm, cubic(y, width, y_mm), cubic(y, depth, y_mm)};
}

double relief_mm(double x_mm, double y_mm) {
  double relief = 0;
  const auto add = [&](const Bump& bump, double centre_mm) {
    const double u = (x_mm - centre_mm) / bump.x_radius_mm, v = (y_mm - bump.y_mm) / bump.y_radius_mm;
    relief += bump.height_mm * std::exp(-0.5 * (u * u + v * v));
  };
  for (const Bump& bump : kBumps) {
    add(bump, bump.x_mm);
    if (bump.x_mm != 0) add(bump, -bump.x_mm);
  }
  return relief;
}

/// The head's surface at `across` = x / half width, -1 to 1.
Eigen::Vector3d surface_mm(double across, double y_mm) {
  const Section section = section_at(y_mm);
  const double x_mm = section.half_width_mm * across;
  const double front = std::pow(1 - std::pow(std::abs(across), kRoundness), 1 / kRoundness);
  return {x_mm, y_mm, section.depth_mm * front + relief_mm(std::abs(x_mm), y_mm)};
}

/// Column by column from right to left, row by row upwards. The right half is the mirror image of the left, bit for
/// bit.
Eigen::Matrix3Xd build_vertices() {
  Eigen::Matrix3Xd vertices(3, kRows * kColumns);
  for (int row = 0; row < kRows; ++row) {
    for (int column = kColumns / 2; column < kColumns; ++column) {
      const double angle = 0.5 * 3.14159265358979323846 * (column - kColumns / 2) / (kColumns / 2);
      const double across = column == kColumns - 1 ? 1 : std::sin(angle);
      const Eigen::Vector3d left = surface_mm(across, kLowestMm + kRowStepMm * row);
      vertices.col(row * kColumns + column) = left;
      vertices.col(row * kColumns + kColumns - 1 - column) =
          Eigen::Vector3d(column == kColumns / 2 ? 0 : -left.x(), left.y(), left.z());
    }
  }
  return vertices;
}

/// Two triangles per cell; the diagonals mirror, too.
Eigen::Matrix3Xi build_triangles() {
  Eigen::Matrix3Xi triangles(3, 2 * (kRows - 1) * (kColumns - 1));
  Eigen::Index next = 0;
  for (int row = 0; row + 1 < kRows; ++row) {
    for (int column = 0; column + 1 < kColumns; ++column) {
      const int a = row * kColumns + column, b = a + 1, c = b + kColumns, d = a + kColumns;
      const bool is_left = column >= kColumns / 2;
      triangles.col(next++) = is_left ? Eigen::Vector3i(a, b, c) : Eigen::Vector3i(a, b, d);
      triangles.col(next++) = is_left ? Eigen::Vector3i(a, c, d) : Eigen::Vector3i(b, c, d);
    }
  }
  return triangles;
}

SurfacePoint place_at(const SurfaceTree& skin, double x_mm, double y_mm) {
  const double across = x_mm / section_at(y_mm).half_width_mm;
  return skin.closest_to(surface_mm(across, y_mm)).place;
}

/// Places are found on the left and mirrored, so that they are symmetric even where the closest triangle is a tie.
SurfacePoint mirrored(const SurfacePoint& left) {
  const int cell = left.triangle / 2, row = cell / (kColumns - 1), column = cell % (kColumns - 1);
  const int other = 2 * (row * (kColumns - 1) + kColumns - 2 - column);
  const Eigen::Vector3d& w = left.barycentric;
  // Left cell: (a b c) and (a c d). Mirrored, a and b change places, and c and d: (b a d) = (a b d), (b d c) = (b c d).
  if (left.triangle % 2 == 0) return {other, {w[1], w[0], w[2]}};
  return {other + 1, {w[0], w[2], w[1]}};
}

template <class Add>
void place_all(const SurfaceTree& skin, const auto& middle, const auto& paired, const Add& add) {
  for (const Spot& spot : middle) add(spot.name, place_at(skin, spot.x_mm, spot.y_mm));
  for (const SpotPair& pair : paired) {
    const SurfacePoint left = place_at(skin, pair.x_mm, pair.y_mm);
    add(pair.left, left);
    add(pair.right, mirrored(left));
  }
}

}  // namespace

FaceModel builtin_face() {
  FaceParts parts;
  parts.name = "builtin";
  parts.vertices_mm = build_vertices();
  parts.triangles = build_triangles();
  parts.skin_triangle_count = static_cast<int>(parts.triangles.cols());
  const SurfaceTree skin(parts.vertices_mm, parts.triangles, parts.skin_triangle_count);
  std::vector<NamedPlace>& layout = parts.layouts[kBuiltinLayout];
  place_all(skin, kMiddleMarkers, kPairedMarkers, [&](std::string_view name, const SurfacePoint& place) {
    layout.push_back({std::string(name), place});
  });
  place_all(skin, kMiddleLandmarks, kPairedLandmarks,
            [&](std::string_view name, const SurfacePoint& place) { parts.landmarks.emplace(name, place); });
  const std::vector<std::string> names = builtin_au_names();
  for (std::size_t k = 0; k < names.size(); ++k) {
    FaceAu au{names[k], Eigen::Matrix3Xd(3, parts.vertices_mm.cols())};
    for (Eigen::Index v = 0; v < parts.vertices_mm.cols(); ++v) {
      au.displacement_mm.col(v) = builtin_displacement_mm(k, parts.vertices_mm.col(v));
    }
    parts.aus.push_back(std::move(au));
  }
  return FaceModel(std::move(parts));
}

Rig builtin_rig_of(const FaceModel& builtin) {
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
    RigAu au{shape.name, Eigen::Matrix3Xd(3, marker_count), shape.upper_bound};
    for (Eigen::Index m = 0; m < marker_count; ++m) {
      au.displacement_mm.col(m) = builtin.at(shape.displacement_mm, (*layout)[static_cast<std::size_t>(m)].place);
    }
    rig.aus.push_back(std::move(au));
  }
  return rig;
}

Rig builtin_rig() { return builtin_rig_of(builtin_face()); }

}  // namespace risorius
