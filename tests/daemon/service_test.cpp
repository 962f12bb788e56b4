// The service in this process, so that the pipeline thread's allocations can be counted.
#include "daemon/service.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <thread>

#include "capture/errors.h"
#include "replay/live/daemon_client.h"
#include "replay/live/sender.h"
#include "replay/performer/performer.h"
#include "solve/faces/builtin_face.h"
#include "support/allocation_counter.h"
#include "support/test_data.h"

namespace risorius {
namespace {

Config on_free_ports() {
  Config config = default_config();
  config.sources[0].listen = "udp://127.0.0.1:0";
  config.output.publish = config.output.control = "tcp://127.0.0.1:*";
  return config;
}

void wait_for_solved(const Service& service, std::uint64_t frames) {
  const auto begin = std::chrono::steady_clock::now();
  while (service.status().at("streams").at("face").at("processed").get<std::uint64_t>() < frames) {
    ASSERT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(60));
    std::this_thread::yield();
  }
}

/// Sends the performer's frames, never more than 64 ahead of the pipeline, so that nothing is dropped on a busy
/// machine.
void stream(const Service& service, std::uint64_t frames) {
  Sender sender(parse_send_target(service.input_endpoint(0)));
  PerformerTake take(builtin_rig(), PerformerOptions{.seconds = static_cast<double>(frames) / 120});
  sender.send_marker_set(take.info().markers);
  MarkerFrame frame;
  for (std::uint64_t sent = 0; take.next(frame); ++sent) {
    if (sent >= 64) wait_for_solved(service, sent - 64);
    sender.send_frame(frame);
  }
  wait_for_solved(service, frames);
}

/// So many frames of three markers at one capture time, numbered from 0.
void stream_without_time(const Service& service, std::uint64_t frames) {
  Sender sender(parse_send_target(service.input_endpoint(0)));
  const MarkerSet set{.id = 1, .names = {"a", "b", "c"}, .rate_hz = 100};
  sender.send_marker_set(set);
  MarkerFrame frame;
  frame.count = 3;
  for (std::uint64_t f = 0; f < frames; ++f) {
    frame.header = {.set_id = set.id, .sequence = f};
    sender.send_frame(frame);
    wait_for_solved(service, f + 1);
  }
}

TEST(Service, CountsFramesWhoseTimeDoesNotAdvanceAndRecordsThemInOneTake) {
  test::TemporaryFolder folder;
  Config config = on_free_ports();
  config.record.folder = (folder.path() / "rec").string();
  Service service(config);
  std::jthread running([&] { service.run(); });
  stream_without_time(service, 60);
  service.stop();
  running.join();
  const auto status = service.status();
  EXPECT_EQ(status.at("streams").at("face").at("frames").at("time_stands"), 59);
  EXPECT_EQ(status.at("record").at("takes"), 1);
  EXPECT_EQ(status.at("record").at("frames"), 60);
}

TEST(Service, PipelineThreadAllocatesNothingPerFrame) {
  Service service(on_free_ports(), &test::allocations_of_this_thread);
  std::jthread running([&] { service.run(); });
  stream(service, 1200);
  service.stop();
  running.join();
  EXPECT_EQ(service.allocations_in_frames(), 0u);
  const auto face = service.status().at("streams").at("face");
  EXPECT_EQ(face.at("processed"), 1200);
  EXPECT_GT(face.at("fill").at("filled_markers"), 0) << "gaps were filled too";
  EXPECT_GT(face.at("continuations"), 0);
}

TEST(Service, RefusesABusyPublishAddress) {
  Config config = on_free_ports();
  const Service first(config);
  config.output.publish = first.publish_endpoint();
  try {
    const Service second(config);
    FAIL() << "two services on one port";
  } catch (const UserError& error) {
    EXPECT_NE(std::string(error.what()).find("another program"), std::string::npos) << error.what();
  }
}

TEST(Service, WithCurveKeysTalksOnlyToThoseOnItsList) {
  const test::TemporaryFolder folder;
  const auto path = [&](const char* name) { return (folder.path() / name).string(); };
  std::filesystem::create_directory(path("clients"));
  for (const char* name : {"daemon", "clients/anna", "stranger"}) {
    write_curve_certificate(path(name), make_curve_key_pair());
  }
  Config config = on_free_ports();
  config.output.curve_key = path("daemon.key_secret");
  config.output.curve_clients = path("clients");
  config.output.status_interval_s = 0.1;
  Service service(config);
  std::jthread running([&] { service.run(); });

  const auto daemon_key = load_curve_public(path("daemon.key"));
  const CurveClient anna{load_curve_secret(path("clients/anna.key_secret")), daemon_key};
  const CurveClient stranger{load_curve_secret(path("stranger.key_secret")), daemon_key};
  const nlohmann::json request{{"command", "status"}};
  for (const auto& curve : {std::optional<CurveClient>(), std::optional(stranger)}) {
    try {
      ask_daemon(service.control_endpoint(), request, std::chrono::seconds(2), curve);
      ADD_FAILURE() << "answered " << (curve ? "a stranger" : "somebody without a key");
    } catch (const UserError& error) {
      EXPECT_NE(std::string(error.what()).find("key"), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find("--curve-server"), std::string::npos) << error.what();
    }
  }
  const auto answer = ask_daemon(service.control_endpoint(), request, std::chrono::seconds(30), anna);
  EXPECT_GE(answer.at("status").at("connections").at("refused"), 2);

  DaemonSubscriber friendly(service.publish_endpoint(), anna), strange(service.publish_endpoint(), stranger);
  LiveView seen, not_seen;
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (seen.status().is_null() && std::chrono::steady_clock::now() < end) {
    friendly.receive_for(std::chrono::milliseconds(100), seen);
    strange.receive_for(std::chrono::milliseconds(10), not_seen);
  }
  EXPECT_FALSE(seen.status().is_null());
  EXPECT_TRUE(not_seen.status().is_null());
  EXPECT_TRUE(friendly.refusal().empty());
  EXPECT_FALSE(strange.refusal().empty());
  service.stop();
}

TEST(Service, RefusesKeysItCannotUse) {
  const test::TemporaryFolder folder;
  Config config = on_free_ports();
  config.output.curve_clients = folder.path().string();
  EXPECT_THROW(Service service(config), UserError) << "a list of clients, and no key";
  config.output.curve_key = (folder.path() / "nobody.key_secret").string();
  try {
    Service service(config);
    FAIL() << "no such file";
  } catch (const UserError& error) {
    EXPECT_NE(std::string(error.what()).find("nobody.key_secret"), std::string::npos) << error.what();
  }
}

TEST(Service, TakesTheNeutralOfASessionAndNamesOneThatItCannotUse) {
  Config config = on_free_ports();
  config.sources[0].neutral = "builtin:4:0-20";
  EXPECT_NO_THROW(Service{config});
  config.sources[0].neutral = "nowhere.c3d:20-90";
  try {
    const Service service(config);
    FAIL();
  } catch (const UserError& error) {
    EXPECT_NE(std::string(error.what()).find("nowhere.c3d"), std::string::npos) << error.what();
  }
}

TEST(Service, EndsCleanlyWithoutAnyFrame) {
  Service service(on_free_ports());
  std::jthread running([&] { service.run(); });
  EXPECT_TRUE(ask_daemon(service.control_endpoint(), {{"command", "stop"}}, std::chrono::seconds(10)).at("ok"));
  running.join();
  EXPECT_EQ(service.status().at("streams").at("face").at("processed"), 0);
}

}  // namespace
}  // namespace risorius
