#include "capture/repair/baselines/marker_matrix.h"

#include "capture/repair/position_vector.h"

namespace risorius {

MarkerMatrix::MarkerMatrix(const std::vector<MarkerFrame>& frames) {
  const auto rows = static_cast<Eigen::Index>(frames.size());
  const auto columns = static_cast<Eigen::Index>(frames.empty() ? 0 : frames.front().count);
  position_mm.setZero(rows, 3 * columns);
  is_seen.setZero(rows, columns);
  for (Eigen::Index f = 0; f < rows; ++f) {
    const MarkerFrame& frame = frames[static_cast<std::size_t>(f)];
    for (Eigen::Index i = 0; i < columns; ++i) {
      const auto m = static_cast<std::size_t>(i);
      if (frame.state[m] != MarkerState::kMeasured) continue;
      is_seen(f, i) = 1;
      position_mm.block<1, 3>(f, 3 * i) = to_vector(frame.position_mm[m]).transpose();
    }
  }
}

std::vector<Eigen::Index> MarkerMatrix::frames_with(const std::vector<Eigen::Index>& wanted) const {
  std::vector<Eigen::Index> found;
  for (Eigen::Index f = 0; f < frames(); ++f) {
    bool all = true;
    for (const Eigen::Index i : wanted) all = all && is_seen(f, i) != 0;
    if (all) found.push_back(f);
  }
  return found;
}

void write_filled(std::vector<MarkerFrame>& frames, const MarkerMatrix& take, const Eigen::MatrixXd& filled_mm,
                  std::int64_t max_gap_ns) {
  for (Eigen::Index i = 0; i < take.markers(); ++i) {
    Eigen::Index before = -1;
    for (Eigen::Index f = 0; f < take.frames(); ++f) {
      if (!take.is_seen(f, i)) continue;
      const std::int64_t span_ns = before < 0 ? max_gap_ns
                                              : frames[static_cast<std::size_t>(f)].header.capture_time_ns -
                                                    frames[static_cast<std::size_t>(before)].header.capture_time_ns;
      for (Eigen::Index k = before + 1; before >= 0 && k < f && span_ns <= max_gap_ns; ++k) {
        MarkerFrame& frame = frames[static_cast<std::size_t>(k)];
        const auto m = static_cast<std::size_t>(i);
        frame.position_mm[m] = to_position(filled_mm.block<1, 3>(k, 3 * i).transpose());
        frame.standard_deviation_mm[m] = 0;
        frame.state[m] = MarkerState::kFilled;
      }
      before = f;
    }
  }
}

}  // namespace risorius
