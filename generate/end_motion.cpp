#include "generate/end_motion.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace risorius {
namespace {

using Eigen::Index;

struct Window {
  Index order = 2;  ///< of the polynomial
  double seconds = 0;
};
/// The calmest last: where the past is too short to choose, it is taken.
constexpr std::array<Window, 5> kWindows{{{3, 0.025}, {2, 0.0167}, {3, 0.05}, {2, 0.025}, {2, 0.05}}};
/// By so much a calmer window's squared error must be lower: what it smooths, the start does not go on with.
constexpr double kCalmer = 2;
constexpr double kAheadS = 1.0 / 120;  ///< how far they are asked to tell
constexpr Index kMostFrames = 32;

Index frames_in(const Window& window, Index rows, double rate_hz) noexcept {
  const auto wanted = std::clamp<Index>(std::llround(window.seconds * rate_hz) + 1, window.order + 1, kMostFrames);
  return std::min(rows, wanted);
}

/// The polynomial through row `last` that is nearest to the `count` - 1 rows before it; the last value is kept exactly,
/// so that nothing leaps there.
EndMotion polynomial_at(const AuMatrix& past, Index column, Index last, Index count, Index order,
                        double rate_hz) noexcept {
  Eigen::Matrix3d gram = Eigen::Matrix3d::Zero();
  Eigen::Vector3d target = Eigen::Vector3d::Zero();
  for (Index back = 1; back < count; ++back) {
    const auto b = -static_cast<double>(back);  // in frames
    const Eigen::Vector3d powers(b, b * b, b * b * b);
    gram += powers * powers.transpose();
    target += powers * (double{past(last - back, column)} - past(last, column));
  }
  const Index terms = std::min(order, count - 1);
  for (Index k = terms; k < 3; ++k) {
    gram.row(k).setZero();
    gram.col(k).setZero();
    gram(k, k) = 1;
    target(k) = 0;
  }
  const Eigen::Vector3d c = gram.ldlt().solve(target);
  return {c(0) * rate_hz, 2 * c(1) * rate_hz * rate_hz, 6 * c(2) * rate_hz * rate_hz * rate_hz};
}

}  // namespace

EndMotion end_motion(const AuMatrix& past, Index column, double rate_hz) noexcept {
  const Index rows = past.rows();
  if (rows < 2) return {};
  const Index longest = frames_in(kWindows.back(), rows, rate_hz);
  const auto ahead = std::max<Index>(1, std::llround(kAheadS * rate_hz));
  const double t = static_cast<double>(ahead) / rate_hz;
  const Window* best = &kWindows.back();
  double least = std::numeric_limits<double>::infinity();
  for (const Window& window : kWindows) {
    const Index count = frames_in(window, rows, rate_hz);
    double squares = 0;
    for (Index last = longest - 1; last + ahead < rows; ++last) {
      const EndMotion motion = polynomial_at(past, column, last, std::min(count, last + 1), window.order, rate_hz);
      const double told = past(last, column) + t * (motion.velocity_per_s +
                                                    t / 2 * (motion.acceleration_per_s2 + t / 3 * motion.jerk_per_s3));
      const double error = told - past(last + ahead, column);
      squares += error * error;
    }
    if (kCalmer * squares > least) continue;
    least = squares;
    best = &window;
  }
  return polynomial_at(past, column, rows - 1, frames_in(*best, rows, rate_hz), best->order, rate_hz);
}

}  // namespace risorius
