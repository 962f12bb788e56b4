#include "replay/commands/rom_live.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <optional>
#include <unistd.h>

#include "capture/errors.h"
#include "capture/monotonic_clock.h"
#include "replay/atomic_file.h"
#include "replay/commands/number_check.h"
#include "replay/commands/output_check.h"
#include "replay/live/curve_refusal.h"
#include "replay/live/daemon_client.h"
#include "replay/picture/rig_pictures.h"
#include "replay/takes/csv_text.h"
#include "solve/rigs/au_name.h"

namespace risorius {
namespace {

volatile std::sig_atomic_t interrupted = 0;

constexpr std::chrono::milliseconds kWait{100};
constexpr int kBarWidth = 24;

/// AU frames of one stream of a running daemon, as poses see them.
class AuStream {
 public:
  AuStream(const RomLiveArguments& arguments)
      : endpoint_(arguments.endpoint),
        stream_(arguments.stream),
        silence_s_(arguments.seconds),
        subscriber_(endpoint_, arguments.curve.client()) {}

  /// Waits for frames and hands them to `sink` until it returns false, the face is silent for too long, or Ctrl-C.
  template <typename Sink>
  void follow(const Sink& sink) {
    bool goes_on = true;
    std::int64_t heard_ns = monotonic_now_ns();
    while (goes_on && interrupted == 0) {
      subscriber_.receive_for(kWait, [&](const std::string& topic, const nlohmann::json& message) {
        if (!goes_on || topic != "au" || !is_ours(message)) return;
        heard_ns = monotonic_now_ns();
        if (auto frame = frame_of(message)) goes_on = sink(*frame);
      });
      if (static_cast<double>(monotonic_now_ns() - heard_ns) > 1e9 * silence_s_) refuse_silence();
    }
  }

  const std::vector<std::string>& aus() const noexcept { return aus_; }
  const std::string& name() const noexcept { return stream_; }
  /// The capture time that a frame's time stands for.
  std::int64_t capture_time_ns(double time_s) const noexcept {
    return begin_ns_ + static_cast<std::int64_t>(std::llround(time_s * 1e9));
  }

 private:
  bool is_ours(const nlohmann::json& message) {
    const auto stream = message.at("stream").get<std::string>();
    if (stream_.empty()) stream_ = stream;
    return stream == stream_;
  }

  /// Nothing where no face was solved, or where the AUs are others than at first.
  std::optional<PoseFrame> frame_of(const nlohmann::json& message) {
    if (message.at("kind") == "predicted") return std::nullopt;
    const auto& values = message.at("au");
    const auto time_ns = message.at("capture_time_ns").get<std::int64_t>();
    if (aus_.empty()) {
      for (const auto& [name, value] : values.items()) aus_.push_back(name);
      std::ranges::stable_sort(aus_, {}, [](const std::string& name) {  // JSON sorts AU10 before AU2
        const auto au = parse_au_name(name);
        return au ? std::pair(au->number, static_cast<int>(au->side)) : std::pair(100, 0);
      });
      begin_ns_ = time_ns;
    }
    PoseFrame frame{static_cast<double>(time_ns - begin_ns_) * 1e-9,
                    Eigen::VectorXd::Zero(static_cast<Eigen::Index>(aus_.size()))};
    bool any = false;
    for (std::size_t i = 0; i < aus_.size(); ++i) {
      const auto found = values.find(aus_[i]);
      if (found == values.end() || !found->is_number()) continue;
      frame.x[static_cast<Eigen::Index>(i)] = found->get<double>();
      any = true;
    }
    return any ? std::optional(frame) : std::nullopt;
  }

  [[noreturn]] void refuse_silence() {
    if (const auto refusal = subscriber_.refusal(); !refusal.empty()) throw UserError(endpoint_, refusal, kCurveRemedy);
    throw UserError(endpoint_,
                    fmt::format("no AU frames{} for {} s", stream_.empty() ? "" : " of " + stream_, silence_s_),
                    "start risoriusd and its tracker, or give its [output] publish address with --connect and the "
                    "source's name with --stream");
  }

  std::string endpoint_, stream_;
  double silence_s_;
  DaemonSubscriber subscriber_;
  std::vector<std::string> aus_;
  std::int64_t begin_ns_ = 0;
};

std::vector<PromptedPose> poses_of(const RomLiveArguments& arguments, const AuStream& stream) {
  std::vector<PromptedPose> all = prompted_poses(stream.aus()), chosen;
  if (arguments.only.empty()) return all;
  std::vector<std::string> names;
  for (const PromptedPose& pose : all) names.push_back(pose.name);
  for (const std::string& name : arguments.only) {
    const auto found = std::ranges::find(all, name, &PromptedPose::name);
    if (found == all.end()) {
      throw UserError("--pose " + name, fmt::format("stream {} has no such pose", stream.name()),
                      fmt::format("choose of {}", fmt::join(names, " ")));
    }
    chosen.push_back(*found);
  }
  return chosen;
}

/// How high the pose's AUs are now; on a terminal only.
void draw_bars(const AuStream& stream, const PromptedPose& pose, const PoseFrame& frame) {
  fmt::print("\r    ");
  for (const std::size_t au : pose.aus) {
    const double x = frame.x[static_cast<Eigen::Index>(au)];
    const auto filled = static_cast<std::size_t>(std::clamp(x / 1.2, 0.0, 1.0) * kBarWidth + 0.5);
    fmt::print("{:<6}{}{} {:4.2f}  ", stream.aus()[au], std::string(filled, '#'), std::string(kBarWidth - filled, '.'),
               x);
  }
  std::fflush(stdout);
}

PoseWatch watch_pose(AuStream& stream, const PromptedPose& pose, double seconds) {
  PoseWatch watch(stream.aus(), pose, {.longest_s = seconds});
  const bool is_terminal = isatty(STDOUT_FILENO) == 1;
  std::int64_t drawn_ns = 0;
  stream.follow([&](PoseFrame& frame) {
    if (is_terminal && monotonic_now_ns() - drawn_ns > 50'000'000) {
      draw_bars(stream, pose, frame);
      drawn_ns = monotonic_now_ns();
    }
    return watch.add(std::move(frame)) == PoseWatch::State::kWaiting;
  });
  if (is_terminal) fmt::print("\r\x1b[K");
  return watch;
}

void append_row(std::string& text, const AuStream& stream, const PromptedPose& pose, const PoseWatch& watch,
                const PoseCheck& check) {
  append_text(text, pose.name);
  text += ',';
  append_text(text, check.au);
  text += ',';
  append_number(text, check.peak);
  const double begin_s = watch.frames().front().time_s, end_s = watch.frames().back().time_s;
  for (const double time_s : {check.peak_s, begin_s, end_s}) {
    text += fmt::format(",{}", stream.capture_time_ns(time_s));
  }
  text += ',';
  if (!std::isnan(check.other_side_peak)) append_number(text, check.other_side_peak);
  text += ',';
  append_text(text, check.company);
  text += ',';
  append_number(text, check.company_intensity);
  text += ',';
  append_text(text, verdict_of(check));
  text += '\n';
}

}  // namespace

void RomLiveArguments::add_to(CLI::App& command) {
  command.add_option("--connect", endpoint, "live: the publish address of a running risoriusd, tcp://127.0.0.1:7001");
  command.add_option("--stream", stream, "live: the source's name; without it the first that is heard");
  command.add_option("--pose", only, "live: only these, such as AU12 AU4");
  command.add_option("--seconds", seconds, "live: for each pose, until it counts as not seen")
      ->check(number_between(1, 600))
      ->capture_default_str();
  command.add_option("--tries", tries, "live: how often a pose is asked for")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command.add_option("-o,--output", output, "live: a table (CSV) of what was seen, with capture times");
  curve.add_to(command);
}

void print_pose_head() {
  fmt::print("{:<8} {:>5} {:>9} {:>11}  {:<16} {}\n", "AU", "peak", "at", "other side", "with", "");
}

void print_pose(const PoseCheck& pose) {
  fmt::print("{:<8} {:>5.2f} {:>7.2f} s {:>11}  {:<16} {}\n", pose.au, pose.peak, pose.peak_s,
             std::isnan(pose.other_side_peak) ? "-" : fmt::format("{:.2f}", pose.other_side_peak),
             pose.company.empty() ? "" : fmt::format("{} {:.2f}", pose.company, pose.company_intensity),
             verdict_of(pose));
}

void prompt_live(const RomLiveArguments& arguments) {
  if (!arguments.output.empty()) check_output_name(arguments.output, "a table of poses", {".csv"});
  std::signal(SIGINT, [](int) { interrupted = 1; });
  AuStream stream(arguments);
  stream.follow([](const PoseFrame&) { return false; });
  if (interrupted != 0) return;
  const std::vector<PromptedPose> poses = poses_of(arguments, stream);
  fmt::print("{}: {} poses. From rest to as far as it goes, hold a second, back to rest; each on its own.\n",
             stream.name(), poses.size());
  print_pose_head();
  std::string table =
      "pose,au,peak,peak_capture_time_ns,from_capture_time_ns,to_capture_time_ns,other_side_peak,with,with_intensity,"
      "verdict\n";
  std::size_t seen = 0, asked = 0, number = 0;
  for (const PromptedPose& pose : poses) {
    ++number;
    for (int attempt = 1; attempt <= arguments.tries && interrupted == 0; ++attempt) {
      fmt::print("{}/{} {} {}{}{}\n", number, poses.size(), pose.name, facs_name(pose.name),
                 pose.aus.size() > 1 ? ", both sides" : "", attempt > 1 ? ", again" : "");
      std::fflush(stdout);
      const PoseWatch watch = watch_pose(stream, pose, arguments.seconds);
      const std::vector<PoseCheck> checks = watch.checks();
      if (interrupted != 0 || checks.empty()) break;
      for (const PoseCheck& check : checks) {
        print_pose(check);
        append_row(table, stream, pose, watch, check);
      }
      const auto is_fine = [](const PoseCheck& check) { return check.is_seen && !check.is_lopsided; };
      const bool fine = std::ranges::all_of(checks, is_fine);
      if (!fine && attempt < arguments.tries) continue;
      asked += checks.size();
      seen += static_cast<std::size_t>(std::ranges::count_if(checks, &PoseCheck::is_seen));
      break;
    }
  }
  fmt::print("{} of {} AUs seen{}\n", seen, asked, interrupted != 0 ? "; interrupted" : "");
  if (arguments.output.empty()) return;
  AtomicFile file(arguments.output);
  file.write(table);
  file.commit();
  fmt::print("written: {}\n", arguments.output);
}

}  // namespace risorius
