#include "replay/takes/trc_reader.h"

#include <gtest/gtest.h>

#include "capture/errors.h"
#include "replay/sample_take.h"
#include "support/test_data.h"

namespace risorius {
namespace {

using test::has_warning;
using test::message_of;
using test::read_all;

constexpr const char* kHeader =
    "PathFileType\t4\t(X/Y/Z)\tface.trc\r\n"
    "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\r\n"
    "100.00\t100.00\t       3\t2\tcm\t100.00\t1\t3\r\n"
    "Frame#\tTime\tChin\t\t\t Brow L \t\t\r\n"
    "\t\tX1\tY1\tZ1\tX2\tY2\tZ2\r\n\r\n";

class Trc : public ::testing::Test {
 protected:
  TrcReader reader(const std::string& text, const TakeOptions& options = {}) {
    test::write_bytes(path_, text);
    return TrcReader(path_, options);
  }
  std::string error(const std::string& text, const TakeOptions& options = {}) {
    return message_of<UserError>([&] {
      auto take = reader(text, options);
      read_all(take);
    });
  }
  test::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.path() / "take.trc";
};

TEST_F(Trc, ReadsNamesUnitRateAndEmptyCells) {
  auto take = reader(std::string(kHeader) +
                     "1\t0.000\t1.5\t2\t-3e-1\t4\t5\t6\t\r\n"
                     "2\t0.010\t\t\t\t4\t5\t6\r\n"
                     "4\t0.030\t1\t2\t3\t\t\t\r\n");
  EXPECT_EQ(take.info().markers.names, (std::vector<std::string>{"Chin", "Brow L"}));
  EXPECT_EQ(take.info().markers.rate_hz, 100);
  EXPECT_EQ(take.info().frame_count, 3u);
  EXPECT_TRUE(take.info().warnings.empty());
  for (int pass = 0; pass < 2; ++pass) {
    const auto frames = read_all(take);
    ASSERT_EQ(frames.size(), 3u);
    EXPECT_EQ(frames[0].position_mm[0], (Position{15, 20, -3}));
    EXPECT_EQ(frames[1].state[0], MarkerState::kMissing);
    EXPECT_EQ(frames[1].state[1], MarkerState::kMeasured);
    EXPECT_EQ(frames[2].state[1], MarkerState::kMissing);
    EXPECT_EQ(frames[2].header.sequence, 3u) << "frame 3 was lost: the sequence leaps with it";
    EXPECT_EQ(frames[2].header.capture_time_ns, 30'000'000);
    take.rewind();
  }
}

TEST_F(Trc, SaysWhatTheHeaderPromisedInVain) {
  EXPECT_TRUE(has_warning(reader(std::string(kHeader) + "1\t0\t1\t2\t3\t4\t5\t6\n"), "3 frames, the file has 1"));
}

TEST_F(Trc, NamesLineAndRemedyOfWhatIsWrong) {
  const std::string good = kHeader;
  EXPECT_NE(error("").find("empty"), std::string::npos);
  EXPECT_NE(error("frame,time_s\n").find("PathFileType"), std::string::npos);
  EXPECT_NE(error(good).find("no frames"), std::string::npos);
  EXPECT_NE(error(good.substr(0, 60)).find("line 2"), std::string::npos);
  EXPECT_NE(error(good + "1\t0\t1\t2\n").find("line 7: marker Chin has 2 of 3"), std::string::npos);
  EXPECT_NE(error(good + "1\t0\t1\tx\t3\n").find("line 7, cell 4: 'x'"), std::string::npos);
  EXPECT_NE(error(good + "1\t0\t1\t2e39\t3\n").find("line 7, cell 4: '2e39' puts marker Chin more than a kilometre"),
            std::string::npos);
  EXPECT_NE(error(good + "2\t0\n2\t0\n").find("frame 2 does not come after"), std::string::npos);
  EXPECT_NE(error(good + "1.5\t0\n").find("no frame number"), std::string::npos);
  EXPECT_NE(error(good + "1\t0\t1\t2\t3\n1000000000\t1\t1\t2\t3\n").find("line 8: the frame numbers leap from 1"),
            std::string::npos);
  std::string furlongs = good;
  furlongs.replace(furlongs.find("cm"), 2, "fl");
  EXPECT_NE(error(furlongs + "1\t0\t1\t2\t3\n").find("Units: 'fl'"), std::string::npos);
  EXPECT_EQ(error(furlongs + "1\t0\t1\t2\t3\n", {.mm_per_unit = 1.0}), "");
}

TEST_F(Trc, EveryTruncationIsReadOrRefusedClearly) {
  const std::string whole = std::string(kHeader) + "1\t0.000\t1.5\t2\t3\t4\t5\t6\n2\t0.01\t1\t2\t3\t4\t5\t6\n";
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const std::string message = error(whole.substr(0, size));
    EXPECT_TRUE(message.empty() || message.find("take.trc") != std::string::npos) << size;
  }
}

TEST_F(Trc, ReadsTheRealFilesOfOtherPrograms) {
  RISORIUS_NEEDS_DATA(folder, "trc");
  auto knee = open_take(folder / "Knee.trc");
  EXPECT_EQ(knee->info().markers.rate_hz, 200);
  EXPECT_EQ(knee->info().markers.names.size(), 71u);
  EXPECT_EQ(knee->info().markers.names[3], "genou1_NewMarker3");
  auto frames = read_all(*knee);
  ASSERT_EQ(frames.size(), 200u);
  EXPECT_FLOAT_EQ(frames[0].position_mm[0].x, 256.84422f);
  EXPECT_EQ(frames[199].header.capture_time_ns, 995'000'000);
  auto gait = open_take(folder / "Gait.trc");
  EXPECT_EQ(gait->info().markers.names.size(), 33u);
  EXPECT_TRUE(has_warning(*gait, "without a name")) << "half of its 66 markers are not labelled";
  EXPECT_EQ(read_all(*gait).size(), 487u);
  EXPECT_THROW(open_take(folder / "Empty.trc"), UserError);
}

}  // namespace
}  // namespace risorius
