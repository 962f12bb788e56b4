#include "replay/takes/take.h"

#include <cmath>
#include <gtest/gtest.h>

#include "capture/errors.h"
#include "replay/sample_take.h"
#include "support/test_data.h"

namespace risorius {
namespace {

TEST(CaptureTime, IsExactForWholeRates) {
  EXPECT_EQ(capture_time_of(0, 60), 0);
  EXPECT_EQ(capture_time_of(1, 60), 16'666'667);
  EXPECT_EQ(capture_time_of(2, 60), 33'333'333);
  EXPECT_EQ(capture_time_of(3, 60), 50'000'000);
}

TEST(CaptureTime, DoesNotDriftOverHours) {
  // Ten hours: 36000 s hold 36000 * rate frames.
  for (const double rate : {60.0, 120.0, 125.0, 1000.0, 119.88, 59.94, 14.5})
    EXPECT_EQ(capture_time_of(static_cast<std::uint64_t>(std::llround(36000 * rate)), rate), 36'000'000'000'000)
        << rate;
}

TEST(CaptureTime, TakesRatesThatWereStoredAsFloatForWhatTheyMeant) {
  // C3D stores 119.88 as 119.87999725; ten hours later that is 2.9 ms of drift.
  EXPECT_EQ(capture_time_of(4'315'680, 119.88f), 36'000'000'000'000);
  // The broadcast rates are n * 1000 / 1001: 120000 frames last 1001 s.
  EXPECT_EQ(capture_time_of(120'000, 120'000.0 / 1001), 1'001'000'000'000);
  EXPECT_EQ(capture_time_of(120'000, static_cast<float>(120'000.0 / 1001)), 1'001'000'000'000);
}

TEST(CaptureTime, GrowsWithEveryFrameAtAnyRate) {
  for (const double rate : {0.3, 29.97, 59.94005994, 119.88, 333.3333333, 1234.56789, 123456.789})
    for (const std::uint64_t start : {std::uint64_t{0}, std::uint64_t{1} << 24, std::uint64_t{1} << 31})
      for (std::uint64_t i = start; i < start + 300; ++i)
        ASSERT_LT(capture_time_of(i, rate), capture_time_of(i + 1, rate)) << rate << " Hz, frame " << i;
}

TEST(TakeRange, IsAPathOrAPathWithFrames) {
  const TakeRange whole = parse_take_range("a/b.c3d");
  EXPECT_EQ(whole.path, "a/b.c3d");
  EXPECT_FALSE(whole.first || whole.last);
  const TakeRange part = parse_take_range("a/b.c3d:20-90");
  EXPECT_EQ(part.path, "a/b.c3d");
  EXPECT_EQ(part.first, 20u);
  EXPECT_EQ(part.last, 90u);
}

TEST(TakeRange, LeavesColonsOfFileNamesAlone) {
  EXPECT_EQ(parse_take_range("actor:one.c3d").path, "actor:one.c3d");
  EXPECT_EQ(parse_take_range("actor:one.c3d:0-0").path, "actor:one.c3d");
}

TEST(TakeRange, RefusesWhatIsNoRange) {
  for (const char* text : {"", ":1-2", "a.c3d:", "a.c3d:5", "a.c3d:-5", "a.c3d:5-", "a.c3d:9-3", "a.c3d:1-2-3",
                           "a.c3d:1-99999999999999999999999"})
    EXPECT_THROW(parse_take_range(text), UserError) << text;
}

TEST(OpenTake, GoesByTheExtensionInAnyCase) {
  const test::TemporaryFolder folder;
  test::write_c3d(folder.path() / "a.C3D", 3, 2);
  test::write_bytes(folder.path() / "b.Csv", "frame,time_s,A_x,A_y,A_z\n0,0,1,2,3\n1,0.01,1,2,3\n");
  EXPECT_EQ(open_take(folder.path() / "a.C3D")->info().markers.names.size(), 3u);
  EXPECT_EQ(open_take(folder.path() / "b.Csv")->info().markers.names.size(), 1u);
}

TEST(OpenTake, NamesTheFileThatItCannotOpen) {
  const auto message = test::message_of<UserError>([] { open_take("nowhere/absent.c3d"); });
  EXPECT_NE(message.find("nowhere/absent.c3d"), std::string::npos) << message;
  EXPECT_THROW(open_take("nowhere/absent.csv"), UserError);
  EXPECT_THROW(open_take("take.trc"), UserError);
  EXPECT_THROW(open_take("/"), UserError);
}

}  // namespace
}  // namespace risorius
