#include "replay/dataset/take_dataset.h"

#include <csignal>
#include <fstream>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sstream>
#include <sys/resource.h>

#include "capture/errors.h"
#include "replay/performer/performer.h"
#include "solve/faces/builtin_face.h"
#include "support/test_data.h"

namespace risorius {
namespace {

std::vector<std::string> lines_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

struct Performed {
  MarkerSet set;
  std::vector<SolvedFrame> frames;
};

Performed perform(double seconds) {
  PerformerTake take(builtin_rig(), {.seconds = seconds});
  FramePipeline pipeline({}, builtin_rig());
  pipeline.use_marker_set(take.info().markers);
  Performed performed{take.info().markers, {}};
  MarkerFrame frame;
  SolvedFrame solved;
  while (take.next(frame)) {
    pipeline.push(frame);
    while (pipeline.pop(solved)) performed.frames.push_back(solved);
  }
  return performed;
}

TEST(TakeDataset, LostFramesKeepTheirPlaceInEveryFile) {
  test::TemporaryFolder folder;
  const auto performed = perform(0.5);
  TakeDataset take(folder.path() / "t", performed.set, builtin_rig(), {.source = "test"});
  for (const auto& frame : performed.frames) {
    const auto sequence = frame.markers.header.sequence;
    if (sequence < 5 || (sequence >= 20 && sequence < 23)) continue;
    ASSERT_TRUE(take.continues_with(frame.markers));
    take.write(frame);
  }
  take.finish();
  constexpr std::size_t kFrames = 55;  // 0.5 s at 120 Hz, from frame 5 on
  EXPECT_EQ(take.frame_count(), kFrames);
  EXPECT_EQ(take.lost_count(), 3u);
  for (const char* file : {"au.csv", "au_sd.csv", "pose.csv", "quality.csv"}) {
    const auto lines = lines_of(take.folder() / file);
    ASSERT_EQ(lines.size(), kFrames + 1) << file;
    const auto commas = [](const std::string& line) { return std::count(line.begin(), line.end(), ','); };
    for (std::size_t i = 0; i < kFrames; ++i) {
      EXPECT_EQ(lines[i + 1].substr(0, lines[i + 1].find(',')), std::to_string(i + 5)) << file;
      EXPECT_EQ(commas(lines[i + 1]), commas(lines[0])) << file << ": " << lines[i + 1];
    }
  }
  EXPECT_NE(lines_of(take.folder() / "quality.csv")[16].find("lost"), std::string::npos);  // sequence 20
  const auto c3d = open_take(take.folder() / "cleaned.c3d");
  EXPECT_EQ(c3d->info().frame_count, kFrames);
  MarkerFrame frame;
  for (std::size_t i = 0; c3d->next(frame); ++i) {
    const bool lost = i >= 15 && i < 18;
    EXPECT_EQ(frame.state[0] == MarkerState::kMissing, lost) << i;
  }
}

/// While it lives, no file of this process may grow beyond so many bytes.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    EXPECT_EQ(getrlimit(RLIMIT_FSIZE, &before_), 0);
    rlimit tight = before_;
    tight.rlim_cur = bytes;
    EXPECT_EQ(setrlimit(RLIMIT_FSIZE, &tight), 0);
  }
  ~FileSizeLimit() { setrlimit(RLIMIT_FSIZE, &before_); }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit before_{};
};

TEST(TakeDataset, KeepsWhatWasWrittenWhenTheDiskRefusesTheRest) {
  test::TemporaryFolder folder;
  const auto performed = perform(8);
  std::size_t written = 0;
  std::string why;
  TakeDataset take(folder.path() / "t", performed.set, builtin_rig(), {.source = "test"});
  {
    const FileSizeLimit limit(512 * 1024);  // au.csv and cleaned.c3d grow larger
    try {
      for (; written < performed.frames.size(); ++written) take.write(performed.frames[written]);
    } catch (const UserError& error) {
      why = error.what();
    }
    ASSERT_NE(why, "");
    take.finish_early(why);
  }
  EXPECT_LE(take.frame_count(), written);
  EXPECT_GE(take.frame_count() + 240, written);  // the buffers' and the last second's
  EXPECT_GE(take.frame_count(), 120u);
  for (const char* file : {"au.csv", "au_sd.csv", "pose.csv", "quality.csv"})
    EXPECT_EQ(lines_of(take.folder() / file).size(), take.frame_count() + 1) << file;
  EXPECT_EQ(open_take(take.folder() / "cleaned.c3d")->info().frame_count, take.frame_count());
  std::ifstream file(take.folder() / "take.json");
  const auto json = nlohmann::json::parse(file);
  EXPECT_EQ(json.at("frames"), take.frame_count());
  EXPECT_EQ(json.at("ended_early"), why);
  EXPECT_FALSE(std::filesystem::exists(take.folder() / "reserve"));
}

TEST(TakeDataset, AFewFramesFarApartMakeNoTakeOfManyRows) {
  test::TemporaryFolder folder;
  auto performed = perform(0.1);
  performed.set.rate_hz = 10'000;
  TakeDataset take(folder.path() / "t", performed.set, builtin_rig(), {.source = "test"});
  SolvedFrame frame = performed.frames[0];
  take.write(frame);
  const auto continues = [&](std::uint64_t lost) {
    frame.markers.header.sequence = frame.aus.header.sequence = take.frame_count() + lost;
    frame.markers.header.capture_time_ns = static_cast<std::int64_t>(frame.markers.header.sequence) * 100'000;
    return take.continues_with(frame.markers);
  };
  EXPECT_FALSE(continues(99'999));
  EXPECT_FALSE(continues(2'021));
  ASSERT_TRUE(continues(2'020));  // 2000, and 20 for the frame that came
  take.write(frame);
  EXPECT_FALSE(continues(21));
  EXPECT_TRUE(continues(20));
}

TEST(TakeDataset, SecondsCountFromTheTakesFirstFrameWhateverTheTrackersClockSays) {
  test::TemporaryFolder folder;
  auto performed = perform(3);
  for (const char* name : {"from_0", "from_9_days"}) {
    TakeDataset take(folder.path() / name, performed.set, builtin_rig(), {.source = "test"});
    for (const auto& frame : performed.frames) take.write(frame);
    take.finish();
    for (auto& frame : performed.frames) {
      frame.markers.header.capture_time_ns += 777'777'777'777'777;
      frame.aus.header.capture_time_ns += 777'777'777'777'777;
    }
  }
  ASSERT_GT(lines_of(folder.path() / "from_0" / "episodes.csv").size(), 1u);
  for (const char* file : {"episodes.csv", "quality.csv"})
    EXPECT_EQ(lines_of(folder.path() / "from_9_days" / file), lines_of(folder.path() / "from_0" / file)) << file;
}

TEST(TakeDataset, RestartsAndLongGapsDoNotContinueATake) {
  test::TemporaryFolder folder;
  auto performed = perform(0.1);
  TakeDataset take(folder.path() / "t", performed.set, builtin_rig(), {});
  auto frame = performed.frames[0];
  frame.markers.header.sequence = 100;
  frame.markers.header.capture_time_ns = 100 * 8'333'333;
  take.write(frame);
  const auto continues = [&](std::uint64_t sequence) {
    frame.markers.header.sequence = sequence;
    // In unsigned numbers: of the sequences some are absurd, and their times may be anything.
    frame.markers.header.capture_time_ns = static_cast<std::int64_t>(sequence * 8'333'333);
    return take.continues_with(frame.markers);
  };
  EXPECT_TRUE(continues(101));
  EXPECT_TRUE(continues(101 + 1200));  // ten seconds at 120 Hz
  EXPECT_FALSE(continues(101 + 1201));
  EXPECT_FALSE(continues(100));
  EXPECT_FALSE(continues(0));
  EXPECT_FALSE(continues(1ull << 62)) << "rows for lost frames must not fill the disk";
}

TEST(TakeDataset, LearnsTheRateFromTheFramesIfTheSetStatesNone) {
  test::TemporaryFolder folder;
  auto performed = perform(0.2);
  performed.set.rate_hz = 0;
  TakeDataset take(folder.path() / "t", performed.set, builtin_rig(), {});
  for (const auto& frame : performed.frames) {
    ASSERT_TRUE(take.continues_with(frame.markers));
    take.write(frame);
  }
  take.finish();
  EXPECT_NEAR(open_take(take.folder() / "cleaned.c3d")->info().markers.rate_hz, 120, 1e-3);
  EXPECT_EQ(take.frame_count(), performed.frames.size());
}

TEST(TakeDataset, NeverWritesOverAFolder) {
  test::TemporaryFolder folder;
  const auto performed = perform(0.1);
  EXPECT_THROW(TakeDataset(folder.path(), performed.set, builtin_rig(), {}), UserError);
}

TEST(TakeDataset, TakeJsonCountsAndKeepsItsMetadata) {
  test::TemporaryFolder folder;
  const auto performed = perform(1);
  TakeDataset take(folder.path() / "t", performed.set, builtin_rig(),
                   {.source = "stage", .metadata_json = R"({"pseudonym": "P07"})"});
  for (const auto& frame : performed.frames) take.write(frame);
  take.finish();
  std::ifstream file(take.folder() / "take.json");
  const auto json = nlohmann::json::parse(file);
  EXPECT_EQ(json.at("frames"), performed.frames.size());
  EXPECT_EQ(json.at("pseudonym"), "P07");
  EXPECT_EQ(json.at("source"), "stage");
  EXPECT_LE(json.at("largest_kkt_residual"), 1e-6);
  EXPECT_GT(json.at("marker_energy_explained").at("with_aus"), json.at("marker_energy_explained").at("by_head_pose"));
  EXPECT_LE(json.at("marker_energy_explained").at("with_aus"), 1.0);
  EXPECT_EQ(lines_of(take.folder() / "episodes.csv").size(), json.at("episodes").get<std::size_t>() + 1);
}

}  // namespace
}  // namespace risorius
