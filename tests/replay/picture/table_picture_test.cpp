#include "replay/picture/table_picture.h"

#include <gtest/gtest.h>
#include <stdexcept>

#include "capture/errors.h"

namespace {

using namespace risorius;

constexpr Colour kRed{1, 0, 0};
constexpr std::uint32_t kRedPixel = 0xffff0000u;

PictureTable table_of(std::size_t rows) {
  PictureTable table{.title = "t", .columns = {{"name", 80, TextAnchor::kLeft}, {"value", 50, TextAnchor::kRight}}};
  for (std::size_t row = 0; row < rows; ++row) table.rows.push_back({{"a"}, {"1.0"}});
  return table;
}

int count_of(const Canvas& canvas, std::uint32_t colour) {
  int count = 0;
  for (int y = 0; y < canvas.height(); ++y)
    for (int x = 0; x < canvas.width(); ++x) count += canvas.pixel(x, y) == colour;
  return count;
}

int dark_pixels(const Canvas& canvas) {
  int count = 0;
  for (int y = 0; y < canvas.height(); ++y)
    for (int x = 0; x < canvas.width(); ++x) count += (canvas.pixel(x, y) & 0xffu) < 0x60u;
  return count;
}

TEST(TablePicture, GrowsWithItsRowsAndTables) {
  const Canvas one = table_picture("", {table_of(2)}, {}), longer = table_picture("", {table_of(12)}, {}),
               two = table_picture("", {table_of(2), table_of(2)}, {});
  EXPECT_EQ(longer.height() - one.height(), 180) << "ten rows of 18 pixels";
  EXPECT_EQ(longer.width(), one.width());
  EXPECT_EQ(two.height(), one.height());
  EXPECT_GE(two.width() - one.width(), 130) << "a table of 80 and 50 pixels more";
}

TEST(TablePicture, ColoursACellAndNoOther) {
  PictureTable table = table_of(3);
  table.rows[1][1] = {"", kRed};
  const int red = count_of(table_picture("", {table}, {}), kRedPixel);
  EXPECT_LE(red, 50 * 18);
  EXPECT_GE(red, 50 * 16) << "but for the lines above and below";
}

TEST(TablePicture, BoldTextIsDarker) {
  PictureTable plain = table_of(1), bold = table_of(1);
  bold.rows[0][0].is_bold = true;
  EXPECT_GT(dark_pixels(table_picture("", {bold}, {})), dark_pixels(table_picture("", {plain}, {})));
}

TEST(TablePicture, TurnedHeadsMakeRoomForThemselves) {
  PictureTable table = table_of(1);
  table.columns[1].head = "a head that is much longer than its column";
  const Canvas upright = table_picture("", {table}, {});
  table.has_turned_heads = true;
  EXPECT_GT(table_picture("", {table}, {}).height(), upright.height() + 100);
}

TEST(TablePicture, NotesAndHeadlineWidenIt) {
  const std::string note(200, 'n');
  EXPECT_GT(table_picture("", {table_of(1)}, {note}).width(), 800);
  EXPECT_GT(table_picture(note, {}, {}).width(), 800) << "without a table, too";
}

TEST(TablePicture, RefusesRowsThatDoNotFit) {
  PictureTable table = table_of(2);
  table.rows[1].pop_back();
  EXPECT_THROW(table_picture("", {table}, {}), std::invalid_argument);
  EXPECT_THROW(table_picture("", {table_of(2000)}, {}), UserError) << "36,000 pixels high";
}

TEST(Warmth, GoesFromWhiteOverAmberToVermilion) {
  EXPECT_EQ(warmth(-1).blue, 1);
  EXPECT_EQ(warmth(0).green, 1);
  EXPECT_GT(warmth(0.5).blue, warmth(1).blue);
  EXPECT_GT(warmth(1).green, warmth(1.5).green);
  EXPECT_EQ(warmth(2).green, warmth(7).green);
}

}  // namespace
