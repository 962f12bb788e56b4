#include "replay/takes/c3d_parameters.h"

#include <gtest/gtest.h>

#include "replay/takes/c3d_preamble.h"

namespace risorius {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// A section with group POINT (id 1) and one parameter of it.
Bytes section_with(const std::string& name, int type, const std::string& dimensions, const std::string& data) {
  std::string bytes("\x01\x50\x01\x54", 4);
  bytes += std::string("\x05\xFF", 2) + "POINT" + std::string("\x03\x00\x00", 3);
  bytes += static_cast<char>(name.size());
  bytes += '\x01';
  bytes += name;
  append_c3d_word(bytes, static_cast<std::uint16_t>(2 + 2 + dimensions.size() + data.size() + 1));
  bytes += static_cast<char>(type);
  bytes += static_cast<char>(dimensions.size());
  bytes += dimensions + data + std::string(3, '\0');
  return {bytes.begin(), bytes.end()};
}

C3dParameters parse(const Bytes& section, std::vector<std::string>& warnings) {
  return C3dParameters(section, C3dProcessor::kIntel, warnings);
}

TEST(C3dParameters, CountsAreUnsignedWords) {
  std::vector<std::string> warnings;
  const auto parameters = parse(section_with("FRAMES", 2, "", "\xFF\xFF"), warnings);
  EXPECT_EQ(parameters.count("POINT", "FRAMES"), 65535u);
  EXPECT_EQ(parameters.count("point", "frames"), 65535u);
  EXPECT_FALSE(parameters.count("POINT", "ABSENT"));
  EXPECT_TRUE(warnings.empty());
}

TEST(C3dParameters, CountsMayBeFloats) {
  std::vector<std::string> warnings;
  std::string data;
  append_c3d_float(data, 100'000.0f);
  EXPECT_EQ(parse(section_with("FRAMES", 4, "", data), warnings).count("POINT", "FRAMES"), 100'000u);
  for (const float no_count : {-1.0f, 2.5f, 1e20f, std::numeric_limits<float>::quiet_NaN()}) {
    data.clear();
    append_c3d_float(data, no_count);
    EXPECT_FALSE(parse(section_with("FRAMES", 4, "", data), warnings).count("POINT", "FRAMES")) << no_count;
  }
}

TEST(C3dParameters, CountsMayBeTwoWordsWithTheLowOneFirst) {
  std::vector<std::string> warnings;
  const auto parameters = parse(section_with("LONG", 2, "\x02", std::string("\x01\x00\x02\x00", 4)), warnings);
  EXPECT_EQ(parameters.count("POINT", "LONG"), 0x20001u);
}

TEST(C3dParameters, GivesTextsWithoutBlanks) {
  std::vector<std::string> warnings;
  const auto parameters = parse(section_with("LABELS", -1, "\x03\x03", "A  BCD" + std::string(3, '\0')), warnings);
  EXPECT_EQ(parameters.texts("POINT", "LABELS"), (std::vector<std::string>{"A", "BCD", ""}));
}

TEST(C3dParameters, ReadsNoMoreThanTheRecordHas) {
  std::vector<std::string> warnings;
  // Seven dimensions of 255 declare 7e16 bytes.
  const auto parameters = parse(section_with("LABELS", -1, std::string(7, '\xFF'), "AB"), warnings);
  EXPECT_EQ(parameters.texts("POINT", "LABELS"), std::vector<std::string>{"AB"});
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("LABELS"), std::string::npos);
}

TEST(C3dParameters, StopsWithAWarningWhereTheBytesAreNoParameter) {
  for (const int type : {0, 3, 7, -2}) {
    std::vector<std::string> warnings;
    const auto parameters = parse(section_with("USED", type, "", "\x01\x02"), warnings);
    EXPECT_FALSE(parameters.has("POINT", "USED")) << type;
    EXPECT_EQ(warnings.size(), 1u) << type;
  }
}

TEST(C3dParameters, SurvivesEveryTruncation) {
  const Bytes whole = section_with("LABELS", -1, "\x02\x02", "ABCD");
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    std::vector<std::string> warnings;
    const Bytes part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_LE(parse(part, warnings).texts("POINT", "LABELS").size(), 2u);
  }
}

}  // namespace
}  // namespace risorius
