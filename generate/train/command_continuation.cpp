// risorius-train continuation: the weights of the next 50 to 500 ms.
#include <cmath>
#include <fmt/format.h>
#include <memory>

#include "generate/continuation_features.h"
#include "generate/train/commands.h"
#include "generate/train/continuation_network.h"
#include "generate/train/training_command.h"
#include "generate/train/training_corpus.h"
#include "replay/corpus/expression_corpus.h"
#include "replay/performer/au_wander.h"
#include "replay/performer/performer_script.h"

namespace risorius {
namespace {

constexpr std::int64_t kRecordedBatch = 1024, kPerformedBatch = 512;
constexpr int kRecordedPasses = 10, kPerformances = 10;
constexpr double kPerformedSeconds = 40, kMostIntensity = 1.2;
constexpr double kMostNoise = 0.02;

struct ContinuationArguments : TrainingArguments {
  std::string architecture = "mlp";
  std::int64_t units = 64;
};

AuRecording perform(const std::vector<std::string>& names, ScriptKind kind, double rate_hz, std::uint64_t seed) {
  ScriptOptions options;
  options.kind = kind;
  options.seconds = kPerformedSeconds;
  options.seed = seed;
  PerformerScript script(names, options);
  AuWander wander(names.size(), shipped_dynamics().micro_motion, shipped_dynamics().rest_drift, 1, rate_hz, seed);
  const std::vector<double> upper(names.size(), kMostIntensity);
  AuRecording recording{
      fmt::format("performer-{}", seed), {names, {}, {}}, std::vector<double>(names.size()), rate_hz, {}};
  std::vector<double> values(names.size());
  for (std::uint64_t f = 0; f < static_cast<std::uint64_t>(kPerformedSeconds * rate_hz); ++f) {
    script.intensities_at(static_cast<double>(f) / rate_hz, values);
    wander.add_to(values, upper);
    recording.series.frames.push_back(f);
    recording.series.intensities.push_back(values);
  }
  return recording;
}

/// Mostly little noise, now and then much.
double drawn_noise(Random& random) { return kMostNoise * random.uniform() * random.uniform(); }

ContinuationTensors recorded_moments(const AuRecording& recording, Random& random) {
  ContinuationDataMaker maker;
  for (int i = 0; i < kRecordedPasses; ++i) {
    // At twice the pace 30 frames per second are 60, and a range of motion comes nearer to speech.
    const double speed = i % 2 == 1 ? 2 : random.uniform(0.7, 1.3);
    maker.add(recording,
              {speed, random.uniform(0.5, 1.2), i % 3 == 0 ? 0 : drawn_noise(random), 1, static_cast<std::uint64_t>(i)},
              MomentPart::kTrain);
  }
  return maker.tensors();
}

ContinuationTensors performed_moments(const std::vector<std::string>& names, std::uint64_t seed, Random& random) {
  ContinuationDataMaker maker;
  for (int i = 0; i < kPerformances; ++i) {
    const auto one = static_cast<std::uint64_t>(i);
    maker.add(
        perform(names, i % 2 == 1 ? ScriptKind::kSpeech : ScriptKind::kMixed, i % 3 == 0 ? 30 : 60, seed * 100 + one),
        {1, random.uniform(0.5, 1.2), i % 3 == 0 ? 0 : drawn_noise(random), 1, one}, MomentPart::kAll);
  }
  return maker.tensors();
}

ContinuationTensors chosen(const ContinuationTensors& data, std::int64_t count) {
  const torch::Tensor rows = torch::randint(data.rows(), {count}, torch::kInt64);
  const auto pick = [&](const torch::Tensor& t) { return t.index_select(0, rows); };
  return {pick(data.inputs), pick(data.damped), pick(data.scale), pick(data.change), pick(data.value)};
}

/// Error at each horizon as a share of the better of hold and damped velocity, and the share within 1.645 deviations.
void measure_one(const std::string& name, ContinuationNetwork& network, const ContinuationTensors& data,
                 Measurements& measured) {
  const ContinuationPrediction predicted = predict(network, data);
  const torch::Tensor errors = (predicted.change - data.change).abs();
  const torch::Tensor held = data.change.abs().mean(0), damped = (data.damped - data.change).abs().mean(0),
                      mean = errors.mean(0),
                      within = (errors <= 1.645 * predicted.deviation).to(torch::kFloat32).mean(0);
  for (std::size_t h = 0; h < kContinuationHorizonsMs.size(); ++h) {
    const auto i = static_cast<std::int64_t>(h);
    measured.emplace_back(fmt::format("{} {} ms: error ratio", name, kContinuationHorizonsMs[h]),
                          mean[i].item<double>() / std::min(held[i].item<double>(), damped[i].item<double>()));
    measured.emplace_back(fmt::format("{} {} ms: within 90 %", name, kContinuationHorizonsMs[h]),
                          within[i].item<double>());
  }
}

void train_continuation(ContinuationArguments arguments) {
  begin_training(arguments.training);
  Random random(arguments.training.seed, 29);
  const std::vector<std::string> names = corpus_aus();
  std::vector<std::pair<std::string, ContinuationTensors>> held;
  std::optional<ContinuationTensors> recorded;
  if (const auto path = arguments.recording_path()) {
    const AuRecording recording = load_au_recording(*path);
    recorded = recorded_moments(recording, random);
    ContinuationDataMaker clean, noisy;
    clean.add(recording, {}, MomentPart::kHeldOut);
    noisy.add(recording, {1, 1, 0.01, 1, 9}, MomentPart::kHeldOut);
    held.emplace_back("recorded", clean.tensors());
    held.emplace_back("recorded, noisy", noisy.tensors());
  }
  const ContinuationTensors performed = performed_moments(names, arguments.training.seed, random);
  ContinuationDataMaker speech;
  speech.add(perform(names, ScriptKind::kSpeech, 60, 99'999), {}, MomentPart::kAll);
  held.emplace_back("performed speech", speech.tensors());

  const auto architecture =
      arguments.architecture == "lstm" ? ContinuationArchitecture::kLstm : ContinuationArchitecture::kMlp;
  ContinuationNetwork network(architecture, arguments.units);
  const auto measure = [&] {
    Measurements measured;
    for (const auto& [name, data] : held) measure_one(name, network, data, measured);
    return measured;
  };
  arguments.training.name =
      "continuation" + std::string(architecture == ContinuationArchitecture::kLstm ? "_lstm" : "");
  arguments.training.folder = arguments.out;
  arguments.training.what = fmt::format("{} units, {}", arguments.units, arguments.recording);
  train(
      *network, arguments.training,
      [&](std::int64_t) {
        torch::Tensor loss;
        if (recorded) {
          const ContinuationTensors batch = chosen(*recorded, kRecordedBatch);
          loss = continuation_loss(predict(network, batch), batch);
        }
        const ContinuationTensors batch = chosen(performed, kPerformedBatch);
        const torch::Tensor more = continuation_loss(predict(network, batch), batch);
        return recorded ? loss + 0.5 * more : more;
      },
      measure);
  finish_training(*network, arguments.training, measure,
                  {{"trained_on", recorded ? kTrainingCredit : "synthetic performer of Risorius"},
                   {"channels", "any: weights are shared by all AUs"},
                   {"rate_hz", "any up to 60"},
                   {"configuration", fmt::format("{} units, seed {}, {} steps", arguments.units,
                                                 arguments.training.seed, arguments.training.steps)}});
}

}  // namespace

void add_continuation_command(CLI::App& app) {
  auto arguments = std::make_shared<ContinuationArguments>();
  arguments->training.steps = 5000;
  arguments->training.learning_rate = 2e-3;
  arguments->training.weight_decay = 1e-3;
  arguments->training.measure_every = 1000;
  CLI::App* command = app.add_subcommand("continuation", "train the continuation network");
  add_recording_option(*command, *arguments);
  add_training_options(*command, *arguments);
  command->add_option("--architecture", arguments->architecture, "mlp, which ships, or lstm, to compare")
      ->check(CLI::IsMember({"mlp", "lstm"}));
  command->add_option("--units", arguments->units, "of the hidden layers")->check(CLI::Range(1, 1024));
  command->callback([arguments] { train_continuation(*arguments); });
}

}  // namespace risorius
