#include "daemon/slip_monitor.h"

#include <gtest/gtest.h>

#include "solve/faces/builtin_face.h"

namespace risorius {
namespace {

/// One stream at 120 Hz: the built-in face at rest.
class SlipMonitorTest : public testing::Test {
 protected:
  SlipMonitorTest() : monitor([this] { return rig; }) {
    markers.names = rig.marker_names;
    while (!(rig.stabiliser_weight[static_cast<Eigen::Index>(stabiliser)] > 0)) ++stabiliser;
    item.kind = OutputItem::Kind::kMarkerSet;
    item.marker_set = &markers;
    monitor.take(item);
  }

  /// `off_mm`: of the first stabiliser, up.
  void take_seconds(double seconds, float off_mm) {
    item.kind = OutputItem::Kind::kSolved;
    for (int i = 0; i < static_cast<int>(seconds * 120); ++i, ++frame) {
      SolvedFrame& solved = item.solved;
      solved.markers.header.capture_time_ns = frame * 8'333'333;
      solved.markers.count = static_cast<std::uint32_t>(rig.marker_count());
      for (std::size_t m = 0; m < rig.marker_count(); ++m) {
        const Eigen::Vector3f p = rig.neutral_mm.col(static_cast<Eigen::Index>(m)).cast<float>();
        solved.markers.position_mm[m] = {p.x(), p.y() + (m == stabiliser ? off_mm : 0), p.z()};
        solved.markers.state[m] = MarkerState::kMeasured;
      }
      solved.aus.count = static_cast<std::uint32_t>(rig.au_count());
      solved.aus.status = SolverStatus::kConverged;
      monitor.take(item);
    }
  }

  Rig rig = builtin_rig();
  MarkerSet markers;
  std::size_t stabiliser = 0;
  OutputItem item;
  std::int64_t frame = 0;
  SlipMonitor monitor;
};

TEST_F(SlipMonitorTest, AStabiliserThatComesOffIsNamedOnce) {
  take_seconds(10, 0);
  EXPECT_EQ(monitor.state().count, 0u);
  EXPECT_LT(monitor.state().stabiliser_mm, 0.1);
  take_seconds(20, 4);
  EXPECT_EQ(monitor.state().count, 1u);
  EXPECT_TRUE(monitor.state().last.starts_with(rig.marker_names[stabiliser] + " slipped by ")) << monitor.state().last;
  EXPECT_GT(monitor.state().stabiliser_mm, 1.5);
}

TEST_F(SlipMonitorTest, ANewNeutralBeginsAnewAndForgetsNoSlip) {
  take_seconds(5, 0);
  take_seconds(15, 4);
  ASSERT_EQ(monitor.state().count, 1u);
  rig.neutral_mm(1, static_cast<Eigen::Index>(stabiliser)) += 4;
  item.kind = OutputItem::Kind::kNeutral;
  monitor.take(item);
  take_seconds(15, 0);  // where the new neutral has it
  EXPECT_EQ(monitor.state().count, 1u);
  EXPECT_LT(monitor.state().stabiliser_mm, 0.1);
}

TEST_F(SlipMonitorTest, AWanderingNeutralShows) {
  take_seconds(15, 0);
  EXPECT_LT(monitor.state().neutral_mm, 0.1);
  for (Eigen::Index m = 0; m < rig.neutral_mm.cols(); ++m) {
    if (!(rig.stabiliser_weight[m] > 0)) rig.neutral_mm(2, m) += m % 2 == 0 ? 1.5 : -1.5;
  }
  take_seconds(60, 0);
  EXPECT_GT(monitor.state().neutral_mm, 1.0);
}

}  // namespace
}  // namespace risorius
