#include "capture/utf8.h"

#include <gtest/gtest.h>

#include "capture/marker_set.h"

namespace risorius {
namespace {

TEST(Utf8, TellsCleanTextFromTheRest) {
  for (const char* clean : {"", "brow_M", "Wange_\xC3\xA4", "\xE2\x82\xAC", "\xF0\x9F\x98\x80"}) {
    EXPECT_TRUE(is_clean_utf8(clean)) << clean;
  }
  for (const char* dirty :
       {"a\nb", "\x7F", "\xE4", "W\xE4nge", "\xC0\x80", "\xED\xA0\x80", "\xF5\x80\x80\x80", "\xE2\x82"}) {
    EXPECT_FALSE(is_clean_utf8(dirty)) << dirty;
  }
}

TEST(Utf8, ReadsOtherBytesAsLatin1) {
  EXPECT_EQ(utf8_of("Rcheek_Outs\xE4"
                    "de"),
            "Rcheek_Outs\xC3\xA4"
            "de");
  EXPECT_EQ(utf8_of("\xC3\xA4\xE4"), "\xC3\xA4\xC3\xA4");  // what is UTF-8 already stays
  EXPECT_EQ(utf8_of("a\tb\x80"), "a?b?");
  EXPECT_TRUE(is_clean_utf8(utf8_of("\xFF\xFE\x01\xC3")));
}

TEST(Utf8, AMarkerSetRefusesNamesThatAreNone) {
  MarkerSet set{.names = {"a", "b\xE4"}, .rate_hz = 60};
  ASSERT_EQ(problems_of(set).size(), 1u);
  EXPECT_NE(problems_of(set)[0].find("is not UTF-8"), std::string::npos);
}

}  // namespace
}  // namespace risorius
