// What the Expression-Generator's network sees of a transition, and where its word counts. One definition for the
// trainer and the runtime.
//
//   x(t) = b(t) + s e(u) r(u),    u = t / T                                                                        (2)
//
// b is the base curve (generate/transition_base.h), r the network's: a cubic B-spline of kTransitionKnots coefficients.
// e = 64 u^3 (1 - u)^3 and its first two derivatives are 0 at both ends, so x leaves and arrives as b does, whatever r
// is.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "generate/au_kind.h"
#include "generate/transition.h"
#include "generate/transition_base.h"

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
  TransitionBase base;
  Eigen::VectorXf scale;  ///< s of (2), > 0
  AuMatrix past;          ///< A x (steps x width), step after step
  AuMatrix fixed;         ///< A x kTransitionFixedWidth
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

/// e of (2).
float transition_envelope(float u) noexcept;
/// Weights of the spline's coefficients at u; four of them are not 0.
void transition_spline(float u, Eigen::Ref<Eigen::VectorXf> weights) noexcept;
/// kTransitionStepWidth inputs at the place of knot k in a transition of `seconds`.
void transition_step_inputs(Eigen::Index knot, float seconds, Eigen::Ref<Eigen::VectorXf> inputs) noexcept;

}  // namespace risorius
