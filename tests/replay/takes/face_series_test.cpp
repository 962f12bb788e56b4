#include "replay/takes/face_series.h"

#include <algorithm>
#include <fstream>
#include <gtest/gtest.h>

#include "capture/errors.h"
#include "support/test_data.h"

namespace risorius {
namespace {

class FaceSeriesFile : public ::testing::Test {
 protected:
  FaceSeries load(const char* text, const FaceSeriesOptions& options = {}) {
    const auto path = folder_.path() / "face.csv";
    std::ofstream(path) << text;
    return load_face_series(path, options);
  }
  static double value(const FaceSeries& face, const std::string& au, std::size_t row = 0) {
    const auto found = std::ranges::find(face.aus.names, au);
    EXPECT_NE(found, face.aus.names.end()) << au;
    return face.aus.intensities.at(row).at(static_cast<std::size_t>(found - face.aus.names.begin()));
  }
  test::TemporaryFolder folder_;
};

TEST_F(FaceSeriesFile, AusStayAsTheyAre) {
  const FaceSeries face = load("Frame,AU12L,pucker\n0,0.5,0.25\n", {.rate_hz = 60});
  EXPECT_EQ(face.aus.names, (std::vector<std::string>{"AU12L", "pucker"}));
  EXPECT_EQ(face.rate_hz, 60);
  EXPECT_TRUE(face.warnings.empty());
  EXPECT_FALSE(load("Frame,AU12L\n0,0.5\n").rate_hz) << "nothing in the file says one";
}

TEST_F(FaceSeriesFile, ColumnsOfShapesBecomeAusInEitherSpelling) {
  for (const char* text : {"Frame,mouthSmileLeft,mouthSmileRight,jawOpen\n0,0.8,0.2,0\n4,0,0,0.5\n",
                           "Frame,MouthSmileLeft,MouthSmileRight,JawOpen\n0,0.8,0.2,0\n4,0,0,0.5\n"}) {
    const FaceSeries face = load(text);
    EXPECT_GT(value(face, "AU12L"), 2 * value(face, "AU12R"));
    EXPECT_GT(value(face, "AU27", 1), 0);
    EXPECT_EQ(face.aus.frames, (std::vector<std::uint64_t>{0, 4}));
    ASSERT_EQ(face.warnings.size(), 1u);
    EXPECT_NE(face.warnings[0].find("face shapes"), std::string::npos);
  }
}

TEST_F(FaceSeriesFile, AnotherTableCounts) {
  ArkitTable table = shipped_arkit_table();
  for (ArkitAu& au : table.aus)
    if (au.au == "AU12L") au.read = {{{"jawOpen", 1.0}}};
  EXPECT_NEAR(value(load("Frame,jawOpen\n0,0.5\n", {.table = &table}), "AU12L"), 0.5, 0.2);
}

TEST_F(FaceSeriesFile, ShapesWithoutAnAuAndShapesThatStandTwiceAreRefused) {
  const std::pair<const char*, const char*> wrong[] = {
      {"Frame,mouthClose\n0,0.5\n", "line 1: no AU can be read from mouthClose"},
      {"Frame,jawOpen,JawOpen\n0,0.5,0.5\n", "line 1: shape 'jawOpen' stands twice"}};
  for (const auto& [text, problem] : wrong) {
    try {
      load(text);
      ADD_FAILURE() << text;
    } catch (const UserError& error) {
      EXPECT_NE(std::string(error.what()).find(problem), std::string::npos) << error.what();
    }
  }
}

TEST_F(FaceSeriesFile, AShapeBesideAusStaysWhatItIs) {
  const FaceSeries face = load("Frame,AU12L,mouthLeft\n0,0.5,0.25\n");
  EXPECT_EQ(face.aus.names, (std::vector<std::string>{"AU12L", "mouthLeft"}));
  EXPECT_EQ(value(face, "mouthLeft"), 0.25);
  EXPECT_TRUE(face.warnings.empty());
}

}  // namespace
}  // namespace risorius
