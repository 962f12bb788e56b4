#include "replay/picture/repair_picture.h"

#include <gtest/gtest.h>

#include "capture/errors.h"
#include "support/synthetic_take.h"

namespace risorius {
namespace {

int differing_pixels(const Canvas& a, const Canvas& b) {
  int differing = 0;
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) differing += a.pixel(x, y) != b.pixel(x, y);
  }
  return differing;
}

TEST(RepairPicture, ShowsWhatWasFilledAndWhatWasRejected) {
  const test::MarkerTake take = test::synthetic_take({.frames = 120});
  auto filled = take.frames;
  for (std::size_t f = 40; f < 60; ++f) {
    filled[f].state[3] = MarkerState::kFilled;
    filled[f].standard_deviation_mm[3] = 0.5F;
  }
  auto rejected = filled;
  rejected[50].reason[3] = RejectReason::kJump;
  const auto draw = [&](const std::vector<MarkerFrame>& after) {
    return repair_picture(take.frames, after, take.set, {"M3", "M4"});
  };
  EXPECT_GT(differing_pixels(draw(take.frames), draw(filled)), 500);
  EXPECT_GT(differing_pixels(draw(filled), draw(rejected)), 20);
}

TEST(RepairPicture, RefusesAMarkerThatTheTakeDoesNotHaveAndSaysWhichThereAre) {
  const test::MarkerTake take = test::synthetic_take({.frames = 10});
  try {
    repair_picture(take.frames, take.frames, take.set, {"Chin"});
    FAIL();
  } catch (const UserError& error) {
    EXPECT_NE(std::string(error.what()).find("M23"), std::string::npos);
  }
  EXPECT_THROW(repair_picture(take.frames, take.frames, take.set, {}), UserError);
}

}  // namespace
}  // namespace risorius
