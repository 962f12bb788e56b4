// The interpolations that every generator of transitions has to beat: hold, linear, minimum jerk (Flash & Hogan 1985),
// cubic Hermite and quintic. u = 0 at the last past row, u = 1 at the last generated one, T the time between.
//
//   hold            x0, and the target in the last row
//   linear          x0 + (x1 - x0) u
//   minimum_jerk    x0 + (x1 - x0) (10 u^3 - 15 u^4 + 6 u^5)          velocity and acceleration 0 at both ends
//   cubic_hermite   x0, v0 at the start; x1, 0 at the end
//   quintic         x0, v0, a0 at the start; x1, 0, 0 at the end
//
// v0 and a0 are those of the parabola fitted to the past's last `window_ms`; the result is clipped to [0, 1.2].
#pragma once

#include <array>
#include <memory>

#include "generate/transition.h"

namespace risorius {

enum class InterpolationKind : std::uint8_t { kHold, kLinear, kMinimumJerk, kCubicHermite, kQuintic };

inline constexpr std::array kInterpolationKinds{InterpolationKind::kHold, InterpolationKind::kLinear,
                                                InterpolationKind::kMinimumJerk, InterpolationKind::kCubicHermite,
                                                InterpolationKind::kQuintic};

struct InterpolationOptions {
  double window_ms = 50;  ///< [0, 1000]: of the past that tells velocity and acceleration; at least its last three rows
};

class Interpolation final : public TransitionModel {
 public:
  /// Throws std::invalid_argument for a window out of range.
  explicit Interpolation(InterpolationKind kind, const InterpolationOptions& options = {});

  std::string_view name() const noexcept override;
  void generate(const TransitionRequest& request, AuMatrix& result) override;

 private:
  InterpolationKind kind_;
  InterpolationOptions options_;
};

/// "hold", "linear", "minimum_jerk", "cubic_hermite" or "quintic"; null for another name.
std::unique_ptr<TransitionModel> make_interpolation(std::string_view name);

/// What the end of a past tells of each AU, per second and per second squared: of the parabola through its last rows,
/// of the line where there are two, 0 where there is one.
struct PastMotion {
  Eigen::VectorXd velocity_per_s, acceleration_per_s2;  ///< A each
};
/// `past` P x A, P >= 1, at `rate_hz`; its last rows that lie within `window_ms`, at least three if there are.
PastMotion motion_at_end(const AuMatrix& past, double rate_hz, double window_ms);

/// Throws std::invalid_argument as TransitionModel::generate does.
void check_transition_request(const TransitionRequest& request);

}  // namespace risorius
