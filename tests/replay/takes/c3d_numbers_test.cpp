#include "replay/takes/c3d_numbers.h"

#include <array>
#include <gtest/gtest.h>

namespace risorius {
namespace {

using Bytes4 = std::array<std::uint8_t, 4>;

float decoded(Bytes4 bytes, C3dProcessor processor) { return c3d_float(bytes.data(), processor); }

TEST(C3dNumbers, IntegersFollowTheProcessorsByteOrder) {
  const std::array<std::uint8_t, 2> bytes{0x34, 0x92};
  EXPECT_EQ(c3d_word(bytes.data(), C3dProcessor::kIntel), 0x9234);
  EXPECT_EQ(c3d_word(bytes.data(), C3dProcessor::kDec), 0x9234);
  EXPECT_EQ(c3d_word(bytes.data(), C3dProcessor::kMips), 0x3492);
  EXPECT_EQ(c3d_integer(bytes.data(), C3dProcessor::kIntel), 0x9234 - 0x10000);
}

TEST(C3dNumbers, IeeeFloatsFollowTheProcessorsByteOrder) {
  // 50.0f = 42480000
  EXPECT_EQ(decoded({0x00, 0x00, 0x48, 0x42}, C3dProcessor::kIntel), 50.0f);
  EXPECT_EQ(decoded({0x42, 0x48, 0x00, 0x00}, C3dProcessor::kMips), 50.0f);
}

TEST(C3dNumbers, VaxFloatsAreThoseOfTheArchitectureManual) {
  // F_floating, bytes in memory: sign and high exponent in the second byte; 1.0 is 0.5 x 2^(129 - 128).
  EXPECT_EQ(decoded({0x80, 0x40, 0x00, 0x00}, C3dProcessor::kDec), 1.0f);
  EXPECT_EQ(decoded({0x80, 0xC0, 0x00, 0x00}, C3dProcessor::kDec), -1.0f);
  EXPECT_EQ(decoded({0x48, 0x43, 0x00, 0x00}, C3dProcessor::kDec), 50.0f);
  EXPECT_EQ(decoded({0x49, 0x41, 0xD0, 0x0F}, C3dProcessor::kDec), 3.14159012f);
  EXPECT_EQ(decoded({0x00, 0x00, 0xFF, 0xFF}, C3dProcessor::kDec), 0.0f);  // exponent 0
  // The largest: (1 - 2^-24) x 2^127; half of IEEE's.
  EXPECT_EQ(decoded({0xFF, 0x7F, 0xFF, 0xFF}, C3dProcessor::kDec), std::ldexp(16777215.0f, 103));
  EXPECT_TRUE(std::isnan(decoded({0x00, 0x80, 0x00, 0x00}, C3dProcessor::kDec)));  // reserved operand
}

}  // namespace
}  // namespace risorius
