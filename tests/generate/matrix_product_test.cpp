#include "generate/matrix_product.h"

#include <array>
#include <bit>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <string>
#include <vector>

namespace risorius {
namespace {

std::vector<float> drawn(std::size_t count, std::mt19937& random) {
  std::normal_distribution<float> normal;
  std::vector<float> values(count);
  for (float& value : values) value = normal(random);
  return values;
}

/// In the order that matrix_product.h promises, a row at a time.
std::vector<float> promised(const std::vector<float>& weights, const std::vector<float>& x, std::vector<float> y) {
  const std::size_t rows = y.size();
  for (std::size_t i = 0; i < rows; ++i) {
    std::size_t j = 0;
    const auto weight = [&](std::size_t k) { return weights[(j + k) * rows + i]; };
    const auto chain = [&](std::size_t k) {
      float sum = weight(k) * x[j + k];
      for (std::size_t more = k + 1; more < k + 4; ++more) sum = std::fma(weight(more), x[j + more], sum);
      return sum;
    };
    for (; j + 8 <= x.size(); j += 8) y[i] += chain(0) + chain(4);
    for (; j < x.size(); ++j) y[i] = std::fma(weight(0), x[j], y[i]);
  }
  return y;
}

// Rows and columns around the widths of vectors and blocks; bf16 rows go by 2048.
constexpr std::size_t kSizes[] = {1, 3, 7, 8, 9, 15, 16, 17, 31, 33, 64, 100};
constexpr std::size_t kBlocks[] = {2047, 2048, 2049, 4097};

/// bf16 weights, and the same as floats.
struct Weights {
  std::vector<float> widened;
  std::vector<Bf16> bf16;
};

Weights drawn_weights(std::size_t count, std::mt19937& random) {
  Weights weights{drawn(count, random), {}};
  for (float& weight : weights.widened) {
    const auto upper = static_cast<std::uint16_t>(std::bit_cast<std::uint32_t>(weight) >> 16);
    weights.bf16.push_back({upper});
    weight = std::bit_cast<float>(std::uint32_t{upper} << 16);
  }
  return weights;
}

class MatrixProduct : public testing::TestWithParam<Vectors> {};

void expect_promised(Vectors vectors, std::size_t rows, std::size_t columns, std::mt19937& random) {
  const Weights weights = drawn_weights(rows * columns, random);
  const auto x = drawn(columns, random), start = drawn(rows, random);
  const auto wanted = promised(weights.widened, x, start);
  auto of_floats = start, of_bf16 = start;
  add_product_with(vectors, weights.widened.data(), rows, x, of_floats.data());
  add_product_with(vectors, weights.bf16.data(), rows, x, of_bf16.data());
  ASSERT_EQ(of_floats, of_bf16) << rows << " x " << columns;
  if (vectors != Vectors::kNarrow) {
    ASSERT_EQ(of_floats, wanted) << rows << " x " << columns;
    return;
  }
  for (std::size_t i = 0; i < rows; ++i) {  // each product rounded, too
    ASSERT_NEAR(of_floats[i], wanted[i], 1e-6 * static_cast<double>(columns + 10)) << rows << " x " << columns;
  }
}

TEST_P(MatrixProduct, IsThePromisedSumForFloatsAndBf16Weights) {
  if (!has_vectors(GetParam())) GTEST_SKIP() << "not on this processor";
  std::mt19937 random(1);
  for (const std::size_t columns : kSizes) {
    for (const std::size_t rows : kSizes) expect_promised(GetParam(), rows, columns, random);
  }
  for (const std::size_t rows : kBlocks) expect_promised(GetParam(), rows, 19, random);
}

INSTANTIATE_TEST_SUITE_P(
    Vectors, MatrixProduct, testing::Values(Vectors::kNarrow, Vectors::kAvx2, Vectors::kAvx512),
    [](const auto& parameter) {
      return std::string(std::array{"Narrow", "Avx2", "Avx512"}[static_cast<int>(parameter.param)]);
    });

TEST(WidestVectors, AreOfThisProcessorAndUsedByDefault) {
  EXPECT_TRUE(has_vectors(widest_vectors()));
  std::mt19937 random(2);
  const Weights weights = drawn_weights(33 * 17, random);
  const auto x = drawn(17, random), start = drawn(33, random);
  auto chosen = start, given = start;
  add_product(weights.bf16.data(), 33, x, chosen.data());
  add_product_with(widest_vectors(), weights.bf16.data(), 33, x, given.data());
  EXPECT_EQ(chosen, given);
}

}  // namespace
}  // namespace risorius
