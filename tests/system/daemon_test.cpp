// The daemon as its users meet it: mistakes, bad input, control messages, the documented Python client.
#include <arpa/inet.h>
#include <csignal>
#include <fstream>
#include <gtest/gtest.h>
#include <random>
#include <regex>
#include <sstream>
#include <sys/socket.h>
#include <unistd.h>

#include "replay/live/daemon_client.h"
#include "replay/live/sender.h"
#include "replay/performer/performer.h"
#include "solve/faces/builtin_face.h"
#include "support/process.h"
#include "support/test_data.h"
#include "system/running_daemon.h"

namespace risorius::test {
namespace {

const char* const kFace = "[[source]]\nname = \"face\"\nlisten = \"udp://127.0.0.1:0\"\n";

int port_of(const std::string& endpoint) { return std::stoi(endpoint.substr(endpoint.rfind(':') + 1)); }

/// Datagrams from an own socket, as anybody on the machine could send them.
class RawSender {
 public:
  explicit RawSender(int port) : socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
    address_.sin_family = AF_INET;
    address_.sin_port = htons(static_cast<std::uint16_t>(port));
    inet_pton(AF_INET, "127.0.0.1", &address_.sin_addr);
  }
  ~RawSender() { ::close(socket_); }
  void send(const std::string& bytes) {
    ::sendto(socket_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&address_), sizeof address_);
  }

 private:
  int socket_;
  sockaddr_in address_{};
};

template <class Done>
bool becomes_true(const RunningDaemon& daemon, Done done) {
  const auto begin = std::chrono::steady_clock::now();
  while (std::chrono::steady_clock::now() - begin < std::chrono::seconds(20)) {
    if (done(daemon.status().at("streams").at("face"))) return true;
  }
  return false;
}

TEST(Daemon, CountsGarbageAndGoesOn) {
  TemporaryFolder folder;
  RunningDaemon daemon(folder.path(), kFace);
  ASSERT_TRUE(daemon.up()) << daemon.process().output();
  RawSender sender(port_of(daemon.input("face")));
  std::mt19937 random(7);
  constexpr std::uint64_t kGarbage = 500;
  for (std::uint64_t i = 0; i < kGarbage; ++i) {
    std::string bytes(random() % 1600, '\0');
    for (char& byte : bytes) byte = static_cast<char>(random());
    sender.send(bytes);
  }
  ASSERT_TRUE(becomes_true(daemon, [&](const nlohmann::json& face) {
    return face.at("datagrams").at("received").get<std::uint64_t>() +
               face.at("datagrams").at("kernel_drops").get<std::uint64_t>() ==
           kGarbage;
  }));
  EXPECT_EQ(daemon.status().at("streams").at("face").at("datagrams").at("refused"), kGarbage);
  const auto sent =
      run({program("risorius").string(), "replay", "builtin:1", "--to", daemon.input("face"), "--speed", "4"});
  ASSERT_EQ(sent.exit_code, 0) << sent.output;
  EXPECT_TRUE(becomes_true(daemon, [](const nlohmann::json& face) { return face.at("processed") == 120; }));
  EXPECT_EQ(daemon.end().exit_code, 0);
}

TEST(Daemon, SaysWhoHasThePort) {
  TemporaryFolder folder, other;
  RunningDaemon first(folder.path(), kFace);
  ASSERT_TRUE(first.up());
  const auto listen = first.input("face");
  std::ofstream(other.path() / "b.toml")
      << "[output]\npublish = \"tcp://127.0.0.1:*\"\ncontrol = \"tcp://127.0.0.1:*\"\n[[source]]\nlisten = \"" << listen
      << "\"\n";
  const auto refused = run({program("risoriusd").string(), "--config", (other.path() / "b.toml").string()}, 20);
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.output.find(std::to_string(port_of(listen))), std::string::npos) << refused.output;
  EXPECT_NE(refused.output.find("port"), std::string::npos) << refused.output;
}

TEST(Daemon, ReportsAllConfigurationProblemsTogether) {
  TemporaryFolder folder;
  const auto path = folder.path() / "bad.toml";
  std::ofstream(path) << "[fill]\nmax_gap_s = -1\nmax_gap_sec = 2\n[[source]]\nname = \"a b\"\nlisten = "
                         "\"tcp://x\"\naxes = \"LLU\"\n[outputs]\n";
  const auto refused = run({program("risoriusd").string(), "--config", path.string()}, 20);
  EXPECT_EQ(refused.exit_code, 1);
  for (const char* part : {"6 problems", "fill.max_gap_s", "fill.max_gap_sec", "source[0].name", "source[0].listen",
                           "source[0].axes", "outputs"}) {
    EXPECT_NE(refused.output.find(part), std::string::npos) << part << " in\n" << refused.output;
  }
}

TEST(Daemon, PrintsAConfigurationThatItReads) {
  TemporaryFolder folder;
  const auto printed = run({program("risoriusd").string(), "--print-config"});
  ASSERT_EQ(printed.exit_code, 0) << printed.output;
  std::ofstream(folder.path() / "printed.toml") << printed.output;
  const auto again =
      run({program("risoriusd").string(), "--config", (folder.path() / "printed.toml").string(), "--print-config"});
  EXPECT_EQ(again.exit_code, 0) << again.output;
  EXPECT_EQ(again.output, printed.output);
}

TEST(Daemon, TellsWhenTheRigDoesNotFitAndTakesASetThatChanges) {
  TemporaryFolder folder;
  RunningDaemon daemon(folder.path(), kFace);
  ASSERT_TRUE(daemon.up());
  Sender sender(parse_send_target(daemon.input("face")));
  MarkerSet set{.id = 5, .names = {"a", "b", "c", "d"}, .rate_hz = 100};
  const auto send_frames = [&](std::uint64_t from, std::uint64_t to) {
    MarkerFrame frame;
    frame.header.set_id = set.id;
    frame.count = static_cast<std::uint32_t>(set.names.size());
    for (std::uint64_t s = from; s < to; ++s) {
      frame.header.sequence = s;
      frame.header.capture_time_ns = static_cast<std::int64_t>(s) * 10'000'000;
      for (std::uint32_t m = 0; m < frame.count; ++m) {
        frame.state[m] = MarkerState::kMeasured;
        frame.position_mm[m] = {static_cast<float>(10 * m), static_cast<float>(m * m), static_cast<float>(s % 5)};
      }
      sender.send_frame(frame);
    }
  };
  sender.send_marker_set(set);
  send_frames(0, 20);
  ASSERT_TRUE(becomes_true(daemon, [](const nlohmann::json& face) { return face.at("processed") == 20; }));
  const auto problem = daemon.status().at("streams").at("face").at("rig_problem").get<std::string>();
  EXPECT_NE(problem.find("FH1"), std::string::npos) << "it names markers of the rig: " << problem;
  set = {.id = 6, .names = {"a", "c", "e"}, .rate_hz = 100};
  sender.send_marker_set(set);
  send_frames(20, 30);
  ASSERT_TRUE(becomes_true(daemon, [](const nlohmann::json& face) { return face.at("processed") == 30; }));
  EXPECT_EQ(daemon.end().exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(daemon.dataset() / "face-001" / "take.json"));
  EXPECT_TRUE(std::filesystem::exists(daemon.dataset() / "face-002" / "take.json")) << "another set is another take";
}

TEST(Daemon, SortsFramesOfSeveralSetsByTheSetTheyName) {
  TemporaryFolder folder;
  RunningDaemon daemon(folder.path(), kFace);
  ASSERT_TRUE(daemon.up());
  Sender sender(parse_listen_address(daemon.input("face")));
  MarkerFrame frame;
  frame.count = 3;
  const auto send = [&](const MarkerSet& set, std::uint64_t from, std::uint64_t to) {
    sender.send_marker_set(set);
    for (std::uint64_t s = from; s < to; ++s) {
      frame.header = {.set_id = set.id, .sequence = s, .capture_time_ns = static_cast<std::int64_t>(s) * 10'000'000};
      for (std::uint32_t m = 0; m < 3; ++m) {
        frame.state[m] = MarkerState::kMeasured;
        frame.position_mm[m] = {static_cast<float>(10 * m), static_cast<float>(m * m), 1};
      }
      sender.send_frame(frame);
    }
  };
  const MarkerSet first{.id = 1, .names = {"a", "b", "c"}, .rate_hz = 100};
  const MarkerSet second{.id = 2, .names = {"a", "c", "d"}, .rate_hz = 100};
  // The same number of markers under another id, there and back again.
  send(first, 0, 10);
  send(second, 10, 20);
  send(first, 20, 30);
  ASSERT_TRUE(becomes_true(daemon, [](const nlohmann::json& face) { return face.at("processed") == 30; }));
  EXPECT_EQ(daemon.status().at("streams").at("face").at("refused_frames"), 0);
  EXPECT_EQ(daemon.end().exit_code, 0);
  for (const char* take : {"face-001", "face-002", "face-003"}) {
    EXPECT_TRUE(std::filesystem::exists(daemon.dataset() / take / "take.json")) << take;
  }
}

TEST(Daemon, SurvivesFramesThatNoRigCanBe) {
  TemporaryFolder folder;
  RunningDaemon daemon(folder.path(), kFace);
  ASSERT_TRUE(daemon.up());
  Sender sender(parse_listen_address(daemon.input("face")));
  PerformerTake take(builtin_rig(), {.seconds = 1});
  sender.send_marker_set(take.info().markers);
  MarkerFrame frame;
  std::uint64_t sent = 0;
  ASSERT_TRUE(take.next(frame));
  sender.send_frame(frame);
  ++sent;
  ASSERT_TRUE(becomes_true(daemon, [](const nlohmann::json& face) { return face.at("processed") == 1; }));
  EXPECT_TRUE(
      ask_daemon(daemon.control(), {{"command", "capture_neutral"}, {"seconds", 0.05}}, std::chrono::seconds(10))
          .at("ok"));
  while (take.next(frame)) {  // every marker in one place, as trackers send markers that they do not see
    frame.state.fill(MarkerState::kMeasured);
    frame.position_mm.fill({});
    sender.send_frame(frame);
    ++sent;
  }
  ASSERT_TRUE(becomes_true(daemon, [&](const nlohmann::json& face) { return face.at("processed") == sent; }));
  const auto face = daemon.status().at("streams").at("face");
  EXPECT_LE(face.at("solved"), 1);
  EXPECT_EQ(face.at("neutral_captures"), 0);
  EXPECT_EQ(daemon.end().exit_code, 0);
}

TEST(Daemon, RefusesAMultipartRequestAndAnswersTheNext) {
  TemporaryFolder folder;
  RunningDaemon daemon(folder.path(), kFace);
  ASSERT_TRUE(daemon.up());
  zmq::context_t context;
  zmq::socket_t socket(context, zmq::socket_type::req);
  socket.set(zmq::sockopt::rcvtimeo, 10'000);
  socket.set(zmq::sockopt::linger, 0);
  socket.connect(daemon.control());
  socket.send(zmq::str_buffer("{\"command\": \"status\"}"), zmq::send_flags::sndmore);
  socket.send(zmq::str_buffer("x"), zmq::send_flags::none);
  zmq::message_t answer;
  ASSERT_TRUE(socket.recv(answer));
  EXPECT_FALSE(nlohmann::json::from_msgpack(answer.to_string()).at("ok"));
  EXPECT_TRUE(ask_daemon(daemon.control(), {{"command", "status"}}, std::chrono::seconds(10)).at("ok"));
  EXPECT_EQ(daemon.end().exit_code, 0);
}

TEST(Daemon, EndsInOrderWhenItsTerminalIsClosed) {
  std::signal(SIGHUP, SIG_DFL);  // whoever runs the tests may ignore it, and children inherit that
  TemporaryFolder folder;
  RunningDaemon daemon(folder.path(), kFace);
  ASSERT_TRUE(daemon.up());
  ASSERT_EQ(run({program("risorius").string(), "replay", "builtin:1", "--to", daemon.input("face")}).exit_code, 0);
  ASSERT_TRUE(becomes_true(daemon, [](const nlohmann::json& face) { return face.at("processed") == 120; }));
  ASSERT_EQ(::kill(daemon.process().id(), SIGHUP), 0);
  const auto ended = daemon.process().finish();
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_TRUE(std::filesystem::exists(daemon.dataset() / "manifest-sha256.txt"));
}

TEST(Daemon, CapturesANeutralOnRequest) {
  TemporaryFolder folder;
  RunningDaemon daemon(folder.path(), kFace);
  ASSERT_TRUE(daemon.up());
  const auto refused =
      ask_daemon(daemon.control(), {{"command", "capture_neutral"}, {"stream", "nobody"}}, std::chrono::seconds(10));
  EXPECT_FALSE(refused.at("ok"));
  EXPECT_NE(refused.at("error").get<std::string>().find("face"), std::string::npos) << "it names the streams";
  // As long as it takes: how busy the machine is must not decide.
  Process sender({program("risorius").string(), "replay", "builtin:600", "--to", daemon.input("face")});
  ASSERT_TRUE(becomes_true(daemon, [](const nlohmann::json& face) { return face.at("processed") > 20; }));
  const auto accepted =
      run({program("risorius").string(), "control", "--connect", daemon.control(), "neutral", "--seconds", "0.5"});
  EXPECT_EQ(accepted.exit_code, 0) << accepted.output;
  EXPECT_TRUE(becomes_true(daemon, [](const nlohmann::json& face) { return face.at("neutral_captures") == 1; }));
  const auto so_far = daemon.status().at("streams").at("face").at("processed").get<std::uint64_t>();
  EXPECT_TRUE(becomes_true(daemon, [&](const nlohmann::json& face) { return face.at("processed") > so_far + 20; }));
  sender.send_signal(SIGINT);
  sender.finish();
  EXPECT_EQ(daemon.end().exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(daemon.dataset() / "face-002" / "rig.json")) << "a take has one neutral";
}

TEST(Daemon, AnswersMalformedControlMessages) {
  TemporaryFolder folder;
  RunningDaemon daemon(folder.path(), kFace);
  ASSERT_TRUE(daemon.up());
  for (const nlohmann::json& request :
       {nlohmann::json(7), nlohmann::json::array({1, 2}), nlohmann::json{{"command", 3}},
        nlohmann::json{{"command", "dance"}}, nlohmann::json{{"command", "\xff\xfe"}},
        nlohmann::json{{"command", std::string(5000, 'x')}},
        nlohmann::json{{"command", "capture_neutral"}, {"seconds", -1}},
        nlohmann::json{{"command", "capture_neutral"}, {"seconds", "long"}},
        nlohmann::json{{"command", "release"}, {"stream", 7}},
        nlohmann::json{{"command", "go_to"}, {"stream", nullptr}},
        nlohmann::json{{"command", "release"}, {"now", true}},
        nlohmann::json{{"command", "status"}, {"stream", "face"}}, nlohmann::json{{"command", "stop"}, {"when", 3}}}) {
    const auto answer = ask_daemon(daemon.control(), request, std::chrono::seconds(10));
    EXPECT_FALSE(answer.at("ok")) << request.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    EXPECT_EQ(answer.at("error").get<std::string>().find("json.exception"), std::string::npos) << answer.at("error");
    EXPECT_NO_THROW((void)answer.dump()) << "text that every client can decode";
    EXPECT_FALSE(answer.at("error").get<std::string>().empty());
  }
  EXPECT_EQ(daemon.end().exit_code, 0);
}

TEST(Daemon, SaysWhatToSendWhereARequestCannotBeRead) {
  TemporaryFolder folder;
  RunningDaemon daemon(folder.path(), kFace);
  ASSERT_TRUE(daemon.up());
  zmq::context_t context;
  zmq::socket_t socket(context, zmq::socket_type::req);
  socket.set(zmq::sockopt::rcvtimeo, 10'000);
  socket.set(zmq::sockopt::linger, 0);
  socket.connect(daemon.control());
  for (const std::string request : {"{\"command\": ", "{\"command\": \"\xff\"}", "\xc1",
                                    "\x81\xa7"
                                    "comm",
                                    ""}) {
    ASSERT_TRUE(socket.send(zmq::buffer(request)));
    zmq::message_t answer;
    ASSERT_TRUE(socket.recv(answer)) << request;
    const auto* begin = answer.data<std::uint8_t>();
    const auto error = nlohmann::json::from_msgpack(begin, begin + answer.size()).at("error").get<std::string>();
    EXPECT_NE(error.find("send {\"command\": \"status\"}"), std::string::npos) << error;
    EXPECT_EQ(error.find("json.exception"), std::string::npos) << error;
  }
  EXPECT_EQ(daemon.end().exit_code, 0);
}

TEST(Daemon, PythonClientOfTheReadmeReadsIt) {
  if (run({"/usr/bin/python3", "-c", "import zmq, msgpack"}).exit_code != 0)
    GTEST_SKIP() << "python3 with zmq and msgpack is not installed";
  std::ifstream readme(std::filesystem::path(RISORIUS_SOURCE_DIR) / "daemon/README.md");
  std::ostringstream text;
  text << readme.rdbuf();
  const std::string all = text.str();
  const auto begin = all.find("```python\n") + 10;
  TemporaryFolder folder;
  std::ofstream(folder.path() / "client.py") << all.substr(begin, all.find("```", begin) - begin);
  RunningDaemon daemon(folder.path(), kFace);
  ASSERT_TRUE(daemon.up());
  Process client({"/usr/bin/python3", (folder.path() / "client.py").string(), daemon.publish()});
  Process sender({program("risorius").string(), "replay", "builtin:3", "--loop", "--to", daemon.input("face")});
  EXPECT_TRUE(client.wait_for_output("AU", 20)) << client.output();
  EXPECT_NE(client.output().find("face"), std::string::npos) << client.output();
  EXPECT_EQ(daemon.end().exit_code, 0);
}

TEST(Daemon, AStreamThatHasEndedIsNotStreaming) {
  TemporaryFolder folder;
  RunningDaemon daemon(folder.path(), kFace);
  ASSERT_TRUE(daemon.up()) << daemon.process().output();
  const auto sent = run(
      {program("risorius").string(), "replay", "--quiet", "builtin:1", "--speed", "10", "--to", daemon.input("face")});
  ASSERT_EQ(sent.exit_code, 0) << sent.output;
  EXPECT_TRUE(becomes_true(daemon, [](const nlohmann::json& face) {
    return face.at("state") == "waiting" && face.at("processed").get<int>() > 0;
  }));
}

TEST(Daemon, SaysWhenAStreamFallsSilentAndWhenItComesBack) {
  TemporaryFolder folder;
  RunningDaemon daemon(folder.path(), kFace);
  ASSERT_TRUE(daemon.up()) << daemon.process().output();
  const auto state_is = [&](const std::string& state) {
    return becomes_true(daemon, [&](const nlohmann::json& face) { return face.at("state") == state; });
  };
  EXPECT_TRUE(state_is("listening"));
  const std::vector<std::string> replay{program("risorius").string(), "replay", "--quiet", "builtin:60", "--to",
                                        daemon.input("face")};
  {
    Process sender(replay);
    EXPECT_TRUE(state_is("streaming"));
  }  // killed: no end of the stream is sent
  EXPECT_TRUE(state_is("stale"));
  const auto silences = daemon.status().at("streams").at("face").at("silences").get<int>();
  EXPECT_GE(silences, 1);
  Process sender(replay);
  EXPECT_TRUE(state_is("streaming"));
  const auto clock = [&] { return daemon.status().at("streams").at("face").at("clock"); };
  EXPECT_EQ(clock().at("source"), "arrivals");
}

}  // namespace
}  // namespace risorius::test
