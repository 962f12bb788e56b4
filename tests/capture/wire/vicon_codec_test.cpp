#include "capture/wire/vicon_codec.h"

#include <gtest/gtest.h>
#include <random>

#include "capture/wire/vicon_packet_writer.h"
#include "support/allocation_counter.h"
#include "support/hex.h"

namespace risorius {
namespace {

using test::hex;
using test::operator+;
using Bytes = std::vector<std::byte>;

constexpr std::size_t kLimit = 1 << 20;
const char* const kDouble1 = "000000000000F03F";
const char* const kDouble2 = "0000000000000040";
const char* const kDouble3 = "0000000000000840";

Bytes bytes_in(const ByteAppender& out) { return {out.bytes().begin(), out.bytes().end()}; }

std::vector<ViconObject> objects_of(std::span<const std::byte> bytes) {
  std::span<const std::byte> objects;
  ViconError error = ViconError::kNone;
  EXPECT_EQ(take_vicon_packet(bytes, kLimit, objects, error), PacketStatus::kWhole);
  std::vector<ViconObject> all;
  while (!objects.empty()) {
    ViconObject object;
    if (!take_vicon_object(objects, object)) {
      ADD_FAILURE() << "object " << all.size();
      break;
    }
    all.push_back(object);
  }
  return all;
}

// One labelled record by hand: subject 3, marker 4, at (1, 2, 3).
Bytes record(const char* ids = "03000000 04000000") {
  return hex(ids) + hex(kDouble1) + hex(kDouble1) + hex(kDouble2) + hex(kDouble3) + Bytes(72) + hex("09000000");
}

TEST(ViconCodec, ReadsThePushRequestOfTheSpecification) {
  const Bytes push = hex("01002B1A 09000000 A2860100 01000000 01");
  const auto objects = objects_of(push);
  ASSERT_EQ(objects.size(), 1u);
  EXPECT_EQ(objects[0].id, static_cast<std::uint32_t>(ViconId::kRequestFrame));
  EXPECT_EQ(decode_vicon_u8(objects[0].body), 1);
  ByteAppender out;
  ViconPacketWriter writer(out);
  writer.u8(ViconId::kRequestFrame, 1);
  writer.finish();
  EXPECT_EQ(bytes_in(out), push);
}

TEST(ViconCodec, TakesAnEmptyPacketForAPacket) {
  const Bytes empty = hex("01002B1A 00000000 FF");
  std::span<const std::byte> bytes = empty, objects;
  ViconError error = ViconError::kNone;
  ASSERT_EQ(take_vicon_packet(bytes, kLimit, objects, error), PacketStatus::kWhole);
  EXPECT_TRUE(objects.empty());
  EXPECT_EQ(bytes.size(), 1u);
}

TEST(ViconCodec, KnowsAWrongTagAndALengthThatCannotBe) {
  const auto error_of = [](const Bytes& packet, PacketStatus expected) {
    std::span<const std::byte> bytes = packet, objects;
    ViconError error = ViconError::kNone;
    EXPECT_EQ(take_vicon_packet(bytes, 1000, objects, error), expected);
    EXPECT_EQ(bytes.size(), packet.size());
    return error;
  };
  EXPECT_EQ(error_of(hex("02002B1A"), PacketStatus::kBad), ViconError::kBadTag);
  EXPECT_EQ(error_of(hex("01002B1A E9030000"), PacketStatus::kBad), ViconError::kTooLong);
  EXPECT_EQ(error_of(hex("01002B1A FFFFFFFF"), PacketStatus::kBad), ViconError::kTooLong);
  EXPECT_EQ(error_of(hex("01002B1A E8030000"), PacketStatus::kIncomplete), ViconError::kNone);
  EXPECT_EQ(error_of(hex("01002B"), PacketStatus::kIncomplete), ViconError::kNone);
}

TEST(ViconCodec, SkipsUnknownObjectsAndRefusesOnesPastTheEnd) {
  const Bytes two = hex("11111111 03000000 AABBCC  05000000 04000000 2A000000");
  std::span<const std::byte> objects = two;
  ViconObject object;
  ASSERT_TRUE(take_vicon_object(objects, object));
  EXPECT_EQ(object.body.size(), 3u);
  ASSERT_TRUE(take_vicon_object(objects, object));
  EXPECT_EQ(decode_vicon_u32(object.body), 42u);
  EXPECT_TRUE(objects.empty());
  for (const char* bad : {"05000000 05000000 2A000000", "05000000 FFFFFFFF", "05000000 0400", "05"}) {
    const Bytes bytes = hex(bad);
    objects = bytes;
    EXPECT_FALSE(take_vicon_object(objects, object)) << bad;
  }
}

TEST(ViconCodec, ReadsLabelledRecordsWrittenByHand) {
  const Bytes body = hex("02000000") + record() + record("03000000 05000000") + hex("EE");
  const auto recons = decode_vicon_recons(body, true);
  ASSERT_TRUE(recons);
  ASSERT_EQ(recons->count, 2u);
  EXPECT_EQ((*recons)[0].subject, 3u);
  EXPECT_EQ((*recons)[0].marker, 4u);
  EXPECT_EQ((*recons)[1].marker, 5u);
  EXPECT_EQ((*recons)[1].position_mm, (std::array<double, 3>{1, 2, 3}));
  EXPECT_EQ(record().size(), 116u);
}

TEST(ViconCodec, ReadsUnlabelledRecordsWrittenByHand) {
  const Bytes body = hex("01000000") + record("");
  const auto recons = decode_vicon_recons(body, false);
  ASSERT_TRUE(recons);
  EXPECT_EQ((*recons)[0].position_mm, (std::array<double, 3>{1, 2, 3}));
  EXPECT_FALSE(decode_vicon_recons(hex("01000000") + Bytes(107), false));
}

TEST(ViconCodec, RefusesCountsBeyondTheBytes) {
  EXPECT_FALSE(decode_vicon_recons(hex("02000000") + record(), true));
  EXPECT_FALSE(decode_vicon_recons(hex("FFFFFFFF") + record(), true));
  EXPECT_FALSE(decode_vicon_recons(hex("35C2720D"), true)) << "116 times this is 2^32 + 4";
  EXPECT_FALSE(decode_vicon_ids(hex("02000000 01000000")));
  EXPECT_FALSE(decode_vicon_ids(hex("01000040")));
  EXPECT_FALSE(decode_vicon_contents(hex("01000000 06000000 01000000")));
  EXPECT_FALSE(decode_vicon_latency_s(hex("01000000 01000000 61") + hex("000000000000F0")));
  EXPECT_FALSE(decode_vicon_u32(hex("010203")));
  EXPECT_FALSE(decode_vicon_i64(hex("01020304050607")));
  EXPECT_FALSE(decode_vicon_u8({}));
}

// A subject with a segment, two markers and an attachment.
const char* const kSubject =
    "07000000 04000000 66616365"  // id 7, "face"
    "01000000 00000000 01000000"  // a segment below the root, id 1
    "00000000 00000000 00000000 00000000 00000000 00000000"
    "04000000 68656164"            // "head"
    "02000000"                     // two markers
    "0A000000 04000000 6368696E"   // 10 "chin"
    "0B000000 00000000"            // 11 ""
    "01000000 0A000000 01000000";  // an attachment

TEST(ViconCodec, ReadsSubjectsWrittenByHand) {
  const auto subject = decode_vicon_subject(hex(kSubject));
  ASSERT_TRUE(subject);
  EXPECT_EQ(subject->id, 7u);
  EXPECT_EQ(subject->name, "face");
  ASSERT_EQ(subject->markers.size(), 2u);
  EXPECT_EQ(subject->markers[0].id, 10u);
  EXPECT_EQ(subject->markers[0].name, "chin");
  EXPECT_EQ(subject->markers[1].name, "");
  EXPECT_TRUE(decode_vicon_subject(hex(kSubject) + hex("AA")));
}

TEST(ViconCodec, RefusesEveryTruncationOfASubjectAndOfRecords) {
  const Bytes subject = hex(kSubject), recons = hex("02000000") + record() + record();
  for (std::size_t size = 0; size < subject.size(); ++size) {
    EXPECT_FALSE(decode_vicon_subject(std::span(subject).first(size))) << size;
  }
  for (std::size_t size = 0; size < recons.size(); ++size) {
    EXPECT_FALSE(decode_vicon_recons(std::span(recons).first(size), true)) << size;
  }
}

TEST(ViconCodec, ReadsTimecodesOfEveryStandard) {
  const auto clock_of = [](const char* standard) {
    const auto timecode = decode_vicon_timecode(hex("01 02 03 04 0500 0600") + hex(standard) + hex("00000000 00"));
    EXPECT_TRUE(timecode);
    return timecode->clock();
  };
  const auto drop = clock_of("02000000");
  ASSERT_TRUE(drop);
  EXPECT_EQ(drop->hours, 1);
  EXPECT_EQ(drop->minutes, 2);
  EXPECT_EQ(drop->seconds, 3);
  EXPECT_EQ(drop->frames, 4);
  EXPECT_EQ(drop->frame_rate, 30);
  EXPECT_TRUE(drop->drop_frame);
  EXPECT_EQ(clock_of("00000000")->frame_rate, 25);
  EXPECT_EQ(clock_of("01000000")->frame_rate, 30);
  EXPECT_FALSE(clock_of("01000000")->drop_frame);
  EXPECT_EQ(clock_of("03000000")->frame_rate, 24);
  EXPECT_EQ(clock_of("04000000")->frame_rate, 24);
  EXPECT_FALSE(clock_of("FFFFFFFF"));
  EXPECT_FALSE(clock_of("06000000"));
  EXPECT_FALSE(decode_vicon_timecode(hex("01 02 03 04 0500 0600 02000000 00000000")));
  EXPECT_FALSE((ViconTimecode{.hours = 24, .standard = 0}).clock());
  EXPECT_FALSE((ViconTimecode{.frames = 25, .standard = 0}).clock());
}

TEST(ViconCodec, SumsLatencies) {
  const Bytes body = hex("02000000 01000000 61") + hex(kDouble1) + hex("00000000") + hex(kDouble2);
  EXPECT_EQ(decode_vicon_latency_s(body), 3.0);
  EXPECT_EQ(decode_vicon_latency_s(hex("00000000")), 0.0);
}

TEST(ViconCodec, ReadsContents) {
  const Bytes body = hex("01000000 05000000 01000000 02000000 06000000 07000000");
  const auto contents = decode_vicon_contents(body);
  ASSERT_TRUE(contents);
  EXPECT_TRUE(contents->unchanged.contains(6));
  EXPECT_TRUE(contents->unchanged.contains(7));
  EXPECT_FALSE(contents->unchanged.contains(5));
}

Bytes whole_packet() {
  ByteAppender out;
  ViconPacketWriter writer(out);
  const std::array<std::pair<std::uint32_t, std::uint32_t>, 1> counts{{{5, 1}}};
  const std::array<std::uint32_t, 2> ids{6, 7};
  writer.contents(counts, ids);
  writer.i64(ViconId::kStreamInfo, 1125000);
  writer.subject({.id = 1, .name = "face", .markers = {{1, "chin"}, {2, "nose"}}});
  writer.u32(ViconId::kFrameInfo, 41);
  writer.timecode(Timecode{1, 2, 3, 4, 30, true});
  const std::array<std::pair<std::string_view, double>, 2> latencies{{{"a", 0.5}, {"b", 0.25}}};
  writer.latencies(latencies);
  writer.frame_rate("Frame Rate", 120);
  const std::array<ViconRecon, 2> recons{{{1, 2, {0.1, -2, 3e-300}}, {1, 1, {4, 5, 6}}}};
  writer.labelled(recons);
  writer.no_unlabelled();
  writer.u8(ViconId::kApplicationInfo, 1);
  writer.ids(ViconId::kObjectEnums, ids);
  writer.i64(ViconId::kPing, 77);
  writer.finish();
  return bytes_in(out);
}

TEST(ViconCodec, ReadsBackWhatItWrites) {
  const Bytes packet = whole_packet();
  const auto objects = objects_of(packet);
  ASSERT_EQ(objects.size(), 12u);
  EXPECT_TRUE(decode_vicon_contents(objects[0].body)->unchanged.contains(7));
  EXPECT_EQ(decode_vicon_i64(objects[1].body), 1125000);
  EXPECT_EQ(decode_vicon_subject(objects[2].body)->markers[1].name, "nose");
  EXPECT_EQ(decode_vicon_u32(objects[3].body), 41u);
  const auto clock = decode_vicon_timecode(objects[4].body)->clock();
  ASSERT_TRUE(clock);
  EXPECT_TRUE(clock->drop_frame);
  EXPECT_EQ(clock->frames, 4);
  EXPECT_EQ(decode_vicon_latency_s(objects[5].body), 0.75);
  const auto recons = decode_vicon_recons(objects[7].body, true);
  EXPECT_EQ((*recons)[0].position_mm, (std::array<double, 3>{0.1, -2, 3e-300}));
  EXPECT_EQ((*recons)[1].marker, 1u);
  EXPECT_EQ(decode_vicon_recons(objects[8].body, false)->count, 0u);
  EXPECT_EQ(decode_vicon_u8(objects[9].body), 1);
  EXPECT_EQ(decode_vicon_ids(objects[10].body)->size(), 2u);
  EXPECT_EQ(decode_vicon_i64(objects[11].body), 77);
}

TEST(ViconCodec, WritesTheLayoutsOfTheSpecification) {
  ByteAppender out;
  ViconPacketWriter writer(out);
  writer.timecode(Timecode{1, 2, 3, 4, 30, true});
  const std::array<ViconRecon, 1> recons{{{3, 4, {1, 2, 3}}}};
  writer.labelled(recons);
  writer.frame_rate("r", 1);
  writer.finish();
  const auto objects = objects_of(out.bytes());
  const auto of = [&](std::size_t i) { return Bytes(objects[i].body.begin(), objects[i].body.end()); };
  EXPECT_EQ(of(0), hex("01 02 03 04 0000 0100 02000000 00000000 00"));
  Bytes expected = hex("01000000") + record();
  for (std::size_t i = 12; i < 20; ++i) expected[i] = std::byte{0};  // radius
  expected[116] = std::byte{1};                                      // trajectory
  EXPECT_EQ(of(1), expected);
  EXPECT_EQ(of(2), hex("01000000 01000000 72") + hex(kDouble1));
}

TEST(ViconCodec, SurvivesTruncationsAndMutations) {
  const Bytes good = whole_packet();
  std::mt19937_64 random(22);
  std::size_t whole = 0, decoded = 0;
  for (int i = 0; i < 40000; ++i) {
    Bytes bytes = good;
    for (std::uint64_t changes = 1 + random() % 4; changes > 0; --changes)
      bytes[8 + random() % (bytes.size() - 8)] = static_cast<std::byte>(random() % 3 == 0 ? 0xFF : random());
    if (i % 4 == 0) {
      bytes.resize(8 + random() % (bytes.size() - 8));
      const auto length = static_cast<std::uint32_t>(bytes.size() - 8);
      std::memcpy(bytes.data() + 4, &length, 4);
    }
    std::span<const std::byte> span = bytes, objects;
    ViconError error = ViconError::kNone;
    if (take_vicon_packet(span, kLimit, objects, error) != PacketStatus::kWhole) continue;
    ++whole;
    ViconObject object;
    while (!objects.empty() && take_vicon_object(objects, object)) {
      decoded += decode_vicon_contents(object.body) ? 1 : 0;
      decoded += decode_vicon_subject(object.body) ? 1 : 0;
      decoded += decode_vicon_timecode(object.body) ? 1 : 0;
      decoded += decode_vicon_latency_s(object.body) ? 1 : 0;
      decoded += decode_vicon_ids(object.body) && decode_vicon_ids(object.body)->contains(1) ? 1 : 0;
      const auto recons = decode_vicon_recons(object.body, i % 2 == 0);
      for (std::size_t r = 0; recons && r < recons->count; ++r) decoded += (*recons)[r].marker;
    }
  }
  EXPECT_GT(whole, 20000u);
  EXPECT_GT(decoded, 1000u);
}

}  // namespace
}  // namespace risorius
