#include "replay/takes/live_link_csv.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>

#include "capture/errors.h"
#include "support/test_data.h"

namespace {

using namespace risorius;

/// A file whose frames have these timecodes.
std::filesystem::path write(const test::TemporaryFolder& folder, const std::vector<std::string>& timecodes,
                            const std::string& value = "0.5", const std::string& count = "BlendShapeCount") {
  const auto path = folder.path() / "face.csv";
  std::ofstream file(path);
  file << "Timecode," << count << ",EyeBlinkLeft,JawRight,JawLeft\n";
  for (const auto& code : timecodes) file << code << ",61," << value << ",0.25,1.003\n";
  return path;
}

/// Frames counted by `step` in a base of `base` per second, from 12:00:00.
std::vector<std::string> timecodes(int frames, int base, int step, const char* fraction = "") {
  std::vector<std::string> codes;
  for (int i = 0; i < frames; ++i) {
    const int unit = i * step;
    codes.push_back(fmt::format("12:{:02}:{:02}:{:02}{}", unit / base / 60, unit / base % 60, unit % base, fraction));
  }
  return codes;
}

std::string complaint_of(const std::filesystem::path& path) {
  try {
    load_live_link_csv(path);
  } catch (const UserError& error) {
    return error.what();
  }
  return "";
}

TEST(LiveLinkCsv, InfersTheRateFromTheSteps) {
  test::TemporaryFolder folder;
  EXPECT_EQ(load_live_link_csv(write(folder, timecodes(100, 60, 2))).rate_hz, 30);  // 30 in a base of 60
  EXPECT_EQ(load_live_link_csv(write(folder, timecodes(200, 60, 1, ".652"))).rate_hz, 60);
  EXPECT_EQ(load_live_link_csv(write(folder, timecodes(100, 30, 1))).rate_hz, 30);
  EXPECT_EQ(load_live_link_csv(write(folder, timecodes(100, 25, 1))).rate_hz, 25);
  EXPECT_EQ(load_live_link_csv(write(folder, timecodes(300, 24, 1))).rate_hz, 24);
  EXPECT_EQ(load_live_link_csv(write(folder, timecodes(100, 60, 2)), 29.97).rate_hz, 29.97);
}

TEST(LiveLinkCsv, AsksForTheRateWhereTheTimecodesDoNotSayIt) {
  test::TemporaryFolder folder;
  const auto path = write(folder, timecodes(20, 60, 1));
  EXPECT_NE(complaint_of(path).find("--rate"), std::string::npos);
  EXPECT_EQ(load_live_link_csv(path, 60).shapes.frames.back(), 19u);
}

TEST(LiveLinkCsv, KeepsHolesNamesAndValues) {
  test::TemporaryFolder folder;
  auto codes = timecodes(100, 60, 2);
  codes.erase(codes.begin() + 40, codes.begin() + 43);
  const LiveLinkTake take = load_live_link_csv(write(folder, codes, "", "BlendshapeCount"));
  EXPECT_EQ(take.rate_hz, 30);
  EXPECT_EQ(take.shapes.names, (std::vector<std::string>{"eyeBlinkLeft", "jawRight", "jawLeft"}));
  ASSERT_EQ(take.shapes.frames.size(), 97u);
  EXPECT_EQ(take.shapes.frames[39], 39u);
  EXPECT_EQ(take.shapes.frames[40], 43u);
  EXPECT_EQ(take.shapes.frames.back(), 99u);
  ASSERT_EQ(take.warnings.size(), 1u);
  EXPECT_NE(take.warnings[0].find("3 frames lost"), std::string::npos);
  EXPECT_TRUE(std::isnan(take.shapes.intensities[0][0])) << "an empty cell is not observed";
  EXPECT_EQ(take.shapes.intensities[0][2], 1.003);
}

TEST(LiveLinkCsv, GoesOnOverMidnight) {
  test::TemporaryFolder folder;
  std::vector<std::string> codes;
  for (int i = 0; i < 60; ++i) codes.push_back(fmt::format("{}:{:02}", i < 30 ? "23:59:59" : "00:00:00", i % 30));
  EXPECT_EQ(load_live_link_csv(write(folder, codes)).shapes.frames.back(), 59u);
}

TEST(LiveLinkCsv, RefusesWhatItCannotReadByLineAndColumn) {
  test::TemporaryFolder folder;
  auto codes = timecodes(100, 60, 1);
  std::swap(codes[50], codes[51]);
  EXPECT_NE(complaint_of(write(folder, codes)).find("line 53"), std::string::npos);  // frame 51
  EXPECT_NE(complaint_of(write(folder, {"12:00:00"})).find("Timecode"), std::string::npos);
  EXPECT_NE(complaint_of(write(folder, {"12:61:00:00"})).find("line 2"), std::string::npos);
  EXPECT_NE(complaint_of(write(folder, timecodes(100, 60, 1), "7")).find("EyeBlinkLeft"), std::string::npos);
  EXPECT_NE(complaint_of(write(folder, timecodes(100, 60, 1), "x")).find("EyeBlinkLeft"), std::string::npos);
  EXPECT_NE(complaint_of(write(folder, {})).find("no frames"), std::string::npos);
  std::ofstream(folder.path() / "other.csv") << "Frame,AU1\n0,1\n";
  EXPECT_NE(complaint_of(folder.path() / "other.csv").find("line 1"), std::string::npos);
  EXPECT_FALSE(is_live_link_csv(folder.path() / "other.csv"));
  EXPECT_TRUE(is_live_link_csv(write(folder, {})));
}

TEST(LiveLinkCsv, ReadsRealRecordings) {
  RISORIUS_NEEDS_DATA(rom, "arkit/alex_rom_3.csv");
  const LiveLinkTake take = load_live_link_csv(rom);
  EXPECT_EQ(take.rate_hz, 30);
  EXPECT_EQ(take.shapes.intensities.size(), 4030u);
  EXPECT_EQ(take.shapes.frames.back(), 4032u);  // three holes of one frame
  RISORIUS_NEEDS_DATA(speech, "arkit/MySlate_161_iPhone_cal.csv");
  EXPECT_EQ(load_live_link_csv(speech).rate_hz, 60);
}

TEST(LiveLinkCsv, SeesNoHoleWhereUnevenStepsAddUp) {
  test::TemporaryFolder folder;
  // Steps of 1.3 and 0.9 units in turn: after ten frames the sum is a whole frame ahead, but none is lost.
  std::vector<std::string> codes;
  double unit = 0;
  for (int i = 0; i < 100; ++i) {
    codes.push_back(fmt::format("12:00:{:02}:{:06.3f}", static_cast<int>(unit) / 60, std::fmod(unit, 60)));
    unit += i % 2 == 0 ? 1.3 : 0.9;
  }
  const LiveLinkTake take = load_live_link_csv(write(folder, codes));
  EXPECT_EQ(take.shapes.frames.back(), 99u);
  EXPECT_TRUE(take.warnings.empty());
}

}  // namespace
