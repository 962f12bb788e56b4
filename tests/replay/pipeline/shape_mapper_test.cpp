#include "replay/pipeline/shape_mapper.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "capture/wire/live_link_codec.h"
#include "solve/faces/builtin_face.h"
#include "support/allocation_counter.h"

namespace risorius {
namespace {

Rig rig_with(const std::vector<std::string>& au_names) {
  Rig rig = builtin_rig();
  const RigAu any = rig.aus.front();
  rig.aus.clear();
  for (const auto& name : au_names) {
    rig.aus.push_back(any);
    rig.aus.back().name = name;
  }
  return rig;
}

std::size_t shape(std::string_view name) {
  const auto names = live_link_shape_names();
  return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
}

ShapeFrame face(std::initializer_list<std::pair<const char*, float>> values, std::int64_t time_ns = 0) {
  ShapeFrame frame;
  frame.has_face = true;
  frame.header.capture_time_ns = time_ns;
  for (const auto& [name, value] : values) frame.value[shape(name)] = value;
  return frame;
}

TEST(ShapeMapper, SidesGoByNameAndColumnsWithoutASideAreTheMean) {
  ShapeMapper mapper(shipped_arkit_table(), rig_with({"AU12L", "AU12R", "AU9", "AU1L"}));
  AuFrame aus;
  mapper.process(
      face({{"mouthSmileLeft", 0.25F}, {"noseSneerLeft", 0.5F}, {"noseSneerRight", 0.25F}, {"browInnerUp", 0.75F}}),
      aus);
  EXPECT_EQ(aus.kind, AuFrameKind::kMapped);
  EXPECT_EQ(aus.status, SolverStatus::kMapped);
  ASSERT_EQ(aus.count, 4u);
  EXPECT_EQ(aus.intensity[0], 0.25);
  EXPECT_EQ(aus.intensity[1], 0);
  EXPECT_EQ(aus.intensity[2], 0.375);
  EXPECT_EQ(aus.intensity[3], 0.75);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(aus.state[k], AuState::kObserved);
    EXPECT_TRUE(std::isnan(aus.standard_deviation[k])) << "nobody knows it";
  }
}

TEST(ShapeMapper, AColumnThatNoShapeTellsOfIsNotObservedAndNamed) {
  ShapeMapper mapper(shipped_arkit_table(), rig_with({"AU12L", "AU13L", "AU23"}));
  EXPECT_EQ(mapper.not_mapped(), (std::vector<std::string>{"AU13L", "AU23"}));
  AuFrame aus;
  mapper.process(face({}), aus);
  EXPECT_EQ(aus.state[0], AuState::kObserved);
  EXPECT_EQ(aus.state[1], AuState::kNotObserved);
  EXPECT_EQ(aus.state[2], AuState::kNotObserved);
}

TEST(ShapeMapper, TheJawIsOneColumnOrTwoAsTheRigHasIt) {
  AuFrame aus;
  ShapeMapper(shipped_arkit_table(), rig_with({"AU27"})).process(face({{"jawOpen", 0.75F}}), aus);
  EXPECT_EQ(aus.intensity[0], 0.75);
  ShapeMapper(shipped_arkit_table(), rig_with({"AU26", "AU27"})).process(face({{"jawOpen", 0.75F}}), aus);
  EXPECT_EQ(aus.intensity[0], 1);
  EXPECT_NEAR(aus.intensity[1], 0.375, 1e-12);
}

TEST(ShapeMapper, WithoutAFaceWhatWasSeenIsHeldAndAResetForgetsIt) {
  ShapeMapper mapper(shipped_arkit_table(), rig_with({"AU12L", "AU13L"}));
  const ShapeFrame nobody;
  AuFrame aus;
  mapper.process(nobody, aus);
  EXPECT_EQ(aus.status, SolverStatus::kNoFace);
  EXPECT_EQ(aus.state[0], AuState::kNotObserved);
  mapper.process(face({{"mouthSmileLeft", 0.5F}}), aus);
  mapper.process(nobody, aus);
  EXPECT_EQ(aus.state[0], AuState::kHeld);
  EXPECT_EQ(aus.intensity[0], 0.5);
  EXPECT_EQ(aus.state[1], AuState::kNotObserved);
  mapper.process(face({{"mouthSmileLeft", ShapeFrame::kNone}}), aus);
  EXPECT_EQ(aus.status, SolverStatus::kMapped);
  EXPECT_EQ(aus.state[0], AuState::kHeld) << "a shape that was not told is not 0";
  mapper.reset();
  mapper.process(nobody, aus);
  EXPECT_EQ(aus.state[0], AuState::kNotObserved);
}

TEST(ShapeMapper, IntensitiesEndAtTheRigsBound) {
  ShapeMapper mapper(shipped_arkit_table(), rig_with({"AU12L"}));
  AuFrame aus;
  mapper.process(face({{"mouthSmileLeft", 1.9F}}), aus);
  EXPECT_EQ(aus.intensity[0], builtin_rig().aus.front().upper_bound);
  mapper.process(face({{"mouthSmileLeft", -0.1F}}), aus);
  EXPECT_EQ(aus.intensity[0], 0);
}

TEST(ShapeMapper, ANeutralIsTheMeanOfItsTimeAndHoldsFromTheNextFrameOn) {
  ShapeMapper mapper(shipped_arkit_table(), rig_with({"AU12L", "AU12R"}));
  mapper.begin_neutral_capture(100);
  AuFrame aus;
  mapper.process(ShapeFrame{}, aus);  // nobody: nothing to learn from
  mapper.process(face({{"mouthSmileLeft", 0.25F}}, 1000), aus);
  mapper.process(face({{"mouthSmileLeft", 0.5F}}, 1050), aus);
  EXPECT_EQ(mapper.neutrals_completed(), 0u);
  mapper.process(face({{"mouthSmileLeft", 0.75F}}, 1100), aus);
  EXPECT_EQ(mapper.neutrals_completed(), 1u);
  EXPECT_EQ(mapper.neutral()[shape("mouthSmileLeft")], 0.375);
  EXPECT_EQ(aus.intensity[0], 0.75);
  mapper.process(face({{"mouthSmileLeft", 0.75F}, {"mouthSmileRight", 0.5F}}, 1150), aus);
  EXPECT_EQ(aus.intensity[0], 0.375);
  EXPECT_EQ(aus.intensity[1], 0.5);
  mapper.process(face({{"mouthSmileLeft", 0.25F}}, 1200), aus);
  EXPECT_EQ(aus.intensity[0], 0) << "never below 0";
}

TEST(ShapeMapper, AllocatesNothing) {
  ShapeMapper mapper(shipped_arkit_table(), builtin_rig());
  AuFrame aus;
  const std::uint64_t before = test::allocations_of_this_thread();
  for (int i = 0; i < 100; ++i) mapper.process(face({{"jawOpen", 0.5F}}, i), aus);
  EXPECT_EQ(test::allocations_of_this_thread(), before);
}

}  // namespace
}  // namespace risorius
