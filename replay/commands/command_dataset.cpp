// risorius dataset: recorded takes to a FACS-coded dataset folder. Whole takes run in parallel.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <exception>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <thread>
#include <unistd.h>
#include <vector>

#include "capture/errors.h"
#include "capture/frame_words.h"
#include "capture/version.h"
#include "replay/commands/commands.h"
#include "replay/commands/rig_argument.h"
#include "replay/commands/take_arguments.h"
#include "replay/dataset/dataset_folder.h"
#include "replay/dataset/take_dataset.h"
#include "replay/pipeline/offline_pipeline.h"
#include "replay/pipeline/rig_neutral.h"
#include "replay/pipeline/stage_config.h"
#include "replay/progress_line.h"
#include "replay/unfinished_paths.h"

namespace risorius {
namespace {

struct DatasetArguments {
  std::vector<std::string> takes;
  std::string rig, neutral, output, config, source;
  bool causal = false, joint = false, free_neutral = false;
  std::string pseudonym, consent, licence;
  TakeArguments take;
};

/// How far a marker may rest from the rig's neutral where that is free, per axis.
constexpr double kFreeNeutralMm = 1;
constexpr double kLeastForNeutral_s = 5;

/// One take on its way into the dataset.
struct TakeJob {
  std::string name;
  std::filesystem::path folder;
  std::unique_ptr<TakeDataset> dataset;
};

/// The take's stem; a second take of the same stem gets "-2" and so on, and so does one that is named like a file of
/// the dataset itself.
std::vector<TakeJob> name_jobs(const DatasetArguments& arguments) {
  std::vector<TakeJob> jobs;
  std::set<std::string> names = dataset_file_names();
  for (const auto& take : arguments.takes) {
    const std::string stem = path_of_take(take).stem().string();
    std::string name = stem;
    for (int n = 2; !names.insert(name).second; ++n) name = fmt::format("{}-{}", stem, n);
    jobs.push_back({.name = take, .folder = std::filesystem::path(arguments.output) / name});
  }
  return jobs;
}

class FrameTally {
 public:
  FrameTally(std::vector<TakeJob>& jobs, const TakeOptions& options) {
    for (const auto& job : jobs) total_ += open_take_or_builtin(job.name, options)->info().frame_count.value_or(0);
  }
  void add(std::uint64_t frames) { progress_.show(done_ += frames, total_); }
  void finish() { progress_.finish(done_); }

 private:
  std::uint64_t total_ = 0;
  std::atomic<std::uint64_t> done_{0};
  ProgressLine progress_{"dataset", "frames"};
};

const char* mode_of(const DatasetArguments& arguments) {
  return arguments.causal         ? "offline, causal"
         : arguments.free_neutral ? "offline, joint, neutral free"
         : arguments.joint        ? "offline, joint"
                                  : "offline, both directions";
}

std::string metadata_of(const DatasetArguments& arguments) {
  return nlohmann::json{{"risorius", kVersion},
                        {"instruction_set", kInstructionSet},
                        {"processing", mode_of(arguments)},
                        {"pseudonym", arguments.pseudonym},
                        {"consent", arguments.consent}}
      .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

void process(TakeJob& job, const DatasetArguments& arguments, const Rig& rig, const StageConfig& stages, int threads,
             FrameTally& tally) {
  const auto take = open_take_or_builtin(job.name, arguments.take.options());
  print_warnings(*take);
  const auto begin = [&](const Rig& rig_of_take) {
    job.dataset =
        std::make_unique<TakeDataset>(job.folder, take->info().markers, rig_of_take,
                                      TakeDatasetOptions{.source = std::filesystem::path(job.name).filename().string(),
                                                         .metadata_json = metadata_of(arguments)});
  };
  const auto sink = [&](const SolvedFrame& frame) { job.dataset->write(frame); };
  std::uint64_t reported = 0;
  const auto progress = [&](std::uint64_t done, std::uint64_t) {
    tally.add(done - reported);
    reported = done;
  };
  if (arguments.joint) {
    const JointSolve joint{.threads = threads, .neutral_mm = arguments.free_neutral ? kFreeNeutralMm : 0};
    solve_jointly(*take, stages.pipeline, rig, joint, begin, sink, progress);
  } else if (begin(rig); arguments.causal) {
    FramePipeline pipeline(stages.pipeline, rig);
    solve_causally(*take, pipeline, sink, progress);
  } else {
    solve_both_directions(*take, stages.pipeline, rig, sink, progress);
  }
  job.dataset->finish();
  progress(job.dataset->frame_count(), 0);
}

void process_in_parallel(std::vector<TakeJob>& jobs, const DatasetArguments& arguments, const Rig& rig,
                         const StageConfig& stages) {
  FrameTally tally(jobs, arguments.take.options());
  std::atomic<std::size_t> next{0};
  std::exception_ptr first_error;
  std::mutex mutex;
  const auto cores = static_cast<std::size_t>(std::max(1U, std::thread::hardware_concurrency()));
  const std::size_t count = std::min(cores, jobs.size());
  const auto work = [&] {
    for (std::size_t i = next++; i < jobs.size(); i = next++) {
      try {
        process(jobs[i], arguments, rig, stages, static_cast<int>(cores / count), tally);
      } catch (...) {
        const std::scoped_lock lock(mutex);
        if (!first_error) first_error = std::current_exception();
        next = jobs.size();
      }
    }
  };
  {
    std::vector<std::jthread> workers;
    for (std::size_t i = 0; i < count; ++i) workers.emplace_back(work);
  }
  if (first_error) std::rethrow_exception(first_error);
  tally.finish();
}

/// The AUs with the longest total time in episodes.
std::string most_active(const TakeDataset& dataset) {
  const auto names = dataset.rig().au_names();
  std::vector<std::pair<std::string, double>> seconds;
  for (const auto& name : names) seconds.emplace_back(name, 0);
  for (const auto& episode : dataset.episodes()) {
    seconds[episode.column].second += static_cast<double>(episode.offset.time_ns - episode.onset.time_ns) * 1e-9;
  }
  std::ranges::stable_sort(seconds, std::greater<>(), [](const auto& s) { return s.second; });
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(6, seconds.size()) && seconds[i].second > 0; ++i) {
    text += fmt::format("{}{} {:.1f} s", i == 0 ? "" : ", ", seconds[i].first, seconds[i].second);
  }
  return text.empty() ? "none" : text;
}

/// What a take cannot tell of its rest: it was too short for the face to come back to it, or the rig's is another face.
void doubt_free_neutral(const TakeDataset& d, const Rig& given) {
  const double moved_mm = std::sqrt((d.rig().neutral_mm - given.neutral_mm).colwise().squaredNorm().mean());
  if (moved_mm > kDoubtedShiftMm) {
    fmt::print(stderr,
               "{}: warning: the neutral found is {:.1f} mm rms from the rig's, which is more than it can mend: give "
               "the session's with --neutral\n",
               d.folder().filename().string(), moved_mm);
  }
  const double seconds = static_cast<double>(d.frame_count()) / std::max(1e-9, d.rate_hz());
  if (seconds < kLeastForNeutral_s) {
    fmt::print(
        stderr,
        "{}: warning: {:.1f} s are hardly enough to find a neutral: what is there all the time is taken for it\n",
        d.folder().filename().string(), seconds);
  }
}

void print_summary(const std::vector<TakeJob>& jobs, const Rig& given) {
  fmt::print("{:<18} {:>7} {:>7}  {:>22}  {:>9} {:>8}\n", "take", "frames", "filled", "marker energy explained",
             "residual", "max KKT");
  fmt::print("{:<18} {:>7} {:>7}  {:>11} {:>11}  {:>9}\n", "", "", "", "head only", "with AUs", "rms");
  for (const auto& job : jobs) {
    const TakeDataset& d = *job.dataset;
    fmt::print(
        "{:<18} {:>7} {:>6.2f}%  {:>10.2f}% {:>10.2f}%  {:>6.2f} mm {:>8.1e}\n", job.folder.filename().string(),
        d.frame_count(),
        100 * static_cast<double>(d.filled_count()) / static_cast<double>(std::max<std::uint64_t>(1, d.sample_count())),
        100 * d.energy().explained_by_head(), 100 * d.energy().explained_with_aus(), d.energy().residual_rms_mm(),
        d.largest_kkt_residual());
    fmt::print("  AUs explain {:.1f} % of what the head leaves; {} episodes, most time in {}\n",
               100 * d.energy().face_explained_by_aus(), d.episodes().size(), most_active(d));
    if (const std::string& source = d.rig().source; source != given.source) {
      fmt::print("  {}\n", source.substr(given.source.size() + 2));  // after "; "
      doubt_free_neutral(d, given);
    }
  }
}

/// Before anything is written: every take opens, and the rig knows its markers.
void refuse_what_cannot_be_solved(const DatasetArguments& arguments, const Rig& rig) {
  for (const auto& name : arguments.takes) {
    const auto take = open_take_or_builtin(name, arguments.take.options());
    AuSolver solver(rig);
    try {
      solver.use_marker_set(take->info().markers);
    } catch (const UserError& error) {
      throw UserError(name + ": " + error.what());
    }
    if (const auto absent = describe_absent_markers(rig, take->info().markers); !absent.empty())
      fmt::print(stderr, "{}: warning: {}; AUs that only they show are not observed\n", name, absent);
  }
}

const char* remedy_of(SolverStatus status) {
  switch (status) {
    case SolverStatus::kMirrored:
      return "turn one letter of --axes round, such as LUF for RUF";
    case SolverStatus::kPoorFit:
      return "is this the take's rig; are --units and --axes right?";
    case SolverStatus::kTooFewMarkers:
      return "fewer than 3 markers or stabilisers were seen: has the take positions? Or the stabilisers disagree: are "
             "two "
             "labels swapped?";
    default:
      return "see column solver of quality.csv";
  }
}

/// "12 poor_fit (remedy), 3 lost": why frames have no AUs; empty if all have.
std::string unsolved_reasons(const TakeDataset& dataset) {
  std::string text;
  const auto add = [&](std::uint64_t count, std::string_view word, std::string_view remedy) {
    if (count > 0) text += fmt::format("{}{} {} ({})", text.empty() ? "" : ", ", count, word, remedy);
  };
  for (const SolverStatus status : {SolverStatus::kMirrored, SolverStatus::kPoorFit, SolverStatus::kTooFewMarkers,
                                    SolverStatus::kIterationLimit, SolverStatus::kNotSolved}) {
    add(dataset.status_count(status), word_of(status), remedy_of(status));
  }
  add(dataset.lost_count(), "lost", "not in the take");
  return text;
}

/// A dataset without a single AU is a mistake, though everything is on disk to find it.
void judge_solved_frames(const std::vector<TakeJob>& jobs) {
  std::uint64_t all_solved = 0;
  std::string reasons;
  for (const auto& job : jobs) {
    const std::uint64_t frames = job.dataset->frame_count(), solved = job.dataset->solved_count();
    all_solved += solved;
    if (10 * solved >= 9 * frames) continue;
    reasons = unsolved_reasons(*job.dataset);
    fmt::print(stderr, "{}: warning: {} of {} frames have no AUs: {}\n", job.name, frames - solved, frames, reasons);
  }
  if (all_solved == 0) throw UserError("dataset", "not one frame could be solved", reasons);
}

/// A dataset that was given up before any of it was whole leaves no folder.
struct RemoveIfEmpty {
  explicit RemoveIfEmpty(std::filesystem::path path) : folder(std::move(path)) {}
  RemoveIfEmpty(const RemoveIfEmpty&) = delete;
  RemoveIfEmpty& operator=(const RemoveIfEmpty&) = delete;
  std::filesystem::path folder;
  ~RemoveIfEmpty() { ::rmdir(folder.c_str()); }
};

/// The rig, with the session's own neutral where one is given.
Rig rig_of(const DatasetArguments& arguments) {
  Rig rig = rig_of_argument(arguments.rig);
  if (arguments.neutral.empty()) return rig;
  const RenewedRig renewed = with_neutral_of_argument(rig, arguments.neutral, arguments.take.options());
  fmt::print("neutral {}: markers are {:.2f} mm rms from the rig's, most {} by {:.2f} mm\n", renewed.place,
             renewed.moved_rms_mm, renewed.moved_most_marker, renewed.moved_most_mm);
  if (const std::string doubt = doubt_of(renewed); !doubt.empty()) fmt::print(stderr, "warning: {}\n", doubt);
  return renewed.rig;
}

void make_dataset(const DatasetArguments& arguments) {
  const Rig rig = rig_of(arguments);
  refuse_what_cannot_be_solved(arguments, rig);
  const StageConfig stages =
      arguments.config.empty() ? StageConfig{} : load_stage_config(arguments.config, arguments.source);
  std::optional<RemoveIfEmpty> given_up;  // before the jobs: they take their folders along first
  std::vector<TakeJob> jobs = name_jobs(arguments);
  begin_dataset_folder(arguments.output);
  const UnfinishedPath unfinished(arguments.output);
  given_up.emplace(arguments.output);
  process_in_parallel(jobs, arguments, rig, stages);
  finish_dataset_folder(arguments.output,
                        dataset_card_markdown({.title = std::filesystem::path(arguments.output).filename().string(),
                                               .rig = rig.name,
                                               .mode = mode_of(arguments),
                                               .pseudonym = arguments.pseudonym,
                                               .consent = arguments.consent,
                                               .licence = arguments.licence,
                                               .options_toml = print_stage_config(stages)}));
  print_summary(jobs, rig);
  fmt::print("dataset: {}\n", arguments.output);
  std::fflush(stdout);
  judge_solved_frames(jobs);
}

}  // namespace

void add_dataset_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("dataset", "solve recorded takes into a FACS-coded dataset folder");
  auto arguments = std::make_shared<DatasetArguments>();
  command->add_option("takes", arguments->takes, kTakeNames)->required();
  command->add_option("--rig", arguments->rig, "rig file, actor folder, or \"builtin\"")->required();
  command->add_option("--neutral", arguments->neutral,
                      "TAKE:FROM-TO, TAKE or TAKE:auto: the neutral of this session, where markers were put on anew");
  command->add_option("-o,--output", arguments->output, "dataset folder to make")->required();
  auto* causal = command->add_flag("--causal", arguments->causal,
                                   "exactly what the live service computes; default: gaps filled from both sides");
  command
      ->add_flag("--joint", arguments->joint,
                 "all frames of a take solved at once, courses joined: smoother and nearer the truth, and slower")
      ->excludes(causal);
  command
      ->add_flag("--free-neutral", arguments->free_neutral,
                 "with --joint: the rest of each take is found with its AUs, where the rig's neutral was none")
      ->needs("--joint");
  command->add_option("--config", arguments->config, "a configuration file of risoriusd: its stage tables are used");
  command->add_option("--source", arguments->source,
                      "whose [[source]] tables of the configuration hold, if it has several");
  command->add_option("--pseudonym", arguments->pseudonym, "of the recorded person, kept with the data");
  command->add_option("--consent", arguments->consent, "reference to the person's consent, kept with the data");
  command->add_option("--licence", arguments->licence, "of the dataset, kept with the data");
  arguments->take.add_to(*command);
  command->callback([arguments] { make_dataset(*arguments); });
}

}  // namespace risorius
