#include "replay/pipeline/slip_watch.h"

#include <cmath>
#include <gtest/gtest.h>

#include "replay/dataset/take_report.h"
#include "solve/faces/builtin_face.h"

namespace risorius {
namespace {

MarkerSet set_of(const Rig& rig) {
  MarkerSet set;
  set.names = rig.marker_names;
  return set;
}

/// The face at rest in frame t at 30 Hz, head where the world is.
SolvedFrame rest(const Rig& rig, int t) {
  SolvedFrame frame;
  frame.markers.count = static_cast<std::uint32_t>(rig.marker_count());
  frame.markers.header.sequence = static_cast<std::uint64_t>(t);
  frame.markers.header.capture_time_ns = static_cast<std::int64_t>(t) * 33'333'333;
  for (std::size_t m = 0; m < rig.marker_count(); ++m) {
    const Eigen::Vector3d p = rig.neutral_mm.col(static_cast<Eigen::Index>(m));
    frame.markers.position_mm[m] = {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
    frame.markers.state[m] = MarkerState::kMeasured;
  }
  frame.aus.header = frame.markers.header;
  frame.aus.count = static_cast<std::uint32_t>(rig.au_count());
  frame.aus.status = SolverStatus::kConverged;
  for (std::size_t i = 0; i < rig.au_count(); ++i) frame.aus.state[i] = AuState::kObserved;
  return frame;
}

std::size_t first_stabiliser(const Rig& rig) {
  std::size_t m = 0;
  while (!(rig.stabiliser_weight[static_cast<Eigen::Index>(m)] > 0)) ++m;
  return m;
}

TEST(SlipWatch, NamesAStabiliserThatCameOff) {
  const Rig rig = builtin_rig();
  SlipWatch watch(rig, set_of(rig));
  const std::size_t loose = first_stabiliser(rig);
  for (int t = 0; t < 900; ++t) {
    SolvedFrame frame = rest(rig, t);
    if (t >= 300) frame.markers.position_mm[loose].y += 4;
    watch.add(frame);
  }
  ASSERT_EQ(watch.slips().size(), 1u);
  EXPECT_EQ(watch.slips()[0].marker, rig.marker_names[loose]);
  EXPECT_NEAR(watch.slips()[0].time_s, 10.5, 1.5);
  EXPECT_GT(watch.slips()[0].moved_mm, 1.5);
}

TEST(SlipWatch, AStabiliserThatAnAuCarriesForLongHasNotSlipped) {
  // A nose that wrinkles for ten seconds takes the marker on its root along.
  const Rig rig = builtin_rig();
  SlipWatch watch(rig, set_of(rig));
  double farthest_mm = 0;
  for (int t = 0; t < 900; ++t) {
    SolvedFrame frame = rest(rig, t);
    for (std::size_t i = 0; i < rig.au_count() && t >= 300 && t < 600; ++i) {
      if (!rig.aus[i].name.starts_with("AU9") && !rig.aus[i].name.starts_with("AU4")) continue;
      frame.aus.intensity[i] = 1;
      for (std::size_t m = 0; m < rig.marker_count(); ++m) {
        const auto column = static_cast<Eigen::Index>(m);
        const Eigen::Vector3f d = rig.aus[i].displacement_mm.col(column).cast<float>();
        Position& p = frame.markers.position_mm[m];
        p = {p.x + d.x(), p.y + d.y(), p.z + d.z()};
        if (rig.stabiliser_weight[column] > 0) farthest_mm = std::max(farthest_mm, static_cast<double>(d.norm()));
      }
    }
    watch.add(frame);
  }
  EXPECT_GT(farthest_mm, 1.5) << "else the test says nothing";
  EXPECT_TRUE(watch.slips().empty());
}

TEST(SlipWatch, FramesWithoutAPoseTellOfNoSlip) {
  const Rig rig = builtin_rig();
  SlipWatch watch(rig, set_of(rig));
  const std::size_t loose = first_stabiliser(rig);
  for (int t = 0; t < 900; ++t) {
    SolvedFrame frame = rest(rig, t);
    if (t >= 300 && t < 400) {
      frame.markers.position_mm[loose].y += 1e6F;
      frame.aus.status = SolverStatus::kTooFewMarkers;
    }
    watch.add(frame);
  }
  EXPECT_TRUE(watch.slips().empty());
}

TEST(SlipWatch, TakesAnExpressionForNoSlip) {
  const Rig rig = builtin_rig();
  SlipWatch watch(rig, set_of(rig));
  const std::size_t moved = first_stabiliser(rig);
  for (int t = 0; t < 900; ++t) {
    SolvedFrame frame = rest(rig, t);
    if (t % 150 > 75 && t % 150 < 120) frame.markers.position_mm[moved].y += 4;  // 1.5 s each
    watch.add(frame);
  }
  EXPECT_TRUE(watch.slips().empty());
}

TEST(SlipWatch, SeesAHeadBandSlipAgainstTheFace) {
  const Rig rig = builtin_rig();
  SlipWatch watch(rig, set_of(rig));
  for (int t = 0; t < 1800; ++t) {
    SolvedFrame frame = rest(rig, t);
    for (std::size_t m = 0; m < rig.marker_count(); ++m) {
      // The pose follows the band: in its frame the face goes down.
      if (t >= 300 && rig.stabiliser_weight[static_cast<Eigen::Index>(m)] == 0) frame.markers.position_mm[m].y -= 5;
    }
    watch.add(frame);
  }
  ASSERT_EQ(watch.slips().size(), 1u);
  EXPECT_TRUE(watch.slips()[0].marker.empty());
  EXPECT_NEAR(watch.now().band_mm, 5, 0.3);
  EXPECT_GT(watch.now().neutral_mm, 3);
}

TEST(SlipWatch, AFaceThatStaysHasNoDrift) {
  const Rig rig = builtin_rig();
  SlipWatch watch(rig, set_of(rig));
  for (int t = 0; t < 300; ++t) watch.add(rest(rig, t));
  EXPECT_TRUE(watch.slips().empty());
  EXPECT_LT(watch.now().neutral_mm, 1e-3);
  EXPECT_GE(watch.history().size(), 9u);
}

TEST(TakeReport, IsDrawnWithItsEpisodesAndTheirConfidence) {
  const Rig rig = builtin_rig();
  TakeReport report(rig, set_of(rig), "take");
  for (int t = 0; t < 300; ++t) {
    SolvedFrame frame = rest(rig, t);
    frame.aus.intensity[0] = t > 100 && t < 200 ? 0.8 : 0;
    frame.aus.standard_deviation.fill(0.05);
    report.add(frame);
  }
  const Canvas page = report.draw();
  EXPECT_EQ(page.width(), 1500);
  ASSERT_EQ(report.episodes().size(), 1u);
  EXPECT_EQ(report.episodes()[0].letter, 'D');
  EXPECT_NEAR(report.confidence_of(report.episodes()[0]), 0.954, 0.001);  // two standard deviations
}

TEST(TakeReport, OfNoFramesIsAnEmptyPage) {
  const Rig rig = builtin_rig();
  TakeReport report(rig, set_of(rig), "nothing");
  EXPECT_GT(report.draw().height(), 100);
}

TEST(TakeReport, LetterConfidenceFallsWithTheDeviation) {
  EXPECT_EQ(letter_confidence(0), 1);
  EXPECT_NEAR(letter_confidence(0.1), 0.6827, 1e-4);
  EXPECT_LT(letter_confidence(0.5), 0.2);
  EXPECT_EQ(letter_confidence(std::nan("")), 0);
}

}  // namespace
}  // namespace risorius
