#include "generate/train/seed_module.h"

#include "generate/seed_network.h"

namespace risorius {

SeedModuleImpl::SeedModuleImpl(std::int64_t aus, const SeedModuleOptions& options) {
  namespace nn = torch::nn;
  encoder = register_module("encoder", nn::LSTM(nn::LSTMOptions(aus, kSeedEncoderUnits).batch_first(true)));
  generator = register_module(
      "generator", nn::LSTM(nn::LSTMOptions(kSeedEncoderUnits + aus, kSeedGeneratorUnits).batch_first(true)));
  if (options.deep_decoder) {
    decode_1 = register_module("decode_1", nn::Linear(kSeedGeneratorUnits, kSeedDecodeUnits));
    decode_2 = register_module("decode_2", nn::Linear(kSeedDecodeUnits, kSeedDecodeUnits));
  }
  output = register_module("output", nn::Linear(options.deep_decoder ? kSeedDecodeUnits : kSeedGeneratorUnits, aus));
  if (options.initialiser) {
    initialiser_1 = register_module("initialiser_1", nn::Linear(2 * aus, kSeedInitialiserUnits));
    initialiser_2 = register_module("initialiser_2",
                                    nn::Linear(kSeedInitialiserUnits, 2 * (kSeedEncoderUnits + kSeedGeneratorUnits)));
  }
}

torch::Tensor SeedModuleImpl::forward(const torch::Tensor& past, const torch::Tensor& target, std::int64_t frames) {
  using State = std::tuple<torch::Tensor, torch::Tensor>;
  const auto options = past.options();
  const std::int64_t batch = past.size(0);
  State encoded{torch::zeros({1, batch, kSeedEncoderUnits}, options),
                torch::zeros({1, batch, kSeedEncoderUnits}, options)};
  State generated{torch::zeros({1, batch, kSeedGeneratorUnits}, options),
                  torch::zeros({1, batch, kSeedGeneratorUnits}, options)};
  const auto leaky = [](const torch::Tensor& x) { return torch::leaky_relu(x, static_cast<double>(kSeedLeak)); };
  if (initialiser_1) {
    const torch::Tensor ends = torch::cat({past.select(1, 0), target}, 1);
    const auto states =
        initialiser_2->forward(leaky(initialiser_1->forward(ends)))
            .split_with_sizes({kSeedEncoderUnits, kSeedEncoderUnits, kSeedGeneratorUnits, kSeedGeneratorUnits}, 1);
    const auto one = [&](std::size_t i) { return states[i].unsqueeze(0).contiguous(); };
    encoded = {one(0), one(1)};
    generated = {one(2), one(3)};
  }
  torch::Tensor code;
  std::tie(code, encoded) = encoder->forward(past, encoded);
  code = code.slice(1, past.size(1) - 1);
  std::vector<torch::Tensor> result;
  for (std::int64_t frame = 0; frame < frames; ++frame) {
    torch::Tensor decoded;
    std::tie(decoded, generated) = generator->forward(torch::cat({code, target.unsqueeze(1)}, 2), generated);
    if (decode_1) decoded = leaky(decode_2->forward(leaky(decode_1->forward(decoded))));
    result.push_back(output->forward(decoded));
    if (frame + 1 < frames) std::tie(code, encoded) = encoder->forward(result.back(), encoded);
  }
  return torch::cat(result, 1);
}

}  // namespace risorius
