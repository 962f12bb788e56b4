#include "solve/faces/landmark_map.h"

#include <fstream>
#include <gtest/gtest.h>
#include <stdexcept>

#include "capture/errors.h"
#include "solve/faces/builtin_face.h"
#include "solve/faces/shipped_maps.h"
#include "support/test_data.h"

namespace {

using namespace risorius;

const std::string kGood =
    R"({"format":"risorius-landmarks","version":1,"name":"lab","landmarks":{"chin":"C"},"stabilisers":{"F":2}})";

std::string error_of(std::string_view json) {
  try {
    parse_landmark_map(json, "here.json");
  } catch (const UserError& error) {
    return error.what();
  }
  return "";
}

TEST(LandmarkMap, ReadsNamesLandmarksAndWeights) {
  const LandmarkMap map = parse_landmark_map(kGood, "here.json");
  EXPECT_EQ(map.name, "lab");
  EXPECT_EQ(map.marker_of_landmark.at("chin"), "C");
  EXPECT_EQ(map.stabiliser_weight.at("F"), 2);
}

// Found when the fuzz target was written: printing such a value ended the program for want of stack.
TEST(LandmarkMap, RefusesAFileThatNestsWithoutEnd) {
  const std::string deep = std::string(200'000, '[') + std::string(200'000, ']');
  EXPECT_NE(error_of(R"({"format":"risorius-landmarks","version":)" + deep + "}").find("nests too deep"),
            std::string::npos);
}

TEST(LandmarkMap, NamesPlaceAndFieldOfEachMistake) {
  const auto expect = [](const std::string& json, const std::string& part) {
    EXPECT_NE(error_of(json).find(part), std::string::npos) << error_of(json);
    EXPECT_TRUE(error_of(json).starts_with("here.json: ")) << error_of(json);
  };
  expect("", "not a JSON object");
  expect("[1]", "not a JSON object");
  expect("{}", "\"format\"");
  expect(R"({"format":"risorius-landmarks","version":2})", "version 2");
  expect(R"({"format":"risorius-landmarks","version":1})", "no \"name\"");
  expect(R"({"format":"risorius-landmarks","version":1,"name":3})", "\"name\" is not a string");
  expect(R"({"format":"risorius-landmarks","version":1,"name":"x"})", "no \"landmarks\"");
  expect(R"({"format":"risorius-landmarks","version":1,"name":"x","landmarks":[]})", "not an object");
  expect(R"({"format":"risorius-landmarks","version":1,"name":"x","landmarks":{"chin":4}})", "landmarks.chin");
  expect(R"({"format":"risorius-landmarks","version":1,"name":"x","landmarks":{"chin":"A","lip_lower":"A"}})", "both");
  expect(R"({"format":"risorius-landmarks","version":1,"name":"x","landmarks":{},"stabilisers":{"F":-1}})",
         "stabilisers.F = -1");
  expect(R"({"format":"risorius-landmarks","version":1,"name":"x","landmarks":{},"stabilizers":{"F":1}})",
         "unknown key \"stabilizers\"");
}

TEST(LandmarkMap, EveryTruncationIsAnError) {
  for (std::size_t length = 0; length < kGood.size(); ++length)
    EXPECT_NE(error_of(kGood.substr(0, length)), "") << length;
}

TEST(LandmarkMap, ShippedMapsNameOnlyLandmarksThatTheBuiltinFaceHas) {
  const FaceModel face = builtin_face();
  ASSERT_EQ(shipped_landmark_maps().size(), 4u);
  for (const ShippedMap& shipped : shipped_landmark_maps()) {
    const LandmarkMap map = find_landmark_map(std::string(shipped.name));
    EXPECT_EQ(map.name, shipped.name);
    EXPECT_GE(map.marker_of_landmark.size(), 4u);
    EXPECT_GE(map.stabiliser_weight.size(), 3u);
    for (const auto& [landmark, marker] : map.marker_of_landmark)
      EXPECT_NE(face.find_landmark(landmark), nullptr) << landmark;
    // The map speaks of the built-in layout of its name, and puts its markers where the landmarks are.
    const auto* layout = face.find_layout(map.name);
    ASSERT_NE(layout, nullptr) << map.name;
    const auto position_of = [&](const std::string& marker) {
      for (const NamedPlace& place : *layout) {
        if (place.name == marker) return face.position_mm(place.place);
      }
      throw std::runtime_error(marker);
    };
    for (const auto& [landmark, marker] : map.marker_of_landmark) {
      EXPECT_LT((position_of(marker) - face.position_mm(*face.find_landmark(landmark))).norm(), 5) << marker;
    }
    for (const auto& [marker, weight] : map.stabiliser_weight) EXPECT_NO_THROW(position_of(marker));
  }
}

TEST(LandmarkMap, FindsFilesAndNamesTheShippedOnesOtherwise) {
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "mine.json").string();
  std::ofstream(path) << kGood;
  EXPECT_EQ(find_landmark_map(path).name, "lab");
  EXPECT_THROW(find_landmark_map(folder.path().string()), UserError);
  try {
    find_landmark_map("nowhere");
    FAIL();
  } catch (const UserError& error) {
    EXPECT_NE(std::string(error.what()).find("iemocap55"), std::string::npos);
  }
}

}  // namespace
