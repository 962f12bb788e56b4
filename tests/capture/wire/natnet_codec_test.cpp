#include "capture/wire/natnet_codec.h"

#include <gtest/gtest.h>
#include <random>

#include "capture/wire/natnet_packets.h"

namespace risorius {
namespace {

using test::HandPacket;
using test::natnet_face_frame;
using test::natnet_labelled;
using test::natnet_message;
using test::NatnetHandFrame;
using test::NatnetHandModel;
using Bytes = std::vector<std::byte>;

constexpr NatnetVersion k30{3, 0}, k40{4, 0}, k41{4, 1}, k42{4, 2};

void expect_face(const NatnetFrame& frame) {
  EXPECT_EQ(frame.frame_number, 7);
  ASSERT_EQ(frame.marker_set_count, 1u);
  auto sets = frame.marker_sets;
  const NatnetMarkerSetView set = take_marker_set(sets);
  EXPECT_TRUE(sets.empty());
  EXPECT_EQ(set.name, "face");
  ASSERT_EQ(set.count(), 3u);
  EXPECT_EQ(set.position(2), (std::array{0.7f, 0.8f, 0.9f}));
  ASSERT_EQ(frame.labelled_count, 4u);
  const NatnetLabelledMarker second = labelled_marker(frame, 1), third = labelled_marker(frame, 2);
  EXPECT_EQ(second.model(), 1);
  EXPECT_EQ(second.member(), 2);
  EXPECT_FALSE(second.measured());
  EXPECT_TRUE(third.measured());
  EXPECT_EQ(third.y, 0.8f);
  EXPECT_EQ(third.size, 0.004f);
  EXPECT_EQ(labelled_marker(frame, 3).params & NatnetLabelledMarker::kUnlabelled, 16);
  EXPECT_EQ(frame.suffix.timestamp_s, 1.5);
  EXPECT_EQ(frame.suffix.mid_exposure_ticks, 20'000'000u);
  EXPECT_EQ(frame.suffix.transmit_ticks, 20'000'020u);
}

TEST(NatnetCodec, ReadsAFrameOf30And40WithoutSizes) {
  for (const NatnetVersion version : {k30, k40}) {
    NatnetFrame frame;
    const HandPacket payload = natnet_face_frame(false).payload();
    ASSERT_EQ(decode_frame(payload.bytes(), version, frame), NatnetError::kNone);
    EXPECT_FALSE(frame.other_layout);
    expect_face(frame);
  }
}

TEST(NatnetCodec, ReadsAFrameOf41AndLaterWithSizesAndAssets) {
  for (const NatnetVersion version : {k41, k42, NatnetVersion{5, 0}}) {
    NatnetFrame frame;
    const HandPacket payload = natnet_face_frame(true).payload();
    ASSERT_EQ(decode_frame(payload.bytes(), version, frame), NatnetError::kNone);
    EXPECT_FALSE(frame.other_layout);
    expect_face(frame);
  }
}

TEST(NatnetCodec, AFrameInTheOtherLayoutIsRecognised) {
  // The server's version changes while its new SERVERINFO is on the way.
  for (const bool sized : {false, true}) {
    NatnetFrame frame;
    const HandPacket payload = natnet_face_frame(sized).payload();
    ASSERT_EQ(decode_frame(payload.bytes(), sized ? k30 : k41, frame), NatnetError::kNone);
    EXPECT_TRUE(frame.other_layout);
    expect_face(frame);
  }
}

TEST(NatnetCodec, SkipsUnknownSectionsAndTrailingBytes) {
  NatnetHandFrame hand = natnet_face_frame(true);
  hand.extra.packet(test::natnet_section(3, HandPacket().zeros(77), true)).packet(test::natnet_section(0, {}, true));
  NatnetFrame frame;
  Bytes bytes = hand.payload().bytes();
  ASSERT_EQ(decode_frame(bytes, k42, frame), NatnetError::kNone);
  expect_face(frame);
  hand.trailing.u64(0x1234567890ABCDEF).u8(3);
  bytes = hand.payload().bytes();
  ASSERT_EQ(decode_frame(bytes, k42, frame), NatnetError::kNone);
  expect_face(frame);
  hand.extra = {};
  bytes = hand.payload().bytes();
  ASSERT_EQ(decode_frame(bytes, k41, frame), NatnetError::kNone);
  expect_face(frame);
  NatnetHandFrame old = natnet_face_frame(false);
  old.trailing.zeros(5);
  bytes = old.payload().bytes();
  ASSERT_EQ(decode_frame(bytes, k30, frame), NatnetError::kNone);
  expect_face(frame);
}

TEST(NatnetCodec, TakesLongerLabelledRecordsOfALaterVersion) {
  NatnetHandFrame hand{.sized = true};
  hand.labelled.packet(natnet_labelled(1, 1, 1, 2, 3, 2)).u32(99).packet(natnet_labelled(1, 2, 4, 5, 6, 2)).u32(98);
  hand.labelled_count = 2;
  NatnetFrame frame;
  const Bytes bytes = hand.payload().bytes();
  ASSERT_EQ(decode_frame(bytes, k42, frame), NatnetError::kNone);
  ASSERT_EQ(frame.labelled_count, 2u);
  EXPECT_EQ(labelled_marker(frame, 1).member(), 2);
  EXPECT_EQ(labelled_marker(frame, 1).z, 6);
}

TEST(NatnetCodec, MarkersThatTheModelFilledAreNotMeasured) {
  NatnetLabelledMarker marker;
  const auto measured = [&](int params) {
    marker.params = static_cast<std::int16_t>(params);
    return marker.measured();
  };
  EXPECT_TRUE(measured(0));     // a server that sets no bits
  EXPECT_TRUE(measured(0x0A));  // point cloud, has model
  EXPECT_TRUE(measured(0x0E));  // both
  EXPECT_FALSE(measured(0x0C));
  EXPECT_FALSE(measured(0x01));
  EXPECT_FALSE(measured(0x0D));
}

TEST(NatnetCodec, EveryTruncationOfAFrameIsAnError) {
  for (const bool sized : {false, true}) {
    const Bytes whole = natnet_face_frame(sized).payload().bytes();
    for (std::size_t size = 0; size < whole.size(); ++size) {
      // A buffer of its own, so that a sanitizer sees a read past the end.
      const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
      NatnetFrame frame;
      EXPECT_NE(decode_frame(cut, sized ? k41 : k30, frame), NatnetError::kNone) << size;
    }
  }
}

TEST(NatnetCodec, NegativeAndAbsurdCountsAreErrors) {
  for (const std::int32_t count : {-1, INT32_MIN, INT32_MAX, 1'000'000}) {
    for (const bool sized : {false, true}) {
      NatnetHandFrame sets = natnet_face_frame(sized), labelled = natnet_face_frame(sized);
      sets.marker_set_count = count;
      labelled.labelled_count = count;
      NatnetFrame frame;
      EXPECT_NE(decode_frame(sets.payload().bytes(), sized ? k41 : k30, frame), NatnetError::kNone);
      EXPECT_NE(decode_frame(labelled.payload().bytes(), sized ? k41 : k30, frame), NatnetError::kNone);
    }
    std::vector<NatnetAsset> model;
    EXPECT_NE(decode_model(HandPacket().i32(count).bytes(), k41, model), NatnetError::kNone);
    EXPECT_NE(decode_model(HandPacket().i32(1).i32(0).text("face").i32(count).bytes(), k30, model), NatnetError::kNone);
  }
  NatnetHandFrame size = natnet_face_frame(true);
  Bytes bytes = size.payload().bytes();
  bytes[8] = bytes[9] = bytes[10] = bytes[11] = std::byte{0xFF};  // the size of the first section: -1
  NatnetFrame frame;
  EXPECT_EQ(decode_frame(bytes, k41, frame), NatnetError::kBadCount);
}

TEST(NatnetCodec, ReadsServerInfoWithAndWithoutItsConnectionPart) {
  const Bytes datagram = test::natnet_server_info(4, 1);
  NatnetPacket packet;
  ASSERT_EQ(decode_natnet(datagram, packet), NatnetError::kNone);
  EXPECT_EQ(packet.message(), NatnetMessage::kServerInfo);
  NatnetServerInfo info;
  ASSERT_EQ(decode_server_info(packet.payload, info), NatnetError::kNone);
  EXPECT_EQ(info.name, "Motive");
  EXPECT_EQ(info.version, k41);
  EXPECT_EQ(info.clock_frequency, 10'000'000u);
  EXPECT_EQ(info.data_port, 1511);
  EXPECT_FALSE(info.multicast);
  EXPECT_EQ(info.group, (std::array<std::uint8_t, 4>{239, 255, 42, 99}));
  ASSERT_EQ(decode_server_info(packet.payload.first(264), info), NatnetError::kNone);
  EXPECT_EQ(info.clock_frequency, 0u);
  EXPECT_EQ(info.data_port, 0);
  for (std::size_t size = 0; size < 264; ++size)
    EXPECT_EQ(decode_server_info(packet.payload.first(size), info), NatnetError::kTruncated);
  Bytes unterminated(packet.payload.begin(), packet.payload.end());
  std::fill_n(unterminated.begin(), 256, std::byte{'n'});
  ASSERT_EQ(decode_server_info(unterminated, info), NatnetError::kNone);
  EXPECT_EQ(info.name, std::string(255, 'n'));
  NatnetPacket old;
  const Bytes two = test::natnet_server_info(2, 9);
  ASSERT_EQ(decode_natnet(two, old), NatnetError::kNone);
  EXPECT_EQ(decode_server_info(old.payload, info), NatnetError::kOldVersion);
}

HandPacket rigid_body(std::string_view name, int id, bool names, bool rotation) {
  HandPacket body;
  body.text(name).i32(id).i32(-1).f32({0, 0, 0});
  if (rotation) body.f32({0, 0, 0, 1});
  body.i32(2).f32({1, 2, 3, 4, 5, 6}).i32(0).i32(0);
  if (names) body.text("B1").text("B2");
  return body;
}

TEST(NatnetCodec, ReadsModelDefinitionsOfAllVersions) {
  for (const NatnetVersion version : {k30, k40, k41, k42}) {
    const bool names = version >= k40, rotation = version >= k42;
    NatnetHandModel hand{.sized = version.sized()};
    hand.add(3, HandPacket().i32(1).text("plate").zeros((2 + 3 + 144 + 12) * 4).i32(0).i32(0).i32(1).text("Fx"));
    hand.add(1, rigid_body("band", 3, names, rotation));
    hand.add(2, HandPacket().text("actor").i32(4).i32(1).packet(rigid_body("hip", 1, names, rotation)));
    hand.add(4, HandPacket().i32(1).text("daq").text("0001").i32(0).i32(0).i32(2).text("a").text("b"));
    hand.add(5, HandPacket().text("Prime 41").f32({0, 0, 0, 0, 0, 0, 1}));
    if (version.sized()) {
      hand.add(6, HandPacket()
                      .text("trained")
                      .i32(1)
                      .i32(12)
                      .i32(1)
                      .packet(rigid_body("bone", 1, names, rotation))
                      .i32(1)
                      .text("T1")
                      .i32(5)
                      .f32({0, 0, 0, 0.01f})
                      .i16(0));
      hand.add(77, HandPacket().zeros(33));  // unknown
    }
    hand.marker_set("face", {"brow", "", "chin"});
    std::vector<NatnetAsset> model;
    ASSERT_EQ(decode_model(hand.payload().bytes(), version, model), NatnetError::kNone);
    ASSERT_EQ(model.size(), version.sized() ? 4u : 3u);
    EXPECT_EQ(model[0].name, "band");
    EXPECT_EQ(model[0].id, 3);
    EXPECT_EQ(model[0].marker_names.size(), names ? 2u : 0u);
    EXPECT_EQ(model[1].kind, NatnetAsset::Kind::kSkeleton);
    EXPECT_EQ(model.back().name, "face");
    EXPECT_EQ(model.back().marker_names, (std::vector<std::string>{"brow", "", "chin"}));
    EXPECT_FALSE(model.back().id);
    if (version.sized()) {
      EXPECT_EQ(model[2].id, 12);
      EXPECT_EQ(model[2].marker_ids, std::vector<std::int32_t>{5});
    }
  }
}

TEST(NatnetCodec, EveryTruncationOfAModelDefinitionIsAnError) {
  for (const bool sized : {false, true}) {
    NatnetHandModel hand{.sized = sized};
    hand.marker_set("face", {"brow", "chin"}).add(1, rigid_body("band", 3, sized, false));
    const Bytes whole = hand.payload().bytes();
    for (std::size_t size = 0; size < whole.size(); ++size) {
      const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
      std::vector<NatnetAsset> model;
      EXPECT_NE(decode_model(cut, sized ? k41 : k30, model), NatnetError::kNone) << size;
    }
  }
}

TEST(NatnetCodec, ANameWithoutEndOrTooLongIsAnError) {
  std::vector<NatnetAsset> model;
  const std::string longest(255, 'n'), longer(256, 'n');
  NatnetHandModel good{.sized = true}, bad{.sized = true};
  EXPECT_EQ(decode_model(good.marker_set(longest, {}).payload().bytes(), k41, model), NatnetError::kNone);
  EXPECT_NE(decode_model(bad.marker_set(longer, {}).payload().bytes(), k41, model), NatnetError::kNone);
}

TEST(NatnetCodec, MutatedMessagesNeverReadOutOfBounds) {
  std::mt19937 random(41);
  NatnetHandModel hand{.sized = true};
  hand.marker_set("face", {"brow", "chin"}).add(1, rigid_body("band", 3, true, false));
  const std::vector<Bytes> messages{natnet_face_frame(true).payload().bytes(),
                                    natnet_face_frame(false).payload().bytes(), hand.payload().bytes(),
                                    test::natnet_server_info(4, 1)};
  std::size_t frames = 0;
  for (int i = 0; i < 24000; ++i) {
    Bytes bytes = messages[random() % messages.size()];
    for (std::uint32_t n = 1 + random() % 4; n > 0; --n)
      bytes[random() % bytes.size()] = static_cast<std::byte>(random() % 2 == 0 ? 0xFF : random());
    if (random() % 4 == 0) bytes.resize(random() % (bytes.size() + 1));
    bytes.shrink_to_fit();
    const NatnetVersion version = random() % 2 == 0 ? k41 : k30;
    NatnetFrame frame;
    if (decode_frame(bytes, version, frame) == NatnetError::kNone) {
      ++frames;
      for (std::size_t m = 0; m < frame.labelled_count; ++m) EXPECT_LE(labelled_marker(frame, m).member(), 65535);
      std::size_t sets = 0;
      for (auto rest = frame.marker_sets; !rest.empty(); ++sets) {
        const auto set = take_marker_set(rest);
        if (set.count() > 0) static_cast<void>(set.position(set.count() - 1));
      }
      EXPECT_EQ(sets, frame.marker_set_count);
    }
    std::vector<NatnetAsset> model;
    decode_model(bytes, version, model);
    NatnetServerInfo info;
    decode_server_info(bytes, info);
    NatnetPacket packet;
    decode_natnet(bytes, packet);
  }
  EXPECT_GT(frames, 1000u);  // many mutations hit a position: the loop above has been walked
}

TEST(NatnetCodec, ADatagramIsNoShorterThanItsHeaderSays) {
  NatnetPacket packet;
  EXPECT_EQ(decode_natnet(HandPacket().u16(7).u8(0).bytes(), packet), NatnetError::kTooShort);
  EXPECT_EQ(decode_natnet(HandPacket().u16(7).u16(5).u32(0).bytes(), packet), NatnetError::kBadLength);
  EXPECT_EQ(decode_natnet(HandPacket().u16(7).u16(3).u32(0).bytes(), packet), NatnetError::kNone);
  EXPECT_EQ(packet.payload.size(), 3u);
}

// What we send, byte for byte.

TEST(NatnetCodec, WritesTheThreeFormsOfConnect) {
  NatnetDatagram out;
  encode_connect(NatnetConnectForm::kHeader, out);
  EXPECT_EQ(out, HandPacket().u16(0).u16(0).bytes());
  encode_connect(NatnetConnectForm::kPing, out);
  EXPECT_EQ(out, HandPacket().u16(0).u16(5).text("Ping").bytes());
  encode_connect(NatnetConnectForm::kSender, out);
  ASSERT_EQ(out.size(), 268u);
  EXPECT_EQ(out[2], std::byte{264 & 0xFF});
  EXPECT_EQ(out[4 + 256 + 4], std::byte{4});  // the NatNet version that we speak
}

TEST(NatnetCodec, WritesFramesAsTheLayoutSays) {
  for (const NatnetVersion version : {k30, k41}) {
    const bool sized = version.sized();
    const HandPacket none = test::natnet_section(0, {}, sized);
    HandPacket hand;
    hand.i32(12).packet(test::natnet_section(1, HandPacket().text("face").i32(1).f32({1, 2, 3}), sized));
    hand.packet(none).packet(none).packet(none);
    if (sized) hand.packet(none);
    hand.packet(test::natnet_section(1, natnet_labelled(1, 1, 1, 2, 3, 10), sized)).packet(none).packet(none);
    hand.u32(0x01020304).u32(0).f64(0.5).u64(7).u64(8).u64(9);
    if (sized) hand.u64(0);
    hand.i16(1).i32(0);
    const NatnetLabelledMarker marker{.id = 0x10001, .x = 1, .y = 2, .z = 3, .size = 0.004f, .params = 10};
    NatnetFrameToSend frame{.frame_number = 12, .marker_set = "face", .markers = {&marker, 1}};
    frame.suffix = {.timecode = 0x01020304,
                    .timestamp_s = 0.5,
                    .mid_exposure_ticks = 7,
                    .data_received_ticks = 8,
                    .transmit_ticks = 9,
                    .params = 1};
    NatnetDatagram out;
    encode_frame(frame, version, out);
    EXPECT_EQ(out, natnet_message(7, hand).bytes());
  }
}

TEST(NatnetCodec, WritesModelsAndServerInfoAsTheLayoutSays) {
  NatnetDatagram out;
  const std::vector<NatnetAsset> model{{.name = "face", .marker_names = {"brow", "chin"}}};
  for (const NatnetVersion version : {k30, k40, k41}) {
    encode_model(model, version, out);
    EXPECT_EQ(out, NatnetHandModel{.sized = version.sized()}.marker_set("face", {"brow", "chin"}).datagram());
  }
  NatnetServerInfo info{.name = "Motive", .application_version = {2, 3, 0, 1}, .version = k41};
  info.clock_frequency = 10'000'000;
  info.data_port = 1511;
  info.group = {239, 255, 42, 99};
  encode_server_info(info, out);
  EXPECT_EQ(out, test::natnet_server_info(4, 1));
  EXPECT_EQ(out.size(), 283u);
}

}  // namespace
}  // namespace risorius
