// The same step in libtorch, in the same run; and with --golden FILE, the golden vectors of
// tests/generate/seed_generator_test.cpp: libtorch's rollout in double and in float.
#include <fmt/core.h>
#include <fstream>
#include <torch/torch.h>
#include <torch/version.h>

#include "bench/bench_report.h"
#include "bench/step_case.h"
#include "generate/train/seed_module.h"
#include "made_seed_weights.h"

namespace risorius::bench {
namespace {

SeedModule libtorch_network(const Safetensors& weights) {
  const torch::NoGradGuard guard;
  SeedModule network(test::kSeedAus);
  for (auto& item : network->named_parameters()) {
    const std::vector<float> values = weights.tensors.at(item.key()).values();
    item.value().copy_(torch::tensor(values).reshape(item.value().sizes()));
  }
  network->eval();
  return network;
}

torch::Tensor past_tensor() {
  const AuMatrix past = test::made_seed_past();
  return torch::tensor(std::vector<float>(past.data(), past.data() + past.size()))
      .reshape({1, past.rows(), past.cols()});
}
torch::Tensor target_tensor() {
  const Eigen::VectorXf target = test::made_seed_target();
  return torch::tensor(std::vector<float>(target.data(), target.data() + target.size())).unsqueeze(0);
}

Tensor exported(const torch::Tensor& values) {
  const torch::Tensor flat = values.to(torch::kFloat32).contiguous();
  return make_tensor({flat.data_ptr<float>(), static_cast<std::size_t>(flat.numel())}, flat.sizes().vec(),
                     TensorType::kF32);
}

void write_golden(const std::string& path) {
  const torch::NoGradGuard guard;
  SeedModule network = libtorch_network(test::made_seed_weights());
  const torch::Tensor single = network->forward(past_tensor(), target_tensor(), test::kRolloutFrames)[0];
  network->to(torch::kFloat64);
  const torch::Tensor exact =
      network->forward(past_tensor().to(torch::kFloat64), target_tensor().to(torch::kFloat64), test::kRolloutFrames)[0];
  Safetensors file;
  file.metadata = {{"made_by", "bench_step_libtorch --golden, libtorch " TORCH_VERSION}};
  file.tensors["reference"] = exported(exact);
  file.tensors["reference_rest"] = exported(exact - exact.to(torch::kFloat32).to(torch::kFloat64));
  file.tensors["libtorch"] = exported(single);
  std::ofstream(path, std::ios::binary) << safetensors_bytes(file);
  fmt::print("libtorch's largest error {:.3g}; written: {}\n", (single - exact).abs().max().item<double>(), path);
}

int run() {
  torch::set_num_threads(1);
  const torch::NoGradGuard guard;
  BenchReport report("step_libtorch");
  const Safetensors weights = test::made_seed_weights();
  const std::string place = "formula";
  SeedNetwork<float> wide({weights, place}, test::kSeedAus);
  SeedNetwork<Bf16> narrow({weights, place}, test::kSeedAus);
  wide.start(test::made_seed_past(), test::made_seed_target());
  narrow.start(test::made_seed_past(), test::made_seed_target());
  std::vector<float> frame(static_cast<std::size_t>(test::kSeedAus));
  SeedModule network = libtorch_network(weights);
  const torch::Tensor target = target_tensor().unsqueeze(1);
  torch::Tensor x = past_tensor().slice(1, 0, 1);
  std::tuple<torch::Tensor, torch::Tensor> encoded{torch::zeros({1, 1, kSeedEncoderUnits}),
                                                   torch::zeros({1, 1, kSeedEncoderUnits})},
      generated{torch::zeros({1, 1, kSeedGeneratorUnits}), torch::zeros({1, 1, kSeedGeneratorUnits})};
  const auto times = step_times_us(
      {{"fp32", [&] { wide.next(frame); }},
       {"bf16", [&] { narrow.next(frame); }},
       {"libtorch", [&] {
          torch::Tensor code, decoded;
          std::tie(code, encoded) = network->encoder->forward(x, encoded);
          std::tie(decoded, generated) = network->generator->forward(torch::cat({code, target}, 2), generated);
          x = network->output->forward(decoded);
        }}});
  report.add("libtorch", times.at("libtorch"));
  report.add("ours, fp32", times.at("fp32"));
  report.add("ours, bf16", times.at("bf16"));
  report.add("fp32 / libtorch", times.at("fp32") / times.at("libtorch"));
  report.add("bf16 / fp32", times.at("bf16") / times.at("fp32"));
  return report.finish();
}

}  // namespace
}  // namespace risorius::bench

int main(int argc, char** argv) {
  if (argc == 3 && std::string_view(argv[1]) == "--golden") {
    risorius::bench::write_golden(argv[2]);
    return 0;
  }
  return risorius::bench::run();
}
