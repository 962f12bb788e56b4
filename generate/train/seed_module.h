// Seed 003's network in libtorch: what generate/seed_network.h runs, with the same names of weights. Its section 5.2.
#pragma once

#include <torch/torch.h>

namespace risorius {

/// The cures that seed 003 proposes for its network (section 7.3, 7.2.2).
struct SeedModuleOptions {
  bool initialiser = false;   ///< hidden states from the first frame and the target, not zero
  bool deep_decoder = false;  ///< three layers instead of one
};

struct SeedModuleImpl : torch::nn::Module {
  SeedModuleImpl(std::int64_t aus, const SeedModuleOptions& options = {});

  /// B x `frames` x A: frames after `past` (B x 20 x A), each fed back. `target`: B x A.
  torch::Tensor forward(const torch::Tensor& past, const torch::Tensor& target, std::int64_t frames);

  torch::nn::LSTM encoder{nullptr}, generator{nullptr};
  torch::nn::Linear output{nullptr}, decode_1{nullptr}, decode_2{nullptr}, initialiser_1{nullptr},
      initialiser_2{nullptr};
};
TORCH_MODULE(SeedModule);

}  // namespace risorius
