#include "capture/wire/event_ring.h"

#include <gtest/gtest.h>
#include <string>

#include "capture/errors.h"

namespace risorius {
namespace {

TEST(EventRing, GivesEventsBackInTheirOrderAcrossItsEnd) {
  EventRing ring(3);
  SourceEvent event;
  std::uint64_t next = 0;
  for (std::uint64_t sequence = 0; sequence < 20; ++sequence) {
    ring.emit(SourceEventKind::kFrame, 7).frame.header.sequence = sequence;
    if (ring.ready(1)) continue;
    ASSERT_TRUE(ring.pop(event));
    EXPECT_EQ(event.frame.header.sequence, next++);
    EXPECT_EQ(event.session, 7u);
  }
  while (ring.pop(event)) EXPECT_EQ(event.frame.header.sequence, next++);
  EXPECT_EQ(next, 20u);
  EXPECT_EQ(ring.high_water().value(), 3u);
}

TEST(EventRing, CountsTheFramesThatWait) {
  EventRing ring(4);
  ring.emit(SourceEventKind::kNewSession, 1);
  ring.emit(SourceEventKind::kFrame, 1);
  EXPECT_EQ(ring.waiting_frames(), 1u);
  EXPECT_EQ(ring.room(), 2u);
  SourceEvent event;
  ASSERT_TRUE(ring.pop(event));
  EXPECT_EQ(ring.waiting_frames(), 1u);
  ASSERT_TRUE(ring.pop(event));
  EXPECT_EQ(ring.waiting_frames(), 0u);
  EXPECT_FALSE(ring.pop(event));
}

TEST(EventRing, AnEventKeepsNothingOfTheOneThatHadItsPlace) {
  EventRing ring(3);
  SourceEvent event;
  SourceEvent& first = ring.emit(SourceEventKind::kRecordingStarted, 1);
  first.set_recording_name(std::string(100, 'n'));
  first.end.frames_sent = 5;
  ASSERT_TRUE(ring.pop(event));
  EXPECT_EQ(event.recording_name(), std::string(kMaxRecordingNameBytes, 'n'));
  for (int i = 0; i < 3; ++i) {
    ring.emit(SourceEventKind::kRecordingStopped, 1);
    ASSERT_TRUE(ring.pop(event));
    EXPECT_EQ(event.recording_name(), "");
    EXPECT_EQ(event.end.frames_sent, 0u);
  }
}

TEST(EventRing, NamesADepthOutOfRange) {
  EXPECT_THROW(EventRing(2), UserError);
  EXPECT_THROW(EventRing(65537), UserError);
}

}  // namespace
}  // namespace risorius
