// risorius rom --connect: poses asked for live, of a performer who plays a range of motion into a running daemon.
#include <algorithm>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <string>

#include "support/process.h"
#include "support/test_data.h"
#include "system/running_daemon.h"

namespace risorius::test {
namespace {

TEST(RomLive, AsksForPosesAndChecksEach) {
  TemporaryFolder folder;
  const std::string tool = program("risorius").string();
  const auto take = (folder.path() / "rom.c3d").string(), table = (folder.path() / "poses.csv").string();
  // The inner brows rise once, for a second and a half, late enough for a slow machine to have begun to listen; the jaw
  // never goes sideways.
  const auto curve = (folder.path() / "brows.csv").string();
  {
    std::ofstream file(curve);
    file << "Frame,AU1L,AU1R\n";
    for (int frame = 0; frame < 780; ++frame) {
      const double x = std::clamp(std::min((frame - 180) / 24.0, (296 - frame) / 24.0), 0.0, 1.0);
      file << frame << ',' << x << ',' << 0.9 * x << '\n';
    }
  }
  const auto made = run({tool, "perform", "--au", curve, "--au-rate", "60", "--rate", "60", "-o", take});
  ASSERT_EQ(made.exit_code, 0) << made.output;
  RunningDaemon daemon(folder.path(),
                       "[[source]]\nname = \"face\"\nlisten = \"udp://127.0.0.1:0\"\nrig = \"builtin\"\n", "",
                       Recording::kOff);
  ASSERT_TRUE(daemon.up());
  Process rom({tool, "rom", "--connect", daemon.publish(), "--seconds", "6", "--tries", "1", "--pose", "AU1", "--pose",
               "AU30R", "-o", table});
  const auto played = run({tool, "replay", take, "--to", daemon.input("face")});
  ASSERT_EQ(played.exit_code, 0) << played.output;
  const auto asked = rom.finish();
  EXPECT_EQ(asked.exit_code, 0) << asked.output;
  EXPECT_NE(asked.output.find("1/2 AU1 inner brow raiser, both sides"), std::string::npos) << asked.output;
  EXPECT_NE(asked.output.find("2 of 3 AUs seen"), std::string::npos) << asked.output;
  std::ifstream file(table);
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  EXPECT_NE(text.find("AU1,AU1L,"), std::string::npos) << text;
  EXPECT_NE(text.find("AU30R,AU30R,"), std::string::npos) << text;
  EXPECT_NE(text.find("not seen: again"), std::string::npos) << text;
}

TEST(RomLive, SaysWhatIsWrong) {
  TemporaryFolder folder;
  const std::string tool = program("risorius").string();
  const auto refused = [&](std::vector<std::string> command, const std::string& word) {
    command.insert(command.begin(), {tool, "rom"});
    const auto finished = run(command);
    EXPECT_NE(finished.exit_code, 0);
    EXPECT_NE(finished.output.find(word), std::string::npos) << finished.output;
  };
  refused({}, "give --rig RIG, or --connect");
  refused({"--connect", "tcp://127.0.0.1:1", "builtin:1"}, "choose one");
  refused({"--connect", "nowhere"}, "cannot be connected to");
  refused({"--connect", "tcp://127.0.0.1:1", "-o", (folder.path() / "none" / "x.csv").string()}, "no folder");
  refused({"--connect", "tcp://127.0.0.1:1", "--seconds", "1"}, "no AU frames for 1 s");
}

}  // namespace
}  // namespace risorius::test
