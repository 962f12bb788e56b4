#include "replay/performer/performer_script.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <set>

#include "replay/performer/expression_table.h"

namespace {

using namespace risorius;

/// Names of a full face, as built-in and fitted rigs have them.
const std::vector<std::string> kFace{"AU1L",  "AU1R",  "AU2L",  "AU2R",  "AU4L",  "AU4R",  "AU5L",  "AU5R",  "AU6L",
                                     "AU6R",  "AU7L",  "AU7R",  "AU9L",  "AU9R",  "AU10L", "AU10R", "AU12L", "AU12R",
                                     "AU15L", "AU15R", "AU16L", "AU16R", "AU17",  "AU18",  "AU20L", "AU20R", "AU22",
                                     "AU24L", "AU24R", "AU27",  "AU45L", "AU45R", "AU30L", "AU30R"};

std::size_t column(const std::string& name) {
  return static_cast<std::size_t>(std::find(kFace.begin(), kFace.end(), name) - kFace.begin());
}

/// The intensities of a whole script, one row per 1 / 100 s.
std::vector<std::vector<double>> play(PerformerScript& script, std::size_t aus) {
  std::vector<std::vector<double>> rows;
  for (double t = 0; t < script.seconds(); t += 0.01) script.intensities_at(t, rows.emplace_back(aus));
  return rows;
}

TEST(AuMove, IsASmoothStepWhoseSkewMovesItsMiddle) {
  for (const double skew : {0.5, 1.0, 2.0}) {
    const AuMove move{0, 2, 0.5, 1, skew};
    EXPECT_EQ(move.share_at(2), 0);
    EXPECT_EQ(move.share_at(2.5), 1);
    EXPECT_NEAR(move.share_at(2 + 0.5 * skew / (1 + skew)), 0.5, 1e-12);
    double last = 0;
    for (double t = 2; t < 2.5; t += 1e-3) {
      EXPECT_GE(move.share_at(t), last);
      last = move.share_at(t);
      // Minimum jerk: at most 5.77 / duration^2 (Flash & Hogan); the warp bends time by up to skew^2 and 2 skew.
      const double acceleration = (move.share_at(t + 1e-3) - 2 * move.share_at(t) + move.share_at(t - 1e-3)) / 1e-6;
      EXPECT_LT(std::abs(acceleration), 4 * 5.8 / 0.25) << t;
    }
  }
}

TEST(AuMoveTrack, AddsUpWhatOverlapsAndWhatIsOver) {
  const std::vector<AuMove> moves{{1, 0.5, 1, 0.4, 1}, {0, 0, 1, 0.7, 1}, {0, 0.3, 0.5, -0.2, 0.8}, {0, 5, 1, -0.5, 1}};
  AuMoveTrack track(moves, 2);
  std::vector<double> x(2);
  for (double t = 0; t < 8; t += 0.01) {
    track.values_at(t, x);
    std::vector<double> sum(2, 0);
    for (const AuMove& move : moves) sum[move.au] += move.change * move.share_at(t);
    ASSERT_NEAR(x[0], sum[0], 1e-12) << t;
    ASSERT_NEAR(x[1], sum[1], 1e-12) << t;
  }
  EXPECT_NEAR(x[0], 0, 1e-12);
  track.rewind();
  track.values_at(0, x);
  EXPECT_EQ(x, std::vector<double>(2, 0));
}

TEST(PerformerScript, ExpressionsTakeEveryDirectedPairOfBothSetsOnce) {
  const PerformerScript script(kFace, {ScriptKind::kExpressions, 0, 3});
  std::map<std::string, int> count;
  for (const ScriptCue& cue : script.cues()) {
    ++count[cue.what];
    EXPECT_LT(cue.begin_s, cue.apex_s);
    EXPECT_GE(cue.end_s - cue.apex_s, 0.5) << "apexes are held";
    EXPECT_LE(cue.end_s, script.seconds());
  }
  for (const auto& [set, names] : shipped_expression_table().sets) {
    for (const std::string& from : names) {
      for (const std::string& to : names) {
        if (from == to) continue;
        EXPECT_EQ(count[from + " > " + to], 1) << set << ": " << from << " > " << to;
      }
    }
  }
  // 30 pairs each, and the ways into and out of the set that has no neutral.
  EXPECT_EQ(script.cues().size(), 62u);
}

TEST(PerformerScript, AnApexShowsItsExpression) {
  PerformerScript script(kFace, {ScriptKind::kExpressions, 0, 4});
  const auto rows = play(script, kFace.size());
  int happy = 0, neutral = 0;
  for (const ScriptCue& cue : script.cues()) {
    const auto& row = rows[static_cast<std::size_t>((cue.apex_s + 0.4) * 100)];
    if (cue.what.ends_with("> happy")) {
      ++happy;
      EXPECT_GT(std::min(row[column("AU12L")], row[column("AU12R")]), 0.35) << cue.what;
      EXPECT_LT(row[column("AU4L")], 0.05);
    }
    if (cue.what.ends_with("> neutral")) {
      ++neutral;
      for (std::size_t k = 0; k < kFace.size(); ++k) {
        if (kFace[k].starts_with("AU45")) continue;
        EXPECT_LT(row[k], 0.05) << kFace[k];
      }
    }
  }
  EXPECT_EQ(happy, 5);
  EXPECT_EQ(neutral, 6);
}

TEST(PerformerScript, VariantsAreChosenByTheChannelsThereAre) {
  // Of "disgust", one variant has AU9 without AU10; a rig without AU10 always plays one of the two that it has most of.
  const PerformerScript script({"AU9", "AU17"}, {ScriptKind::kExpressions, 0, 5});
  EXPECT_NE(std::find(script.masked().begin(), script.masked().end(), "AU12"), script.masked().end());
  EXPECT_EQ(std::find(script.masked().begin(), script.masked().end(), "AU9"), script.masked().end());
}

TEST(PerformerScript, EveryScriptIsBoundedSmoothNeutralAtItsEndsAndSeeded) {
  for (const char* name : {"expressions", "speech", "rom", "idle", "mixed"}) {
    const ScriptOptions options{*parse_script_kind(name), 40, 11};
    PerformerScript script(kFace, options), again(kFace, options);
    const auto rows = play(script, kFace.size());
    EXPECT_EQ(rows, play(again, kFace.size())) << name;
    EXPECT_EQ(rows.front(), std::vector<double>(kFace.size(), 0)) << name;
    double largest = 0, largest_step = 0;
    for (std::size_t f = 1; f < rows.size(); ++f) {
      for (std::size_t k = 0; k < kFace.size(); ++k) {
        ASSERT_GE(rows[f][k], 0) << name;
        ASSERT_LE(rows[f][k], 1.15) << name;
        largest = std::max(largest, rows[f][k]);
        largest_step = std::max(largest_step, std::abs(rows[f][k] - rows[f - 1][k]));
      }
    }
    EXPECT_GT(largest, 0.3) << name;
    // The fastest is a blink: minimum jerk over 0.07 s peaks at 1.875 / 0.07 per second, 0.27 in 0.01 s.
    EXPECT_LT(largest_step, 0.28) << name;
    for (std::size_t k = 0; k < kFace.size(); ++k) EXPECT_LT(rows.back()[k], 0.3) << name << " " << kFace[k];
    ScriptOptions other = options;
    other.seed = 12;
    PerformerScript different(kFace, other);
    EXPECT_NE(rows, play(different, kFace.size())) << name;
  }
  EXPECT_FALSE(parse_script_kind("dance"));
}

TEST(PerformerScript, RangeOfMotionMovesEveryChannelAndPurelyWhereAsked) {
  PerformerScript script(kFace, {ScriptKind::kRom, 0, 2, false, false});
  const auto rows = play(script, kFace.size());
  std::vector<double> largest(kFace.size(), 0);
  for (const auto& row : rows)
    for (std::size_t k = 0; k < row.size(); ++k) largest[k] = std::max(largest[k], row[k]);
  for (std::size_t k = 0; k < kFace.size(); ++k) {
    if (kFace[k].starts_with("AU45")) continue;
    EXPECT_GT(largest[k], 0.1) << kFace[k];
  }
  // At the apex of one AU asked alone, only that AU moves, but for what still fades from before.
  for (const ScriptCue& cue : script.cues()) {
    if (cue.what != "AU9") continue;
    const auto& row = rows[static_cast<std::size_t>(cue.end_s * 100)];
    const double loudest = *std::max_element(row.begin(), row.end());
    EXPECT_EQ(loudest, std::max(row[column("AU9L")], row[column("AU9R")]));
  }
}

TEST(PerformerScript, TheJawGoesToOneSideAtATime) {
  PerformerScript script({"AU30L", "AU30R"}, {ScriptKind::kRom, 300, 2});
  for (const auto& row : play(script, 2)) EXPECT_LT(std::min(row[0], row[1]), 0.35);
}

TEST(PerformerScript, SpeechOpensTheJawThreeToSixTimesASecond) {
  PerformerScript script(kFace, {ScriptKind::kSpeech, 120, 9});
  const auto rows = play(script, kFace.size());
  double phrases_s = 0;
  for (const ScriptCue& cue : script.cues()) phrases_s += cue.end_s - cue.begin_s;
  EXPECT_GT(phrases_s, 60);
  int openings = 0;
  const std::size_t jaw = column("AU27");
  for (std::size_t f = 1; f + 1 < rows.size(); ++f)
    openings += rows[f][jaw] > 0.03 && rows[f][jaw] > rows[f - 1][jaw] && rows[f][jaw] >= rows[f + 1][jaw];
  // Syllables of the open vowels and consonants run into each other: somewhat fewer openings than syllables.
  EXPECT_GT(openings / phrases_s, 2.0);
  EXPECT_LT(openings / phrases_s, 7.0);
}

TEST(PerformerScript, BlinksAreFastAsymmetricInTimeAndNearlyTogether) {
  PerformerScript script({"AU45L", "AU45R"}, {ScriptKind::kIdle, 300, 6});
  const auto& moves = script.moves(ScriptLayer::kBlink);
  ASSERT_EQ(moves.size() % 4, 0u);  // down and up on two sides
  const double per_minute = static_cast<double>(moves.size()) / 4 / 5;
  EXPECT_NEAR(per_minute, 17, 6);  // Poisson: 85 blinks, 3 deviations are 28, that is 5.5 a minute
  for (std::size_t i = 0; i < moves.size(); i += 4) {
    EXPECT_LT(std::abs(moves[i].begin_s - moves[i + 1].begin_s), 0.01);
    const double whole_s = moves[i + 2].begin_s + moves[i + 2].duration_s - moves[i].begin_s;
    EXPECT_GE(whole_s, 0.2);
    EXPECT_LE(whole_s, 0.42);
    EXPECT_LT(moves[i].duration_s, moves[i + 2].duration_s);  // the lid falls faster than it rises
  }
}

TEST(PerformerScript, AU1IsNotAU12) {
  // "sad" moves AU1 but not AU12: a rule that goes by prefix would move both.
  PerformerScript script({"AU1", "AU12"}, {ScriptKind::kExpressions, 0, 4});
  const auto rows = play(script, 2);
  for (const ScriptCue& cue : script.cues()) {
    const auto& row = rows[static_cast<std::size_t>((cue.apex_s + 0.4) * 100)];
    if (cue.what.ends_with("> sad")) {
      EXPECT_TRUE(row[0] > 0.3 && row[1] < 0.05) << cue.what;
    }
    if (cue.what.ends_with("> happy")) {
      EXPECT_TRUE(row[1] > 0.3 && row[0] < 0.05) << cue.what;
    }
  }
}

}  // namespace
