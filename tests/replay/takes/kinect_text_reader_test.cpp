#include "replay/takes/kinect_text_reader.h"

#include <gtest/gtest.h>

#include "replay/text_take.h"

namespace risorius {
namespace {

using test::has_warning;
using test::read_all;

class KinectText : public test::TextTake {
 protected:
  KinectText() : TextTake("a_affirmative_datapoints.txt") {}
};

const std::string kHeader = "0.0 0x 0y 0z 1x 1y 1z\n";

TEST_F(KinectText, CarriesPixelsAndDepthIntoMillimetres) {
  auto take = reader(kHeader + "100.5 320 240 1050 215 345 1050\n100.55 320 240 0 320 135 525\n");
  EXPECT_EQ(take->info().markers.names, (std::vector<std::string>{"P0", "P1"}));
  EXPECT_TRUE(has_warning(*take, "525 px"));
  const auto frames = read_all(*take);
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].position_mm[0], (Position{0, 0, -1050}));
  EXPECT_EQ(frames[0].position_mm[1], (Position{210, -210, -1050}));  // 105 px at twice the focal length
  EXPECT_EQ(frames[1].state[0], MarkerState::kMissing);
  EXPECT_EQ(frames[1].position_mm[1], (Position{0, 105, -525}));
  take->rewind();
  EXPECT_EQ(read_all(*take).size(), 2u);
}

TEST_F(KinectText, TheTimesPartBehindThePointIsMilliseconds) {
  auto take = reader(kHeader +
                     "1390385453.938 1 1 900 1 1 900\n1390385454.0 1 1 900 1 1 900\n"
                     "1390385454.62 1 1 900 1 1 900\n1390385454.125 1 1 900 1 1 900\n");
  const auto frames = read_all(*take);
  ASSERT_EQ(frames.size(), 4u);
  EXPECT_EQ(frames[0].header.capture_time_ns, 0);
  EXPECT_EQ(frames[1].header.capture_time_ns, 62'000'000);
  EXPECT_EQ(frames[2].header.capture_time_ns, 124'000'000);
  EXPECT_EQ(frames[3].header.capture_time_ns, 187'000'000);
  EXPECT_EQ(frames[3].header.sequence, 3u);
  EXPECT_NEAR(take->info().markers.rate_hz, 3 / 0.187, 1e-9);
}

TEST_F(KinectText, ARateThatIsGivenReplacesTheTimes) {
  auto take = reader(kHeader + "1.5 1 1 900 1 1 900\n1.9 1 1 900 1 1 -5\n", {.rate_hz = 20.0});
  const auto frames = read_all(*take);
  EXPECT_EQ(take->info().markers.rate_hz, 20);
  EXPECT_EQ(frames[1].header.capture_time_ns, 50'000'000);
  EXPECT_EQ(frames[1].state[1], MarkerState::kMissing);  // no depth is below 0
}

TEST_F(KinectText, SaysWhatIsWrongAndWhere) {
  const std::string first = "1.5 1 1 900 1 1 900\n";
  EXPECT_NE(error(kHeader + first + first).find("line 3, column 0.0: 1.5 s does not come after"), std::string::npos);
  EXPECT_NE(error(kHeader + first + "1.1234 1 1 900 1 1 900\n").find("'1.1234' is no time"), std::string::npos);
  EXPECT_NE(error(kHeader + first + "99999999999999999.1 1 1 9 1 1 9\n").find("is no time"), std::string::npos);
  EXPECT_NE(error(kHeader + first + "2.5 1 1 900 1 x 900\n").find("line 3, column 1y: 'x' is no number"),
            std::string::npos);
  EXPECT_NE(error(kHeader + first + "2.5 1 1 900 1 1\n").find("6 cells where the header names 7"), std::string::npos);
  EXPECT_NE(error(kHeader + first + "2.5 1 1 900 1 1 9e9\n").find("P1 would be more than a kilometre away"),
            std::string::npos);
  EXPECT_NE(error("0.0 0x 0y 0z 2x 2y 2z\n" + first).find("column 5 is not 1x"), std::string::npos);
  EXPECT_NE(error("0.0 0x 0y 0z 1x 1y\n").find("column 7 is not 1z"), std::string::npos);
  EXPECT_NE(error(kHeader + first).find("1 frames after the header"), std::string::npos);
  EXPECT_THROW(reader(kHeader + first + "2.5 1 1 900 1 1 900\n", {.mm_per_unit = 10.0}), UserError);
}

TEST_F(KinectText, ReadsTheRealOnesWithoutAStepBackInTime) {
  for (const char* name : {"a_affirmative", "a_wh_question", "a_yn_question"}) {
    RISORIUS_NEEDS_DATA(path, std::string("kinect/") + name + "_datapoints.txt");
    auto take = open_take(path);
    EXPECT_EQ(take->info().markers.names.size(), 100u);
    std::int64_t last_ns = -1;
    std::size_t missing = 0;
    for (const MarkerFrame& frame : read_all(*take)) {
      EXPECT_GT(frame.header.capture_time_ns, last_ns);
      last_ns = frame.header.capture_time_ns;
      for (std::size_t i = 0; i < frame.count; ++i) missing += frame.state[i] == MarkerState::kMissing;
    }
    EXPECT_GT(missing, 1000u) << name;
  }
}

}  // namespace
}  // namespace risorius
