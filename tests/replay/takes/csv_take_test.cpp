#include "replay/takes/csv_take.h"

#include <algorithm>
#include <gtest/gtest.h>

#include "capture/errors.h"
#include "replay/sample_take.h"
#include "support/test_data.h"

namespace risorius {
namespace {

using test::has_warning;
using test::message_of;
using test::read_all;

class CsvTake : public ::testing::Test {
 protected:
  CsvTakeReader reader(const std::string& text, const TakeOptions& options = {}) {
    test::write_bytes(path_, text);
    return CsvTakeReader(path_, options);
  }
  std::vector<MarkerFrame> frames(const std::string& text, const TakeOptions& options = {}) {
    auto take = reader(text, options);
    return read_all(take);
  }
  std::string error(const std::string& text, const TakeOptions& options = {}) {
    return message_of<UserError>([&] { frames(text, options); });
  }

  test::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.path() / "take.csv";
};

TEST_F(CsvTake, IsReadBackWithEqualBits) {
  constexpr std::size_t kMarkers = 7;
  for (const double rate : {60.0, 119.88, 125.0, 1000.0, 60'000.0 / 1001}) {
    CsvTakeWriter writer(path_, test::sample_set(kMarkers));
    // From frame 20 on, as a part of a take has it.
    std::vector<MarkerFrame> written;
    for (std::uint64_t f = 0; f < 400; ++f) {
      MarkerFrame frame = test::sample_frame(f, kMarkers, rate);
      frame.header.capture_time_ns = capture_time_of(f + 20, rate);
      if (f % 3 == 0) frame.state[2] = MarkerState::kMissing;
      if (f % 5 == 0) frame.state[3] = MarkerState::kRejected;
      written.push_back(frame);
      writer.write(frame);
    }
    writer.finish();
    CsvTakeReader take(path_, {});
    EXPECT_NEAR(take.info().markers.rate_hz, rate, 1e-9);
    EXPECT_EQ(take.info().frame_count, 400u);
    EXPECT_TRUE(take.info().warnings.empty());
    EXPECT_EQ(take.info().markers.names, test::sample_set(kMarkers).names);
    const auto read = read_all(take);
    for (std::size_t f = 0; f < read.size(); ++f) {
      EXPECT_EQ(read[f].header.capture_time_ns, written[f].header.capture_time_ns);
      for (std::size_t i = 0; i < kMarkers; ++i) {
        const bool measured = written[f].state[i] == MarkerState::kMeasured;
        EXPECT_EQ(read[f].state[i] == MarkerState::kMeasured, measured);
        EXPECT_EQ(read[f].position_mm[i], measured ? written[f].position_mm[i] : Position());
      }
    }
  }
}

TEST_F(CsvTake, FindsItsSeparator) {
  for (const char separator : {',', ';', '\t'}) {
    std::string text = "frame,time_s,A_x,A_y,A_z\n0,0,1.5,2.5,3.5\n1,0.01,1.5,2.5,-3.5e1\n";
    std::replace(text.begin(), text.end(), ',', separator);
    const auto read = frames(text);
    ASSERT_EQ(read.size(), 2u);
    EXPECT_EQ(read[1].position_mm[0], (Position{1.5f, 2.5f, -35.0f}));
  }
}

TEST_F(CsvTake, ReadsWhatSpreadsheetsWrite) {
  // Byte order mark, CRLF, quotes, blanks, a blank line, columns in another order, one that means nothing to us.
  auto take = reader(
      "\xEF\xBB\xBF\"time_s\" ,\"A, left_z\", A2_x,\"A, left_x\",\"A, left_y\",A2_y,A2_z,note\r\n"
      "0, 3 ,4,1,2,5,6,\"say \"\"hi\"\", twice\"\r\n\r\n0.5, \"30\" ,40,10,20,50,60,\r\n");
  EXPECT_EQ(take.info().markers.names, (std::vector<std::string>{"A, left", "A2"}));
  EXPECT_TRUE(has_warning(take, "'note'"));
  EXPECT_EQ(take.info().markers.rate_hz, 2);
  const auto read = read_all(take);
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[0].position_mm[0], (Position{1, 2, 3}));
  EXPECT_EQ(read[1].position_mm[1], (Position{40, 50, 60}));
}

TEST_F(CsvTake, TakesEmptyCellsAndNanForMissing) {
  const auto read = frames("A_x,A_y,A_z,B_x,B_y,B_z\n1,2,3,,,\n1,NaN,3,4,5,6\n1,2,,0,0,0\n", {.rate_hz = 60});
  ASSERT_EQ(read.size(), 3u);
  EXPECT_EQ(read[0].state[0], MarkerState::kMeasured);
  EXPECT_EQ(read[0].state[1], MarkerState::kMissing);
  EXPECT_EQ(read[1].state[0], MarkerState::kMissing);
  EXPECT_EQ(read[1].position_mm[0], Position());
  EXPECT_EQ(read[2].state[0], MarkerState::kMissing);
  EXPECT_EQ(read[2].state[1], MarkerState::kMeasured);  // in CSV an origin is an origin: missing has its own sign
}

TEST_F(CsvTake, AppliesUnitAxesAndRate) {
  const auto read =
      frames("A_x,A_y,A_z\n1,2,3\n1,2,3\n", {.mm_per_unit = 10, .axes = Axes::parse("RFU"), .rate_hz = 50});
  EXPECT_EQ(read[0].position_mm[0], (Position{-10, 30, 20}));
  EXPECT_EQ(read[1].header.capture_time_ns, 20'000'000);
}

TEST_F(CsvTake, TurnsPrintedTimesIntoTheExactGrid) {
  const auto read = frames("time_s,A_x,A_y,A_z\n0.000000,1,1,1\n0.016667,1,1,1\n0.033333,1,1,1\n0.05,1,1,1\n");
  EXPECT_EQ(read[1].header.capture_time_ns, 16'666'667);
  EXPECT_EQ(read[2].header.capture_time_ns, 33'333'333);
}

TEST_F(CsvTake, KeepsIrregularTimesWithAWarning) {
  auto take = reader("time_s,A_x,A_y,A_z\n0.1,1,1,1\n0.17,1,1,1\n0.24,1,1,1\n0.4,1,1,1\n");
  EXPECT_TRUE(has_warning(take, "time_s"));
  EXPECT_NEAR(take.info().markers.rate_hz, 1 / 0.07, 1e-6);  // the median of 0.07, 0.07, 0.16
  EXPECT_EQ(read_all(take)[3].header.capture_time_ns, 400'000'000);
}

TEST_F(CsvTake, RefusesTimesThatDoNotGrow) {
  EXPECT_NE(error("time_s,A_x,A_y,A_z\n0,1,1,1\n0.2,1,1,1\n0.1,1,1,1\n").find("line 4"), std::string::npos);
  EXPECT_NE(error("time_s,A_x,A_y,A_z\n0,1,1,1\n0,1,1,1\n").find("line 3"), std::string::npos);
  EXPECT_NE(error("time_s,A_x,A_y,A_z\n0,1,1,1\n,1,1,1\n").find("line 3, column time_s"), std::string::npos);
}

TEST_F(CsvTake, NeedsARate) {
  EXPECT_NE(error("A_x,A_y,A_z\n1,2,3\n").find("give the rate"), std::string::npos);
  EXPECT_NE(error("time_s,A_x,A_y,A_z\n0,1,2,3\n").find("give the rate"), std::string::npos);
  EXPECT_FALSE(error("A_x,A_y,A_z\n1,2,3\n", {.rate_hz = 0}).empty());
}

TEST_F(CsvTake, NamesTheColumnThatIsWrong) {
  EXPECT_NE(error("A_x,A_y\n1,2\n", {.rate_hz = 60}).find("column A_z: is missing"), std::string::npos);
  EXPECT_NE(error("A_x,A_y,A_z,A_y\n1,2,3,4\n", {.rate_hz = 60}).find("column A_y: stands twice"), std::string::npos);
  EXPECT_NE(error("a,b\n1,2\n", {.rate_hz = 60}).find("NAME_x"), std::string::npos);
}

TEST_F(CsvTake, NamesThePlaceOfABadCell) {
  for (const char* bad : {"abc", "1.5x", "1,5", "--1", "1e99", "inf", "0x10", "1 2"}) {
    const std::string cell = std::string(bad).find(',') == std::string::npos ? bad : '"' + std::string(bad) + '"';
    const std::string message = error("A_x,A_y,A_z\n1,2,3\n1," + cell + ",3\n", {.rate_hz = 60});
    EXPECT_NE(message.find("take.csv, line 3, column A_y: '" + std::string(bad) + "'"), std::string::npos) << message;
  }
}

TEST_F(CsvTake, NamesTheLineOfAWrongNumberOfCells) {
  EXPECT_NE(error("A_x,A_y,A_z\n1,2,3\n1,2\n", {.rate_hz = 60}).find("line 3: 2 cells"), std::string::npos);
  EXPECT_NE(error("A_x,A_y,A_z\n1,2,3,4\n", {.rate_hz = 60}).find("line 2: 4 cells"), std::string::npos);
  EXPECT_NE(error("A_x,A_y,A_z\n\"1,2,3\n", {.rate_hz = 60}).find("quote"), std::string::npos);
}

TEST_F(CsvTake, RefusesEmptyFiles) {
  EXPECT_NE(error("").find("empty"), std::string::npos);
  EXPECT_NE(error("A_x,A_y,A_z\n", {.rate_hz = 60}).find("no frames"), std::string::npos);
}

TEST_F(CsvTake, WritesNamesThatNeedQuotes) {
  MarkerSet set = test::sample_set(1);
  set.names[0] = "brow, \"left\"";
  CsvTakeWriter writer(path_, set);
  writer.write(test::sample_frame(0, 1));
  writer.write(test::sample_frame(1, 1));
  writer.finish();
  EXPECT_EQ(CsvTakeReader(path_, {}).info().markers.names, set.names);
}

TEST_F(CsvTake, WriterRefusesAnotherNumberOfMarkers) {
  CsvTakeWriter writer(path_, test::sample_set(2));
  EXPECT_THROW(writer.write(test::sample_frame(0, 3)), std::invalid_argument);
}

TEST_F(CsvTake, TakesFrameNumbersThatLeapForLostFrames) {
  const auto read = frames("frame,time_s,A_x,A_y,A_z\n10,0.1,1,2,3\n11,0.11,1,2,3\n14,0.14,1,2,3\n");
  ASSERT_EQ(read.size(), 3u);
  EXPECT_EQ(read[1].header.sequence, 1u);
  EXPECT_EQ(read[2].header.sequence, 4u);
  EXPECT_EQ(read[2].header.capture_time_ns, 140'000'000);
  const auto take = reader("frame,time_s,A_x,A_y,A_z\n10,0.1,1,2,3\n11,0.11,1,2,3\n14,0.14,1,2,3\n");
  EXPECT_NEAR(take.info().markers.rate_hz, 100, 1e-9);
  EXPECT_TRUE(take.info().warnings.empty());
}

TEST_F(CsvTake, RefusesFrameNumbersOutOfOrderAndPlacesOutOfTheWorld) {
  const std::string header = "frame,time_s,A_x,A_y,A_z\n";
  EXPECT_NE(error(header + "1,0,1,2,3\n1,0.1,1,2,3\n").find("line 3, column frame: frame 1 does not come after"),
            std::string::npos);
  EXPECT_NE(error(header + "5,0,1,2,3\n4,0.1,1,2,3\n").find("frame 4 does not come after frame 5"), std::string::npos);
  EXPECT_NE(error(header + "1.5,0,1,2,3\n").find("'1.5' is no frame number"), std::string::npos);
  EXPECT_NE(error(header + "-1,0,1,2,3\n").find("'-1' is no frame number"), std::string::npos);
  EXPECT_NE(error(header + "0,0,1,2,3\n900000,0.1,1,2,3\n").find("leap"), std::string::npos);
  EXPECT_NE(error(header + "0,0,1,2e30,3\n1,0.1,1,2,3\n").find("column A_y: '2e30' is more than a kilometre away"),
            std::string::npos);
}

TEST_F(CsvTake, EchoesALongCellShortened) {
  const std::string message = error("frame,time_s,A_x,A_y,A_z\n0,0,1,2," + std::string(100'000, 'x') + "\n1,1,1,1,1\n");
  EXPECT_NE(message.find("xxx...' is no number"), std::string::npos);
  EXPECT_LT(message.size(), 400u);
}

TEST_F(CsvTake, ReadsNamesInLatin1WithAWarning) {
  const auto take = reader("frame,time_s,W\xE4nge_x,W\xE4nge_y,W\xE4nge_z\n0,0,1,2,3\n1,0.1,1,2,3\n");
  EXPECT_EQ(take.info().markers.names, std::vector<std::string>{"W\xC3\xA4nge"});
  EXPECT_TRUE(has_warning(take, "read as Latin-1"));
}

}  // namespace
}  // namespace risorius
