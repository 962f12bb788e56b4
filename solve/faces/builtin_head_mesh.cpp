#include "solve/faces/builtin_head_mesh.h"

#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "solve/faces/builtin_head_parts.h"
#include "solve/faces/builtin_head_surface.h"
#include "solve/faces/smooth_shapes.h"

namespace risorius {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// A stretch of rows or columns: so many equal cells up to a place.
struct Stretch {
  double to;
  int cells;
};

// Densest at lids and lips, where the face moves most.
constexpr double kLowestRowMm = -165;
constexpr std::array kRowStretches = std::to_array<Stretch>({{-105, 4},
                                                             {-84, 7},
                                                             {-50, 13},
                                                             {-44, 4},
                                                             {head::kMouthYMm, 9},
                                                             {-26, 8},
                                                             {-16, 5},
                                                             {-4, 9},
                                                             {18, 8},
                                                             {24, 4},
                                                             {head::kEyeSlitYMm, 5},
                                                             {38, 6},
                                                             {46, 5},
                                                             {62, 9},
                                                             {97, 8},
                                                             {134, 6}});
constexpr std::array kFrontColumns =
    std::to_array<Stretch>({{head::kEyeInnerXMm, 9}, {head::kMouthCornerXMm, 6}, {head::kEyeOuterXMm, 12}, {53, 4}});
constexpr std::array kSideColumnsDegrees = std::to_array<Stretch>({{80, 5}, {112, 7}, {180, 5}});
constexpr double kFirstSideDegrees = 49.2;  // where x = 53 on a front half width of 68.5 at roundness 2.3

template <std::size_t N>
std::vector<double> places_of(double first, const std::array<Stretch, N>& stretches) {
  std::vector<double> places{first};
  for (const Stretch& stretch : stretches) {
    const double from = places.back();
    for (int k = 1; k <= stretch.cells; ++k) places.push_back(from + (stretch.to - from) * k / stretch.cells);
  }
  return places;
}

/// The rows' shift at the eye and at the mouth: the slit's edges lie where lids and lips do, and the rows beyond share.
double row_shift_mm(double x, double row_y, bool is_above_slit) noexcept {
  const double above_eye = row_y - head::kEyeSlitYMm;
  const bool is_upper = above_eye > 0 || (above_eye == 0 && is_above_slit);
  const double lid = (is_upper ? upper_lid_y_mm(x) : lower_lid_y_mm(x)) - head::kEyeSlitYMm;
  double shift = lid * std::pow(1 - std::min(1.0, std::abs(above_eye) / (is_upper ? 22 : 18)), 1.6);
  const double beside = smooth_between(44, 26, x);
  const double lip = lip_line_y_mm(x) - height_on_row_mm(x, head::kMouthYMm);
  shift += beside * lip * std::pow(1 - std::min(1.0, std::abs(row_y - head::kMouthYMm) / 16), 2);
  return shift;
}

class Builder {
 public:
  Builder()
      : rows_(places_of(kLowestRowMm, kRowStretches)),
        front_(places_of(0, kFrontColumns)),
        side_(places_of(kFirstSideDegrees, kSideColumnsDegrees)),
        half_(static_cast<int>(front_.size() + side_.size()) - 2),
        ring_(2 * half_) {
    eye_row_ = row_at(head::kEyeSlitYMm);
    mouth_row_ = row_at(head::kMouthYMm);
    eye_inner_ = kFrontColumns[0].cells;
    mouth_corner_ = eye_inner_ + kFrontColumns[1].cells;
    eye_outer_ = mouth_corner_ + kFrontColumns[2].cells;
  }

  HeadMesh build() {
    add_grid();
    add_slit_edges();
    add_skin_triangles();
    collect_edges();
    add_lid_rims();
    mesh_.skin_triangle_count = 2 * static_cast<int>(left_.size());
    add_inner_parts(parts_);
    finish();
    return std::move(mesh_);
  }

 private:
  int row_at(double y) const {
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      if (std::abs(rows_[r] - y) < 1e-9) return static_cast<int>(r);
    }
    return -1;
  }

  /// Column 0 is the middle of the face, half_ the middle of the back; left between, right beyond.
  int mirror_column(int column) const { return (ring_ - column) % ring_; }
  int vertex(int row, int column) const { return row * ring_ + (column + ring_) % ring_; }
  int mirrored(int v) const { return mesh_.mirror_vertex[static_cast<std::size_t>(v)]; }

  Eigen::Vector3d point(int row, int column, bool is_above_slit) const {
    const double row_y = rows_[static_cast<std::size_t>(row)];
    if (column >= static_cast<int>(front_.size())) {
      const double degrees = side_[static_cast<std::size_t>(column) - front_.size() + 1];
      if (degrees >= 90) return back_of_head_mm(degrees * kPi / 180, row_y);
      const double x = head_half_width_mm(row_y) * std::pow(std::sin(degrees * kPi / 180), 2 / 2.3);
      return front_of_head_mm(x, row_y);
    }
    const double chart_x = front_[static_cast<std::size_t>(column)];
    // Columns keep their x on the face's front and fan in towards the sides, the neck and the crown.
    const double scale = head_half_width_mm(row_y) / head::kFrontHalfWidthMm;
    const double share = std::max(smooth_between(20, 62, chart_x), smooth_between(80, 122, row_y));
    const double x = chart_x * (1 + share * (scale - 1));
    return front_of_head_mm(x, row_y + row_shift_mm(x, row_y, is_above_slit));
  }

  int add_vertex(const Eigen::Vector3d& p, HeadPart part, bool above_mouth, bool above_eye, int mirror) {
    points_.push_back(p);
    mesh_.part.push_back(part);
    mesh_.is_above_mouth.push_back(above_mouth);
    mesh_.is_above_eye.push_back(above_eye);
    mesh_.mirror_vertex.push_back(mirror);
    const int index = static_cast<int>(points_.size()) - 1;
    mesh_.anchor.push_back(index);
    return index;
  }

  void add_grid() {
    for (int row = 0; row < static_cast<int>(rows_.size()); ++row) {
      for (int column = 0; column < ring_; ++column) {
        const bool is_right = column > half_;
        Eigen::Vector3d p = point(row, is_right ? mirror_column(column) : column, false);
        if (column == 0 || column == half_) p.x() = 0;
        if (is_right) p.x() = -p.x();
        add_vertex(p, HeadPart::kSkin, row > mouth_row_, row > eye_row_, vertex(row, mirror_column(column)));
      }
    }
    const Eigen::Vector3d top = front_of_head_mm(0, 137.5);
    pole_ = add_vertex({0, top.y(), 3}, HeadPart::kSkin, true, true, 0);
    mesh_.mirror_vertex.back() = pole_;
  }

  /// The grid's own vertices on a slit are its lower edge; copies are the upper edge.
  void add_slit_edges() {
    for (int column = eye_inner_ + 1; column < eye_outer_; ++column) {
      const Eigen::Vector3d p = point(eye_row_, column, true);
      const int next = static_cast<int>(points_.size());
      upper_copy_[vertex(eye_row_, column)] = add_vertex(p, HeadPart::kSkin, true, true, next + 1);
      upper_copy_[vertex(eye_row_, -column)] = add_vertex({-p.x(), p.y(), p.z()}, HeadPart::kSkin, true, true, next);
    }
    for (int column = -mouth_corner_ + 1; column < mouth_corner_; ++column) {
      const int lower = vertex(mouth_row_, column);
      Eigen::Vector3d p = points_[static_cast<std::size_t>(lower)];
      // Closed lips touch; a hair between them keeps them two surfaces.
      points_[static_cast<std::size_t>(lower)].y() -= kLipGapMm / 2;
      p.y() += kLipGapMm / 2;
      upper_copy_[lower] = add_vertex(p, HeadPart::kSkin, true, false, 0);
    }
    for (int column = -mouth_corner_ + 1; column < mouth_corner_; ++column) {
      mesh_.mirror_vertex[static_cast<std::size_t>(upper_copy_[vertex(mouth_row_, column)])] =
          upper_copy_[vertex(mouth_row_, -column)];
    }
  }

  /// A corner of a cell above its row: on a slit, the upper edge.
  int above(int row, int column) const {
    const int v = vertex(row, column);
    const auto copy = upper_copy_.find(v);
    return copy == upper_copy_.end() ? v : copy->second;
  }

  void add_skin_triangles() {
    const int last_row = static_cast<int>(rows_.size()) - 1;
    for (int row = 0; row < last_row; ++row) {
      for (int column = 0; column < half_; ++column) {
        const int a = above(row, column), b = above(row, column + 1);
        const int c = vertex(row + 1, column + 1), d = vertex(row + 1, column);
        // The shorter diagonal.
        const auto length = [&](int i, int k) {
          return (points_[static_cast<std::size_t>(i)] - points_[static_cast<std::size_t>(k)]).squaredNorm();
        };
        if (length(a, c) <= length(b, d)) {
          left_.push_back({a, b, c});
          left_.push_back({a, c, d});
        } else {
          left_.push_back({a, b, d});
          left_.push_back({b, c, d});
        }
      }
    }
    for (int column = 0; column < half_; ++column) {
      left_.push_back({vertex(last_row, column), vertex(last_row, column + 1), pole_});
    }
  }

  void collect_edges() {
    for (int column = eye_inner_; column <= eye_outer_; ++column) {
      mesh_.upper_lid_edge.push_back(above(eye_row_, column));
      mesh_.lower_lid_edge.push_back(vertex(eye_row_, column));
    }
    for (int column = -mouth_corner_; column <= mouth_corner_; ++column) {
      mesh_.upper_lip_edge.push_back(above(mouth_row_, column));
      mesh_.lower_lip_edge.push_back(vertex(mouth_row_, column));
    }
  }

  /// The lids' thickness: a rim from each edge back to the eyeball.
  void add_lid_rims() {
    const auto rim = [&](const std::vector<int>& edge, bool is_upper) {
      std::vector<int> inner{edge.front()};
      for (std::size_t k = 1; k + 1 < edge.size(); ++k) {
        const Eigen::Vector3d p = points_[static_cast<std::size_t>(edge[k])];
        const Eigen::Vector3d in = p + 1.9 * (head::kEyeballMm - p).normalized();
        const int next = static_cast<int>(points_.size());
        add_vertex(in, HeadPart::kLidRim, true, is_upper, next + 1);
        add_vertex({-in.x(), in.y(), in.z()}, HeadPart::kLidRim, true, is_upper, next);
        mesh_.anchor[static_cast<std::size_t>(next)] = edge[k];
        mesh_.anchor[static_cast<std::size_t>(next) + 1] = mirrored(edge[k]);
        inner.push_back(next);
      }
      inner.push_back(edge.back());
      for (std::size_t k = 0; k + 1 < edge.size(); ++k) {
        std::array<int, 4> q{edge[k], edge[k + 1], inner[k + 1], inner[k]};
        if (is_upper) std::swap(q[1], q[3]);
        if (q[0] != q[1] && q[1] != q[2] && q[0] != q[2]) rims_.push_back({q[0], q[1], q[2]});
        if (q[0] != q[3] && q[2] != q[3] && q[0] != q[2]) rims_.push_back({q[0], q[2], q[3]});
      }
    };
    rim(mesh_.upper_lid_edge, true);
    rim(mesh_.lower_lid_edge, false);
    parts_.points = &points_;
    parts_.mesh = &mesh_;
  }

  /// Left triangles and their mirror images, skin first; then the parts within.
  void finish() {
    std::vector<Eigen::Vector3i> all = left_;
    const auto mirror_all = [&](const std::vector<Eigen::Vector3i>& list) {
      for (const Eigen::Vector3i& t : list) all.emplace_back(mirrored(t[0]), mirrored(t[2]), mirrored(t[1]));
    };
    mirror_all(left_);
    std::vector<Eigen::Vector3i> inner = rims_;
    inner.insert(inner.end(), parts_.left.begin(), parts_.left.end());
    const std::size_t skin = all.size();
    all.insert(all.end(), inner.begin(), inner.end());
    mirror_all(inner);
    mesh_.triangles.resize(3, static_cast<Eigen::Index>(all.size()));
    for (std::size_t t = 0; t < all.size(); ++t) mesh_.triangles.col(static_cast<Eigen::Index>(t)) = all[t];
    const auto pair_up = [&](std::size_t begin, std::size_t count) {
      for (std::size_t t = 0; t < count; ++t) mesh_.mirror_triangle.push_back(static_cast<int>(begin + count + t));
      for (std::size_t t = 0; t < count; ++t) mesh_.mirror_triangle.push_back(static_cast<int>(begin + t));
    };
    pair_up(0, skin / 2);
    pair_up(skin, inner.size());
    mesh_.vertices_mm.resize(3, static_cast<Eigen::Index>(points_.size()));
    for (std::size_t v = 0; v < points_.size(); ++v) mesh_.vertices_mm.col(static_cast<Eigen::Index>(v)) = points_[v];
  }

  static constexpr double kLipGapMm = 0.06;

  std::vector<double> rows_, front_, side_;
  int half_, ring_, eye_row_ = 0, mouth_row_ = 0, eye_inner_ = 0, eye_outer_ = 0, mouth_corner_ = 0, pole_ = 0;
  std::vector<Eigen::Vector3d> points_;
  std::map<int, int> upper_copy_;
  std::vector<Eigen::Vector3i> left_, rims_;
  HeadPartBuilder parts_;
  HeadMesh mesh_;
};

}  // namespace

HeadMesh build_head_mesh() { return Builder().build(); }

}  // namespace risorius
