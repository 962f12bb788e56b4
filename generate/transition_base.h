// The curve that the Expression-Generator corrects: it goes on as the face moves, lets that motion die away, and covers
// what is then left of the way. One definition for the trainer and the runtime.
//
//   b(t) = x0 + p(t) + (d - p(T)) m(t / T),    p(t) = Int_0^t v0 w(s / tau) + a0 s w(s / tau_a) + j0 s^2/2 w(s / tau_j)
//   ds   (1)
//
// x0, v0, a0, j0: value, velocity, acceleration and jerk of the past at its last frame (generate/end_motion.h), d the
// way to the target, m the minimum-jerk curve; w falls from 1 to 0 with two zero derivatives at both ends, so b leaves
// x0 with v0 and a0 and reaches the target at rest. What p has covered is not taken back: p goes to rest as a stopping
// movement does, and only the rest of the way is left to m.
#pragma once

#include <Eigen/Core>

#include "generate/transition.h"

namespace risorius {

/// Of one transition, a row per AU.
struct TransitionBase {
  Eigen::VectorXf start, change;  ///< x0, d
  Eigen::VectorXf velocity_per_s, acceleration_per_s2, jerk_per_s3;
  Eigen::VectorXf velocity_fade_s, acceleration_fade_s, jerk_fade_s;  ///< tau, tau_a, tau_j, > 0
  Eigen::VectorXf covered;                                            ///< p(T)
};

/// 10 u^3 - 15 u^4 + 6 u^5.
float minimum_jerk(float u) noexcept;

/// `request`: checked by the caller.
void make_transition_base(const TransitionRequest& request, TransitionBase& base);

/// b at time t_s of a transition of `seconds`; all AUs.
void transition_base_at(const TransitionBase& base, float t_s, float seconds, Eigen::Ref<Eigen::RowVectorXf> row);

}  // namespace risorius
