// What rehearsed fills that are alike (gaps of one length, say) got wrong, and so how far others like them are
// believed:
//   weight: fill = stayed + weight (model - stayed), with `stayed` the plainest way to fill;
//   scale:  of the stated variance, so that the 90 % interval is the one that the errors have.
// Begins with a belief (weight 1, scale 1) that is worth some samples.
#pragma once

#include <Eigen/Core>
#include <array>

namespace risorius {

class FillTrust {
 public:
  /// `moved`: mean square of model - stayed, per axis and in stated variances, of the fills that this is about.
  explicit FillTrust(double moved = 1) noexcept;

  /// A fill that counts `share`: what the model moved by, what would have been right, and the stated variance.
  void note_move(double share, const Eigen::Vector3d& moved_mm, const Eigen::Vector3d& right_mm,
                 double variance_mm2) noexcept;
  /// What the weighed fill got wrong.
  void note_error(double share, const Eigen::Vector3d& error_mm, double variance_mm2) noexcept;
  /// So much (0 to 1) of what was found gives way to `first`.
  void give_way(const FillTrust& first, double gone) noexcept;

  double weight() const noexcept;
  double scale() const noexcept;

 private:
  static constexpr std::size_t kErrors = 28;  ///< |error|, in stated deviations, by thirds of octaves from 1/16

  double away_;                         ///< sum of (model - stayed)^2, in stated variances
  double towards_;                      ///< of (model - stayed) . (truth - stayed)
  double samples_;                      ///< axes
  std::array<double, kErrors> errors_;  ///< how many axes had an error up to so large
};

}  // namespace risorius
