#include "daemon/config.h"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>

#include "capture/errors.h"
#include "support/test_data.h"

namespace risorius {
namespace {

std::string error_of(const std::string& toml) {
  try {
    parse_config(toml, "test.toml");
  } catch (const UserError& error) {
    return error.what();
  }
  return "";
}

TEST(Config, EmptyFileIsTheDefault) {
  EXPECT_EQ(print_config(parse_config("", "empty.toml")), print_config(default_config()));
}

TEST(Config, PrintedConfigurationReadsBackEqual) {
  Config config = default_config();
  config.sources[0].name = "left";
  config.sources.push_back(config.sources[0]);
  config.sources[1].name = "right";
  config.sources[1].listen = "zmq+tcp://127.0.0.1:7010";
  config.sources[1].rig = "a \"quoted\" \\ path.json";
  config.sources[1].stages.pipeline.fill.max_gap_ns = 123'456'789;
  config.sources[1].stages.pipeline.despike.method = DespikeMethod::kDisplacement;
  config.output.status_interval_s = 0.1;
  config.latency.awake_share = 0.02;
  const std::string printed = print_config(config);
  EXPECT_EQ(print_config(parse_config(printed, "printed.toml")), printed);
  EXPECT_EQ(parse_config(printed, "printed.toml").sources[1].stages.pipeline.fill.max_gap_ns, 123'456'789);
  EXPECT_EQ(parse_config(printed, "printed.toml").latency.awake_share, 0.02);
  EXPECT_THROW(parse_config("[latency]\nawake_share = 1.5\n", "much.toml"), UserError);
}

TEST(Config, RecordedWithASessionIsReadForItsStages) {
  Config config = default_config();
  config.sources[0].stages.pipeline.fill.max_gap_ns = 123'456'789;
  const StageConfig stages = parse_stage_config(print_config(config), "session.mcap: config", config.sources[0].name);
  EXPECT_EQ(stages.pipeline.fill.max_gap_ns, 123'456'789);
}

TEST(Config, StageTablesAtTheTopHoldForAllSourcesUnlessOverridden) {
  const Config config = parse_config(
      "[fill]\nmax_gap_s = 1.5\nmethod = \"hold\"\n[[source]]\nname = \"a\"\nlisten = \"udp://127.0.0.1:1\"\n"
      "[[source]]\nname = \"b\"\nlisten = \"udp://127.0.0.1:2\"\n[source.fill]\nmethod = \"none\"\n",
      "t");
  ASSERT_EQ(config.sources.size(), 2u);
  EXPECT_EQ(config.sources[0].stages.pipeline.fill.method, FillMethod::kHold);
  EXPECT_EQ(config.sources[1].stages.pipeline.fill.method, FillMethod::kNone);
  EXPECT_EQ(config.sources[1].stages.pipeline.fill.max_gap_ns, 1'500'000'000);
}

TEST(Config, NamesKeyValueAndRemedyOfEveryProblem) {
  const std::string error =
      error_of("[solve]\nridge = \"much\"\nnoise_mm = 99\nrobust_iterations = 1.5\n[despike]\nmethod = \"magic\"\n");
  for (const char* part : {"4 problems", "solve.ridge", "much", "solve.noise_mm", "99", "0.001 to 10",
                           "robust_iterations", "whole number", "despike.method", "magic", "\"displacement\""}) {
    EXPECT_NE(error.find(part), std::string::npos) << part << " in: " << error;
  }
}

TEST(Config, ChecksWhatNatnetSourcesAreTold) {
  const Config config = parse_config(
      "[[source]]\nlisten = \"natnet://192.168.1.5\"\nnatnet_markers = \"set:face\"\nnatnet_data_port = 1600\n"
      "natnet_multicast_group = \"239.1.2.3\"\nnatnet_local_address = \"10.0.0.2\"\nnatnet_timecode = \"30df\"\n",
      "t");
  EXPECT_EQ(config.sources[0].natnet_markers, "set:face");
  EXPECT_EQ(config.sources[0].natnet_data_port, 1600);
  EXPECT_TRUE(parse_natnet_timecode(config.sources[0].natnet_timecode)->drop_frame);
  const std::string error = error_of(
      "[[source]]\nlisten = \"natnet://10.0.0.1\"\nnatnet_markers = \"set:\"\nnatnet_data_port = "
      "65536\nnatnet_multicast_group = \"10.0.0.1\"\n"
      "natnet_local_address = \"here\"\nnatnet_timecode = \"29.97\"\n");
  for (const char* part : {"5 problems", "natnet_markers", "\"set:NAME\"", "natnet_data_port", "natnet_multicast_group",
                           "239.255.42.99", "natnet_local_address", "here", "natnet_timecode", "30df"}) {
    EXPECT_NE(error.find(part), std::string::npos) << part << " in: " << error;
  }
}

TEST(Config, ReadsWhatQtmAndViconSourcesNeed) {
  const Config config = parse_config(
      "[[source]]\nname = \"q\"\nlisten = \"qtm://10.0.0.7\"\nqtm_frames = \"udp\"\n"
      "[[source]]\nname = \"v\"\nlisten = \"vicon://10.0.0.8\"\nvicon_subject = \"Anna\"\nvicon_rate_hz = 59.94\n",
      "t");
  EXPECT_EQ(config.sources[0].qtm_frames, "udp");
  EXPECT_EQ(config.sources[1].vicon_subject, "Anna");
  EXPECT_EQ(config.sources[1].vicon_rate_hz, 59.94);
  const std::string printed = print_config(config);
  EXPECT_EQ(print_config(parse_config(printed, "printed.toml")), printed);
  const std::string subject = "[[source]]\nlisten = \"vicon://10.0.0.8\"\nname = ";
  EXPECT_EQ(error_of(subject + "\"a\"\n" + subject + "\"b\"\n"), "") << "two subjects of one server";
  const std::string error =
      error_of("[[source]]\nlisten = \"qtm://10.0.0.7\"\nqtm_frames = \"pigeon\"\nvicon_rate_hz = -1\n");
  for (const char* part : {"2 problems", "source[0].qtm_frames", "pigeon", "vicon_rate_hz", "-1"})
    EXPECT_NE(error.find(part), std::string::npos) << part << " in: " << error;
}

TEST(Config, RefusesKeysOfAnotherProtocol) {
  const std::string error =
      error_of("[[source]]\nqtm_frames = \"udp\"\nnatnet_markers = \"labelled\"\nvicon_subject = \"\"\n");
  for (const char* part : {"2 problems", "source[0].qtm_frames", "qtm://", "source[0].natnet_markers", "natnet://",
                           "udp://127.0.0.1:7000", "leave it out"})
    EXPECT_NE(error.find(part), std::string::npos) << part << " in: " << error;
}

TEST(Config, FollowsATrackerOnlyWhereOneTellsItsRecording) {
  const std::string follow = "[record]\nfolder = \"d\"\nfollow = \"tracker\"\n";
  EXPECT_NE(error_of(follow).find("record.follow"), std::string::npos) << error_of(follow);
  EXPECT_NE(error_of(follow + "[[source]]\nlisten = \"vicon://10.0.0.8\"\n").find("nothing would be recorded"),
            std::string::npos);
  EXPECT_EQ(error_of(follow + "[[source]]\nlisten = \"qtm://10.0.0.8\"\n"), "");
}

TEST(Config, RefusesUnknownKeysEverywhere) {
  for (const char* toml : {"colour = 1", "[output]\npublsh = \"x\"", "[[source]]\nporte = 3",
                           "[[source]]\n[source.fill]\nmax_gap = 3", "[fil]\n"}) {
    EXPECT_NE(error_of(toml).find("unknown key"), std::string::npos) << toml;
  }
}

TEST(Config, RefusesSourcesThatShareNameOrPort) {
  const std::string one = "[[source]]\nname = \"a\"\nlisten = \"udp://127.0.0.1:7000\"\n";
  EXPECT_NE(error_of(one + one).find("2 problems"), std::string::npos);
  EXPECT_NE(error_of("source = 5").find("[[source]]"), std::string::npos);
}

TEST(Config, RefusesAddressesThatCannotBeBoundTogether) {
  const auto source = [](const std::string& name, const std::string& listen) {
    return "[[source]]\nname = \"" + name + "\"\nlisten = \"" + listen + "\"\n";
  };
  const auto output = [](const std::string& publish, const std::string& control) {
    return "[output]\npublish = \"" + publish + "\"\ncontrol = \"" + control + "\"\n";
  };
  const std::string far = "tcp://127.0.0.1:7001", near = "tcp://127.0.0.1:7002";
  const std::string error = error_of(output(far, near) + source("a", "zmq+tcp://127.0.0.1:7001"));
  for (const char* part : {"1 problem", "source[0].listen", "zmq+tcp://127.0.0.1:7001", "output.publish", far.c_str()})
    EXPECT_NE(error.find(part), std::string::npos) << part << " in: " << error;
  for (const std::string& toml :
       {output(far, far), output(far, "tcp://*:7001"), output(far, near) + source("a", "zmq+tcp://0.0.0.0:7002"),
        output("tcp://localhost:7003", near) + source("a", "zmq+tcp://127.0.0.1:7003"),
        output("ipc:///tmp/a", "ipc:///tmp/a"),
        source("a", "udp://0.0.0.0:11111") + source("b", "livelink://127.0.0.1"),
        source("a", "natnet://10.0.0.5") + source("b", "natnet://10.0.0.5")})
    EXPECT_NE(error_of(toml).find("1 problem"), std::string::npos) << toml << error_of(toml);
  for (const std::string& toml :
       {output("tcp://127.0.0.1:*", "tcp://127.0.0.1:*") + source("a", "zmq+tcp://127.0.0.1:0"),
        output(far, near) + source("a", "udp://127.0.0.1:7001"), output(far, "tcp://10.0.0.5:7001"),
        source("a", "udp://127.0.0.1:0") + source("b", "udp://127.0.0.1:0"),
        source("a", "qtm://10.0.0.5") + source("b", "qtm://10.0.0.5")})
    EXPECT_EQ(error_of(toml), "") << toml;
}

TEST(Config, IsARegularFileOfAtMostAMebibyte) {
  const auto refusal = [](const std::filesystem::path& path) {
    try {
      load_config(path);
    } catch (const UserError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const test::TemporaryFolder folder;
  const auto large = folder.path() / "large.toml";
  std::ofstream(large) << std::string((1 << 20) + 1, '\n');
  EXPECT_NE(refusal(large).find("has 1048577 bytes"), std::string::npos) << refusal(large);
  for (const std::filesystem::path& path : {std::filesystem::path("/dev/zero"), folder.path(), large})
    EXPECT_NE(refusal(path).find("a regular file of at most 1 MiB"), std::string::npos) << refusal(path);
  EXPECT_NE(refusal(folder.path() / "none.toml").find("cannot be read"), std::string::npos);
  std::filesystem::resize_file(large, 1 << 20);
  EXPECT_EQ(refusal(large), "");
}

TEST(Config, SaysWhereTheTomlIsBroken) {
  EXPECT_NE(error_of("[output]\npublish = \n").find("test.toml, line 2"), std::string::npos);
}

}  // namespace
}  // namespace risorius
