// Keeps what an AU means while a rig is refined: a new displacement field may turn, grow and spread only so far from
// where it began, and must stay more like itself than like another AU.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "solve/rigs/rig.h"

namespace risorius {

/// Cosine between two fields over all markers; 0 where one is zero.
double cosine_of(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b);

struct AuGuardLimits {
  double least_cosine = 0.7;                    ///< to the start
  double least_gain = 0.4, largest_gain = 2.5;  ///< of the field's norm to the start's
  double largest_far_share = 0.15;              ///< of the field's energy where the start does not reach
  double reach_mm = 12;                         ///< see reach_of (basis_update.h)
};

class AuGuard {
 public:
  /// Throws std::invalid_argument for limits out of range.
  AuGuard(Rig start, const AuGuardLimits& limits);

  bool allows(std::size_t au, const Eigen::Matrix3Xd& field_mm) const;
  /// Takes the field back towards the start until it is allowed; true if that was needed.
  bool hold_back(std::size_t au, Eigen::Matrix3Xd& field_mm) const;

 private:
  Rig start_;
  AuGuardLimits limits_;
  std::vector<Eigen::VectorXd> is_far_;  // per AU: M, 1 where the start does not reach
  Eigen::MatrixXd start_cosine_;         // K x K
};

}  // namespace risorius
