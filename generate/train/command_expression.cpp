// risorius-train expression-generator: the default model's weights.
#include <fmt/format.h>
#include <memory>

#include "generate/train/commands.h"
#include "generate/train/expression_network.h"
#include "generate/train/training_command.h"
#include "generate/train/training_corpus.h"
#include "generate/transition_features.h"
#include "replay/corpus/augmentation.h"

namespace risorius {
namespace {

constexpr std::size_t kPool = 4000;
constexpr std::int64_t kBatch = 16, kDraws = 2;
constexpr int kIdleShare = 5;
constexpr double kVarietyWeight = 0.2, kDurationWeight = 0.02;
constexpr double kLeastPower = 1e-3;  ///< added to both; an AU at rest has no rhythm

struct ExpressionArguments : TrainingArguments {
  double recorded_share = 0.5;
  ExpressionNetworkOptions network;
};

/// Mean over the course, summed over AUs: one number per transition.
torch::Tensor errors(const torch::Tensor& curve, const TransitionTensors& data) {
  return torch::zeros({data.transitions})
      .index_add(0, data.owner, (curve - data.course).square().mean(1) * data.weight);
}

/// Per row, how far the normalised power spectrum has to be carried (replay/evaluation/npss.h), as a share of its
/// width.
torch::Tensor carried_power(const torch::Tensor& curve, const torch::Tensor& truth) {
  const auto cumulated = [](const torch::Tensor& x) {
    const torch::Tensor power = torch::abs(torch::fft::fft(x)).square();
    return (power / (power.sum(1, true) + kLeastPower * static_cast<double>(x.size(1)))).cumsum(1);
  };
  return (cumulated(curve) - cumulated(truth)).abs().mean(1);
}

/// As the bench's NPSS: weighed by power and length.
double npss_of(const torch::Tensor& curve, const TransitionTensors& data) {
  const torch::Tensor length = data.seconds.square(), weight = length * data.course.square().mean(1);
  return ((carried_power(curve, data.course) * data.seconds * weight).sum() / weight.sum()).item<double>();
}

/// The expected course is the nearest on average; of several draws of the noise, one shall be near (Gupta et al. 2018,
/// their variety loss).
torch::Tensor member_loss(ExpressionMember& member, const TransitionTensors& batch, const torch::Tensor& basis) {
  const auto error = [&](const torch::Tensor& noise) {
    return errors(courses_of(batch, member->forward(batch, noise), basis), batch);
  };
  const torch::Tensor none = torch::zeros({batch.transitions, kTransitionNoise});
  const torch::Tensor expected = error(none).mean();
  std::vector<torch::Tensor> drawn;
  for (std::int64_t i = 0; i < kDraws; ++i) drawn.push_back(error(torch::randn_like(none)));
  return expected + kVarietyWeight * std::get<0>(torch::stack(drawn).min(0)).mean();
}

/// Each member has its own batch. The mean over members, so that figures of different numbers of them compare.
torch::Tensor step_loss(ExpressionNetwork& network, const TransitionTensors& data, const torch::Tensor& basis) {
  torch::Tensor loss = torch::zeros({});
  for (ExpressionMember& member : network->members) {
    const TransitionTensors batch =
        data.of(std::get<0>(torch::_unique2(torch::randint(data.transitions, {kBatch}, torch::kInt64))));
    const torch::Tensor duration = network->expected_log_seconds(batch.whole) - batch.log_seconds;
    loss = loss + member_loss(member, batch, basis) + kDurationWeight * duration.abs().mean();
  }
  return loss / static_cast<double>(network->members.size());
}

/// Of the validation's transitions (the test's are left to the bench), with the error of the better of straight line
/// and minimum jerk.
struct HeldOut {
  std::string name;
  TransitionTensors data;
  double interpolation = 0, interpolation_npss = 0;
};

HeldOut held_out(std::string name, const std::vector<std::string>& names,
                 const std::vector<const Transition*>& chosen) {
  HeldOut result{std::move(name), transition_tensors(names, chosen, kCorpusRateHz), 0, 0};
  const torch::Tensor u = torch::arange(1, kCourseSamples + 1) / static_cast<double>(kCourseSamples);
  const torch::Tensor from = result.data.fixed.select(1, 2).unsqueeze(1),
                      to = result.data.fixed.select(1, 3).unsqueeze(1);
  const torch::Tensor linear = from + u * (to - from),
                      smooth = from + u * u * u * (10 + u * (6 * u - 15)) * (to - from);
  const auto error = [&](const torch::Tensor& curve) { return errors(curve, result.data).mean().item<double>(); };
  result.interpolation = std::min(error(linear), error(smooth));
  result.interpolation_npss = std::min(npss_of(linear, result.data), npss_of(smooth, result.data));
  return result;
}

/// The validation's, from the third of their way on.
std::vector<Transition> begun_under_way(const TrainingCorpora& corpora) {
  std::vector<Transition> begun;
  for (const TransitionCorpus* corpus : {&corpora.recorded, &corpora.expressions, &corpora.motions}) {
    for (const Transition* one : part_of(*corpus, CorpusPart::kValidation))
      begun.push_back(under_way(*one, one->course.rows() / 3));
  }
  return begun;
}

void train_expression_generator(ExpressionArguments arguments) {
  begin_training(arguments.training);
  const std::optional<std::filesystem::path> recording = arguments.recording_path();
  const TrainingCorpora corpora = make_training_corpora(recording, arguments.training.seed);
  const std::vector<Transition> pool =
      make_training_pool(corpora, kPool, arguments.recorded_share, arguments.training.seed);
  std::vector<const Transition*> pointers;
  for (const Transition& one : pool) pointers.push_back(&one);
  const TransitionTensors data = transition_tensors(corpora.names, pointers, kCorpusRateHz, kIdleShare);
  std::vector<HeldOut> held;
  if (recording) {
    held.push_back(held_out("recorded", corpora.names, part_of(corpora.recorded, CorpusPart::kValidation)));
  }
  held.push_back(held_out("expressions", corpora.names, part_of(corpora.expressions, CorpusPart::kValidation)));
  held.push_back(held_out("motions", corpora.names, part_of(corpora.motions, CorpusPart::kValidation)));

  const std::vector<Transition> begun = begun_under_way(corpora);
  std::vector<const Transition*> begun_pointers;
  for (const Transition& one : begun) begun_pointers.push_back(&one);
  held.push_back(held_out("under way", corpora.names, begun_pointers));

  ExpressionNetwork network(arguments.network);
  const torch::Tensor basis = residual_basis();
  const auto measure = [&] {
    Measurements measured;
    for (const HeldOut& one : held) {
      const torch::Tensor curve =
          courses_of(one.data, network->forward(one.data), basis).clamp(0, kMostTransitionIntensity);
      measured.emplace_back(one.name + ": MSE to the better interpolation's",
                            errors(curve, one.data).mean().item<double>() / one.interpolation);
      measured.emplace_back(one.name + ": NPSS to the better interpolation's",
                            npss_of(curve, one.data) / one.interpolation_npss);
    }
    return measured;
  };
  arguments.training.name = "expression_generator";
  arguments.training.folder = arguments.out;
  arguments.training.what = fmt::format("{} members, decoder {}, recorded share {}, {}", arguments.network.members,
                                        arguments.network.decoder_units, arguments.recorded_share, arguments.recording);
  train(
      *network, arguments.training, [&](std::int64_t) { return step_loss(network, data, basis); }, measure);
  finish_training(
      *network, arguments.training, measure,
      {{"trained_on", recording ? kTrainingCredit : "synthetic performer of Risorius"},
       {"channels", "any: weights are shared by all AUs"},
       {"rate_hz", "any: the course is a spline over the way"},
       {"configuration", fmt::format("{} members, encoder {}, decoder {}, seed {}, {} steps", arguments.network.members,
                                     arguments.network.encoder_units, arguments.network.decoder_units,
                                     arguments.training.seed, arguments.training.steps)}});
}

}  // namespace

void add_expression_command(CLI::App& app) {
  auto arguments = std::make_shared<ExpressionArguments>();
  arguments->training.steps = 1000;
  arguments->training.learning_rate = 3e-3;
  CLI::App* command = app.add_subcommand("expression-generator", "train the default Expression-Generator");
  add_recording_option(*command, *arguments);
  add_training_options(*command, *arguments);
  command->add_option("--recorded-share", arguments->recorded_share, "of the pool")->check(CLI::Range(0.0, 1.0));
  command->add_option("--members", arguments->network.members, "networks whose mean is the expected course")
      ->check(CLI::Range(1, 64));
  command->add_option("--units", arguments->network.decoder_units, "of the decoder")->check(CLI::Range(1, 1024));
  command->callback([arguments] { train_expression_generator(*arguments); });
}

}  // namespace risorius
