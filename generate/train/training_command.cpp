#include "generate/train/training_command.h"

#include <fmt/format.h>

#include "generate/train/export_weights.h"

namespace risorius {

std::optional<std::filesystem::path> TrainingArguments::recording_path() const {
  return recording.empty() ? std::nullopt : std::optional<std::filesystem::path>(recording);
}

void add_training_options(CLI::App& command, TrainingArguments& arguments) {
  TrainingOptions& training = arguments.training;
  command.add_option("--out", arguments.out, "folder for weights, checkpoint and figures");
  command.add_option("--steps", training.steps, "of training")->check(CLI::Range(1, 10'000'000));
  command.add_option("--seed", training.seed, "of everything drawn");
  command.add_option("--rate", training.learning_rate, "at the beginning")->check(CLI::Range(1e-6, 1.0));
  command.add_option("--decay", training.weight_decay, "of weights")->check(CLI::Range(0.0, 1.0));
}

void add_recording_option(CLI::App& command, TrainingArguments& arguments) {
  command.add_option("--recording", arguments.recording, "alex_rom_3.csv; without it, the performer alone")
      ->check(CLI::ExistingFile);
}

void begin_training(const TrainingOptions& options) {
  torch::set_num_threads(1);
  torch::manual_seed(options.seed);
}

void finish_training(torch::nn::Module& network, const TrainingOptions& options,
                     const std::function<Measurements()>& measure, std::map<std::string, std::string> metadata) {
  round_weights(network);
  network.eval();
  const torch::NoGradGuard guard;
  for (const auto& [name, value] : measure()) fmt::print("{}: {:.5g}\n", name, value);
  metadata["model"] = options.name;
  const auto path = options.folder / (options.name + ".safetensors");
  export_weights(network, std::move(metadata), path);
  fmt::print("{}\n", path.string());
}

}  // namespace risorius
