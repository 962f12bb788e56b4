// The topic `shown` over real sockets: through a drop-out, to a target and back; and `au` stays what was measured.
#include <chrono>
#include <cmath>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>
#include <zmq.hpp>

#include "capture/monotonic_clock.h"
#include "replay/live/daemon_client.h"
#include "replay/live/sender.h"
#include "replay/performer/performer.h"
#include "solve/faces/builtin_face.h"
#include "support/test_data.h"
#include "system/running_daemon.h"

namespace risorius::test {
namespace {

const char* const kFace = "[[source]]\nname = \"face\"\nlisten = \"udp://127.0.0.1:0\"\n";

/// Messages of `shown` and `au`, as they come.
class Listener {
 public:
  explicit Listener(const std::string& endpoint, const std::vector<const char*>& topics = {"shown", "au"})
      : socket_(context_, zmq::socket_type::sub) {
    for (const char* topic : topics) socket_.set(zmq::sockopt::subscribe, topic);
    socket_.connect(endpoint);
  }
  /// Until `done` of a message is true; false after 20 s.
  template <class Done>
  bool listen_until(Done done) {
    const std::int64_t end_ns = monotonic_now_ns() + 20'000'000'000;
    socket_.set(zmq::sockopt::rcvtimeo, 100);
    while (monotonic_now_ns() < end_ns) {
      zmq::message_t topic, body;
      if (!socket_.recv(topic)) continue;
      if (!socket_.recv(body)) continue;
      const auto* bytes = static_cast<const std::uint8_t*>(body.data());
      auto message = nlohmann::json::from_msgpack(bytes, bytes + body.size());
      auto& list = topic.to_string() == "shown" ? shown : au;
      list.push_back(std::move(message));
      if (&list == &shown && done(shown.back())) return true;
    }
    return false;
  }
  std::vector<nlohmann::json> shown, au;

 private:
  zmq::context_t context_;
  zmq::socket_t socket_;
};

class Stream {
 public:
  explicit Stream(const std::string& input)
      : sender_(parse_send_target(input)), take_(builtin_rig(), PerformerOptions{.rate_hz = 60, .seconds = 60}) {
    sender_.send_marker_set(take_.info().markers);
  }
  /// So many frames at 60 Hz, paced by the clock; capture times go on as the clock does.
  void send(int frames) {
    MarkerFrame frame;
    for (int f = 0; f < frames && take_.next(frame); ++f) {
      const std::int64_t due_ns = begin_ns_ + frame.header.capture_time_ns;
      sleep_until(due_ns);
      sender_.send_frame(frame);
    }
  }
  /// Frames that nobody gets, while the time passes for them.
  void lose(int frames) {
    MarkerFrame frame;
    for (int f = 0; f < frames && take_.next(frame); ++f) {
      sleep_until(begin_ns_ + frame.header.capture_time_ns);
    }
  }

 private:
  static void sleep_until(std::int64_t due_ns) {
    std::this_thread::sleep_for(std::chrono::nanoseconds(std::max<std::int64_t>(0, due_ns - monotonic_now_ns())));
  }
  Sender sender_;
  PerformerTake take_;
  std::int64_t begin_ns_ = monotonic_now_ns();
};

bool has_origin(const nlohmann::json& message, const char* origin) { return message.at("origin") == origin; }

TEST(Shown, IsContinuousThroughADropOutThatTheMeasuredAusShow) {
  TemporaryFolder folder;
  RunningDaemon daemon(folder.path(), kFace, "[shown]\nbridge_s = 2\n", Recording::kOn);
  ASSERT_TRUE(daemon.up()) << daemon.process().output();
  Listener listener(daemon.publish());
  Stream stream(daemon.input("face"));
  std::jthread sending([&] {
    stream.send(60);
    stream.lose(90);  // 1.5 s: a machine that stops for one of them still shows some
    stream.send(60);
  });
  // After the drop-out: a busy machine makes gaps of its own, which are bridged too.
  const auto after = [](const auto& m, double seconds) {
    return m.at("capture_time_ns").template get<std::int64_t>() > static_cast<std::int64_t>(seconds * 1e9);
  };
  ASSERT_TRUE(listener.listen_until([&](const auto& m) { return has_origin(m, "bridge") && after(m, 1.0); }));
  ASSERT_TRUE(listener.listen_until([&](const auto& m) { return has_origin(m, "rejoin") && after(m, 2.5); }));
  ASSERT_TRUE(listener.listen_until([&](const auto& m) { return has_origin(m, "solved") && after(m, 2.5); }));
  sending.join();
  int bridged = 0;
  for (std::size_t i = 1; i < listener.shown.size(); ++i) {
    const auto &before = listener.shown[i - 1], &now = listener.shown[i];
    const double dt_s = 1e-9 * static_cast<double>(now.at("capture_time_ns").get<std::int64_t>() -
                                                   before.at("capture_time_ns").get<std::int64_t>());
    for (const auto& [name, value] : now.at("au").items()) {
      if (value.is_null() || before.at("au").at(name).is_null()) continue;
      // A lid closes in less than 0.1 s, so faster than 20 per s is no motion; frames that jitter share a time.
      EXPECT_LE(std::abs(value.get<double>() - before.at("au").at(name).get<double>()), 20 * std::max(dt_s, 0.02))
          << name;
    }
    if (!has_origin(now, "bridge")) continue;
    ++bridged;
    EXPECT_EQ(now.at("kind"), "predicted");
  }
  EXPECT_GE(bridged, 5) << "of 1.5 s at 60 Hz, less three frame times";
  for (const auto& frame : listener.au) EXPECT_EQ(frame.at("kind"), "solved");
  const auto shown = daemon.status().at("streams").at("face").at("shown");
  EXPECT_GT(shown.at("predicted"), 0);
  EXPECT_LT(shown.at("predicted"), shown.at("messages"));
}

TEST(Shown, FadesToNeutralWhereTheStreamEnds) {
  TemporaryFolder folder;
  RunningDaemon daemon(folder.path(), kFace, "[shown]\nbridge_s = 0.1\nfade_s = 0.3\n", Recording::kOff);
  ASSERT_TRUE(daemon.up()) << daemon.process().output();
  Listener listener(daemon.publish());
  const auto played = run({program("risorius").string(), "replay", "builtin:2", "--to", daemon.input("face")});
  ASSERT_EQ(played.exit_code, 0) << played.output;
  ASSERT_TRUE(listener.listen_until([](const auto& m) { return has_origin(m, "fade"); }));
  ASSERT_TRUE(listener.listen_until([](const auto& m) {
    return std::ranges::all_of(m.at("au"),
                               [](const auto& x) { return x.is_null() || x.template get<double>() < 0.01; });
  }));
}

TEST(Shown, GoesToATargetAndComesBack) {
  TemporaryFolder folder;
  RunningDaemon daemon(folder.path(), kFace, "", Recording::kOff);
  ASSERT_TRUE(daemon.up()) << daemon.process().output();
  const nlohmann::json go{{"command", "go_to"}, {"expression", "happy"}, {"seconds", 0.3}, {"hold_seconds", 2}};
  const auto too_early = ask_daemon(daemon.control(), go, std::chrono::seconds(10));
  EXPECT_FALSE(too_early.at("ok")) << "no face is there";
  Listener listener(daemon.publish(), {"shown"});
  Stream stream(daemon.input("face"));
  // As long as it takes: on a slow machine the course is ready late.
  std::jthread sending([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) stream.send(30);
  });
  ASSERT_TRUE(listener.listen_until([](const auto&) { return true; }));
  const auto answer = ask_daemon(daemon.control(), go, std::chrono::seconds(10));
  ASSERT_TRUE(answer.at("ok")) << answer.dump();
  ASSERT_TRUE(listener.listen_until([](const auto& m) {
    return has_origin(m, "target") && std::abs(m.at("au").at("AU12L").template get<double>() - 0.9) < 1e-3;
  })) << listener.shown.size()
      << " shown, the last: " << listener.shown.back().dump();
  ASSERT_TRUE(listener.listen_until([](const auto& m) { return has_origin(m, "solved"); }));
  // A target that is still being prepared can be called off, too.
  for (int turn = 0; turn < 5; ++turn) {
    nlohmann::json asked = ask_daemon(daemon.control(), go, std::chrono::seconds(10));
    while (!asked.at("ok"))
      asked = ask_daemon(daemon.control(), go, std::chrono::seconds(10));  // the last one's thread
    EXPECT_TRUE(ask_daemon(daemon.control(), {{"command", "release"}}, std::chrono::seconds(10)).at("ok")) << turn;
  }
  EXPECT_FALSE(ask_daemon(daemon.control(), {{"command", "release"}}, std::chrono::seconds(10)).at("ok"))
      << "no target any more";
  nlohmann::json timed = go, as_faces_do;
  timed["seconds"] = "auto";
  do {
    as_faces_do = ask_daemon(daemon.control(), timed, std::chrono::seconds(10));
  } while (!as_faces_do.at("ok") &&
           as_faces_do.at("error").get<std::string>().find("being prepared") != std::string::npos);
  ASSERT_TRUE(as_faces_do.at("ok")) << as_faces_do.dump();
  EXPECT_GT(as_faces_do.at("seconds"), 0.3);
  EXPECT_LT(as_faces_do.at("seconds"), 3.4);
  EXPECT_FALSE(ask_daemon(daemon.control(), {{"command", "go_to"}, {"expression", "nobody"}}, std::chrono::seconds(10))
                   .at("ok"));
}

}  // namespace
}  // namespace risorius::test
