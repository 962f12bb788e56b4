// risorius-train corpus: what there is to learn from and to be measured on, as tables.
#include <fmt/format.h>
#include <map>
#include <memory>

#include "generate/train/commands.h"
#include "generate/train/training_corpus.h"
#include "replay/atomic_file.h"
#include "replay/corpus/expression_corpus.h"
#include "replay/corpus/study_composition.h"

namespace risorius {
namespace {

struct CorpusArguments {
  std::vector<std::string> recordings;
  std::string output, study;  ///< study: a letter; empty: all 30 pairs
  std::uint64_t seed = 1;
};

const char* name_of(CorpusPart part) {
  return part == CorpusPart::kTrain ? "train" : part == CorpusPart::kValidation ? "validation" : "test";
}

void print_summary(const std::string& what, const TransitionCorpus& corpus) {
  std::map<CorpusPart, std::size_t> parts;
  Eigen::Index shortest = 0, longest = 0, sum = 0;
  std::size_t direct = 0;
  for (const Transition& one : corpus.transitions) {
    ++parts[one.part];
    shortest = shortest == 0 ? one.course.rows() : std::min(shortest, one.course.rows());
    longest = std::max(longest, one.course.rows());
    sum += one.course.rows();
    if (one.stray <= 0.15F) ++direct;
  }
  const std::size_t count = corpus.transitions.size();
  fmt::print("{:<28} {:>5} transitions ({} train, {} validation, {} test), {} to {} frames, mean {:.0f}; {} direct\n",
             what, count, parts[CorpusPart::kTrain], parts[CorpusPart::kValidation], parts[CorpusPart::kTest], shortest,
             longest, count > 0 ? static_cast<double>(sum) / static_cast<double>(count) : 0.0, direct);
}

void append_rows(const TransitionCorpus& corpus, std::string& text) {
  for (const Transition& one : corpus.transitions)
    text += fmt::format("{},{},{},{},{},{},{:.3f},{},{:.4f}\n", one.take, one.from, one.to, one.variant, one.sibling,
                        name_of(one.part), one.begin_s, one.course.rows(), one.stray);
}

void make_corpus(const CorpusArguments& arguments) {
  const StillnessOptions still;
  fmt::print(
      "still: no AU but the lids' faster than {}/s over {:.0f} ms, for at least {:.0f} ms; a transition changes "
      "some AU by {} or more, in {} to {} frames at {} Hz\n",
      still.most_speed, 1e3 * still.window_s, 1e3 * still.least_still_s, still.least_change, still.least_frames,
      still.most_frames, kCorpusRateHz);
  std::string text = "take,from,to,variant,sibling,part,begin_s,frames,stray\n";
  if (arguments.study.empty()) {
    const TransitionCorpus expressions = perform_expressions(corpus_aus(), {arguments.seed, 5});
    print_summary("performed expressions", expressions);
    print_summary("of which seed 003's pairs", only_pairs(expressions, seed003_pairs()));
    append_rows(expressions, text);
  } else {
    const TransitionCorpus data = study_corpus(corpus_aus(), arguments.study.front(), arguments.seed);
    print_summary("seed 003's study, model " + arguments.study, data);
    append_rows(data, text);
  }
  for (const std::string& path : arguments.recordings) {
    const AuRecording recording = load_au_recording(path);
    for (const std::string& warning : recording.warnings) fmt::print(stderr, "{}: {}\n", path, warning);
    const TransitionCorpus corpus = cut_transitions(motion_of(recording));
    print_summary(recording.take, corpus);
    append_rows(corpus, text);
  }
  if (arguments.output.empty()) return;
  AtomicFile file(arguments.output);
  file.write(text);
  file.commit();
}

}  // namespace

void add_corpus_command(CLI::App& app) {
  auto arguments = std::make_shared<CorpusArguments>();
  CLI::App* command = app.add_subcommand("corpus", "list the transitions of recordings and of the performer");
  command->add_option("recording", arguments->recordings, "Live Link Face CSV files");
  command
      ->add_option("--study", arguments->study, "a to i: the data of that model of seed 003's study, and its held-out")
      ->check(CLI::IsMember({"a", "b", "c", "d", "e", "f", "g", "h", "i"}));
  command->add_option("--seed", arguments->seed, "of the performer");
  command->add_option("-o,--output", arguments->output, "CSV file, one line per transition");
  command->callback([arguments] { make_corpus(*arguments); });
}

}  // namespace risorius
