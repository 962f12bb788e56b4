// Series of intensities out of frames, for the benches of accuracy.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "capture/frames.h"
#include "capture/marker_set.h"
#include "solve/au_solver.h"

namespace risorius::bench {

struct Solved {
  Eigen::MatrixXd x;  ///< frames x K
  double largest_kkt = 0;
};

Solved table_of(const std::vector<AuFrame>& frames, Eigen::Index aus);
/// As the live path does.
std::vector<AuFrame> solve_frame_by_frame(const Rig& rig, const MarkerSet& markers,
                                          const std::vector<MarkerFrame>& frames, const AuSolverOptions& options = {});

}  // namespace risorius::bench
