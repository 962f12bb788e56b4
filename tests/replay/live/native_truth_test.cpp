#include "replay/live/native_truth.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/native_stream.h"

namespace risorius {
namespace {

constexpr std::size_t kMarkers = 165;  // two datagrams a frame

struct Stream {
  NativeTruth truth;
  void offer_all(std::uint64_t frames) {
    truth.offered(test::datagrams_of(test::marker_set(kMarkers, 1, "m")).at(0));
    for (std::uint64_t s = 0; s < frames; ++s) {
      for (const auto& part : test::datagrams_of(test::marker_frame(s, kMarkers))) EXPECT_TRUE(truth.offered(part));
    }
  }
  void forward_set() { truth.forwarded(test::datagrams_of(test::marker_set(kMarkers, 1, "m")).at(0)); }
  void forward(std::uint64_t sequence, std::size_t part) {
    truth.forwarded(test::datagrams_of(test::marker_frame(sequence, kMarkers)).at(part));
  }
  void forward(std::uint64_t sequence) {
    forward(sequence, 0);
    forward(sequence, 1);
  }
  void forward_end(std::uint64_t last) {
    truth.forwarded(test::datagram_of({.session = 1, .frames_sent = last + 1, .last_sequence = last}));
  }
  nlohmann::json frames() const { return truth.json().at("1").at("frames"); }
  nlohmann::json datagrams() const { return truth.json().at("1").at("datagrams"); }
};

TEST(NativeTruth, TellsLostIncompleteAndRepeatedApart) {
  Stream stream;
  stream.offer_all(8);
  stream.forward(0);  // before its set: of no use
  stream.forward_set();
  stream.forward(1);
  stream.forward(2, 1);  // incomplete
  stream.forward(4);
  stream.forward(4, 0);  // repeated
  stream.forward(7);
  const auto frames = stream.frames(), datagrams = stream.datagrams();
  EXPECT_EQ(frames.at("offered"), 8);
  EXPECT_EQ(frames.at("whole"), 3);
  EXPECT_EQ(frames.at("lost"), 4);  // 2, 3, 5, 6
  EXPECT_EQ(frames.at("lost_before_first"), 1);
  EXPECT_EQ(frames.at("incomplete"), 1);
  EXPECT_EQ(frames.at("lost_sequences"), nlohmann::json::parse("[[0,0],[2,3],[5,6]]"));
  EXPECT_EQ(datagrams.at("frame_parts_before_set"), 2);
  EXPECT_EQ(datagrams.at("frame_parts_used"), 6);
  EXPECT_EQ(datagrams.at("frame_parts_repeated"), 1);
  EXPECT_EQ(datagrams.at("frame_parts_of_incomplete"), 1);
  EXPECT_EQ(datagrams.at("marker_set"), 1);
}

TEST(NativeTruth, CountsByHowManyAFrameWasOvertaken) {
  Stream stream;
  stream.offer_all(8);
  stream.forward_set();
  for (const std::uint64_t sequence : {1, 0, 3, 4, 2, 6}) stream.forward(sequence);
  stream.forward_end(7);
  stream.forward(5);
  const auto frames = stream.frames();
  EXPECT_EQ(frames.at("late_before_first"), 1);                                // 0
  EXPECT_EQ(frames.at("overtaken_by"), nlohmann::json::parse(R"({"2": 1})"));  // 2 by 3 and 4
  EXPECT_EQ(frames.at("after_end"), 1);                                        // 5
  EXPECT_EQ(frames.at("lost_sequences"), nlohmann::json::parse("[[7,7]]"));
}

TEST(NativeTruth, SettlesFramesBeyondItsMemory) {
  NativeTruth truth;
  truth.offered(test::datagrams_of(test::marker_set(1)).at(0));
  truth.forwarded(test::datagrams_of(test::marker_set(1)).at(0));
  constexpr std::uint64_t kFrames = NativeTruth::kRemembered + 1000;
  for (std::uint64_t s = 0; s < kFrames; ++s) {
    const auto datagram = test::datagrams_of(test::marker_frame(s, 1)).at(0);
    truth.offered(datagram);
    if (s % 10 != 3) truth.forwarded(datagram);
  }
  const auto frames = truth.json().at("1").at("frames");
  EXPECT_EQ(frames.at("offered"), kFrames);
  EXPECT_EQ(frames.at("whole").get<std::uint64_t>() + frames.at("lost").get<std::uint64_t>(), kFrames);
  EXPECT_EQ(frames.at("lost"), kFrames / 10 + (kFrames % 10 > 3 ? 1 : 0));
}

TEST(NativeTruth, KnowsOtherDatagramsAsSuch) {
  NativeTruth truth;
  EXPECT_FALSE(truth.offered(test::Bytes(100, std::byte{7})));
  EXPECT_TRUE(truth.json().empty());
}

}  // namespace
}  // namespace risorius
