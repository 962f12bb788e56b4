#include "replay/commands/rom_live.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>
#include <optional>
#include <unistd.h>

#include "capture/errors.h"
#include "capture/frames.h"
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
constexpr const char* kTopic = "au";
constexpr double kNotObserved = std::numeric_limits<double>::quiet_NaN();

/// AU frames of one stream of a running daemon, as poses see them.
class AuStream {
 public:
  explicit AuStream(const RomLiveArguments& arguments)
      : endpoint_(arguments.endpoint),
        stream_(arguments.stream),
        silence_s_(arguments.seconds),
        subscriber_(endpoint_, arguments.curve.client(), kTopic) {}

  /// Hands frames with a face to `sink` until it returns false, or an interrupt. Throws UserError where none comes for
  /// as long as a pose may take.
  template <typename Sink>
  void follow(const Sink& sink) {
    bool goes_on = true;
    std::int64_t used_ns = monotonic_now_ns();
    others_ = malformed_ = 0;
    while (goes_on && interrupted == 0) {
      subscriber_.receive_for(kWait, [&](const std::string& topic, const nlohmann::json& message) {
        if (!goes_on || topic != kTopic) return;
        auto frame = try_read(message);
        if (!frame) return;
        used_ns = monotonic_now_ns();
        goes_on = sink(*frame);
      });
      if (goes_on && static_cast<double>(monotonic_now_ns() - used_ns) > 1e9 * silence_s_) refuse_silence();
    }
  }

  const std::vector<std::string>& aus() const noexcept { return aus_; }
  const std::string& name() const noexcept { return stream_; }
  /// The capture time that a frame's time stands for.
  std::int64_t capture_time_ns(double time_s) const noexcept {
    return begin_ns_ + static_cast<std::int64_t>(std::llround(time_s * 1e9));
  }

 private:
  /// Nothing for other streams, predicted frames, frames without a face, and what is no AU message at all.
  std::optional<PoseFrame> try_read(const nlohmann::json& message) {
    try {
      const auto stream = message.at("stream").get<std::string>();
      if (!stream_.empty() && stream != stream_) return std::nullopt;
      if (message.at("kind").get<std::string>() == "predicted") return std::nullopt;
      const nlohmann::json &values = message.at("au"), &time = message.at("capture_time_ns");
      if (!values.is_object() || !time.is_number_integer()) {
        ++malformed_;
        return std::nullopt;
      }
      auto frame = frame_of(values, time.get<std::int64_t>());
      if (!frame) ++others_;
      if (frame) stream_ = stream;
      return frame;
    } catch (const nlohmann::json::exception&) {
      ++malformed_;
      return std::nullopt;
    }
  }

  std::optional<PoseFrame> frame_of(const nlohmann::json& values, std::int64_t time_ns) {
    std::vector<std::string> names;
    bool any = false;
    for (const auto& [name, value] : values.items()) {
      names.push_back(name);
      any = any || (value.is_number() && std::isfinite(value.get<double>()));
    }
    if (!any) return std::nullopt;
    std::ranges::stable_sort(names, {}, [](const std::string& name) {  // JSON sorts AU10 before AU2
      const auto au = parse_au_name(name);
      return au ? std::pair(au->number, static_cast<int>(au->side)) : std::pair(100, 0);
    });
    if (aus_.empty()) {
      aus_ = names;
      begin_ns_ = time_ns;
    }
    if (names != aus_) {
      throw UserError(endpoint_,
                      fmt::format("the AUs of {} are others now ({} were, {} are)", stream_, aus_.size(), names.size()),
                      "begin again: the rig was changed");
    }
    PoseFrame frame{static_cast<double>(difference_ns(time_ns, begin_ns_)) * 1e-9,
                    Eigen::VectorXd::Constant(static_cast<Eigen::Index>(aus_.size()), kNotObserved)};
    for (std::size_t i = 0; i < aus_.size(); ++i) {
      const auto& value = values.at(aus_[i]);
      if (value.is_number() && std::isfinite(value.get<double>())) {
        frame.x[static_cast<Eigen::Index>(i)] = value.get<double>();
      }
    }
    return frame;
  }

  [[noreturn]] void refuse_silence() {
    if (const auto refusal = subscriber_.refusal(); !refusal.empty()) throw UserError(endpoint_, refusal, kCurveRemedy);
    const std::string of_stream = stream_.empty() ? "" : " of " + stream_;
    malformed_ += subscriber_.malformed();
    if (others_ > 0) {
      throw UserError(endpoint_, fmt::format("frames{} come, but none has had a face for {} s", of_stream, silence_s_),
                      "are the markers seen, and is the rig this actor's? risorius watch shows the stream's state");
    }
    throw UserError(endpoint_,
                    fmt::format("no AU frames{} for {} s{}", of_stream, silence_s_,
                                malformed_ > 0 ? fmt::format(", but {} messages that are none", malformed_) : ""),
                    "start risoriusd and its tracker, or give its [output] publish address with --connect and the "
                    "source's name with --stream");
  }

  std::string endpoint_, stream_;
  double silence_s_;
  DaemonSubscriber subscriber_;
  std::vector<std::string> aus_;
  std::int64_t begin_ns_ = 0;
  std::uint64_t others_ = 0, malformed_ = 0;  ///< messages since the last frame that was used
};

std::vector<PromptedPose> poses_of(const RomLiveArguments& arguments, const AuStream& stream) {
  std::vector<PromptedPose> all = prompted_poses(stream.aus()), chosen;
  if (arguments.only.empty()) return all;
  std::vector<std::string> names;
  for (const PromptedPose& pose : all) names.push_back(pose.name);
  for (const std::string& name : arguments.only) {
    const auto found = std::ranges::find(all, name, &PromptedPose::name);
    const auto column = std::ranges::find(stream.aus(), name);
    if (found == all.end() && column != stream.aus().end()) {  // one side alone
      chosen.push_back({name, {static_cast<std::size_t>(column - stream.aus().begin())}});
      continue;
    }
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
    const double seen = frame.x[static_cast<Eigen::Index>(au)], x = std::isfinite(seen) ? seen : 0;
    const auto filled = static_cast<std::size_t>(std::clamp(x / 1.2, 0.0, 1.0) * kBarWidth + 0.5);
    fmt::print("{:<6}{}{} {:4.2f}  ", stream.aus()[au], std::string(filled, '#'), std::string(kBarWidth - filled, '.'),
               x);
  }
  std::fflush(stdout);
}

PoseWatch watch_pose(AuStream& stream, const PromptedPose& pose, const RomLiveArguments& arguments) {
  PoseWatch watch(stream.aus(), pose, {.least_peak = arguments.least_peak, .longest_s = arguments.seconds});
  // By the clock, too: a tracker may send one capture time again and again.
  const std::int64_t end_ns = monotonic_now_ns() + static_cast<std::int64_t>(1e9 * arguments.seconds);
  const bool is_terminal = isatty(STDOUT_FILENO) == 1;
  std::int64_t drawn_ns = 0;
  stream.follow([&](PoseFrame& frame) {
    if (is_terminal && monotonic_now_ns() - drawn_ns > 50'000'000) {
      draw_bars(stream, pose, frame);
      drawn_ns = monotonic_now_ns();
    }
    return watch.add(std::move(frame)) == PoseWatch::State::kWaiting && monotonic_now_ns() < end_ns;
  });
  if (is_terminal) fmt::print("\r\x1b[K");
  return watch;
}

/// What was seen so far, on the disk after each pose: whatever ends the session, it keeps them.
class PoseTable {
 public:
  explicit PoseTable(std::string path) : path_(std::move(path)) {}

  void add(const AuStream& stream, const PromptedPose& pose, const PoseWatch& watch) {
    for (const PoseCheck& check : watch.checks()) append(stream, pose, watch, check);
    if (path_.empty()) return;
    AtomicFile file(path_);
    file.write(text_);
    file.commit();
  }

 private:
  void append(const AuStream& stream, const PromptedPose& pose, const PoseWatch& watch, const PoseCheck& check) {
    append_text(text_, pose.name);
    text_ += ',';
    append_text(text_, check.au);
    text_ += ',';
    append_number(text_, check.peak);
    const double begin_s = watch.frames().front().time_s, end_s = watch.frames().back().time_s;
    for (const double time_s : {check.peak_s, begin_s, end_s}) {
      text_ += fmt::format(",{}", stream.capture_time_ns(time_s));
    }
    text_ += ',';
    if (!std::isnan(check.other_side_peak)) append_number(text_, check.other_side_peak);
    text_ += ',';
    append_text(text_, check.company);
    text_ += ',';
    append_number(text_, check.company_intensity);
    text_ += ',';
    append_text(text_, verdict_of(check));
    text_ += '\n';
  }

  std::string path_;
  std::string text_ =
      "pose,au,peak,peak_capture_time_ns,from_capture_time_ns,to_capture_time_ns,other_side_peak,with,with_intensity,"
      "verdict\n";
};

}  // namespace

void RomLiveArguments::add_to(CLI::App& command) {
  CLI::Option* live = command.add_option("--connect", endpoint,
                                         "live: the publish address of a running risoriusd, tcp://127.0.0.1:7001");
  command.add_option("--stream", stream, "live: the source's name; without it the first that is heard")->needs(live);
  command.add_option("--pose", only, "live: only these, such as AU12 AU4L")->needs(live);
  command.add_option("--least", least_peak, "live: the intensity from which on a pose counts as seen")
      ->check(number_between(0.05, 1.2))
      ->needs(live)
      ->capture_default_str();
  command.add_option("--seconds", seconds, "live: for each pose, until it counts as not seen")
      ->check(number_between(1, 600))
      ->needs(live)
      ->capture_default_str();
  command.add_option("--tries", tries, "live: how often a pose is asked for")
      ->check(CLI::Range(1, 100))
      ->needs(live)
      ->capture_default_str();
  command.add_option("-o,--output", output, "live: a table (CSV) of what was seen, with capture times")->needs(live);
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
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { interrupted = 1; });
  AuStream stream(arguments);
  stream.follow([](const PoseFrame&) { return false; });
  if (interrupted != 0) return;
  const std::vector<PromptedPose> poses = poses_of(arguments, stream);
  fmt::print(
      "{}: {} poses. From rest to as far as it goes, hold a second, back to rest; each on its own. Seen from "
      "{:.2f} on.\nTimes (at) count from the first frame that was heard.\n",
      stream.name(), poses.size(), arguments.least_peak);
  print_pose_head();
  PoseTable table(arguments.output);
  std::size_t seen = 0, of = 0, asked = 0;
  for (const PromptedPose& pose : poses) {
    for (int attempt = 1; attempt <= arguments.tries && interrupted == 0; ++attempt) {
      fmt::print("{}/{} {} {}{}{}\n", asked + 1, poses.size(), pose.name, facs_name(pose.name),
                 pose.aus.size() > 1 ? ", both sides" : "", attempt > 1 ? ", again" : "");
      std::fflush(stdout);
      const PoseWatch watch = watch_pose(stream, pose, arguments);
      const std::vector<PoseCheck> checks = watch.checks();
      if (interrupted != 0 || checks.empty()) break;
      for (const PoseCheck& check : checks) print_pose(check);
      table.add(stream, pose, watch);
      const auto is_fine = [](const PoseCheck& check) { return check.is_seen && !check.is_lopsided; };
      const bool fine = std::ranges::all_of(checks, is_fine);
      if (!fine && attempt < arguments.tries) continue;
      ++asked;
      of += checks.size();
      seen += static_cast<std::size_t>(std::ranges::count_if(checks, &PoseCheck::is_seen));
      break;
    }
    if (interrupted != 0) break;
  }
  fmt::print(
      "{} of {} AUs seen{}\n", seen, of,
      asked < poses.size() ? fmt::format("; interrupted, {} poses were not answered", poses.size() - asked) : "");
  if (!arguments.output.empty()) fmt::print("written: {}\n", arguments.output);
}

}  // namespace risorius
