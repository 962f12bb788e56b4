#include "replay/takes/range_take.h"

#include <gtest/gtest.h>

#include "capture/errors.h"
#include "replay/sample_take.h"
#include "replay/takes/csv_take.h"
#include "support/test_data.h"

namespace risorius {
namespace {

class Range : public ::testing::Test {
 protected:
  Range() {
    std::string text = "frame,time_s,A_x,A_y,A_z\n";
    for (int f = 0; f < 50; ++f) text += std::to_string(f) + "," + std::to_string(f * 0.01) + ",1,2,3\n";
    test::write_bytes(path_, text);
  }
  RangeTake take(std::uint64_t first, std::uint64_t last) { return RangeTake(open_take(path_), first, last); }

  test::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.path() / "take.csv";
};

TEST_F(Range, KeepsNumbersAndTimesOfTheWholeTake) {
  RangeTake stretch = take(20, 29);
  EXPECT_EQ(stretch.info().frame_count, 10u);
  for (int round = 0; round < 2; ++round) {
    const auto frames = test::read_all(stretch);
    ASSERT_EQ(frames.size(), 10u);
    EXPECT_EQ(frames.front().header.sequence, 20u);
    EXPECT_EQ(frames.back().header.sequence, 29u);
    EXPECT_EQ(frames.front().header.capture_time_ns, 200'000'000);
    stretch.rewind();
  }
}

TEST_F(Range, RefusesToReachBeyondTheTake) {
  EXPECT_NO_THROW(take(49, 49));
  EXPECT_NE(test::message_of<UserError>([&] { take(20, 50); }).find("take.csv:20-50: the take ends after 50 frames"),
            std::string::npos);
}

}  // namespace
}  // namespace risorius
