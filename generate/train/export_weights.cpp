#include "generate/train/export_weights.h"

#include "generate/safetensors.h"
#include "replay/atomic_file.h"

namespace risorius {

void export_weights(const torch::nn::Module& network, std::map<std::string, std::string> metadata,
                    const std::filesystem::path& path) {
  Safetensors file{std::move(metadata), {}};
  for (const auto& item : network.named_parameters()) {
    const torch::Tensor values = item.value().detach().contiguous();
    file.tensors[item.key()] = make_tensor({values.data_ptr<float>(), static_cast<std::size_t>(values.numel())},
                                           values.sizes().vec(), TensorType::kBf16);
  }
  AtomicFile out(path);
  out.write(safetensors_bytes(file));
  out.commit();
}

void round_weights(torch::nn::Module& network) {
  const torch::NoGradGuard guard;
  for (torch::Tensor& parameter : network.parameters())
    parameter.copy_(parameter.to(torch::kBFloat16).to(torch::kFloat32));
}

}  // namespace risorius
