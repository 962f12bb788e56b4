#include "replay/corpus/transition_corpus.h"

#include <cmath>
#include <gtest/gtest.h>
#include <set>

#include "generate/au_kind.h"
#include "replay/corpus/augmentation.h"
#include "replay/corpus/expression_corpus.h"
#include "replay/corpus/recording_merge.h"
#include "replay/performer/au_moves.h"
#include "support/test_data.h"

namespace {

using namespace risorius;

/// Moves at 120 Hz: AU12 up from 1 s to 2 s and down from 3.5 s to 4 s, with a blink in the second rest.
AuMotion known_motion() {
  AuMotion motion{"known", {"AU12L", "AU45L"}, 120, AuMatrix(600, 2)};
  AuMoveTrack track({{0, 1, 1, 0.8, 1}, {0, 3.5, 0.5, -0.8, 1}, {1, 2.5, 0.1, 1, 1}, {1, 2.7, 0.1, -1, 1}}, 2);
  std::vector<double> values(2);
  for (Eigen::Index f = 0; f < 600; ++f) {
    track.values_at(static_cast<double>(f) / 120, values);
    motion.rows(f, 0) = static_cast<float>(values[0]);
    motion.rows(f, 1) = static_cast<float>(values[1]);
  }
  return motion;
}

TEST(TransitionCorpus, CutsMotionsBetweenStillPosesAndIgnoresBlinks) {
  const TransitionCorpus corpus = cut_transitions(known_motion());
  ASSERT_EQ(corpus.transitions.size(), 2u);
  const Transition &up = corpus.transitions[0], &down = corpus.transitions[1];
  // Minimum jerk's speed 30 change/T u^2 (1 - u)^2 passes 0.3/s at u = 0.128 of the first and 0.087 of the second.
  EXPECT_NEAR(up.begin_s, 1.128, 0.02);
  EXPECT_LT(up.stray, 1e-3F);
  EXPECT_NEAR(static_cast<double>(up.course.rows()) / 120, 0.744, 0.03);
  EXPECT_NEAR(down.begin_s, 3.543, 0.02);
  ASSERT_EQ(up.past.rows(), kTransitionPastFrames);
  EXPECT_LT(up.past(kTransitionPastFrames - 1, 0), 0.02F);
  EXPECT_NEAR(up.course(up.course.rows() - 1, 0), 0.8, 0.02);
}

TEST(TransitionCorpus, LeavesOutWhatIsTooShortTooLongOrHardlyMoves) {
  StillnessOptions options;
  options.least_frames = 200;
  EXPECT_TRUE(cut_transitions(known_motion(), options).transitions.empty());
  options = {};
  options.most_frames = 60;
  for (const Transition& one : cut_transitions(known_motion(), options).transitions) EXPECT_LE(one.course.rows(), 60);
  options = {};
  options.least_change = 0.9;
  EXPECT_TRUE(cut_transitions(known_motion(), options).transitions.empty());
  options.most_speed = 0;
  EXPECT_THROW(cut_transitions(known_motion(), options), std::invalid_argument);
}

TEST(TransitionCorpus, BlocksOfATakeStayOnOneSideOfTheSplit) {
  const TransitionCorpus corpus = cut_transitions(known_motion(), {}, 1);
  for (const Transition& a : corpus.transitions) {
    for (const Transition& b : corpus.transitions) EXPECT_TRUE(a.sibling != b.sibling || a.part == b.part);
  }
  EXPECT_EQ(corpus.transitions[0].part, CorpusPart::kTrain);
}

TEST(TransitionCorpus, AppendsByName) {
  TransitionCorpus to{{"AU45R", "AU12L"}, 120, {}};
  append(to, cut_transitions(known_motion()));
  ASSERT_EQ(to.transitions.size(), 2u);
  const AuMatrix& course = to.transitions[0].course;
  EXPECT_EQ(course.col(0).cwiseAbs().maxCoeff(), 0) << "nothing serves AU45R";
  EXPECT_NEAR(course(course.rows() - 1, 1), 0.8, 0.02);
}

TEST(TransitionCorpus, CutsTransitionsOutOfARealTake) {
  RISORIUS_NEEDS_DATA(path, "arkit/alex_rom_3.csv");
  const AuMotion motion = motion_of(load_au_recording(path));
  EXPECT_EQ(motion.names, corpus_aus());
  const TransitionCorpus corpus = cut_transitions(motion);
  EXPECT_GT(corpus.transitions.size(), 20u);
  for (const Transition& one : corpus.transitions) {
    EXPECT_GE(one.course.rows(), 41);
    EXPECT_LE(one.course.rows(), 402);
    EXPECT_GE(one.course.minCoeff(), 0);
    EXPECT_LE(one.course.maxCoeff(), 1.2F);
  }
  EXPECT_GT(part_of(corpus, CorpusPart::kTest).size(), 3u);
}

TEST(ExpressionCorpus, PerformsEveryPairInEveryVariant) {
  const TransitionCorpus corpus = perform_expressions(corpus_aus());
  EXPECT_EQ(corpus.transitions.size(), 30u * 5);
  std::set<std::pair<std::string, std::string>> pairs;
  for (const Transition& one : corpus.transitions) {
    pairs.emplace(one.from, one.to);
    EXPECT_GE(one.course.rows(), 41);
    EXPECT_LE(one.course.rows(), 402);
    EXPECT_EQ(one.past.rows(), kTransitionPastFrames);
  }
  EXPECT_EQ(pairs.size(), 30u);
  EXPECT_EQ(only_pairs(corpus, seed003_pairs()).transitions.size(), 85u) << "seed 003's Table 4.2";
  EXPECT_EQ(part_of(corpus, CorpusPart::kTest).size(), 30u);
  for (const Transition& a : corpus.transitions) {
    for (const Transition& b : corpus.transitions) ASSERT_TRUE(a.sibling != b.sibling || a.part == b.part);
  }
}

TEST(ExpressionCorpus, TheSameSeedGivesTheSameBits) {
  const TransitionCorpus a = perform_expressions(corpus_aus(), {3, 1}), b = perform_expressions(corpus_aus(), {3, 1}),
                         c = perform_expressions(corpus_aus(), {4, 1});
  ASSERT_EQ(a.transitions.size(), b.transitions.size());
  for (std::size_t i = 0; i < a.transitions.size(); ++i) EXPECT_EQ(a.transitions[i].course, b.transitions[i].course);
  EXPECT_NE(a.transitions[0].course.sum(), c.transitions[0].course.sum());
}

TEST(ExpressionCorpus, AVariantIsTheSameHoweverManyThereAre) {
  // So two corpora of one seed share performances: what one of them holds out, the other may train on.
  const TransitionCorpus one = perform_expressions(corpus_aus(), {3, 1}),
                         three = perform_expressions(corpus_aus(), {3, 3});
  ASSERT_EQ(one.transitions.size() * 3, three.transitions.size());
  for (std::size_t i = 0; i < one.transitions.size(); ++i)
    EXPECT_EQ(one.transitions[i].course, three.transitions[i].course);
  EXPECT_EQ(three.transitions.back().part, CorpusPart::kTest);
}

TEST(Augmentation, VariesPaceStrengthAndSideWithinTheLimits) {
  const TransitionCorpus corpus = perform_expressions(corpus_aus(), {1, 1});
  const auto mirrored = other_sides(corpus.names);
  Random random(5, 0);
  for (const Transition& original : corpus.transitions) {
    const Transition varied = vary(original, mirrored, random, {.under_way = 0});
    EXPECT_EQ(varied.sibling, original.sibling);
    EXPECT_GE(varied.course.rows(), 41);
    EXPECT_LE(varied.course.rows(), 402);
    EXPECT_GE(varied.course.minCoeff(), 0);
    EXPECT_LE(varied.course.maxCoeff(), 1.2F);
    // Nothing leaps where the past ends: the step over the seam is like the steps before and after it.
    const auto largest_step = [](const AuMatrix& rows) {
      return (rows.bottomRows(rows.rows() - 1) - rows.topRows(rows.rows() - 1)).cwiseAbs().maxCoeff();
    };
    const float seam = (varied.course.row(0) - varied.past.row(varied.past.rows() - 1)).cwiseAbs().maxCoeff();
    const float largest = std::max(largest_step(varied.past), largest_step(varied.course));
    EXPECT_LE(seam, 1.25F * largest + 1e-3F);
  }
}

TEST(Augmentation, BeginsUnderWayWithTheCourseBeforeAsPast) {
  const TransitionCorpus corpus = perform_expressions(corpus_aus(), {1, 1});
  const Transition& whole = corpus.transitions.front();
  const Transition rest = under_way(whole, 30);
  EXPECT_EQ(rest.course.rows(), whole.course.rows() - 30);
  EXPECT_EQ(rest.course, whole.course.bottomRows(whole.course.rows() - 30));
  ASSERT_EQ(rest.past.rows(), kTransitionPastFrames);
  EXPECT_EQ(rest.past, whole.course.middleRows(10, 20));
  EXPECT_DOUBLE_EQ(rest.begin_s, whole.begin_s + 0.25);
  EXPECT_EQ(rest.sibling, whole.sibling);
  const Transition early = under_way(whole, 5);
  EXPECT_EQ(early.past.topRows(15), whole.past.bottomRows(15));
  EXPECT_EQ(early.past.bottomRows(5), whole.course.topRows(5));

  const auto mirrored = other_sides(corpus.names);
  Random random(5, 0);
  for (const Transition& original : corpus.transitions) {
    const Transition varied = vary(original, mirrored, random, {.pace = 0, .pace_bend = 0, .under_way = 1});
    const auto share = static_cast<double>(varied.course.rows()) / static_cast<double>(original.course.rows());
    EXPECT_GE(share, 0.3);
    EXPECT_LE(share, 0.92);
  }
}

TEST(Augmentation, MirrorsSidesByName) {
  const std::vector<std::string> names{"AU12L", "AU27", "AU12R", "mouthLeft", "mouthRight", "AU30L"};
  EXPECT_EQ(other_sides(names), (std::vector<std::size_t>{2, 1, 0, 4, 3, 5}));
  AugmentationOptions only_mirror{0, 0, 1, 0, 0};
  Transition original;
  original.past = AuMatrix::Constant(20, 6, 0.1F);
  original.course = AuMatrix::Constant(60, 6, 0.1F);
  original.course.col(0).setConstant(0.7F);
  original.past.col(0).setConstant(0.7F);
  Random random(1, 0);
  const Transition varied = vary(original, other_sides(names), random, only_mirror);
  ASSERT_EQ(varied.course.rows(), 60);
  EXPECT_FLOAT_EQ(varied.course(30, 2), 0.7F);
  EXPECT_FLOAT_EQ(varied.course(30, 0), 0.1F);
}

/// Frames of the cubic x = (f / 10)^3 / 100 + f / 50.
AuSeries cubic_frames(const std::vector<std::uint64_t>& frames) {
  AuSeries series{{"AU1"}, frames, {}};
  for (const std::uint64_t f : frames) {
    const auto t = static_cast<double>(f) / 10;
    series.intensities.push_back({t * t * t / 100 + t / 5});
  }
  return series;
}

TEST(RecordingMerge, FillsWhatNoRecordingHasAndIsExactOnPolynomialsOfItsDegree) {
  const std::vector<AuSeries> recordings{cubic_frames({0, 2, 3, 7, 10}), cubic_frames({0, 1, 4, 7, 9}),
                                         cubic_frames({2, 6})};
  const MergedSeries merged = merge_recordings(recordings, MergeDegree::kCubic);
  EXPECT_EQ(merged.series.frames, (std::vector<std::uint64_t>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10}));
  EXPECT_EQ(merged.missing, (std::vector<std::uint64_t>{5, 8}));
  EXPECT_EQ(merged.duplicates, 3u);
  EXPECT_EQ(merged.longest_gap, 1u);
  const AuSeries truth = cubic_frames(merged.series.frames);
  for (std::size_t f = 0; f <= 10; ++f)
    EXPECT_NEAR(merged.series.intensities[f][0], truth.intensities[f][0], 1e-12) << f;
  const MergedSeries linear = merge_recordings(recordings, MergeDegree::kLinear);
  EXPECT_NEAR(linear.series.intensities[5][0], (truth.intensities[4][0] + truth.intensities[6][0]) / 2, 1e-12);
  EXPECT_NE(linear.series.intensities[5][0], truth.intensities[5][0]);
}

TEST(RecordingMerge, RefusesWhatDoesNotFit) {
  EXPECT_THROW(merge_recordings({}, MergeDegree::kLinear), std::invalid_argument);
  const std::vector<AuSeries> two{cubic_frames({0, 1}), cubic_frames({1})};
  EXPECT_THROW(merge_recordings(two, MergeDegree::kQuadratic), std::invalid_argument);
  std::vector<AuSeries> other = two;
  other[1].names = {"AU2"};
  EXPECT_THROW(merge_recordings(other, MergeDegree::kLinear), std::invalid_argument);
}

}  // namespace
