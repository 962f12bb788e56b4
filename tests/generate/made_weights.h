// Weights by formula, for tests: small numbers from a counter, the same everywhere.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <numeric>
#include <string>
#include <vector>

#include "generate/safetensors.h"

namespace risorius::test {

/// Evenly spread in [-reach, reach), by SplitMix64 (Steele, Lea & Flood 2014).
inline std::vector<float> made_values(std::size_t count, float reach, std::uint64_t seed) {
  std::vector<float> values(count);
  std::uint64_t state = seed;
  for (float& value : values) {
    std::uint64_t x = state += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    value = reach * (static_cast<float>((x ^ (x >> 31)) >> 40) * 0x1p-23F - 1);
  }
  return values;
}

inline void add_tensor(Safetensors& file, const std::string& name, std::initializer_list<std::int64_t> shape,
                       float reach, TensorType type = TensorType::kF32) {
  const auto count = static_cast<std::size_t>(
      std::accumulate(shape.begin(), shape.end(), std::int64_t{1}, [](auto a, auto b) { return a * b; }));
  file.tensors[name] = make_tensor(made_values(count, reach, 1 + file.tensors.size()), shape, type);
}

inline void add_dense(Safetensors& file, const std::string& name, std::int64_t outputs, std::int64_t inputs,
                      float reach) {
  add_tensor(file, name + ".weight", {outputs, inputs}, reach);
  add_tensor(file, name + ".bias", {outputs}, reach);
}

inline void add_lstm(Safetensors& file, const std::string& name, std::int64_t units, std::int64_t inputs, float reach) {
  add_tensor(file, name + ".weight_ih_l0", {4 * units, inputs}, reach);
  add_tensor(file, name + ".weight_hh_l0", {4 * units, units}, reach);
  add_tensor(file, name + ".bias_ih_l0", {4 * units}, reach);
  add_tensor(file, name + ".bias_hh_l0", {4 * units}, reach);
}

}  // namespace risorius::test
