#include "capture/wire/tracker_names.h"

#include <gtest/gtest.h>

#include "capture/marker_set.h"

namespace risorius {
namespace {

TEST(TrackerNames, AreAsTheTrackerHasThemWhereThatCanBe) {
  TrackerNames names;
  names.add("chin");
  names.add("nose", "face");
  EXPECT_EQ(names.size(), 2u);
  EXPECT_EQ(names.take(), (std::vector<std::string>{"chin", "nose"}));
}

TEST(TrackerNames, ATakenNameGetsItsGroupThenANumber) {
  TrackerNames names;
  names.add("chin", "anna");
  names.begin_group();
  names.add("chin", "ben");
  names.add("chin", "ben");
  names.add("chin");
  names.add("", "ben");
  EXPECT_EQ(names.take(), (std::vector<std::string>{"chin", "ben:chin", "chin#2", "chin#3", "4"}));
}

TEST(TrackerNames, AnyBytesBecomeNamesOfASet) {
  TrackerNames names;
  const std::string e_acute = "\xc3\xa9";
  for (const std::string& bytes :
       {std::string("\xff\xfe"), std::string("a\0b", 3), std::string(300, 'x'), std::string(300, 'x'),
        std::string(62, 'y') + e_acute, std::string(62, 'y') + e_acute, std::string(), std::string("#2")})
    names.add(bytes, bytes);
  MarkerSet set{.id = 1, .names = names.take()};
  EXPECT_TRUE(problems_of(set).empty()) << problems_of(set).front();
  EXPECT_EQ(set.names[2], std::string(63, 'x'));
  EXPECT_EQ(set.names[3], std::string(61, 'x') + "#2");
  EXPECT_EQ(set.names[4], std::string(62, 'y')) << "no half character";
}

}  // namespace
}  // namespace risorius
