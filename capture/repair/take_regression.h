// What the regressions of a take's gaps have in common: the take in the head's frame, every marker's way through it
// made smooth and whole enough to be a feature of others, and which samples a gap is learnt from.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "capture/repair/gap_regression.h"
#include "capture/repair/head_take.h"
#include "capture/repair/known_motion.h"

namespace risorius {

class TakeRegression {
 public:
  /// Keeps a reference to the take. `known`: how this face moves, or null.
  TakeRegression(const HeadTake& take, const std::vector<std::string>& names,
                 const std::shared_ptr<const KnownMotion>& known);

  /// The way of marker i through frames [begin, end), in the head's frame. The marker is measured somewhere.
  GapRegression::Fill fill(std::size_t i, std::size_t begin, std::size_t end) const;

 private:
  void smooth(std::size_t i);
  void bridge(std::size_t i);
  double noise_mm(std::size_t i) const;
  Eigen::VectorXd weights(std::size_t i, std::size_t begin, std::size_t end) const;
  std::vector<std::size_t> samples(std::size_t i, std::size_t begin, std::size_t end) const;
  Eigen::Matrix3Xd guess_of(std::size_t i, const Eigen::VectorXd& weights) const;
  GapFeatures features(const std::vector<std::size_t>& frames, const Eigen::VectorXd& weights,
                       const Eigen::Matrix3Xd& guess) const;

  const HeadTake& take_;
  KnownModes modes_;
  Eigen::MatrixXd feature_mm_;                     ///< 3 markers x frames, about each marker's mean
  std::vector<Eigen::Vector3d> mean_mm_;           ///< by marker
  std::vector<std::vector<std::size_t>> seen_in_;  ///< frames by marker
};

}  // namespace risorius
