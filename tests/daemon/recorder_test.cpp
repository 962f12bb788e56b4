#include "daemon/recorder.h"

#include <algorithm>
#include <fstream>
#include <gtest/gtest.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "solve/faces/builtin_face.h"
#include "support/test_data.h"

namespace risorius {
namespace {

class Record : public ::testing::Test {
 protected:
  Recorder::Options options(const std::string& stream, bool follow_tracker) {
    return {.folder = folder_.path() / "rec",
            .streams = {{stream, rig_, "{}"}},
            .card_markdown = "card",
            .follow_tracker = follow_tracker,
            .with_neutral = [this, stream](std::uint32_t, std::uint64_t neutral) -> std::optional<Recorder::Stream> {
              if (neutral > 2) return std::nullopt;
              Rig rig = rig_;
              rig.source = "neutral " + std::to_string(neutral);
              return Recorder::Stream{stream, rig, "{}"};
            }};
  }
  void send_set() {
    set_ = {.names = rig_.marker_names, .rate_hz = 100};
    item_->kind = OutputItem::Kind::kMarkerSet;
    item_->marker_set = &set_;
    ASSERT_TRUE(results_.send_control(*item_));
  }
  void send_frames(std::uint64_t first, std::uint64_t last) {
    item_->kind = OutputItem::Kind::kSolved;
    for (std::uint64_t f = first; f <= last; ++f) {
      FrameHeader header{
          .set_id = set_.id, .sequence = f, .capture_time_ns = static_cast<std::int64_t>(f) * 10'000'000};
      item_->solved.markers.header = item_->solved.aus.header = header;
      item_->solved.markers.count = static_cast<std::uint32_t>(set_.names.size());
      item_->solved.aus.count = static_cast<std::uint32_t>(rig_.au_count());
      ASSERT_TRUE(results_.send_frame(*item_));
    }
  }
  /// Of a sender whose capture times do as they like, 100 frames a second by our clock.
  template <class CaptureTime>
  void send_frames_at(std::uint64_t first, std::uint64_t last, CaptureTime capture_time_ns) {
    item_->kind = OutputItem::Kind::kSolved;
    item_->solved.markers.count = static_cast<std::uint32_t>(set_.names.size());
    item_->solved.aus.count = static_cast<std::uint32_t>(rig_.au_count());
    for (std::uint64_t f = first; f <= last; ++f) {
      item_->solved.markers.header =
          item_->solved.aus.header = {.set_id = set_.id,
                                      .sequence = f,
                                      .capture_time_ns = capture_time_ns(static_cast<std::int64_t>(f)),
                                      .receive_time_ns = 5'000'000'000 + static_cast<std::int64_t>(f) * 10'000'000};
      ASSERT_TRUE(results_.send_frame(*item_));
    }
  }
  void send_recording(bool started, const std::string& name) {
    item_->kind = started ? OutputItem::Kind::kRecordingStarted : OutputItem::Kind::kRecordingStopped;
    item_->recording_name_size = static_cast<std::uint8_t>(name.size());
    std::ranges::copy(name, item_->recording_name_bytes.begin());
    ASSERT_TRUE(results_.send_control(*item_));
  }
  nlohmann::json take(const std::string& name) {
    std::ifstream file(folder_.path() / "rec" / name / "take.json");
    return nlohmann::json::parse(file);
  }

  test::TemporaryFolder folder_;
  const Rig rig_ = builtin_rig();
  MarkerSet set_;
  std::unique_ptr<OutputItem> item_ = std::make_unique<OutputItem>();
  Channel<OutputItem> results_{512};
};

TEST_F(Record, FollowsTheTrackersOwnRecording) {
  Recorder recorder(options("face", true), results_);
  send_set();
  send_frames(0, 9);
  send_recording(true, "Take 007");
  send_frames(10, 29);
  send_recording(false, "Take 007");
  send_frames(30, 34);
  send_recording(true, "Take 008");
  send_frames(35, 39);
  recorder.stop();
  EXPECT_EQ(recorder.problem(), "");
  EXPECT_EQ(recorder.takes_finished(), 2u);
  EXPECT_EQ(recorder.frames_recorded(), 25u);
  EXPECT_EQ(recorder.frames_outside(), 15u);
  EXPECT_EQ(take("face-001").at("tracker_recording"), "Take 007");
  EXPECT_EQ(take("face-001").at("first_sequence"), 10);
  EXPECT_EQ(take("face-001").at("frames"), 20);
  EXPECT_EQ(take("face-002").at("tracker_recording"), "Take 008");
  EXPECT_EQ(take("face-002").at("frames"), 5);
}

TEST_F(Record, ATimeThatStandsBeginsNoTakes) {
  Recorder recorder(options("face", false), results_);
  send_set();
  send_frames_at(0, 299, [](std::int64_t) { return 0; });
  recorder.stop();
  EXPECT_EQ(recorder.problem(), "");
  EXPECT_EQ(recorder.takes_finished(), 1u);
  EXPECT_EQ(recorder.frames_recorded(), 300u);
  EXPECT_EQ(take("face-001").at("frames"), 300);
  EXPECT_EQ(take("face-001").at("lost_frames"), 0);
  EXPECT_EQ(take("face-001").at("frames_whose_time_does_not_advance"), 299);
}

TEST_F(Record, ATimeThatGoesBackBeginsAtMostOneTakeASecond) {
  Recorder recorder(options("face", false), results_);
  send_set();
  send_frames_at(0, 399, [](std::int64_t f) { return -f * 1'000'000; });
  recorder.stop();
  EXPECT_EQ(recorder.problem(), "");
  EXPECT_EQ(recorder.frames_recorded(), 400u);
  EXPECT_EQ(recorder.takes_finished(), 5u);  // the first frame's, and with frames 1, 101, 201, 301
  EXPECT_EQ(take("face-002").at("first_sequence"), 1);
  EXPECT_EQ(take("face-002").at("frames"), 100);
  EXPECT_EQ(take("face-003").at("first_sequence"), 101);
}

TEST_F(Record, ATrackersClockThatIsSetBackBeginsATake) {
  Recorder recorder(options("face", false), results_);
  send_set();
  send_frames_at(0, 29, [](std::int64_t f) { return 1'000'000'000'000 + f * 10'000'000; });
  send_frames_at(30, 59, [](std::int64_t f) { return f * 10'000'000; });
  recorder.stop();
  EXPECT_EQ(recorder.takes_finished(), 2u);
  EXPECT_EQ(take("face-002").at("first_sequence"), 30);
  EXPECT_FALSE(take("face-002").contains("frames_whose_time_does_not_advance"));
}

TEST_F(Record, ATakeHasTheRigThatItsFramesWereSolvedWith) {
  Recorder recorder(options("face", false), results_);
  send_set();
  for (std::uint64_t neutral = 0; neutral < 3; ++neutral) {
    item_->neutral = neutral;  // no item between them: the frames alone must tell
    send_frames(10 * neutral, 10 * neutral + 9);
  }
  recorder.stop();
  EXPECT_EQ(recorder.takes_finished(), 3u);
  EXPECT_EQ(take("face-001").at("rig").at("source"), rig_.source);
  EXPECT_EQ(take("face-002").at("rig").at("source"), "neutral 1");
  EXPECT_EQ(take("face-003").at("rig").at("source"), "neutral 2");
}

TEST_F(Record, RefusesFramesWhoseRigIsForgotten) {
  Recorder recorder(options("face", false), results_);
  send_set();
  send_frames(0, 9);
  item_->neutral = 3;
  send_frames(10, 19);
  item_->neutral = 2;
  send_frames(20, 29);
  recorder.stop();
  EXPECT_EQ(recorder.frames_recorded(), 20u);
  EXPECT_EQ(recorder.frames_not_written(), 10u);
  EXPECT_NE(recorder.problem().find("live neutral 3"), std::string::npos) << recorder.problem();
}

TEST_F(Record, RecordsAllWhereItIsNotToFollow) {
  Recorder recorder(options("face", false), results_);
  send_set();
  send_recording(true, "Take 007");
  send_frames(0, 9);
  send_recording(false, "Take 007");
  send_frames(10, 14);
  recorder.stop();
  EXPECT_EQ(recorder.takes_finished(), 1u);
  EXPECT_EQ(recorder.frames_recorded(), 15u);
  EXPECT_EQ(recorder.frames_outside(), 0u);
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / "rec" / "manifest-sha256.txt"));
}

TEST_F(Record, ARecordingThatFailedCountsEveryFrameAndGetsNoManifest) {
  Recorder recorder(options(std::string(300, 'n'), false), results_);  // no file system has such a name
  send_set();
  send_frames(0, 60);
  recorder.stop();
  EXPECT_NE(recorder.problem(), "");
  EXPECT_EQ(recorder.frames_recorded(), 0u);
  EXPECT_EQ(recorder.frames_not_written(), 61u);
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "rec" / "manifest-sha256.txt"));
}

}  // namespace
}  // namespace risorius
