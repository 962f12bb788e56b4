#include "generate/layers.h"

#include <cmath>
#include <gtest/gtest.h>

#include "made_weights.h"
#include "support/allocation_counter.h"

namespace risorius {
namespace {

using test::made_values;

double sigmoid(double x) { return 1 / (1 + std::exp(-x)); }

/// An LSTM in double, written gate by gate.
struct ReferenceLstm {
  std::size_t units, inputs;
  std::vector<float> ih, hh, bias_ih, bias_hh;
  std::vector<double> h = std::vector<double>(units, 0), c = h;

  void step(const std::vector<float>& x) {
    const std::vector<double> before = h;
    for (std::size_t u = 0; u < units; ++u) {
      double gate[4];
      for (std::size_t g = 0; g < 4; ++g) {
        const std::size_t row = g * units + u;
        gate[g] = static_cast<double>(bias_ih[row]) + static_cast<double>(bias_hh[row]);
        for (std::size_t i = 0; i < inputs; ++i)
          gate[g] += static_cast<double>(ih[row * inputs + i]) * static_cast<double>(x[i]);
        for (std::size_t i = 0; i < units; ++i) gate[g] += static_cast<double>(hh[row * units + i]) * before[i];
      }
      c[u] = sigmoid(gate[1]) * c[u] + sigmoid(gate[0]) * std::tanh(gate[2]);
      h[u] = sigmoid(gate[3]) * std::tanh(c[u]);
    }
  }
};

TEST(Dense, MultipliesAndAddsForAnyNumberOfColumns) {
  for (const std::size_t inputs : {1u, 7u, 8u, 9u, 31u}) {
    const auto weight = made_values(5 * inputs, 1, 3), bias = made_values(5, 1, 4), x = made_values(inputs, 1, 5);
    const Dense<float> dense(weight, bias);
    std::vector<float> y(5);
    dense.process(x, y);
    for (std::size_t row = 0; row < 5; ++row) {
      double sum = static_cast<double>(bias[row]);
      for (std::size_t i = 0; i < inputs; ++i)
        sum += static_cast<double>(weight[row * inputs + i]) * static_cast<double>(x[i]);
      EXPECT_NEAR(y[row], sum, 2e-6) << inputs;
    }
  }
  EXPECT_THROW(Dense<float>(made_values(10, 1, 1), made_values(3, 1, 1)), std::invalid_argument);
}

TEST(Lstm, FollowsItsEquations) {
  constexpr std::size_t kUnits = 24, kInputs = 11;
  const auto ih = made_values(4 * kUnits * kInputs, 0.4F, 1), hh = made_values(4 * kUnits * kUnits, 0.4F, 2),
             bih = made_values(4 * kUnits, 0.4F, 3), bhh = made_values(4 * kUnits, 0.4F, 4);
  Lstm<float> lstm(ih, hh, bih, bhh);
  ReferenceLstm reference{kUnits, kInputs, ih, hh, bih, bhh};
  for (std::uint64_t step = 0; step < 50; ++step) {
    const auto x = made_values(kInputs, 2, 100 + step);
    lstm.process(x);
    reference.step(x);
    for (std::size_t u = 0; u < kUnits; ++u) ASSERT_NEAR(lstm.hidden()[u], reference.h[u], 2e-6) << step;
  }
  lstm.reset();
  EXPECT_EQ(lstm.hidden()[3], 0);
  EXPECT_THROW(Lstm<float>(ih, hh, bih, made_values(3, 1, 1)), std::invalid_argument);
}

TEST(Lstm, TakesAStateAndGoesOnFromIt) {
  constexpr std::size_t kUnits = 8, kInputs = 3;
  const auto ih = made_values(4 * kUnits * kInputs, 0.5F, 1), hh = made_values(4 * kUnits * kUnits, 0.5F, 2),
             bias = made_values(4 * kUnits, 0.5F, 3), x = made_values(kInputs, 1, 9);
  Lstm<float> a(ih, hh, bias, bias), b(ih, hh, bias, bias);
  a.process(x);
  const std::vector<float> hidden(a.hidden().begin(), a.hidden().end()), cell(a.cell().begin(), a.cell().end());
  b.set_state(hidden, cell);
  a.process(x);
  b.process(x);
  for (std::size_t u = 0; u < kUnits; ++u) EXPECT_EQ(a.hidden()[u], b.hidden()[u]);
}

TEST(Lstm, Bf16WeightsGiveWhatTheirWidenedValuesGive) {
  constexpr std::size_t kUnits = 16, kInputs = 5;
  const auto rounded = [](std::vector<float> values) {
    for (float& value : values) value = from_bf16(to_bf16(value));
    return values;
  };
  const auto ih = rounded(made_values(4 * kUnits * kInputs, 0.5F, 1)),
             hh = rounded(made_values(4 * kUnits * kUnits, 0.5F, 2)), bias = made_values(4 * kUnits, 0.5F, 3);
  Lstm<float> wide(ih, hh, bias, bias);
  Lstm<Bf16> narrow(ih, hh, bias, bias);
  for (std::uint64_t step = 0; step < 20; ++step) {
    const auto x = made_values(kInputs, 1, step);
    wide.process(x);
    narrow.process(x);
  }
  for (std::size_t u = 0; u < kUnits; ++u) EXPECT_EQ(wide.hidden()[u], narrow.hidden()[u]);
}

TEST(Lstm, SurvivesLargeInputs) {
  const auto ih = made_values(4 * 4 * 2, 1, 1), hh = made_values(4 * 4 * 4, 1, 2), bias = made_values(16, 1, 3);
  Lstm<float> lstm(ih, hh, bias, bias);
  for (const float size : {1e3F, -1e5F, 1e30F}) {
    lstm.process(std::vector<float>{size, -size});
    for (const float h : lstm.hidden()) EXPECT_LE(std::abs(h), 1.0F);
  }
}

TEST(Lstm, AllocatesNothingInAStep) {
  const auto ih = made_values(4 * 16 * 4, 1, 1), hh = made_values(4 * 16 * 16, 1, 2), bias = made_values(64, 1, 3),
             x = made_values(4, 1, 4);
  Lstm<float> lstm(ih, hh, bias, bias);
  const Dense<Bf16> dense(made_values(3 * 16, 1, 5), made_values(3, 1, 6));
  std::vector<float> y(3);
  const auto before = test::allocations_of_this_thread();
  for (int step = 0; step < 10; ++step) {
    lstm.process(x);
    dense.process(lstm.hidden(), y);
  }
  EXPECT_EQ(test::allocations_of_this_thread(), before);
}

}  // namespace
}  // namespace risorius
