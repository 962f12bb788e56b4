// Transitions as tensors: one row per transition and AU that moves, sampled at even places of the way.
#pragma once

#include <span>
#include <torch/torch.h>

#include "replay/corpus/transition_corpus.h"

namespace risorius {

inline constexpr Eigen::Index kCourseSamples = 40;  ///< of a course, at u = 1/40, 2/40, ... 1

struct TransitionTensors {
  torch::Tensor fixed;        ///< R x kTransitionFixedWidth
  torch::Tensor past;         ///< R x steps x width
  torch::Tensor seconds;      ///< R
  torch::Tensor scale;        ///< R
  torch::Tensor base;         ///< R x kCourseSamples
  torch::Tensor course;       ///< R x kCourseSamples: the truth
  torch::Tensor weight;       ///< R: how many rows this one stands for
  torch::Tensor owner;        ///< R, int64: which transition
  torch::Tensor whole;        ///< T x kTransitionWholeWidth
  torch::Tensor log_seconds;  ///< T
  std::int64_t transitions = 0;

  /// The rows of some transitions, renumbered.
  TransitionTensors of(const torch::Tensor& chosen) const;
};

/// Of the AUs that rest at 0 before and after, one in `idle_share` gives a row, which then counts as often.
TransitionTensors transition_tensors(const std::vector<std::string>& names,
                                     std::span<const Transition* const> transitions, double rate_hz,
                                     int idle_share = 1);

/// kTransitionKnots x kCourseSamples: what the spline's coefficients add, with the envelope.
torch::Tensor residual_basis();
/// x of (2) in generate/transition_features.h, before it is cut to the bounds: R x kCourseSamples. `coefficients`: R x
/// kTransitionKnots.
torch::Tensor courses_of(const TransitionTensors& data, const torch::Tensor& coefficients, const torch::Tensor& basis);

}  // namespace risorius
