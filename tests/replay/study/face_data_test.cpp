#include "replay/study/face_data.h"

#include <gtest/gtest.h>
#include <string_view>

#include "solve/faces/builtin_face.h"

namespace risorius {
namespace {

std::string encoded(std::string_view text) { return base64_of(std::as_bytes(std::span(text))); }

TEST(FaceData, EncodesAsRfc4648Shows) {
  EXPECT_EQ(encoded(""), "");
  EXPECT_EQ(encoded("f"), "Zg==");
  EXPECT_EQ(encoded("fo"), "Zm8=");
  EXPECT_EQ(encoded("foo"), "Zm9v");
  EXPECT_EQ(encoded("foobar"), "Zm9vYmFy");
}

TEST(FaceData, HoldsTheFrontOfTheFaceAndTheWantedAusOnly) {
  const FaceModel face = builtin_face();
  const auto data = face_data(face, {"AU12L", "AU27", "AU99"});
  ASSERT_EQ(data.at("aus").size(), 2u);
  EXPECT_EQ(data.at("aus")[1].at("name"), "AU27");
  // 8 letters of base64 hold three numbers of 16 bits.
  const std::size_t vertices = data.at("vertices").get<std::string>().size() / 8;
  EXPECT_LT(vertices, static_cast<std::size_t>(face.vertices_mm().cols()));
  EXPECT_GT(vertices, static_cast<std::size_t>(face.vertices_mm().cols()) / 3);
  EXPECT_GT(data.at("skin_triangles").get<int>(), face.skin_triangle_count() / 3);
  EXPECT_LT(data.at("step_mm").get<double>(), 0.01);
  EXPECT_FALSE(data.at("aus")[0].at("crease_cells").get<std::string>().empty()) << "the nasolabial fold";
  EXPECT_FALSE(data.at("aus")[1].contains("crease_cells")) << "a jaw folds nothing";
  EXPECT_EQ(data, face_data(face, {"AU12L", "AU27", "AU99"}));
}

}  // namespace
}  // namespace risorius
