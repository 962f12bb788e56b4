#include "replay/dataset/episodes.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "capture/errors.h"
#include "replay/sample_take.h"
#include "support/allocation_counter.h"
#include "support/test_data.h"

namespace risorius {
namespace {

static_assert(Stage<EpisodeDetector, AuFrame, Episode>);

constexpr std::int64_t kStep_ns = 10'000'000;  // 100 Hz
constexpr double kUnseen = std::numeric_limits<double>::quiet_NaN();

AuFrame frame_of(std::uint64_t index, const std::vector<double>& intensities) {
  AuFrame frame;
  frame.header.sequence = index;
  frame.header.capture_time_ns = static_cast<std::int64_t>(index) * kStep_ns;
  for (const double intensity : intensities) {
    if (!std::isnan(intensity)) frame.state[frame.count] = AuState::kObserved;
    frame.intensity[frame.count++] = intensity;
  }
  return frame;
}

std::vector<Episode> drain(EpisodeDetector& detector) {
  std::vector<Episode> episodes;
  for (Episode episode; detector.pop(episode);) episodes.push_back(episode);
  return episodes;
}

/// The episodes of one AU whose intensities are given frame by frame.
std::vector<Episode> episodes_of(const std::vector<double>& intensities, const EpisodeOptions& options = {},
                                 const std::string& name = "AU12L") {
  EpisodeDetector detector({name}, options);
  std::vector<Episode> episodes;
  for (std::size_t i = 0; i < intensities.size(); ++i) {
    EXPECT_TRUE(detector.push(frame_of(i, {intensities[i]})));
    for (const Episode& episode : drain(detector)) episodes.push_back(episode);
  }
  detector.flush();
  for (const Episode& episode : drain(detector)) episodes.push_back(episode);
  EXPECT_TRUE(detector.ledger().balanced());
  return episodes;
}

/// `frames` frames of rest, a plateau of `frames` frames, rest again.
std::vector<double> plateau(double intensity, std::size_t frames = 10) {
  std::vector<double> series(3 * frames, 0.0);
  std::fill_n(series.begin() + static_cast<std::ptrdiff_t>(frames), frames, intensity);
  return series;
}

TEST(Episodes, HaveOnsetApexAndOffset) {
  const auto episodes = episodes_of({0, 0, 0.06, 0.2, 0.5, 0.8, 0.8, 0.3, 0.06, 0.04, 0});
  ASSERT_EQ(episodes.size(), 1u);
  const Episode& episode = episodes[0];
  EXPECT_EQ(episode.onset.frame, 2u);  // 0.06 * 5 = 0.3, above the low threshold of 0.25
  EXPECT_EQ(episode.apex.frame, 5u);   // the first of two equal peaks
  EXPECT_EQ(episode.offset.frame, 8u);
  EXPECT_EQ(episode.apex.time_ns, 5 * kStep_ns);
  EXPECT_EQ(episode.peak, 0.8);
  EXPECT_EQ(episode.letter, 'D');  // 4.0
  EXPECT_EQ(episode.closed_by, EpisodeEnd::kOffset);
  EXPECT_EQ(episode.au_number, 12);
  EXPECT_EQ(episode.side, ColumnSide::kLeft);
}

TEST(Episodes, ChangeLettersExactlyAtTheCutPoints) {
  // FACS.md: below 0.5 nothing, [0.5, 1.5) A, ... from 4.5 E, of five times the intensity, capped at 5.
  for (const auto& [cut, below, at] :
       {std::tuple{0.5, '-', 'A'}, {1.5, 'A', 'B'}, {2.5, 'B', 'C'}, {3.5, 'C', 'D'}, {4.5, 'D', 'E'}}) {
    const auto just_below = episodes_of(plateau(cut / 5 - 1e-9)), just_at = episodes_of(plateau(cut / 5));
    if (below == '-') {
      EXPECT_TRUE(just_below.empty());
    } else {
      ASSERT_EQ(just_below.size(), 1u);
      EXPECT_EQ(just_below[0].letter, below);
    }
    ASSERT_EQ(just_at.size(), 1u) << cut;
    EXPECT_EQ(just_at[0].letter, at);
  }
  EXPECT_EQ(episodes_of(plateau(1.2))[0].letter, 'E');
  EXPECT_EQ(episodes_of(plateau(1.2))[0].peak, 1.2);
}

TEST(Episodes, DependOnTheScaledIntensityAlone) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 0.02);
  std::vector<double> series, doubled;
  for (int i = 0; i < 2000; ++i) {
    series.push_back(std::max(0.0, 0.3 * std::sin(i * 0.02) + noise(random)));
    doubled.push_back(2 * series.back());  // a power of two: exact
  }
  const auto once = episodes_of(series), twice = episodes_of(doubled, {.scale = 2.5});
  ASSERT_GE(once.size(), 6u);  // 2000 * 0.02 / 2 pi = 6.4 swings
  ASSERT_EQ(twice.size(), once.size());
  for (std::size_t i = 0; i < once.size(); ++i) {
    EXPECT_EQ(twice[i].onset.frame, once[i].onset.frame);
    EXPECT_EQ(twice[i].offset.frame, once[i].offset.frame);
    EXPECT_EQ(twice[i].letter, once[i].letter);
    EXPECT_EQ(twice[i].peak, 2 * once[i].peak);
  }
}

TEST(Episodes, AreNotChoppedByNoiseAroundTheCutPoint) {
  std::vector<double> series = plateau(0.1, 40);
  for (std::size_t i = 40; i < 80; ++i) series[i] += (i % 2 == 0 ? 0.02 : -0.02);
  EXPECT_EQ(episodes_of(series).size(), 1u);
  EXPECT_GT(episodes_of(series, {.hysteresis = 0, .minimum_duration_s = 0}).size(), 10u);
}

TEST(Episodes, AreDroppedAndCountedWhereTooShort) {
  std::vector<double> series(20, 0.0);
  series[5] = series[6] = 1;  // one step of 10 ms
  EpisodeDetector detector({"AU12L"}, {.minimum_duration_s = 0.011});
  for (std::size_t i = 0; i < series.size(); ++i) detector.push(frame_of(i, {series[i]}));
  detector.flush();
  EXPECT_TRUE(drain(detector).empty());
  EXPECT_EQ(detector.too_short(), 1u);
  EXPECT_EQ(episodes_of(series, {.minimum_duration_s = 0.01}).size(), 1u);
}

TEST(Episodes, GoOnWhileNotObservedForAShortTime) {
  std::vector<double> series = plateau(0.6, 20);
  for (std::size_t i = 25; i < 35; ++i) series[i] = kUnseen;
  const auto episodes = episodes_of(series);
  ASSERT_EQ(episodes.size(), 1u);
  EXPECT_EQ(episodes[0].onset.frame, 20u);
  EXPECT_EQ(episodes[0].offset.frame, 39u);
  EXPECT_EQ(episodes[0].closed_by, EpisodeEnd::kOffset);
}

TEST(Episodes, EndWhereLastSeenWhenTheyCameDownUnseen) {
  std::vector<double> series = plateau(0.6, 20);
  for (std::size_t i = 30; i < 45; ++i) series[i] = kUnseen;
  const auto episodes = episodes_of(series);
  ASSERT_EQ(episodes.size(), 1u);
  EXPECT_EQ(episodes[0].offset.frame, 29u);
}

TEST(Episodes, AreClosedAndMarkedAfterTooLongWithoutSight) {
  std::vector<double> series(200, 0.6);
  for (std::size_t i = 50; i < 150; ++i) series[i] = kUnseen;  // 1 s
  const auto episodes = episodes_of(series);
  ASSERT_EQ(episodes.size(), 2u);
  EXPECT_EQ(episodes[0].offset.frame, 49u);
  EXPECT_EQ(episodes[0].closed_by, EpisodeEnd::kNotObserved);
  EXPECT_EQ(episodes[1].onset.frame, 150u);
  EXPECT_EQ(episodes[1].closed_by, EpisodeEnd::kEndOfTake);
}

TEST(Episodes, AreNeitherStartedNorRaisedByWhatIsNotMeasured) {
  EpisodeDetector detector({"AU12L"}, {});
  for (std::uint64_t i = 0; i < 60; ++i) {
    AuFrame frame = frame_of(i, {i >= 20 && i < 40 ? 0.4 : 0.0});
    if (i == 10 || i == 25) {  // a held value, and a prediction, both high
      frame.intensity[0] = 1.2;
      if (i == 10) frame.state[0] = AuState::kHeld;
      if (i == 25) frame.kind = AuFrameKind::kPredicted;
    }
    detector.push(frame);
  }
  const auto episodes = drain(detector);
  ASSERT_EQ(episodes.size(), 1u);
  EXPECT_EQ(episodes[0].onset.frame, 20u);
  EXPECT_EQ(episodes[0].peak, 0.4);
}

TEST(Episodes, AreClosedAndMarkedAtTheEndOfTheTake) {
  const auto episodes = episodes_of(std::vector<double>(30, 0.6));
  ASSERT_EQ(episodes.size(), 1u);
  EXPECT_EQ(episodes[0].onset.frame, 0u);
  EXPECT_EQ(episodes[0].offset.frame, 29u);
  EXPECT_EQ(episodes[0].closed_by, EpisodeEnd::kEndOfTake);
}

TEST(Episodes, CodeTheJawAsDropBelowTheSplitAndAsStretchAbove) {
  // AU26 is 0 to 0.6 of the range, AU27 the rest: 0.3 is half of AU26 (2.5, C); 0.6 all of it (5, E); 0.8 half of
  // AU27 (2.5, C); at 0.63 AU27 would be 0.375, below its letter A.
  for (const auto& [intensity, number, letter] : {std::tuple{0.061, 26, 'A'},
                                                  {0.301, 26, 'C'},
                                                  {0.6, 26, 'E'},
                                                  {0.63, 26, 'E'},
                                                  {0.801, 27, 'C'},
                                                  {1.2, 27, 'E'}}) {
    const auto episodes = episodes_of(plateau(intensity), {}, "AU27");
    ASSERT_EQ(episodes.size(), 1u) << intensity;
    EXPECT_EQ(episodes[0].au_number, number) << intensity;
    EXPECT_EQ(episodes[0].letter, letter) << intensity;
  }
  // Beside a column of its own AU26, AU27 is an AU like others.
  EpisodeDetector both({"AU26", "AU27"}, {});
  for (std::uint64_t i = 0; i < 20; ++i) both.push(frame_of(i, {0, 0.5}));
  both.flush();
  const auto episodes = drain(both);
  ASSERT_EQ(episodes.size(), 1u);
  EXPECT_EQ(episodes[0].au_number, 27);
  EXPECT_EQ(episodes[0].letter, 'C');
}

TEST(Episodes, UseTheProfileOfAnAu) {
  const CutPoints unequal{0.2, 1, 2, 4, 4.9};
  EXPECT_EQ(episodes_of(plateau(0.75), {.cut_points_of = {{"AU12", unequal}}, .hysteresis = 0.1})[0].letter, 'C');
  EXPECT_EQ(episodes_of(plateau(0.75), {.cut_points_of = {{"AU12R", unequal}}, .hysteresis = 0.1})[0].letter, 'D');
}

TEST(Episodes, AllocateNothingAndGiveEqualBitsTwice) {
  const std::vector<std::string> names(kMaxAus, "mouthLeft");
  EpisodeDetector first(names, {}), second(names, {});
  std::vector<Episode> a, b;
  a.reserve(4096);
  b.reserve(4096);
  const auto run = [&](EpisodeDetector& detector, std::vector<Episode>& episodes) {
    std::mt19937 random(3);
    AuFrame frame;
    frame.count = kMaxAus;
    frame.state.fill(AuState::kObserved);
    for (std::uint64_t i = 0; i < 600; ++i) {
      frame.header.sequence = i;
      frame.header.capture_time_ns = static_cast<std::int64_t>(i) * kStep_ns;
      // All AUs at once up and down, so that every push that closes closes as many as it can.
      frame.intensity.fill(i % 20 < 10 ? 0.5 + static_cast<double>(random() % 1000) / 1e4 : 0.0);
      Episode episode;
      while (!detector.push(frame))
        while (detector.pop(episode)) episodes.push_back(episode);
    }
    detector.flush();
    for (Episode episode; detector.pop(episode);) episodes.push_back(episode);
  };
  const std::uint64_t before = test::allocations_of_this_thread();
  run(first, a);
  EXPECT_EQ(test::allocations_of_this_thread(), before);
  run(second, b);
  ASSERT_EQ(a.size(), 30u * kMaxAus);  // 600 / 20 rises of all AUs; none is lost
  ASSERT_EQ(b.size(), a.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].peak, b[i].peak);
    EXPECT_EQ(a[i].apex.frame, b[i].apex.frame);
  }
}

TEST(Episodes, RefuseFramesOfAnotherSet) {
  EpisodeDetector detector({"AU1L", "AU1R"}, {});
  EXPECT_TRUE(detector.push(frame_of(0, {1})));
  EXPECT_EQ(detector.ledger().refused.value(), 1u);
  EXPECT_TRUE(detector.ledger().balanced());
}

TEST(Episodes, RefuseOptionsOutOfRange) {
  const auto make = [](const EpisodeOptions& options) { EpisodeDetector({"AU1L"}, options); };
  EXPECT_NO_THROW(make({}));
  EXPECT_THROW(make({.scale = 0}), UserError);
  EXPECT_THROW(make({.cap = 4}), UserError);
  EXPECT_THROW(make({.cut_points = {0.5, 0.5, 1, 2, 3}}), UserError);
  EXPECT_THROW(make({.cut_points = {0, 1, 2, 3, 4}}), UserError);
  EXPECT_THROW(make({.cut_points_of = {{"AU1", {2, 1, 3, 4, 5}}}}), UserError);
  EXPECT_THROW(make({.hysteresis = 0.5}), UserError);
  EXPECT_THROW(make({.minimum_duration_s = -1}), UserError);
  EXPECT_THROW(make({.longest_unobserved_s = std::nan("")}), UserError);
  EXPECT_THROW(make({.jaw_split = 1}), UserError);
  EXPECT_THROW(EpisodeDetector({}, {}), UserError);
  const auto message = test::message_of<UserError>([&] { make({.hysteresis = 0.75}); });
  EXPECT_NE(message.find("hysteresis is 0.75"), std::string::npos) << message;
}

TEST(Episodes, AreSavedAsCsv) {
  const test::TemporaryFolder folder;
  const std::vector<std::string> names = {"AU12L", "AU6", "mouthLeft"};
  EpisodeDetector detector(names, {});
  for (std::uint64_t i = 0; i < 30; ++i) {
    const double rise = i >= 10 && i < 20 ? 0.5 : 0;
    detector.push(frame_of(i, {rise, i == 15 ? 0.9 : rise, i >= 20 ? 0.25 : 0}));
  }
  detector.flush();
  save_episodes(folder.path() / "episodes.csv", names, drain(detector));
  EXPECT_EQ(test::read_bytes(folder.path() / "episodes.csv"),
            "au,side,code,onset_frame,apex_frame,offset_frame,onset_s,apex_s,offset_s,peak,letter,closed_by\n"
            "12,L,L12C,10,10,19,0.1,0.1,0.19,0.5,C,offset\n"
            "6,,6E,10,15,19,0.1,0.15,0.19,0.9,E,offset\n"
            "mouthLeft,,mouthLeft:A,20,20,29,0.2,0.2,0.29,0.25,A,end of take\n");
}

}  // namespace
}  // namespace risorius
