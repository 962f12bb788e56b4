// Normalised power spectrum similarity (Gopalakrishnan et al. 2019, eq. 6 to 9): how alike two motions are in rhythm,
// whatever their phase. 0 is alike. Per sequence and channel, over the whole discrete Fourier transform of its frames:
//
//   P[f] = |X[f]|^2,   p[f] = P[f] / sum P,   EMD = sum_f | cumsum(p_truth)[f] - cumsum(p_made)[f] |
//   NPSS = sum w EMD / sum w,   w = sum_f P_truth[f]
//
// A channel without power has cumsum 0, and weight 0 if it is the truth's.
#pragma once

#include "generate/transition.h"

namespace risorius {

class PowerSpectrumSimilarity {
 public:
  /// Frames x AUs, of one size, at least one frame. Throws std::invalid_argument otherwise.
  void add(const AuMatrix& truth, const AuMatrix& made);
  /// NaN if no truth had any power.
  double value() const noexcept;

 private:
  double weighted_sum_ = 0, weight_ = 0;
};

}  // namespace risorius
