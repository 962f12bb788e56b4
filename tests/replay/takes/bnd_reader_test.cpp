#include "replay/takes/bnd_reader.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "capture/errors.h"
#include "replay/sample_take.h"
#include "support/test_data.h"

namespace risorius {
namespace {

using test::has_warning;
using test::message_of;
using test::read_all;

class Bnd : public ::testing::Test {
 protected:
  void write(int frame, const std::string& text) {
    test::write_bytes(folder_.path() / fmt::format("M2_{}.bnd", frame), text);
  }
  std::string error() {
    return message_of<UserError>([&] { read_all(*open_take(folder_.path())); });
  }
  test::TemporaryFolder folder_;
};

TEST_F(Bnd, ReadsAFolderInTheOrderOfItsNumbers) {
  for (const int frame : {10, 9, 100}) {
    std::string text;
    for (int i = 1; i <= 83; ++i) text += fmt::format("{}\t{}.5\t{}\t{}\r\n", i, frame, i, -i);
    write(frame, text);
  }
  const auto take = open_take(folder_.path());
  EXPECT_EQ(take->info().markers.names.size(), 83u);
  EXPECT_EQ(take->info().markers.names[0], "L01");
  EXPECT_EQ(take->info().markers.rate_hz, 25);
  EXPECT_TRUE(has_warning(*take, "25 Hz"));
  const auto frames = read_all(*take);
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_EQ(frames[0].position_mm[82], (Position{9.5f, 83, -83}));
  EXPECT_EQ(frames[1].position_mm[0], (Position{10.5f, 1, -1}));
  EXPECT_EQ(frames[2].position_mm[0].x, 100.5f);
  EXPECT_EQ(frames[2].header.capture_time_ns, 3'640'000'000) << "frames 11 to 99 are lost";
}

TEST_F(Bnd, ReadsASingleFrameAndARateThatIsGiven) {
  write(1, "0 1 2 3\n7 NaN 5 6\n");
  const auto take = open_take(folder_.path() / "M2_1.bnd", {.mm_per_unit = 10.0, .rate_hz = 50.0});
  EXPECT_TRUE(take->info().warnings.empty());
  const auto frames = read_all(*take);
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].position_mm[0], (Position{10, 20, 30}));
  EXPECT_EQ(frames[0].state[1], MarkerState::kMissing);
}

TEST_F(Bnd, NamesFileLineAndRemedyOfWhatIsWrong) {
  EXPECT_NE(error().find("no .bnd files"), std::string::npos);
  write(1, "1 2 3 4\n2 3 x 5\n");
  EXPECT_NE(error().find("M2_1.bnd, line 2: '2 3 x 5'"), std::string::npos);
  write(1, "1 2 3 4\n");
  write(2, "1 2 3 4\n2 3 4 5\n");
  EXPECT_NE(error().find("M2_2.bnd: 2 landmarks"), std::string::npos);
  write(2, "2 2 3 4\n");
  EXPECT_NE(error().find("landmark 2 stands where"), std::string::npos);
  write(2, "");
  EXPECT_NE(error().find("no landmarks"), std::string::npos);
}

TEST_F(Bnd, TakesANumberThatLacksForALostFrame) {
  for (const int frame : {3, 4, 7}) write(frame, "1 1 2 3\n");
  const auto frames = read_all(*open_take(folder_.path()));
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_EQ(frames[1].header.sequence, 1u);
  EXPECT_EQ(frames[2].header.sequence, 4u);
  EXPECT_EQ(frames[2].header.capture_time_ns, 160'000'000);
}

TEST_F(Bnd, RefusesANumberThatStandsTwiceAndPlacesOutOfTheWorld) {
  write(1, "1 1 2 3\n");
  test::write_bytes(folder_.path() / "M2_001.bnd", "1 1 2 3\n");
  EXPECT_NE(error().find("has the number 1 after"), std::string::npos);
  std::filesystem::remove(folder_.path() / "M2_001.bnd");
  write(2, "1 1 1e300 3\n");
  EXPECT_NE(error().find("M2_2.bnd, landmark 1: 1e+300 is more than a kilometre away"), std::string::npos);
}

}  // namespace
}  // namespace risorius
