// risorius study as users call it: a page of series, the scores of answers, and what it must refuse.
#include <fstream>
#include <gtest/gtest.h>

#include "replay/takes/csv_text.h"
#include "support/posing_series.h"
#include "support/process.h"
#include "support/test_data.h"
#include "system/stream_checks.h"

namespace risorius::test {
namespace {

Finished study(std::vector<std::string> words) {
  words.insert(words.begin(), {program("risorius").string(), "study"});
  return run(words);
}

class StudyTool : public ::testing::Test {
 protected:
  std::string path(const char* name) const { return (folder_.path() / name).string(); }
  std::string write(const char* name, const std::string& text) const {
    std::ofstream(path(name)) << text;
    return path(name);
  }
  std::string series(const char* name, std::uint64_t seed) const {
    const AuSeries posing = posing_series(8, seed);
    std::string text = "Frame";
    for (const std::string& au : posing.names) text.append(",").append(au);
    for (std::size_t f = 0; f < posing.frames.size(); ++f) {
      text.append("\n").append(std::to_string(f));
      for (const double value : posing.intensities[f]) {
        text += ',';
        append_number(text, value);
      }
    }
    return write(name, text + "\n");
  }
  TemporaryFolder folder_;
};

TEST_F(StudyTool, TheSameSeedMakesTheSamePage) {
  const std::string first = series("first.csv", 1), second = series("second.csv", 2);
  for (const auto& [page, seed] : {std::pair{"a.html", "5"}, std::pair{"b.html", "5"}, std::pair{"c.html", "6"}}) {
    const auto made = study({first, second, "--rate", "60", "--pairs", "12", "--seed", seed, "-o", path(page)});
    ASSERT_EQ(made.exit_code, 0) << made.output;
    EXPECT_NE(made.output.find("12 pairs"), std::string::npos) << made.output;
    EXPECT_NE(made.output.find("the face does not show mouthLeft"), std::string::npos) << made.output;
  }
  EXPECT_EQ(bytes_of_file(path("a.html")), bytes_of_file(path("b.html")));
  EXPECT_NE(bytes_of_file(path("a.html")), bytes_of_file(path("c.html")));
}

TEST_F(StudyTool, ScoresAnswersAndDrawsThem) {
  const std::string answers = write("answers.csv",
                                    "page,seed,participant,pair,transition,left,right,answer,seconds,replays\n"
                                    "p,1,A,1,t@1,real,minimum_jerk,left,2.5,0\n"
                                    "p,1,A,2,t@2,minimum_jerk,real,same,2,1\n");
  const auto scored = study({"--score", answers, "-o", path("figure.png")});
  ASSERT_EQ(scored.exit_code, 0) << scored.output;
  EXPECT_NE(scored.output.find("2 answers of 1 participant"), std::string::npos) << scored.output;
  EXPECT_NE(scored.output.find("0.0 to 79.3"), std::string::npos) << "Wilson's interval of 0 of 1: " << scored.output;
  EXPECT_EQ(bytes_of_file(path("figure.png")).substr(1, 3), "PNG");
}

TEST_F(StudyTool, RefusesWhatItCannotUse) {
  const std::string take = series("take.csv", 1), page = path("page.html");
  const std::string damaged = write("damaged.csv", "page,seed,participant\np,1,A\n");
  const std::string no_weights = write("weights.safetensors", "none");
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"-o", page}, "no AU series is given"},
      {{take, "--rate", "60"}, "-o PAGE.html"},
      {{take, "-o", page}, "--rate"},
      {{take, "--rate", "60", "--pairs", "1000", "-o", page}, "1000 pairs of"},
      {{take, "--rate", "60", "--pairs", "-1", "-o", page}, "--pairs"},
      {{take, take, "--rate", "60", "-o", page}, "is the second take named take"},
      {{take, "--rate", "60", "-o", take}, "is to be read and to be written"},
      {{take, "--rate", "60", "--seed-weights", no_weights, "-o", page}, "weights.safetensors"},
      {{path("none.csv"), "--rate", "60", "-o", page}, "none.csv"},
      {{"--score", damaged}, "no column pair"},
      {{take, "--score", damaged}, "AU series beside --score"},
      {{"--score", path("none.csv")}, "none.csv"},
  };
  for (const auto& [words, problem] : cases) {
    const auto refused = study(words);
    EXPECT_NE(refused.exit_code, 0) << problem;
    EXPECT_NE(refused.output.find(problem), std::string::npos) << "not '" << problem << "' but\n" << refused.output;
    EXPECT_FALSE(std::filesystem::exists(page)) << problem;
  }
}

}  // namespace
}  // namespace risorius::test
