#include "generate/continuation.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <stdexcept>

namespace risorius {
namespace {

/// Writes down what it is shown.
class Recorder final : public ContinuationModel {
 public:
  struct Log {
    std::vector<std::int64_t> times_ns;
    int resets = 0;
  };
  explicit Recorder(Log& log) : log_(log) {}
  std::string_view name() const noexcept override { return "recorder"; }
  void observe(const AuFrame& frame) noexcept override { log_.times_ns.push_back(frame.header.capture_time_ns); }
  void predict(Continuation& continuation) noexcept override { continuation.intensity[0][0] = 0.5f; }
  void reset() noexcept override { ++log_.resets; }

 private:
  Log& log_;
};

AuFrame frame_at(std::int64_t time_ns) {
  AuFrame frame;
  frame.header.capture_time_ns = time_ns;
  frame.count = 3;
  frame.status = SolverStatus::kConverged;
  return frame;
}

std::int64_t frame_time_ns(int frame, double rate_hz) { return std::llround(frame * 1e9 / rate_hz); }

TEST(Continuer, DecimatesByCaptureTimeToAtMost60Hz) {
  for (const double rate_hz : {24.0, 30.0, 59.94, 60.0, 100.0, 120.0, 125.0, 240.0, 1000.0}) {
    Recorder::Log log;
    Continuer continuer(std::make_unique<Recorder>(log));
    Continuation out;
    const int seconds = 10, frames = static_cast<int>(rate_hz * seconds);
    for (int f = 0; f < frames; ++f) continuer.process(frame_at(frame_time_ns(f, rate_hz)), out);
    EXPECT_NEAR(static_cast<double>(log.times_ns.size()), std::min(60.0, rate_hz) * seconds, 6) << rate_hz;
  }
}

TEST(Continuer, GoesOnAtTheEndsOfTime) {
  Recorder::Log log;
  Continuer continuer(std::make_unique<Recorder>(log));
  Continuation out;
  const std::vector<std::int64_t> times_ns{INT64_MIN, INT64_MAX - 1, INT64_MAX, INT64_MIN, 0, 1'000'000'000};
  for (const std::int64_t time_ns : times_ns) continuer.process(frame_at(time_ns), out);
  EXPECT_EQ(log.times_ns,
            (std::vector<std::int64_t>{INT64_MIN, INT64_MAX - 1, INT64_MAX, INT64_MIN, 0, 1'000'000'000}));
}

TEST(Continuer, FillsHeaderAndHorizons) {
  Recorder::Log log;
  Continuer continuer(std::make_unique<Recorder>(log), {.horizons_ms = {16.5, 500}});
  AuFrame frame = frame_at(7);
  frame.header.sequence = 99;
  Continuation out;
  ASSERT_TRUE(continuer.process(frame, out));
  EXPECT_EQ(out.header.sequence, 99u);
  EXPECT_EQ(out.step_count, 2u);
  EXPECT_EQ(out.au_count, 3u);
  EXPECT_EQ(out.ahead_ns[0], 16'500'000);
  EXPECT_EQ(out.ahead_ns[1], 500'000'000);
  EXPECT_EQ(out.intensity[0][0], 0.5f);
}

TEST(Continuer, ShowsTheModelNeitherUnsolvedNorPredictedNorRepeatedFrames) {
  Recorder::Log log;
  Continuer continuer(std::make_unique<Recorder>(log));
  Continuation out;
  AuFrame frame = frame_at(0);
  EXPECT_TRUE(continuer.process(frame, out));
  EXPECT_FALSE(continuer.process(frame, out));
  frame = frame_at(100'000'000);
  frame.kind = AuFrameKind::kPredicted;
  EXPECT_FALSE(continuer.process(frame, out));
  frame = frame_at(100'000'000);
  for (const SolverStatus status : {SolverStatus::kNotSolved, SolverStatus::kTooFewMarkers}) {
    frame.status = status;
    EXPECT_FALSE(continuer.process(frame, out));
  }
  frame.status = SolverStatus::kIterationLimit;
  EXPECT_TRUE(continuer.process(frame, out));
  frame.header.capture_time_ns *= 2;
  frame.count = kMaxAus + 1;
  EXPECT_FALSE(continuer.process(frame, out));
  EXPECT_EQ(log.times_ns.size(), 2u);
  EXPECT_EQ(log.resets, 0);
}

TEST(Continuer, ResetsTheModelWhenTimeGoesBackOrTheAusChange) {
  Recorder::Log log;
  Continuer continuer(std::make_unique<Recorder>(log));
  Continuation out;
  for (int f = 100; f < 110; ++f) continuer.process(frame_at(frame_time_ns(f, 60)), out);
  EXPECT_TRUE(continuer.process(frame_at(0), out));
  EXPECT_EQ(log.resets, 1);
  EXPECT_TRUE(continuer.process(frame_at(frame_time_ns(1, 60)), out));
  AuFrame other = frame_at(frame_time_ns(2, 60));
  other.header.set_id = 5;
  EXPECT_TRUE(continuer.process(other, out));
  EXPECT_EQ(log.resets, 2);
}

TEST(Continuer, GoesOnAtItsRateAfterAGap) {
  Recorder::Log log;
  Continuer continuer(std::make_unique<Recorder>(log));
  Continuation out;
  for (int f = 0; f < 240; ++f) continuer.process(frame_at(frame_time_ns(f, 240)), out);
  const std::size_t before = log.times_ns.size();
  for (int f = 1200; f < 1440; ++f) continuer.process(frame_at(frame_time_ns(f, 240)), out);
  EXPECT_NEAR(static_cast<double>(log.times_ns.size() - before), 60, 1);  // no burst to catch up
}

TEST(Continuer, RefusesOptionsOutOfRange) {
  Recorder::Log log;
  const auto make = [&](const ContinuerOptions& options) { Continuer(std::make_unique<Recorder>(log), options); };
  EXPECT_THROW(make({.max_rate_hz = 0}), std::invalid_argument);
  EXPECT_THROW(make({.max_rate_hz = std::numeric_limits<double>::quiet_NaN()}), std::invalid_argument);
  EXPECT_THROW(make({.horizons_ms = {}}), std::invalid_argument);
  EXPECT_THROW(make({.horizons_ms = {100, 50}}), std::invalid_argument);
  EXPECT_THROW(make({.horizons_ms = {0}}), std::invalid_argument);
  EXPECT_THROW(make({.horizons_ms = {2001}}), std::invalid_argument);
  EXPECT_THROW(make({.horizons_ms = std::vector<double>(33, 1)}), std::invalid_argument);
  EXPECT_THROW(Continuer(nullptr), std::invalid_argument);
}

}  // namespace
}  // namespace risorius
