// A session's file, written, read, torn, recovered and solved again; without a daemon.
#include <fstream>
#include <gtest/gtest.h>
#include <memory>
#include <sstream>

#include "capture/errors.h"
#include "replay/live/messages.h"
#include "replay/performer/performer.h"
#include "replay/pipeline/stage_config.h"
#include "replay/session/session_recover.h"
#include "replay/session/session_solver.h"
#include "replay/session/session_verify.h"
#include "replay/session/session_writer.h"
#include "solve/faces/builtin_face.h"
#include "support/test_data.h"

namespace risorius {
namespace {

void no_progress(std::uint64_t, std::uint64_t) {}

class SessionFile : public testing::Test {
 protected:
  std::filesystem::path path(const std::string& name = "session.mcap") const { return folder_.path() / name; }
  SessionDescription description() const {
    return {.streams = {{"face", "udp", rig_to_json(builtin_rig())}},
            .config_toml = print_stage_config({}) + "\n[[source]]\nname = \"face\"\n",
            .facts = {{"risorius", "0"}, {"consent", "form 12"}},
            .monotonic_ns = 1'000,
            .utc_ns = 1'700'000'000'000'000'000};
  }

  /// What a daemon would record of `frames` frames of the performer at 120 Hz.
  void record(SessionWriter& writer, int frames, std::uint32_t skipped_tick = UINT32_MAX) {
    const Rig rig = builtin_rig();
    PerformerTake take(rig, {.seconds = frames / 120.0});
    std::uint32_t ticks = 0, aus = 0, continuations = 0;
    std::int64_t now_ns = 0;
    MessageBuffer message;
    const auto names = rig.au_names();
    SessionSolver solver({}, rig, nullptr,
                         {.solved =
                              [&](const SolvedFrame& frame) {
                                encode_aus(frame.aus, {"face", aus, now_ns, names}, message);
                                writer.write(SessionTopic::kAus, 0, aus++, now_ns, std::as_bytes(std::span(message)));
                              },
                          .continued =
                              [&](const Continuation& continuation) {
                                encode_continuation(continuation, {"face", continuations, now_ns, names}, message);
                                writer.write(SessionTopic::kContinuations, 0, continuations++, now_ns,
                                             std::as_bytes(std::span(message)));
                              }});
    ByteAppender bytes;
    const auto tick = [&](const auto&... values) {
      encode_tick(values..., bytes);
      if (ticks++ != skipped_tick) writer.write(SessionTopic::kTicks, 0, ticks - 1, now_ns, bytes.bytes());
      SessionTick decoded;
      ASSERT_TRUE(decode_tick(bytes.bytes(), decoded));
      solver.take(decoded);
    };
    tick(take.info().markers);
    for (MarkerFrame frame; take.next(frame);) {
      now_ns = frame.header.receive_time_ns = 5'000 + frame.header.capture_time_ns;
      writer.write_raw(0, static_cast<std::uint32_t>(frame.header.sequence), now_ns,
                       {.ip_version = 4, .port = 9, .address = {127, 0, 0, 1}}, std::as_bytes(std::span("datagram")));
      tick(frame);
      writer.keep_time(now_ns);
    }
  }
  std::string bytes(const std::filesystem::path& of) const {
    std::ifstream file(of, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
  }

 private:
  test::TemporaryFolder folder_;
};

TEST_F(SessionFile, HoldsWhatWasRecordedAndSolvesToTheSameBits) {
  SessionWriter writer(path(), description());
  record(writer, 180);
  writer.finish({{"dropped ticks", "0"}});
  EXPECT_EQ(writer.problem(), "");
  SessionReader reader(path());
  while (reader.next()) {
  }
  reader.require_session();
  EXPECT_TRUE(reader.file().whole());
  EXPECT_EQ(reader.session().at("consent"), "form 12");
  EXPECT_EQ(reader.report().at("written /face/ticks"), "181");
  const auto& topics = reader.topics();
  EXPECT_EQ(topics.at("/face/raw").messages, 180u);
  EXPECT_EQ(topics.at("/face/ticks").messages, 181u);
  EXPECT_EQ(topics.at("/face/ticks").missing, 0u);
  EXPECT_EQ(topics.at("/face/au").messages, 180u);
  EXPECT_EQ(topics.at("/face/view/au").messages, 90u) << "60 of 120 a second";
  EXPECT_EQ(topics.at("/face/raw").first_ns, 1'700'000'000'000'000'000 + 4'000);

  const SessionVerdict verdict = verify_session(path(), no_progress);
  EXPECT_EQ(verdict.different(), 0u);
  ASSERT_EQ(verdict.topics.size(), 2u);
  EXPECT_EQ(verdict.topics[0].equal, 180u);
  EXPECT_EQ(verdict.topics[0].not_recorded + verdict.topics[0].not_solved, 0u);
  EXPECT_GT(verdict.topics[1].equal, 50u);
  EXPECT_TRUE(verdict.whole);
}

TEST_F(SessionFile, AnotherRigOrAMissingTickDoesNotPassForEqual) {
  SessionDescription other = description();
  Rig rig = builtin_rig();
  rig.neutral_mm(0, 0) += 1e-9;
  other.streams[0].rig_json = rig_to_json(rig);
  {
    SessionWriter writer(path("rig.mcap"), other);
    record(writer, 60);
    writer.finish({});
  }
  EXPECT_GT(verify_session(path("rig.mcap"), no_progress).different(), 50u);
  SessionWriter writer(path(), description());
  record(writer, 60, 30);
  writer.finish({});
  const SessionVerdict verdict = verify_session(path(), no_progress);
  EXPECT_EQ(verdict.missing_ticks, 1u);
  EXPECT_EQ(verdict.topics[0].not_solved, 1u);
}

TEST_F(SessionFile, TornAnywhereItIsRecoveredAndWhatIsThereIsEqual) {
  {
    SessionWriter writer(path(), description());
    record(writer, 180);
    writer.finish({});
  }
  const std::string whole = bytes(path());
  std::uint64_t most = 0;
  for (std::size_t share = 1; share <= 40; ++share) {
    // 40 places over the file, and each byte of one stretch is what mcap_test does.
    const std::size_t length = whole.size() * share / 41 + share % 7;
    std::ofstream(path("torn.mcap"), std::ios::binary) << whole.substr(0, length);
    const auto recovered = recover_session(path("torn.mcap"), path("recovered.mcap"), no_progress);
    EXPECT_FALSE(recovered.was_whole);
    EXPECT_FALSE(missing_times(recovered).empty());
    EXPECT_GE(recovered.messages, most);
    most = recovered.messages;
    SessionReader reader(path("recovered.mcap"));
    std::uint64_t messages = 0;
    while (reader.next()) ++messages;
    EXPECT_TRUE(reader.file().whole()) << length;
    EXPECT_TRUE(reader.file().damages().empty()) << length;
    EXPECT_EQ(messages, recovered.messages) << length;
    EXPECT_EQ(reader.recovery().at("of"), "torn.mcap");
    if (share % 8 == 0 && messages > 0) {
      EXPECT_EQ(verify_session(path("recovered.mcap"), no_progress).different(), 0u);
    }
    std::filesystem::remove(path("recovered.mcap"));
  }
  EXPECT_GT(most, 400u);
}

TEST_F(SessionFile, RefusesWhatIsNoSessionAndKeepsWhatIsThere) {
  std::ofstream(path("text.mcap")) << "not at all";
  EXPECT_THROW(verify_session(path("text.mcap"), no_progress), UserError);
  EXPECT_THROW(recover_session(path("text.mcap"), path("out.mcap"), no_progress), UserError);
  EXPECT_FALSE(std::filesystem::exists(path("out.mcap")));
  {
    McapWriter other(path("other.mcap"));
    other.finish();
  }
  EXPECT_THROW(verify_session(path("other.mcap"), no_progress), UserError);
  EXPECT_THROW(recover_session(path("other.mcap"), path("text.mcap"), no_progress), UserError);
  EXPECT_EQ(bytes(path("text.mcap")), "not at all");
}

}  // namespace
}  // namespace risorius
