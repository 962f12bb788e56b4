// Layers out of a safetensors file, by the names that PyTorch's modules give their weights.
#pragma once

#include <array>
#include <string>

#include "generate/layers.h"
#include "generate/safetensors.h"

namespace risorius {

struct WeightsReader {
  const Safetensors& file;
  const std::string& place;  ///< stands in messages

  /// Throws UserError where the tensor is missing or has another shape.
  std::vector<float> values(const std::string& name, std::initializer_list<std::int64_t> shape) const {
    return file.require(place, name, {shape.begin(), shape.size()}).values();
  }
  /// Rows of a matrix that must be there, whatever their number.
  std::int64_t rows(const std::string& name) const {
    const auto found = file.tensors.find(name);
    return found == file.tensors.end() || found->second.shape.empty() ? 0 : found->second.shape.front();
  }
  template <typename Weight>
  Dense<Weight> dense(const std::string& name, std::int64_t outputs, std::int64_t inputs) const {
    return {values(name + ".weight", {outputs, inputs}), values(name + ".bias", {outputs})};
  }
  template <typename Weight>
  Lstm<Weight> lstm(const std::string& name, std::int64_t units, std::int64_t inputs) const {
    return {values(name + ".weight_ih_l0", {4 * units, inputs}), values(name + ".weight_hh_l0", {4 * units, units}),
            values(name + ".bias_ih_l0", {4 * units}), values(name + ".bias_hh_l0", {4 * units})};
  }
};

}  // namespace risorius
