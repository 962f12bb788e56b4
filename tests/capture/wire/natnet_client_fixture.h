// A NatNet session in virtual time, for the tests of what it makes of a server's messages.
#pragma once

#include <cstdint>
#include <gtest/gtest.h>
#include <utility>
#include <vector>

#include "capture/wire/natnet_packets.h"
#include "capture/wire/natnet_session.h"

namespace risorius::test {

inline constexpr std::int64_t kMs = 1'000'000;

// A session in virtual time, with its events and what it has sent.
struct NatnetClientFixture {
  explicit NatnetClientFixture(const NatnetOptions& options = {}) : session(options) {}
  void tick() { session.tick(Tick{.time_ns = now_ns}); }
  void advance(std::int64_t ms) {
    for (std::int64_t i = 0; i < ms; ++i) {
      now_ns += kMs;
      if (now_ns >= session.next_tick_ns()) tick();
    }
  }
  void push(const std::vector<std::byte>& datagram) {
    EXPECT_TRUE(session.push(datagram, now_ns));
    SourceEvent event;
    while (session.pop(event)) events.push_back(event);
    EXPECT_TRUE(session.counters().datagrams.balanced());
    EXPECT_TRUE(session.counters().frames.balanced());
  }
  std::vector<std::vector<std::byte>> sent() {
    std::vector<std::vector<std::byte>> datagrams;
    std::vector<std::byte> datagram;
    while (session.pop_datagram(datagram)) datagrams.push_back(datagram);
    return datagrams;
  }
  bool has_sent(NatnetMessage message) {
    bool found = false;
    for (const std::vector<std::byte>& datagram : sent()) {
      NatnetPacket packet;
      found = found || (decode_natnet(datagram, packet) == NatnetError::kNone && packet.message() == message);
    }
    return found;
  }
  /// To the state in which frames are taken; the face has three markers unless the model says otherwise.
  void connect(unsigned major = 4, unsigned minor = 1, const std::vector<std::byte>& model = {}) {
    const bool sized = major > 4 || (major == 4 && minor >= 1);
    tick();
    push(natnet_server_info(major, minor));
    push(test::natnet_message(3, HandPacket().f32({240})).bytes());
    push(model.empty() ? NatnetHandModel{.sized = sized}.marker_set("face", {"brow", "nose", "chin"}).datagram()
                       : model);
  }
  std::vector<SourceEventKind> kinds() const {
    std::vector<SourceEventKind> all;
    for (const auto& event : events) all.push_back(event.kind);
    return all;
  }
  const MarkerFrame& last_frame() const { return events.back().frame; }

  NatnetSession session;
  std::int64_t now_ns = 1'000'000'000'000;
  std::vector<SourceEvent> events;
};

// Two actors: model 5 is the second marker set. Only the positions say so.
inline NatnetHandFrame natnet_two_faces(bool with_positions) {
  NatnetHandFrame hand{.sized = true};
  if (with_positions) {
    hand.marker_sets.text("anna").i32(2).f32({1, 1, 1, 2, 2, 2}).text("ben").i32(2).f32({3, 3, 3, 4, 4, 4});
    hand.marker_sets.text("all").i32(4).f32({1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4});
    hand.marker_set_count = 3;
  }
  hand.labelled.packet(natnet_labelled(5, 1, 3, 3, 3, 10)).packet(natnet_labelled(5, 2, 4, 4, 4, 10));
  hand.labelled.packet(natnet_labelled(9, 1, 1, 1, 1, 10)).packet(natnet_labelled(9, 2, 2, 2, 2, 10));
  hand.labelled_count = 4;
  return hand;
}

inline std::vector<std::byte> natnet_two_faces_model() {
  return NatnetHandModel{}
      .marker_set("anna", {"brow", "chin"})
      .marker_set("ben", {"brow", "chin"})
      .marker_set("all", {"anna_brow", "anna_chin", "ben_brow", "ben_chin"})
      .datagram();
}

}  // namespace risorius::test
