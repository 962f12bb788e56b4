// The page as a participant meets it: its scripts are run by node, without a browser.
#include "replay/study/study_page.h"

#include <array>
#include <fstream>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <optional>

#include "generate/made_seed_weights.h"
#include "replay/study/study_score.h"
#include "solve/faces/builtin_face.h"
#include "support/posing_series.h"
#include "support/process.h"
#include "support/test_data.h"

namespace risorius {
namespace {

const FaceModel& face() {
  static const FaceModel model = builtin_face();
  return model;
}

const Study& study() {
  static const Study made = [] {
    const std::vector<AuRecording> recordings{
        record_of("posing, \"twice\"", test::posing_series(9, 8), test::kPosingRateHz)};
    const Safetensors weights = test::made_seed_weights();
    return make_study(recordings, face(),
                      {.pairs = 15, .seed = 3, .seed_weights = &weights, .seed_weights_place = "made"});
  }();
  return made;
}

std::filesystem::path written(const test::TemporaryFolder& folder, const std::string& page) {
  const auto path = folder.path() / "page.html";
  std::ofstream(path) << page;
  return path;
}

TEST(StudyPage, IsOneFileThatNamesNoKindAndAsksForNothing) {
  const std::string page = study_page(study(), face());
  for (const char* word : {"expression_generator", "minimum_jerk", "\"seed\"", "\"real\"", "{{",
                           "http:", "https:", "src=", "<link", "import ", "fetch("})
    EXPECT_EQ(page.find(word), std::string::npos) << word;
  EXPECT_EQ(page, study_page(study(), face())) << "the same bytes";
  EXPECT_LT(page.size(), 3'000'000u);
}

TEST(StudyPage, TheConsentLineIsText) {
  const std::string page = study_page(study(), face(), "Ethics board <b>7</b> & {{face}}");
  EXPECT_NE(page.find("Ethics board &lt;b&gt;7&lt;/b&gt; &amp; {{face}}"), std::string::npos);
  EXPECT_EQ(page.find("I take part voluntarily"), std::string::npos);
}

/// What tests/replay/study/take_part.mjs saw and answered; it takes part once for all tests.
class StudyPageInNode : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (test::run({"sh", "-c", "node --version"}).exit_code != 0) return;
    const test::TemporaryFolder folder;
    const auto page = written(folder, study_page(study(), face())), csv = folder.path() / "answers.csv";
    const auto script = std::filesystem::path(RISORIUS_SOURCE_DIR) / "tests/replay/study/take_part.mjs";
    run_ = test::run({"node", script.string(), page.string(), csv.string()});
    if (run_->exit_code == 0) answers_ = load_study_answers(std::vector{csv});
  }
  void SetUp() override {
    if (!run_) GTEST_SKIP() << "there is no node here";
    ASSERT_EQ(run_->exit_code, 0) << run_->output;
    seen_ = nlohmann::json::parse(run_->output);
  }
  static inline std::optional<test::Finished> run_;
  static inline std::vector<StudyAnswer> answers_;
  nlohmann::json seen_;
};

TEST_F(StudyPageInNode, AnswersBecomeACsvThatIsScored) {
  const std::vector<StudyAnswer>& read = answers_;
  ASSERT_EQ(read.size(), study().trials.size());
  std::size_t ties = 0;
  for (std::size_t i = 0; i < read.size(); ++i) {
    const StudyTrial& trial = study().trials[i];
    EXPECT_EQ(read[i].pair, i + 1);
    EXPECT_EQ(read[i].left, study().kinds[trial.left_kind]);
    EXPECT_EQ(read[i].right, study().kinds[trial.right_kind]);
    EXPECT_EQ(read[i].transition, study().transitions[trial.transition]);
    EXPECT_EQ(read[i].participant, "P-07");
    EXPECT_EQ(read[i].seed, study().seed);
    // take_part.mjs answers left, right, same in turn, and plays every fourth once more.
    EXPECT_EQ(static_cast<std::size_t>(read[i].choice), i % 3);
    EXPECT_EQ(read[i].replays, i % 4 == 0 ? 1u : 0u);
    const double clip_s = static_cast<double>(study().clips[trial.left_clip].rows()) / study().rate_hz;
    EXPECT_GT(read[i].seconds, clip_s) << "nobody answers before the end";
    EXPECT_LT(read[i].seconds, 2 * (clip_s + 2));
    ties += read[i].choice == StudyChoice::kSame ? 1 : 0;
  }
  const auto scores = score_study(read);
  EXPECT_EQ(scores.size(), 5u);
  std::size_t all = 0;
  for (const ComparisonScore& score : scores) all += score.first_preferred + score.second_preferred + score.ties;
  EXPECT_EQ(all, study().trials.size());
  EXPECT_EQ(ties, study().trials.size() / 3);
}

TEST_F(StudyPageInNode, NothingNamesAKindBeforeTheEnd) {
  ASSERT_GT(seen_.at("texts").size(), study().trials.size()) << "at least the progress of each pair";
  for (const std::string text : seen_.at("texts")) {
    for (const std::string& kind : study().kinds) {
      // The question itself says "real".
      if (kind != "real") {
        EXPECT_EQ(text.find(kind), std::string::npos) << text;
      }
    }
    for (const std::string& transition : study().transitions) EXPECT_EQ(text.find(transition), std::string::npos);
  }
}

TEST_F(StudyPageInNode, AReloadLosesNothingAndNobodyBeginsWithoutCodeAndConsent) {
  EXPECT_EQ(seen_.at("reloaded_at"), 7);
  EXPECT_EQ(seen_.at("welcome"), "Welcome back: 7 of 15 pairs are answered.");
  EXPECT_NE(seen_.at("without_code"), "");
  EXPECT_NE(seen_.at("bad_code"), "");
  EXPECT_NE(seen_.at("without_consent"), "");
  EXPECT_EQ(seen_.at("file"), "answers-" + seen_.at("page").get<std::string>() + "-P-07.csv");
  EXPECT_TRUE(seen_.at("shown_for_copying").get<bool>());
  EXPECT_EQ(seen_.at("after_next"), "") << "the next participant's code is his own";
}

TEST_F(StudyPageInNode, DrawsTheFaceAsItIs) {
  // Clip 0 in its 41st frame: rest and moved places of every seventh vertex that the page draws.
  Eigen::VectorXd intensities = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(face().aus().size()));
  for (std::size_t k = 0; k < study().aus.size(); ++k) {
    intensities[face().find_au(study().aus[k]) - face().aus().data()] =
        static_cast<double>(study().clips[0](40, static_cast<Eigen::Index>(k)));
  }
  const Eigen::Matrix3Xd moved = face().deformed_mm(intensities), &rest = face().vertices_mm();
  ASSERT_GT((moved - rest).colwise().norm().maxCoeff(), 1) << "a frame that moves something";
  const auto& places = seen_.at("places");
  ASSERT_GT(places.size(), 500u);
  for (const auto& place : places) {
    const auto values = place.get<std::array<double, 6>>();
    const Eigen::Vector3d at_rest(values.data()), at_move(values.data() + 3);
    const double off_mm =
        ((rest.colwise() - at_rest).colwise().squaredNorm() + (moved.colwise() - at_move).colwise().squaredNorm())
            .minCoeff();
    ASSERT_LT(std::sqrt(off_mm), 0.03) << at_rest.transpose();
  }
}

}  // namespace
}  // namespace risorius
