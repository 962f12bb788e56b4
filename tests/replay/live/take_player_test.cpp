#include "replay/live/take_player.h"

#include <gtest/gtest.h>

#include "capture/errors.h"
#include "support/loopback.h"

namespace risorius {
namespace {

using test::run_until;

class FewFrames : public TakeReader {
 public:
  explicit FewFrames(std::uint64_t count) : count_(count) {
    info_.path = "few";
    info_.markers = {.names = {"a"}, .rate_hz = 500};
  }
  const TakeInfo& info() const noexcept override { return info_; }
  bool next(MarkerFrame& frame) override {
    if (next_ == count_) return false;
    frame = {};
    frame.count = 1;
    frame.header.sequence = next_;
    frame.header.capture_time_ns = capture_time_of(next_++, info_.markers.rate_hz);
    return true;
  }
  void rewind() override { next_ = 0; }

 private:
  std::uint64_t count_, next_ = 0;
  TakeInfo info_;
};

class Listener : public TrackerServer {
 public:
  void start(const MarkerSet& set) override { started = set.names == std::vector<std::string>{"a"}; }
  void send_frame(const MarkerFrame& frame, std::int64_t exposure_ns) override {
    headers.push_back(frame.header);
    exposures_ns.push_back(exposure_ns);
  }
  void stop() noexcept override {}
  std::size_t streaming_clients() const noexcept override { return clients; }
  std::string endpoint() const override { return ""; }
  const TrackerServerStatistics& statistics() const noexcept override { return statistics_; }

  bool started = false;
  std::size_t clients = 0;
  std::vector<FrameHeader> headers;
  std::vector<std::int64_t> exposures_ns;

 private:
  TrackerServerStatistics statistics_;
};

TEST(TakePlayer, PlaysAtTheTakesPaceAndKeepsExposuresInStepWithCaptureTimes) {
  boost::asio::io_context io;
  FewFrames take(20);
  Listener listener;
  bool ended = false;
  TakePlayer player(io, take, listener, {}, [&] { ended = true; });
  const auto begin = std::chrono::steady_clock::now();
  player.start();
  EXPECT_TRUE(listener.started);
  ASSERT_TRUE(run_until(io, [&] { return ended; }));
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(38));  // 19 intervals of 2 ms
  ASSERT_EQ(listener.headers.size(), 20u);
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_EQ(listener.headers[i].sequence, i);
    EXPECT_EQ(listener.exposures_ns[i] - listener.exposures_ns[0], listener.headers[i].capture_time_ns);
  }
  EXPECT_EQ(player.frames_played(), 20u);
}

TEST(TakePlayer, ALoopGoesOnCounting) {
  boost::asio::io_context io;
  FewFrames take(3);
  Listener listener;
  TakePlayer player(io, take, listener, {.pace = {.speed = 0}, .loop = true}, [] {});
  player.start();
  ASSERT_TRUE(run_until(io, [&] { return listener.headers.size() == 8; }));
  player.stop();
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(listener.headers[i].sequence, i);
    EXPECT_EQ(listener.headers[i].capture_time_ns, static_cast<std::int64_t>(i) * 2'000'000);
  }
}

TEST(TakePlayer, WaitsForAClientIfToldTo) {
  boost::asio::io_context io;
  FewFrames take(3);
  Listener listener;
  bool ended = false;
  TakePlayer player(io, take, listener, {.pace = {.speed = 0}, .wait_for_client = true}, [&] { ended = true; });
  player.start();
  io.run_for(std::chrono::milliseconds(20));
  EXPECT_TRUE(listener.headers.empty());
  listener.clients = 1;
  ASSERT_TRUE(run_until(io, [&] { return ended; }));
  EXPECT_EQ(listener.headers.size(), 3u);
}

TEST(TakePlayer, ATakeWithoutFramesIsTheUsersToChange) {
  boost::asio::io_context io;
  FewFrames take(0);
  Listener listener;
  EXPECT_THROW(TakePlayer(io, take, listener, {}, [] {}), UserError);
}

}  // namespace
}  // namespace risorius
