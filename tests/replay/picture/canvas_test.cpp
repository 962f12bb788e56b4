#include "replay/picture/canvas.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <string>
#include <vector>

#include "capture/errors.h"

namespace risorius {
namespace {

constexpr std::uint32_t kWhite = 0xffffffffu, kRed = 0xffff0000u;
constexpr Colour kRedInk{1.0, 0.0, 0.0};

TEST(Canvas, PutsTheOriginAtTheTopLeft) {
  Canvas canvas(20, 10);
  canvas.fill_rectangle({0, 0, 4, 2}, kRedInk);
  EXPECT_EQ(canvas.pixel(0, 0), kRed);
  EXPECT_EQ(canvas.pixel(3, 1), kRed);
  EXPECT_EQ(canvas.pixel(4, 1), kWhite);
  EXPECT_EQ(canvas.pixel(3, 2), kWhite);
}

TEST(Canvas, BreaksAPolylineAtPointsThatAreNotFinite) {
  Canvas canvas(30, 9);
  const std::vector<PicturePoint> track = {{1, 4.5}, {9, 4.5}, {NAN, 4.5}, {20, 4.5}, {29, 4.5}};
  canvas.polyline(track, kRedInk, 3.0);
  EXPECT_EQ(canvas.pixel(5, 4), kRed);
  EXPECT_EQ(canvas.pixel(15, 4), kWhite);
  EXPECT_EQ(canvas.pixel(25, 4), kRed);
}

TEST(Canvas, DrawsAnArrowThatEndsAtItsTip) {
  Canvas canvas(60, 21);
  canvas.arrow({5, 10.5}, {50, 10.5}, kRedInk, 2.0);
  EXPECT_EQ(canvas.pixel(20, 10), kRed);
  EXPECT_NE(canvas.pixel(45, 12), kWhite) << "the head is wider than the shaft";
  EXPECT_EQ(canvas.pixel(20, 13), kWhite);
  EXPECT_EQ(canvas.pixel(53, 10), kWhite);
}

TEST(Canvas, ClipsUntilToldOtherwise) {
  Canvas canvas(20, 20);
  canvas.begin_clip({0, 0, 10, 20});
  canvas.fill_rectangle({0, 0, 20, 10}, kRedInk);
  canvas.end_clip();
  EXPECT_EQ(canvas.pixel(15, 5), kWhite);
  canvas.fill_rectangle({0, 10, 20, 10}, kRedInk);
  EXPECT_EQ(canvas.pixel(15, 15), kRed);
}

TEST(Canvas, CopiesImagesRowByRow) {
  Canvas canvas(5, 5);
  const std::vector<std::uint32_t> pixels = {kRed, 0xff00ff00u, 0xff0000ffu, kRed, kRed, kRed};
  canvas.image({1, 2}, pixels, 3);
  EXPECT_EQ(canvas.pixel(2, 2), 0xff00ff00u);
  EXPECT_EQ(canvas.pixel(3, 2), 0xff0000ffu);
  EXPECT_EQ(canvas.pixel(1, 3), kRed);
  EXPECT_EQ(canvas.pixel(4, 2), kWhite);
}

TEST(Canvas, TextIsAsWideAsItSays) {
  Canvas canvas(200, 30);
  const double width = canvas.text_width("AU12", 14.0);
  EXPECT_GT(width, 14.0);
  canvas.text({200.0, 20.0}, "AU12", 14.0, kRedInk, TextAnchor::kRight);
  bool is_inked = false;
  for (int x = 0; x < 200; ++x) {
    for (int y = 0; y < 30; ++y) {
      if (canvas.pixel(x, y) == kWhite) continue;
      is_inked = true;
      EXPECT_GE(x, 199.0 - width);
    }
  }
  EXPECT_TRUE(is_inked);
}

TEST(Canvas, SavesAPngOrSaysWhichFileItCouldNotWrite) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "risorius_canvas";
  std::filesystem::create_directories(folder);
  Canvas canvas(8, 8);
  canvas.save_png(folder / "a.png");
  std::ifstream file(folder / "a.png", std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  ASSERT_GT(bytes.size(), 32u);
  EXPECT_EQ(bytes.substr(0, 8), "\x89PNG\r\n\x1a\n");
  EXPECT_EQ(bytes.substr(bytes.size() - 8, 4), "IEND");
  try {
    canvas.save_png(folder / "missing" / "a.png");
    FAIL();
  } catch (const UserError& error) {
    EXPECT_NE(std::string(error.what()).find("missing"), std::string::npos);
  }
  std::filesystem::remove_all(folder);
}

TEST(Canvas, RefusesSizesThatNoPictureHas) {
  EXPECT_THROW(Canvas(0, 10), UserError);
  EXPECT_THROW(Canvas(10, 20000), UserError);
}

}  // namespace
}  // namespace risorius
