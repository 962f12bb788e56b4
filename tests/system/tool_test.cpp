// The offline tool as users call it: what it must refuse, with one clear message and nothing lost.
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <string>

#include "support/process.h"
#include "support/test_data.h"
#include "system/running_daemon.h"

namespace risorius::test {
namespace {

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

TEST(Tool, NeverWritesOverWhatItReads) {
  TemporaryFolder folder;
  const std::string tool = program("risorius").string();
  const auto take = (folder.path() / "take.csv").string(), other = (folder.path() / "." / "take.csv").string();
  const auto made = run({tool, "perform", "--script", "idle", "--seconds", "1", "-o", take});
  ASSERT_EQ(made.exit_code, 0) << made.output;
  const std::string before = bytes_of(take);
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{tool, "defects", take, "-o", other},
        {tool, "defects", take, "-o", (folder.path() / "x.csv").string(), "--truth", take},
        {tool, "rig", "fit", "--neutral", take, "--landmarks", "iemocap55", "-o", take},
        {tool, "rig", "calibrate", "--neutral", "builtin:0-60", "--landmarks", "iemocap55", "--au", "AU12L=" + take,
         "-o", take},
        {tool, "perform", "--au", take, "-o", take}}) {
    const auto refused = run(command);
    EXPECT_NE(refused.exit_code, 0) << command[1];
    EXPECT_NE(refused.output.find("is to be read and to be written"), std::string::npos) << refused.output;
    EXPECT_EQ(bytes_of(take), before) << command[1];
  }
}

TEST(Tool, RefusesOutputsThatCollide) {
  TemporaryFolder folder;
  const auto out = (folder.path() / "y.csv").string();
  const auto refused = run({program("risorius").string(), "perform", "--seconds", "1", "-o", out, "--truth", out});
  EXPECT_NE(refused.exit_code, 0);
  EXPECT_NE(refused.output.find("is to be written twice"), std::string::npos) << refused.output;
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST(Tool, RefusesASeriesWithoutAnAuOfTheRig) {
  TemporaryFolder folder;
  const auto series = folder.path() / "pose.csv";
  std::ofstream(series) << "Frame,foo,bar\n0,0,0\n1,0,1\n";
  const auto refused =
      run({program("risorius").string(), "perform", "--au", series.string(), "-o", (folder.path() / "y.csv").string()});
  EXPECT_NE(refused.exit_code, 0);
  EXPECT_NE(refused.output.find("none of its columns is an AU"), std::string::npos) << refused.output;
}

TEST(Tool, RefusesACalibrationOfWhatIsNoAu) {
  TemporaryFolder folder;
  const auto refused =
      run({program("risorius").string(), "rig", "calibrate", "--neutral", "builtin:0-60", "--landmarks", "iemocap55",
           "--au", "au12l=builtin:0-60", "-o", (folder.path() / "r.json").string()});
  EXPECT_NE(refused.exit_code, 0);
  EXPECT_NE(refused.output.find("'au12l' is no AU"), std::string::npos) << refused.output;
}

}  // namespace
}  // namespace risorius::test
