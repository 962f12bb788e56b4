// Seed 003's network with weights by formula, rounded to bf16: for golden vectors and for measuring its step. The size
// of its layers is what counts there, not what they know.
#pragma once

#include "generate/seed_network.h"
#include "made_weights.h"

namespace risorius::test {

inline constexpr std::int64_t kSeedAus = 15;  ///< of the thesis; 1,894,927 weights

/// Reaches as PyTorch's own initial weights have them.
inline Safetensors made_seed_weights() {
  Safetensors file;
  file.metadata = {{"model", "seed"},
                   {"rate_hz", "120"},
                   {"channels", "AU1L,AU1R,AU2L,AU2R,AU4L,AU4R,AU6L,AU6R,AU9,AU10,AU13L,AU13R,AU18,AU22,AU27"}};
  const auto lstm = [&](const std::string& name, std::int64_t units, std::int64_t inputs, float reach) {
    add_tensor(file, name + ".weight_ih_l0", {4 * units, inputs}, reach, TensorType::kBf16);
    add_tensor(file, name + ".weight_hh_l0", {4 * units, units}, reach, TensorType::kBf16);
    add_tensor(file, name + ".bias_ih_l0", {4 * units}, reach, TensorType::kBf16);
    add_tensor(file, name + ".bias_hh_l0", {4 * units}, reach, TensorType::kBf16);
  };
  lstm("encoder", kSeedEncoderUnits, kSeedAus, 1.0F / 16);
  lstm("generator", kSeedGeneratorUnits, kSeedEncoderUnits + kSeedAus, 0.0442F);
  // Larger, so that what is fed back matters.
  add_tensor(file, "output.weight", {kSeedAus, kSeedGeneratorUnits}, 0.3F, TensorType::kBf16);
  add_tensor(file, "output.bias", {kSeedAus}, 0.3F, TensorType::kBf16);
  return file;
}

/// A past and a target by formula.
inline AuMatrix made_seed_past() {
  const auto values = made_values(static_cast<std::size_t>(kSeedPastFrames * kSeedAus), 0.5F, 77);
  AuMatrix past(kSeedPastFrames, kSeedAus);
  for (Eigen::Index i = 0; i < past.size(); ++i) past.data()[i] = 0.5F + values[static_cast<std::size_t>(i)];
  return past;
}
inline Eigen::VectorXf made_seed_target() {
  const auto values = made_values(static_cast<std::size_t>(kSeedAus), 0.5F, 78);
  Eigen::VectorXf target(kSeedAus);
  for (Eigen::Index i = 0; i < target.size(); ++i) target(i) = 0.5F + values[static_cast<std::size_t>(i)];
  return target;
}

inline constexpr Eigen::Index kRolloutFrames = 100;

}  // namespace risorius::test
