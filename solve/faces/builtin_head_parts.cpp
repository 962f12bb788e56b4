#include "solve/faces/builtin_head_parts.h"

#include <array>
#include <cmath>

#include "solve/faces/builtin_head_surface.h"

namespace risorius {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kEyeSegments = 20;
// Rings about the gaze, degrees; pupil (4 mm) and iris (11.8 mm across) end between two narrow ones.
constexpr std::array<double, 10> kEyeRingsDegrees{9.4, 10.4, 19, 28.2, 30.0, 42, 55, 68, 80, 92};

void add_eyeball(HeadPartBuilder& builder) {
  using head::kEyeballMm, head::kEyeballRadiusMm;
  const auto add_both = [&](const Eigen::Vector3d& p) {
    const int left = builder.add(p, HeadPart::kEyeball, -1, true);
    const int right = builder.add({-p.x(), p.y(), p.z()}, HeadPart::kEyeball, -1, true);
    builder.pair(left, right);
    return left;
  };
  const int pole = add_both(kEyeballMm + Eigen::Vector3d(0, 0, kEyeballRadiusMm));
  std::vector<int> before;
  for (const double degrees : kEyeRingsDegrees) {
    const double angle = degrees * kPi / 180;
    std::vector<int> ring;
    for (int k = 0; k < kEyeSegments; ++k) {
      const double around = 2 * kPi * k / kEyeSegments;
      ring.push_back(add_both(kEyeballMm + kEyeballRadiusMm * Eigen::Vector3d(std::sin(angle) * std::cos(around),
                                                                              std::sin(angle) * std::sin(around),
                                                                              std::cos(angle))));
    }
    for (std::size_t k = 0; k < ring.size(); ++k) {
      const std::size_t next = (k + 1) % ring.size();
      if (before.empty()) {
        builder.left.emplace_back(pole, ring[k], ring[next]);
      } else {
        builder.left.emplace_back(before[k], ring[k], ring[next]);
        builder.left.emplace_back(before[k], ring[next], before[next]);
      }
    }
    before = ring;
  }
}

/// A bow of teeth: from the right to the left, two rows high, the crowns' borders as small waves.
void add_teeth(HeadPartBuilder& builder, bool is_upper) {
  constexpr int kHalf = 24, kRows = 4;
  const HeadPart part = is_upper ? HeadPart::kUpperTeeth : HeadPart::kLowerTeeth;
  const double half_width = is_upper ? 23 : 20, front_z = is_upper ? 87.5 : 86;
  const double bite_y = is_upper ? -36.5 : -38, root_y = is_upper ? -25.5 : -45;
  std::vector<std::vector<int>> rows;
  for (int row = 0; row < kRows; ++row) {
    std::vector<int> line;
    for (int k = -kHalf; k <= kHalf; ++k) {
      const double a = static_cast<double>(k) / kHalf, angle = a * 0.5 * kPi;
      const double wave = std::abs(std::sin(kPi * 7 * a)), depth = row == kRows - 1 ? 2 : 0;
      const double down = static_cast<double>(std::min(row, kRows - 2)) / (kRows - 2);
      const double y = root_y + (bite_y - root_y) * down + (is_upper ? 0.8 : -0.6) * (1 - wave) * down;
      const double z = front_z - 26 * (1 - std::cos(angle)) + 0.7 * wave - depth;
      line.push_back(builder.add({half_width * std::sin(angle), y, z}, part, -1, is_upper));
    }
    for (int k = 0; k <= 2 * kHalf; ++k) {
      builder.mesh->mirror_vertex[static_cast<std::size_t>(line[static_cast<std::size_t>(k)])] =
          line[static_cast<std::size_t>(2 * kHalf - k)];
    }
    rows.push_back(line);
  }
  for (std::size_t row = 0; row + 1 < rows.size(); ++row) {
    for (std::size_t k = kHalf; k < 2 * kHalf; ++k) {
      std::array<int, 4> q{rows[row][k], rows[row][k + 1], rows[row + 1][k + 1], rows[row + 1][k]};
      if (is_upper) std::swap(q[1], q[3]);
      builder.left.emplace_back(q[0], q[1], q[2]);
      builder.left.emplace_back(q[0], q[2], q[3]);
    }
  }
}

/// From each lip's edge around its inner side to the back of the mouth, and the wall between both.
void add_pocket(HeadPartBuilder& builder) {
  // Closed lips touch on a surface that rises inwards, so that nobody looks in between them.
  struct Step {
    double up_mm, apart_mm, back_mm;
  };
  constexpr std::array kSteps =
      std::to_array<Step>({{0.9, 0, 1.4}, {1, 1, 3}, {0, 4, 4.6}, {0, 10, 6.5}, {0, 13, 14}, {0, 8, 34}});
  std::vector<std::vector<int>> lines[2];
  for (const bool is_upper : {true, false}) {
    const std::vector<int>& edge = is_upper ? builder.mesh->upper_lip_edge : builder.mesh->lower_lip_edge;
    auto& own = lines[is_upper ? 0 : 1];
    own.push_back(edge);
    for (const Step& step : kSteps) {
      std::vector<int> line{edge.front()};
      for (std::size_t k = 1; k + 1 < edge.size(); ++k) {
        const Eigen::Vector3d p = (*builder.points)[static_cast<std::size_t>(edge[k])];
        const double taper = std::sqrt(1 - std::pow(p.x() / (head::kMouthCornerXMm + 0.5), 2));
        const Eigen::Vector3d offset(0, taper * (step.up_mm + (is_upper ? 1 : -1) * step.apart_mm),
                                     -step.back_mm * (0.25 + 0.75 * taper));
        line.push_back(builder.add(p + offset, HeadPart::kMouthPocket, edge[k], is_upper));
      }
      line.push_back(edge.back());
      for (std::size_t k = 1; k + 1 < line.size(); ++k) {
        builder.mesh->mirror_vertex[static_cast<std::size_t>(line[k])] = line[line.size() - 1 - k];
      }
      own.push_back(line);
    }
  }
  const auto join = [&](const std::vector<int>& a, const std::vector<int>& b, bool flip) {
    for (std::size_t k = a.size() / 2; k + 1 < a.size(); ++k) {
      std::array<int, 4> q{a[k], a[k + 1], b[k + 1], b[k]};
      if (flip) std::swap(q[1], q[3]);
      if (q[0] != q[1] && q[1] != q[2] && q[0] != q[2]) builder.left.emplace_back(q[0], q[1], q[2]);
      if (q[0] != q[3] && q[2] != q[3] && q[0] != q[2]) builder.left.emplace_back(q[0], q[2], q[3]);
    }
  };
  for (std::size_t s = 0; s + 1 < lines[0].size(); ++s) {
    join(lines[0][s], lines[0][s + 1], true);
    join(lines[1][s], lines[1][s + 1], false);
  }
  join(lines[0].back(), lines[1].back(), true);
}

}  // namespace

int HeadPartBuilder::add(const Eigen::Vector3d& p, HeadPart part, int anchor, bool is_above_mouth) {
  const int index = static_cast<int>(points->size());
  points->push_back(p);
  mesh->part.push_back(part);
  mesh->is_above_mouth.push_back(is_above_mouth);
  mesh->is_above_eye.push_back(false);
  mesh->mirror_vertex.push_back(index);
  mesh->anchor.push_back(anchor < 0 ? index : anchor);
  return index;
}

void HeadPartBuilder::pair(int left_vertex, int right_vertex) {
  mesh->mirror_vertex[static_cast<std::size_t>(left_vertex)] = right_vertex;
  mesh->mirror_vertex[static_cast<std::size_t>(right_vertex)] = left_vertex;
}

void add_inner_parts(HeadPartBuilder& builder) {
  add_eyeball(builder);
  add_teeth(builder, true);
  add_teeth(builder, false);
  add_pocket(builder);
}

}  // namespace risorius
