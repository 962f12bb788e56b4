#include "replay/takes/au_csv.h"

#include <cmath>
#include <gtest/gtest.h>

#include "capture/errors.h"
#include "replay/sample_take.h"
#include "support/test_data.h"

namespace risorius {
namespace {

using test::message_of;

class AuCsv : public ::testing::Test {
 protected:
  AuSeries load(const std::string& text) {
    test::write_bytes(path_, text);
    return load_au_csv(path_);
  }
  std::string error(const std::string& text) {
    return message_of<UserError>([&] { load(text); });
  }

  test::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.path() / "au.csv";
};

AuFrame frame_of(std::uint64_t sequence, std::initializer_list<double> intensities) {
  AuFrame frame;
  frame.header.sequence = sequence;
  for (const double intensity : intensities) {
    frame.state[frame.count] = AuState::kObserved;
    frame.intensity[frame.count++] = intensity;
  }
  return frame;
}

TEST_F(AuCsv, WritesTheLayoutOfSeed003) {
  AuCsvWriter writer(path_, {"AU1L", "AU1R", "AU27"});
  writer.write(frame_of(0, {0.1, 0.5, 1.2}));
  AuFrame partly = frame_of(1, {0.25, 0.5, 1});
  partly.state[0] = AuState::kNotObserved;
  partly.state[1] = AuState::kHeld;
  writer.write(partly);
  writer.finish();
  EXPECT_EQ(test::read_bytes(path_), "Frame,AU1L,AU1R,AU27\n0,0.1,0.5,1.2\n1,,,1\n");
}

TEST_F(AuCsv, IsReadBackWithEqualBits) {
  const std::vector<double> awkward = {0, 1.2, 1.0 / 3, 5e-324, 1e-17, 0.1 + 0.2, std::nextafter(1.2, 0)};
  AuCsvWriter writer(path_, {"AU4L", "AU4R"});
  for (std::size_t i = 0; i < awkward.size(); ++i) writer.write(frame_of(i + 1'000'000'000'000, {awkward[i], 1.0}));
  writer.finish();
  const AuSeries series = load_au_csv(path_);
  EXPECT_EQ(series.names, (std::vector<std::string>{"AU4L", "AU4R"}));
  ASSERT_EQ(series.frames.size(), awkward.size());
  for (std::size_t i = 0; i < awkward.size(); ++i) {
    EXPECT_EQ(series.frames[i], i + 1'000'000'000'000);
    EXPECT_EQ(series.intensities[i], (std::vector<double>{awkward[i], 1.0}));
  }
}

TEST_F(AuCsv, TakesEmptyCellsForNotObserved) {
  const AuSeries series = load("Frame;AU1L;AU1R\r\n7;;0.5\r\n");
  EXPECT_EQ(series.frames, std::vector<std::uint64_t>{7});
  EXPECT_TRUE(std::isnan(series.intensities[0][0]));
  EXPECT_EQ(series.intensities[0][1], 0.5);
}

TEST_F(AuCsv, NamesThePlaceOfWhatIsWrong) {
  EXPECT_NE(error("Time,AU1L\n0,1\n").find("the first column is 'Time'"), std::string::npos);
  EXPECT_NE(error("Frame\n0\n").find("no AU columns"), std::string::npos);
  EXPECT_NE(error("Frame,AU1L,AU1L\n0,1,1\n").find("stands twice"), std::string::npos);
  EXPECT_NE(error("Frame,AU1L\n0,1\n1,x\n").find("au.csv, line 3, column AU1L: 'x'"), std::string::npos);
  EXPECT_NE(error("Frame,AU1L\n-1,1\n").find("line 2, column Frame: '-1'"), std::string::npos);
  EXPECT_NE(error("Frame,AU1L\n0,1,2\n").find("line 2: 3 cells"), std::string::npos);
}

TEST_F(AuCsv, WriterRefusesWhatDoesNotFit) {
  EXPECT_THROW(AuCsvWriter(path_, {}), UserError);
  EXPECT_THROW(AuCsvWriter(path_, std::vector<std::string>(kMaxAus + 1, "AU1")), UserError);
  AuCsvWriter writer(path_, {"AU1L"});
  EXPECT_THROW(writer.write(frame_of(0, {1, 1})), std::invalid_argument);
}

TEST_F(AuCsv, RefusesWhatIsNoIntensityByLineAndColumn) {
  EXPECT_NE(error("Frame,AU1L\n0,nan\n").find("line 2, column AU1L: 'nan' is no number"), std::string::npos);
  EXPECT_NE(error("Frame,AU1L\n0,0.5\n1,1e30\n").find("line 3, column AU1L: '1e30' is no intensity"),
            std::string::npos);
  EXPECT_NE(error("Frame,AU1L\n0,5\n").find("multiply those of 0 to 5 by 0.2"), std::string::npos);
  EXPECT_NE(error("Frame,AU1L\n").find("has no frames"), std::string::npos);
}

TEST_F(AuCsv, RefusesFramesThatDoNotGrowOrLeapTooFar) {
  EXPECT_NE(error("Frame,AU1L\n0,0\n0,0\n").find("line 3, column Frame: frame 0 does not come after frame 0"),
            std::string::npos);
  EXPECT_NE(error("Frame,AU1L\n7,0\n3,0\n").find("frame 3 does not come after frame 7"), std::string::npos);
  EXPECT_NE(error("Frame,AU1L\n7,0\n30000000,0\n").find("leap from 7 to 30000000"), std::string::npos);
  EXPECT_EQ(load("Frame,AU1L\n7,0\n9,1\n").frames, (std::vector<std::uint64_t>{7, 9}));
}

}  // namespace
}  // namespace risorius
