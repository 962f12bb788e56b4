// risorius replay: a take as a live source, at its own pace.
#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdint>
#include <fmt/format.h>
#include <memory>

#include "capture/errors.h"
#include "replay/commands/commands.h"
#include "replay/commands/take_arguments.h"
#include "replay/live/pacer.h"
#include "replay/live/send_target.h"
#include "replay/live/sender.h"
#include "replay/progress_line.h"

namespace risorius {
namespace {

volatile std::sig_atomic_t interrupted = 0;

struct ReplayArguments {
  std::string take, target, speed = "1";
  bool loop = false, quiet = false;
  TakeArguments take_arguments;
};

double speed_of(const std::string& text) {
  if (text == "max") return 0;
  double speed = 0;
  if (!CLI::detail::lexical_cast(text, speed) || !(speed > 0 && speed <= 1000)) {
    throw UserError("--speed", "\"" + text + "\" is neither \"max\" nor a number above 0 and up to 1000",
                    "1 is the take's own pace");
  }
  return speed;
}

/// Capture times of a second round go on where the first ended: the loop goes on counting.
struct LoopClock {
  std::uint64_t sequence_offset = 0;
  std::int64_t time_offset_ns = 0;
  std::uint64_t first_sequence = 0, last_sequence = 0;
  std::int64_t first_time_ns = 0, last_time_ns = 0;
  bool begun = false;

  void place(MarkerFrame& frame) {
    if (!begun) {
      first_sequence = frame.header.sequence;
      first_time_ns = frame.header.capture_time_ns;
      begun = true;
    }
    frame.header.sequence += sequence_offset;
    frame.header.capture_time_ns += time_offset_ns;
    last_sequence = frame.header.sequence;
    last_time_ns = frame.header.capture_time_ns;
  }
  void begin_round(double rate_hz) {
    sequence_offset = last_sequence + 1 - first_sequence;
    time_offset_ns = last_time_ns + capture_time_of(1, rate_hz) - first_time_ns;
  }
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
  const SendTarget target = parse_send_target(arguments.target);
  const double speed = speed_of(arguments.speed);
  const auto take = open_take_or_builtin(arguments.take, arguments.take_arguments.options());
  print_warnings(*take);
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { interrupted = 1; });

  Sender sender(target);
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
      if (progress) progress->show(done, arguments.loop ? 0 : take->info().frame_count.value_or(0));
    }
    if (done == 0) throw UserError(arguments.take, "has no frames", "give a take with frames");
    clock.begin_round(take->info().markers.rate_hz);
    take->rewind();
  } while (arguments.loop && interrupted == 0);
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
  CLI::App* command =
      app.add_subcommand("replay", "stream a take to risoriusd, or to anybody who reads the native protocol");
  auto arguments = std::make_shared<ReplayArguments>();
  command->add_option("take", arguments->take, kTakeNames)->required();
  command->add_option("--to", arguments->target, "udp://HOST:PORT or zmq+tcp://HOST:PORT")->required();
  command
      ->add_option("--speed", arguments->speed,
                   "times the take's own pace; \"max\" = as fast as the other side takes it")
      ->capture_default_str();
  command->add_flag("--loop", arguments->loop, "begin again at the end; sequence and capture time go on counting");
  command->add_flag("--quiet", arguments->quiet, "no progress line");
  arguments->take_arguments.add_to(*command);
  command->callback([arguments] { replay(*arguments); });
}

}  // namespace risorius
