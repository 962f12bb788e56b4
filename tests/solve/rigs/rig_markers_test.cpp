#include "solve/rigs/rig_markers.h"

#include <gtest/gtest.h>
#include <limits>

#include "synthetic_face.h"

namespace risorius {
namespace {

TEST(RigMarkers, AcceptsOnlyFramesOfItsSet) {
  const Rig rig = test::synthetic_rig(12, 2);
  RigMarkers markers(rig, 0.2);
  MarkerFrame frame = test::marker_frame(rig, Eigen::Vector2d(0, 0));
  EXPECT_FALSE(markers.accepts(frame));
  markers.use_marker_set(rig, test::marker_set_of(rig));
  EXPECT_TRUE(markers.accepts(frame));
  frame.count = 11;
  EXPECT_FALSE(markers.accepts(frame));
  frame.count = 12;
  frame.header.set_id += 1;
  EXPECT_FALSE(markers.accepts(frame));
}

TEST(RigMarkers, StateAndPositionGiveTheWeight) {
  const Rig rig = test::synthetic_rig(12, 2);
  RigMarkers markers(rig, 0.2);
  markers.use_marker_set(rig, test::marker_set_of(rig));
  MarkerFrame frame = test::marker_frame(rig, Eigen::Vector2d(0, 0));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  frame.state[1] = MarkerState::kMissing;
  frame.state[2] = MarkerState::kRejected;
  frame.position_mm[3].y = nan;
  frame.position_mm[4].z = -2e6f;  // 2 km
  for (const int m : {5, 6, 7}) frame.state[m] = MarkerState::kFilled;
  frame.standard_deviation_mm[5] = 0.2f;
  frame.standard_deviation_mm[6] = nan;
  frame.standard_deviation_mm[7] = 0;
  markers.read(frame);
  const std::array expected{1.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 1.0, 1.0};
  for (std::size_t m = 0; m < expected.size(); ++m) {
    EXPECT_NEAR(markers.weight()[static_cast<Eigen::Index>(m)], expected[m], 1e-6) << m;
  }
  EXPECT_TRUE(markers.is_measured(0));
  EXPECT_FALSE(markers.is_measured(7));
  EXPECT_EQ(markers.world_mm(8).x(), frame.position_mm[8].x);
}

TEST(RigMarkers, NamesTheMarkersThatTheSetLacksAndCountsThoseBeyondEight) {
  const Rig rig = test::synthetic_rig(12, 2);
  MarkerSet set = test::marker_set_of(rig);
  EXPECT_EQ(describe_absent_markers(rig, set), "");
  set.names[2] = "other";
  EXPECT_EQ(describe_absent_markers(rig, set),
            "1 of the rig's 12 markers are not in the marker set: " + rig.marker_names[2]);
  set.names.resize(2);
  const std::string text = describe_absent_markers(rig, set);
  EXPECT_TRUE(text.starts_with("10 of the rig's 12 markers")) << text;
  EXPECT_TRUE(text.ends_with(rig.marker_names[9] + " and 2 more")) << text;
}

}  // namespace
}  // namespace risorius
