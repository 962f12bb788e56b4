#include "replay/study/study.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <set>

#include "capture/errors.h"
#include "generate/made_seed_weights.h"
#include "replay/corpus/transition_corpus.h"
#include "replay/study/study_pairs.h"
#include "solve/faces/builtin_face.h"
#include "support/posing_series.h"

namespace risorius {
namespace {

const FaceModel& face() {
  static const FaceModel model = builtin_face();
  return model;
}

AuRecording posing(std::size_t poses, std::uint64_t seed) {
  return record_of("posing", test::posing_series(poses, seed), test::kPosingRateHz);
}

TEST(Study, ShowsTheRecordedCourseAndWhatTheGeneratorsMakeOfItsEnds) {
  const std::vector<AuRecording> recordings{posing(8, 1)};
  const auto cut = cut_transitions(motion_of(recordings.front()));
  ASSERT_GE(cut.transitions.size(), 6u);
  const Study study = make_study(recordings, face(), {.pairs = 12});
  EXPECT_EQ(study.kinds, (std::vector<std::string>{"real", "expression_generator", "minimum_jerk"}));
  EXPECT_EQ(study.transitions.size(), cut.transitions.size());
  ASSERT_EQ(study.trials.size(), 12u);
  for (const StudyTrial& trial : study.trials) {
    const AuMatrix &left = study.clips.at(trial.left_clip), &right = study.clips.at(trial.right_clip);
    const Transition& real = cut.transitions[trial.transition];
    ASSERT_EQ(left.rows(), kTransitionPastFrames + real.course.rows());
    ASSERT_EQ(right.rows(), left.rows());
    EXPECT_TRUE(left.topRows(kTransitionPastFrames) == right.topRows(kTransitionPastFrames)) << "the same past";
    EXPECT_LT((left.bottomRows(1) - right.bottomRows(1)).cwiseAbs().maxCoeff(), 1e-5F) << "the same target";
    EXPECT_FALSE(left == right);
    const auto smile = std::find(study.aus.begin(), study.aus.end(), "AU12L") - study.aus.begin();
    if (trial.left_kind == kStudyReal) {
      EXPECT_TRUE(left.bottomRows(real.course.rows()).col(smile) == real.course.col(2)) << "as it was recorded";
    }
  }
}

TEST(Study, SaysWhichRecordingAGeneratorHasLearntFrom) {
  AuRecording learnt = posing(6, 2);
  learnt.take = "alex_rom_3";
  const std::vector<AuRecording> recordings{learnt, posing(6, 3)};
  Safetensors weights = test::made_seed_weights();
  weights.metadata["trained_on"] = "somebody.csv, posing.csv";
  std::vector<std::string> told;
  for (const std::string& note :
       make_study(recordings, face(), {.pairs = 6, .seed_weights = &weights, .seed_weights_place = "made"}).notes) {
    if (note.find("was trained on it") != std::string::npos) told.push_back(note);
  }
  ASSERT_EQ(told.size(), 2u);
  EXPECT_TRUE(told[0].starts_with("alex_rom_3: expression_generator was trained on it")) << told[0];
  learnt.take = "rom_3";
  for (const std::string& note : make_study(std::vector{learnt}, face(), {.pairs = 6}).notes)
    EXPECT_EQ(note.find("was trained on it"), std::string::npos) << note;
  EXPECT_TRUE(told[1].starts_with("posing: the model of made was trained on it")) << told[1];
}

TEST(Study, ASideIsServedByTheAuWithoutASideAndWhatTheFaceLacksIsNoted) {
  const std::vector<AuRecording> recordings{posing(6, 2)};
  const Study study = make_study(recordings, face(), {.pairs = 6});
  EXPECT_EQ(study.aus, (std::vector<std::string>{"AU1L", "AU1R", "AU4L", "AU12L", "AU12R", "AU27"}));
  ASSERT_EQ(study.notes.size(), 1u);
  EXPECT_NE(study.notes.front().find("mouthLeft"), std::string::npos) << study.notes.front();
  AuMatrix row(1, 2);
  row << 0.5F, 1.9F;
  const AuMatrix shown = face_intensities({"AU1", "AU45"}, row, face());
  const auto value = [&](const char* name) { return shown(0, face().find_au(name) - face().aus().data()); };
  EXPECT_FLOAT_EQ(value("AU1L"), 0.5F);
  EXPECT_FLOAT_EQ(value("AU1R"), 0.5F);
  EXPECT_FLOAT_EQ(value("AU45R"), 1.0F) << "a closed lid closes no further";
  EXPECT_FLOAT_EQ(value("AU12L"), 0.0F);
}

TEST(Study, NoBlinkTellsTheRecordedCourse) {
  AuSeries series = test::posing_series(8, 7);
  series.names.push_back("AU45");
  for (std::size_t f = 0; f < series.frames.size(); ++f)
    series.intensities[f].push_back(f % 40 < 10 ? std::sin(0.1 * 3.14159 * static_cast<double>(f % 40)) : 0.0);
  const std::vector<AuRecording> recordings{record_of("blinking", series, test::kPosingRateHz)};
  for (const bool own_lids : {false, true}) {
    const Study study = make_study(recordings, face(), {.pairs = 12, .own_lids = own_lids});
    const auto lid = std::find(study.aus.begin(), study.aus.end(), "AU45L") - study.aus.begin();
    ASSERT_LT(lid, static_cast<std::ptrdiff_t>(study.aus.size()));
    std::size_t alike = 0;
    for (const StudyTrial& trial : study.trials)
      alike += study.clips[trial.left_clip].col(lid) == study.clips[trial.right_clip].col(lid) ? 1 : 0;
    if (own_lids) {
      EXPECT_LT(alike, study.trials.size() / 2);
    } else {
      EXPECT_EQ(alike, study.trials.size());
    }
  }
}

TEST(Study, SeedTakesPartWhereItsWeightsAreGiven) {
  const std::vector<AuRecording> recordings{posing(8, 3)};
  const Safetensors weights = test::made_seed_weights();
  const StudyOptions options{.pairs = 20, .seed = 4, .seed_weights = &weights, .seed_weights_place = "made"};
  const Study study = make_study(recordings, face(), options);
  EXPECT_EQ(study.kinds, (std::vector<std::string>{"real", "expression_generator", "seed", "minimum_jerk"}));
  std::set<std::size_t> seen;
  for (const StudyTrial& trial : study.trials) seen.insert({trial.left_kind, trial.right_kind});
  EXPECT_EQ(seen.size(), 4u);
  const bool is_said = std::any_of(study.notes.begin(), study.notes.end(),
                                   [](const std::string& note) { return note.find("seed does not know") == 0; });
  EXPECT_TRUE(is_said) << "AU4L is among its AUs, AU12L is not";
}

TEST(Study, ClipsAreSharedAndTheirOrderSaysNothingOfTheKinds) {
  const std::vector<AuRecording> recordings{posing(14, 5)};
  const Study study = make_study(recordings, face(), {.pairs = 40, .seed = 2});
  std::vector<std::set<std::size_t>> kinds_of_clip(study.clips.size());
  for (const StudyTrial& trial : study.trials) {
    kinds_of_clip[trial.left_clip].insert(trial.left_kind);
    kinds_of_clip[trial.right_clip].insert(trial.right_kind);
  }
  std::size_t changes = 0;
  for (std::size_t k = 0; k < study.clips.size(); ++k) {
    ASSERT_EQ(kinds_of_clip[k].size(), 1u) << "a clip is of one kind, and shown";
    changes += k > 0 && kinds_of_clip[k] != kinds_of_clip[k - 1] ? 1 : 0;
  }
  // Of three kinds in random order two of three neighbours differ; a run of each kind would change twice.
  EXPECT_GT(changes, study.clips.size() / 3);
}

TEST(Study, ASeriesWithoutRestsAndTooManyPairsAreRefused) {
  const std::vector<AuRecording> still{record_of("still", {{"AU12L"}, {0, 1, 2}, {{0.1}, {0.1}, {0.1}}}, 60)};
  EXPECT_THROW(make_study(still, face(), {}), UserError);
  EXPECT_THROW(make_study({}, face(), {}), UserError);
  const std::vector<AuRecording> few{posing(4, 6)};
  try {
    make_study(few, face(), {.pairs = 500});
    FAIL() << "500 pairs of five transitions";
  } catch (const UserError& error) {
    EXPECT_NE(std::string(error.what()).find("--pairs: 500 pairs of"), std::string::npos) << error.what();
  }
  EXPECT_THROW(make_study(few, face(), {.pairs = 0}), UserError);
}

}  // namespace
}  // namespace risorius
