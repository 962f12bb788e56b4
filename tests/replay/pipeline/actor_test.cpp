#include "replay/pipeline/actor.h"

#include <fstream>
#include <gtest/gtest.h>

#include "capture/errors.h"
#include "solve/faces/builtin_face.h"
#include "support/test_data.h"

namespace risorius {
namespace {

Actor actor() {
  Actor result{.pseudonym = "P07", .date = "2026-01-31", .note = "markers by template", .rig = builtin_rig()};
  const std::string marker = result.rig.marker_names[4];
  result.names.emplace("tracker_4", marker);
  result.gains.emplace("AU12L", 1.25);
  result.neutrals.push_back({.date = "2026-02-01",
                             .place = "take.c3d:0-60",
                             .position_mm = {{marker, result.rig.neutral_mm.col(4) + Eigen::Vector3d(0, 1, 0)}}});
  return result;
}

std::string message_of(const std::filesystem::path& folder) {
  try {
    load_actor(folder);
  } catch (const UserError& error) {
    return error.what();
  }
  return "";
}

TEST(Actor, ComesBackAsItWasSaved) {
  test::TemporaryFolder folder;
  const auto path = folder.path() / "anna";
  save_actor(actor(), path);
  ASSERT_TRUE(is_actor_folder(path));
  const Actor read = load_actor(path), written = actor();
  EXPECT_EQ(read.pseudonym, written.pseudonym);
  EXPECT_EQ(read.note, written.note);
  EXPECT_EQ(read.names, written.names);
  EXPECT_EQ(read.gains, written.gains);
  ASSERT_EQ(read.neutrals.size(), 1u);
  EXPECT_EQ(read.neutrals[0].position_mm, written.neutrals[0].position_mm);
  EXPECT_EQ(rig_to_json(read.rig), rig_to_json(written.rig));
}

TEST(Actor, ItsRigHasNamesGainsAndNewestNeutral) {
  const Actor a = actor();
  const Rig rig = rig_of_actor(a);
  EXPECT_EQ(rig.marker_names[4], "tracker_4");
  EXPECT_EQ(rig.neutral_mm(1, 4), a.rig.neutral_mm(1, 4) + 1);
  EXPECT_EQ(rig.neutral_mm.col(5), a.rig.neutral_mm.col(5));
  for (std::size_t i = 0; i < rig.au_count(); ++i) {
    const double gain = rig.aus[i].name == "AU12L" ? 1.25 : 1;
    EXPECT_TRUE(rig.aus[i].displacement_mm.isApprox(a.rig.aus[i].displacement_mm / gain)) << rig.aus[i].name;
  }
}

TEST(Actor, AFolderStandsWhereARigIsNamed) {
  test::TemporaryFolder folder;
  save_actor(actor(), folder.path() / "anna");
  EXPECT_EQ(load_rig_or_actor(folder.path() / "anna").marker_names[4], "tracker_4");
  EXPECT_THROW(load_rig_or_actor(folder.path() / "nobody"), UserError);
}

TEST(Actor, RefusalsNameWhatIsWrong) {
  test::TemporaryFolder folder;
  const auto path = folder.path() / "anna";
  save_actor(actor(), path);
  const auto with = [&](const std::string& json) {
    std::ofstream(path / kActorFile) << json;
    return message_of(path);
  };
  EXPECT_NE(with("{").find("not a JSON object"), std::string::npos);
  EXPECT_NE(with(R"({"format": "x", "version": 1})").find("no actor profile"), std::string::npos);
  const std::string head = R"({"format": "risorius-actor", "version": 1, )";
  EXPECT_NE(with(head + R"("names": {"a": "nowhere"}})").find("nowhere"), std::string::npos);
  EXPECT_NE(with(head + R"("gains": {"AU99": 1}})").find("AU99"), std::string::npos);
  EXPECT_NE(with(head + R"("gains": {"AU12L": 0}})").find("AU12L = 0"), std::string::npos);
  EXPECT_NE(with(head + R"("neutrals": [{"position_mm": {"CH1": [1, 2]}}]})").find("CH1"), std::string::npos);
  EXPECT_NE(with(head + R"("colour": "red"})").find("colour"), std::string::npos);
}

}  // namespace
}  // namespace risorius
