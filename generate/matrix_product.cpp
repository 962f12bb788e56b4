#include "generate/matrix_product.h"

namespace risorius {
namespace {

inline float widened(float value) noexcept { return value; }
inline float widened(Bf16 value) noexcept { return std::bit_cast<float>(static_cast<std::uint32_t>(value.bits) << 16); }

/// Compiled once for each kind of vectors, into the functions below.
template <typename Weight>
[[gnu::always_inline]] inline void sum(const Weight* weights, std::size_t rows, std::span<const float> x,
                                       float* __restrict y) noexcept {
  std::size_t j = 0;
  for (; j + 8 <= x.size(); j += 8) {
    const Weight* __restrict w = weights + j * rows;
    const float a = x[j], b = x[j + 1], c = x[j + 2], d = x[j + 3], e = x[j + 4], f = x[j + 5], g = x[j + 6],
                h = x[j + 7];
    for (std::size_t i = 0; i < rows; ++i) {
      const float first = (widened(w[i]) * a + widened(w[i + rows]) * b) +
                          (widened(w[i + 2 * rows]) * c + widened(w[i + 3 * rows]) * d);
      const float second = (widened(w[i + 4 * rows]) * e + widened(w[i + 5 * rows]) * f) +
                           (widened(w[i + 6 * rows]) * g + widened(w[i + 7 * rows]) * h);
      y[i] += first + second;
    }
  }
  for (; j < x.size(); ++j) {
    const Weight* __restrict w = weights + j * rows;
    const float a = x[j];
    for (std::size_t i = 0; i < rows; ++i) y[i] += widened(w[i]) * a;
  }
}

template <typename Weight>
using Sum = void (*)(const Weight* weights, std::size_t rows, std::span<const float> x, float* y) noexcept;

template <typename Weight>
void sum_narrow(const Weight* weights, std::size_t rows, std::span<const float> x, float* y) noexcept {
  sum(weights, rows, x, y);
}

#if defined(__x86_64__)
template <typename Weight>
[[gnu::target("avx2")]] void sum_avx2(const Weight* weights, std::size_t rows, std::span<const float> x,
                                      float* y) noexcept {
  sum(weights, rows, x, y);
}

template <typename Weight>
[[gnu::target("avx512f,avx512bw,avx512vl")]] void sum_avx512(const Weight* weights, std::size_t rows,
                                                             std::span<const float> x, float* y) noexcept {
  sum(weights, rows, x, y);
}

template <typename Weight>
Sum<Weight> widest_sum() noexcept {
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512bw") != 0 && __builtin_cpu_supports("avx512vl") != 0) return &sum_avx512<Weight>;
  return __builtin_cpu_supports("avx2") != 0 ? &sum_avx2<Weight> : &sum_narrow<Weight>;
}
#else
template <typename Weight>
Sum<Weight> widest_sum() noexcept {
  return &sum_narrow<Weight>;
}
#endif

const Sum<float> sum_of_floats = widest_sum<float>();
const Sum<Bf16> sum_of_bf16 = widest_sum<Bf16>();

}  // namespace

void add_product(const float* weights, std::size_t rows, std::span<const float> x, float* y) noexcept {
  sum_of_floats(weights, rows, x, y);
}

void add_product(const Bf16* weights, std::size_t rows, std::span<const float> x, float* y) noexcept {
  sum_of_bf16(weights, rows, x, y);
}

}  // namespace risorius
