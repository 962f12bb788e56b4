#include "generate/matrix_product.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace risorius {
namespace {

inline std::array<float, 8> eight_of(std::span<const float> x, std::size_t from) noexcept {
  std::array<float, 8> eight{};
  std::copy_n(x.begin() + static_cast<std::ptrdiff_t>(from), eight.size(), eight.begin());
  return eight;
}

/// Whether a product and its sum are one instruction. Where the processor has none, std::fma would be a call for each.
enum class Arithmetic : bool { kSeparate, kFused };

template <Arithmetic kind>
[[gnu::always_inline]] inline float multiply_add(float a, float b, float c) noexcept {
  if constexpr (kind == Arithmetic::kFused) return std::fma(a, b, c);
  return a * b + c;
}

/// What eight columns add to a row, in the order that the header promises.
template <Arithmetic kind, typename Term>
[[gnu::always_inline]] inline float sum_of_eight(const Term& weight, const float* x) noexcept {
  const auto chain = [&](std::size_t k) {
    float sum = weight(k) * x[k];
    for (std::size_t more = k + 1; more < k + 4; ++more) sum = multiply_add<kind>(weight(more), x[more], sum);
    return sum;
  };
  const float first = chain(0), second = chain(4);
  return first + second;
}

/// Compiled once for each kind of vectors, into the functions below.
template <Arithmetic kind>
[[gnu::always_inline]] inline void sum(const float* weights, std::size_t rows, std::span<const float> x,
                                       float* __restrict y) noexcept {
  std::size_t j = 0;
  for (; j + 8 <= x.size(); j += 8) {
    const float* __restrict w = weights + j * rows;
    const std::array<float, 8> eight = eight_of(x, j);
    for (std::size_t i = 0; i < rows; ++i)
      y[i] += sum_of_eight<kind>([&](std::size_t k) { return w[i + k * rows]; }, eight.data());
  }
  for (; j < x.size(); ++j) {
    const float* __restrict w = weights + j * rows;
    const float a = x[j];
    for (std::size_t i = 0; i < rows; ++i) y[i] = multiply_add<kind>(w[i], a, y[i]);
  }
}

static_assert(std::endian::native == std::endian::little);  // the even row's weight is the lower half of a pair

inline std::uint32_t pair_at(const Bf16* weights) noexcept {
  std::uint32_t pair = 0;
  std::memcpy(&pair, weights, sizeof(pair));
  return pair;
}
inline float even_of(std::uint32_t pair) noexcept { return std::bit_cast<float>(pair << 16); }
inline float odd_of(std::uint32_t pair) noexcept { return std::bit_cast<float>(pair & 0xffff0000u); }

/// Two weights are widened by a shift and a mask where each alone would take a shuffle and a shift: what a step with
/// bf16 weights lasts is arithmetic, no longer memory. `even` and `odd`: sums of every other row; `pairs` of them.
template <Arithmetic kind>
[[gnu::always_inline]] inline void sum_pairs(const Bf16* weights, std::size_t rows, std::size_t pairs,
                                             std::span<const float> x, float* __restrict even,
                                             float* __restrict odd) noexcept {
  std::size_t j = 0;
  for (; j + 8 <= x.size(); j += 8) {
    const Bf16* __restrict w = weights + j * rows;
    const std::array<float, 8> eight = eight_of(x, j);
    for (std::size_t i = 0; i < pairs; ++i) {
      const auto pair = [&](std::size_t k) { return pair_at(w + 2 * i + k * rows); };
      even[i] += sum_of_eight<kind>([&](std::size_t k) { return even_of(pair(k)); }, eight.data());
      odd[i] += sum_of_eight<kind>([&](std::size_t k) { return odd_of(pair(k)); }, eight.data());
    }
  }
  for (; j < x.size(); ++j) {
    const Bf16* __restrict w = weights + j * rows;
    const float a = x[j];
    for (std::size_t i = 0; i < pairs; ++i) {
      const std::uint32_t pair = pair_at(w + 2 * i);
      even[i] = multiply_add<kind>(even_of(pair), a, even[i]);
      odd[i] = multiply_add<kind>(odd_of(pair), a, odd[i]);
    }
  }
}

/// The row that an odd number of them leaves over.
template <Arithmetic kind>
[[gnu::always_inline]] inline float sum_row(const Bf16* weights, std::size_t rows, std::span<const float> x,
                                            float y) noexcept {
  const auto weight = [&](std::size_t j) {
    return std::bit_cast<float>(static_cast<std::uint32_t>(weights[j * rows].bits) << 16);
  };
  std::size_t j = 0;
  for (; j + 8 <= x.size(); j += 8) y += sum_of_eight<kind>([&](std::size_t k) { return weight(j + k); }, x.data() + j);
  for (; j < x.size(); ++j) y = multiply_add<kind>(weight(j), x[j], y);
  return y;
}

constexpr std::size_t kPairs = 1024;  ///< at once; an LSTM's gates are 2048 rows

template <Arithmetic kind>
[[gnu::always_inline]] inline void sum(const Bf16* weights, std::size_t rows, std::span<const float> x,
                                       float* __restrict y) noexcept {
  float even[kPairs], odd[kPairs];
  for (std::size_t first = 0; first + 1 < rows; first += 2 * kPairs) {
    const std::size_t pairs = std::min(kPairs, (rows - first) / 2);
    for (std::size_t i = 0; i < pairs; ++i) {
      even[i] = y[first + 2 * i];
      odd[i] = y[first + 2 * i + 1];
    }
    sum_pairs<kind>(weights + first, rows, pairs, x, even, odd);
    for (std::size_t i = 0; i < pairs; ++i) {
      y[first + 2 * i] = even[i];
      y[first + 2 * i + 1] = odd[i];
    }
  }
  if (rows % 2 == 1) y[rows - 1] = sum_row<kind>(weights + rows - 1, rows, x, y[rows - 1]);
}

template <typename Weight>
using Sum = void (*)(const Weight* weights, std::size_t rows, std::span<const float> x, float* y) noexcept;

template <typename Weight>
void sum_narrow(const Weight* weights, std::size_t rows, std::span<const float> x, float* y) noexcept {
  sum<Arithmetic::kSeparate>(weights, rows, x, y);
}

#if defined(__x86_64__)
template <typename Weight>
[[gnu::target("avx2,fma")]] void sum_avx2(const Weight* weights, std::size_t rows, std::span<const float> x,
                                          float* y) noexcept {
  sum<Arithmetic::kFused>(weights, rows, x, y);
}

template <typename Weight>
[[gnu::target("avx512f,avx512bw,avx512vl,fma")]] void sum_avx512(const Weight* weights, std::size_t rows,
                                                                 std::span<const float> x, float* y) noexcept {
  sum<Arithmetic::kFused>(weights, rows, x, y);
}
#endif

template <typename Weight>
Sum<Weight> sum_with(Vectors vectors) noexcept {
#if defined(__x86_64__)
  if (vectors == Vectors::kAvx512) return &sum_avx512<Weight>;
  if (vectors == Vectors::kAvx2) return &sum_avx2<Weight>;
#endif
  return &sum_narrow<Weight>;
}

const Sum<float> sum_of_floats = sum_with<float>(widest_vectors());
const Sum<Bf16> sum_of_bf16 = sum_with<Bf16>(widest_vectors());

}  // namespace

bool has_vectors(Vectors vectors) noexcept {
#if defined(__x86_64__)
  __builtin_cpu_init();
  const bool fma = __builtin_cpu_supports("fma") != 0;
  if (vectors == Vectors::kAvx2) return fma && __builtin_cpu_supports("avx2") != 0;
  if (vectors == Vectors::kAvx512)
    return fma && __builtin_cpu_supports("avx512bw") != 0 && __builtin_cpu_supports("avx512vl") != 0;
#endif
  return vectors == Vectors::kNarrow;
}

Vectors widest_vectors() noexcept {
  for (const Vectors vectors : {Vectors::kAvx512, Vectors::kAvx2}) {
    if (has_vectors(vectors)) return vectors;
  }
  return Vectors::kNarrow;
}

void add_product(const float* weights, std::size_t rows, std::span<const float> x, float* y) noexcept {
  sum_of_floats(weights, rows, x, y);
}

void add_product(const Bf16* weights, std::size_t rows, std::span<const float> x, float* y) noexcept {
  sum_of_bf16(weights, rows, x, y);
}

void add_product_with(Vectors vectors, const float* weights, std::size_t rows, std::span<const float> x,
                      float* y) noexcept {
  sum_with<float>(vectors)(weights, rows, x, y);
}

void add_product_with(Vectors vectors, const Bf16* weights, std::size_t rows, std::span<const float> x,
                      float* y) noexcept {
  sum_with<Bf16>(vectors)(weights, rows, x, y);
}

}  // namespace risorius
