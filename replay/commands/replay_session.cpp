#include "replay/commands/replay_session.h"

#include <csignal>
#include <fmt/format.h>
#include <memory>

#include "capture/errors.h"
#include "replay/live/datagram_sender.h"
#include "replay/live/pacer.h"
#include "replay/progress_line.h"
#include "replay/session/session_reader.h"

namespace risorius {
namespace {

volatile std::sig_atomic_t interrupted = 0;

/// The chosen stream; checks that its packets can be sent to `target`.
const StreamFacts& chosen_stream(const SessionReader& reader, const SessionReplay& replay, Transport transport) {
  std::string names;
  for (const StreamFacts& stream : reader.streams()) names += (names.empty() ? "" : ", ") + stream.name;
  if (replay.stream.empty() && reader.streams().size() != 1)
    throw UserError("--stream", "must be given, there are several", "streams: " + names);
  const StreamFacts* stream = replay.stream.empty() ? &reader.streams().front() : reader.find_stream(replay.stream);
  if (stream == nullptr)
    throw UserError("--stream", "\"" + replay.stream + "\" is not in the file", "streams: " + names);
  const bool is_native = stream->protocol == "udp" || stream->protocol == "zmq+tcp";
  const bool is_sent_as_is = stream->protocol == "livelink" && transport == Transport::kUdp;
  if (!is_native && !is_sent_as_is) {
    throw UserError(replay.path, "stream " + stream->name + " came over " + stream->protocol,
                    "a recorded conversation with a tracker cannot be had again; `risorius verify` solves its Ticks");
  }
  return *stream;
}

}  // namespace

bool is_session_file(const std::string& path) { return path.ends_with(".mcap"); }

void replay_session(const SessionReplay& replay) {
  const SendTarget target = parse_send_target(replay.target);
  SessionReader reader(replay.path);
  bool more = reader.next();
  reader.require_session();
  const StreamFacts stream = chosen_stream(reader, replay, target.transport);
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { interrupted = 1; });

  DatagramSender sender(target, {.curve = replay.curve});
  Pacer pacer({.speed = replay.speed, .frame_cap_hz = default_frame_cap_hz(target.transport)});
  std::unique_ptr<ProgressLine> progress;
  if (!replay.quiet) progress = std::make_unique<ProgressLine>("replay", "datagrams");
  std::uint64_t done = 0, errors = 0, not_sent = 0;
  for (; more && interrupted == 0; more = reader.next()) {
    if (reader.topic() != SessionTopic::kRaw || reader.stream() != stream.name) continue;
    // The file's time of a datagram is that of its receive call.
    while (interrupted == 0 && !pacer.wait(reader.message().log_time_ns)) {
    }
    if (interrupted != 0) break;
    not_sent += sender.send(reader.message().data, errors) ? 0 : 1;
    ++done;
    if (progress) progress->show(done, 0);
  }
  if (progress) progress->finish(done);
  if (done == 0 && interrupted == 0)
    throw UserError(replay.path, "has no datagrams of stream " + stream.name, "risorius info says what it has");
  if (!replay.quiet) {
    fmt::print(stderr, "sent {} datagrams; not sent {}, send errors {}; late by more than 1 ms: {}, latest {:.2f} ms\n",
               done - not_sent, not_sent, errors, pacer.statistics().late_frames,
               static_cast<double>(pacer.statistics().max_lateness_ns) * 1e-6);
  }
  if (2 * errors > done) {
    throw UserError(replay.target, fmt::format("{} datagrams were refused: nobody listens there", errors),
                    "start the receiver first");
  }
}

}  // namespace risorius
