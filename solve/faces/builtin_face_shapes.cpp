#include "solve/faces/builtin_face_shapes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

namespace risorius {
namespace {

/// The skin about (x, y) within the radii moves by `shift_mm`, and by the share `gather` of its way to the middle line.
struct Pull {
  double x_mm, y_mm, x_radius_mm, y_radius_mm;
  std::array<double, 3> shift_mm;
  double gather = 0;
};

enum class Sides : std::uint8_t { kBoth, kMiddle };

struct Shape {
  std::string_view au;
  Sides sides;
  std::array<Pull, 3> pulls;
  bool has_jaw = false;
};

// Left side (x > 0) for shapes with sides. Insertions, directions and amplitudes after the muscles of the FACS manual
// (Ekman, Friesen & Hager 2002): frontalis lifts the brow by 8 mm, zygomaticus the lip corner by 13 mm, and so on.
constexpr std::array kShapes = std::to_array<Shape>({
    // frontalis, inner and outer part
    {"AU1", Sides::kBoth, {{{14, 56, 30, 36, {0.5, 8, -1}}}}},
    {"AU2", Sides::kBoth, {{{48, 54, 32, 36, {1, 8, -2}}}}},
    // corrugator (in and down), procerus (down between the brows)
    {"AU4",
     Sides::kBoth,
     {{{22, 56, 34, 28, {-4, -5.5, 1.5}}, {46, 54, 24, 22, {-3, -2, 0}}, {4, 46, 18, 20, {-0.5, -3, 1}}}}},
    // orbicularis oculi: orbital part lifts the cheek and draws in the outer corner; palpebral part narrows the lids
    {"AU6", Sides::kBoth, {{{46, 8, 32, 28, {-1.5, 6, 2}}, {58, 40, 22, 22, {-3, -2, -1}}}}},
    {"AU7", Sides::kBoth, {{{30, 19, 26, 16, {-2, 3, 0.5}}, {31, 37, 22, 13, {0, -2.5, 0}}}}},
    // levator labii superioris alaeque nasi; it wrinkles the nose and draws the inner brow down
    {"AU9",
     Sides::kBoth,
     {{{12, 2, 20, 26, {-0.5, 6, 1.5}}, {8, 46, 18, 18, {-1, -3, 1}}, {10, -27, 18, 10, {0, 2.5, 0.5}}}}},
    // levator labii superioris
    {"AU10", Sides::kBoth, {{{13, -29, 22, 18, {0.5, 7, 1}}, {26, -10, 20, 20, {1, 4, 2}}}}},
    // zygomaticus major
    {"AU12", Sides::kBoth, {{{26, -38, 32, 28, {8, 9, -5}}, {44, -6, 30, 28, {1, 5, 3.5}}}}},
    // buccinator: the corner is drawn in against the teeth
    {"AU14", Sides::kBoth, {{{25, -38, 20, 18, {4, 0.5, -7}}, {46, -36, 24, 26, {-4, 0, -1}}}}},
    // depressor anguli oris, depressor labii inferioris
    {"AU15", Sides::kBoth, {{{25, -42, 28, 28, {1.5, -8, -2}}}}},
    {"AU16", Sides::kBoth, {{{12, -48, 20, 18, {1.5, -6.5, 1}}}}},
    // mentalis lifts the chin's boss and pushes the lower lip up and out
    {"AU17", Sides::kMiddle, {{{0, -72, 36, 26, {0, 7, 2.5}}, {0, -48, 28, 16, {0, 4, 3}}}}},
    // orbicularis oris: pucker, funnel
    {"AU18", Sides::kMiddle, {{{0, -38, 46, 32, {0, 0, 7}, 0.42}}}},
    // risorius and platysma
    {"AU20", Sides::kBoth, {{{27, -40, 38, 26, {8, -2, -4}}, {46, -46, 26, 30, {5, -3, -2}}}}},
    {"AU22",
     Sides::kMiddle,
     {{{0, -28, 32, 14, {0, 4.5, 6}}, {0, -49, 32, 16, {0, -5, 6.5}}, {0, -38, 40, 20, {0, 0, 2}, 0.12}}}},
    // orbicularis oris: lips pressed
    {"AU24", Sides::kBoth, {{{12, -30, 22, 9, {0.5, -3, -2}}, {12, -47, 22, 10, {0.5, 3.5, -2}}}}},
    {"AU27", Sides::kMiddle, {}, true},
    // the upper lid comes down
    {"AU45", Sides::kBoth, {{{31, 37, 20, 14, {0, -9, 1.5}}}}},
});

constexpr double kHingeYMm = 8, kHingeZMm = 15;  // the jaw's joint, before the ear
constexpr double kJawRadians = 0.25;             // 30 mm at the chin, 122 mm from the hinge
constexpr double kMouthYMm = -38;

double smooth_step(double t) noexcept {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * t * (t * (6 * t - 15) + 10);
}

/// Wendland's function C2: 1 at the middle, 0 with its first two derivatives from the radii on.
double weight_of(const Pull& pull, double x_mm, double y_mm) noexcept {
  if (pull.x_radius_mm <= 0) return 0;
  const double d = std::hypot((x_mm - pull.x_mm) / pull.x_radius_mm, (y_mm - pull.y_mm) / pull.y_radius_mm);
  if (d >= 1) return 0;
  const double rest = (1 - d) * (1 - d);
  return rest * rest * (4 * d + 1);
}

/// The share of the jaw's turn: below the mouth's line; the cheeks beside it stretch over a taller band than the lips.
double jaw_weight(const Eigen::Vector3d& p) noexcept {
  const double half_band_mm = 9 + 21 * smooth_step((std::abs(p.x()) - 12) / 30);
  return smooth_step((kMouthYMm + half_band_mm - p.y()) / (2 * half_band_mm));
}

Eigen::Vector3d jaw_displacement_mm(const Eigen::Vector3d& p) {
  const double weight = jaw_weight(p);
  if (weight == 0) return Eigen::Vector3d::Zero();
  const Eigen::Vector3d arm(p.x(), p.y() - kHingeYMm, p.z() - kHingeZMm);
  return weight * (Eigen::AngleAxisd(kJawRadians, Eigen::Vector3d::UnitX()) * arm - arm);
}

Eigen::Vector3d left_displacement_mm(const Shape& shape, const Eigen::Vector3d& p) {
  Eigen::Vector3d displacement = shape.has_jaw ? jaw_displacement_mm(p) : Eigen::Vector3d::Zero();
  for (const Pull& pull : shape.pulls) {
    const double weight = weight_of(pull, p.x(), p.y());
    displacement +=
        weight * Eigen::Vector3d(pull.shift_mm[0] - pull.gather * p.x(), pull.shift_mm[1], pull.shift_mm[2]);
  }
  return displacement;
}

struct Column {
  const Shape* shape;
  char side;  ///< 'L', 'R', or 0
};

const std::vector<Column>& columns() {
  static const std::vector<Column> all = [] {
    std::vector<Column> list;
    for (const Shape& shape : kShapes) {
      if (shape.sides == Sides::kBoth) {
        list.push_back({&shape, 'L'});
        list.push_back({&shape, 'R'});
      } else {
        list.push_back({&shape, 0});
      }
    }
    return list;
  }();
  return all;
}

}  // namespace

std::vector<std::string> builtin_au_names() {
  std::vector<std::string> names;
  for (const Column& column : columns()) {
    names.emplace_back(column.shape->au);
    if (column.side != 0) names.back() += column.side;
  }
  return names;
}

Eigen::Vector3d builtin_displacement_mm(std::size_t index, const Eigen::Vector3d& point_mm) {
  const Column& column = columns().at(index);
  const Eigen::Vector3d mirror(column.side == 'R' ? -1 : 1, 1, 1);
  const Eigen::Vector3d left_point_mm = mirror.cwiseProduct(point_mm);
  return mirror.cwiseProduct(left_displacement_mm(*column.shape, left_point_mm));
}

}  // namespace risorius
