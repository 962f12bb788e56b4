#include "solve/faces/builtin_landmarks.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>

#include "capture/check.h"
#include "solve/faces/builtin_head_surface.h"

namespace risorius {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180;
/// Just off an edge, on its own side: a landmark on the edge of a lid or lip.
constexpr double kOffEdgeMm = 0.4;

/// A ray from outside to the skin: from the front at (x, y), or from around the head at an angle to the left and y.
struct Spot {
  double x_or_degrees, y;
  bool is_around = false;
};

struct Mark {
  std::string left, right;  ///< equal: in the middle
  Spot spot;
};

Spot front(double x, double y) { return {x, y}; }
Spot around(double degrees, double y) { return {degrees, y, true}; }
Spot upper_lid(double x) { return {x, upper_lid_y_mm(x) + kOffEdgeMm}; }
Spot lower_lid(double x) { return {x, lower_lid_y_mm(x) - kOffEdgeMm}; }
Spot upper_lip(double x) { return {x, lip_line_y_mm(x) + kOffEdgeMm}; }
Spot lower_lip(double x) { return {x, lip_line_y_mm(x) - kOffEdgeMm}; }
Spot upper_border(double x) { return {x, upper_lip_border_y_mm(x)}; }
Spot lower_border(double x) { return {x, lower_lip_border_y_mm(x)}; }
const Spot kEyeInner{head::kEyeInnerXMm - 0.5, head::kEyeInnerYMm},
    kEyeOuter{head::kEyeOuterXMm + 0.5, head::kEyeOuterYMm};
const Spot kMouthCorner{head::kMouthCornerXMm + 0.6, -35};

SurfacePoint first_hit(const HeadMesh& mesh, const Eigen::Vector3d& from, const Eigen::Vector3d& direction) {
  SurfacePoint best;
  double nearest = std::numeric_limits<double>::max();
  for (int t = 0; t < mesh.skin_triangle_count / 2; ++t) {  // the left half
    const Eigen::Vector3i v = mesh.triangles.col(t);
    const Eigen::Vector3d a = mesh.vertices_mm.col(v[0]);
    const Eigen::Vector3d ab = mesh.vertices_mm.col(v[1]) - a, ac = mesh.vertices_mm.col(v[2]) - a;
    const Eigen::Vector3d normal = ab.cross(ac);
    const double facing = -normal.dot(direction);
    if (facing <= 0) continue;
    const double distance = normal.dot(from - a) / facing;
    if (distance >= nearest) continue;
    const Eigen::Vector3d inside = from + distance * direction - a;
    const double v1 = normal.dot(inside.cross(ac)) / normal.squaredNorm();
    const double v2 = normal.dot(ab.cross(inside)) / normal.squaredNorm();
    constexpr double kTolerance = 1e-9;
    if (v1 < -kTolerance || v2 < -kTolerance || v1 + v2 > 1 + kTolerance) continue;
    nearest = distance;
    Eigen::Vector3d weights(1 - v1 - v2, v1, v2);
    // On an edge exactly: the middle line stays the middle line.
    weights = weights.unaryExpr([](double w) { return w < 1e-7 ? 0 : w; });
    best = {t, weights / weights.sum()};
  }
  RISORIUS_CHECK(best.triangle >= 0);
  return best;
}

SurfacePoint place_of(const HeadMesh& mesh, const Spot& spot) {
  if (!spot.is_around) return first_hit(mesh, {spot.x_or_degrees, spot.y, 300}, -Eigen::Vector3d::UnitZ());
  const double angle = spot.x_or_degrees * kDegree;
  const Eigen::Vector3d outward(std::sin(angle), 0, std::cos(angle));
  return first_hit(mesh, Eigen::Vector3d(0, spot.y, 10) + 300 * outward, -outward);
}

SurfacePoint mirrored(const HeadMesh& mesh, const SurfacePoint& left) {
  const Eigen::Vector3d& w = left.barycentric;
  return {mesh.mirror_triangle[static_cast<std::size_t>(left.triangle)], {w[0], w[2], w[1]}};
}

Mark middle(std::string name, Spot spot) { return {name, name, spot}; }

std::vector<Mark> rig_landmarks() {
  return {middle("nose_bridge", front(0, 37)),
          middle("nose_tip", front(0, -1.5)),
          middle("lip_upper", front(0, -26)),
          middle("lip_lower", front(0, -44.5)),
          middle("chin", front(0, -78)),
          {"brow_inner_left", "brow_inner_right", front(12, 53)},
          {"brow_middle_left", "brow_middle_right", front(34, 57)},
          {"brow_outer_left", "brow_outer_right", front(56, 51)},
          {"eye_inner_left", "eye_inner_right", kEyeInner},
          {"eye_outer_left", "eye_outer_right", kEyeOuter},
          {"mouth_corner_left", "mouth_corner_right", kMouthCorner}};
}

std::vector<Mark> iemocap55() {
  std::vector<Mark> marks{middle("CH2", front(0, -78)),    middle("FH2", front(0, 90)),
                          middle("MH", front(0, 108)),     middle("MNOSE", front(0, 37)),
                          middle("TNOSE", front(0, -1.5)), middle("Mou3", front(0, -26)),
                          middle("Mou7", front(0, -44.5))};
  const auto both = [&](const char* left, const char* right, double x, double y) {
    marks.push_back({left, right, front(x, y)});
  };
  both("CH3", "CH1", 16, -73), both("FH3", "FH1", 32, 88);
  both("LC1", "RC1", 22, 12), both("LC2", "RC2", 41, 13), both("LC3", "RC3", 57, 10), both("LC4", "RC4", 27, -10);
  both("LC5", "RC5", 44, -10), both("LC6", "RC6", 56, -16), both("LC7", "RC7", 44, -36), both("LC8", "RC8", 38, -56);
  both("LLID", "RLID", 31, 38), both("LNSTRL", "RNSTRL", 16, -6);
  both("LBM0", "RBM0", 9, 45), both("LBM1", "RBM1", 21, 46.5), both("LBM2", "RBM2", 37, 48),
      both("LBM3", "RBM3", 52, 43);
  both("LBRO1", "RBRO1", 12, 53), both("LBRO2", "RBRO2", 26, 57), both("LBRO3", "RBRO3", 42, 58),
      both("LBRO4", "RBRO4", 56, 51);
  both("Mou5", "Mou1", kMouthCorner.x_or_degrees, kMouthCorner.y), both("Mou4", "Mou2", 13, -27.5),
      both("Mou6", "Mou8", 13, -43), both("LHD", "RHD", 48, 104);
  return marks;
}

std::vector<Mark> animface41() {
  std::vector<Mark> marks{middle("ForeHead_M", front(0, 90)), middle("Eyebrow_Center", front(0, 51)),
                          middle("NoseTop", front(0, 37)),    middle("NoseHead", front(0, -1.5)),
                          middle("Mouth_Up", front(0, -26)),  middle("Mouth_Down", front(0, -44)),
                          middle("Chin", front(0, -76))};
  const auto both = [&](const std::string& left, const std::string& right, double x, double y) {
    marks.push_back({left, right, front(x, y)});
  };
  both("ForeHead_L", "ForeHead_R", 32, 88);
  for (const auto& [name, x, y] : {std::tuple{"Inside", 12.0, 52.0}, {"M", 34.0, 56.0}, {"Outside", 54.0, 51.0}})
    both(std::string("Leyebrow_") + name, std::string("Reyebrow_") + name, x, y);
  for (const auto& [name, x, y] :
       {std::tuple{"Up", 31.0, 39.0}, {"Down", 31.0, 22.5}, {"Inside", 14.5, 29.0}, {"Outside", 48.0, 31.5}})
    both(std::string("Leye_") + name, std::string("Reye_") + name, x, y);
  for (const auto& [name, x, y] : {std::tuple{"Up", 40.0, 12.0}, {"Down", 38.0, -22.0}, {"Outside", 56.0, -4.0}})
    both(std::string("Lcheek_") + name, std::string("Rcheek_") + name, x, y);
  both("NoseHead_L", "NoseHead_R", 15.5, -6);
  both("Mouth_UpL1", "Mouth_UpR1", 12, -27.5), both("Mouth_Lend", "Mouth_Rend", 26.5, -35);
  both("Mouth_DownL", "Mouth_DownR", 12, -43);
  both("Chin_L1", "Chin_R1", 17, -72), both("Chin_L2", "Chin_R2", 36, -60);
  return marks;
}

std::vector<Mark> bu4dfe83() {
  std::vector<Mark> marks;
  const auto sided = [&](const char* group, const std::vector<Spot>& spots) {
    for (std::size_t k = 0; k < spots.size(); ++k) {
      const std::string name = group + std::string("_") + std::to_string(k + 1);
      marks.push_back({"left_" + name, "right_" + name, spots[k]});
    }
  };
  // From the outer corner over the upper lid to the inner corner and back below; brows likewise.
  sided("eye", {kEyeOuter, upper_lid(39), upper_lid(31), upper_lid(22), kEyeInner, lower_lid(23), lower_lid(31),
                lower_lid(39)});
  sided("brow", {front(57, 47.5), front(47, 56), front(37, 58.5), front(25, 56), front(13, 53.5), front(10, 51),
                 front(13, 48.5), front(24, 50.5), front(37, 53), front(47, 51.5)});
  // Rings that run from the right over the top to the left and back: number k and its image n - k.
  const auto ring = [&](const std::string& group, const std::vector<std::pair<int, int>>& numbers,
                        const std::vector<Spot>& spots) {
    for (std::size_t k = 0; k < spots.size(); ++k) {
      marks.push_back({group + std::to_string(numbers[k].first), group + std::to_string(numbers[k].second), spots[k]});
    }
  };
  // nose_1..12 from the right of the bridge down, around the base, up on the left.
  ring("nose_", {{12, 1}, {11, 2}, {10, 3}, {9, 4}, {8, 5}, {7, 6}},
       {front(9, 33), front(11, 16), front(16, -2), front(16.5, -8), front(10, -12.5), front(3.5, -13)});
  ring("mouth_outer_", {{7, 1}, {6, 2}, {5, 3}, {4, 4}, {8, 12}, {9, 11}, {10, 10}},
       {kMouthCorner, upper_border(14), upper_border(5), upper_border(0), lower_border(16), lower_border(8),
        lower_border(0)});
  ring("mouth_inner_", {{5, 1}, {4, 2}, {3, 3}, {6, 8}, {7, 7}},
       {upper_lip(22), upper_lip(10), upper_lip(0), lower_lip(10), lower_lip(0)});
  ring("contour_", {{15, 1}, {14, 2}, {13, 3}, {12, 4}, {11, 5}, {10, 6}, {9, 7}, {8, 8}},
       {around(74, 32), around(73, 12), around(71, -8), around(66, -28), around(57, -48), around(42, -63),
        around(22, -75), front(0, -80)});
  return marks;
}

std::vector<Mark> ibug68() {
  std::vector<Mark> marks;
  const auto add = [&](int left, int right, const Spot& spot) {
    marks.push_back({std::to_string(left), std::to_string(right), spot});
  };
  add(16, 0, around(76, 34)), add(15, 1, around(75, 16)), add(14, 2, around(73, -2)), add(13, 3, around(69, -22));
  add(12, 4, around(62, -40)), add(11, 5, around(52, -56)), add(10, 6, around(37, -68)), add(9, 7, around(19, -77));
  add(8, 8, front(0, -80));
  add(22, 21, front(12, 51)), add(23, 20, front(23, 54)), add(24, 19, front(34, 56.5)), add(25, 18, front(46, 55));
  add(26, 17, front(56, 48));
  add(27, 27, front(0, 37)), add(28, 28, front(0, 24)), add(29, 29, front(0, 11)), add(30, 30, front(0, -1.5));
  add(35, 31, front(14, -10)), add(34, 32, front(6, -13)), add(33, 33, front(0, -13.5));
  add(42, 39, kEyeInner), add(43, 38, upper_lid(25.5)), add(44, 37, upper_lid(36.5)), add(45, 36, kEyeOuter);
  add(46, 41, lower_lid(36.5)), add(47, 40, lower_lid(25.5));
  add(54, 48, kMouthCorner), add(53, 49, upper_border(15)), add(52, 50, upper_border(5.5)),
      add(51, 51, upper_border(0));
  add(55, 59, lower_border(17)), add(56, 58, lower_border(8)), add(57, 57, lower_border(0));
  add(64, 60, upper_lip(22.5)), add(63, 61, upper_lip(9)), add(62, 62, upper_lip(0));
  add(65, 67, lower_lip(9)), add(66, 66, lower_lip(0));
  return marks;
}

}  // namespace

void add_builtin_landmarks(const HeadMesh& mesh, FaceParts& parts) {
  const auto place_all = [&](const std::vector<Mark>& marks, const auto& add) {
    for (const Mark& mark : marks) {
      const SurfacePoint left = place_of(mesh, mark.spot);
      add(mark.left, left);
      if (mark.right != mark.left) add(mark.right, mirrored(mesh, left));
    }
  };
  place_all(rig_landmarks(),
            [&](const std::string& name, const SurfacePoint& place) { parts.landmarks.emplace(name, place); });
  const auto add_layout = [&](const char* name, const std::vector<Mark>& marks) {
    std::vector<NamedPlace>& layout = parts.layouts[name];
    place_all(marks, [&](const std::string& mark, const SurfacePoint& place) { layout.push_back({mark, place}); });
  };
  add_layout("iemocap55", iemocap55());
  add_layout("animface41", animface41());
  add_layout("bu4dfe83", bu4dfe83());
  add_layout("ibug68", ibug68());
}

}  // namespace risorius
