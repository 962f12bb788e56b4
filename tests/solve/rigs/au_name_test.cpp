#include "solve/rigs/au_name.h"

#include <gtest/gtest.h>

namespace risorius {
namespace {

TEST(AuName, ParsesWhatItFormats) {
  for (int number = 1; number <= 99; ++number) {
    for (const AuSide side : {AuSide::kBoth, AuSide::kLeft, AuSide::kRight}) {
      const AuName name{number, side};
      EXPECT_EQ(parse_au_name(format_au_name(name)), name);
    }
  }
  EXPECT_EQ(format_au_name({12, AuSide::kLeft}), "AU12L");
}

TEST(AuName, OtherNamesHaveNoNumber) {
  for (const char* text : {"", "A", "AU", "AUL", "AU0", "AU01", "AU100", "AU12l", "au12", "AU12LR", "AU1.5", "AU-1",
                           " AU1", "AU1 ", "mouthLeft", "AU1\xc3\xa4"}) {
    EXPECT_FALSE(parse_au_name(text).has_value()) << text;
  }
}

TEST(AuSetId, IsFnv1aOfTheNamesInOrder) {
  // FNV-1a of "a\n", by hand from the published offset 0x811c9dc5 and prime 0x01000193.
  EXPECT_EQ(au_set_id({"a"}), ((((0x811c9dc5u ^ 'a') * 0x01000193u) ^ '\n') * 0x01000193u));
  EXPECT_NE(au_set_id({"AU1", "AU2"}), au_set_id({"AU2", "AU1"}));
  EXPECT_NE(au_set_id({"AU1", "AU2"}), au_set_id({"AU1AU2"}));
}

}  // namespace
}  // namespace risorius
