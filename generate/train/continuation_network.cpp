#include "generate/train/continuation_network.h"

#include "generate/continuation_features.h"

namespace risorius {
namespace {

constexpr std::int64_t kLags = static_cast<std::int64_t>(kContinuationLagsMs.size());
constexpr std::int64_t kOutputs = 2 * static_cast<std::int64_t>(kContinuationHorizonsMs.size());
constexpr double kNinety = 1.645, kShare = 0.9;

}  // namespace

ContinuationNetworkImpl::ContinuationNetworkImpl(ContinuationArchitecture architecture, std::int64_t units) {
  namespace nn = torch::nn;
  std::int64_t width = kContinuationWidth;
  if (architecture == ContinuationArchitecture::kLstm) {
    memory = register_module("memory", nn::LSTM(nn::LSTMOptions(1, units).batch_first(true)));
    width += units;
  }
  input = register_module("input", nn::Linear(width, units));
  first = register_module("first", nn::Linear(units, units));
  second = register_module("second", nn::Linear(units, units));
  output = register_module("output", nn::Linear(units, kOutputs));
  // No residual to begin with: damped velocity.
  torch::NoGradGuard guard;
  output->weight.mul_(0.1);
  output->bias.zero_();
}

torch::Tensor ContinuationNetworkImpl::forward(const torch::Tensor& inputs) {
  torch::Tensor joined = inputs;
  if (memory) {
    const torch::Tensor past = inputs.slice(1, 0, kLags).flip(1).unsqueeze(2);  // oldest first
    joined = torch::cat({inputs, std::get<0>(memory->forward(past)).select(1, kLags - 1)}, 1);
  }
  torch::Tensor hidden = torch::silu(input->forward(joined));
  hidden = hidden + torch::silu(first->forward(hidden));
  hidden = hidden + torch::silu(second->forward(hidden));
  return output->forward(hidden);
}

ContinuationPrediction predict(ContinuationNetwork& network, const ContinuationTensors& data) {
  const auto halves = network->forward(data.inputs).chunk(2, 1);
  const torch::Tensor scale = data.scale.unsqueeze(1), value = data.value.unsqueeze(1);
  const torch::Tensor at = value + data.damped + scale * halves[0];
  return {at.clamp(0, 1.2) - value, scale * halves[1].clamp(-8, 4).exp()};
}

torch::Tensor continuation_loss(const ContinuationPrediction& predicted, const ContinuationTensors& data) {
  const torch::Tensor error = (predicted.change - data.change).abs();
  // Each horizon and strength counts in its own units for the deviations, in intensities for the values.
  const torch::Tensor over = error.detach() - kNinety * predicted.deviation;
  const torch::Tensor pinball = torch::maximum(kShare * over, (kShare - 1) * over) / data.scale.unsqueeze(1).sqrt();
  return error.mean() + 0.2 * pinball.mean();
}

}  // namespace risorius
