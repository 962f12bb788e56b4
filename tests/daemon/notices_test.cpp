#include "daemon/notices.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace risorius {
namespace {

nlohmann::json status_of(const std::string& state, const nlohmann::json& solver) {
  return {{"streams", {{"face", {{"state", state}, {"rig_problem", ""}, {"solver", solver}}}}}};
}

/// The only line there is, or all of them where that is not so.
std::string only_line(const std::vector<std::string>& lines) {
  std::string text;
  for (const auto& line : lines) text += (text.empty() ? "" : "\n") + line;
  EXPECT_EQ(lines.size(), 1u) << text;
  return text;
}

TEST(Notices, AChangeOfStateIsToldOnce) {
  Notices notices;
  EXPECT_TRUE(notices.update(status_of("listening", {})).empty()) << "the daemon has said so already";
  EXPECT_TRUE(only_line(notices.update(status_of("streaming", {}))).starts_with("face: streaming"));
  EXPECT_TRUE(notices.update(status_of("streaming", {})).empty());
  EXPECT_NE(only_line(notices.update(status_of("stale", {}))).find("tracker"), std::string::npos);
}

TEST(Notices, AStreamThatHasEndedIsNoTrackerThatSendsNothing) {
  Notices notices;
  auto status = status_of("waiting", {});
  status["streams"]["face"]["link"]["state"] = "streaming";
  EXPECT_EQ(only_line(notices.update(status)), "face: waiting: the stream has ended; the next one is waited for");
  Notices others;
  status["streams"]["face"]["link"]["state"] = "waiting";
  EXPECT_NE(only_line(others.update(status)).find("tracker"), std::string::npos);
}

TEST(Notices, FramesWithoutAusAreToldWithTheReasonMostOfThemHave) {
  Notices notices;
  EXPECT_EQ(notices.update(status_of("streaming", {{"converged", 100}, {"mirrored", 0}})).size(), 1u);
  EXPECT_TRUE(notices.update(status_of("streaming", {{"converged", 190}, {"mirrored", 20}})).empty());
  EXPECT_NE(only_line(notices.update(status_of("streaming", {{"converged", 200}, {"mirrored", 120}}))).find("axes"),
            std::string::npos);
  EXPECT_TRUE(notices.update(status_of("streaming", {{"converged", 200}, {"mirrored", 220}})).empty()) << "told";
  EXPECT_TRUE(notices.update(status_of("streaming", {{"converged", 200}, {"mirrored", 220}})).empty()) << "no frames";
  EXPECT_NE(only_line(notices.update(status_of("streaming", {{"converged", 300}, {"mirrored", 220}}))).find("again"),
            std::string::npos);
}

TEST(Notices, AProblemOfTheRigIsTold) {
  Notices notices;
  auto status = status_of("listening", {});
  status["streams"]["face"]["rig_problem"] = "marker nose is not in the rig";
  EXPECT_EQ(only_line(notices.update(status)), "face: no AUs: marker nose is not in the rig");
  EXPECT_TRUE(notices.update(status).empty());
}

TEST(Notices, MarkersOfTheRigThatTheSetLacksAreTold) {
  Notices notices;
  auto status = status_of("listening", {});
  status["streams"]["face"]["rig_absent_markers"] = "2 of the rig's 55 markers are not in the marker set: CH1, CH2";
  EXPECT_NE(only_line(notices.update(status)).find("CH1, CH2; AUs that only they show"), std::string::npos);
  EXPECT_TRUE(notices.update(status).empty());
}

TEST(Notices, ACaptureTimeThatDoesNotAdvanceIsToldOnce) {
  Notices notices;
  auto status = status_of("listening", {});
  status["streams"]["face"]["frames"]["time_stands"] = 0;
  EXPECT_TRUE(notices.update(status).empty());
  status["streams"]["face"]["frames"]["time_stands"] = 3;
  const std::string line = only_line(notices.update(status));
  EXPECT_TRUE(line.starts_with("face: capture time does not advance")) << line;
  EXPECT_NE(line.find("capture_time_ns"), std::string::npos) << line;
  status["streams"]["face"]["frames"]["time_stands"] = 3000;
  EXPECT_TRUE(notices.update(status).empty());
}

TEST(Notices, ASlipIsToldOnce) {
  Notices notices;
  auto status = status_of("listening", {});
  status["streams"]["face"]["slip"] = {{"count", 0}, {"last", ""}};
  EXPECT_TRUE(notices.update(status).empty());
  status["streams"]["face"]["slip"] = {{"count", 1}, {"last", "RTMP slipped by 4.0 mm at 10.0 s of its take"}};
  EXPECT_TRUE(only_line(notices.update(status)).starts_with("face: RTMP slipped by 4.0 mm"));
  EXPECT_TRUE(notices.update(status).empty());
}

TEST(Notices, ARefusedSourceAFullQueueAndADiskThatFailsAreTold) {
  Notices notices;
  auto status = status_of("waiting", {});
  EXPECT_EQ(notices.update(status).size(), 1u);
  auto& face = status["streams"]["face"];
  face["datagrams"]["errors"]["no_labels"] = 600;
  EXPECT_NE(only_line(notices.update(status)).find("600 datagrams refused: no_labels"), std::string::npos);
  face["admission"]["dropped"] = 7;
  EXPECT_NE(only_line(notices.update(status)).find("face: admission 7 frames"), std::string::npos);
  status["record"]["problem"] = "session/take: No space left on device";
  EXPECT_EQ(only_line(notices.update(status)), "recording: session/take: No space left on device");
  face["neutral_captures"] = 1;
  EXPECT_EQ(only_line(notices.update(status)), "face: neutral taken");
  face["neutral_failures"] = 1;
  EXPECT_TRUE(only_line(notices.update(status)).starts_with("face: neutral NOT taken"));
  EXPECT_TRUE(notices.update(status).empty());
}

TEST(Notices, ALossIsToldAgainOnlyWhenItHasDoubled) {
  Notices notices;
  auto status = status_of("listening", {});
  const auto with_loss = [&](std::uint64_t frames) {
    status["streams"]["face"]["frames"]["lost"] = frames;
    return status;
  };
  EXPECT_TRUE(notices.update(with_loss(0)).empty());
  EXPECT_NE(only_line(notices.update(with_loss(10))).find("frames.lost 10 frames"), std::string::npos);
  EXPECT_TRUE(notices.update(with_loss(19)).empty());
  EXPECT_NE(only_line(notices.update(with_loss(20))).find("20"), std::string::npos);
  status["connections"]["refused"] = 1;
  EXPECT_NE(only_line(notices.update(status)).find("curve_clients"), std::string::npos);
}

}  // namespace
}  // namespace risorius
