// risorius study: a page for a blind comparison of transitions, drawn on the face; and what its answers say.
#include "replay/commands/command_study.h"

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <set>

#include "capture/errors.h"
#include "generate/safetensors.h"
#include "generate/transition_models.h"
#include "replay/atomic_file.h"
#include "replay/commands/number_check.h"
#include "replay/commands/output_check.h"
#include "replay/study/study.h"
#include "replay/study/study_page.h"
#include "replay/study/study_picture.h"
#include "replay/study/study_score.h"
#include "solve/faces/builtin_face.h"

namespace risorius {
namespace {

struct StudyArguments {
  std::vector<std::string> series, answers;
  std::string output, seed_weights, consent;
  std::uint64_t pairs = 40, seed = 1;
  double rate_hz = 0;  // 0: as the file says
  bool own_lids = false;
};

void make_page(const StudyArguments& arguments) {
  if (arguments.series.empty())
    throw UserError("study", "no AU series is given", "name at least one, or score answers with --score");
  if (arguments.output.empty()) throw UserError("study", "there is no output", "name the page with -o PAGE.html");
  std::vector<std::filesystem::path> inputs(arguments.series.begin(), arguments.series.end());
  inputs.emplace_back(arguments.seed_weights);
  check_outputs(inputs, {arguments.output});
  check_output_name(arguments.output, "a page", {".html", ".htm"});
  StudyOptions options{.pairs = arguments.pairs, .seed = arguments.seed, .own_lids = arguments.own_lids};
  std::optional<Safetensors> weights;
  if (!arguments.seed_weights.empty()) {
    weights = load_safetensors(arguments.seed_weights);
    options.seed_weights = &*weights;
    options.seed_weights_place = arguments.seed_weights;
  }
  std::vector<AuRecording> recordings;
  std::set<std::string> takes;
  const std::optional<double> rate_hz = arguments.rate_hz > 0 ? std::optional(arguments.rate_hz) : std::nullopt;
  for (const std::string& path : arguments.series) {
    recordings.push_back(load_au_recording(path, rate_hz));
    for (const std::string& warning : recordings.back().warnings) fmt::print("warning: {}: {}\n", path, warning);
    if (!takes.insert(recordings.back().take).second)
      throw UserError(path, "is the second take named " + recordings.back().take, "give each take once");
  }
  const FaceModel face = builtin_face();
  const Study study = make_study(recordings, face, options);
  for (const std::string& note : study.notes) fmt::print("note: {}\n", note);
  const std::string page = study_page(study, face, arguments.consent);
  AtomicFile file(arguments.output);
  file.write(page);
  file.commit();
  fmt::print("written: {}, {} pairs out of {} transitions, {:.1f} MB; open it in a browser\n", arguments.output,
             study.trials.size(), study.transitions.size(), static_cast<double>(page.size()) * 1e-6);
}

void score(const StudyArguments& arguments) {
  if (!arguments.series.empty())
    throw UserError(arguments.series.front(), "is an AU series beside --score",
                    "name the answers behind --score, and make pages without it");
  const std::vector<std::filesystem::path> files(arguments.answers.begin(), arguments.answers.end());
  if (!arguments.output.empty()) check_output_name(arguments.output, "a figure", {".png"});
  check_outputs(files, {arguments.output});
  const std::vector<StudyAnswer> answers = load_study_answers(files);
  const std::vector<ComparisonScore> scores = score_study(answers);
  std::set<std::string> participants;
  for (const StudyAnswer& answer : answers) participants.insert(answer.participant);
  fmt::print("{} answers of {} participant{}\n\n", answers.size(), participants.size(),
             participants.size() == 1 ? "" : "s");
  fmt::print("{:<24}{:<24}{:>7}{:>8}{:>6}{:>9}{:>17}{:>10}{:>8}{:>14}\n", "first", "second", "first", "second", "same",
             "first %", "95 % interval", "p", "people", "p of people");
  for (const ComparisonScore& s : scores) {
    fmt::print("{:<24}{:<24}{:>7}{:>8}{:>6}{:>9}{:>17}{:>10.3g}{:>8}{:>14.3g}\n", s.first, s.second, s.first_preferred,
               s.second_preferred, s.ties, std::isnan(s.share) ? "-" : fmt::format("{:.1f}", 100 * s.share),
               fmt::format("{:.1f} to {:.1f}", 100 * s.low, 100 * s.high), s.p, s.participants, s.participants_p);
  }
  fmt::print(
      "\nfirst %: of the answers that prefer one; Wilson's interval; p: two-sided sign test over answers, and over "
      "people\n");
  if (arguments.output.empty()) return;
  study_picture(scores).save_png(arguments.output);
  fmt::print("written: {}\n", arguments.output);
}

}  // namespace

void add_study_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "study", "a page for a blind comparison of real and generated transitions, and the scores of its answers");
  auto arguments = std::make_shared<StudyArguments>();
  command->add_option("series", arguments->series,
                      "Live Link Face CSV or AU CSV, best of people whom no model was trained on");
  command->add_option("--pairs", arguments->pairs, "that each participant sees")
      ->check(whole_number())
      ->capture_default_str();
  command->add_option("--seed", arguments->seed, "of the draw of transitions, sides and order")
      ->check(whole_number())
      ->capture_default_str();
  command->add_option("--seed-weights", arguments->seed_weights,
                      "of seed 003's generator (./run train seed): it takes part, too");
  command->add_flag(
      "--own-lids", arguments->own_lids,
      "generators move the lids, too (default: as recorded in every clip; a blink would tell the real one)");
  command->add_option("--rate", arguments->rate_hz, "of AU CSVs, frames per second")->check(number_between(1, 2000));
  command->add_option("--consent", arguments->consent,
                      "the line that participants agree to, instead of the page's own");
  command->add_option("--score", arguments->answers,
                      "files of answers: print the scores, draw them with -o FIGURE.png");
  command->add_option("-o,--output", arguments->output, "page (.html), or figure (.png)");
  command->callback([arguments] { arguments->answers.empty() ? make_page(*arguments) : score(*arguments); });
}

}  // namespace risorius
