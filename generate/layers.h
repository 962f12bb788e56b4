// The two layers that the generators are made of, for one vector at a time: a step of a network reads its weights once
// and is bound by memory, so weights can be kept as bf16 and a step of an LSTM is one matrix-vector product.
//
// generate/matrix_product.h has the product and how weights lie.
#pragma once

#include <Eigen/Core>
#include <cstring>
#include <span>
#include <stdexcept>
#include <vector>

#include "generate/matrix_product.h"
#include "generate/safetensors.h"

namespace risorius {

inline void narrow(float value, float& to) noexcept { to = value; }
inline void narrow(float value, Bf16& to) noexcept { to.bits = to_bf16(value); }

/// Column after column out of rows x columns in row-major order, to `columns` from `first_column` on.
template <typename Weight>
void place_columns(std::span<const float> row_major, std::size_t rows, std::size_t first_column,
                   std::vector<Weight>& weights) {
  const std::size_t columns = row_major.size() / rows;
  for (std::size_t i = 0; i < rows; ++i) {
    for (std::size_t j = 0; j < columns; ++j)
      narrow(row_major[i * columns + j], weights[(first_column + j) * rows + i]);
  }
}

/// y = W x + b.
template <typename Weight>
class Dense {
 public:
  Dense() = default;
  /// `weight`: outputs x inputs, row-major; `bias`: outputs. Throws std::invalid_argument.
  Dense(std::span<const float> weight, std::span<const float> bias)
      : inputs_(bias.empty() ? 0 : weight.size() / bias.size()),
        bias_(bias.begin(), bias.end()),
        weights_(weight.size()) {
    if (bias.empty() || weight.size() != inputs_ * bias.size())
      throw std::invalid_argument("Dense: weight and bias do not fit");
    place_columns<Weight>(weight, bias_.size(), 0, weights_);
  }

  std::size_t inputs() const noexcept { return inputs_; }
  std::size_t outputs() const noexcept { return bias_.size(); }

  /// Sizes as constructed; x and y apart.
  void process(std::span<const float> x, std::span<float> y) const noexcept {
    std::memcpy(y.data(), bias_.data(), bias_.size() * sizeof(float));
    add_product(weights_.data(), bias_.size(), x.first(inputs_), y.data());
  }

 private:
  std::size_t inputs_ = 0;
  std::vector<float> bias_;
  std::vector<Weight> weights_;
};

/// 1 / (1 + exp(-x)), over an array.
inline void apply_sigmoid(Eigen::Ref<Eigen::ArrayXf> x) noexcept { x = (1 + (-x).exp()).inverse(); }
/// Not out of exp: near 0, where states live, that would lose what the sums have kept.
inline void apply_tanh(Eigen::Ref<Eigen::ArrayXf> x) noexcept { x = x.tanh(); }

/// A long short-term memory (Hochreiter & Schmidhuber 1997; gates in PyTorch's order: input, forget, cell, output), as
/// equations 2.1 to 2.6 of seed 003. Holds its state; copies share nothing.
template <typename Weight>
class Lstm {
 public:
  Lstm() = default;
  /// weight_ih: 4 H x I, weight_hh: 4 H x H, row-major; biases 4 H each. Throws std::invalid_argument.
  Lstm(std::span<const float> weight_ih, std::span<const float> weight_hh, std::span<const float> bias_ih,
       std::span<const float> bias_hh)
      : units_(bias_ih.size() / 4),
        inputs_(bias_ih.empty() ? 0 : weight_ih.size() / bias_ih.size()),
        bias_(bias_ih.begin(), bias_ih.end()),
        weights_(weight_ih.size() + weight_hh.size()) {
    const std::size_t gates = 4 * units_;
    if (units_ == 0 || bias_ih.size() != gates || bias_hh.size() != gates || weight_ih.size() != gates * inputs_ ||
        weight_hh.size() != gates * units_)
      throw std::invalid_argument("Lstm: weights and biases do not fit");
    for (std::size_t i = 0; i < gates; ++i) bias_[i] += bias_hh[i];
    place_columns<Weight>(weight_ih, gates, 0, weights_);
    place_columns<Weight>(weight_hh, gates, inputs_, weights_);
    joined_ = Eigen::ArrayXf::Zero(static_cast<Eigen::Index>(inputs_ + units_));
    gates_ = Eigen::ArrayXf::Zero(static_cast<Eigen::Index>(gates));
    cell_ = Eigen::ArrayXf::Zero(static_cast<Eigen::Index>(units_));
  }

  std::size_t inputs() const noexcept { return inputs_; }
  std::size_t units() const noexcept { return units_; }

  void reset() noexcept {
    joined_.setZero();
    cell_.setZero();
  }
  /// Hidden and cell state, H each.
  void set_state(std::span<const float> hidden, std::span<const float> cell) noexcept {
    std::memcpy(joined_.data() + inputs_, hidden.data(), units_ * sizeof(float));
    std::memcpy(cell_.data(), cell.data(), units_ * sizeof(float));
  }
  std::span<const float> hidden() const noexcept { return {joined_.data() + inputs_, units_}; }
  std::span<const float> cell() const noexcept { return {cell_.data(), units_}; }

  /// One step; the output is hidden().
  void process(std::span<const float> x) noexcept {
    std::memcpy(joined_.data(), x.data(), inputs_ * sizeof(float));
    std::memcpy(gates_.data(), bias_.data(), bias_.size() * sizeof(float));
    add_product(weights_.data(), bias_.size(), {joined_.data(), inputs_ + units_}, gates_.data());
    const auto n = static_cast<Eigen::Index>(units_);
    apply_sigmoid(gates_.head(2 * n));
    apply_tanh(gates_.segment(2 * n, n));
    apply_sigmoid(gates_.tail(n));
    cell_ = gates_.segment(n, n) * cell_ + gates_.head(n) * gates_.segment(2 * n, n);
    auto hidden = joined_.tail(n);
    hidden = cell_;
    apply_tanh(hidden);
    hidden *= gates_.tail(n);
  }

 private:
  std::size_t units_ = 0, inputs_ = 0;
  std::vector<float> bias_;
  std::vector<Weight> weights_;
  Eigen::ArrayXf joined_;  ///< [x; h]: what the merged weights multiply
  Eigen::ArrayXf gates_, cell_;
};

}  // namespace risorius
