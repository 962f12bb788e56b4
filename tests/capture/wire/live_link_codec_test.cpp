#include "capture/wire/live_link_codec.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <set>

#include "support/live_link_packets.h"

namespace risorius {
namespace {

using test::HandLiveLink;

LiveLinkError error_of(const std::vector<std::byte>& bytes) {
  LiveLinkPacket packet;
  return decode_live_link(bytes, packet);
}

TEST(LiveLinkCodec, ReadsAHandMadePacketInBothFormsOfTheVersion) {
  for (const bool one_byte : {false, true}) {
    const auto bytes = HandLiveLink{.one_byte_version = one_byte}.bytes();
    LiveLinkPacket packet;
    ASSERT_EQ(decode_live_link(bytes, packet), LiveLinkError::kNone);
    EXPECT_EQ(packet.form, one_byte ? LiveLinkVersionForm::kByte : LiveLinkVersionForm::kU32);
    EXPECT_EQ(packet.device_id, "$01234567-89AB-CDEF-0123-456789ABCDEF");
    EXPECT_EQ(packet.name, "iPhone");
    EXPECT_EQ(packet.frame, 100);
    EXPECT_EQ(packet.subframe, 0.25F);
    EXPECT_EQ(packet.fps, 60);
    EXPECT_EQ(packet.denominator, 1);
    EXPECT_TRUE(packet.has_face);
    for (std::size_t i = 0; i < kLiveLinkValues; ++i) EXPECT_EQ(packet.value[i], static_cast<float>(i) / 64);
  }
}

TEST(LiveLinkCodec, APacketWithoutValuesHasNoFace) {
  for (const HandLiveLink& hand : {HandLiveLink{.has_count = false}, HandLiveLink{.values = {}}}) {
    const auto bytes = hand.bytes();
    LiveLinkPacket packet{.has_face = true};
    ASSERT_EQ(decode_live_link(bytes, packet), LiveLinkError::kNone);
    EXPECT_FALSE(packet.has_face);
    EXPECT_EQ(packet.frame, 100);
  }
}

TEST(LiveLinkCodec, ShapesAreInUnrealsOrderLeftBeforeRight) {
  const auto names = live_link_shape_names();
  EXPECT_EQ(names[15], "jawLeft");
  EXPECT_EQ(names[16], "jawRight");
  EXPECT_EQ(names[21], "mouthLeft");
  EXPECT_EQ(names[22], "mouthRight");
  EXPECT_EQ(std::set(names.begin(), names.end()).size(), 52u);
}

TEST(LiveLinkCodec, ToleratesFewerValuesMoreValuesAndTrailingBytes) {
  LiveLinkPacket packet;
  const auto fewer = HandLiveLink{.values = HandLiveLink::ramp(52)}.bytes();
  ASSERT_EQ(decode_live_link(fewer, packet), LiveLinkError::kNone);
  EXPECT_EQ(packet.value[51], 51.0F / 64);
  EXPECT_TRUE(std::isnan(packet.value[52]));
  const auto more = HandLiveLink{.values = HandLiveLink::ramp(70)}.bytes();
  ASSERT_EQ(decode_live_link(more, packet), LiveLinkError::kNone);
  EXPECT_EQ(packet.value[60], 60.0F / 64);
  auto trailing = HandLiveLink{}.bytes();
  trailing.insert(trailing.end(), 9, std::byte{0xAB});
  ASSERT_EQ(decode_live_link(trailing, packet), LiveLinkError::kNone);
  EXPECT_EQ(packet.value[60], 60.0F / 64);
}

TEST(LiveLinkCodec, ValuesThatAreNoNumbersAreNotTold) {
  HandLiveLink hand;
  hand.values[3] = std::numeric_limits<float>::infinity();
  hand.values[4] = std::numeric_limits<float>::quiet_NaN();
  const auto bytes = hand.bytes();
  LiveLinkPacket packet;
  ASSERT_EQ(decode_live_link(bytes, packet), LiveLinkError::kNone);
  EXPECT_TRUE(std::isnan(packet.value[3]) && std::isnan(packet.value[4]));
  EXPECT_EQ(packet.value[5], 5.0F / 64);
}

TEST(LiveLinkCodec, SaysWhatIsWrong) {
  auto bytes = HandLiveLink{}.bytes();
  bytes[0] = std::byte{5};
  EXPECT_EQ(error_of(bytes), LiveLinkError::kNotSix);
  bytes = HandLiveLink{.one_byte_version = true}.bytes();
  bytes[0] = std::byte{7};
  EXPECT_EQ(error_of(bytes), LiveLinkError::kNotSix);
  EXPECT_EQ(error_of({}), LiveLinkError::kNotSix);
  EXPECT_EQ(error_of(HandLiveLink{.id = "#01234567-89AB-CDEF-0123-456789ABCDEF"}.bytes()), LiveLinkError::kId);
  EXPECT_EQ(error_of(HandLiveLink{.name = std::string(256, 'x')}.bytes()), LiveLinkError::kName);
  EXPECT_EQ(error_of(HandLiveLink{.name = std::string(255, 'x')}.bytes()), LiveLinkError::kNone);
  EXPECT_EQ(error_of(HandLiveLink{.frame = -1}.bytes()), LiveLinkError::kTime);
  EXPECT_EQ(error_of(HandLiveLink{.subframe = NAN}.bytes()), LiveLinkError::kTime);
  EXPECT_EQ(error_of(HandLiveLink{.subframe = 1.5F}.bytes()), LiveLinkError::kTime);
  EXPECT_EQ(error_of(HandLiveLink{.fps = 0}.bytes()), LiveLinkError::kTime);
  EXPECT_EQ(error_of(HandLiveLink{.denominator = -1}.bytes()), LiveLinkError::kTime);
  EXPECT_EQ(error_of(HandLiveLink{.fps = 1001, .denominator = 1}.bytes()), LiveLinkError::kTime);
  EXPECT_EQ(error_of(HandLiveLink{.fps = 30000, .denominator = 1001}.bytes()), LiveLinkError::kNone);
}

TEST(LiveLinkCodec, ADenominatorOf0MeansAWholeRate) {
  const auto bytes = HandLiveLink{.fps = 24, .denominator = 0}.bytes();
  LiveLinkPacket packet;
  ASSERT_EQ(decode_live_link(bytes, packet), LiveLinkError::kNone);
  EXPECT_EQ(packet.rate_hz(), 24);
}

TEST(LiveLinkCodec, EveryTruncationIsRefusedButTheOneThatSaysNoFace) {
  for (const bool one_byte : {false, true}) {
    const auto whole = HandLiveLink{.one_byte_version = one_byte}.bytes();
    const std::size_t no_face = HandLiveLink{.one_byte_version = one_byte, .has_count = false}.bytes().size();
    for (std::size_t size = 0; size < whole.size(); ++size) {
      const std::vector<std::byte> cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
      EXPECT_EQ(error_of(cut) == LiveLinkError::kNone, size == no_face) << size;
    }
  }
}

TEST(LiveLinkCodec, WritesWhatItReads) {
  for (const HandLiveLink& hand :
       {HandLiveLink{}, HandLiveLink{.one_byte_version = true, .name = ""}, HandLiveLink{.has_count = false}}) {
    const auto bytes = hand.bytes();
    LiveLinkPacket packet;
    ASSERT_EQ(decode_live_link(bytes, packet), LiveLinkError::kNone);
    ByteAppender written;
    encode_live_link(packet, written);
    EXPECT_TRUE(std::ranges::equal(written.bytes(), bytes));
  }
}

// Views of what was accepted must lie within the datagram; the address sanitizer looks at the rest.
TEST(LiveLinkCodec, TwentyThousandMutationsNeverReadOutside) {
  std::mt19937 random(11111);
  std::size_t accepted = 0;
  for (int round = 0; round < 20'000; ++round) {
    auto bytes = HandLiveLink{.one_byte_version = round % 2 == 0}.bytes();
    for (int change = 0; change < 1 + round % 4; ++change) {
      // Most of a packet is values: half of the changes go where the structure is.
      const std::size_t range = change % 2 == 0 ? std::min<std::size_t>(bytes.size(), 80) : bytes.size();
      bytes[random() % range] = static_cast<std::byte>(random() % 256);
    }
    if (round % 3 == 0) bytes.resize(random() % (bytes.size() + 1));
    bytes.shrink_to_fit();
    LiveLinkPacket packet;
    if (decode_live_link(bytes, packet) != LiveLinkError::kNone) continue;
    ++accepted;
    const auto* begin = reinterpret_cast<const char*>(bytes.data());
    EXPECT_GE(packet.name.data(), begin);
    EXPECT_LE(packet.name.data() + packet.name.size(), begin + bytes.size());
    for (const float value : packet.value) EXPECT_FALSE(std::isinf(value));
  }
  EXPECT_GT(accepted, 1000u);
  EXPECT_LT(accepted, 19'000u);
}

}  // namespace
}  // namespace risorius
