// The offline tool as users call it: what it must refuse, with one clear message and nothing lost.
#include <algorithm>
#include <csignal>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <string>
#include <unistd.h>

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

TEST(Tool, MakesATransitionOfTwoPosesInOneCall) {
  TemporaryFolder folder;
  const std::string tool = program("risorius").string();
  const auto smile = folder.path() / "smile.csv", next = folder.path() / "next.csv";
  const auto made =
      run({tool, "transition", "--from", "neutral", "--to", "happy", "--frames", "50", "-o", smile.string()});
  ASSERT_EQ(made.exit_code, 0) << made.output;
  std::ifstream file(smile);
  std::string line, last;
  int lines = 0;
  while (std::getline(file, line)) last = line, ++lines;
  EXPECT_EQ(lines, 1 + 1 + 50) << "header, start, 50 frames";
  EXPECT_NE(last.find(",0.9"), std::string::npos) << "the last frame is the target: " << last;
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "smile.png"));
  const auto on = run({tool, "transition", "--from", smile.string(), "--to", "sad:2", "-o", next.string()});
  EXPECT_EQ(on.exit_code, 0) << on.output;
  const auto timed =
      run({tool, "transition", "--from", "neutral", "--to", "happy", "--frames", "auto", "-o", next.string()});
  EXPECT_EQ(timed.exit_code, 0) << timed.output;
  EXPECT_NE(timed.output.find("as long as a face is expected to take"), std::string::npos) << timed.output;
  const auto onto_itself =
      run({tool, "transition", "--from", smile.string() + ":3", "--to", "sad", "-o", smile.string()});
  EXPECT_NE(onto_itself.exit_code, 0);
  EXPECT_NE(onto_itself.output.find("is to be read and to be written"), std::string::npos) << onto_itself.output;
  for (const std::vector<std::string>& bad :
       {std::vector<std::string>{"--from", "furious", "--to", "happy"},
        {"--from", "neutral", "--to", "happy", "--frames", "auto", "--model", "linear"},
        {"--from", "neutral", "--to", "happy", "--frames", "some"},
        {"--from", "neutral", "--to", "happy", "--frames", "12.5"},
        {"--from", "neutral", "--to", "happy", "--model", "magic"},
        {"--from", "neutral", "--to", "happy", "--frames", "0"},
        {"--from", "neutral", "--to", "happy", "--model", "linear", "--variants", "2"}}) {
    std::vector<std::string> command{tool, "transition", "-o", (folder.path() / "bad.csv").string()};
    command.insert(command.end(), bad.begin(), bad.end());
    EXPECT_NE(run(command).exit_code, 0) << bad[1];
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "bad.csv"));
  }
}

TEST(Tool, SaysHowFarAFreeNeutralIsFromTheRigs) {
  TemporaryFolder folder;
  const std::string tool = program("risorius").string();
  const auto out = folder.path() / "ds";
  const std::vector<std::string> command{tool, "dataset", "builtin:1", "--rig", "builtin", "--free-neutral", "-o", out};
  EXPECT_NE(run(command).exit_code, 0) << "it needs --joint";
  std::vector<std::string> joint = command;
  joint.push_back("--joint");
  const auto made = run(joint);
  ASSERT_EQ(made.exit_code, 0) << made.output;
  EXPECT_NE(made.output.find("neutral found with the take's AUs, markers moved by"), std::string::npos) << made.output;
  EXPECT_NE(bytes_of(out / "builtin" / "rig.json").find("neutral found with"), std::string::npos);
}

TEST(Tool, RefusesAnOutputThatItCannotWriteBeforeTheWork) {
  TemporaryFolder folder;
  const std::string tool = program("risorius").string();
  const auto in_folder = [&](const char* name) { return (folder.path() / name).string(); };
  struct Case {
    std::string output, word;
  };
  for (const auto& [output, word] :
       {Case{in_folder("o_x.txt"), ".c3d or .csv"}, Case{"", "is empty"}, Case{in_folder("none/x.c3d"), "no folder"}}) {
    const auto refused = run({tool, "clean", "builtin:1", "-o", output});
    EXPECT_NE(refused.exit_code, 0) << output;
    EXPECT_NE(refused.output.find(word), std::string::npos) << refused.output;
    EXPECT_EQ(refused.output.find("repair"), std::string::npos) << "before the work: " << refused.output;
  }
  const auto refused = run({tool, "transition", "--from", "neutral", "--to", "happy", "-o", in_folder("x.txt")});
  EXPECT_NE(refused.exit_code, 0);
  EXPECT_NE(refused.output.find(".csv"), std::string::npos) << refused.output;
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Tool, WarnsOfANeutralOfOneFrameForAnActorToo) {
  TemporaryFolder folder;
  const std::string tool = program("risorius").string();
  const auto rig = (folder.path() / "rig.json").string(), anna = (folder.path() / "anna").string();
  ASSERT_EQ(run({tool, "rig", "fit", "--neutral", "builtin:0-60", "--landmarks", "iemocap55", "-o", rig}).exit_code, 0);
  ASSERT_EQ(run({tool, "actor", "new", anna, "--rig", rig}).exit_code, 0);
  const auto few = run({tool, "actor", "neutral", anna, "builtin:5-5"});
  EXPECT_EQ(few.exit_code, 0) << few.output;
  EXPECT_NE(few.output.find("warning: a neutral of 1 frame carries"), std::string::npos) << few.output;
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

TEST(Tool, NamesTheSubcommandsThatThereAre) {
  const std::string tool = program("risorius").string();
  const auto refused = run({tool, "foo"});
  EXPECT_NE(refused.exit_code, 0);
  EXPECT_NE(refused.output.find("\"foo\" is no subcommand"), std::string::npos) << refused.output;
  EXPECT_NE(refused.output.find("dataset"), std::string::npos) << refused.output;
  EXPECT_NE(run({tool, "rig", "foo"}).output.find("calibrate"), std::string::npos);
  EXPECT_EQ(run({tool, "dataset", "--help"}).exit_code, 0);
}

TEST(Tool, RefusesNumbersThatAreNone) {
  TemporaryFolder folder;
  const auto out = (folder.path() / "y.csv").string();
  for (const std::vector<std::string>& option : {std::vector<std::string>{"--seed", "-1"},
                                                 {"--seconds", "nan"},
                                                 {"--noise", "nan"},
                                                 {"--rate", "1e9"},
                                                 {"--au-rate", "nan"}}) {
    const auto refused = run({program("risorius").string(), "perform", option[0], option[1], "-o", out});
    EXPECT_NE(refused.exit_code, 0) << option[0];
    EXPECT_NE(refused.output.find("\"" + option[1] + "\" is not a"), std::string::npos) << refused.output;
    EXPECT_FALSE(std::filesystem::exists(out));
  }
}

TEST(Tool, FailsWhereNotOneFrameOfADatasetCouldBeSolvedAndSaysWhy) {
  TemporaryFolder folder;
  const std::string tool = program("risorius").string();
  const auto take = (folder.path() / "take.csv").string();
  ASSERT_EQ(run({tool, "perform", "--script", "idle", "--seconds", "1", "-o", take}).exit_code, 0);
  const auto dataset = [&](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> command{tool, "dataset", take, "--rig", "builtin", "-o", (folder.path() / name).string()};
    command.insert(command.end(), more.begin(), more.end());
    return run(command);
  };
  EXPECT_EQ(dataset("right", {}).exit_code, 0);
  const auto mirrored = dataset("mirrored", {"--axes", "RUF"});
  EXPECT_NE(mirrored.exit_code, 0);
  EXPECT_NE(mirrored.output.find("120 mirrored (turn one letter of --axes round"), std::string::npos)
      << mirrored.output;
  const auto large = dataset("large", {"--units", "cm"});
  EXPECT_NE(large.exit_code, 0);
  EXPECT_NE(large.output.find("not one frame could be solved"), std::string::npos) << large.output;
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "large" / "manifest-sha256.txt"));  // nothing is lost
}

TEST(Tool, ReadsAStretchOfATakeIntoADataset) {
  TemporaryFolder folder;
  const std::string tool = program("risorius").string();
  const auto take = (folder.path() / "take.csv").string(), out = (folder.path() / "out").string();
  ASSERT_EQ(run({tool, "perform", "--script", "idle", "--seconds", "1", "-o", take}).exit_code, 0);
  const auto made = run({tool, "dataset", take + ":30-89", "--rig", "builtin", "-o", out});
  EXPECT_EQ(made.exit_code, 0) << made.output;
  const std::string aus = bytes_of(std::filesystem::path(out) / "take" / "au.csv");
  EXPECT_EQ(std::count(aus.begin(), aus.end(), '\n'), 61);
  EXPECT_NE(aus.find("\n30,"), std::string::npos);
  const auto beyond = run({tool, "dataset", take + ":30-120", "--rig", "builtin", "-o", out + "2"});
  EXPECT_NE(beyond.exit_code, 0);
  EXPECT_NE(beyond.output.find("the take ends after 120 frames"), std::string::npos) << beyond.output;
}

TEST(Tool, ATakeNamedLikeAFileOfTheDatasetGetsAnotherFolder) {
  TemporaryFolder folder;
  const std::string tool = program("risorius").string();
  const auto take = (folder.path() / "README.md.csv").string(), out = (folder.path() / "out").string();
  ASSERT_EQ(run({tool, "perform", "--script", "idle", "--seconds", "0.5", "-o", take}).exit_code, 0);
  const auto made = run({tool, "dataset", take, "--rig", "builtin", "--causal", "-o", out});
  EXPECT_EQ(made.exit_code, 0) << made.output;
  EXPECT_TRUE(std::filesystem::is_regular_file(std::filesystem::path(out) / "README.md"));
  EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(out) / "README.md-2" / "au.csv"));
}

TEST(Tool, LeavesNothingHalfWrittenBehindWhenInterrupted) {
  TemporaryFolder folder;
  const auto take = (folder.path() / "take.csv").string();
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"perform", "--script", "speech", "--seconds", "3000", "-o", take},
        {"dataset", "builtin:3000", "--rig", "builtin", "--causal", "-o", (folder.path() / "out").string()}}) {
    std::vector<std::string> whole{program("risorius").string()};
    whole.insert(whole.end(), command.begin(), command.end());
    Process process(whole);
    const auto begun = [&] { return !std::filesystem::is_empty(folder.path()); };
    for (int i = 0; i < 3000 && !begun(); ++i) usleep(20'000);
    ASSERT_TRUE(begun());
    usleep(300'000);  // into the frames
    process.send_signal(SIGINT);
    EXPECT_EQ(process.finish().exit_code, -1);
    EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << command[0];
  }
}

TEST(Tool, RefusesOneRecordingForTwoAus) {
  TemporaryFolder folder;
  const auto refused =
      run({program("risorius").string(), "rig", "calibrate", "--neutral", "builtin:0-60", "--landmarks", "iemocap55",
           "--au", "AU12L=builtin:0-60", "--au", "AU12R=builtin:0-60", "-o", (folder.path() / "r.json").string()});
  EXPECT_NE(refused.exit_code, 0);
  EXPECT_NE(refused.output.find("is given for AU12L already"), std::string::npos) << refused.output;
}

}  // namespace
}  // namespace risorius::test
