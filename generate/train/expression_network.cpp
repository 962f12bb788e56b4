#include "generate/train/expression_network.h"

#include <string>

#include "generate/transition_features.h"

namespace risorius {

ExpressionMemberImpl::ExpressionMemberImpl(const ExpressionNetworkOptions& options) {
  namespace nn = torch::nn;
  const std::int64_t width = kTransitionFixedWidth + kTransitionStepWidth + kTransitionNoise;
  encoder = register_module("encoder",
                            nn::LSTM(nn::LSTMOptions(kTransitionPastWidth, options.encoder_units).batch_first(true)));
  state =
      register_module("state", nn::Linear(options.encoder_units + kTransitionFixedWidth, 2 * options.decoder_units));
  decoder = register_module("decoder", nn::LSTM(nn::LSTMOptions(width, options.decoder_units).batch_first(true)));
  output = register_module("output", nn::Linear(options.decoder_units, 1));
  // No residual to begin with: the base curve.
  torch::NoGradGuard guard;
  output->weight.mul_(0.1);
  output->bias.zero_();
}

torch::Tensor ExpressionMemberImpl::forward(const TransitionTensors& data, const torch::Tensor& noise) {
  const std::int64_t rows = data.fixed.size(0);
  const torch::Tensor encoded = std::get<0>(encoder->forward(data.past)).select(1, kTransitionPastSteps - 1);
  const torch::Tensor start = torch::tanh(state->forward(torch::cat({encoded, data.fixed}, 1)));
  const auto halves = start.chunk(2, 1);
  std::vector<torch::Tensor> steps;
  // The same numbers as transition_step_inputs gives, for all rows.
  for (Eigen::Index k = 0; k < kTransitionKnots; ++k) {
    Eigen::VectorXf inputs(kTransitionStepWidth);
    transition_step_inputs(k, 1, inputs);
    const float share_left = 1 - (inputs(0) + 1) / 2;
    const auto constant = [&](float value) { return torch::full({rows}, value); };
    steps.push_back(torch::stack(
        {constant(inputs(0)), constant(inputs(1)), (share_left * data.seconds).clamp_max(4.0F), constant(inputs(3))},
        1));
  }
  const torch::Tensor still = torch::cat({data.fixed, noise.index_select(0, data.owner)}, 1);
  const torch::Tensor sequence =
      torch::cat({still.unsqueeze(1).expand({rows, kTransitionKnots, still.size(1)}), torch::stack(steps, 1)}, 2);
  const auto decoded = decoder->forward(
      sequence, std::make_tuple(halves[0].unsqueeze(0).contiguous(), halves[1].unsqueeze(0).contiguous()));
  return output->forward(std::get<0>(decoded)).squeeze(2);
}

ExpressionNetworkImpl::ExpressionNetworkImpl(const ExpressionNetworkOptions& options) {
  for (std::int64_t i = 0; i < options.members; ++i)
    members.push_back(register_module("member_" + std::to_string(i), ExpressionMember(options)));
  duration_hidden = register_module("duration_hidden", torch::nn::Linear(kTransitionWholeWidth, 16));
  duration = register_module("duration", torch::nn::Linear(16, 1));
}

torch::Tensor ExpressionNetworkImpl::forward(const TransitionTensors& data) {
  const torch::Tensor none = torch::zeros({data.transitions, kTransitionNoise});
  std::vector<torch::Tensor> made;
  for (ExpressionMember& member : members) made.push_back(member->forward(data, none));
  return torch::stack(made).mean(0);
}

torch::Tensor ExpressionNetworkImpl::expected_log_seconds(const torch::Tensor& whole) {
  return duration->forward(torch::tanh(duration_hidden->forward(whole))).squeeze(1);
}

}  // namespace risorius
