#include "replay/takes/arkit_aus.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <set>

#include "capture/errors.h"
#include "replay/takes/live_link_csv.h"
#include "support/test_data.h"

namespace {

using namespace risorius;

/// The value of a channel in the first row; NaN if there is no such channel.
double first(const AuSeries& series, const std::string& name) {
  const auto found = std::find(series.names.begin(), series.names.end(), name);
  return found == series.names.end() ? std::nan("")
                                     : series.intensities[0][static_cast<std::size_t>(found - series.names.begin())];
}

AuSeries one_row(std::vector<std::string> names, std::vector<double> values) {
  return {std::move(names), {0}, {std::move(values)}};
}

TEST(ArkitAus, SidesAreTheSubjectsAndGoByName) {
  // The order of Live Link Face's header, in which right comes before left for the mouth and the jaw.
  const AuSeries shapes =
      one_row({"jawRight", "jawLeft", "mouthRight", "mouthLeft", "mouthSmileRight", "mouthSmileLeft", "eyeBlinkLeft"},
              {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7});
  const AuSeries aus = aus_of_shapes(shapes, shipped_arkit_table());
  EXPECT_EQ(first(aus, "AU30R"), 0.1);
  EXPECT_EQ(first(aus, "AU30L"), 0.2);
  EXPECT_EQ(first(aus, "mouthRight"), 0.3);
  EXPECT_EQ(first(aus, "mouthLeft"), 0.4);
  EXPECT_EQ(first(aus, "AU12R"), 0.5);
  EXPECT_EQ(first(aus, "AU12L"), 0.6);
  EXPECT_EQ(first(aus, "AU45L"), 0.7);
  EXPECT_TRUE(std::isnan(first(aus, "AU45R"))) << "a shape that is not there is no AU, and not 0";
  const AuSeries back = shapes_of_aus(aus, shipped_arkit_table());
  EXPECT_EQ(first(back, "mouthSmileRight"), 0.5);
  EXPECT_EQ(first(back, "mouthSmileLeft"), 0.6);
  EXPECT_EQ(first(back, "jawRight"), 0.1);
  EXPECT_EQ(first(back, "jawLeft"), 0.2);
}

TEST(ArkitAus, OneColumnIsTheWholeJawAndTwoShareIt) {
  for (const double open : {0.0, 0.3, 0.6, 0.8, 1.0}) {
    const AuSeries shapes = one_row({"jawOpen"}, {open});
    const AuSeries whole = aus_of_shapes(shapes, shipped_arkit_table());
    EXPECT_EQ(first(whole, "AU27"), open);
    EXPECT_TRUE(std::isnan(first(whole, "AU26")));
    const AuSeries split = aus_of_shapes(shapes, shipped_arkit_table(), JawColumns::kSplit);
    EXPECT_NEAR(first(split, "AU26"), std::min(1.0, open / 0.6), 1e-12);
    EXPECT_NEAR(first(split, "AU27"), std::max(0.0, (open - 0.6) / 0.4), 1e-12);
    for (const AuSeries& aus : {whole, split})
      EXPECT_NEAR(first(shapes_of_aus(aus, shipped_arkit_table()), "jawOpen"), open, 1e-12);
  }
}

TEST(ArkitAus, ReadingUndoesWritingForEveryAuThatCanBeRead) {
  for (const ArkitAu& au : shipped_arkit_table().aus) {
    if (au.read.empty() || au.write.empty() || !au.for_whole_jaw) continue;
    const AuSeries shapes = shapes_of_aus(one_row({au.au}, {0.4}), shipped_arkit_table());
    EXPECT_NEAR(first(aus_of_shapes(shapes, shipped_arkit_table()), au.au), 0.4, 1e-12) << au.au;
    for (double value : shapes.intensities[0]) EXPECT_LE(value, 1);
    EXPECT_TRUE(std::isnan(first(shapes, "mouthClose"))) << "alone it moves the lips by centimetres";
  }
}

TEST(ArkitAus, WhatCannotBeReadIsMissing) {
  const AuSeries shapes = one_row(
      {"mouthPressLeft", "mouthPressRight", "mouthRollLower", "mouthRollUpper", "mouthSmileLeft", "browInnerUp"},
      {1, 1, 1, 1, 1, 0.5});
  const AuSeries aus = aus_of_shapes(shapes, shipped_arkit_table());
  for (const char* name : {"AU23", "AU13L", "AU25"}) EXPECT_TRUE(std::isnan(first(aus, name))) << name;
  EXPECT_EQ(columns_for(aus.names, "AU1L"), columns_for(aus.names, "AU1"));  // one shape serves both sides
  EXPECT_EQ(columns_for({"AU9L", "AU9R"}, "AU9"), (std::vector<std::size_t>{0, 1}));
  EXPECT_TRUE(columns_for({"AU9L"}, "AU9").empty());
  EXPECT_TRUE(columns_for({"AU30L", "AU30R"}, "AU30").empty());
  EXPECT_TRUE(columns_for({"AU9"}, "AU99").empty());
}

TEST(ArkitAus, LipsPartIsAConsequenceAndNoAction) {
  const AuSeries shapes = one_row(
      {"jawOpen", "mouthClose", "mouthLowerDownLeft", "mouthLowerDownRight", "mouthUpperUpLeft", "mouthUpperUpRight"},
      {0.5, 0.4, 0.2, 0, 0, 0});
  EXPECT_NEAR(first(aus_of_shapes(shapes, shipped_arkit_table()), "AU25"), 0.2, 1e-12);
  EXPECT_TRUE(std::isnan(first(aus_of_shapes(shapes, shipped_arkit_table(), JawColumns::kWhole, true), "AU25")));
}

TEST(ArkitAus, RefusesBrokenTablesByTheirRow) {
  const auto complaint = [](const std::string& json) -> std::string {
    try {
      parse_arkit_table(json, "my.json");
    } catch (const UserError& error) {
      return error.what();
    }
    return "";
  };
  const std::string head = R"({"format":"risorius-arkit-aus","version":1,"facs_edition":"2002","aus":[)";
  EXPECT_EQ(complaint(head + R"({"au":"AU2","class":"A","read":[{"a":1}],"write":{}}]})"), "");
  EXPECT_NE(complaint("[]").find("my.json"), std::string::npos);
  EXPECT_NE(complaint(R"({"format":"risorius-arkit-aus","version":2})").find("version 2"), std::string::npos);
  EXPECT_NE(complaint(head + R"({"au":"AU2","class":"D","read":[]}]})").find("aus.AU2"), std::string::npos);
  EXPECT_NE(complaint(head + R"({"au":"AU2","class":"A","read":[{"a":"x"}]}]})").find("a = \"x\""), std::string::npos);
  EXPECT_NE(complaint(head + R"({"au":"AU2","class":"A","read":[],"range":[1,0]}]})").find("range"), std::string::npos);
}

TEST(ArkitAus, TheTableKnowsEveryShapeOfARealRecordingButGazeAndMouthClose) {
  RISORIUS_NEEDS_DATA(path, "arkit/alex_rom_3.csv");
  std::set<std::string> used;
  for (const ArkitAu& au : shipped_arkit_table().aus) {
    for (const auto& alternative : au.read)
      for (const auto& [shape, weight] : alternative) used.insert(shape);
    for (const auto& [shape, weight] : au.write) used.insert(shape);
  }
  const LiveLinkTake take = load_live_link_csv(path);
  EXPECT_EQ(take.shapes.names.size(), 52u);
  std::set<std::string> unknown;
  for (const std::string& name : take.shapes.names) {
    if (!used.erase(name) && !name.starts_with("eyeLook")) unknown.insert(name);
  }
  EXPECT_EQ(unknown, std::set<std::string>{});
  EXPECT_EQ(used, std::set<std::string>{}) << "a shape that ARKit does not have";
}

}  // namespace
