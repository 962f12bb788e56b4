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

/// A run of frames in which a marker is hidden: [begin, end).
struct Gap {
  std::size_t marker, begin, end;
  std::size_t length() const noexcept { return end - begin; }
};

class TakeRegression {
 public:
  /// Keeps a reference to the take. `known`: how this face moves, or null.
  TakeRegression(const HeadTake& take, const std::vector<std::string>& names,
                 const std::shared_ptr<const KnownMotion>& known);

  struct Way {
    GapRegression::Fill fill;  ///< in the head's frame
    GapChoice choice;
  };
  /// The way through a gap of a marker that is measured somewhere.
  Way fill(const Gap& gap) const;
  /// As if the same gap, the same others hidden, began where the marker is in truth measured.
  GapRegression::Fill fill_at(const Gap& gap, std::size_t begin, const GapChoice& choice) const;

  /// Of those who could speak for the marker, the nearer the more, the share that is hidden in the gap, 0 to 1.
  double unheard(const Gap& gap) const;
  /// How much those who speak for the marker move about the straight line while a gap as this one lasts that begins at
  /// `begin`: mean square, mm^2.
  double liveliness(const Gap& gap, std::size_t begin) const;
  /// Of the marker's samples, per axis.
  double noise_mm(std::size_t i) const;

 private:
  void smooth(std::size_t i);
  void bridge(std::size_t i);
  double seen_share(std::size_t j, const Gap& gap) const;
  double nearness(std::size_t i, std::size_t j) const;
  Eigen::VectorXd weights(const Gap& gap) const;
  std::vector<std::size_t> samples(const Gap& gap) const;
  Eigen::Matrix3Xd positions_mm(std::size_t i, const std::vector<std::size_t>& frames) const;
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
