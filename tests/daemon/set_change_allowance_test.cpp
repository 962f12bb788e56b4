#include "daemon/set_change_allowance.h"

#include <gtest/gtest.h>

namespace risorius {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

TEST(SetChangeAllowance, ManyAtOnceThenTwoASecond) {
  SetChangeAllowance allowance;
  std::int64_t now_ns = 5 * kSecond;
  for (int k = 0; k < SetChangeAllowance::kAtOnce; ++k) EXPECT_TRUE(allowance.take(now_ns)) << k;
  EXPECT_FALSE(allowance.take(now_ns));
  int taken = 0;
  for (int k = 0; k < 601; ++k) taken += allowance.take(now_ns += kSecond / 60);
  EXPECT_EQ(taken, 20);
}

TEST(SetChangeAllowance, WhatWasNotUsedIsNotSavedUpForEver) {
  SetChangeAllowance allowance;
  EXPECT_TRUE(allowance.take(0));
  int taken = 0;
  for (int k = 0; k < 100; ++k) taken += allowance.take(3600 * kSecond);
  EXPECT_EQ(taken, SetChangeAllowance::kAtOnce);
}

}  // namespace
}  // namespace risorius
