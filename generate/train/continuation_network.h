// The continuation networks as libtorch trains them: the all-MLP one that generate/learned_continuation.h runs, and an
// LSTM over the lags that it is compared with. Both give, per row, five residuals and five logarithms of standard
// deviations, in units of the row's scale.
#pragma once

#include <torch/torch.h>

#include "generate/train/continuation_data.h"

namespace risorius {

enum class ContinuationArchitecture : std::uint8_t { kMlp, kLstm };

struct ContinuationNetworkImpl : torch::nn::Module {
  ContinuationNetworkImpl(ContinuationArchitecture architecture, std::int64_t units);
  torch::Tensor forward(const torch::Tensor& inputs);

  torch::nn::Linear input{nullptr}, first{nullptr}, second{nullptr}, output{nullptr};
  torch::nn::LSTM memory{nullptr};
};
TORCH_MODULE(ContinuationNetwork);

/// Of the values at all horizons: the mean, and the standard deviation.
struct ContinuationPrediction {
  torch::Tensor change, deviation;  ///< R x horizons
};
ContinuationPrediction predict(ContinuationNetwork& network, const ContinuationTensors& data);

/// Absolute error, and the pinball loss of nine tenths of the absolute error at 1.645 standard deviations.
torch::Tensor continuation_loss(const ContinuationPrediction& predicted, const ContinuationTensors& data);

}  // namespace risorius
