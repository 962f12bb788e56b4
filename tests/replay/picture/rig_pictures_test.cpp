#include "replay/picture/rig_pictures.h"

#include <cstdlib>
#include <gtest/gtest.h>
#include <set>
#include <stdexcept>

#include "replay/picture/marker_surface.h"
#include "solve/faces/builtin_face.h"

namespace {

using namespace risorius;

const FaceModel& face() {
  static const FaceModel built = builtin_face();
  return built;
}

const Rig& rig() {
  static const Rig built = builtin_rig_of(face());
  return built;
}

/// By how much two pictures of one size differ, in all pixels and colours, right half of each view apart from the left.
struct Difference {
  int left = 0, right = 0;
};

Difference difference_of(const Canvas& a, const Canvas& b) {
  Difference difference;
  const int view_width = a.width() / 3;  // the front view is the left third of the picture
  for (int y = 40; y < a.height(); ++y) {
    for (int x = 0; x < view_width; ++x) {
      for (int shift = 0; shift < 24; shift += 8) {
        const auto colour = [&](const Canvas& c) { return static_cast<int>(c.pixel(x, y) >> shift & 0xff); };
        (x < view_width / 2 ? difference.left : difference.right) += std::abs(colour(a) - colour(b));
      }
    }
  }
  return difference;
}

TEST(RigPictures, ShowsAnAuWhereItIs) {
  const RigPictures pictures(rig(), &face());
  const Canvas neutral = pictures.picture({}, 300);
  const Difference left = difference_of(neutral, pictures.picture({"AU12L"}, 300));
  EXPECT_GT(left.right, 10'000);  // the subject's left is the picture's right
  EXPECT_LT(left.left, left.right / 4);
  const Difference right = difference_of(neutral, pictures.picture({"AU12R"}, 300));
  EXPECT_GT(right.left, 10'000);
  EXPECT_LT(right.right, right.left / 4);
}

TEST(RigPictures, TheThreeQuarterViewIsFromTheSideThatMoves) {
  const RigPictures pictures(rig(), &face());
  // Paper on both sides of the head in the middle third: a face that looks to the picture's left leaves more there.
  const auto paper_left_of_face = [&](const char* column) {
    const Canvas picture = pictures.picture({column}, 300);
    const int begin = picture.width() / 3, end = 2 * begin, y = picture.height() / 2;
    int left = 0, right = 0;
    while (left < end - begin && picture.pixel(begin + left, y) == picture.pixel(2, 50)) ++left;
    while (right < end - begin && picture.pixel(end - 1 - right, y) == picture.pixel(2, 50)) ++right;
    return left - right;
  };
  EXPECT_GT(paper_left_of_face("AU12L"), 10);
  EXPECT_LT(paper_left_of_face("AU12R"), -10);
}

TEST(RigPictures, DrawsRigsWithoutAFace) {
  const RigPictures pictures(rig(), nullptr);
  const Difference difference = difference_of(pictures.picture({}, 200), pictures.picture({"AU27"}, 200));
  EXPECT_GT(difference.left + difference.right, 200);
}

TEST(RigPictures, TheSheetHasACellForTheNeutralAndEachAuWithItsSidesTogether) {
  std::set<std::string> aus{"neutral"};
  for (const RigAu& au : rig().aus) {
    const bool is_half = (au.name.ends_with('L') || au.name.ends_with('R')) && !au.name.starts_with("AU30");
    aus.insert(is_half ? au.name.substr(0, au.name.size() - 1) : au.name);
  }
  EXPECT_EQ(RigPictures(rig(), &face()).contact_sheet_cells(), aus.size());
}

TEST(RigPictures, RefusesColumnsAndSizesThatAreNot) {
  const RigPictures pictures(rig(), &face());
  EXPECT_THROW(pictures.picture({"AU99"}, 300), std::invalid_argument);
  EXPECT_THROW(pictures.picture({}, 10), std::invalid_argument);
}

TEST(FacsName, NamesAusAndTheirSides) {
  EXPECT_EQ(facs_name("AU12L"), "lip corner puller, left");
  EXPECT_EQ(facs_name("AU9"), "nose wrinkler");
  EXPECT_EQ(facs_name("mouthLeft"), "");
}

TEST(MarkerSurface, CoversTheMarkersWithoutOverlap) {
  const Eigen::Matrix3Xi triangles = triangulated_markers(rig().neutral_mm, 1e6);
  // Euler: a triangulation of n points with h on the hull has 2n - 2 - h triangles, 3 <= h <= n.
  EXPECT_LE(triangles.cols(), 2 * 55 - 2 - 3);
  EXPECT_GE(triangles.cols(), 2 * 55 - 2 - 25);
  for (Eigen::Index t = 0; t < triangles.cols(); ++t) {
    const auto at = [&](int corner) { return Eigen::Vector2d(rig().neutral_mm.col(triangles(corner, t)).head<2>()); };
    const Eigen::Vector2d ab = at(1) - at(0), ac = at(2) - at(0);
    EXPECT_GT(ab.x() * ac.y() - ab.y() * ac.x(), 0) << t;
  }
  EXPECT_EQ(triangulated_markers(rig().neutral_mm.leftCols(2)).cols(), 0);
  EXPECT_LT(triangulated_markers(rig().neutral_mm, 25).cols(), triangles.cols());
}

}  // namespace
