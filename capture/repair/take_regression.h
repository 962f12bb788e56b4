// What the regressions of a take's gaps have in common: the take in the head's frame, every marker's way through it
// made smooth and whole enough to be a feature of others, and which samples a gap is learnt from.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "capture/repair/gap_regression.h"
#include "capture/repair/head_take.h"

namespace risorius {

class TakeRegression {
 public:
  /// Keeps a reference to the take.
  explicit TakeRegression(const HeadTake& take);

  /// The way of marker i through frames [begin, end), in the head's frame. The marker is measured somewhere.
  GapRegression::Fill fill(std::size_t i, std::size_t begin, std::size_t end) const;

 private:
  void smooth(std::size_t i);
  void bridge(std::size_t i);
  double noise_mm(std::size_t i) const;
  Eigen::VectorXd weights(std::size_t i, std::size_t begin, std::size_t end) const;
  std::vector<std::size_t> samples(std::size_t i, std::size_t begin, std::size_t end) const;
  Eigen::MatrixXd features(const std::vector<std::size_t>& frames, const Eigen::VectorXd& weights) const;
  Eigen::VectorXd times(const std::vector<std::size_t>& frames) const;

  const HeadTake& take_;
  Eigen::MatrixXd feature_mm_;                     ///< 3 markers x frames, about each marker's mean
  std::vector<Eigen::Vector3d> mean_mm_;           ///< by marker
  std::vector<std::vector<std::size_t>> seen_in_;  ///< frames by marker
};

}  // namespace risorius
