#include "replay/picture/facial_creases.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "solve/rigs/au_name.h"

namespace risorius {
namespace {

constexpr double kReach = 4;   // widths, beyond which nothing shows
constexpr double kMiddle = 2;  // widths beyond the middle of the face, over which a line that begins there fades

std::vector<Crease> all_creases() {
  return {
      // Forehead: across its middle where only the inner brows rise, arched over the outer ones.
      {"AU1", {{0, 68}, {12, 68}, {24, 65}}, 1.9, 0.83},
      {"AU1", {{0, 75}, {12, 75.5}, {26, 72}}, 1.9, 0.83},
      {"AU1", {{0, 83}, {11, 83}, {22, 80}}, 1.9, 0.6},
      {"AU2", {{30, 70}, {43, 73}, {56, 68}}, 1.9, 0.83},
      {"AU2", {{28, 78}, {43, 81}, {56, 76}}, 1.9, 0.83},
      {"AU2", {{30, 86}, {42, 89}, {53, 85}}, 1.9, 0.6},
      // Between the brows: upright folds; across the root of the nose.
      {"AU4", {{4.5, 40}, {6, 50}, {8.5, 60}}, 1.7, 1},
      {"AU4", {{10, 50}, {12, 57}, {15, 63}}, 1.7, 0.52},
      {"AU4", {{0, 36}, {6, 36.5}}, 1.7, 0.52},
      {"AU9", {{0, 28}, {5, 28.5}, {9, 31}}, 1.4, 1.1},
      {"AU9", {{0, 33}, {5, 33.5}, {9, 36}}, 1.4, 1},
      {"AU9", {{4, 24}, {9, 19}, {13, 12}}, 1.4, 1},
      {"AU9", {{6, 28}, {12, 23}, {17, 16}}, 1.4, 0.85},
      {"AU9", {{15, 2}, {19, -6}, {23, -15}}, 2.2, 1.4},
      // Beside and below the eye.
      {"AU6", {{53, 34}, {60, 37}, {67, 42}}, 1.4, 0.72},
      {"AU6", {{54, 31}, {61, 31}, {69, 32}}, 1.4, 0.72},
      {"AU6", {{53, 28}, {60, 25}, {67, 20}}, 1.4, 0.72},
      {"AU6", {{17, 22}, {29, 15.5}, {44, 17}}, 1.9, 0.78},
      {"AU7", {{20, 23.5}, {31, 20}, {43, 23.5}}, 1.3, 0.75},
      // The nasolabial fold: deepest where AU10 and AU12 bend it, its lower end round the corner.
      {"AU10", {{15, 0}, {20, -9}, {25, -17}, {28, -24}}, 2.3, 1.5},
      {"AU12", {{16, -3}, {24, -12}, {32, -22}, {36.5, -33}, {36, -42}}, 2.4, 1.7},
      {"AU13", {{17, -4}, {24, -12}, {30, -20}}, 2.2, 0.9},
      {"AU14", {{31.5, -27}, {34.5, -33}, {33, -41}}, 1.9, 1.5},
      {"AU15", {{29, -35}, {31.5, -42}, {32, -51}}, 1.9, 1.2},
      {"AU16", {{0, -53}, {10, -52}, {19, -48}}, 2.3, 0.6},
      {"AU20", {{36, -25}, {40, -34}, {39.5, -45}}, 1.9, 1},
      {"AU20", {{42, -27}, {46, -36}, {45.5, -46}}, 1.9, 0.6},
      // Chin: the furrow below the lip and the puckered boss.
      {"AU17", {{0, -54}, {9, -55}, {17, -60}}, 2.2, 1.2},
      {"AU17", {{2, -64}, {6, -65}}, 1.8, 0.9},
      {"AU17", {{8, -68}, {12, -69}}, 1.8, 0.83},
      {"AU17", {{0, -70}, {5, -71}}, 1.8, 0.83},
      {"AU17", {{9, -62}, {12, -64}}, 1.7, 0.6},
      // Lips: fine lines across the reds where the ring draws together; pressed lips bulge above and below instead.
      {"AU18", {{3, -24}, {3, -31}}, 1.2, 0.33},
      {"AU18", {{9, -25}, {8, -31}}, 1.2, 0.33},
      {"AU18", {{15, -27}, {13, -32}}, 1.2, 0.28},
      {"AU18", {{4, -38}, {4, -44}}, 1.2, 0.33},
      {"AU18", {{10, -38}, {11, -43}}, 1.2, 0.28},
      {"AU23", {{3, -23}, {3.4, -29}}, 1, 0.39},
      {"AU23", {{9, -22.5}, {8, -29.5}}, 1, 0.39},
      {"AU23", {{14.5, -25}, {13, -31}}, 1, 0.39},
      {"AU23", {{3.5, -40}, {4, -47}}, 1, 0.39},
      {"AU23", {{9, -40}, {10.5, -46}}, 1, 0.39},
      {"AU24", {{0, -49}, {9, -48.5}, {18, -45}}, 2.3, 0.84},
      {"AU24", {{4, -20.5}, {12, -21.5}, {20, -26}}, 2.3, 0.6},
      {"AU28", {{0, -48}, {10, -47.5}, {19, -44}}, 2.3, 0.72},
  };
}

/// Distance to a polyline, and how far along it (0 to 1) the nearest point is.
std::pair<double, double> nearest_on(const std::vector<Eigen::Vector2d>& points, const Eigen::Vector2d& p) {
  double least = std::numeric_limits<double>::infinity(), at = 0;
  const auto segments = static_cast<double>(points.size() - 1);
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const Eigen::Vector2d way = points[i + 1] - points[i];
    const double t = std::clamp((p - points[i]).dot(way) / way.squaredNorm(), 0.0, 1.0);
    const double distance = (p - points[i] - t * way).norm();
    if (distance >= least) continue;
    least = distance;
    at = (static_cast<double>(i) + t) / segments;
  }
  return {least, at};
}

}  // namespace

std::span<const Crease> facial_creases() {
  static const std::vector<Crease> creases = all_creases();
  return creases;
}

CreaseShade::CreaseShade(const std::vector<std::string>& columns, double actor_per_face) {
  for (const std::string& column : columns) {
    const auto name = parse_au_name(column);
    if (!name) continue;
    const std::string au = "AU" + std::to_string(name->number);
    for (const Crease& crease : facial_creases()) {
      if (crease.au != au) continue;
      for (const double side : {1.0, -1.0}) {
        if ((side > 0 && name->side == AuSide::kRight) || (side < 0 && name->side == AuSide::kLeft)) continue;
        Line line{{}, {1e9, 1e9}, {-1e9, -1e9}, crease.width_mm * actor_per_face, crease.depth_mm * actor_per_face};
        for (const Eigen::Vector2d& p : crease.line) {
          line.points.emplace_back(actor_per_face * side * p.x(), actor_per_face * p.y());
          line.low = line.low.cwiseMin(line.points.back());
          line.high = line.high.cwiseMax(line.points.back());
        }
        line.low.array() -= kReach * line.width_mm;
        line.high.array() += kReach * line.width_mm;
        lines_.push_back(std::move(line));
      }
    }
  }
}

double CreaseShade::height_mm(double x_mm, double y_mm) const noexcept {
  const Eigen::Vector2d p(x_mm, y_mm);
  double height = 0;
  for (const Line& line : lines_) {
    if ((p.array() < line.low.array()).any() || (p.array() > line.high.array()).any()) continue;
    const auto [distance, at] = nearest_on(line.points, p);
    const double u = distance / line.width_mm;
    if (u >= kReach) continue;
    // Skin is pushed aside: what sinks in the middle stands up beside it.
    const double profile = std::exp(-0.5 * u * u) - 0.25 * std::exp(-0.125 * u * u);
    const auto soft = [](double s) { return s * s * (3 - 2 * s); };
    // Lines that begin in the middle of the face go on in their mirror image: where both are, they add up to one fold.
    const bool begins_in_middle = std::abs(line.points.front().x()) < 1e-9;
    const double inwards = line.points.back().x() > 0 ? p.x() : -p.x();
    const double begin = begins_in_middle ? std::clamp(0.5 + 0.5 * inwards / (kMiddle * line.width_mm), 0.0, 1.0)
                                          : std::min(1.0, 4 * at);
    const double end = std::min(1.0, 4 * (1 - at));
    height -= line.depth_mm * profile * soft(begin) * soft(end);
  }
  return height;
}

}  // namespace risorius
