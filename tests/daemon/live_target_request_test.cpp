#include "daemon/live_target_request.h"

#include <cmath>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "capture/errors.h"

namespace risorius {
namespace {

const std::vector<std::string> kAus{"AU6L", "AU12L", "AU12R"};

LiveTargetRequest parsed(const char* json) { return live_target_of(nlohmann::json::parse(json), kAus); }

TEST(LiveTargetRequest, NamesAnExpressionOrAus) {
  const auto happy = parsed(R"({"command": "go_to", "expression": "happy", "seconds": 2, "stream": "face"})");
  EXPECT_EQ(happy.stream, "face");
  EXPECT_FLOAT_EQ(happy.target.target[1], 0.9F);
  EXPECT_EQ(happy.target.seconds, 2);
  EXPECT_EQ(happy.target.return_s, 2) << "as long back as there";
  EXPECT_EQ(happy.target.hold_s, 1);
  const auto aus = parsed(R"({"command": "go_to", "au": {"AU12R": 0.4}, "hold_seconds": 0, "return_seconds": 0.5})");
  EXPECT_FLOAT_EQ(aus.target.target[2], 0.4F);
  EXPECT_FLOAT_EQ(aus.target.target[0], 0);
  EXPECT_EQ(aus.target.hold_s, 0);
  EXPECT_EQ(aus.target.return_s, 0.5);
}

TEST(LiveTargetRequest, MayLeaveTheTimeToTheModel) {
  const auto both = parsed(R"({"command": "go_to", "expression": "happy", "seconds": "auto"})");
  EXPECT_TRUE(both.is_seconds_auto);
  EXPECT_TRUE(both.is_return_auto);
  const auto there =
      parsed(R"({"command": "go_to", "expression": "happy", "seconds": "auto", "return_seconds": 0.25})");
  EXPECT_TRUE(there.is_seconds_auto);
  EXPECT_FALSE(there.is_return_auto);
  EXPECT_EQ(there.target.return_s, 0.25);
  EXPECT_FALSE(parsed(R"({"command": "go_to", "expression": "happy"})").is_seconds_auto);
}

TEST(LiveTargetRequest, SaysWhatTheStreamDoesNotHave) {
  EXPECT_EQ(parsed(R"({"command": "go_to", "expression": "surprised"})").masked,
            (std::vector<std::string>{"AU1", "AU2", "AU27", "AU5"}));
}

TEST(LiveTargetRequest, RefusesWhatItCannotMean) {
  for (const char* json :
       {R"({"command": "go_to"})", R"({"command": "go_to", "expression": "happy", "au": {"AU6L": 1}})",
        R"({"command": "go_to", "expression": "furious"})", R"({"command": "go_to", "expression": 3})",
        R"({"command": "go_to", "au": {}})", R"({"command": "go_to", "au": {"AU99": 1}})",
        R"({"command": "go_to", "au": {"AU6L": 1.3}})", R"({"command": "go_to", "au": {"AU6L": "much"}})",
        R"({"command": "go_to", "expression": "happy", "seconds": 0})",
        R"({"command": "go_to", "expression": "happy", "seconds": 61})",
        R"({"command": "go_to", "expression": "happy", "seconds": "soon"})",
        R"({"command": "go_to", "expression": "happy", "return_seconds": "auto"})",
        R"({"command": "go_to", "expression": "happy", "hold_seconds": -1})",
        R"({"command": "go_to", "expression": "happy", "speed": 1})",
        R"({"command": "go_to", "expression": "happy", "stream": 1})"})
    EXPECT_THROW(parsed(json), UserError) << json;
}

TEST(LiveTargetRequest, SaysWhichNumberIsOutOfRange) {
  nlohmann::json request{{"command", "go_to"}, {"expression", "happy"}, {"seconds", std::nan("")}};
  try {
    live_target_of(request, kAus);
    FAIL() << "accepted";
  } catch (const UserError& error) {
    EXPECT_NE(std::string(error.what()).find("seconds: nan is out of range"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace risorius
