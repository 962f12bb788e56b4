#include "capture/wire/natnet_marker_map.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "capture/wire/natnet_client_fixture.h"

namespace risorius {
namespace {

using test::HandPacket;
using test::natnet_face_frame;
using test::natnet_labelled;
using test::natnet_two_faces;
using test::natnet_two_faces_model;
using test::NatnetHandFrame;
using test::NatnetHandModel;
using Client = test::NatnetClientFixture;

TEST(NatnetMarkerMap, TakesTheLegacyMarkerSetWhereNoMarkerIsLabelled) {
  NatnetHandFrame hand = natnet_face_frame(true);
  hand.labelled = natnet_labelled(0, 50000, 9, 9, 9, 0x12);
  hand.labelled_count = 1;
  Client client;
  client.connect();
  client.push(hand.datagram());
  EXPECT_EQ(client.last_frame().position_mm[2], (Position{700, 800, 900}));
  EXPECT_EQ(client.last_frame().state[1], MarkerState::kMissing);  // at (0, 0, 0): that is how it says so
  Client labelled_only(NatnetOptions{.markers = "labelled"});
  labelled_only.connect();
  labelled_only.push(hand.datagram());
  EXPECT_EQ(labelled_only.last_frame().state[0], MarkerState::kMissing);
}

TEST(NatnetMarkerMap, AnOccludedMarkerStaysMissingThoughItsMarkerSetHasAPosition) {
  NatnetHandFrame hand = natnet_face_frame(true);
  hand.marker_sets = HandPacket().text("face").i32(3).f32({0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f, 0.7f, 0.8f, 0.9f});
  Client client;
  client.connect();
  client.push(hand.datagram());
  EXPECT_EQ(client.last_frame().state[1], MarkerState::kMissing);
}

TEST(NatnetMarkerMap, WhateverBytesMotiveHasForANameTheSetIsOne) {
  const std::string long_name = std::string(62, 'L') + "\xc3\xa9";
  Client client;
  client.connect(4, 1,
                 NatnetHandModel{}
                     .marker_set("face", {"M\xe4rker", "a\tb", long_name, long_name, long_name, "\xc3\xa9"})
                     .datagram());
  ASSERT_GE(client.events.size(), 2u);
  ASSERT_EQ(client.events[1].kind, SourceEventKind::kMarkerSet);
  const MarkerSet& set = *client.events[1].set;
  EXPECT_TRUE(problems_of(set).empty()) << problems_of(set).front();
  ASSERT_EQ(set.names.size(), 6u);
  EXPECT_EQ(set.names[0], "M\xc3\xa4rker");
  EXPECT_EQ(set.names[1], "a?b");
  EXPECT_EQ(set.names[2], std::string(62, 'L'));
  EXPECT_EQ(set.names[5], "\xc3\xa9");
}

TEST(NatnetMarkerMap, FindsTheModelOfAMarkerSetByEqualPositions) {
  Client both, ben(NatnetOptions{.markers = "set:ben"});
  both.connect(4, 1, natnet_two_faces_model());
  ben.connect(4, 1, natnet_two_faces_model());
  EXPECT_EQ(both.events[1].set->names, (std::vector<std::string>{"brow", "chin", "ben:brow", "ben:chin"}));
  EXPECT_EQ(ben.events[1].set->names, (std::vector<std::string>{"brow", "chin"}));
  for (const bool with_positions : {true, false}) {  // and knows it from then on
    both.push(natnet_two_faces(with_positions).datagram());
    ben.push(natnet_two_faces(with_positions).datagram());
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_EQ(both.last_frame().position_mm[i].x, 1000 * static_cast<float>(i + 1)) << i;
    EXPECT_EQ(ben.last_frame().position_mm[0].x, 3000);
    EXPECT_EQ(ben.last_frame().position_mm[1].x, 4000);
  }
}

TEST(NatnetMarkerMap, MarkersOfNoModelAreNobodysThoughTheyLackTheirBit) {
  NatnetHandFrame hand = natnet_face_frame(true);
  hand.labelled = natnet_labelled(0, 2, 9, 9, 9, 0);
  hand.labelled_count = 1;
  Client client;
  client.connect();
  client.push(hand.datagram());
  EXPECT_EQ(client.last_frame().position_mm[0], (Position{100, 200, 300}));  // from the marker set
  EXPECT_EQ(client.last_frame().state[1], MarkerState::kMissing);
  // Where there is nothing else, they are what they seem to be.
  hand.marker_sets = HandPacket();
  hand.marker_set_count = 0;
  Client bare;
  bare.connect();
  bare.push(hand.datagram());
  EXPECT_EQ(bare.last_frame().position_mm[1], (Position{9000, 9000, 9000}));
}

TEST(NatnetMarkerMap, MembersMayCountFrom0) {
  NatnetHandFrame hand{.sized = true};
  for (int m = 2; m >= 0; --m) hand.labelled.packet(natnet_labelled(1, m, 1, 1, static_cast<float>(m + 1), 10));
  hand.labelled_count = 3;
  Client client;
  client.connect();
  client.push(hand.datagram());
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(client.last_frame().position_mm[i].z, 1000 * static_cast<float>(i + 1));
}

TEST(NatnetMarkerMap, AssetsAreFoundByTheirIdAndMarkersByTheirs) {
  HandPacket asset;
  asset.text("trained").i32(1).i32(12).i32(0).i32(2);
  asset.text("left").i32(7).f32({0, 0, 0, 0.01f}).i16(0).text("right").i32(3).f32({0, 0, 0, 0.01f}).i16(0);
  Client client;
  client.connect(4, 1, NatnetHandModel{}.add(6, asset).datagram());
  NatnetHandFrame hand{.sized = true};
  hand.labelled.packet(natnet_labelled(12, 3, 3, 3, 3, 10)).packet(natnet_labelled(12, 7, 7, 7, 7, 10));
  hand.labelled.packet(natnet_labelled(4, 1, 8, 8, 8, 10));  // of a model that nobody described
  hand.labelled_count = 3;
  client.push(hand.datagram());
  EXPECT_EQ(client.events[1].set->names, (std::vector<std::string>{"left", "right"}));
  EXPECT_EQ(client.last_frame().position_mm[0].x, 7000);
  EXPECT_EQ(client.last_frame().position_mm[1].x, 3000);
}

TEST(NatnetMarkerMap, ModelsWithoutWantedNamesAndWithTooManyAreRefusedAndCounted) {
  Client none(NatnetOptions{.markers = "set:nobody"});
  none.connect();
  EXPECT_EQ(none.session.counters().of(NatnetError::kNoMarkers), 1u);
  HandPacket set;
  set.text("many").i32(257);
  for (int i = 0; i < 257; ++i) set.text(fmt::format("m{}", i));
  Client many;
  many.connect(4, 1, NatnetHandModel{}.add(0, set).datagram());
  EXPECT_EQ(many.session.counters().of(NatnetError::kTooManyMarkers), 1u);
  EXPECT_TRUE(many.events.empty());
}

}  // namespace
}  // namespace risorius
