// risorius-train seed: seed 003's network on a data set put together like its own: 17 performed pairs of expressions, 5
// variants, each "recorded" three times with lost frames, merged and filled by three kinds of interpolation.
#include <array>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>

#include "generate/seed_network.h"
#include "generate/train/commands.h"
#include "generate/train/seed_module.h"
#include "generate/train/training_command.h"
#include "replay/corpus/expression_corpus.h"
#include "replay/corpus/recording_merge.h"
#include "replay/corpus/study_composition.h"
#include "replay/performer/random.h"

namespace risorius {
namespace {

constexpr double kLostFrames = 0.3;  ///< of each of three recordings; then mostly no two in a row are lost in all
constexpr int kRecordings = 3;
constexpr std::array kInterpolations{MergeDegree::kLinear, MergeDegree::kQuadratic, MergeDegree::kCubic};
constexpr double kEndWeight = 5;  ///< of the cure "weighted start and end"
constexpr std::int64_t kEndFrames = 10;

/// Every so many frames are shown during a part of the training, which begins at `share` of it. A quarter of the frames
/// is a quarter of the time a step takes, and what start and target mean for a face is the same at any rate; the last
/// part is at the rate that the network runs at.
struct Pace {
  double share = 0;
  Eigen::Index every = 1;
};
constexpr std::array<Pace, 3> kPaces{{{0, 4}, {0.6, 2}, {0.8, 1}}};

struct SeedArguments : TrainingArguments {
  std::string cure = "none", study;  ///< a letter; empty: none of the study's models
  std::int64_t batch = 8;
};

/// One performance as three leaky recordings, merged.
Transition merged(const Transition& one, const std::vector<std::string>& names, MergeDegree degree,
                  std::uint64_t seed) {
  AuMatrix rows(one.past.rows() + one.course.rows(), one.course.cols());
  rows << one.past, one.course;
  Random random(seed, 31);
  std::vector<AuSeries> recordings(kRecordings);
  for (AuSeries& recording : recordings) {
    recording.names = names;
    for (Eigen::Index f = 0; f < rows.rows(); ++f) {
      const bool is_end = f == 0 || f + 1 == rows.rows();
      if (!is_end && random.chance(kLostFrames)) continue;
      recording.frames.push_back(static_cast<std::uint64_t>(f));
      recording.intensities.emplace_back(rows.row(f).begin(), rows.row(f).end());
    }
  }
  const MergedSeries series = merge_recordings(recordings, degree);
  Transition result = one;
  for (Eigen::Index f = 0; f < rows.rows(); ++f) {
    for (Eigen::Index k = 0; k < rows.cols(); ++k) {
      const auto value =
          static_cast<float>(series.series.intensities[static_cast<std::size_t>(f)][static_cast<std::size_t>(k)]);
      (f < one.past.rows() ? result.past(f, k) : result.course(f - one.past.rows(), k)) = value;
    }
  }
  return result;
}

/// Every so many rows, the last one among them.
AuMatrix thinned(const AuMatrix& rows, Eigen::Index every) {
  const Eigen::Index count = (rows.rows() + every - 1) / every;
  AuMatrix result(count, rows.cols());
  for (Eigen::Index back = 0; back < count; ++back)
    result.row(count - 1 - back) = rows.row(rows.rows() - 1 - back * every);
  return result;
}

/// Sequences of different lengths, padded with their last frame.
struct Sequences {
  torch::Tensor past, target, course, frames;  ///< S x past x A, S x A, S x longest x A, S
};

Sequences sequences_of(const std::vector<Transition>& transitions, Eigen::Index every) {
  const auto count = static_cast<std::int64_t>(transitions.size());
  std::int64_t longest = 0, width = transitions.front().course.cols();
  for (const Transition& one : transitions) longest = std::max<std::int64_t>(longest, one.course.rows());
  Sequences s{torch::zeros({count, (kSeedPastFrames + every - 1) / every, width}), torch::zeros({count, width}),
              torch::zeros({count, (longest + every - 1) / every, width}), torch::zeros({count}, torch::kInt64)};
  longest = s.course.size(1);
  for (std::int64_t i = 0; i < count; ++i) {
    const Transition& one = transitions[static_cast<std::size_t>(i)];
    const auto tensor_of = [&](const AuMatrix& all) {
      const AuMatrix rows = thinned(all, every);
      return torch::from_blob(const_cast<float*>(rows.data()), {rows.rows(), rows.cols()}).clone();
    };
    s.past[i] = tensor_of(one.past);
    const torch::Tensor course = tensor_of(one.course);
    s.course[i] = course[-1].unsqueeze(0).expand({longest, width});
    s.course[i].slice(0, 0, course.size(0)) = course;
    s.target[i] = course[-1];
    s.frames[i] = course.size(0);
  }
  return s;
}

/// Equation (5.7) over a batch: the mean over each sequence's own frames and AUs. `end_weight`: of the first and last
/// frames.
torch::Tensor sequence_loss(SeedModule& network, const Sequences& all, const torch::Tensor& chosen, double end_weight) {
  const auto pick = [&](const torch::Tensor& t) { return t.index_select(0, chosen); };
  const torch::Tensor frames = pick(all.frames);
  const auto longest = frames.max().item<std::int64_t>();
  const torch::Tensor made = network->forward(pick(all.past), pick(all.target), longest);
  const torch::Tensor place = torch::arange(longest).unsqueeze(0), left = frames.unsqueeze(1) - place;
  torch::Tensor weight = (left > 0).to(torch::kFloat32);
  const torch::Tensor at_end = torch::logical_or(place < kEndFrames, left <= kEndFrames).to(torch::kFloat32);
  weight = weight * (1 + (end_weight - 1) * at_end);
  const torch::Tensor error = (made - pick(all.course).slice(1, 0, longest)).square().mean(2);
  return ((error * weight).sum(1) / weight.sum(1)).mean();
}

std::string trained_on(const std::string& study) {
  return "synthetic performer of Risorius: " + (study.empty() ? "the 17 pairs of seed 003's Table 4.2"
                                                              : "data of model " + study + " of seed 003's Table 5.3");
}

void train_seed(SeedArguments arguments) {
  begin_training(arguments.training);
  const TransitionCorpus corpus =
      arguments.study.empty()
          ? only_pairs(perform_expressions(corpus_aus(), {arguments.training.seed, 5}), seed003_pairs())
          : study_corpus(corpus_aus(), arguments.study.front(), arguments.training.seed);
  std::vector<Transition> training, test;
  std::uint64_t sibling = 0;
  for (const Transition& one : corpus.transitions) {
    for (const MergeDegree degree : kInterpolations) {
      auto& part = one.part == CorpusPart::kTrain ? training : test;
      part.push_back(merged(one, corpus.names, degree, arguments.training.seed * 1000 + sibling++));
    }
  }
  std::vector<Sequences> sequences;
  for (const Pace& pace : kPaces) sequences.push_back(sequences_of(training, pace.every));
  const Sequences held = sequences_of(test, 1);
  const auto aus = static_cast<std::int64_t>(corpus.names.size());
  SeedModule network(aus, SeedModuleOptions{arguments.cure == "initialiser", arguments.cure == "deep_decoder"});
  const double end_weight = arguments.cure == "weighted" ? kEndWeight : 1;
  const auto measure = [&] {
    const torch::Tensor all = torch::arange(held.frames.size(0));
    return Measurements{{"MSE of unseen variants", sequence_loss(network, held, all, 1).item<double>()}};
  };
  arguments.training.name = arguments.cure == "none" ? "seed" : "seed_" + arguments.cure;
  if (!arguments.study.empty()) arguments.training.name += "_study_" + arguments.study;
  fmt::print("{}: {} transitions to learn from, {} after three interpolations of each\n", arguments.training.name,
             training.size() / kInterpolations.size(), training.size());
  arguments.training.folder = arguments.out;
  arguments.training.what = fmt::format("batch {}", arguments.batch);
  train(
      *network, arguments.training,
      [&](std::int64_t step) {
        const double share = static_cast<double>(step) / static_cast<double>(arguments.training.steps);
        std::size_t pace = 0;
        while (pace + 1 < kPaces.size() && kPaces[pace + 1].share <= share) ++pace;
        const torch::Tensor chosen =
            torch::randperm(static_cast<std::int64_t>(training.size())).slice(0, 0, arguments.batch);
        return sequence_loss(network, sequences[pace], chosen, end_weight);
      },
      measure);
  finish_training(*network, arguments.training, measure,
                  {{"trained_on", trained_on(arguments.study)},
                   {"channels", fmt::format("{}", fmt::join(corpus.names, ","))},
                   {"rate_hz", fmt::format("{}", corpus.rate_hz)},
                   {"configuration", fmt::format("cure {}, seed {}, {} steps of {}", arguments.cure,
                                                 arguments.training.seed, arguments.training.steps, arguments.batch)}});
}

}  // namespace

void add_seed_command(CLI::App& app) {
  auto arguments = std::make_shared<SeedArguments>();
  arguments->training.steps = 500;
  arguments->training.learning_rate = 4e-3;
  arguments->training.weight_decay = 0;
  arguments->training.measure_every = 100;
  CLI::App* command = app.add_subcommand("seed", "train seed 003's own network, or one of its cures");
  command->add_option("--cure", arguments->cure, "none, initialiser, weighted or deep_decoder")
      ->check(CLI::IsMember({"none", "initialiser", "weighted", "deep_decoder"}));
  command->add_option("--study", arguments->study, "a to i: on the data of that model of seed 003's study")
      ->check(CLI::IsMember({"a", "b", "c", "d", "e", "f", "g", "h", "i"}));
  add_training_options(*command, *arguments);
  command->add_option("--batch", arguments->batch, "sequences per step")->check(CLI::Range(1, 85));
  command->callback([arguments] { train_seed(*arguments); });
}

}  // namespace risorius
