#include "capture/repair/symmetric_update.h"

#include <cstddef>

namespace risorius {
namespace {

[[gnu::always_inline]] inline void multiply(const double* a, std::size_t size, const double* x,
                                            double* __restrict y) noexcept {
  for (std::size_t i = 0; i < size; ++i) y[i] = 0;
  std::size_t c = 0;
  for (; c + 4 <= size; c += 4) {
    const double* __restrict w = a + c * size;
    const double x0 = x[c], x1 = x[c + 1], x2 = x[c + 2], x3 = x[c + 3];
    for (std::size_t i = 0; i < size; ++i) {
      y[i] += (w[i] * x0 + w[i + size] * x1) + (w[i + 2 * size] * x2 + w[i + 3 * size] * x3);
    }
  }
  for (; c < size; ++c) {
    const double* __restrict w = a + c * size;
    for (std::size_t i = 0; i < size; ++i) y[i] += w[i] * x[c];
  }
}

[[gnu::always_inline]] inline void update(double* __restrict a, std::size_t size, double scale,
                                          const double* __restrict v) noexcept {
  for (std::size_t c = 0; c < size; ++c) {
    double* __restrict column = a + c * size;
    const double share = v[c];
    for (std::size_t i = 0; i < size; ++i) column[i] = scale * column[i] - share * v[i];
  }
}

using Multiply = void (*)(const double* a, std::size_t size, const double* x, double* y) noexcept;
using Update = void (*)(double* a, std::size_t size, double scale, const double* v) noexcept;

void multiply_narrow(const double* a, std::size_t size, const double* x, double* y) noexcept {
  multiply(a, size, x, y);
}
void update_narrow(double* a, std::size_t size, double scale, const double* v) noexcept { update(a, size, scale, v); }

#if defined(__x86_64__)
[[gnu::target("avx2")]] void multiply_avx2(const double* a, std::size_t size, const double* x, double* y) noexcept {
  multiply(a, size, x, y);
}
[[gnu::target("avx2")]] void update_avx2(double* a, std::size_t size, double scale, const double* v) noexcept {
  update(a, size, scale, v);
}
bool has_avx2() noexcept {
  __builtin_cpu_init();
  return __builtin_cpu_supports("avx2") != 0;
}
const Multiply widest_multiply = has_avx2() ? &multiply_avx2 : &multiply_narrow;
const Update widest_update = has_avx2() ? &update_avx2 : &update_narrow;
#else
const Multiply widest_multiply = &multiply_narrow;
const Update widest_update = &update_narrow;
#endif

}  // namespace

void multiply_symmetric(const Eigen::MatrixXd& a, const Eigen::VectorXd& x, Eigen::VectorXd& y) noexcept {
  widest_multiply(a.data(), static_cast<std::size_t>(a.cols()), x.data(), y.data());
}

void scale_less_square(Eigen::MatrixXd& a, double scale, const Eigen::VectorXd& v) noexcept {
  widest_update(a.data(), static_cast<std::size_t>(a.cols()), scale, v.data());
}

}  // namespace risorius
