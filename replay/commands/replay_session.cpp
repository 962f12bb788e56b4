#include "replay/commands/replay_session.h"

#include <csignal>
#include <fmt/format.h>
#include <memory>

#include "capture/errors.h"
#include "replay/live/pacer.h"
#include "replay/live/send_target.h"
#include "replay/progress_line.h"
#include "replay/session/session_player.h"
#include "replay/session/session_reader.h"

namespace risorius {
namespace {

volatile std::sig_atomic_t interrupted = 0;

const StreamFacts& chosen_stream(const SessionReader& reader, const SessionReplay& replay) {
  std::string names;
  for (const StreamFacts& stream : reader.streams()) names += (names.empty() ? "" : ", ") + stream.name;
  if (reader.streams().empty())
    throw UserError(replay.path, "says of no stream what it was", "is its begin damaged? risorius info says so");
  if (replay.stream.empty() && reader.streams().size() != 1)
    throw UserError("--stream", "must be given, there are several", "streams: " + names);
  const StreamFacts* stream = replay.stream.empty() ? &reader.streams().front() : reader.find_stream(replay.stream);
  if (stream == nullptr)
    throw UserError("--stream", "\"" + replay.stream + "\" is not in the file", "streams: " + names);
  return *stream;
}

}  // namespace

bool is_session_file(const std::string& path) { return path.ends_with(".mcap"); }

void replay_session(const SessionReplay& replay) {
  const SendTarget target = parse_send_target(replay.target);
  SessionReader reader(replay.path);
  bool more = reader.next();
  reader.require_session();
  const StreamFacts stream = chosen_stream(reader, replay);
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { interrupted = 1; });

  const auto player = make_session_player(stream, target, replay.curve);
  if (!replay.quiet && player->topic() == SessionTopic::kTicks)
    fmt::print(stderr, "stream {} came over {}: its frames are sent, as the native protocol\n", stream.name,
               stream.protocol);
  Pacer pacer({.speed = replay.speed, .frame_cap_hz = default_frame_cap_hz(target.transport)});
  std::unique_ptr<ProgressLine> progress;
  if (!replay.quiet) progress = std::make_unique<ProgressLine>("replay", player->unit());
  const SessionPlayer::Counts& counts = player->counts();
  for (; more && interrupted == 0; more = reader.next()) {
    if (!player->takes(reader.topic()) || reader.stream() != stream.name) continue;
    // The file's time of a datagram is that of its receive call.
    while (interrupted == 0 && !pacer.wait(reader.message().log_time_ns)) {
    }
    if (interrupted != 0) break;
    player->send(reader.topic(), reader.message().data);
    if (progress) progress->show(counts.sent, 0);
  }
  player->finish();
  if (progress) progress->finish(counts.sent);
  const std::uint64_t done = counts.sent + counts.not_sent;
  if (done == 0 && interrupted == 0)
    throw UserError(replay.path,
                    counts.without_set > 0 ? fmt::format("the marker set of the {} frames of stream {} is missing",
                                                         counts.without_set, stream.name)
                                           : fmt::format("has no {} of stream {}", player->unit(), stream.name),
                    "risorius info says what it has, and what is missing");
  if (!replay.quiet) {
    fmt::print(stderr, "sent {} {}; not sent {}, send errors {}; late by more than 1 ms: {}, latest {:.2f} ms\n",
               counts.sent, player->unit(), counts.not_sent, counts.send_errors, pacer.statistics().late_frames,
               static_cast<double>(pacer.statistics().max_lateness_ns) * 1e-6);
    if (counts.left_out > 0)
      fmt::print(stderr, "left out: {} neutrals and starts and stops of the tracker's recording; ask for them anew\n",
                 counts.left_out);
    if (counts.without_set > 0)
      fmt::print(stderr, "left out: {} frames whose marker set is missing in the file\n", counts.without_set);
  }
  if (2 * counts.send_errors > done) {
    throw UserError(replay.target, fmt::format("{} datagrams were refused: nobody listens there", counts.send_errors),
                    "start the receiver first");
  }
}

}  // namespace risorius
