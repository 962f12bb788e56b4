// The loop that every training goes through: steps, learning rate along half a cosine, measurement on held-out data,
// checkpoints, figures. A training that was interrupted goes on from its last checkpoint and gives the same weights as
// one that was not: what a step draws follows from the seed and the step alone.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <torch/torch.h>
#include <utility>
#include <vector>

namespace risorius {

struct TrainingOptions {
  std::int64_t steps = 1000;
  std::uint64_t seed = 1;
  double learning_rate = 3e-3;
  double weight_decay = 1e-4;
  double most_gradient = 1;          ///< norm, clipped
  std::int64_t measure_every = 250;  ///< steps; then a checkpoint is written, too
  std::filesystem::path folder;      ///< of checkpoint and figures
  std::string name;                  ///< of the model; begins the files' names
  std::string what;                  ///< whatever else the weights depend on; a checkpoint of another is refused
};

using Measurements = std::vector<std::pair<std::string, double>>;

/// `loss(step)` draws a batch; `measure()` says figures of held-out data, always the same ones. Writes NAME.csv and
/// NAME.png beside the checkpoint. Throws UserError if the folder cannot be written or the checkpoint is another
/// training's.
Measurements train(torch::nn::Module& network, const TrainingOptions& options,
                   const std::function<torch::Tensor(std::int64_t step)>& loss,
                   const std::function<Measurements()>& measure);

}  // namespace risorius
