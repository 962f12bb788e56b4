// What the Expression-Generator's network sees of a transition, and the curve that it corrects. One definition for the
// trainer and the runtime.
//
//   x(t) = x0 + d m(u) + v0 t w(t / tau) + a0 t^2 / 2 w(t / tau_a) + j0 t^3 / 6 w(t / tau_j) + s e(u) r(u),
//   u = t / T                                                                                                     (1)
//
// x0, v0, a0, j0 are value, velocity, acceleration and jerk of the past at its last frame (generate/end_motion.h), d
// the way to the target, m the minimum-jerk curve, w falls from 1 to 0 with two zero derivatives at both ends. tau =
// min(T, 0.25 s), shorter where the velocity would add more than 0.5 until then; tau_a and tau_j likewise for 0.05,
// 1/30 s at least, but an acceleration that brakes may take off all that the velocity adds. r is the network's: a cubic
// B-spline of kTransitionKnots coefficients. e = 64 u^3 (1 - u)^3 and its first two derivatives are 0 at both ends, so
// x leaves x0 with v0 and a0 and reaches the target at rest, whatever r is.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "generate/au_kind.h"
#include "generate/transition.h"

namespace risorius {

inline constexpr Eigen::Index kTransitionKnots = 24;
inline constexpr Eigen::Index kTransitionPastSteps = 8;    ///< 20 ms apart, the last at the last frame
inline constexpr Eigen::Index kTransitionPastWidth = 2;    ///< per step: of the AU, and of its other side
inline constexpr Eigen::Index kTransitionFixedWidth = 19;  ///< what stays the same over a transition
inline constexpr Eigen::Index kTransitionStepWidth = 4;    ///< what changes: u, u (1 - u), time to arrival, m(u)
inline constexpr Eigen::Index kTransitionWholeWidth = 9;   ///< of all AUs together, for the duration
inline constexpr float kMostTransitionIntensity = 1.2F;

/// Of one transition, a row per AU.
struct TransitionFeatures {
  Eigen::VectorXf start, change, velocity_per_s, acceleration_per_s2, jerk_per_s3;
  Eigen::VectorXf velocity_fade_s, acceleration_fade_s, jerk_fade_s;  ///< tau, tau_a, tau_j of (1)
  Eigen::VectorXf scale;                                              ///< s of (1), > 0
  AuMatrix past;                                                      ///< A x (steps x width), step after step
  AuMatrix fixed;                                                     ///< A x kTransitionFixedWidth
  Eigen::VectorXf whole;  ///< kTransitionWholeWidth; does not depend on the duration
};

class TransitionFeatureMaker {
 public:
  /// AUs by name.
  explicit TransitionFeatureMaker(const std::vector<std::string>& names);

  /// Throws std::invalid_argument: sizes that do not fit, numbers that are not finite, no frames, no rate.
  void make(const TransitionRequest& request, TransitionFeatures& features) const;
  std::size_t size() const noexcept { return kinds_.size(); }

 private:
  void check(const TransitionRequest& request) const;
  void make_past(const TransitionRequest& request, TransitionFeatures& features) const;

  std::vector<AuKind> kinds_;
  std::vector<std::size_t> other_;
};

/// 10 u^3 - 15 u^4 + 6 u^5.
float minimum_jerk(float u) noexcept;
/// e of (1).
float transition_envelope(float u) noexcept;
/// Weights of the spline's coefficients at u; four of them are not 0.
void transition_spline(float u, Eigen::Ref<Eigen::VectorXf> weights) noexcept;
/// kTransitionStepWidth inputs at the place of knot k in a transition of `seconds`.
void transition_step_inputs(Eigen::Index knot, float seconds, Eigen::Ref<Eigen::VectorXf> inputs) noexcept;
/// (1) without its last term, at time t_s of a transition of `seconds`; all AUs.
void transition_base(const TransitionFeatures& features, float t_s, float seconds, Eigen::Ref<Eigen::RowVectorXf> row);

}  // namespace risorius
