#include "capture/repair/baselines/held_marker.h"

#include <cmath>
#include <gtest/gtest.h>

namespace risorius {
namespace {

TEST(HeldMarker, DampedVelocityGoesOnAndComesToRest) {
  HeldMarker marker;
  for (int f = 0; f < 100; ++f) marker.observe({100.0 * 0.01 * f, 0, 0}, 0.01);  // 100 mm/s
  const double last = marker.hold_mm().x();
  marker.miss(0.01);
  EXPECT_NEAR(marker.damped_mm().x() - last, 0.1 * (1 - std::exp(-0.1)) * 100, 0.01);
  marker.miss(10);
  EXPECT_NEAR(marker.damped_mm().x() - last, HeldMarker::kDampingS * 100, 0.01);
  EXPECT_EQ(marker.hold_mm().x(), last);
}

}  // namespace
}  // namespace risorius
