#include "replay/session/tick_codec.h"

#include <cstring>
#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace risorius {
namespace {

MarkerFrame frame_of(std::uint32_t count) {
  MarkerFrame frame;
  frame.header = {.stream_id = 1,
                  .set_id = 7,
                  .sequence = 1ULL << 40,
                  .capture_time_ns = -5,
                  .receive_time_ns = 1234567890123,
                  .timecode = {1, 2, 3, 4, 30, true}};
  frame.count = count;
  for (std::uint32_t m = 0; m < count; ++m) {
    frame.state[m] = m % 5 == 0 ? MarkerState::kMissing : MarkerState::kMeasured;
    frame.position_mm[m] = {static_cast<float>(m) / 3, -1e-30F, 1e30F};
  }
  return frame;
}

void expect_equal(const MarkerFrame& a, const MarkerFrame& b) {
  EXPECT_EQ(a.header.sequence, b.header.sequence);
  EXPECT_EQ(a.header.capture_time_ns, b.header.capture_time_ns);
  EXPECT_EQ(a.header.receive_time_ns, b.header.receive_time_ns);
  EXPECT_EQ(a.header.set_id, b.header.set_id);
  EXPECT_EQ(a.header.timecode.frame_rate, b.header.timecode.frame_rate);
  EXPECT_EQ(a.header.timecode.drop_frame, b.header.timecode.drop_frame);
  EXPECT_EQ(a.count, b.count);
  EXPECT_EQ(a.state, b.state);
  EXPECT_EQ(a.reason, b.reason);
  EXPECT_EQ(std::memcmp(&a.position_mm, &b.position_mm, sizeof a.position_mm), 0);
  EXPECT_EQ(std::memcmp(&a.standard_deviation_mm, &b.standard_deviation_mm, sizeof a.standard_deviation_mm), 0);
}

TEST(TickCodec, FramesComeBackBitForBit) {
  ByteAppender bytes;
  SessionTick tick;
  for (const std::uint32_t count : {0U, 1U, 55U, 256U}) {
    MarkerFrame frame = frame_of(count);
    encode_tick(frame, bytes);
    ASSERT_TRUE(decode_tick(bytes.bytes(), tick));
    ASSERT_EQ(tick.kind, TickKind::kFrame);
    expect_equal(tick.frame, frame);
  }
  MarkerFrame filled = frame_of(9);
  filled.reason[3] = RejectReason::kGhost;
  filled.standard_deviation_mm[4] = 0.25F;
  encode_tick(filled, bytes);
  ASSERT_TRUE(decode_tick(bytes.bytes(), tick));
  expect_equal(tick.frame, filled);
}

TEST(TickCodec, TheOtherKindsComeBack) {
  ByteAppender bytes;
  SessionTick tick;
  ShapeFrame shapes;
  shapes.header.sequence = 5;
  shapes.has_face = true;
  shapes.value[3] = 0.5F;
  shapes.value[4] = ShapeFrame::kNone;
  encode_tick(shapes, bytes);
  ASSERT_TRUE(decode_tick(bytes.bytes(), tick));
  ASSERT_EQ(tick.kind, TickKind::kShapes);
  EXPECT_TRUE(tick.shapes.has_face);
  EXPECT_EQ(std::memcmp(&tick.shapes.value, &shapes.value, sizeof shapes.value), 0);

  const MarkerSet set{
      .id = 3, .names = {"a", "\xC3\xA4"}, .rate_hz = 119.88, .mm_per_unit = 10, .axes = *Axes::parse("RUF")};
  encode_tick(set, bytes);
  ASSERT_TRUE(decode_tick(bytes.bytes(), tick));
  EXPECT_EQ(tick.set, set);
  encode_end_of_stream_tick(bytes);
  ASSERT_TRUE(decode_tick(bytes.bytes(), tick));
  EXPECT_EQ(tick.kind, TickKind::kEndOfStream);
  encode_neutral_tick(1'500'000'000, bytes);
  ASSERT_TRUE(decode_tick(bytes.bytes(), tick));
  EXPECT_EQ(tick.duration_ns, 1'500'000'000);
  encode_recording_tick(false, "Take 7", bytes);
  ASSERT_TRUE(decode_tick(bytes.bytes(), tick));
  EXPECT_EQ(tick.kind, TickKind::kRecordingStopped);
  EXPECT_EQ(tick.recording_name, "Take 7");
}

TEST(TickCodec, RefusesEveryTruncationAndWhatNoPipelineCouldBeGiven) {
  ByteAppender bytes;
  SessionTick tick;
  encode_tick(frame_of(12), bytes);
  const std::vector<std::byte> frame(bytes.bytes().begin(), bytes.bytes().end());
  for (std::size_t size = 0; size < frame.size(); ++size)
    EXPECT_FALSE(decode_tick(std::span(frame).first(size), tick)) << size;
  auto longer = frame;
  longer.push_back(std::byte{0});
  EXPECT_FALSE(decode_tick(longer, tick));
  encode_tick(MarkerSet{.names = {"twice", "twice"}, .rate_hz = 100}, bytes);
  EXPECT_FALSE(decode_tick(bytes.bytes(), tick)) << "a name twice";
  // Random changes: refused, or a frame that is within its bounds.
  std::mt19937 random(5);
  for (int i = 0; i < 20'000; ++i) {
    auto broken = frame;
    for (int flips = 0; flips < 3; ++flips) broken[random() % broken.size()] ^= std::byte(1U << random() % 8);
    if (!decode_tick(broken, tick) || tick.kind != TickKind::kFrame) continue;
    ASSERT_LE(tick.frame.count, kMaxMarkers);
    for (const MarkerState state : tick.frame.state) ASSERT_LE(state, MarkerState::kRejected);
  }
}

}  // namespace
}  // namespace risorius
