// y += W x, the product that a network's step consists of, for float and bf16 weights.
//
// Weights lie column after column: the sum runs over contiguous rows, eight columns at a time, and needs no reordered
// sums, so a build without -ffast-math is fast. Each row's sum is made in one order, by fused multiplications and
// additions, whatever the width of the machine's vectors: the same bits on all that have them, so the widest that this
// processor has can be chosen when the program runs. Without fused ones (before 2013) products are rounded before they
// are added: other last bits, as fast as may be. bf16 weights are widened as they are read; sums are float.
//
//   column:  0           1                      eight columns c of a block make two chains, which are added, then to y:
//          [ w00 w10 .. | w01 w11 .. | ... ]    y += (((c0 + c1) + c2) + c3) + (((c4 + c5) + c6) + c7)
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace risorius {

/// Upper half of a float.
struct Bf16 {
  std::uint16_t bits = 0;
};

/// W: rows x columns, column after column; x: columns; y: rows, apart from x.
void add_product(const float* weights, std::size_t rows, std::span<const float> x, float* y) noexcept;
void add_product(const Bf16* weights, std::size_t rows, std::span<const float> x, float* y) noexcept;

/// What a product may be made with. kNarrow: what the build allows, without fused arithmetic.
enum class Vectors : std::uint8_t { kNarrow, kAvx2, kAvx512 };
bool has_vectors(Vectors vectors) noexcept;  ///< of this processor
Vectors widest_vectors() noexcept;           ///< that add_product takes

/// The same with given vectors, which this processor has.
void add_product_with(Vectors vectors, const float* weights, std::size_t rows, std::span<const float> x,
                      float* y) noexcept;
void add_product_with(Vectors vectors, const Bf16* weights, std::size_t rows, std::span<const float> x,
                      float* y) noexcept;

}  // namespace risorius
