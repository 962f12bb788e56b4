#include "capture/wire/marker_codec.h"

#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <set>

#include "capture/wire/crc32c.h"
#include "support/allocation_counter.h"
#include "support/native_stream.h"

namespace risorius {
namespace {

using test::Bytes;
using test::datagram_of;
using test::datagrams_of;
using test::marker_frame;
using test::marker_set;

DecodeError error_of(std::span<const std::byte> datagram) {
  NativeMessage message;
  return decode(datagram, message);
}

Bytes bytes_of_hex(std::string_view hex) {
  Bytes bytes;
  for (std::size_t i = 0; i + 1 < hex.size();) {
    if (hex[i] == ' ') {
      ++i;
      continue;
    }
    bytes.push_back(static_cast<std::byte>(std::stoi(std::string(hex.substr(i, 2)), nullptr, 16)));
    i += 2;
  }
  return bytes;
}

// Puts a right checksum at the end of what a test has changed by hand.
Bytes sealed(Bytes datagram) {
  const std::uint32_t crc = crc32c(std::span<const std::byte>(datagram).first(datagram.size() - 4));
  std::memcpy(datagram.data() + datagram.size() - 4, &crc, 4);
  return datagram;
}

template <class T>
Bytes with(Bytes datagram, std::size_t offset, T value) {
  std::memcpy(datagram.data() + offset, &value, sizeof value);
  return sealed(std::move(datagram));
}

// Written by hand from the tables of capture/README.md; only the checksums come from a program (Python, bit by bit).
const char* const kSetHex =
    "5249534F 0100 0100 04030201 07000000"  // RISO, version 1, set, session 0x01020304, set 7
    "0000000000005940 0000000000002440"     // 100 Hz, 10 mm per unit
    "464C5500 0500 0200 0000 0200"          // FLU, revision 5, names 0 and 1 of 2
    "036A6177 046E6F7365";                  // jaw, nose
const char* const kFrameHex =
    "5249534F 0100 0200 04030201 07000000"  // RISO, version 1, frame, session 0x01020304, set 7
    "0900000000000000 40E2010000000000"     // sequence 9, capture time 123456 ns
    "01020304 1E 01 0200 0000 0200"         // 01:02:03:04 at 30 frames/s, drop frame; markers 0 and 1 of 2
    "01"                                    // marker 0 is valid
    "0000803F 00000040 00004040"            // 1, 2, 3
    "0000C07F 0000C07F 0000C07F";           // nan, nan, nan
const char* const kEndHex =
    "5249534F 0100 0300 04030201 00000000"  // RISO, version 1, end, session 0x01020304
    "0A00000000000000 0900000000000000";    // 10 frames, the last was 9

TEST(MarkerCodec, ReadsBytesWrittenByHand) {
  NativeMessage message;
  const Bytes set_bytes = bytes_of_hex(std::string(kSetHex) + "B8B03C9A");
  ASSERT_EQ(decode(set_bytes, message), DecodeError::kNone);
  const auto set = std::get<MarkerSetPart>(message);
  EXPECT_EQ(set.session, 0x01020304u);
  EXPECT_EQ(set.set_id, 7u);
  EXPECT_EQ(set.revision, 5u);
  EXPECT_EQ(set.rate_hz, 100);
  EXPECT_EQ(set.mm_per_unit, 10);
  EXPECT_EQ(set.axes.letters(), "FLU");
  EXPECT_EQ(set.count, 2u);
  auto names = set.names;
  EXPECT_EQ(take_name(names), "jaw");
  EXPECT_EQ(take_name(names), "nose");
  EXPECT_TRUE(names.empty());

  const Bytes frame_bytes = bytes_of_hex(std::string(kFrameHex) + "94D0574E");
  ASSERT_EQ(decode(frame_bytes, message), DecodeError::kNone);
  const auto part = std::get<MarkerFramePart>(message);
  EXPECT_EQ(part.sequence, 9u);
  EXPECT_EQ(part.capture_time_ns, 123456);
  EXPECT_EQ(part.timecode.minutes, 2);
  EXPECT_EQ(part.timecode.frame_rate, 30);
  EXPECT_TRUE(part.timecode.drop_frame);
  MarkerFrame frame;
  EXPECT_EQ(place_markers(part, set.mm_per_unit, set.axes, frame), 0u);
  EXPECT_EQ(frame.state[0], MarkerState::kMeasured);
  EXPECT_EQ(frame.position_mm[0], (Position{20, 30, 10}));  // FLU in cm -> LUF in mm
  EXPECT_EQ(frame.state[1], MarkerState::kMissing);
  EXPECT_EQ(frame.reason[1], RejectReason::kNone);

  const Bytes end_bytes = bytes_of_hex(std::string(kEndHex) + "C93135AC");
  ASSERT_EQ(decode(end_bytes, message), DecodeError::kNone);
  EXPECT_EQ(std::get<EndOfStream>(message).frames_sent, 10u);
  EXPECT_EQ(std::get<EndOfStream>(message).last_sequence, 9u);
}

TEST(MarkerCodec, WritesTheSameBytes) {
  MarkerSet set{.id = 7, .names = {"jaw", "nose"}, .rate_hz = 100, .mm_per_unit = 10, .axes = *Axes::parse("FLU")};
  EXPECT_EQ(datagrams_of(set, 0x01020304, 5).at(0), bytes_of_hex(std::string(kSetHex) + "B8B03C9A"));
  EXPECT_EQ(datagram_of({.session = 0x01020304, .frames_sent = 10, .last_sequence = 9}),
            bytes_of_hex(std::string(kEndHex) + "C93135AC"));
}

TEST(MarkerCodec, FramesComeBackBitForBit) {
  for (const std::size_t count : {1u, 7u, 8u, 9u, 116u, 117u, 118u, 234u, 235u, 256u}) {
    MarkerFrame sent = marker_frame(7, count);
    sent.header.sequence = 1'000'000'007;
    sent.state[0] = MarkerState::kMeasured;
    sent.position_mm[0] = {-0.0F, std::numeric_limits<float>::denorm_min(), 1e6F};
    sent.header.timecode = {23, 59, 58, 23, 24, false};
    MarkerFrame received;
    received.header.set_id = sent.header.set_id;
    for (const auto& datagram : datagrams_of(sent)) {
      EXPECT_LE(datagram.size(), kMaxDatagramBytes);
      NativeMessage message;
      ASSERT_EQ(decode(datagram, message), DecodeError::kNone);
      const auto& part = std::get<MarkerFramePart>(message);
      EXPECT_EQ(part.sequence, sent.header.sequence);
      EXPECT_EQ(part.timecode.hours, 23);
      EXPECT_EQ(place_markers(part, 1, Axes(), received), 0u);
    }
    EXPECT_EQ(std::memcmp(&received.position_mm, &sent.position_mm, sizeof sent.position_mm), 0) << count;
    EXPECT_EQ(received.state, sent.state) << count;
  }
}

TEST(MarkerCodec, SplitsLongSetsAndLosesNoName) {
  MarkerSet set = marker_set(kMaxMarkers, 3, std::string(kMaxNameBytes - 3, 'x'));
  const auto datagrams = datagrams_of(set);
  EXPECT_GT(datagrams.size(), 10u);  // 256 names of 61 to 64 bytes with their sizes, at most 1424 of them per datagram
  std::vector<std::string> names;
  for (const auto& datagram : datagrams) {
    EXPECT_LE(datagram.size(), kMaxDatagramBytes);
    NativeMessage message;
    ASSERT_EQ(decode(datagram, message), DecodeError::kNone);
    auto part = std::get<MarkerSetPart>(message);
    EXPECT_EQ(part.first, names.size());
    for (std::size_t i = 0; i < part.part_count; ++i) names.emplace_back(take_name(part.names));
  }
  EXPECT_EQ(names, set.names);
}

TEST(MarkerCodec, NumbersThatAreNotFiniteBecomeMissingAndAreCounted) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  MarkerFrame sent;
  sent.count = 5;
  sent.state.fill(MarkerState::kMeasured);
  sent.position_mm[4] = {1, 1, 1001};  // a kilometre and a metre, in metres
  sent.position_mm[0] = {nan, 1, 1};
  sent.position_mm[1] = {1, 1, -infinity};
  sent.position_mm[2] = {1, 1e38F, 1};  // finite in metres, not in millimetres
  sent.position_mm[3] = {1, 2, 3};
  NativeMessage message;
  const auto datagram = datagrams_of(sent).at(0);
  ASSERT_EQ(decode(datagram, message), DecodeError::kNone);
  MarkerFrame received;
  EXPECT_EQ(place_markers(std::get<MarkerFramePart>(message), 1000, Axes(), received), 4u);
  for (const std::size_t i : {0, 1, 2, 4}) {
    EXPECT_EQ(received.state[i], MarkerState::kMissing);
    EXPECT_EQ(received.reason[i], RejectReason::kNotFinite);
    EXPECT_EQ(received.position_mm[i], Position{});
  }
  EXPECT_EQ(received.position_mm[3], (Position{1000, 2000, 3000}));
}

TEST(MarkerCodec, RoundsToFloatOnce) {
  MarkerFrame sent = marker_frame(1, 1);
  sent.position_mm[0] = {0.1F, 0.7F, 1.3F};
  const auto datagram = datagrams_of(sent).at(0);
  NativeMessage message;
  ASSERT_EQ(decode(datagram, message), DecodeError::kNone);
  MarkerFrame received;
  place_markers(std::get<MarkerFramePart>(message), 25.4, Axes(), received);  // inches: 25.4 is no float
  EXPECT_EQ(received.position_mm[0].x, static_cast<float>(25.4 * static_cast<double>(0.1F)));
  EXPECT_EQ(received.position_mm[0].y, static_cast<float>(25.4 * static_cast<double>(0.7F)));
  EXPECT_EQ(received.position_mm[0].z, static_cast<float>(25.4 * static_cast<double>(1.3F)));
}

std::vector<Bytes> one_of_each() {
  return {datagrams_of(marker_set(5)).at(0), datagrams_of(marker_frame(3, 117)).at(0), datagram_of({1, 10, 9})};
}

TEST(MarkerCodec, EveryTruncationIsAnErrorEvenWithARightChecksum) {
  for (const auto& whole : one_of_each()) {
    ASSERT_EQ(error_of(whole), DecodeError::kNone);
    for (std::size_t size = 0; size < whole.size(); ++size) {
      // Copied to its exact size, so that a sanitizer sees any read beyond it.
      const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
      EXPECT_NE(error_of(cut), DecodeError::kNone) << size;
      if (size < 20) continue;
      EXPECT_EQ(error_of(sealed(cut)), DecodeError::kBadLength) << size;
    }
  }
}

TEST(MarkerCodec, SurplusBytesAreAnError) {
  for (const auto& whole : one_of_each()) {
    Bytes longer = whole;
    longer.push_back(std::byte{0});
    EXPECT_EQ(error_of(sealed(longer)), DecodeError::kBadLength);
    longer.resize(kMaxDatagramBytes + 1);
    EXPECT_EQ(error_of(sealed(longer)), DecodeError::kTooLong);
  }
}

TEST(MarkerCodec, EveryFlippedBitIsFound) {
  for (const auto& whole : one_of_each()) {
    for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
      Bytes flipped = whole;
      flipped[bit / 8] ^= std::byte{1} << (bit % 8);
      EXPECT_NE(error_of(flipped), DecodeError::kNone) << bit;
    }
  }
}

TEST(MarkerCodec, RandomBytesBehindARightHeaderAndChecksumNeverReadOutside) {
  std::mt19937 random(5);
  int decoded = 0;
  for (int round = 0; round < 20'000; ++round) {
    Bytes datagram = one_of_each()[random() % 3];
    const std::size_t changes = 1 + random() % 4;
    for (std::size_t i = 0; i < changes; ++i) {
      datagram[16 + random() % (datagram.size() - 20)] = static_cast<std::byte>(random());
    }
    if (random() % 4 == 0) datagram.resize(20 + random() % (datagram.size() - 20));
    NativeMessage message;
    if (decode(sealed(datagram), message) != DecodeError::kNone) continue;
    ++decoded;
    MarkerFrame frame;
    const Bytes kept = sealed(datagram);
    ASSERT_EQ(decode(kept, message), DecodeError::kNone);
    if (const auto* part = std::get_if<MarkerFramePart>(&message)) {
      ASSERT_LE(part->first + part->part_count, kMaxMarkers);
      place_markers(*part, 1, Axes(), frame);
    }
  }
  EXPECT_GT(decoded, 1000);  // most changes hit positions or names, which may hold anything
}

TEST(MarkerCodec, NamesWhatIsWrong) {
  const Bytes set = one_of_each()[0], frame = one_of_each()[1];
  Bytes wrong = set;
  wrong[0] = std::byte{'X'};
  EXPECT_EQ(error_of(wrong), DecodeError::kBadMagic);
  EXPECT_EQ(error_of(with(set, 4, std::uint16_t{2})), DecodeError::kBadVersion);
  EXPECT_EQ(error_of(with(set, 6, std::uint16_t{4})), DecodeError::kBadType);
  EXPECT_EQ(error_of(with(set, 6, std::uint16_t{0})), DecodeError::kBadType);
  wrong = set;
  wrong.back() ^= std::byte{1};
  EXPECT_EQ(error_of(wrong), DecodeError::kBadChecksum);

  EXPECT_EQ(error_of(with(set, 16, -1.0)), DecodeError::kBadValue);
  EXPECT_EQ(error_of(with(set, 16, std::numeric_limits<double>::infinity())), DecodeError::kBadValue);
  EXPECT_EQ(error_of(with(set, 24, 0.0)), DecodeError::kBadValue);
  EXPECT_EQ(error_of(with(set, 24, std::numeric_limits<double>::quiet_NaN())), DecodeError::kBadValue);
  EXPECT_EQ(error_of(with(set, 32, 'U')), DecodeError::kBadValue);              // UUF
  EXPECT_EQ(error_of(with(set, 44, std::uint8_t{0})), DecodeError::kBadValue);  // an empty name
  EXPECT_EQ(error_of(with(set, 44, std::uint8_t{255})), DecodeError::kBadLength);
  EXPECT_EQ(error_of(with(set, 45, '\n')), DecodeError::kBadValue);
  EXPECT_EQ(error_of(with(set, 45, '\xFF')), DecodeError::kBadValue);  // not UTF-8

  for (const auto& [count, first, part_count] :
       {std::array<std::uint16_t, 3>{0, 0, 0}, {257, 0, 117}, {117, 0, 0}, {117, 1, 117}, {117, 65535, 2}}) {
    Bytes ranged = with(with(with(frame, 38, count), 40, first), 42, part_count);
    EXPECT_EQ(error_of(ranged), DecodeError::kBadCount) << count << " " << first << " " << part_count;
  }
  EXPECT_EQ(error_of(with(frame, 37, std::uint8_t{2})), DecodeError::kBadValue);  // an unknown flag
}

TEST(MarkerCodec, AcceptsNamesInEveryScript) {
  for (const char* name : {"Kinn", "Mundwinkel_ö", "уголок", "口角", "😀"}) {
    EXPECT_EQ(error_of(datagrams_of(MarkerSet{.names = {name}}).at(0)), DecodeError::kNone) << name;
  }
  // Overlong, surrogate, beyond U+10FFFF, cut off.
  for (const char* name : {"\xC0\xAF", "\xED\xA0\x80", "\xF4\x90\x80\x80", "\xE2\x82", "\x80", "\xF8\x80"}) {
    EXPECT_EQ(error_of(datagrams_of(MarkerSet{.names = {name}}).at(0)), DecodeError::kBadValue);
  }
}

TEST(MarkerCodec, EveryErrorHasANameOfItsOwn) {
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < kDecodeErrorCount; ++i) names.insert(name_of(static_cast<DecodeError>(i)));
  EXPECT_EQ(names.size(), kDecodeErrorCount);
  EXPECT_FALSE(names.contains(""));
}

TEST(MarkerCodec, AllocatesNothing) {
  const MarkerSet set = marker_set(20);
  const MarkerFrame frame = marker_frame(1, 60);
  DatagramBuffer buffer;
  NativeMessage message;
  MarkerFrame received;
  const auto before = test::allocations_of_this_thread();
  encode(set, 1, 0, 0, buffer);
  const EncodedPart part = encode(frame, 1, 0, buffer);
  ASSERT_EQ(decode(std::span<const std::byte>(buffer).first(part.bytes), message), DecodeError::kNone);
  place_markers(std::get<MarkerFramePart>(message), 10, Axes(), received);
  EXPECT_EQ(test::allocations_of_this_thread(), before);
}

}  // namespace
}  // namespace risorius
