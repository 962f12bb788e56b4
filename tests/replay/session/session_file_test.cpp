// A session's file, written, read, torn, recovered and solved again; without a daemon.
#include <boost/asio/io_context.hpp>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <memory>
#include <sstream>

#include "capture/errors.h"
#include "capture/wire/udp_source.h"
#include "replay/live/messages.h"
#include "replay/performer/performer.h"
#include "replay/pipeline/stage_config.h"
#include "replay/session/session_player.h"
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
  EXPECT_GE(topics.at("/face/sets").messages, 2u) << "in each chunk but the first";
  EXPECT_EQ(topics.at("/face/sets").missing, 0u);
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

TEST_F(SessionFile, VerifyRepeatsWhatTheRecoverySaysIsMissing) {
  {
    SessionWriter writer(path(), description());
    record(writer, 180);
    writer.finish({});
  }
  const std::string whole = bytes(path());
  std::ofstream(path("torn.mcap"), std::ios::binary) << whole.substr(0, whole.size() * 2 / 3);
  const auto recovered = recover_session(path("torn.mcap"), path("recovered.mcap"), no_progress);
  const SessionVerdict verdict = verify_session(path("recovered.mcap"), no_progress);
  EXPECT_TRUE(verdict.whole);
  EXPECT_EQ(verdict.recovered_of, "torn.mcap");
  EXPECT_EQ(verdict.missing_in_recovered, missing_times(recovered));
  EXPECT_FALSE(verdict.missing_in_recovered.empty());
  EXPECT_TRUE(verify_session(path(), no_progress).missing_in_recovered.empty());
}

TEST_F(SessionFile, OfAFileWithoutAnythingNothingIsRecovered) {
  {
    SessionWriter writer(path(), description());
    writer.finish({});
  }
  const std::string whole = bytes(path());
  for (const std::string& text : {whole.substr(0, 8), whole.substr(0, 8) + std::string(300, '\x06')}) {
    std::ofstream(path("torn.mcap"), std::ios::binary) << text;
    try {
      recover_session(path("torn.mcap"), path("recovered.mcap"), no_progress);
      FAIL() << text.size();
    } catch (const UserError& error) {
      EXPECT_NE(std::string(error.what()).find("nothing to recover"), std::string::npos) << error.what();
    }
    EXPECT_FALSE(std::filesystem::exists(path("recovered.mcap")));
  }
}

TEST_F(SessionFile, TimesThatNoMessageHasAreNotTold) {
  {
    SessionWriter writer(path(), description());
    record(writer, 60);
  }
  // Where the next chunk would be: the head of a chunk of which little is there, from the year 2245.
  std::string broken = bytes(path());
  ByteAppender head;
  head.append(std::uint8_t{6});
  head.append(std::uint64_t{1} << 40);
  head.append(std::int64_t{8'700'000'000'000'000'000});
  head.append(std::int64_t{8'700'000'001'000'000'000});
  broken.append(reinterpret_cast<const char*>(head.bytes().data()), head.bytes().size());
  broken.append(100, 'x');
  std::ofstream(path("broken.mcap"), std::ios::binary) << broken;
  const auto recovered = recover_session(path("broken.mcap"), path("recovered.mcap"), no_progress);
  for (const std::string& line : missing_times(recovered)) EXPECT_EQ(line.find("2245"), std::string::npos) << line;
  const McapDamage damage{.offset = 7, .bytes = 9, .problem = "torn", .start_ns = 20, .end_ns = 30};
  const auto first_line = [&](std::optional<MessageTimes> times) {
    return damage_lines(std::span(&damage, 1), 1, 9, times).front();
  };
  EXPECT_EQ(first_line(std::nullopt), "byte 7: torn");
  EXPECT_EQ(first_line(MessageTimes{10, 29}), "byte 7: torn");
  EXPECT_EQ(first_line(MessageTimes{21, 90}), "byte 7: torn");
  EXPECT_NE(first_line(MessageTimes{20, 30}).find("it held messages from"), std::string::npos);
}

/// The first chunk of a session is damaged, which held the Tick of the marker set.
class SessionWithoutItsFirstChunk : public SessionFile {
 protected:
  void SetUp() override {
    {
      SessionDescription description = this->description();
      description.streams[0].protocol = "natnet";
      SessionWriter writer(path(), description);
      record(writer, 180);
      writer.finish({});
    }
    std::string broken = bytes(path());
    const std::size_t datagram = broken.find("datagram");
    ASSERT_NE(datagram, std::string::npos);
    broken[datagram] = 'D';
    std::ofstream(path("broken.mcap"), std::ios::binary) << broken;
  }
  /// Plays it to a port of ours; `repeats`: with the repeated sets.
  SessionPlayer::Counts play(bool repeats) const {
    boost::asio::io_context io;
    const UdpSource receiver(io, {.port = 0}, [] {});
    const SendTarget target = parse_send_target(fmt::format("udp://127.0.0.1:{}", receiver.port()));
    SessionReader reader(path("broken.mcap"));
    std::unique_ptr<SessionPlayer> player;
    while (reader.next()) {
      if (!player) player = make_session_player(reader.streams().front(), target, std::nullopt);
      if (!player->takes(reader.topic()) || (reader.topic() == SessionTopic::kSets && !repeats)) continue;
      player->send(reader.topic(), reader.message().data);
    }
    player->finish();
    return player->counts();
  }
};

TEST_F(SessionWithoutItsFirstChunk, IsSolvedFromTheNextOneOn) {
  const SessionVerdict verdict = verify_session(path("broken.mcap"), no_progress);
  EXPECT_FALSE(verdict.whole);
  EXPECT_GT(verdict.missing_ticks, 40u);
  EXPECT_EQ(verdict.ticks + verdict.missing_ticks, 181u);
  const VerifiedTopic& aus = verdict.topics.at(0);
  EXPECT_EQ(aus.not_solved, 0u);
  EXPECT_EQ(aus.equal + aus.different, verdict.ticks) << "each frame that is there is solved";
}

TEST_F(SessionWithoutItsFirstChunk, IsSentFromTheNextOneOnAndWithoutRepeatsSaysWhatItLeavesOut) {
  const SessionVerdict verdict = verify_session(path("broken.mcap"), no_progress);
  const auto counts = play(true);
  EXPECT_EQ(counts.sent, verdict.ticks);
  EXPECT_EQ(counts.without_set, 0u);
  const auto older = play(false);
  EXPECT_EQ(older.sent, 0u);
  EXPECT_EQ(older.without_set, verdict.ticks);
}

TEST_F(SessionFile, DamagedMetadataAreToldAndTheirCopyCounts) {
  {
    SessionWriter writer(path(), description());
    record(writer, 60);
  }
  const std::string whole = bytes(path());
  const std::string rig = description().streams[0].rig_json;
  for (const std::string& words : {std::string("form 12"), std::string("risorius-session"), rig.substr(0, 40)}) {
    SCOPED_TRACE(words);
    const std::size_t first = whole.find(words), second = whole.find(words, first + 1);
    ASSERT_NE(second, std::string::npos);
    for (const std::size_t at : {first, second}) {
      std::string broken = whole;
      broken[at + 2] ^= 1;
      std::ofstream(path("broken.mcap"), std::ios::binary) << broken;
      SessionReader reader(path("broken.mcap"));
      while (reader.next()) {
      }
      EXPECT_NO_THROW(reader.require_session());
      EXPECT_EQ(reader.session().at("consent"), "form 12");
      ASSERT_EQ(reader.streams().size(), 1u);
      EXPECT_EQ(reader.streams()[0].rig_json, rig);
      EXPECT_EQ(reader.config_toml(), description().config_toml);
      EXPECT_EQ(reader.file().damage_count(), 1u);
    }
    std::string broken = whole;
    broken[first + 2] ^= 1;
    broken[second + 2] ^= 1;
    std::ofstream(path("broken.mcap"), std::ios::binary) << broken;
    SessionReader reader(path("broken.mcap"));
    while (reader.next()) {
    }
    EXPECT_EQ(reader.file().damage_count(), 2u);
    if (words.front() != '{') {
      try {
        reader.require_session();
        ADD_FAILURE() << "a session without its description";
      } catch (const UserError& error) {
        EXPECT_NE(std::string(error.what()).find("damaged"), std::string::npos) << error.what();
      }
    }
  }
}

TEST_F(SessionFile, WhatIsMissingBeforeATopicsFirstMessageIsToldSo) {
  {
    SessionWriter writer(path(), description());
    writer.write(SessionTopic::kContinuations, 0, 3, 1'000, {});
    writer.write(SessionTopic::kContinuations, 0, 6, 2'001'000, {});
    writer.finish({});
  }
  const auto lines = missing_times(recover_session(path(), path("recovered.mcap"), no_progress));
  EXPECT_EQ(lines, (std::vector<std::string>{
                       "3 messages of /face/continuation before 2023-11-14 22:13:20.000000 UTC",
                       "2 messages of /face/continuation between 2023-11-14 22:13:20.000000 UTC and 2023-11-14 "
                       "22:13:20.002000 UTC"}));
}

TEST_F(SessionFile, OfManyGapsAHundredAreListedAndAllAreCounted) {
  {
    SessionWriter writer(path(), description());
    for (std::uint32_t i = 0; i < 150; ++i) writer.write(SessionTopic::kStatus, 0, 2 * i, 1'000 * i, {});
    writer.finish({});
  }
  const auto recovered = recover_session(path(), path("recovered.mcap"), no_progress);
  const auto lines = missing_times(recovered);
  ASSERT_EQ(lines.size(), TopicAccount::kMostGaps + 1);
  EXPECT_EQ(lines.back(), "and in 49 more gaps of /status: 149 messages of it in all");
}

/// Each message has a channel of its own, under one id: more than a file can number.
TEST_F(SessionFile, OfMoreChannelsThanAFileCanHaveNothingIsRecovered) {
  ByteAppender records, file;
  constexpr int kChannels = 70'000;
  for (int i = 0; i < kChannels; ++i) {
    append_mcap_record(McapChannel{.id = 1, .topic = fmt::format("/{}", i), .message_encoding = "raw", .metadata = {}},
                       records);
    append_mcap_record(McapMessage{.channel_id = 1, .log_time_ns = 700'000'000LL * i, .data = {}}, records);
  }
  file.append_bytes(std::as_bytes(std::span(kMcapMagic)));
  const std::size_t chunk = begin_mcap_record(McapOp::kChunk, file);
  for (const std::uint64_t value : {std::uint64_t{0}, std::uint64_t{0}, std::uint64_t{records.size()}})
    file.append(value);
  file.append(mcap_crc(records.bytes()));
  append_mcap_text("", file);
  file.append(std::uint64_t{records.size()});
  file.append_bytes(records.bytes());
  end_mcap_record(chunk, file);
  std::ofstream(path("many.mcap"), std::ios::binary)
      .write(reinterpret_cast<const char*>(file.bytes().data()), static_cast<std::streamsize>(file.size()));
  EXPECT_THROW(recover_session(path("many.mcap"), path("recovered.mcap"), no_progress), UserError);
  EXPECT_FALSE(std::filesystem::exists(path("recovered.mcap")));
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
