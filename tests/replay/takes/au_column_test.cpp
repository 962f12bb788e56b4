#include "replay/takes/au_column.h"

#include <gtest/gtest.h>

namespace risorius {
namespace {

TEST(AuColumn, HasNumberAndSide) {
  for (const auto& [name, number, side] : {std::tuple{"AU12L", 12, ColumnSide::kLeft},
                                           {"AU1R", 1, ColumnSide::kRight},
                                           {"AU6", 6, ColumnSide::kNone},
                                           {"AU04", 4, ColumnSide::kNone}}) {
    const AuColumn column = parse_au_column(name);
    EXPECT_EQ(column.name, name);
    EXPECT_EQ(column.number, number);
    EXPECT_EQ(column.side, side);
  }
}

TEST(AuColumn, KeepsOtherNamesWithoutNumberAndSide) {
  for (const char* name :
       {"mouthLeft", "AU", "AUL", "AU12X", "AU12LR", "AU-1", "AU0", "AU100", "au12", "XAU12", "AU1.5"}) {
    const AuColumn column = parse_au_column(name);
    EXPECT_EQ(column.name, name);
    EXPECT_EQ(column.number, 0) << name;
    EXPECT_EQ(column.side, ColumnSide::kNone) << name;
  }
}

}  // namespace
}  // namespace risorius
