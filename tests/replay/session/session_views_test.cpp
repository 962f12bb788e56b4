#include "replay/session/session_views.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace risorius {
namespace {

using nlohmann::json;

/// What viewers make of a JSON schema: plain types, and of an object the properties that are listed.
void expect_readable(const json& schema, const std::string& place) {
  ASSERT_TRUE(schema.is_object()) << place;
  if (schema.contains("oneOf")) {
    for (const json& one : schema.at("oneOf"))
      EXPECT_TRUE(one.at("const").is_number() && one.at("title").is_string()) << place;
    return;
  }
  ASSERT_TRUE(schema.contains("type") && schema.at("type").is_string()) << place << ": " << schema.dump();
  if (schema.at("type") == "array") return expect_readable(schema.at("items"), place + "[]");
  if (schema.at("type") != "object") return;
  ASSERT_TRUE(schema.contains("properties")) << place;
  for (const auto& [name, property] : schema.at("properties").items()) expect_readable(property, place + "." + name);
}

std::vector<std::byte> packed(const json& message) {
  const auto bytes = json::to_msgpack(message);
  const auto view = std::as_bytes(std::span(bytes));
  return {view.begin(), view.end()};
}

TEST(SessionViews, HaveSchemasOfWhatViewersCanRead) {
  expect_readable(json::parse(au_view_schema({"AU1", "AU12L"})), "au");
  expect_readable(json::parse(marker_view_schema()), "markers");
}

TEST(SessionViews, OfAusListEachAuOfTheStreamAndNothingElse) {
  const json schema = json::parse(au_view_schema({"AU1", "AU12L"}));
  EXPECT_EQ(schema.at("properties").at("au").at("properties").dump(),
            R"({"AU1":{"type":"number"},"AU12L":{"type":"number"}})")
      << "as of this stream";
  EXPECT_NE(au_view_schema_name("anna"), au_view_schema_name("ben"));
}

TEST(SessionViews, OfAusLeaveOutWhatWasNotObserved) {
  const json message{
      {"stream", "face"}, {"sequence", 7}, {"residual_rms_mm", nullptr}, {"au", {{"AU1", 0.5}, {"AU2", nullptr}}}};
  const json view = json::parse(au_view_json(packed(message), 1'500'000'000));
  EXPECT_EQ(view.at("au").dump(), R"({"AU1":0.5})");
  EXPECT_FALSE(view.contains("residual_rms_mm"));
  EXPECT_EQ(view.at("timestamp").dump(), R"({"nsec":500000000,"sec":1})");
  EXPECT_EQ(view.at("sequence"), 7);
}

TEST(SessionViews, OfMarkersStandUprightWhereZIsUp) {
  const json message{{"positions_mm", {0, 1000, 0, nullptr, nullptr, nullptr}}, {"states", "MX"}};
  const json view = json::parse(marker_view_json(packed(message), 0));
  const auto turn = view.at("pose").at("orientation");
  const Eigen::Quaterniond rotation(turn.at("w").get<double>(), turn.at("x").get<double>(), turn.at("y").get<double>(),
                                    turn.at("z").get<double>());
  EXPECT_LT((rotation * Eigen::Vector3d::UnitY() - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_EQ(view.at("point_stride"), 13);
  EXPECT_EQ(view.at("data").get<std::string>().size(), 20u) << "13 bytes in base64: the missing marker is left out";
}

TEST(SessionViews, OfWhatIsNoSuchMessageAreEmpty) {
  EXPECT_EQ(au_view_json(packed({{"au", 3}}), 0), "");
  EXPECT_EQ(au_view_json(packed(json::array({1})), 0), "");
  EXPECT_EQ(marker_view_json(packed({{"au", json::object()}}), 0), "");
  const std::vector<std::byte> torn(3, std::byte{0xc1});
  EXPECT_EQ(au_view_json(torn, 0), "");
}

}  // namespace
}  // namespace risorius
