#include "replay/takes/iemocap_reader.h"

#include <gtest/gtest.h>

#include "replay/text_take.h"

namespace risorius {
namespace {

using test::has_warning;
using test::read_all;

class Iemocap : public test::TextTake {
 protected:
  Iemocap() : TextTake("Ses01F_impro01.txt") {}
};

const std::string kHeader = "CH1 TNOSE LH1 Mou3\nFrame# Time x y z x y z x y z x y z\n";

TEST_F(Iemocap, ReadsTheFaceAndLeavesTheHandsOut) {
  auto take = reader(kHeader +
                     "1 0.00000 1.5 2 3 4 5 6 0.1 0.2 0.3 7 8 9\n"
                     "2 0.00833 NaN NaN NaN 4 5 6 0.1 0.2 0.3 7 8 9\r\n"
                     "3 0.01667 1 2 3 4 5 6 nan nan nan 7 8 9\n");
  EXPECT_EQ(take->info().markers.names, (std::vector<std::string>{"CH1", "TNOSE", "Mou3"}));
  EXPECT_TRUE(has_warning(*take, "LH1"));
  EXPECT_EQ(take->info().markers.rate_hz, 120);
  const auto frames = read_all(*take);
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_EQ(frames[0].position_mm[2], (Position{7, 8, 9}));
  EXPECT_EQ(frames[1].state[0], MarkerState::kMissing);
  EXPECT_EQ(frames[1].state[1], MarkerState::kMeasured);
  EXPECT_EQ(frames[2].header.capture_time_ns, 16'666'667);
}

TEST_F(Iemocap, TakesNamesThatStandAboveEachCoordinate) {
  auto take =
      reader("Frame# Time CH1 CH1 CH1 CH2 CH2 CH2\nFrame# Time x y z x y z\n1 0 1 2 3 4 5 6\n2 0.01 1 2 3 4 5 6\n");
  EXPECT_EQ(take->info().markers.names, (std::vector<std::string>{"CH1", "CH2"}));
}

TEST_F(Iemocap, NamesLineAndRemedyOfWhatIsWrong) {
  EXPECT_NE(error("").find("empty"), std::string::npos);
  EXPECT_NE(error("notes of the session\nwere lost\n").find("Frame# Time"), std::string::npos);
  EXPECT_NE(error("CH1 CH2\nFrame# Time x y z\n1 0 1 2 3\n").find("5 columns for 2"), std::string::npos);
  EXPECT_NE(error("LH1\nFrame# Time x y z\n1 0 1 2 3\n").find("face markers"), std::string::npos);
  EXPECT_NE(
      error(kHeader + "1 0 1 2 3 4 five 6 7 8 9 1 2 3\n2 0.1 1 2 3 4 5 6 7 8 9 1 2 3\n").find("line 3, cell 7: 'five'"),
      std::string::npos);
  EXPECT_NE(error(kHeader + "1 0 1 2 3 4 5 6 7 8 9 1 2 3\n2 0.1 1 2\n").find("CH1 has 2 of 3"), std::string::npos);
  EXPECT_NE(error(kHeader + "1 0 1 2 3 4 5 6 7 8 9 1 2 3\n").find("give the rate"), std::string::npos);
}

}  // namespace
}  // namespace risorius
