// The messages are read back by another implementation of MessagePack.
#include "replay/live/messages.h"

#include <cmath>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace risorius {
namespace {

nlohmann::json decode(const MessageBuffer& bytes) { return nlohmann::json::from_msgpack(bytes.begin(), bytes.end()); }

std::vector<std::string> names(std::size_t count, std::size_t bytes) {
  std::vector<std::string> all;
  for (std::size_t i = 0; i < count; ++i) {
    std::string name = std::to_string(i);
    all.push_back(name + std::string(bytes - name.size(), 'x'));
  }
  return all;
}

TEST(Messages, AuFrameReadsBack) {
  AuFrame frame;
  frame.header = {.sequence = 1ull << 40, .capture_time_ns = -7, .receive_time_ns = 9};
  frame.count = 3;
  frame.status = SolverStatus::kConverged;
  frame.state = {AuState::kObserved, AuState::kHeld, AuState::kNotObserved};
  frame.intensity = {0.25, 1.2, 0};
  frame.standard_deviation = {0.01, 0.02, 0};
  frame.residual_rms_mm = 0.3;
  frame.kkt_residual = 1e-12;
  frame.world_from_head = {{0, 0, 0, 1}, {1, 2, 3}};
  const std::vector<std::string> au_names{"AU1L", "AU12R", "mouthLeft"};
  MessageBuffer bytes;
  encode_aus(frame, {.stream = "face", .message = 5, .publish_time_ns = 11, .names = au_names}, bytes);
  const auto json = decode(bytes);
  EXPECT_EQ(json.at("version"), 1);
  EXPECT_EQ(json.at("stream"), "face");
  EXPECT_EQ(json.at("message"), 5);
  EXPECT_EQ(json.at("sequence"), 1ull << 40);
  EXPECT_EQ(json.at("capture_time_ns"), -7);
  EXPECT_EQ(json.at("receive_time_ns"), 9);
  EXPECT_EQ(json.at("publish_time_ns"), 11);
  EXPECT_EQ(json.at("au").at("AU1L"), 0.25);
  EXPECT_EQ(json.at("au").at("AU12R"), 1.2);
  EXPECT_TRUE(json.at("au").at("mouthLeft").is_null()) << "not observed is never 0";
  EXPECT_EQ(json.at("states"), "oh-");
  EXPECT_EQ(json.at("status"), "converged");
  EXPECT_EQ(json.at("kkt_residual"), 1e-12);
  EXPECT_EQ(json.at("translation_mm"), (nlohmann::json{1, 2, 3}));
  EXPECT_EQ(json.at("rotation_xyzw"), (nlohmann::json{0, 0, 0, 1}));
}

TEST(Messages, AMappedFrameSaysThatItHasNoPoseAndNoResidual) {
  AuFrame frame;
  frame.count = 2;
  frame.kind = AuFrameKind::kMapped;
  frame.status = SolverStatus::kNoFace;
  frame.state = {AuState::kHeld, AuState::kNotObserved};
  frame.intensity = {0.25, 0};
  frame.standard_deviation = {std::nan(""), std::nan("")};
  const std::vector<std::string> au_names{"AU1L", "AU13L"};
  MessageBuffer bytes;
  encode_aus(frame, {.stream = "phone", .names = au_names}, bytes);
  const auto json = decode(bytes);
  EXPECT_EQ(json.at("kind"), "mapped");
  EXPECT_EQ(json.at("status"), "no_face");
  EXPECT_EQ(json.at("states"), "h-");
  EXPECT_EQ(json.at("au").at("AU1L"), 0.25);
  for (const char* key : {"residual_rms_mm", "kkt_residual", "rotation_xyzw", "translation_mm"})
    EXPECT_TRUE(json.at(key).is_null()) << key;
  EXPECT_EQ(json.at("standard_deviation"), (nlohmann::json{nullptr, nullptr}));
}

TEST(Messages, MarkerFrameReadsBackAndHidesWhatIsNotKnown) {
  MarkerFrame frame;
  frame.count = 4;
  frame.state = {MarkerState::kMeasured, MarkerState::kFilled, MarkerState::kRejected, MarkerState::kMissing};
  for (std::uint32_t m = 0; m < 4; ++m) frame.position_mm[m] = {1.5f, 2.5f, static_cast<float>(m)};
  const auto marker_names = names(4, 3);
  MessageBuffer bytes;
  encode_markers(frame, {.stream = "s", .names = marker_names}, bytes);
  const auto json = decode(bytes);
  EXPECT_EQ(json.at("states"), ".fro");
  EXPECT_EQ(json.at("names"), marker_names);
  const nlohmann::json expected{1.5, 2.5, 0, 1.5, 2.5, 1, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr};
  EXPECT_EQ(json.at("positions_mm"), expected);
}

TEST(Messages, LargestFramesFit) {
  MessageBuffer bytes;
  MarkerFrame markers;
  markers.count = kMaxMarkers;
  markers.state.fill(MarkerState::kMeasured);
  const auto marker_names = names(kMaxMarkers, 63);
  encode_markers(markers, {.stream = "s", .names = marker_names}, bytes);
  EXPECT_EQ(decode(bytes).at("positions_mm").size(), 3 * kMaxMarkers);

  AuFrame aus;
  aus.count = kMaxAus;
  aus.state.fill(AuState::kObserved);
  const auto au_names = names(kMaxAus, 200);
  encode_aus(aus, {.stream = "s", .names = au_names}, bytes);
  EXPECT_EQ(decode(bytes).at("au").size(), kMaxAus);

  Continuation continuation;
  continuation.au_count = kMaxAus;
  continuation.step_count = kMaxContinuationSteps;
  continuation.ahead_ns.fill(INT64_MAX);
  encode_continuation(continuation, {.stream = "s", .names = au_names}, bytes);
  EXPECT_EQ(decode(bytes).at("au").at(au_names[63]).size(), kMaxContinuationSteps);
  EXPECT_EQ(decode(bytes).at("standard_deviation").size(), kMaxAus);
}

}  // namespace
}  // namespace risorius
