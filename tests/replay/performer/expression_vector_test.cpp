#include "replay/performer/expression_vector.h"

#include <gtest/gtest.h>

#include "capture/errors.h"

namespace risorius {
namespace {

ExpressionTable table() {
  return parse_expression_table(
      R"({"format": "risorius-expressions", "version": 1, "sets": {},
          "expressions": {"calm": [{}], "glad": [{"AU12": 0.9, "AU27": 0.3}, {"AU12": 0.5, "AU99": 1}]}})",
      "test");
}

TEST(ExpressionVector, MovesBothSidesAndLeavesTheRest) {
  const auto glad = expression_vector("glad", {"AU1", "AU12L", "AU12R", "AU27"}, table());
  EXPECT_EQ(glad.intensities, (std::vector<double>{0, 0.9, 0.9, 0.3}));
  EXPECT_TRUE(glad.masked.empty());
  EXPECT_EQ(expression_vector("calm", {"AU1", "AU12"}, table()).intensities, (std::vector<double>{0, 0}));
}

TEST(ExpressionVector, TakesAnotherJawAndNamesWhatIsMasked) {
  EXPECT_EQ(expression_vector("glad", {"AU26", "AU12"}, table()).intensities, (std::vector<double>{0.3, 0.9}));
  const auto second = expression_vector("glad:2", {"AU12"}, table());
  EXPECT_EQ(second.intensities, (std::vector<double>{0.5}));
  EXPECT_EQ(second.masked, (std::vector<std::string>{"AU99"}));
}

TEST(ExpressionVector, RefusesNamesAndVariantsThatAreNone) {
  for (const char* name : {"furious", "", "glad:3", "glad:0", "glad:", "glad:x", "glad:1x", "glad:-1"})
    EXPECT_THROW(expression_vector(name, {"AU12"}, table()), UserError) << name;
  try {
    expression_vector("furious", {"AU12"}, table());
  } catch (const UserError& error) {
    EXPECT_NE(std::string(error.what()).find("calm, glad"), std::string::npos) << error.what();
  }
  EXPECT_NE(expression_names().find("surprised"), std::string::npos);
}

}  // namespace
}  // namespace risorius
