// Where skin folds under each AU: the wrinkles and furrows that FACS readers look for. They are shading, not geometry:
// a mesh of some thousand vertices cannot carry folds of a millimetre, so pictures bend the light there as folds would.
// Lines over the built-in face at rest, in its frontal plane (mm, x to the subject's left); written for the left side.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace risorius {

struct Crease {
  std::string_view au;                ///< without side
  std::vector<Eigen::Vector2d> line;  ///< at least two points; fades out towards its ends
  double width_mm = 1.2;              ///< from the bottom to where the skin is level again
  double depth_mm = 0.8;
};
std::span<const Crease> facial_creases();

/// The creases of some columns ("AU12L", "AU17") of a face that is scaled by `actor_per_face`.
class CreaseShade {
 public:
  CreaseShade() = default;
  CreaseShade(const std::vector<std::string>& columns, double actor_per_face);

  bool empty() const noexcept { return lines_.empty(); }
  /// Height of the folded skin over the smooth one, mm (< 0 in a crease, a little > 0 beside it), at a place of the
  /// resting face.
  double height_mm(double x_mm, double y_mm) const noexcept;

 private:
  struct Line {
    std::vector<Eigen::Vector2d> points;
    Eigen::Vector2d low, high;  ///< of the region where it shows
    double width_mm, depth_mm;
  };
  std::vector<Line> lines_;
};

}  // namespace risorius
