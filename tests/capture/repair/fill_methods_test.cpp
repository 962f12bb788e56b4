#include "capture/repair/fill_methods.h"

#include <gtest/gtest.h>
#include <set>

#include "capture/errors.h"
#include "support/synthetic_take.h"

namespace risorius {
namespace {

using test::distance_mm;
using test::MarkerTake;
using test::synthetic_take;

constexpr std::int64_t kLongNs = 10'000'000'000;

double error_mm(const MarkerTake& truth, const MarkerTake& filled, std::size_t i, std::size_t begin, std::size_t end) {
  double sum = 0;
  for (std::size_t f = begin; f < end; ++f) {
    EXPECT_EQ(filled.frames[f].state[i], MarkerState::kFilled);
    sum += distance_mm(truth.frames[f].position_mm[i], filled.frames[f].position_mm[i]);
  }
  return sum / static_cast<double>(end - begin);
}

TEST(FillMethods, EveryOneFillsAGapAndLeavesMeasuredSamplesBitEqual) {
  const MarkerTake truth = synthetic_take();
  MarkerTake cut = truth;
  test::hide(cut, 3, 300, 30);
  for (const FillMethodEntry& method : fill_methods()) {
    MarkerTake filled = cut;
    method.fill(filled.frames, filled.set, kLongNs);
    for (std::size_t f = 0; f < truth.frames.size(); ++f) {
      for (std::size_t i = 0; i < 24; ++i) {
        const bool hidden = cut.frames[f].state[i] == MarkerState::kMissing;
        ASSERT_EQ(filled.frames[f].state[i], hidden ? MarkerState::kFilled : MarkerState::kMeasured) << method.name;
        if (!hidden) {
          ASSERT_EQ(filled.frames[f].position_mm[i], truth.frames[f].position_mm[i]) << method.name;
        }
      }
    }
    // Nothing is farther off than a marker of the lower half ever moves: three movements of about 2 mm per axis.
    EXPECT_LT(error_mm(truth, filled, 3, 300, 330), 12) << method.name;
  }
}

// Of three movements, 23 other markers show everything.
TEST(FillMethods, ThoseThatLearnFromTheOtherMarkersBeatThoseThatDoNot) {
  const MarkerTake truth = synthetic_take();
  MarkerTake cut = truth;
  test::hide(cut, 3, 400, 90);
  const auto error = [&](std::string_view name) {
    MarkerTake filled = cut;
    fill_method_named(name).fill(filled.frames, filled.set, kLongNs);
    return error_mm(truth, filled, 3, 400, 490);
  };
  const double linear = error("linear_head"), hold = error("hold");
  for (const char* name : {"offline", "kalman", "pca"}) EXPECT_LT(error(name), 0.25 * linear) << name;
  for (const char* name : {"causal", "online_pca"}) EXPECT_LT(error(name), 0.25 * hold) << name;
}

TEST(FillMethods, CausalOnesDoNotLookAhead) {
  const MarkerTake truth = synthetic_take();
  MarkerTake cut = truth;
  test::hide(cut, 3, 300, 30);
  for (const FillMethodEntry& method : fill_methods()) {
    if (!method.is_causal) continue;
    MarkerTake whole = cut, first = cut;
    first.frames.resize(315);
    method.fill(whole.frames, whole.set, kLongNs);
    method.fill(first.frames, first.set, kLongNs);
    for (std::size_t f = 0; f < 315; ++f) EXPECT_TRUE(test::same_bits(whole.frames[f], first.frames[f])) << method.name;
  }
}

TEST(FillMethods, AreFoundByNameAndAnotherNameIsRefusedWithTheList) {
  std::set<std::string_view> names;
  for (const FillMethodEntry& method : fill_methods()) names.insert(method.name);
  EXPECT_EQ(names.size(), fill_methods().size());
  EXPECT_EQ(&fill_method_named("pca").name, &fill_methods()[6].name);
  try {
    fill_method_named("spline");
    FAIL();
  } catch (const UserError& error) {
    EXPECT_NE(std::string(error.what()).find("linear_head"), std::string::npos);
  }
}

}  // namespace
}  // namespace risorius
