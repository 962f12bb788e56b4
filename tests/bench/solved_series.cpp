#include "bench/solved_series.h"

#include <algorithm>

namespace risorius::bench {

Solved table_of(const std::vector<AuFrame>& frames, Eigen::Index aus) {
  Solved solved{Eigen::MatrixXd(static_cast<Eigen::Index>(frames.size()), aus), 0};
  for (std::size_t f = 0; f < frames.size(); ++f) {
    solved.largest_kkt = std::max(solved.largest_kkt, frames[f].kkt_residual);
    for (Eigen::Index i = 0; i < aus; ++i)
      solved.x(static_cast<Eigen::Index>(f), i) = frames[f].intensity[static_cast<std::size_t>(i)];
  }
  return solved;
}

std::vector<AuFrame> solve_frame_by_frame(const Rig& rig, const MarkerSet& markers,
                                          const std::vector<MarkerFrame>& frames, const AuSolverOptions& options) {
  AuSolver solver(rig, options);
  solver.use_marker_set(markers);
  std::vector<AuFrame> out(frames.size());
  for (std::size_t f = 0; f < frames.size(); ++f) {
    solver.push(frames[f]);
    solver.pop(out[f]);
  }
  return out;
}

}  // namespace risorius::bench
