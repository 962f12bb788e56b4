// A take as a matrix for the published methods: one row per frame, x y z of each marker in turn (world, mm).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "capture/frames.h"

namespace risorius {

struct MarkerMatrix {
  Eigen::MatrixXd position_mm;                                          ///< frames x 3 markers; 0 where not measured
  Eigen::Matrix<std::uint8_t, Eigen::Dynamic, Eigen::Dynamic> is_seen;  ///< frames x markers

  explicit MarkerMatrix(const std::vector<MarkerFrame>& frames);
  Eigen::Index frames() const noexcept { return is_seen.rows(); }
  Eigen::Index markers() const noexcept { return is_seen.cols(); }
  /// Frames in which all those markers were seen.
  std::vector<Eigen::Index> frames_with(const std::vector<Eigen::Index>& markers) const;
};

/// Makes a hidden marker a filled one, if it lies in a gap of at most `max_gap_ns` between two measured samples.
/// The standard deviation of these methods is not known: it is stated as 0.
void write_filled(std::vector<MarkerFrame>& frames, const MarkerMatrix& take, const Eigen::MatrixXd& filled_mm,
                  std::int64_t max_gap_ns);

}  // namespace risorius
