#include "generate/matrix_product.h"

#include <bit>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
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

// Rows and columns around the widths of vectors and blocks.
constexpr std::size_t kSizes[] = {1, 3, 7, 8, 9, 15, 16, 17, 31, 33, 64, 100};

TEST(MatrixProduct, GivesTheSameBitsWhateverTheWidthOfTheVectors) {
  std::mt19937 random(1);
  for (const std::size_t rows : kSizes) {
    for (const std::size_t columns : kSizes) {
      const auto weights = drawn(rows * columns, random), x = drawn(columns, random), start = drawn(rows, random);
      auto y = start;
      add_product(weights.data(), rows, x, y.data());
      ASSERT_EQ(y, promised(weights, x, start)) << rows << " x " << columns;
    }
  }
}

TEST(MatrixProduct, OfBf16IsThatOfItsWidenedWeights) {
  std::mt19937 random(2);
  for (const std::size_t rows : kSizes) {
    for (const std::size_t columns : kSizes) {
      auto widened = drawn(rows * columns, random);
      std::vector<Bf16> weights;
      for (float& weight : widened) {
        const auto upper = static_cast<std::uint16_t>(std::bit_cast<std::uint32_t>(weight) >> 16);
        weights.push_back({upper});
        weight = std::bit_cast<float>(std::uint32_t{upper} << 16);
      }
      const auto x = drawn(columns, random), start = drawn(rows, random);
      auto y = start;
      add_product(weights.data(), rows, x, y.data());
      ASSERT_EQ(y, promised(widened, x, start)) << rows << " x " << columns;
    }
  }
}

}  // namespace
}  // namespace risorius
