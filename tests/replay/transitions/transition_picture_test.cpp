#include "replay/transitions/transition_picture.h"

#include <gtest/gtest.h>
#include <stdexcept>

namespace risorius {
namespace {

TEST(TransitionPicture, HasAPanelForEachAuThatMovesMost) {
  const std::vector<std::string> names{"AU1", "AU2", "AU4"};
  const AuMatrix past = AuMatrix::Zero(2, 3);
  AuMatrix course(5, 3);
  for (Eigen::Index row = 0; row < 5; ++row) course.row(row) << 0, 0.1F * static_cast<float>(row), 0.01F;
  const Canvas all = transition_picture("a to b", names, past, {{"x", course}}, 120);
  const Canvas two = transition_picture("a to b", names, past, {{"x", course}, {"y", course}}, 120, 2);
  EXPECT_GT(all.height(), two.height()) << "two rows of panels, and one";
  EXPECT_EQ(all.width(), two.width());
}

TEST(TransitionPicture, HasItsLegendAboveThePanelsInAsManyRowsAsItTakes) {
  const AuMatrix past = AuMatrix::Zero(2, 1), course = AuMatrix::Zero(5, 1);
  const std::string label(40, 'm');
  const Canvas one = transition_picture("", {"AU1"}, past, {{label, course}}, 120);
  const Canvas many = transition_picture("", {"AU1"}, past, std::vector<TransitionCourse>(8, {label, course}), 120);
  EXPECT_GT(many.height(), one.height()) << "the panel is as high as before";
}

TEST(TransitionPicture, RefusesSizesThatDoNotFit) {
  const AuMatrix past = AuMatrix::Zero(2, 1), course = AuMatrix::Zero(5, 1);
  EXPECT_THROW(transition_picture("", {"AU1"}, past, {}, 120), std::invalid_argument);
  EXPECT_THROW(transition_picture("", {"AU1", "AU2"}, past, {{"x", course}}, 120), std::invalid_argument);
  EXPECT_THROW(transition_picture("", {"AU1"}, past, {{"x", AuMatrix(0, 1)}}, 120), std::invalid_argument);
}

}  // namespace
}  // namespace risorius
