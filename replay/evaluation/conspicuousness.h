// Whether an eye would stumble over a generated transition: seed 003's criteria for conspicuous animations (its 6.3.1)
// as one formula, and the ratings +, o and - of its Table 7.1. generate/README.md, equations (6) and (7), says why it
// reads so. Intensities; "%" is of the full range 1.2, as in seed 003.
#pragma once

#include <array>
#include <cstdint>

#include "generate/transition.h"

namespace risorius {

inline constexpr double kFullRange = 1.2;

/// How far an AU runs against the way from its start to its end, in %: max over i < j of s (x_i - x_j), s the sign of
/// xN - x0 (+1 if equal), i and j over `start` and the column `au` of `course`.
double reactivation_percent(double start, const AuMatrix& course, Eigen::Index au);

enum class TransitionRating : std::uint8_t { kInconspicuous, kNarrow, kConspicuous };
/// '+', 'o' or '-', as in seed 003's Table 7.1.
char symbol_of(TransitionRating rating) noexcept;

/// Up to here a criterion is missed narrowly, as a multiple of its threshold.
inline constexpr double kNarrowExcess = 1.25;
inline constexpr std::size_t kCriteria = 4;

struct Conspicuousness {
  double summed_error = 0;          ///< E: sum over frames of the mean over AUs of (made - truth)^2
  double largest_jump_percent = 0;  ///< J1: the largest |x_k - x_(k-1)|, start included, of all AUs
  double third_jump_percent = 0;    ///< J3: that of the AU with the third largest one; 0 where there are fewer AUs
  double reactivation_percent = 0;  ///< R: above the truth's, of the AU with the most
  double end_percent = 0;           ///< S: the most of |x1 - x0| above the truth's, and of |xN - target|

  /// Equation (6): {E / 1, max(J1 / 40 %, J3 / 20 %), R / 25 %, S / 25 %}.
  std::array<double, kCriteria> excess() const noexcept;
  /// Some criterion is above 1.
  bool is_conspicuous() const noexcept;
  /// Equation (7): narrow is one criterion above 1 and up to kNarrowExcess, all others not above 1.
  TransitionRating rating() const noexcept;
};

/// `past` P x A, `truth` and `made` N x A; the target is the truth's last row. Throws std::invalid_argument for sizes
/// that do not fit.
Conspicuousness conspicuousness_of(const AuMatrix& past, const AuMatrix& truth, const AuMatrix& made);

}  // namespace risorius
