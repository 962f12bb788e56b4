#include "replay/performer/marker_defects.h"

#include <fstream>
#include <gtest/gtest.h>
#include <memory>
#include <string>

#include "replay/performer/performer.h"
#include "replay/performer/truth_files.h"
#include "solve/faces/builtin_face.h"
#include "support/test_data.h"

namespace {

using namespace risorius;

constexpr std::size_t kMarkers = 36;

/// A grid of 6 by 6 markers, 20 mm apart.
Eigen::Matrix3Xd grid() {
  Eigen::Matrix3Xd at(3, kMarkers);
  for (int i = 0; i < 36; ++i) at.col(i) = Eigen::Vector3d(20 * (i % 6), 20 * (i / 6), 0);
  return at;
}

struct Frames {
  std::unique_ptr<MarkerFrame> clean = std::make_unique<MarkerFrame>(), observed = std::make_unique<MarkerFrame>();
  void fill() {
    clean->count = observed->count = kMarkers;
    for (std::size_t m = 0; m < kMarkers; ++m) {
      clean->state[m] = MarkerState::kMeasured;
      clean->position_mm[m] = {20.0F * static_cast<float>(m % 6), 20.0F * static_cast<float>(m / 6), 0};
    }
  }
};

TEST(MarkerDefects, ARegionIsEverythingWithinAHand) {
  const Eigen::Matrix3Xd at = grid();
  MarkerDefects defects(at, 100,
                        {.noise_mm = 0, .occlusion_share = 0, .false_track_share = 0, .regions_per_minute = 20}, 3);
  Frames frames;
  int events = 0, covered_frames = 0;
  bool was_covered = false;
  constexpr int kFrames = 100 * 300;
  for (int f = 0; f < kFrames; ++f) {
    frames.fill();
    defects.apply(*frames.clean, *frames.observed);
    std::vector<Eigen::Index> hidden;
    for (std::size_t m = 0; m < kMarkers; ++m) {
      if (defects.causes()[m] == DefectCause::kGood) continue;
      ASSERT_EQ(defects.causes()[m], DefectCause::kRegionOccluded);
      ASSERT_EQ(frames.observed->state[m], MarkerState::kMissing);
      hidden.push_back(static_cast<Eigen::Index>(m));
    }
    events += !hidden.empty() && !was_covered;
    was_covered = !hidden.empty();
    covered_frames += was_covered;
    if (hidden.empty()) continue;
    // One of them is the middle: the others are those within 40 mm of it, and no more.
    bool has_middle = false;
    for (const Eigen::Index middle : hidden) {
      std::size_t near = 0;
      for (Eigen::Index m = 0; m < at.cols(); ++m) near += (at.col(m) - at.col(middle)).norm() <= 40;
      bool all_near = true;
      for (const Eigen::Index m : hidden) all_near = all_near && (at.col(m) - at.col(middle)).norm() <= 40;
      has_middle = has_middle || (all_near && near == hidden.size());
    }
    ASSERT_TRUE(has_middle) << f;
  }
  EXPECT_NEAR(events, 100 / 1.2, 30);  // 20 a minute of the free time, each 0.57 s on average; 3 deviations
  EXPECT_NEAR(static_cast<double>(covered_frames) / 100 / events, 0.57, 0.15);
}

TEST(MarkerDefects, ColouredNoiseLastsAndHasTheAskedDeviation) {
  MarkerDefects defects(grid(), 100,
                        {.noise_mm = 0, .occlusion_share = 0, .false_track_share = 0, .coloured_noise_mm = 0.4}, 3);
  Frames frames;
  double squares = 0, products = 0, count = 0;
  std::vector<float> last(kMarkers, 0);
  constexpr int kFrames = 20000;
  for (int f = 0; f < kFrames; ++f) {
    frames.fill();
    defects.apply(*frames.clean, *frames.observed);
    for (std::size_t m = 0; m < kMarkers; ++m) {
      const float error = frames.observed->position_mm[m].z;
      squares += error * error;
      products += error * last[m];
      last[m] = error;
      ++count;
    }
  }
  EXPECT_NEAR(std::sqrt(squares / count), 0.4, 0.02);
  EXPECT_NEAR(products / squares, std::exp(-0.01 / 0.25), 0.01);  // from frame to frame
}

TEST(MarkerDefects, WhatIsMissingStaysMissingAndNobodysPartner) {
  MarkerDefects defects(grid(), 100, {.noise_mm = 0, .occlusion_share = 0, .false_track_share = 0.2}, 3);
  Frames frames;
  int jumps = 0;
  for (int f = 0; f < 2000; ++f) {
    frames.fill();
    for (std::size_t m = 0; m < kMarkers; m += 2) {
      frames.clean->state[m] = MarkerState::kMissing;
      frames.clean->position_mm[m] = {-999, -999, -999};
    }
    defects.apply(*frames.clean, *frames.observed);
    for (std::size_t m = 0; m < kMarkers; ++m) {
      if (m % 2 == 0) {
        ASSERT_EQ(defects.causes()[m], DefectCause::kAbsent);
        ASSERT_EQ(frames.observed->state[m], MarkerState::kMissing);
      } else {
        ASSERT_GT(frames.observed->position_mm[m].x, -100) << "a track went where nobody was";
        jumps += defects.causes()[m] == DefectCause::kJump;
      }
    }
  }
  EXPECT_GT(jumps, 100);
}

TEST(TruthFiles, HaveOneLinePerFrameAndOneLetterPerMarker) {
  test::TemporaryFolder folder;
  PerformerOptions options{.seconds = 2, .occlusion_share = 0.2};
  Performance performance(builtin_rig(), options);
  TruthWriter writer(folder.path() / "truth.csv", performance.rig().au_names());
  const auto observed = std::make_unique<MarkerFrame>(), clean = std::make_unique<MarkerFrame>();
  const auto truth = std::make_unique<AuFrame>();
  std::vector<std::string> letters;
  while (performance.next(*observed, *truth, *clean)) {
    writer.write(*truth, performance.causes());
    std::string& line = letters.emplace_back();
    for (std::size_t m = 0; m < clean->count; ++m)
      line += clean->state[m] == MarkerState::kMeasured ? '.' : clean->state[m] == MarkerState::kMissing ? 'o' : 'x';
  }
  writer.finish(performance.script()->cues());
  ASSERT_EQ(writer.paths().size(), 4u);
  const AuSeries aus = load_au_csv(writer.paths()[0]);
  EXPECT_EQ(aus.names, performance.rig().au_names());
  EXPECT_EQ(aus.frames.size(), 240u);
  std::ifstream markers(folder.path() / "truth.markers.csv");
  std::string line;
  std::getline(markers, line);
  EXPECT_EQ(line, "frame,causes");
  for (std::size_t f = 0; f < 240; ++f) {
    ASSERT_TRUE(std::getline(markers, line));
    std::string read = line.substr(line.find(',') + 1);
    for (char& letter : read) letter = letter == 'j' || letter == 'g' || letter == 's' ? 'x' : letter;
    EXPECT_EQ(read, letters[f]) << f;
  }
  EXPECT_FALSE(std::getline(markers, line));
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "truth.pose.csv"));
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "truth.cues.csv"));
}

}  // namespace
