// The default Expression-Generator as libtorch trains it; generate/expression_generator.h runs it. All weights are
// shared by all AUs. Several members of one kind, which differ in how they begin and in what they are shown:
//
//   past (8 steps) -> LSTM -> state of the decoder -> [fixed, step inputs, noise] -> LSTM -> linear -> coefficient
#pragma once

#include <torch/torch.h>
#include <vector>

#include "generate/train/transition_data.h"

namespace risorius {

inline constexpr std::int64_t kTransitionNoise = 4;

struct ExpressionNetworkOptions {
  std::int64_t members = 4;
  std::int64_t encoder_units = 32;
  std::int64_t decoder_units = 48;
};

struct ExpressionMemberImpl : torch::nn::Module {
  explicit ExpressionMemberImpl(const ExpressionNetworkOptions& options);
  /// Coefficients of the residual, R x kTransitionKnots. `noise`: transitions x kTransitionNoise.
  torch::Tensor forward(const TransitionTensors& data, const torch::Tensor& noise);

  torch::nn::LSTM encoder{nullptr}, decoder{nullptr};
  torch::nn::Linear state{nullptr}, output{nullptr};
};
TORCH_MODULE(ExpressionMember);

struct ExpressionNetworkImpl : torch::nn::Module {
  explicit ExpressionNetworkImpl(const ExpressionNetworkOptions& options = {});
  /// The members' mean, without noise: the expected course.
  torch::Tensor forward(const TransitionTensors& data);
  /// Logarithm of the expected duration, one per transition.
  torch::Tensor expected_log_seconds(const torch::Tensor& whole);

  std::vector<ExpressionMember> members;
  torch::nn::Linear duration_hidden{nullptr}, duration{nullptr};
};
TORCH_MODULE(ExpressionNetwork);

}  // namespace risorius
