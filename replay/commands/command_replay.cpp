// risorius replay: a take as a live source, at its own pace.
#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdint>
#include <fmt/format.h>
#include <memory>

#include "capture/errors.h"
#include "replay/commands/commands.h"
#include "replay/commands/curve_arguments.h"
#include "replay/commands/pace_arguments.h"
#include "replay/commands/replay_session.h"
#include "replay/commands/take_arguments.h"
#include "replay/live/loop_clock.h"
#include "replay/live/pacer.h"
#include "replay/live/send_target.h"
#include "replay/live/sender.h"
#include "replay/progress_line.h"

namespace risorius {
namespace {

volatile std::sig_atomic_t interrupted = 0;

struct ReplayArguments {
  std::string take, target, stream;
  bool quiet = false;
  PaceArguments pace;
  CurveArguments curve;
  TakeArguments take_arguments;
};

void print_statistics(const Sender& sender, const Pacer& pacer) {
  const auto& sent = sender.statistics();
  const auto& paced = pacer.statistics();
  fmt::print(
      stderr,
      "sent {} frames in {} datagrams; not sent {}, send errors {}; late by more than 1 ms: {}, latest {:.2f} ms\n",
      sent.frames, sent.datagrams, sent.frames_not_sent, sent.send_errors, paced.late_frames,
      static_cast<double>(paced.max_lateness_ns) * 1e-6);
}

void replay(const ReplayArguments& arguments) {
  if (is_session_file(arguments.take)) {
    if (arguments.pace.loop) throw UserError("--loop", "a session is replayed once", "leave it out");
    return replay_session({.path = arguments.take,
                           .stream = arguments.stream,
                           .target = arguments.target,
                           .speed = arguments.pace.speed_factor(),
                           .quiet = arguments.quiet,
                           .curve = arguments.curve.client()});
  }
  if (!arguments.stream.empty()) throw UserError("--stream", "a take has one stream", "leave it out");
  const SendTarget target = parse_send_target(arguments.target);
  const double speed = arguments.pace.speed_factor();
  const auto take = open_take_or_builtin(arguments.take, arguments.take_arguments.options());
  print_warnings(*take);
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { interrupted = 1; });

  Sender sender(target, {.curve = arguments.curve.client()});
  Pacer pacer({.speed = speed, .frame_cap_hz = default_frame_cap_hz(target.transport)});
  std::unique_ptr<ProgressLine> progress;
  if (!arguments.quiet) progress = std::make_unique<ProgressLine>("replay", "frames");
  sender.send_marker_set(take->info().markers);
  LoopClock clock;
  MarkerFrame frame;
  std::uint64_t done = 0;
  do {
    while (interrupted == 0 && take->next(frame)) {
      clock.place(frame);
      if (!pacer.wait(frame.header.capture_time_ns)) continue;
      sender.send_frame(frame);
      ++done;
      if (progress) progress->show(done, arguments.pace.loop ? 0 : take->info().frame_count.value_or(0));
    }
    if (done == 0) throw UserError(arguments.take, "has no frames", "give a take with frames");
    clock.begin_round(capture_time_of(1, take->info().markers.rate_hz));
    take->rewind();
  } while (arguments.pace.loop && interrupted == 0);
  sender.send_end_of_stream();
  if (progress) progress->finish(done);
  if (!arguments.quiet) print_statistics(sender, pacer);
  if (const auto& sent = sender.statistics(); 2 * sent.send_errors > sent.datagrams) {
    throw UserError(arguments.target, fmt::format("{} datagrams were refused: nobody listens there", sent.send_errors),
                    "start the receiver first");
  }
}

}  // namespace

void add_replay_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "replay", "stream a take, or a recorded session as it came, to risoriusd or whoever reads the native protocol");
  auto arguments = std::make_shared<ReplayArguments>();
  command->add_option("take", arguments->take, std::string(kTakeNames) + "; or a session, NAME.mcap")->required();
  command->add_option("--to", arguments->target, "udp://HOST:PORT or zmq+tcp://HOST:PORT")->required();
  command->add_option("--stream", arguments->stream, "of a session that has several");
  arguments->pace.add_to(*command);
  arguments->curve.add_to(*command);
  command->add_flag("--quiet", arguments->quiet, "no progress line");
  arguments->take_arguments.add_to(*command);
  command->callback([arguments] { replay(*arguments); });
}

}  // namespace risorius
