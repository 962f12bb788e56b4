// How near solved AU series come to the truth. Only identifiable AUs count: moved by some marker beyond three times the
// noise at intensity 1. AUs whose fields the markers cannot tell apart (cosine above 0.95, the head's motion taken out)
// are tied: their mean, weighted by size, counts once.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "solve/rigs/rig.h"

namespace risorius::bench {

/// AUs that count as one channel.
struct AuTie {
  std::string name;               ///< "AU6L", or "AU6L+AU14L" where tied
  std::vector<Eigen::Index> aus;  ///< columns of the rig
  std::vector<double> share;      ///< of each in the mean, sum 1
};

std::vector<AuTie> identifiable_aus(const Rig& rig, double noise_mm);

/// T x (number of ties) from T x K.
Eigen::MatrixXd tied_series(const Eigen::MatrixXd& aus, const std::vector<AuTie>& ties);

struct AuAccuracy {
  Eigen::VectorXd rmse, correlation, lag_frames;  ///< per channel; correlation and lag NaN where the truth rests
  double rmse_median = 0, rmse_p90 = 0, rmse_all = 0, correlation_median = 0, lag_median_frames = 0;
  double moving_rmse_median = 0;  ///< over the channels whose truth moves
  Eigen::MatrixXd crosstalk;      ///< (j, i): how much of a unit of true j appears in solved i, by regression
};

/// Both T x channels; the first `skip` frames are left out.
AuAccuracy accuracy_of(const Eigen::MatrixXd& truth, const Eigen::MatrixXd& solved);

/// Of the values that are numbers; NaN if there are none.
double quantile(std::vector<double> values, double share);

}  // namespace risorius::bench
